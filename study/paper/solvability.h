#pragma once

namespace lcpbench::paper {

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
