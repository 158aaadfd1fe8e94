#pragma once

namespace lcpbench {

/// What the residuals of an island of contacts are relative to: an error of 1 is as bad as no impulses at all. In
/// double or in 113 bits. All sizes are velocities [m/s]. Inlined everywhere: the kernels for each instruction set use
/// it, and no instance of one may be linked into another.
template <class Real>
struct ContactScale {
  static constexpr double kSpeedShare = 1e-6;     ///< of `speed`, at least
  static constexpr double kLeast = 1e-8;          ///< [m/s], at least: below 1e-12 m/s nothing is ever wrong
  static constexpr double kRoundingShare = 1e-4;  ///< a residual of `rounding` is not more than this

  Real without = 0;   ///< the residual of no impulses: of pyramid and cone the largest -q_i of the normal rows
  Real speed = 0;     ///< the largest |J_i'v| of the impulse rows
  Real rounding = 0;  ///< the largest error of forming a J_i'v in double

  /// A row J_i'v of `entries` terms whose magnitudes sum to `terms`.
  [[gnu::always_inline]] void add_row(Real velocity, Real terms, double entries) {
    raise(speed, velocity < 0 ? -velocity : velocity);
    raise(rounding, static_cast<Real>(entries + 1) * (static_cast<Real>(0x1p-53) * terms + static_cast<Real>(0x1p-1074)));
  }
  /// q_i of a normal row, with its offset.
  [[gnu::always_inline]] void add_approach(Real q) { raise(without, -q); }

  /// What counts at least, whatever no impulses leave.
  [[gnu::always_inline]] Real floor() const {
    Real floor = static_cast<Real>(kLeast);
    raise(floor, static_cast<Real>(kSpeedShare) * speed);
    raise(floor, rounding / static_cast<Real>(kRoundingShare));
    return floor;
  }
  [[gnu::always_inline]] Real value() const {
    Real value = floor();
    raise(value, without);
    return value;
  }

 private:
  /// To infinity by a NaN: data beyond the range of the type tell nothing.
  [[gnu::always_inline]] static void raise(Real& largest, Real x) {
    if (!(x <= largest)) largest = x > largest ? x : static_cast<Real>(__builtin_inf());
  }
};

}  // namespace lcpbench
