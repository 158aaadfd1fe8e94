#pragma once

#include <memory>
#include <vector>

#include "core/islands.h"
#include "core/problem.h"
#include "core/solver.h"
#include "native/auto/island_solver.h"
#include "native/auto/report.h"
#include "native/contacts/problem_cutter.h"

namespace lcpbench {

/// One island of a problem as a problem of its own, without the friction rows that cannot press. If no contact
/// approaches, none presses and nothing is solved. If no method finds an answer, z = 0 is tested (RestTest): it is one
/// where the contacts approach by rounding only.
class IslandOfProblem {
 public:
  IslandOfProblem(Methods& shared, const std::shared_ptr<LaterEngines>& later, double error)
      : solver_(shared, later, error, false) {}

  /// Cuts the problem out. @param whole must outlive the next load @param v velocity of the whole problem
  /// @param carries per contact of the whole; 1 for those whose lambda the answer of solve() includes
  void load(ProblemCutter& whole, const Island& island, const Vector& v, std::vector<char>& carries,
            const IslandSolver::Load& how);
  /// Another velocity. Loads the methods if a contact approaches for the first time since load().
  void update(const Vector& v);

  /// Adds the island's impulses to z and its change of velocity to u, both of the whole problem. u arrives as v.
  /// @param start of the whole problem, or nullptr
  /// @returns kSolved, or why not; answer() then says more, and z has the best impulses that were found
  Claim solve(const Vector* start, const AutoLimits& limits, Vector& z, Vector& u, AutoReport& report);

  /// Of the last solve, unless the island was at rest.
  const Answer& answer() const { return answer_; }
  const std::vector<Index>& contacts() const { return island_.contacts; }
  /// The last solve gave a velocity of the solver's own, which is in u.
  bool gave_velocity() const { return is_at_rest_ || answer_.velocity.size() > 0; }
  /// Work that the island is likely to take; 0 at rest.
  double likely_work() const { return is_at_rest_ ? 0 : solver_.likely_work(); }

 private:
  void cut(const Vector& v);
  void place_unknowns(const ContactLayout& layout);
  bool rests(const Vector& u) const;
  Claim remain_at_rest(AutoReport& report);
  void tell_what_is_carried();
  void write_velocity(Vector& u);

  ProblemCutter* cutter_ = nullptr;
  std::vector<char>* carries_ = nullptr;
  Island island_;
  bool is_at_rest_ = false;
  bool is_loaded_ = false;  ///< solver_
  IslandSolver::Load how_;

  /// The data of problem_, unless that is the whole, and those of an earlier one, which solvers may still read. Only
  /// data that nobody else has are written over.
  std::shared_ptr<ContactProblem> part_, spare_;
  Problem problem_;
  std::vector<Index> place_;  ///< in z of the whole, of each unknown
  Vector v_, u_, start_;
  Answer answer_;
  IslandSolver solver_;
};

}  // namespace lcpbench
