// The native interior point in velocity space with CHOLMOD factoring its systems. One of two files that may include
// native code (tests/core/layers.cmake): it is that method, and stands here because CHOLMOD is linked into workers
// only.
#include "adapters/define_adapter.h"
#include "adapters/suitesparse/cholmod_factorization.h"
#include "native/velocity_ipm/settings.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <optional>

#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"
#include "native/velocity_ipm/interior_point.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kVelocityIpmCholmodCapabilities{
    .needs = Needs::kFactored,
    .frictionless_only = true,
    .guarantees = "solvable frictionless contact problems of regular inertia, redundant contacts included",
    .obeys_time_limit = true};

struct VelocityIpmCholmodSettings {
  CholmodOptions cholmod;
  InteriorPointSettings method;

  void visit(auto&& field) {
    field("factor", cholmod.factor,
          Choices<CholmodFactor>{{{"auto", CholmodFactor::kAuto},
                                  {"simplicial", CholmodFactor::kSimplicial},
                                  {"supernodal", CholmodFactor::kSupernodal}}},
          "CHOLMOD's factorization: LDL' by single columns, LL' by dense blocks of them, or its own choice");
    field("ordering", cholmod.ordering,
          Choices<CholmodOrdering>{
              {{"given", CholmodOrdering::kGiven}, {"amd", CholmodOrdering::kAmd}, {"metis", CholmodOrdering::kMetis}}},
          "order of elimination; given: the order of velocity_ipm");
    field("refinements", cholmod.refinements, IntegerRange{.min = 0, .max = 10},
          "steps of iterative refinement of each linear system");
    method.visit(field);
  }
};

class VelocityIpmCholmod;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// A regular inertia in blocks, a dense one as one block; nothing for a singular one or where only the inverse is
/// known.
std::optional<BlockInertia> in_blocks(const Inertia& inertia) {
  if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) return *blocks;
  if (std::holds_alternative<InverseInertia>(inertia)) return {};
  const auto* factors = std::get_if<FactoredInertia>(&inertia);
  if (factors != nullptr && factors->X.cols() < factors->X.rows()) return {};
  return BlockInertia{{dense_inertia(inertia)}};
}

/// InteriorPoint over CHOLMOD.
///
/// kSolved: the velocity residual, computed from z alone, is within accept_residual, and the answer passes AnswerTest.
class VelocityIpmCholmod final : public Solver {
 public:
  explicit VelocityIpmCholmod(const VelocityIpmCholmodSettings& settings)
      : settings_(settings), method_(settings.method) {}
  const Capabilities& capabilities() const override { return kVelocityIpmCholmodCapabilities; }

 private:
  void on_load(const Problem& problem) override {
    ContactProblem contact = *problem.contact();
    const std::optional<BlockInertia> blocks = in_blocks(contact.inertia);
    if (!blocks) return method_.load(nullptr, contact);
    contact.inertia = *blocks;
    method_.load(sparse_whitened_normals(contact, cholmod_factorization(settings_.cholmod)), contact);
    if (method_.loaded()) test_.load(problem, AnswerTest::Bodies::kOneByOne);
  }

  void on_update(const Vector& v) override {
    if (!method_.loaded() || !v.allFinite()) return Solver::on_update(v);
    method_.set_velocity(v);
    test_.set_velocity(v);
  }

  void on_solve(const SolveRequest& request, Answer& answer) override {
    if (!method_.loaded()) {
      answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
      answer.claim = Claim::kUnsupported;
      answer.detail = "needs a positive definite inertia, given itself";
      return;
    }
    const double deadline_s = wall_clock_s() + request.time_limit_s;
    if (method_.iterate(request, answer)) {
      if (settings_.method.finish) method_.finish(answer.counters);
      method_.conclude(answer);
    }
    test_.settle(answer, deadline_s);
  }

  VelocityIpmCholmodSettings settings_;
  InteriorPoint method_;
  AnswerTest test_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_velocity_ipm_cholmod() {
  return define_adapter<VelocityIpmCholmod, VelocityIpmCholmodSettings>(
      {.name = "velocity_ipm_cholmod",
       .summary = "velocity_ipm with CHOLMOD for its sparse systems",
       .source = "CHOLMOD: Chen, Davis, Hager, Rajamanickam 2008; the method: velocity_ipm",
       .capabilities = kVelocityIpmCholmodCapabilities});
}

}  // namespace lcpbench
