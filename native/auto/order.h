#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/problem.h"
#include "native/auto/report.h"

namespace lcpbench {

/// A method, and the work (BudgetedSolver::work()) that it may do in its first turn at an island.
struct Turn {
  AutoMethod method;
  double work;
  double price;  ///< of a unit of its work, in multiplications of contact_lemke
};

/// Rows of normals and tangents (two for each contact with friction) over the coordinates that contacts move: above 1
/// contacts oppose each other. O(contacts)
double redundancy(const ContactProblem& contact, Index idle);

/// In which order methods take turns at an island: the likeliest first, by the island's size, by friction, and by the
/// error that is asked for.
class Order {
 public:
  static constexpr std::size_t kMaxTurns = 4;

  /// No turn has less work: to end it sooner would cost more than it saves, since the next method would be loaded.
  static constexpr double kLeastWork = 0x1p17;

  /// Of the methods that take the problem. O(1)
  /// @param idle coordinates that no contact moves @param error that an answer may leave; 0: none is stated
  void choose(const Problem& problem, Index idle, double error);
  /// The method has the first turn, if it takes the problem.
  void put_first(AutoMethod method);
  /// So has friction_ipm, for its first convex problem, which finds rest.
  void put_rest_first();

  std::span<const Turn> turns() const { return {turns_.data(), count_}; }
  /// Whether the method has a turn.
  bool has(AutoMethod method) const;
  /// What the first method takes on about half of all islands of this size, in multiplications of contact_lemke.
  double likely_work() const { return count_ > 0 ? turns_[0].price * turns_[0].work / kWorkOfNineOverHalf : 0; }
  /// The same of the first convex problem of friction_ipm, which finds rest; with its load.
  double likely_work_of_rest() const { return unknowns_ * (kWorkOfRest + kStepsToRest * block_ * block_); }

 private:
  /// What a method takes on nine of ten islands, over what it takes on every second one.
  static constexpr double kWorkOfNineOverHalf = 4;
  static constexpr double kWorkOfRest = 0x1p14, kStepsToRest = 16;  ///< for each unknown

  std::array<Turn, kMaxTurns> turns_{};
  std::size_t count_ = 0;
  double unknowns_ = 1;
  double block_ = 1;  ///< coordinates of the largest block of the inertia
};

}  // namespace lcpbench
