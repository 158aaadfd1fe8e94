#pragma once

#include "core/problem.h"
#include "core/solver.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// Compares the post-impact velocities of two answers to one problem that has only one such velocity.
///
/// Without friction and with positive definite G, v+ is unique even if z is not. For two answers z and y with their
/// complements w = M z + q and x = M y + q,
///
///     ||v+(z) - v+(y)||_G^2  <=  z'w + y'x - z'x - y'w,
///
/// with equality for rigid contacts. The residuals of the two answers bound the right-hand side. The velocities may
/// differ by the root of this bound, and for rounding by ngc eps cond(G) of the norms of both and of v, and by nc eps
/// of the velocities that the impulses make one by one, which may cancel. The velocity of an answer is the one that its
/// solver returned, where that has ngc entries; else it follows from z.
class VelocityAgreement {
 public:
  /// O(ngc^3), and so is side(). @pre applies()
  explicit VelocityAgreement(const Problem& problem);

  /// Above this the eigenvalues of G are not computed, and nothing is compared.
  static constexpr Index kLargest = 300;

  /// Whether the problem has one post-impact velocity by theory, and a size at which it is compared.
  /// @param definite  the problem is solvable by Evaluator::truth: unless all contacts yield, G is then definite
  static bool applies(const Problem& problem, bool definite);

  /// What agree() compares of one answer, whose errors are usable.
  struct Side {
    Vector velocity;             ///< ngc, in coordinates in which the norm of G is the Euclidean one
    double cancelled = 0;        ///< at least sum |z_i| ||G* N_i||_G
    double impulses = 0;         ///< sum |z_i|
    double slacks = 0;           ///< sum |w_i|
    double complementarity = 0;  ///< |z'w|
    double violation = 0;        ///< max(0, -min w)
    double negativity = 0;       ///< max(0, -min z)
  };
  Side side(const Answer& answer, const Errors& errors) const;

  /// False when they lie further apart than allowed, or a velocity is NaN.
  bool agree(const Side& a, const Side& b) const;

 private:
  Vector whiten(const Vector& velocity) const;

  Problem problem_;
  Matrix factor_;               ///< lower Cholesky factor of G, or of G* where only that is known
  bool inverse_ = false;        ///< factor_ is that of G*
  double rounding_ = 0;         ///< ngc eps cond(G)
  double mobility_ = 0;         ///< the largest ||G* u||_G over |u|
  double velocity_before_ = 0;  ///< ||v||_G
};

}  // namespace lcpbench
