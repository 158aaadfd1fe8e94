#pragma once

#include <memory>
#include <optional>

#include "core/solver.h"
#include "core/quad_inertia.h"
#include "study/evaluation/quad_lcp.h"
#include "study/stability/transformations.h"

namespace lcpbench {

/// Takes the physical answers from answers to one problem.
class PhysicalAnswers {
 public:
  explicit PhysicalAnswers(const Problem& problem);

  /// Contact problem: the velocity returned, else v + G* J f, of z in 113 bits. Bare LCP: z. @pre z is usable
  Vector of(const Answer& answer);

 private:
  Problem problem_;
  std::unique_ptr<QuadInertia> inertia_;
  std::unique_ptr<ContactQuadLcp> lcp_;
};

/// How far physical answers to one problem lie apart, in a norm that no unit changes.
class Distance {
 public:
  /// @param unique  the problem has one physical answer by theory; see stability()
  Distance(const Problem& problem, bool unique);

  bool unique() const { return unique_; }
  /// Relative. NaN where nothing can be said (no velocity before the impact).
  double operator()(const Vector& a, const Vector& b) const;
  /// The change that conditioning allows per unit of change of the data; at least 1. Only for unique answers.
  double condition() const { return condition_; }

 private:
  Vector coordinates(const Vector& difference) const;

  bool unique_ = false;
  bool bare_ = false;
  bool inverse_ = false;
  Matrix factor_;     ///< lower Cholesky factor of G, or of G*; N' where the answer is not unique
  double scale_ = 0;  ///< of the velocity before the impact
  double condition_ = 1;
};

/// Largest over smallest nonzero eigenvalue of a symmetric matrix of doubles with unit diagonal. Up to kLargestQuad
/// rows in 113 bits, so that only true zeros are left out; above, all below 8 n eps of the norm are.
double scaled_condition(const Matrix& symmetric);

}  // namespace lcpbench
