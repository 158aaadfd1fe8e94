#pragma once

#include "core/contact_problem.h"
#include "study/evaluation/contact_lcp.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// Why a problem's friction has no cone to be measured by, or "": why_no_round_cone() of the contacts that have other than
/// 2 directions. Those of 2 have the cone of a problem in the plane.
std::string why_no_cone(const ContactProblem& problem);

/// The conditions of the round Coulomb cone, and of its convex relaxation, at one contact, in 113 bits.
/// measure_friction() and Errors::model_error_m_per_s both use this definition.
/// @pre for all members but has_friction(): why_no_cone() is empty
///
/// f is the contact's impulse and w = J'u + offset + compliance f, each with a part along the normal (f_N) and one
/// along the tangents (f_t). M_nn is the diagonal entry of M for the normal, M_tt the larger one of the two tangents'.
class ConeFriction {
 public:
  /// @param problem, lcp  of that problem; must outlive this object
  ConeFriction(const ContactProblem& problem, ContactLcp& lcp);

  bool has_friction(Index contact) const { return edges(contact) > 0; }

  // Of a contact with friction. z has lcp.size() entries, its lambdas play no part; u = v + G* J f.

  /// | M_tt f_t - P(M_tt f_t - w_t) | [m/s], P the nearest point of the disc of radius mu M_tt max(f_N, 0).
  /// Infinity where it is not finite.
  Quad residual(Index contact, const QuadVector& z, const QuadVector& u) const;
  /// m | f - P(f - w / m) | [m/s], P the nearest point of the cone |f_t| <= mu f_N, m the larger of M_nn and M_tt: zero
  /// where the conditions of the convex model hold. Infinity where it is not finite.
  Quad convex_residual(Index contact, const QuadVector& z, const QuadVector& u) const;
  /// Sets what a WorstRow says of its contact.
  void describe(Index contact, const QuadVector& z, const QuadVector& u, WorstRow& worst) const;
  /// mu |w_t| - w_N [m/s]: at most zero where w is in the dual cone mu |w_t| <= w_N.
  Quad lack(Index contact, const QuadVector& z, const QuadVector& u) const;
  /// f'w [J].
  Quad work(Index contact, const QuadVector& z, const QuadVector& u) const;
  /// |f_t| [N s].
  Quad impulse(Index contact, const QuadVector& z) const { return impulse_of(contact, z).length(); }
  /// |J_t'u| [m/s].
  Quad slip(Index contact, const QuadVector& u) const {
    const Quad along_second = edges(contact) > 2 ? lcp_.project(second(contact), u) : Quad{0};
    return Tangential{lcp_.project(direction(contact, 0), u), along_second}.length();
  }
  /// mu f_N - |f_t| [N s].
  Quad slack(Index contact, const QuadVector& z) const;

 private:
  /// A vector along the two tangents of a contact.
  struct Tangential {
    Quad first = 0;
    Quad second = 0;

    Quad length() const;
  };

  Index edges(Index contact) const { return problem_.edges[static_cast<std::size_t>(contact)]; }
  std::size_t direction(Index contact, Index k) const;
  std::size_t second(Index contact) const { return direction(contact, edges(contact) / 4); }
  Quad normal(Index contact, const QuadVector& z) const { return z[static_cast<std::size_t>(contact)]; }
  Tangential impulse_of(Index contact, const QuadVector& z) const;
  /// w_t
  Tangential relative_slip(Index contact, const QuadVector& z, const QuadVector& u) const;
  Quad diagonal(Index contact) const;

  const ContactProblem& problem_;
  const ContactLayout& layout_;
  ContactLcp& lcp_;
};

}  // namespace lcpbench
