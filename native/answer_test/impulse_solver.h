#pragma once

#include <limits>
#include <string>

#include "core/solver.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"
#include "native/contacts/contact_impulses.h"
#include "native/contacts/budgeted_solver.h"

namespace lcpbench {

/// A solver whose iterates are impulses: its state, and the test of its answers. Base is a Solver. on_load() of the
/// solver loads state_ and, unless it sets refusal_, calls load_test().
template <class Base>
class ImpulseSolver : public Base {
 protected:
  void on_update(const Vector& v) final {
    if (!refusal_.empty() || !v.allFinite()) return Solver::on_update(v);  // refuses it, as load does
    state_.set_velocity(v);
    test_.set_velocity(v);
  }

  /// @pre state_ is loaded
  void load_test(const Problem& problem) {
    test_.load(problem, &state_.units.numbers());
  }

  /// Where no contact approaches in double (of a bare LCP q is 0), so that no impulses are the solution: claims z = 0 if
  /// it passes the test.
  /// @pre answer is cleared, with a zero z of the right size
  void claim_rest(double deadline_s, Answer& answer) {
    answer.claim = Claim::kSolved;
    answer.counters.iterations = 0;
    test_.settle(answer, deadline_s);  // q may have underflowed
  }

  static constexpr const char* kGrewOutOfRange = "the iterates grew out of the range of double";

  std::string refusal_;  // why the solver does not take the problem that is loaded, which no capability says; or ""
  ContactImpulses state_;
  AnswerTest test_;
};

/// An ImpulseSolver whose solves a budget may end.
template <class Base = BudgetedSolver>
class BudgetedImpulseSolver : public ImpulseSolver<Base> {
 public:
  bool solve_within(const Budget& budget, Answer& answer) override {
    bool has_ended = true;
    begin(budget.start, budget.error);
    if (!this->refusal_.empty()) {
      result_.claim = Claim::kUnsupported;
      result_.detail = this->refusal_;
    } else if (!(this->state_.scale > 0)) {
      this->claim_rest(budget.deadline_s, result_);
    } else {
      has_ended = run(budget.work, budget.deadline_s);
    }
    answer.reserve(this->problem());
    answer = result_;
    return has_ended;
  }

 protected:
  /// Begins a solve: result_ by begin_result(), and all that does not outlast a solve.
  virtual void begin(const Vector* start, double error) = 0;
  /// @pre q is not 0 @returns whether the solve has ended, with what result_ says; if not, so much work is done
  virtual bool run(double work, double deadline_s) = 0;

  void on_solve(const SolveRequest& request, Answer& answer) final {
    const double deadline_s = wall_clock_s() + request.time_limit_s;
    solve_within({.start = this->capabilities().warm_start ? request.start : nullptr, .deadline_s = deadline_s}, answer);
  }

  void begin_result(const Counters& counters) {
    result_.clear();
    result_.z.resize(this->problem().size());
    result_.z.setZero();
    result_.counters = counters;
  }

  /// Claims result_ if it passes the test of all native solvers. @param work  grows by that of the test
  /// @returns whether the solve has ended
  bool settle(double deadline_s, double& work) {
    result_.claim = Claim::kSolved;
    const bool is_end = this->test_.settle(result_, deadline_s) || result_.claim != Claim::kNumericalFailure;
    work += this->state_.work_of_test() + this->test_.work_in_quad();
    return is_end;
  }

  Answer result_;
};

/// A method in rounds whose residual need not fall: the impulses of the smallest residual are its answer.
template <class Base = BudgetedSolver>
class BestImpulseSolver : public BudgetedImpulseSolver<Base> {
 public:
  double residual(const Answer& /*answer*/) override {
    if (!this->refusal_.empty()) return std::numeric_limits<double>::infinity();
    return this->state_.scale > 0 ? best_.residual : 0;
  }

 protected:
  /// The residual up to which the impulses are claimed, unless the tolerance is larger or an error is stated.
  static constexpr double kAcceptedResidual = 1e-4;

  /// Of one solve.
  struct Best {
    double tolerance = 0;        ///< of the residual, relative to the scale: where the rounds end
    double accept_residual = 0;  ///< and up to where the impulses are claimed
    double residual = std::numeric_limits<double>::infinity();  ///< the least so far, that of best_impulse_
    double work = 0;  ///< see BudgetedSolver::work(); a method may have more of its own
  };

  /// Ends the solve with the best impulses. @param claim  if their residual is more than accept_residual
  /// @returns whether the solve has ended; if they fail the test of what is claimed, it goes on to a smaller residual
  bool end(Claim claim, double deadline_s) {
    constexpr double kTighter = 0.25;
    report_best(claim);
    if (!(best_.residual <= best_.accept_residual) || this->settle(deadline_s, best_.work)) return true;
    this->state_.drop_what_counts_as_zero();
    report(claim);
    if (this->settle(deadline_s, best_.work)) return true;
    if (!can_improve() || best_.residual > best_.tolerance || best_.residual <= kSureResidual) return true;
    best_.tolerance = kTighter * best_.residual;
    return false;
  }

  /// Hands out the best impulses, where the budget of work is over.
  void report_best(Claim claim) {
    this->state_.impulse = best_impulse_;
    this->state_.recompute_velocity();
    report(claim);
  }

  /// Whether another round may have a smaller residual.
  virtual bool can_improve() const { return true; }
  /// Writes Answer::detail of a claim.
  virtual void describe(std::string& /*detail*/) const {}

  Best best_;
  Vector best_impulse_;  // of ContactImpulses

 private:
  /// The impulses of the state.
  void report(Claim claim) {
    this->result_.claim = claim;
    this->state_.write_answer(this->result_.z);
    describe(this->result_.detail);
  }
};

}  // namespace lcpbench
