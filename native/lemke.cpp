#include "native/lemke.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <stdexcept>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace lemke {

void* allocate_aligned(std::size_t bytes) {
  constexpr std::size_t kAlignment = 64;
  void* memory = std::aligned_alloc(kAlignment, (bytes / kAlignment + 1) * kAlignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void free_aligned(void* memory) { std::free(memory); }

}  // namespace lemke

namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

const lemke::Engine& engine_at(LemkeEngine engine, IsaLevel level) {
  const bool dense = engine == LemkeEngine::kDense;
  if (level > best_isa_level()) throw std::invalid_argument("this processor lacks the instruction-set level asked for");
#if defined(__x86_64__)
  if (level == IsaLevel::kAvx512) return dense ? lemke::avx512::kDenseEngine : lemke::avx512::kKernelEngine;
  if (level == IsaLevel::kAvx2) return dense ? lemke::avx2::kDenseEngine : lemke::avx2::kKernelEngine;
#endif
  return dense ? lemke::baseline::kDenseEngine : lemke::baseline::kKernelEngine;
}

std::ptrdiff_t pivot_limit(const LemkeSettings& settings, Index n) {
  if (settings.max_pivots > 0) return static_cast<std::ptrdiff_t>(settings.max_pivots);
  if (settings.cap == LemkeCap::kLemke) return std::min<Index>(1000, 50 * n);
  return std::max<Index>(1000, n * n);
}

void append_pivot(void* pivots, std::ptrdiff_t entering, std::ptrdiff_t leaving) {
  static_cast<std::vector<LemkePivot>*>(pivots)->push_back({entering, leaving});
}

/// Sets to zero what is negative by no more than rounding; larger negatives stay, to be seen.
void clip_rounding(Vector& z) {
  const double noise = 1e-12 * z.cwiseAbs().maxCoeff();
  for (double& value : z) {
    if (value < 0 && value >= -noise) value = 0;
  }
}

void report(lemke::Ending ending, Answer& answer) {
  // Short enough for std::string to hold in place, so that solve() allocates nothing.
  switch (ending) {
    case lemke::Ending::kSolved: answer.claim = Claim::kSolved; return;
    case lemke::Ending::kRay:
      answer.claim = Claim::kUnsolvable;
      answer.detail = "ray";
      return;
    case lemke::Ending::kPivotLimit:
      answer.claim = Claim::kIterationLimit;
      answer.detail = "pivot limit";
      return;
    case lemke::Ending::kTimeLimit: answer.claim = Claim::kTimeLimit; return;
    case lemke::Ending::kBreakdown:
      answer.claim = Claim::kNumericalFailure;
      answer.detail = "singular basis";
      return;
  }
}

}  // namespace

Capabilities lemke_capabilities(const LemkeSettings& settings) {
  Capabilities capabilities;
  capabilities.needs = Needs::kDense;
  capabilities.max_size = 10000;  // room for three n x n matrices, 2.4 GB
  capabilities.guarantees = "copositive-plus M without degeneracy";
  capabilities.obeys_time_limit = true;
  // Eigen's blocked LU takes its packing buffers from the heap.
  capabilities.allocation_free = settings.engine == LemkeEngine::kKernel;
  return capabilities;
}

Lemke::Lemke(const LemkeSettings& settings, IsaLevel level)
    : settings_(settings),
      capabilities_(lemke_capabilities(settings)),
      engine_(engine_at(settings.engine, level)),
      state_(engine_.create()) {}

Lemke::~Lemke() { engine_.destroy(state_); }

void Lemke::on_load(const Problem& problem) {
  if (const ContactProblem* contact = problem.contact()) {
    load_contact(*contact);
  } else {
    load_matrix(problem.lcp());
  }
}

void Lemke::load_matrix(const Lcp& lcp) {
  lemke::Input input;
  input.n = input.dense = lcp.size();
  input.q = lcp.q.data();
  input.M = lcp.M.data();
  engine_.load(state_, input);
}

void Lemke::load_contact(const ContactProblem& contact) {
  const ContactLayout layout = contact_layout(contact);
  const Index impulses = layout.nc + layout.friction;
  RowMajorMatrix J(contact.ngc(), impulses);
  std::visit([&](const auto& N) { J.leftCols(layout.nc) = N; }, contact.N);
  std::visit([&](const auto& D) { J.rightCols(layout.friction) = D; }, contact.D);
  Vector q = Vector::Zero(layout.size());
  q.head(impulses).noalias() = J.transpose() * contact.v;
  const Matrix Ginv = inverse_inertia(contact.inertia);

  std::vector<std::ptrdiff_t> friction_begin;
  std::vector<std::ptrdiff_t> cone_normal;
  std::vector<double> mu;
  for (const Index normal : layout.cone_contact) {
    friction_begin.push_back(layout.friction_offset() + layout.friction_begin[static_cast<std::size_t>(normal)]);
    cone_normal.push_back(normal);
    mu.push_back(contact.mu(normal));
  }
  friction_begin.push_back(impulses);

  lemke::Input input;
  input.n = layout.size();
  input.dense = impulses;
  input.cones = layout.cones;
  input.q = q.data();
  input.ngc = contact.ngc();
  input.J = J.data();
  input.Ginv = Ginv.data();
  input.friction_begin = friction_begin.data();
  input.cone_normal = cone_normal.data();
  input.mu = mu.data();
  engine_.load(state_, input);
}

void Lemke::on_solve(const SolveRequest& request, Answer& answer) {
  lemke::Rules rules;
  rules.pivot_tolerance = settings_.pivot_tolerance;
  rules.zero_tolerance = settings_.zero_tolerance;
  rules.resolve = settings_.update == LemkeUpdate::kResolve;
  rules.max_pivots = pivot_limit(settings_, answer.z.size());
  rules.clock_s = wall_clock_s;
  rules.deadline_s = std::isinf(request.time_limit_s) ? request.time_limit_s : wall_clock_s() + request.time_limit_s;
  if (recorded_ != nullptr) {
    rules.on_pivot = append_pivot;
    rules.context = recorded_;
  }

  const lemke::Outcome outcome = engine_.solve(state_, rules, answer.z.data());
  report(outcome.ending, answer);
  if (answer.claim == Claim::kSolved && answer.z.size() > 0) clip_rounding(answer.z);
  answer.counters.iterations = outcome.pivots;
  answer.counters.pivots = outcome.pivots;
  answer.counters.factorizations = outcome.factorizations;
}

SolverDefinition lcpbench_solver_lemke() {
  SolverDefinition definition;
  definition.name = "lemke";
  definition.summary = "Lemke's complementary pivoting by the rules of LEMKE, basis factored afresh at each pivot";
  definition.source =
      "Lemke 1965; LEMKE of Fackler, Miranda 1997, as used by Drumwright, Shell 2012; Cottle, Pang, Stone 1992, 4.4";
  definition.capabilities = lemke_capabilities({});
  return define_solver<Lemke, LemkeSettings>(std::move(definition));
}

}  // namespace lcpbench
