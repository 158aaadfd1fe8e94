#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "study/evaluation/quad_lcp.h"

namespace lcpbench {

/// The friction of the contacts of a problem by the round Coulomb cone, in the arithmetic of Real, Quad or Bounded:
/// the one definition of measure_cone() and of the model's error. Contacts with friction have multiples of 4 edges.
template <class Real>
class ConeFriction {
 public:
  using RealVector = std::vector<Real>;

  /// @param problem, lcp  of that problem; must outlive this object
  ConeFriction(const ContactProblem& problem, ContactLcp<Real>& lcp);

  bool has_friction(Index contact) const { return edges(contact) > 0; }
  /// | M_tt f_t - P(M_tt f_t - u_t) | [m/s] of a contact with friction. What is not finite is infinite, and a Bounded
  /// then in doubt. @param z  size() entries @param u  the velocity v+ under z
  Real residual(Index contact, const RealVector& z, const RealVector& u) const;
  /// m | f - P(f - w / m) | [m/s] of a contact with friction: P the nearest point of the cone |f_t| <= mu f_N, w its
  /// relative velocity with offsets and compliance, m the larger of M_nn and M_tt. The conditions of the convex model.
  Real convex_residual(Index contact, const RealVector& z, const RealVector& u) const;
  /// What w has to have more along the normal for mu |w_t| <= w_N [m/s], or less.
  Real lack(Index contact, const RealVector& z, const RealVector& u) const;
  /// f'w [J].
  Real work(Index contact, const RealVector& z, const RealVector& u) const;
  /// |f_t| [N s].
  Real impulse(Index contact, const RealVector& z) const { return impulse_of(contact, z).length(); }
  /// |u_t| [m/s].
  Real slip(Index contact, const RealVector& u) const { return slip_of(contact, u).length(); }
  /// mu f_N - |f_t| [N s].
  Real slack(Index contact, const RealVector& z) const;

 private:
  /// A vector along the two tangents of a contact.
  struct Tangential {
    Real first = 0;
    Real second = 0;

    Real length() const;
  };

  Index edges(Index contact) const { return problem_.edges[static_cast<std::size_t>(contact)]; }
  std::size_t direction(Index contact, Index k) const;
  Real normal(Index contact, const RealVector& z) const { return z[static_cast<std::size_t>(contact)]; }
  bool impulse_free(Index contact, const RealVector& z) const;
  Tangential impulse_of(Index contact, const RealVector& z) const;
  Tangential slip_of(Index contact, const RealVector& u) const;
  /// w_t: with the offset and what the contact yields.
  Tangential relative_slip(Index contact, const Tangential& f, const RealVector& u) const;
  Real diagonal(Index contact) const;

  const ContactProblem& problem_;
  const ContactLayout& layout_;
  ContactLcp<Real>& lcp_;
};

}  // namespace lcpbench
