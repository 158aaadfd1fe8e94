#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"

namespace lcpbench {

/// One factor for each island, its unit: a power of two >= 1 that brings its max|q| to at least the largest of all
/// islands, and to less than twice that. Tolerances relative to max|q| of the whole problem are then relative to that
/// of each island. Nothing couples islands: velocities and offsets times the unit have impulses times the unit, bit for
/// bit except for underflow.
///
/// The unit is smaller where scaled velocities would overflow, and where q cancels: |q| below 2^-17 of the sum of its
/// terms' magnitudes counts as that much, so that its rounding error stays far below the tolerances. It is 1 for an
/// island with q = 0. All are 1 if there is one island, or if some q is not finite.
class IslandUnits {
 public:
  void load(const ContactProblem& problem);
  /// Of LCP(q, M): each row is a contact and a coordinate. O(n^2)
  void load(const Matrix& M);

  /// Of the problem; empty for a contact problem whose inertia couples all coordinates, if no contact is soft.
  const IslandNumbers& numbers() const { return numbers_; }

  /// False: all units are 1 for every velocity.
  bool several() const { return islands_.size() > 1; }

  /// Three steps choose the units for a velocity v: clear(), which makes them 1; add_row() for each column J_i of
  /// [N D], or one of two opposite columns; choose(). They allocate nothing.
  /// @param q J_i'v and the row's offset @param magnitudes |J_i|'|v| and the offset's magnitude
  void clear();
  void add_row(Index contact, double q, double magnitudes);
  /// @param v of all coordinates (q of a bare LCP)
  void choose(const Vector& v);

  double of_contact(Index contact) const { return unit(numbers_.of_contact, contact); }
  double of_coordinate(Index coordinate) const { return unit(numbers_.of_coordinate, coordinate); }

  /// Multiplies the velocities of all coordinates by their units; restore() divides.
  void scale(Vector& v) const;
  void restore(Vector& v) const;

 private:
  struct Island {
    double q = 0;           // largest |q_i|
    double magnitudes = 0;  // largest sum of the terms of a q_i
    double speed = 0;       // largest |v_i|
    double unit = 1;
  };

  static double unit_for(const Island& island, double largest_q);

  double unit(const std::vector<Index>& island_of, Index i) const {
    if (!several()) return 1;
    const Index island = island_of[static_cast<std::size_t>(i)];
    return island < 0 ? 1 : islands_[static_cast<std::size_t>(island)].unit;
  }

  IslandNumbers numbers_;
  std::vector<Island> islands_;
};

}  // namespace lcpbench
