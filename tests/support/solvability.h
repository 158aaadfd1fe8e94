#pragma once

#include <cmath>

// The shares of solvable problems of which study/paper/rates.sql has the values.

namespace lcpbench::paper {

// The generator's sizes, docs/reference/generators.md.
inline constexpr int kFewestCoordinates = 6;
inline constexpr int kMostCoordinates = 15;
inline constexpr int kFewestContacts = 2;
inline constexpr int kMostContacts = 20;
inline constexpr int kLowestRank = 6;

/// Mean of `chance(contacts, coordinates, rank)` over the sizes.
template <class Chance>
double mean_over_sizes(Chance chance) {
  double total = 0;
  for (int coordinates = kFewestCoordinates; coordinates <= kMostCoordinates; ++coordinates) {
    const int ranks = coordinates - kLowestRank + 1;
    for (int contacts = kFewestContacts; contacts <= kMostContacts; ++contacts) {
      for (int rank = kLowestRank; rank <= coordinates; ++rank) total += chance(contacts, coordinates, rank) / ranks;
    }
  }
  return total / ((kMostCoordinates - kFewestCoordinates + 1) * (kMostContacts - kFewestContacts + 1));
}

/// The chance that `count` random half-spaces through the origin of a space of `dimension`, in general position and
/// each as likely as its opposite, have a common point (Wendel 1962): 2^(1-count) sum over i < dimension of C(count-1,
/// i).
/// @pre count >= 1, dimension >= 0.
inline double wendel(int count, int dimension) {
  double binomial = 1;
  double sum = 0;
  for (int i = 0; i < dimension && i < count; ++i) {
    sum += binomial;
    binomial = binomial * (count - 1 - i) / (i + 1);
  }
  return std::ldexp(sum, 1 - count);
}

/// The chance that a frictionless problem with `contacts` generic contacts, `coordinates` coordinates and an inertia of
/// rank `rank` has a solution: 1 at full rank, else the mean of Wendel's for `rank` and `rank` + 1. It has none iff
/// some u >= 0 has N u in the null space of G and v'N u < 0.
inline double solvable_chance(int contacts, int coordinates, int rank) {
  if (rank >= coordinates) return 1;
  return (wendel(contacts, rank) + wendel(contacts, rank + 1)) / 2;
}

/// The share of Experiment 3's monotone problems that have a solution: the mean over the generator's sizes at their
/// defaults (6..15 coordinates, 2..20 contacts, rank 6..coordinates).
inline double solvable_share_of_exp3() { return mean_over_sizes(solvable_chance); }

/// The same of Experiment 4 where a redundant contact is a positive multiple of one other, which asks nothing new of a
/// velocity: only the 1..contacts independent ones count. The reading `combination` has no such form.
inline double solvable_share_of_exp4() {
  return mean_over_sizes([](int contacts, int coordinates, int rank) {
    double total = 0;
    for (int independent = 1; independent <= contacts; ++independent) {
      total += solvable_chance(independent, coordinates, rank);
    }
    return total / contacts;
  });
}

}  // namespace lcpbench::paper
