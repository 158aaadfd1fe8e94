#pragma once

#include <string>

#include "core/answer/contact_lcp.h"
#include "core/answer/residual.h"
#include "core/contact_problem.h"

namespace lcpbench {

/// Why a problem's friction has no cone to be measured by, or "": why_no_round_cone() of the contacts that have other
/// than 2 directions. Those of 2 have the cone of a problem in the plane.
std::string why_no_cone(const ContactProblem& problem);

/// The conditions of the round Coulomb cone, and of its convex relaxation, at one contact, in 113 bits.
/// @pre for all members but has_friction(): why_no_cone() is empty
///
/// f is the contact's impulse and w = J'u + offset + compliance f, each with a part along the normal (f_N) and one
/// along the tangents (f_t). M_nn is the diagonal entry of M for the normal, M_tt the larger one of the two tangents'.
/// z has lcp.size() entries, its lambdas play no part; u = v + G* J f.
class ConeFriction {
 public:
  using Vector2 = Tangential<Quad>;

  /// @param problem, lcp  of that problem; must outlive this object
  ConeFriction(const ContactProblem& problem, ContactLcp& lcp) : problem_(problem), layout_(lcp.layout()), lcp_(lcp) {}

  bool has_friction(Index contact) const { return edges(contact) > 0; }

  // Of a contact with friction.

  /// friction_residual() [m/s]. Infinity where it is not finite.
  Quad residual(Index contact, const QuadVector& z, const QuadVector& u) const;
  /// convex_residual() with the larger of M_nn and M_tt [m/s]. Infinity where it is not finite.
  Quad convex_residual(Index contact, const QuadVector& z, const QuadVector& u) const;
  /// f_t [N s].
  Vector2 impulse(Index contact, const QuadVector& z) const;
  /// w_t [m/s].
  Vector2 slip(Index contact, const QuadVector& z, const QuadVector& u) const;
  /// w_N [m/s].
  Quad separation(Index contact, const QuadVector& z, const QuadVector& u) const {
    return lcp_.velocity(static_cast<std::size_t>(contact), z, u);
  }
  /// mu |w_t| - w_N [m/s]: at most zero where w is in the dual cone mu |w_t| <= w_N.
  Quad lack(Index contact, const QuadVector& z, const QuadVector& u) const {
    return Quad{problem_.mu(contact)} * slip(contact, z, u).length() - separation(contact, z, u);
  }
  /// f'w [J].
  Quad work(Index contact, const QuadVector& z, const QuadVector& u) const {
    return normal(contact, z) * separation(contact, z, u) + impulse(contact, z).dot(slip(contact, z, u));
  }
  /// |J_t'u| [m/s].
  Quad speed(Index contact, const QuadVector& u) const {
    const Quad along_second = edges(contact) > 2 ? lcp_.project(second(contact), u) : Quad{0};  // in the plane: none
    return Vector2{lcp_.project(direction(contact, 0), u), along_second}.length();
  }
  /// mu f_N - |f_t| [N s].
  Quad slack(Index contact, const QuadVector& z) const {
    return Quad{problem_.mu(contact)} * normal(contact, z) - impulse(contact, z).length();
  }

 private:
  Index edges(Index contact) const { return problem_.edges[static_cast<std::size_t>(contact)]; }
  std::size_t direction(Index contact, Index k) const {
    return static_cast<std::size_t>(layout_.friction_offset() +
                                    layout_.friction_begin[static_cast<std::size_t>(contact)] + k);
  }
  std::size_t second(Index contact) const { return direction(contact, edges(contact) / 4); }
  Quad normal(Index contact, const QuadVector& z) const { return z[static_cast<std::size_t>(contact)]; }
  Quad diagonal(Index contact) const;

  const ContactProblem& problem_;
  const ContactLayout& layout_;
  ContactLcp& lcp_;
};

}  // namespace lcpbench
