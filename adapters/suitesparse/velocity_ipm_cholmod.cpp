// The native interior point in velocity space with CHOLMOD factoring its systems. The only adapter that may include
// native code (tests/core/layers.cmake): it is that method, and stands here because CHOLMOD is linked into workers
// only.
#include "adapters/define_adapter.h"
#include "native/velocity_ipm/settings.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <limits>
#include <memory>
#include <new>
#include <optional>

#include <cholmod.h>

#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"
#include "native/velocity_ipm/interior_point.h"
#endif

namespace lcpbench {
namespace {

/// CHOLMOD's kinds of factorization, with its numbers. kAuto: it chooses by the work per entry of the factor.
enum class CholmodFactor { kSimplicial = 0, kAuto = 1, kSupernodal = 2 };
/// kGiven: the order that the matrix comes in; the others: CHOLMOD looks for one of its own.
enum class CholmodOrdering { kGiven = 0, kAmd = 2, kMetis = 3 };

struct CholmodOptions {
  CholmodFactor factor = CholmodFactor::kAuto;
  CholmodOrdering ordering = CholmodOrdering::kGiven;
  std::int64_t refinements = 1;  ///< steps x += A^-1 (b - A x) after each solution
};

struct VelocityIpmCholmodSettings {
  static constexpr Capabilities capabilities{
      .needs = Needs::kFactored,
      .frictionless_only = true,
      .guarantees = "solvable frictionless contact problems of regular inertia, redundant contacts included",
      .obeys_time_limit = true};

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

static_assert(static_cast<int>(CholmodFactor::kSimplicial) == CHOLMOD_SIMPLICIAL);
static_assert(static_cast<int>(CholmodFactor::kAuto) == CHOLMOD_AUTO);
static_assert(static_cast<int>(CholmodFactor::kSupernodal) == CHOLMOD_SUPERNODAL);
static_assert(static_cast<int>(CholmodOrdering::kGiven) == CHOLMOD_NATURAL);
static_assert(static_cast<int>(CholmodOrdering::kAmd) == CHOLMOD_AMD);
static_assert(static_cast<int>(CholmodOrdering::kMetis) == CHOLMOD_METIS);

/// CHOLMOD's view of a lower triangle that the caller owns. The library takes pointers to mutable data, but does not
/// change the data.
cholmod_sparse view_of(const SparseMatrix& lower) {
  cholmod_sparse view{};
  view.nrow = static_cast<std::size_t>(lower.rows());
  view.ncol = static_cast<std::size_t>(lower.cols());
  view.nzmax = static_cast<std::size_t>(lower.nonZeros());
  view.p = const_cast<int*>(lower.outerIndexPtr());
  view.i = const_cast<int*>(lower.innerIndexPtr());
  view.x = const_cast<double*>(lower.valuePtr());
  view.stype = -1;  // symmetric, lower triangle
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

/// CHOLMOD's Cholesky factorization, nothing added to the matrix. A pivot that is not positive (LL') or zero (LDL') is
/// a breakdown. Throws std::bad_alloc when CHOLMOD runs out of memory or of 32-bit indices.
/// [Chen, Davis, Hager, Rajamanickam 2008]
class CholmodCholesky final : public SparseFactorization {
 public:
  explicit CholmodCholesky(const CholmodOptions& options) : options_(options) {
    cholmod_start(&common_);
    common_.print = 0;
    common_.dbound = 0;  // no pivot is raised to a bound
    common_.nmethods = 1;
    common_.method[0].ordering = static_cast<int>(options.ordering);
    common_.postorder = 1;  // supernodes need it, and fill does not change
    common_.supernodal = static_cast<int>(options.factor);
  }
  CholmodCholesky(const CholmodCholesky&) = delete;
  CholmodCholesky& operator=(const CholmodCholesky&) = delete;
  ~CholmodCholesky() override {
    cholmod_free_dense(&solution_, &common_);
    cholmod_free_dense(&scratch_y_, &common_);
    cholmod_free_dense(&scratch_e_, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }

  void analyze(const SparseMatrix& lower) override {
    cholmod_sparse view = view_of(lower);
    factor_ = cholmod_analyze(&view, &common_);
    check(factor_ != nullptr);
    cost_ = {.factor = common_.fl / 2, .solve = 2 * common_.lnz};
  }

  bool factor(const SparseMatrix& lower) override {
    matrix_ = &lower;
    cholmod_sparse view = view_of(lower);
    check(cholmod_factorize(&view, factor_, &common_) != 0);
    return common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
  }

  void solve(Vector& x) override {
    right_hand_side_ = x;
    solve_once(right_hand_side_, x);
    for (std::int64_t round = 0; round < options_.refinements; ++round) {
      residual_ = right_hand_side_;
      residual_.noalias() -= matrix_->selfadjointView<Eigen::Lower>() * x;
      solve_once(residual_, correction_);
      x += correction_;
    }
  }

  Cost cost() const override { return cost_; }

 private:
  /// Errors (status below 0) are thrown: memory, or more entries than 32-bit indices count. Warnings are breakdowns.
  void check(bool done) const {
    if (!done || common_.status < CHOLMOD_OK) throw std::bad_alloc();
  }

  void solve_once(Vector& b, Vector& x) {
    cholmod_dense view{};
    view.nrow = view.nzmax = view.d = static_cast<std::size_t>(b.size());
    view.ncol = 1;
    view.x = b.data();
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    check(cholmod_solve2(CHOLMOD_A, factor_, &view, nullptr, &solution_, nullptr, &scratch_y_, &scratch_e_, &common_) !=
          0);
    x = Eigen::Map<const Vector>(static_cast<const double*>(solution_->x), b.size());
  }

  CholmodOptions options_;
  cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
  Cost cost_;
  const SparseMatrix* matrix_ = nullptr;
  cholmod_dense* solution_ = nullptr;  // these three are kept by CHOLMOD from one solution to the next
  cholmod_dense* scratch_y_ = nullptr;
  cholmod_dense* scratch_e_ = nullptr;
  Vector right_hand_side_;
  Vector residual_;
  Vector correction_;
};

/// The inertia in blocks, a dense one as one block. Nothing if only its inverse is known, or if it has fewer factors
/// than coordinates. Other singular ones fail when their blocks are factored.
std::optional<BlockInertia> in_blocks(const Inertia& inertia) {
  if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) return *blocks;
  if (std::holds_alternative<InverseInertia>(inertia)) return {};
  const auto* factors = std::get_if<FactoredInertia>(&inertia);
  if (factors != nullptr && factors->X.cols() < factors->X.rows()) return {};
  return BlockInertia{{dense_inertia(inertia)}};
}

/// InteriorPoint over CHOLMOD.
///
/// kSolved: the velocity residual, computed from z alone, is at most 3e-5 or the tolerance, and the answer passes
/// AnswerTest.
class VelocityIpmCholmod final : public Solver {
 public:
  explicit VelocityIpmCholmod(const VelocityIpmCholmodSettings& settings)
      : settings_(settings), method_(settings.method) {}
  const Capabilities& capabilities() const override { return VelocityIpmCholmodSettings::capabilities; }

 private:
  void on_load(const Problem& problem) override {
    ContactProblem contact = *problem.contact();
    const std::optional<BlockInertia> blocks = in_blocks(contact.inertia);
    if (!blocks || contact.nc() == 0) return method_.load(nullptr, contact);
    contact.inertia = *blocks;
    method_.load(sparse_whitened_normals(contact, std::make_unique<CholmodCholesky>(settings_.cholmod)), contact);
    if (method_.loaded()) test_.load(problem);
  }

  void on_update(const Vector& v) override {
    if (!method_.loaded() || !v.allFinite()) return Solver::on_update(v);
    method_.set_velocity(v);
    test_.set_velocity(v);
  }

  void on_solve(const SolveRequest& request, Answer& answer) override {
    answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
    if (answer.z.size() == 0) {  // CHOLMOD takes no matrix without entries
      answer.claim = Claim::kSolved;
      return;
    }
    if (!method_.loaded()) {
      answer.claim = Claim::kUnsupported;
      answer.detail = "needs a positive definite inertia, given itself";
      return;
    }
    const double deadline_s = wall_clock_s() + request.time_limit_s;
    method_.begin();
    const InteriorPoint::Stop stop = method_.iterate(std::numeric_limits<double>::infinity(), deadline_s,
                                                   settings_.method.max_iterations, answer.counters);
    if (method_.iterated(stop, answer)) {
      settings_.method.finish ? method_.finish(answer.counters) : method_.drop_parting();
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
       .source = "CHOLMOD: Chen, Davis, Hager, Rajamanickam 2008; the method: velocity_ipm"});
}

}  // namespace lcpbench
