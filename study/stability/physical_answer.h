#pragma once

#include <memory>

#include "core/answer/contact_lcp.h"
#include "core/solver.h"

namespace lcpbench {

/// What a solver's answer to one problem means physically: of contacts the velocity after the impact, of a bare LCP z
/// itself.
class PhysicalAnswers {
 public:
  /// Takes contacts' G* in 113 bits, in O(ngc^3). @param problem  shared, its data are not copied
  explicit PhysicalAnswers(const Problem& problem);

  /// The velocity that the answer has, else v + G* J f of its z in 113 bits. @pre z has n finite entries, and G* is
  /// known (RefinedInertia::well_defined): an answer that passed as solved has both
  Vector of(const Answer& answer) const;

  /// The relative change from one physical answer to another: of contacts ||b - a||_G over the larger of ||v||_G and
  /// ||a||_G, which no choice of units changes, and max|b - a| / max|a| of a bare LCP. Only with offsets b is a the
  /// larger one.
  double change(const Vector& a, const Vector& b) const;

  /// The factor by which conditioning lets a relative change of the data grow: of contacts the larger of the conditions
  /// of G and of J'G*J (see response_condition; of G alone where that is NaN), of a bare LCP the condition of M + M',
  /// each with unit diagonal.
  double condition() const;

 private:
  double length(const Vector& velocity) const;

  Problem problem_;
  std::unique_ptr<RefinedInertia> inertia_;
  std::unique_ptr<ContactLcp> lcp_;
};

/// Largest over smallest nonzero eigenvalue of a symmetric matrix of doubles, scaled to unit diagonal. Up to
/// kLargestQuad rows they are found in 113 bits, so that only true zeros count as zero. Above, those below 8 n eps of
/// the norm do.
double scaled_condition(const Matrix& symmetric);

}  // namespace lcpbench
