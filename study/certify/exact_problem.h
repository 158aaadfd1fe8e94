#pragma once

#include <optional>
#include <vector>

#include "core/problem.h"
#include "study/certify/certificate.h"
#include "study/certify/exact_system.h"

namespace lcpbench::exact {

/// numerators_i 2^exponents_i / denominator; denominator > 0.
struct ScaledVector {
  IntegerVector numerators;
  std::vector<slong> exponents;
  Integer denominator{1};
};

ExactVector to_text(const ScaledVector& x);
/// Each entry correctly rounded.
Vector to_doubles(const ScaledVector& x);
/// x / max|x|, each entry correctly rounded; zeros where x is zero.
Vector to_unit_doubles(const ScaledVector& x);

/// A problem over the integers. If the columns of X of a FactoredInertia are linearly dependent there are two systems:
/// system() on independent columns, to solve, and stated() on all, for the certificate. A bare LCP has system() only.
class ExactProblem {
 public:
  /// @throws TimePassed
  ExactProblem(const Problem& problem, const Deadline& deadline);

  /// What is solved; K is nonsingular. @pre inertia().refusal is empty: else there is no system, here and below
  const ExactSystem& system() const { return system_; }
  const ExactInertia& inertia() const { return inertia_; }
  const Dyadic& velocity() const { return v_; }  ///< v, before the impact

  /// The system of the certificate: all factors with alpha > 0.
  const ExactSystem& stated() const { return stated_ ? *stated_ : system_; }
  /// A point of system() as one of stated(): the entries of p for left-out factors are zero.
  ExactPoint stated(ExactPoint point) const;

  // Of a point of stated(), in the units of the problem.
  ScaledVector z(const ExactPoint& point) const;
  ScaledVector potential(const ExactPoint& point) const;
  ScaledVector velocity_after(const ExactPoint& point) const;  ///< v + Y p

  /// A contact problem without friction whose M is proven positive semidefinite: all its solutions share M z, and with
  /// it one velocity. False for bare LCPs.
  bool monotone() const { return inertia_.semidefinite && !frictional_; }
  bool frictional() const { return frictional_; }

 private:
  bool frictional_ = false;
  std::vector<Index> weighted_;  // factors with alpha > 0
  std::vector<Index> spanning_;  // those of them that are independent, as positions in X
  Dyadic v_;
  ExactInertia inertia_;
  ExactSystem system_;
  std::optional<ExactInertia> stated_inertia_;
  std::optional<ExactSystem> stated_;
};

/// The p with v + Y p = 0, beside z = 0, in the units of system(): a candidate for the direction of a proof, and no
/// solution. Nothing if Y cannot be inverted. @pre the inertia has full rank @throws TimePassed
std::optional<ExactPoint> point_at_rest(const ExactProblem& problem, const Deadline& deadline);

}  // namespace lcpbench::exact
