#pragma once

#include <string>
#include <vector>

#include "core/problem.h"
#include "study/certify/deadline.h"
#include "study/certify/integers.h"
#include "study/certify/row_unknowns.h"

namespace lcpbench::exact {

/// p and z over one denominator > 0: [denominator; p; z].
using Point = IntegerMatrix;

/// A complementarity problem over the integers: find p (k) and z (n) >= 0 with
///
///     [c K -L] [1; p; z] = 0,   w = [q R' S] [1; p; z] >= 0,   z'w = 0.
///
/// A bare LCP has k = 0 and S = M. A contact problem keeps its inertia in K, so that no inverse is ever formed. p and z
/// are in the problem's units. c is zero but for bounded rows with bounds that are not: z is then that of RowUnknowns.
struct ExactSystem {
  Index potentials = 0;          ///< k, entries of the change of velocity in some coordinates
  Index size = 0;                ///< n
  IntegerMatrix rows{};          ///< (k + n) x (1 + k + n), each without its powers of two
  std::vector<slong> exponents;  ///< of these powers

  ExactSystem() = default;
  /// @param w,more_w  the rows of w
  ExactSystem(Dyadic equations, Dyadic w, Dyadic more_w = {});

  Index row_of(Index i) const { return potentials + i; }         ///< of w_i
  Index column_of(Index i) const { return 1 + potentials + i; }  ///< of z_i
  /// @returns [K p - L z; w] times the denominator, each row in a unit of its own
  IntegerMatrix values(const Point& point, const Deadline& deadline) const;
  /// [q R' S], but for one power of two.
  IntegerMatrix w_in_one_unit() const;
};

/// The system of a problem, and what is proven of its inertia. With C = [N D R], the inertia is K p = B f for impulses
/// f, and the change of velocity is Y p; docs/explanation/certificates.md has them for each form.
struct ExactProblem {
  /// @throws TimePassed
  ExactProblem(const Problem& problem, const Deadline& deadline);

  ExactSystem system;
  Dyadic v, K, B, R, q;       ///< contacts only, as all below: v before the impact, w = q + R p for impulses of zero
  Dyadic shape;               ///< Y
  std::optional<RowUnknowns> rows;  ///< where there are bounded rows
  bool semidefinite = false;  ///< proven: M restricted to impulses is symmetric positive semidefinite
  bool full_rank = false;     ///< proven: G* C f = 0 only where C f = 0
  std::string refusal;        ///< why nothing can be certified; "" where it can. Else there is no system
};

/// The frictionless system whose contacts are the edges of all friction cones: N_i of every contact i, in the place of
/// i, and N_i + mu_i D_t of every friction column t. @throws TimePassed
ExactSystem edge_system(const ContactProblem& contact, const ExactProblem& problem, const Deadline& deadline);

// Proofs by multiplication alone; nothing here knows how the vectors were found.

/// @param values  system.values(point)
bool is_solution(const ExactSystem& system, const Point& point, const IntegerMatrix& values);

/// u >= 0, L u = 0, S'u <= 0, q'u < 0, in the problem's units. For a system without potentials, and for one of
/// contacts, whose R'K^-1 L is symmetric, this contradicts w >= 0: u'w <= q'u whatever z >= 0. c does not count, as
/// u'R'K^-1 c is the impulses of c times K^-1 L u.
bool is_contradiction(const ExactSystem& system, const IntegerMatrix& u);

/// Whether after the shift of the velocity by Y p the velocities w of the edges are >= 0, but for contacts with r_n >
/// 0, and for the friction edges of those of at most 4 with r_t > 0: then no f in the friction cones with C f in
/// null(G) has q'f < 0, and, G being semidefinite and mu >= 0, the problem is solvable. [Cottle, Pang, Stone 1992,
/// Thm 3.8.6: M is copositive, and q is nonnegative on the solutions of LCP(0, M)]
/// @param values  edges.values() of a point with this p and z = 0
bool is_solvability_proof(const ContactProblem& contact, const ExactSystem& edges, const IntegerMatrix& values);

}  // namespace lcpbench::exact
