#pragma once

#include <memory>
#include <vector>

#include "core/isa.h"
#include "core/islands.h"
#include "core/settings.h"
#include "core/solver.h"
#include "native/active_set/active_set_engine.h"
#include "native/contacts/growing_vector.h"
#include "native/contacts/budgeted_solver.h"
#include "native/proofs/doubtful_inertia.h"
#include "native/proofs/farkas_support.h"

namespace lcpbench {

struct ActiveSetSettings {
  double accept_residual = 3e-5;
  std::int64_t max_iterations = 0;

  void visit(auto&& field) {
    field("accept_residual", accept_residual, RealRange{.min = 0},
          "claim solved only when the velocity residual is at most this times the scale of the island; whatever is "
          "set, at most 5e-5 of the scale, or 1e-9 where the inertia may be singular");
    field("max_iterations", max_iterations, IntegerRange{.min = 0, .max = std::int64_t{1} << 40},
          "contacts added to or dropped from the active set; 0: 20 (contacts + coordinates) + 100");
  }
};

/// Solves frictionless contact problems as the projection of v onto {u : N'u >= 0} in the metric of the inertia,
///
///     minimize 1/2 (u - v)'G (u - v) subject to N'u >= 0,
///
/// whose multipliers are the normal impulses, by the dual active-set method of Goldfarb and Idnani in coordinates in
/// which the inertia is the identity. In exact arithmetic it ends at the solution, or proves that there is none, for
/// any contacts, redundant or not: finite because the objective increases. [Goldfarb, Idnani 1983;
/// docs/reference/solvers/active_set.md]
///
/// Set-up O(ngc^3 / 6 + nc ngc^2 / 2), less where the inertia is blocks, a step O(ngc (nc + active)). Returns the
/// velocity as well as z.
///
/// kSolved: the answer passed the solver's own test; kUnsolvable: it is proven for the data as they are that some
/// contacts approach whatever the impulses (FarkasSupport; `farkas` is that u, rounded); kIterationLimit, kTimeLimit;
/// kNumericalFailure: the test failed, no such proof was found, or the inertia is not semidefinite or too close to
/// singular for double. SolveRequest::start: its positive entries are the first active set.
class ActiveSet final : public BudgetedSolver {
 public:
  /// @param level instruction-set level of the engines; must not exceed best_isa_level().
  explicit ActiveSet(const ActiveSetSettings& settings, IsaLevel level = isa_level());

  const Capabilities& capabilities() const override;

  /// Budget::error has no effect: the method ends in an answer to rounding or in none.
  bool solve_within(const Budget& budget, Answer& answer) override;
  double work() const override { return static_cast<double>(outcome_.work); }
  double residual(const Answer& answer) override;

  /// What load() takes, in the units of work(). @param idle coordinates that no contact moves, which are left out
  static double load_work(const Problem& problem, Index idle);

  /// Takes all memory that load() and solve() need for this problem, and touches hardly any of it: load() then
  /// allocates nothing for this and any other that was reserved. What was loaded must be loaded again.
  void reserve(const Problem& problem);

 private:
  void on_load(const Problem& problem) override;
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;
  void describe(const ContactProblem& contact);
  void begin_solve(const Vector* start);
  void finish(Answer& answer);
  bool is_disproved();
  double accepted() const;

  ActiveSetSettings settings_;
  std::unique_ptr<active_set::Engine> engine_;

  active_set::Rules rules_;
  active_set::Outcome outcome_;
  active_set::Input input_;  // points into the problem, or into what follows
  DoubtfulInertia doubtful_;
  IslandNumbers islands_;  // found only where the inertia does not couple all
  GrowingVector v_;
  GrowingVector dense_normals_;  // of a sparse N
  GrowingVector dense_inertia_;  // of block inertia
  GrowingVector farkas_;
  std::vector<Index> support_;  // of farkas_
  FarkasSupport farkas_support_;
};

/// @throws std::invalid_argument when this processor lacks the level
std::unique_ptr<active_set::Engine> make_active_set_engine(IsaLevel level);

}  // namespace lcpbench
