#pragma once

#include <vector>

#include "core/types.h"

namespace lcpbench {

/// The bounds of a mixed LCP, n entries each; none where z >= 0 is all that is asked for.
///
/// Then lower_i <= z_i <= upper_i, and w_i >= 0 where z_i is at its lower bound, <= 0 at its upper, = 0 between. Row i
/// with friction_of_i = j >= 0 has the bounds -mu_i z_j and mu_i z_j of the same z: the box of friction that ODE,
/// Bullet and DART have, at a fixed point of the iteration over its limits. It is a model of its own, no pyramid and no
/// cone.
struct LcpBounds {
  static constexpr double kNoBound = 1e20;

  Vector lower;                  ///< -infinity: none, as in rows of friction
  Vector upper;                  ///< infinity: none
  std::vector<int> friction_of;  ///< -1: bounded by lower and upper
  Vector mu;                     ///< >= 0; 0 without friction_of

  /// z >= 0 for n rows.
  static LcpBounds nonnegative(Index n);
  bool is_free(Index i) const;
  /// Those of a part of the rows, in this order. Friction of a row that is left out is zero.
  LcpBounds of_rows(const std::vector<Index>& rows) const;
  /// Without entries where they are those of nonnegative().
  void simplify();
  /// Takes bounds of kNoBound and more as none, which is how other programs write them; returns how many it took so.
  Index drop_huge();
  /// Whether a row has two bounds, or those of friction.
  bool needs_slacks() const;
};

/// LCP(q, M): find z >= 0 with w = M z + q >= 0 and z'w = 0. [Cottle, Pang, Stone 1992, (1.1.1)] With bounds it is
/// mixed.
struct Lcp {
  Matrix M;  ///< n x n
  Vector q;  ///< n
  LcpBounds bounds{};
  Index dropped_bounds = 0;  ///< that were read as none, see LcpBounds::drop_huge()

  Index size() const { return q.size(); }
  bool is_mixed() const { return bounds.lower.size() > 0; }
};

}  // namespace lcpbench
