#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"

namespace lcpbench {

/// One factor for each island, its unit: a power of two >= 1 that brings its scale (ContactScale; of a bare LCP max|q|)
/// to at least the largest of all islands, and to less than twice that. Tolerances relative to the largest scale are
/// then relative to that of each island. Nothing couples islands: velocities and offsets times the unit have impulses
/// times the unit, bit for bit except for underflow.
///
/// The unit is smaller where scaled velocities would overflow, and where q cancels: a scale below 2^-17 of the sum of
/// the magnitudes of a q's terms counts as that much, so that its rounding error stays far below the tolerances. It is
/// 1 for an island without an approach, which no impulses solve. All are 1 if there is one island, or if some q is not
/// finite.
class IslandUnits {
 public:
  void load(const ContactProblem& problem);
  /// Of LCP(q, M): each row is a contact and a coordinate. O(n^2)
  void load(const Matrix& M);

  /// Of the problem; empty for a contact problem whose inertia couples all coordinates, if no contact is soft.
  const IslandNumbers& numbers() const { return numbers_; }

  /// False: all units are 1 for every velocity.
  bool several() const { return islands_.size() > 1; }

  /// What a row adds to the scale of its island.
  struct Row {
    double approach = 0;    ///< -q_i of a normal row, if above zero; |q_i| of a bare LCP
    double floor = 0;       ///< ContactScale::floor() of the row alone; of a bare LCP 0
    double magnitudes = 0;  ///< of the terms of q_i, summed
  };

  /// Three steps choose the units for a velocity v: clear(), which makes them 1; add_row() for each column J_i of
  /// [N D], or one of two opposite columns; choose(). They allocate nothing.
  void clear();
  void add_row(Index contact, const Row& row);
  /// @param v of all coordinates (q of a bare LCP)
  void choose(const Vector& v);
  /// The largest scale of an island with an approach, in its unit 1; 0 if none has one. Infinite where one is not
  /// finite. @pre several(); choose()
  double largest_scale() const { return largest_scale_; }

  double of_contact(Index contact) const { return unit(numbers_.of_contact, contact); }
  double of_coordinate(Index coordinate) const { return unit(numbers_.of_coordinate, coordinate); }

  /// Multiplies the velocities of all coordinates by their units; restore() divides.
  void scale(Vector& v) const;
  void restore(Vector& v) const;

 private:
  struct Island {
    Row largest;       // each of its rows
    double speed = 0;  // largest |v_i|
    double unit = 1;

    double scale() const { return largest.approach > largest.floor ? largest.approach : largest.floor; }
  };

  static double unit_for(const Island& island, double largest_scale);

  double unit(const std::vector<Index>& island_of, Index i) const {
    if (!several()) return 1;
    const Index island = island_of[static_cast<std::size_t>(i)];
    return island < 0 ? 1 : islands_[static_cast<std::size_t>(island)].unit;
  }

  IslandNumbers numbers_;
  std::vector<Island> islands_;
  double largest_scale_ = 0;
};

/// The row of a contact problem. @param velocity J_i'v @param terms |J_i|'|v| @param offset of q_i @param magnitude that
/// of the terms of the offset
IslandUnits::Row row_of_units(bool is_normal, double velocity, double terms, double entries, double offset,
                              double magnitude);

}  // namespace lcpbench
