#pragma once

#include <array>

#include "core/contact_problem.h"

namespace lcpbench {

/// Cosine and sine of 2 pi k / edges, rounded to multiples of 2^-40 so that all machines agree. Opposite directions are
/// exact negatives, and directions along a tangent are exact. @pre edges is even and > 0, 0 <= k < edges
std::array<double, 2> edge_direction(Index k, Index edges);

/// What compliance and tangential offsets add to the rows of M z + q (see ContactProblem), in the arithmetic of Real. M
/// is not formed.
template <class Real>
class SoftRows {
 public:
  using Tangential = std::array<Real, 2>;  ///< along the two tangents of a contact

  /// @param problem, layout  must outlive this object
  SoftRows(const ContactProblem& problem, const ContactLayout& layout) : problem_(problem), layout_(layout) {}

  /// r_n
  Real normal(Index contact) const { return Real(problem_.normal_compliance(contact)); }
  /// r_t C f_D. @param impulse  impulse(i) is z_i. O(edges of the contact)
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
  /// offset_t
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
  /// r_t |C_k|^2: what compliance adds to the diagonal entry of M for direction k.
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

/// Whether every contact has r_n > 0, all compliances are finite and >= 0, and all tangential offsets are finite. If
/// mu >= 0, the problem then has a solution: M is copositive, and every solution z of LCP(0, M) has z'q = 0. For
/// 0 = z'M z >= sum r_n f_N^2 makes f_N zero, the cone rows then make f_D zero, and q is zero in the cone rows.
/// [Cottle, Pang, Stone 1992, 3.8.6]
bool every_contact_yields(const ContactProblem& problem);

/// Sets the compliances and tangential offsets of `to` to those of `contacts` in `from`, in this order.
void select_softness(const ContactProblem& from, const std::vector<Index>& contacts, ContactProblem& to);

/// A problem without compliance and tangential offsets that has the same q, M and z, but more coordinates: one for each
/// compliance r along the normal or a tangent, with the inertia 1 / r, in units in which that is about the largest
/// mass. It is exact for contacts of 0, 2 or 4 edges without tangential offsets unless G* is given; else rounded. A
/// tangential offset without compliance becomes the speed of a coordinate so heavy that it adds no more to M than about
/// the rounding of M. The first ngc coordinates are those of the problem.
ContactProblem rigid_equivalent(const ContactProblem& problem);

}  // namespace lcpbench
