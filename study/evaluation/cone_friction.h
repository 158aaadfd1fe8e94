#pragma once

#include <type_traits>
#include <vector>

#include "core/contact_problem.h"
#include "study/evaluation/contact_lcp.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// The conditions of the round Coulomb cone, and of its convex relaxation, at one contact, in the arithmetic of Real,
/// Quad or Bounded. measure_friction() and Errors::model_error_m_per_s both use this definition.
/// @pre for all members but has_friction(): why_no_round_cone() is empty
///
/// f is the contact's impulse and w = J'u + offset + compliance f, each with a part along the normal (f_N) and one
/// along the tangents (f_t). M_nn is the diagonal entry of M for the normal, M_tt the larger one of the two tangents'.
template <class Real>
class ConeFriction {
 public:
  using RealVector = std::vector<Real>;

  /// @param problem, lcp  of that problem; must outlive this object
  ConeFriction(const ContactProblem& problem, ContactLcp<Real>& lcp);

  bool has_friction(Index contact) const { return edges(contact) > 0; }

  // Of a contact with friction. z has lcp.size() entries; u is the generalized velocity v + G* J f.

  /// | M_tt f_t - P(M_tt f_t - w_t) | [m/s], P the nearest point of the disc of radius mu M_tt max(f_N, 0). A Quad that
  /// is not finite becomes infinity. @throws Doubt where a Bounded is not finite
  Real residual(Index contact, const RealVector& z, const RealVector& u) const;
  /// m | f - P(f - w / m) | [m/s], P the nearest point of the cone |f_t| <= mu f_N, m the larger of M_nn and M_tt: zero
  /// where the conditions of the convex model hold. Infinity where it is not finite.
  Real convex_residual(Index contact, const RealVector& z, const RealVector& u) const
    requires std::is_same_v<Real, Quad>;
  /// Sets what a WorstRow says of its contact.
  void describe(Index contact, const RealVector& z, const RealVector& u, WorstRow& worst) const
    requires std::is_same_v<Real, Quad>;
  /// mu |w_t| - w_N [m/s]: at most zero where w is in the dual cone mu |w_t| <= w_N.
  Real lack(Index contact, const RealVector& z, const RealVector& u) const;
  /// f'w [J].
  Real work(Index contact, const RealVector& z, const RealVector& u) const;
  /// |f_t| [N s].
  Real impulse(Index contact, const RealVector& z) const { return impulse_of(contact, z).length(); }
  /// |J_t'u| [m/s].
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
