#pragma once

#include <algorithm>

namespace lcpbench {

/// What the residuals of an island of contacts are relative to: an error of 1 is as bad as no impulses at all. In
/// double or in 113 bits. All sizes are velocities [m/s].
template <class Real>
struct ContactScale {
  static constexpr double kSpeedShare = 1e-6;     ///< of `speed`, at least
  static constexpr double kLeast = 1e-8;          ///< [m/s], at least: below 1e-12 m/s nothing is ever wrong
  static constexpr double kRoundingShare = 1e-4;  ///< a residual of `rounding` is not more than this

  Real without = 0;   ///< the residual of no impulses: of pyramid and cone the largest -q_i of the normal rows
  Real speed = 0;     ///< the largest |J_i'v| of the impulse rows
  Real rounding = 0;  ///< the largest error of forming a J_i'v in double

  /// A row J_i'v of `entries` terms whose magnitudes sum to `terms`.
  void add_row(Real velocity, Real terms, double entries) {
    speed = std::max(speed, velocity < 0 ? -velocity : velocity);
    rounding = std::max(rounding, Real{entries + 1} * (Real{0x1p-53} * terms + Real{0x1p-1074}));
  }
  /// q_i of a normal row, with its offset.
  void add_approach(Real q) { without = std::max(without, -q); }

  Real value() const {
    return std::max({without, Real{kSpeedShare} * speed, Real{kLeast}, rounding / Real{kRoundingShare}});
  }
};

}  // namespace lcpbench
