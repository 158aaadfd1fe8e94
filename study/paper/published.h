#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

namespace lcpbench::paper {

// The figures of Drumwright and Shell (2012), "Extensive analysis of linear complementarity problem (LCP) solver
// performance on randomly generated rigid body contact problems", as printed: published.csv. Here is what the paper's
// experiments are called, and what theory says of them.

/// Algorithm III.1 (frictionless) or IV.1 (friction cones).
enum class Kind { kMonotone, kCopositive };

/// The solvers of the paper.
enum class Family { kLemke, kPath, kInteriorPoint };

inline constexpr std::array<Kind, 2> kKinds{Kind::kMonotone, Kind::kCopositive};
inline constexpr std::array<Family, 3> kFamilies{Family::kLemke, Family::kPath, Family::kInteriorPoint};

/// "monotone", "copositive": as in the names of sets.
const char* name_of(Kind kind);
/// "Lemke", "PATH", "IP": as in the paper's tables.
const char* name_of(Family family);

/// An experiment by its name in sets ("exp5-1e8") and in the paper's tables ("5, 1e8").
struct Experiment {
  std::string_view name;
  std::string_view title;
  bool redundant = false;        ///< has dependent contacts, so that the readings of redundancy differ
  bool regularized = false;      ///< Experiment 6
  std::string_view condition{};  ///< "1e5", "1e8", "1e10", "" where none is prescribed
};

/// In the order of the tables; the experiment with the raised ceilings last.
std::span<const Experiment> experiments();
/// nullptr for a name that is none of them.
const Experiment* find_experiment(std::string_view name);

/// The chance that `count` random half-spaces through the origin of a space of `dimension`, in general position and
/// each as likely as its opposite, have a common point (Wendel 1962): 2^(1-count) sum over i < dimension of C(count-1,
/// i).
/// @pre count >= 1, dimension >= 0.
double wendel(int count, int dimension);

/// The chance that a frictionless problem with `contacts` generic contacts, `coordinates` coordinates and an inertia of
/// rank `rank` has a solution: 1 at full rank, else the mean of Wendel's for `rank` and `rank` + 1. It has none iff
/// some u >= 0 has N u in the null space of G and v'N u < 0.
double solvable_chance(int contacts, int coordinates, int rank);

/// The share of Experiment 3's monotone problems that have a solution: the mean over the generator's sizes at their
/// defaults (6..15 coordinates, 2..20 contacts, rank 6..coordinates).
double solvable_share_of_exp3();

/// The same of Experiment 4 where a redundant contact is a positive multiple of one other, which asks nothing new of a
/// velocity: only the 1..contacts independent ones count. The reading `combination` has no such form.
double solvable_share_of_exp4();

}  // namespace lcpbench::paper
