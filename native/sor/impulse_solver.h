#pragma once

#include "core/solver.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {

/// A method that changes one impulse after the other: its state, and the test of its answers. Base is a Solver.
template <class Base = Solver>
class ImpulseSolver : public Base {
 protected:
  /// After state_ is loaded.
  virtual void prepare(const Problem& problem) = 0;
  /// @pre q is not 0
  virtual void iterate(const SolveRequest& request, double deadline_s, Answer& answer) = 0;

  void on_load(const Problem& problem) final {
    state_.load(problem);
    prepare(problem);
    test_.load(problem, AnswerTest::Bodies::kOneByOne, &state_.units.numbers());
  }
  void on_update(const Vector& v) final {
    if (!v.allFinite()) return Solver::on_update(v);  // refuses it, as load does
    state_.set_velocity(v);
    test_.set_velocity(v);
  }
  void on_solve(const SolveRequest& request, Answer& answer) final {
    const double deadline_s = wall_clock_s() + request.time_limit_s;
    if (state_.q_max > 0) return iterate(request, deadline_s, answer);
    claim_rest(deadline_s, answer);
  }

  /// Where q is 0 in double, so that max|q| gives no scale for a residual: claims z = 0 if it passes the test.
  /// @pre answer is cleared, with a zero z of the right size
  void claim_rest(double deadline_s, Answer& answer) {
    answer.claim = Claim::kSolved;
    answer.counters.iterations = 0;
    test_.settle(answer, deadline_s);  // q may have underflowed
  }

  static constexpr const char* kGrewOutOfRange = "the iterates grew out of the range of double";

  ContactImpulses state_;
  AnswerTest test_;
};

}  // namespace lcpbench
