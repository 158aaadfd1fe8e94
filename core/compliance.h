#pragma once

#include <array>

#include "core/contact_problem.h"

namespace lcpbench {

/// Cosine and sine of 2 pi k / edges, to multiples of 2^-40 so that every machine has the same; of opposite directions
/// exactly opposite, and exact along the tangents.
std::array<double, 2> edge_direction(Index k, Index edges);

/// What compliance and tangential offsets add to rows of M z + q, in the arithmetic of Real. M is not formed.
template <class Real>
class SoftRows {
 public:
  using Tangential = std::array<Real, 2>;  ///< along the two tangents of a contact

  /// @param problem, layout  must outlive this object
  SoftRows(const ContactProblem& problem, const ContactLayout& layout) : problem_(problem), layout_(layout) {}

  /// r_n
  Real normal(Index contact) const { return Real(problem_.normal_compliance(contact)); }
  /// r_t C f_D. @param impulse  z by its index
  template <class Impulse>
  Tangential yielding(Index contact, const Impulse& impulse) const {
    Tangential net{Real(0.0), Real(0.0)};
    const double compliance = problem_.tangential_compliance(contact);
    for (Index k = 0; compliance != 0 && k < edges(contact); ++k) {
      const std::array<double, 2> direction = edge_direction(k, edges(contact));
      const Real f(impulse(layout_.friction_offset() + begin(contact) + k));
      net[0] += Real(direction[0]) * f;
      net[1] += Real(direction[1]) * f;
    }
    return {Real(compliance) * net[0], Real(compliance) * net[1]};
  }
  Tangential offset(Index contact) const {
    return {Real(problem_.tangential_offset(contact, 0)), Real(problem_.tangential_offset(contact, 1))};
  }
  /// C_k'x for the contact's direction k.
  Real along(Index contact, Index k, const Tangential& x) const {
    const std::array<double, 2> direction = edge_direction(k, edges(contact));
    Real sum = Real(direction[0]) * x[0];
    sum += Real(direction[1]) * x[1];
    return sum;
  }
  /// How many terms softness adds to the sum that is w of direction k, for bounds on its rounding: one for each tangent
  /// that the direction goes along. In the rigid equivalent they are entries of J.
  int terms(Index contact, Index k) const {
    const std::array<double, 2> direction = edge_direction(k, edges(contact));
    int count = 0;
    for (const int tangent : {0, 1}) {
      const bool acts =
          problem_.tangential_compliance(contact) != 0 || problem_.tangential_offset(contact, tangent) != 0;
      if (acts && direction[static_cast<std::size_t>(tangent)] != 0) ++count;
    }
    return count;
  }
  /// r_t |C_k|^2, the part of M_ii for direction k.
  Real diagonal(Index contact, Index k) const {
    const std::array<double, 2> direction = edge_direction(k, edges(contact));
    const Real compliance(problem_.tangential_compliance(contact));
    return along(contact, k, {compliance * Real(direction[0]), compliance * Real(direction[1])});
  }

 private:
  Index begin(Index contact) const { return layout_.friction_begin[static_cast<std::size_t>(contact)]; }
  Index edges(Index contact) const { return problem_.edges[static_cast<std::size_t>(contact)]; }

  const ContactProblem& problem_;
  const ContactLayout& layout_;
};

/// Whether every contact has r_n > 0, and all softness is valid. If mu >= 0 there is a solution then: M is copositive,
/// and a solution of LCP(0, M) has no impulses, because w_N'f_N >= r_n |f_N|^2 makes f_N zero, and then friction is
/// zero, too. [Cottle, Pang, Stone 1992, 3.8.6]
bool every_contact_yields(const ContactProblem& problem);

/// Gives `to` the compliance and the tangential offsets that these contacts have in `from`.
void select_softness(const ContactProblem& from, const std::vector<Index>& contacts, ContactProblem& to);

/// The problem of the same z without compliance: coordinates of its own carry what a soft contact gives way. They have
/// the inertia 1 / r, in units in which that is about the largest mass. It is exact for contacts of 0, 2 or 4 edges
/// without tangential offsets, else rounded. A tangential offset without compliance is the speed of a coordinate that
/// impulses move by no more than the rounding of M. The first ngc coordinates are those of the problem.
ContactProblem rigid_equivalent(const ContactProblem& problem);

/// Whether the impulses of z change the speeds of tangential offsets without compliance by no more than a millionth:
/// where a contact moves next to nothing else, very large impulses would change them in the rigid equivalent alone.
bool creeps_as_given(const ContactProblem& problem, const ContactProblem& rigid, const Vector& z);

}  // namespace lcpbench
