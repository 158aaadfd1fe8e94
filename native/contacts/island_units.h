#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"

namespace lcpbench {

/// Powers of two, at least 1, that bring max|q| of every island to the largest of them, or to less than twice that. An
/// iteration whose tolerances are relative to max|q| of the whole problem then holds every island to its own. Nothing
/// couples islands, so that the velocity of an island times its unit has its impulses times the same unit, bit for bit
/// (but for underflow).
///
/// An island whose q cancels to less than 1e-5 of its terms is scaled as if it did not cancel further: its rounding
/// must stay far below the tolerances. Where there is one island all units are 1, and so is that of an island with
/// q = 0.
class IslandUnits {
 public:
  void load(const ContactProblem& problem);
  /// Of LCP(q, M): each row is a contact and a coordinate. O(n^2)
  void load(const Matrix& M);

  /// Of the contact problem; empty where its inertia couples all, and no contact is soft.
  const IslandNumbers& numbers() const { return numbers_; }

  /// False: all units are 1, and nothing below changes that.
  bool several() const { return islands_.size() > 1; }

  /// Three steps that choose the units for a velocity: clear(), add_row() for the rows of [N D] (one of two opposite
  /// ones suffices), choose(). Until then they are 1. Allocates nothing.
  /// @param q its J_i'v + b_i; `magnitudes` the sum |J_i|'|v| + |b_i|
  void clear();
  void add_row(Index contact, double q, double magnitudes);
  /// @param v of all coordinates (q of a bare LCP)
  void choose(const Vector& v);

  double of_contact(Index contact) const { return unit(numbers_.of_contact, contact); }
  double of_coordinate(Index coordinate) const { return unit(numbers_.of_coordinate, coordinate); }

  /// Velocities of all coordinates: into these units, and back.
  void scale(Vector& v) const;
  void restore(Vector& v) const;

 private:
  struct Island {
    double q = 0;           // largest |q_i|
    double magnitudes = 0;  // largest sum of the terms of a q_i
    double speed = 0;       // largest |v_i|
    double unit = 1;
  };

  static double choose(const Island& island, double largest_q);

  double unit(const std::vector<Index>& island_of, Index i) const {
    if (!several()) return 1;
    const Index island = island_of[static_cast<std::size_t>(i)];
    return island < 0 ? 1 : islands_[static_cast<std::size_t>(island)].unit;
  }

  IslandNumbers numbers_;
  std::vector<Island> islands_;
};

}  // namespace lcpbench
