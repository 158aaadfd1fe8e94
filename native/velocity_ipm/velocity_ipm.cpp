#include "native/velocity_ipm/velocity_ipm.h"

#include <limits>
#include <memory>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/active_set/active_set.h"
#include "native/answer_test/answer_test.h"
#include "native/velocity_ipm/interior_point.h"
#include "native/velocity_ipm/multifrontal.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct VelocityIpmSettings {
  InteriorPointSettings method;

  void visit(auto&& field) {
    method.visit(field);
  }
};

/// Solves frictionless contact problems by the interior-point method in velocity space (InteriorPoint). Block inertia
/// with a sparse N: sparse Cholesky in each step, whose cost follows the graph of bodies. Dense: O(ngc^2 (nc + ngc))
/// for each step.
///
/// With `finish` the answer is brought to full accuracy, dense by the dual active-set method from the contacts that are
/// pressed, sparse by InteriorPoint::finish().
///
/// Finished by the active set, an answer is claimed as ActiveSet does. Else kSolved: the velocity residual, computed
/// from z alone, is at most 3e-5 or the tolerance, and the answer passes AnswerTest; kUnsolvable: AnswerTest proves it.
/// kNumericalFailure: neither, and `detail` mostly says what ended the iteration or the test.
class VelocityIpm final : public BudgetedSolver {
 public:
  explicit VelocityIpm(const VelocityIpmSettings& settings)
      : settings_(settings), method_(settings.method), active_set_({}) {}
  const Capabilities& capabilities() const override;
  bool solve_within(const Budget& budget, Answer& answer) override;
  double work() const override { return method_.work() - work_before_ + work_of_active_set_; }
  double residual(const Answer& /*answer*/) override { return method_.loaded() ? method_.best(best_) : kInfinity; }

 private:
  void on_load(const Problem& problem) override;
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  void begin(double error);
  bool ends_with_active_set() const { return settings_.method.finish && !is_sparse_; }
  void end(InteriorPoint::Stop stop, double deadline_s);
  bool finish_dense(double deadline_s);
  void confirm_rest(double deadline_s);
  void run_active_set(double deadline_s);

  VelocityIpmSettings settings_;
  InteriorPoint method_;
  ActiveSet active_set_;
  AnswerTest test_;  // of answers that the active set does not finish
  bool is_sparse_ = false;
  Vector pressed_, best_;  // nc
  Answer result_;
  double work_before_ = 0;  // of method_, at begin()
  double work_of_active_set_ = 0;
};

void VelocityIpm::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  result_.reserve(problem);
  best_.resize(contact.nc());
  is_sparse_ = suits_sparse_algebra(contact);
  method_.load(is_sparse_ ? sparse_whitened_normals(contact, multifrontal_cholesky()) : dense_whitened_normals(contact),
               contact);
  if (!method_.loaded()) return;
  if (!ends_with_active_set()) {
    return test_.load(problem);
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

/// Solves for result_, from the contacts in pressed_.
void VelocityIpm::run_active_set(double deadline_s) {
  active_set_.solve({.start = &pressed_, .time_limit_s = deadline_s - wall_clock_s()}, result_);
  const ContactProblem& contact = *problem().contact();
  const auto rows = static_cast<double>(contact.nc() + contact.ngc());
  work_of_active_set_ += static_cast<double>(result_.counters.pivots) * static_cast<double>(contact.ngc()) * rows;
}

/// Adds to the counters. False when the active set decides nothing; the claim says why. InteriorPoint::conclude() then
/// writes z.
bool VelocityIpm::finish_dense(double deadline_s) {
  method_.pressed_contacts(pressed_);
  const Counters counters = result_.counters;
  run_active_set(deadline_s);
  const std::int64_t steps = result_.counters.pivots;
  const std::int64_t factorizations = result_.counters.factorizations;
  result_.counters = counters;
  result_.counters.pivots = steps;
  result_.counters.factorizations += factorizations;
  if (result_.claim == Claim::kSolved || result_.claim == Claim::kUnsolvable) return true;
  result_.velocity.resize(0);
  return false;
}

/// Tests z = 0, the answer where q is computed as zero: rounding may hide a q that is not.
void VelocityIpm::confirm_rest(double deadline_s) {
  if (!ends_with_active_set()) {
    test_.settle(result_, deadline_s);
    return;
  }
  pressed_.setZero();
  run_active_set(deadline_s);
}

void VelocityIpm::begin(double error) {
  result_.clear();
  result_.z.resize(problem().size());
  result_.z.setZero();
  result_.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  work_before_ = method_.work();
  work_of_active_set_ = 0;
  if (!method_.loaded()) return;
  method_.aim_at(error > 0 ? error : settings_.method.tolerance);
  if (error > 0) method_.accept(error);
  test_.allow(error);
  method_.begin();
}

bool VelocityIpm::solve_within(const Budget& budget, Answer& answer) {
  using Stop = InteriorPoint::Stop;
  begin(budget.error);
  bool has_ended = true;
  if (method_.loaded()) {
    const Stop stop = method_.iterate(budget.work, budget.deadline_s, settings_.method.max_iterations, result_.counters);
    has_ended = stop != Stop::kWorkLimit;
    if (has_ended) {
      end(stop, budget.deadline_s);
    } else {
      result_.claim = Claim::kIterationLimit;
      method_.best(result_.z);
    }
  } else {
    result_.claim = Claim::kUnsupported;
    result_.detail = "needs an inertia of positive definite blocks";
  }
  answer.reserve(problem());
  answer = result_;
  return has_ended;
}

void VelocityIpm::end(InteriorPoint::Stop stop, double deadline_s) {
  if (!method_.iterated(stop, result_)) {
    if (result_.claim == Claim::kSolved) confirm_rest(deadline_s);
    return;
  }
  if (ends_with_active_set() && finish_dense(deadline_s)) return;
  const bool is_out_of_time = result_.claim == Claim::kTimeLimit;  // of the active set
  if (!settings_.method.finish) {
    method_.drop_parting();
  } else if (is_sparse_) {
    method_.finish(result_.counters);
  }
  method_.conclude(result_);
  if (!ends_with_active_set()) {
    test_.settle(result_, deadline_s);
  } else if (is_out_of_time) {
    result_.claim = Claim::kTimeLimit;
  } else if (result_.claim == Claim::kSolved) {  // the active set, which tests in up to 113 bits, did not confirm it
    result_.claim = Claim::kNumericalFailure;
  }
}

void VelocityIpm::on_solve(const SolveRequest& request, Answer& answer) {
  solve_within({.deadline_s = wall_clock_s() + request.time_limit_s}, answer);
}

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .frictionless_only = true,
    .guarantees = "solvable frictionless contact problems, redundant contacts included",
    .obeys_time_limit = true,
    .allocation_free = true};

constexpr Capabilities kSoft = with_compliance(kCapabilities);

const Capabilities& VelocityIpm::capabilities() const {
  return yields_without_friction(problem()) ? kSoft : kCapabilities;
}

}  // namespace

std::unique_ptr<BudgetedSolver> make_velocity_ipm() { return std::make_unique<VelocityIpm>(VelocityIpmSettings{}); }

SolverDefinition lcpbench_solver_velocity_ipm() {
  return define_solver<VelocityIpm, VelocityIpmSettings>(
      {.name = "velocity_ipm",
       .summary = "predictor-corrector interior point in velocity space, dense or sparse, finished to full accuracy",
       .source = "Mehrotra 1992, On the implementation of a primal-dual interior point method",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
