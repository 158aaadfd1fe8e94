#pragma once

#include "core/problem.h"
#include "core/solver.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// Compares the post-impact velocities of two answers to one problem that has only one such velocity.
///
/// Frictionless contacts and positive definite G: v+ is the projection of v, in the metric of G, on the velocities that
/// penetrate nothing, and so unique, however many z there are. For two answers z and y with complements w and x,
///
///     ||v+(z) - v+(y)||_G^2  =  z'w + y'x - z'x - y'w,
///
/// so two answers that nearly hold can differ by at most the sum of their residuals. They are allowed this difference,
/// and n eps cond(G) for rounding. The velocity of an answer is the one that its solver returned, where it
/// did; else it follows from z.
class VelocityAgreement {
 public:
  /// O(ngc^3). @pre a frictionless contact problem, G positive definite, ngc <= kLargest.
  explicit VelocityAgreement(const Problem& problem);

  /// Above this the eigenvalues of G are not computed, and nothing is compared.
  static constexpr Index kLargest = 300;

  /// Whether the problem has one post-impact velocity by theory, and a size at which it is compared.
  /// @param definite  G is proven positive definite (see Evaluator::truth)
  static bool applies(const Problem& problem, bool definite);

  /// One answer as it is compared: usable, with the measures of its z.
  struct Side {
    Vector velocity;             ///< ngc, in coordinates in which the norm of G is the Euclidean one
    double impulses = 0;         ///< sum |z_i|
    double slacks = 0;           ///< sum |w_i|
    double complementarity = 0;  ///< |z'w|
    double violation = 0;        ///< max(0, -min w)
    double negativity = 0;       ///< max(0, -min z)
  };
  Side side(const Answer& answer, const Errors& errors) const;

  /// False when they lie further apart than allowed, or anything is NaN.
  bool agree(const Side& a, const Side& b) const;

 private:
  Vector whiten(const Vector& velocity) const;

  Problem problem_;
  Matrix factor_;               ///< lower Cholesky factor of G, or of G* where only that is known
  bool inverse_ = false;        ///< factor_ is that of G*
  double rounding_ = 0;         ///< n eps cond(G)
  double velocity_before_ = 0;  ///< ||v||_G
};

}  // namespace lcpbench
