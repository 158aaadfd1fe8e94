#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/answer/contact_residual.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// Measures the velocity that an answer comes with by the one that its z implies.
class ReturnedVelocity {
 public:
  /// @param v_plus  implied by z. @param contact, z, v_plus  must outlive this object.
  ReturnedVelocity(ContactResidual& contact, const QuadVector& z, const QuadVector& v_plus)
      : contact_(contact), z_(z), v_plus_(v_plus) {}

  /// Sets Errors::returned_velocity_error and velocity_mismatch, and what follows from them.
  /// @returns false where that takes a G* that 113 bits do not tell
  bool measure(const Vector& returned, Errors& errors);

 private:
  double mismatch(const Vector& returned) const;
  /// Sums over an island.
  struct IslandImpulses {
    Quad energy = 0;   ///< v'G v; 0 where only G* is known
    Quad size = 0;     ///< its root + sum_j sqrt(M_jj) |f_j|
    double count = 0;  ///< of the f_j that are not zero
    double coordinates = 0;
    Quad change = 0;  ///< the largest sqrt(G_ii) |v+ - v|_i
  };
  /// The part of the scales that all coordinates share.
  struct ImpulseScale {
    QuadVector generalized;  ///< |J| |f|
    QuadVector inertial;     ///< |G| |v+ - v|; zeros where only G* is known
    QuadVector root;         ///< sqrt(G_ii); none where only G* is known
    IslandNumbers numbers;
    std::vector<IslandImpulses> islands;  ///< at k + 1 that of number k; at 0 the coordinates that no contact moves
  };
  /// Of row i of |G*| the products with `generalized` and with `inertial`; and G*_ii.
  struct Response {
    Quad to_impulses = 0, to_inertia = 0, own = 0;
  };
  const ImpulseScale& impulse_scale();
  Response respond(std::size_t coordinate);
  Quad rounding(std::size_t coordinate, const Response& response);
  Quad scale_of(std::size_t coordinate);

  ContactResidual& contact_;
  const QuadVector& z_;
  const QuadVector& v_plus_;
  std::optional<ImpulseScale> impulse_scale_;  // made by impulse_scale()
};

}  // namespace lcpbench
