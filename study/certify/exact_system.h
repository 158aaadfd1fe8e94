#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/contact_problem.h"
#include "core/lcp.h"
#include "study/certify/deadline.h"
#include "study/certify/integers.h"

namespace lcpbench::exact {

struct Term {
  Index column = 0;
  Integer value;
};

/// A complementarity problem over the integers: find p (k) and z (n) >= 0 with
///
///     K p = L z,   w = q + R'p + S z >= 0,   z'w = 0.
///
/// A bare LCP has k = 0 and S = M. A contact problem keeps its inertia in K, so that no inverse is ever formed. The
/// numbers are the problem's own times powers of two: p = 2^p_exponent p', z_i = 2^z_exponent[i] z'_i, w_i =
/// 2^w_exponent[i] w'_i.
struct ExactSystem {
  IntegerMatrix K;                   ///< k x k
  IntegerMatrix L;                   ///< k x n
  IntegerMatrix R;                   ///< k x n
  std::vector<std::vector<Term>> S;  ///< n rows
  IntegerVector q;                   ///< n
  slong p_exponent = 0;
  std::vector<slong> z_exponent;  ///< n
  std::vector<slong> w_exponent;  ///< n

  Index size() const { return static_cast<Index>(q.size()); }
  Index potentials() const { return K.rows(); }  ///< k entries of p, the change of velocity in some coordinates
};

/// p / denominator and z / denominator; denominator > 0.
struct ExactPoint {
  IntegerVector p;
  IntegerVector z;
  Integer denominator{1};
};

/// The inertia of a contact problem in the form that ExactSystem takes: K p = (left C) f, w = q + (right C)'p, and the
/// change of velocity is Y p.
struct ExactInertia {
  Dyadic K;
  std::optional<Dyadic> left;      ///< k x ngc; none: the identity
  std::optional<Dyadic> right;     ///< k x ngc; none: the identity
  std::optional<Dyadic> velocity;  ///< Y, ngc x k; none: the identity
  bool semidefinite = false;       ///< proven: M restricted to impulses is symmetric positive semidefinite
  bool full_rank = false;          ///< proven, for independent factors: G* C f = 0 only where C f = 0
  std::string refusal;             ///< why nothing can be certified; "" where it can
};

/// The factors with alpha other than 0.
std::vector<Index> weighted_factors(const FactoredInertia& inertia);

// Functions that take a deadline @throw TimePassed.

/// The weighted factors that do not depend on those before (dependence is tested modulo a prime:
/// an independent column may be taken for dependent, never the reverse).
std::vector<Index> independent_factors(const FactoredInertia& inertia, const Deadline& deadline);

/// @param factors  of a FactoredInertia, the columns of X that span its range; ignored by the other forms.
ExactInertia exact_inertia(const Inertia& inertia, const std::vector<Index>& factors, const Deadline& deadline);

/// C'v, plus the offsets in its first rows. @param offsets  one column of entries, no more than C has columns
Dyadic velocities_before(const Dyadic& C, const Dyadic& v, const Dyadic& offsets, const Deadline& deadline);

/// The frictionless system of the columns of C and of q, one entry for each: S = 0.
ExactSystem frictionless_system(const ExactInertia& inertia, const Dyadic& C, const Dyadic& q,
                                const Deadline& deadline);

/// The whole system of a contact problem, cone rows and compliance included.
ExactSystem contact_system(const ContactProblem& problem, const ExactInertia& inertia, const Deadline& deadline);

/// The edges of all friction cones as columns: N_i of every contact, then N_i + mu_i D_t of every friction column t.
Dyadic cone_edges(const ContactProblem& problem);
/// What the velocity along each edge is offset by: b_i, and b_i + mu_i times the offset along D_t. No rows where the
/// problem has none.
Dyadic offsets_of_edges(const ContactProblem& problem);

ExactSystem bare_system(const Lcp& lcp);

}  // namespace lcpbench::exact
