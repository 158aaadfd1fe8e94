#include <limits>
#include <memory>

#include "core/registry.h"
#include "native/active_set/active_set.h"
#include "native/answer_test/answer_test.h"
#include "native/velocity_ipm/interior_point.h"
#include "native/velocity_ipm/multifrontal_cholesky.h"

namespace lcpbench {
namespace {

struct VelocityIpmSettings {
  Algebra algebra = Algebra::kAuto;
  InteriorPointSettings method;

  void visit(auto&& field) {
    visit_algebra(field, algebra);
    method.visit(field);
  }
};

/// Solves frictionless contact problems by the interior-point method in velocity space (InteriorPoint). Block inertia
/// with a sparse N: sparse Cholesky, whose cost follows the graph of bodies. Dense: O(ngc^2 (nc + ngc)).
///
/// Finish. Dense: the dual active-set method from the contacts that are pressed. Sparse: InteriorPoint::finish().
///
/// kSolved: the velocity residual, computed from z alone, is within accept_residual, and the answer passes AnswerTest
/// or the test of the active set; kUnsolvable: shown by the finish; kNumericalFailure: it is not, with what ended the
/// iteration.
class VelocityIpm final : public Solver {
 public:
  explicit VelocityIpm(const VelocityIpmSettings& settings)
      : settings_(settings), method_(settings.method), active_set_({}) {}
  const Capabilities& capabilities() const override;

 private:
  void on_load(const Problem& problem) override;
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  bool ends_with_active_set() const { return settings_.method.finish && !is_sparse_; }
  bool finish_dense(const SolveRequest& request, Answer& answer);
  void confirm_rest(const SolveRequest& request, Answer& answer);

  VelocityIpmSettings settings_;
  InteriorPoint method_;
  ActiveSet active_set_;
  AnswerTest test_;  // of what the active set does not test
  bool is_sparse_ = false;
  Vector pressed_;  // nc
};

void VelocityIpm::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  is_sparse_ = wants_sparse(settings_.algebra, contact);
  method_.load(is_sparse_ ? sparse_whitened_normals(contact, multifrontal_cholesky()) : dense_whitened_normals(contact),
               contact);
  if (!method_.loaded()) return;
  if (!ends_with_active_set()) {
    return test_.load(problem, is_sparse_ ? AnswerTest::Bodies::kOneByOne : AnswerTest::Bodies::kTogether);
  }
  active_set_.load(problem);
  pressed_.resize(contact.nc());
}

void VelocityIpm::on_update(const Vector& v) {
  if (!method_.loaded() || !v.allFinite()) return Solver::on_update(v);
  if (ends_with_active_set()) {
    active_set_.update(v);
  } else {
    test_.set_velocity(v);
  }
  method_.set_velocity(v);
}

/// False when the active set has no answer either; conclude() then writes all of the answer.
bool VelocityIpm::finish_dense(const SolveRequest& request, Answer& answer) {
  method_.pressed_contacts(pressed_);
  const Counters counters = answer.counters;
  active_set_.solve({.start = &pressed_, .time_limit_s = request.time_limit_s}, answer);
  const std::int64_t steps = answer.counters.pivots;
  const std::int64_t factorizations = answer.counters.factorizations;
  answer.counters = counters;
  answer.counters.pivots = steps;
  answer.counters.factorizations += factorizations;
  if (answer.claim == Claim::kSolved || answer.claim == Claim::kUnsolvable) return true;
  answer.velocity.resize(0);
  return false;
}

/// No q is other than zero, but q may have been rounded to that.
void VelocityIpm::confirm_rest(const SolveRequest& request, Answer& answer) {
  if (!ends_with_active_set()) {
    test_.settle(answer, wall_clock_s() + request.time_limit_s);
    return;
  }
  pressed_.setZero();
  active_set_.solve({.start = &pressed_, .time_limit_s = request.time_limit_s}, answer);
}

void VelocityIpm::on_solve(const SolveRequest& request, Answer& answer) {
  if (!method_.loaded()) {
    answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
    answer.claim = Claim::kUnsupported;
    answer.detail = "algebra=sparse needs an inertia of positive definite blocks";
    return;
  }
  if (!method_.iterate(request, answer)) {
    if (answer.claim == Claim::kSolved) confirm_rest(request, answer);
    return;
  }
  if (ends_with_active_set() && finish_dense(request, answer)) return;
  if (!settings_.method.finish) {
    method_.drop_parting();
  } else if (is_sparse_) {
    method_.finish(answer.counters);
  }
  method_.conclude(answer);
  if (!ends_with_active_set()) {
    test_.settle(answer, std::numeric_limits<double>::infinity());
  } else if (answer.claim == Claim::kSolved) {  // refused by the test of the active set, in up to 113 bits
    answer.claim = Claim::kNumericalFailure;
  }
}

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .frictionless_only = true,
    .guarantees = "solvable frictionless contact problems, redundant contacts included",
    .obeys_time_limit = true,
    .allocation_free = true};

const Capabilities& VelocityIpm::capabilities() const { return kCapabilities; }

}  // namespace

SolverDefinition lcpbench_solver_velocity_ipm() {
  return define_solver<VelocityIpm, VelocityIpmSettings>(
      {.name = "velocity_ipm",
       .summary = "predictor-corrector interior point in velocity space, dense or sparse, finished to full accuracy",
       .source = "Mehrotra 1992, On the implementation of a primal-dual interior point method",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
