#include "study/paper/solvability.h"

#include <cmath>

namespace lcpbench::paper {

namespace {

// The generator's sizes, docs/reference/generators.md.
constexpr int kFewestCoordinates = 6;
constexpr int kMostCoordinates = 15;
constexpr int kFewestContacts = 2;
constexpr int kMostContacts = 20;
constexpr int kLowestRank = 6;

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

}  // namespace

double wendel(int count, int dimension) {
  double binomial = 1;
  double sum = 0;
  for (int i = 0; i < dimension && i < count; ++i) {
    sum += binomial;
    binomial = binomial * (count - 1 - i) / (i + 1);
  }
  return std::ldexp(sum, 1 - count);
}

double solvable_chance(int contacts, int coordinates, int rank) {
  if (rank >= coordinates) return 1;
  return (wendel(contacts, rank) + wendel(contacts, rank + 1)) / 2;
}

double solvable_share_of_exp3() { return mean_over_sizes(solvable_chance); }

double solvable_share_of_exp4() {
  return mean_over_sizes([](int contacts, int coordinates, int rank) {
    double total = 0;
    for (int independent = 1; independent <= contacts; ++independent) {
      total += solvable_chance(independent, coordinates, rank);
    }
    return total / contacts;
  });
}

}  // namespace lcpbench::paper
