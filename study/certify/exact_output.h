#pragma once

#include <vector>

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

ScaledVector scaled_z(const ExactSystem& system, const ExactPoint& point);
ScaledVector scaled_potential(const ExactSystem& system, const ExactPoint& point);

/// v + Y p.
ScaledVector scaled_velocity(const ExactInertia& inertia, const Dyadic& v, const ExactSystem& system,
                             const ExactPoint& point);

}  // namespace lcpbench::exact
