#pragma once

#include "study/certify/deadline.h"
#include "study/certify/exact_system.h"

namespace lcpbench::exact {

// Proofs by multiplication alone; nothing here knows how the vectors were found. Those that take a deadline
// @throw TimePassed.

/// K p = L z, z >= 0, w = q + R'p + S z >= 0, z'w = 0.
bool is_solution(const ExactSystem& system, const ExactPoint& point, const Deadline& deadline);

/// u >= 0, L u = 0, S'u <= 0, q'u < 0. For a system without potentials, and for one of contacts, whose R'K^-1 L is
/// symmetric, this contradicts w >= 0: u'w <= q'u whatever z >= 0. @param u  n entries
bool is_contradiction(const ExactSystem& system, const IntegerVector& u, const Deadline& deadline);

/// Whether the velocity v + Y p has N_i'(v + Y p) + b_i >= mu_i max_t(-D_t'(v + Y p), 0) at every contact i: then no f
/// in the friction cones with C f in null(G) has q'f < 0, and, G being semidefinite and mu >= 0, the problem is
/// solvable.
/// [Cottle, Pang, Stone 1992, Thm 3.8.6: M is copositive, and q is nonnegative on the solutions of LCP(0, M)]
bool is_solvability_proof(const ExactSystem& contact, const ContactProblem& problem, const ExactPoint& point,
                          const Deadline& deadline);

/// w_i = q_i + R_i'p + S_i z, times the denominator.
Integer complement(const ExactSystem& system, const ExactPoint& point, Index i);

/// Whether p / denominator is the same for both.
bool same_potential(const ExactPoint& a, const ExactPoint& b);

}  // namespace lcpbench::exact
