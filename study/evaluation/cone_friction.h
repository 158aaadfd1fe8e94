#pragma once

#include <type_traits>
#include <vector>

#include "core/contact_problem.h"
#include "study/evaluation/contact_lcp.h"

namespace lcpbench {

/// The friction of a problem's contacts by the round Coulomb cone, in the arithmetic of Real, Quad or Bounded.
/// measure_friction() and the model's error both use this definition.
/// @pre the edges of each contact with friction are a multiple of 4
///
/// Of a contact: f its impulse, u the velocity v+, and w = u + offset + compliance f, each with a part along the normal
/// (f_N) and one along the tangents (f_t). M_tt is the larger of the diagonal entries of M for the two tangents.
template <class Real>
class ConeFriction {
 public:
  using RealVector = std::vector<Real>;

  /// @param problem, lcp  of that problem; must outlive this object
  ConeFriction(const ContactProblem& problem, ContactLcp<Real>& lcp);

  bool has_friction(Index contact) const { return edges(contact) > 0; }

  // Of a contact with friction. z has size() entries, u is the velocity v+ under z.

  /// | M_tt f_t - P(M_tt f_t - w_t) | [m/s], P the nearest point of the disc of radius mu M_tt max(f_N, 0). Infinity
  /// where a Quad is not finite. @throws Doubt where a Bounded is not
  Real residual(Index contact, const RealVector& z, const RealVector& u) const;
  /// m | f - P(f - w / m) | [m/s], P the nearest point of the cone |f_t| <= mu f_N, m the larger of M_nn and M_tt: zero
  /// where the conditions of the convex model hold. Infinity where it is not finite.
  Real convex_residual(Index contact, const RealVector& z, const RealVector& u) const
    requires std::is_same_v<Real, Quad>;
  /// mu |w_t| - w_N [m/s]: at most zero where w is in the dual cone mu |w_t| <= w_N.
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
  /// w_t
  Tangential relative_slip(Index contact, const Tangential& f, const RealVector& u) const;
  Real diagonal(Index contact) const;

  const ContactProblem& problem_;
  const ContactLayout& layout_;
  ContactLcp<Real>& lcp_;
};

}  // namespace lcpbench
