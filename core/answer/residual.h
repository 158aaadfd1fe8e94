#pragma once

#include <cmath>

#include "core/quad.h"

// What one contact of an answer leaves of its conditions [m/s], in double or in 113 bits. z are impulses, w velocities
// with offsets and compliance, m the diagonal entries of M. Zero where the conditions hold, and only there.

namespace lcpbench {

/// A vector along the two tangents of a contact.
template <class Real>
struct Tangential {
  Real first = 0;
  Real second = 0;

  Tangential operator*(Real factor) const { return {factor * first, factor * second}; }
  Tangential operator-(const Tangential& x) const { return {first - x.first, second - x.second}; }
  Real dot(const Tangential& x) const { return first * x.first + second * x.second; }
  Real length() const {
    using std::sqrt, lcpbench::sqrt;
    return sqrt(dot(*this));
  }
};

/// |min(a, b)|: of a row m z and w, of a cone row lambda and M_nn times the unused friction.
template <class Real>
Real row_residual(Real a, Real b) {
  const Real least = b < a ? b : a;
  return least < 0 ? -least : least;
}

/// | m f - P(m f - w) |, P the nearest point of the disc of radius mu m max(f_N, 0). [Alart, Curnier 1991]
template <class Real>
Real friction_residual(Real m, Real mu, Real normal, const Tangential<Real>& f, const Tangential<Real>& w) {
  const Tangential<Real> trial = f * m - w;
  const Real radius = mu * m * (normal > 0 ? normal : Real{0});
  const Real length = trial.length();
  return (f * m - trial * (length > radius ? radius / length : Real{1})).length();
}

/// m | f - P(f - w / m) |, P the nearest point of the cone |f_t| <= mu f_N: the conditions of the convex model.
template <class Real>
Real convex_residual(Real m, Real mu, Real normal, Real normal_w, const Tangential<Real>& f,
                     const Tangential<Real>& w) {
  const auto length = [](Real a, Real b) { return Tangential<Real>{a, b}.length(); };
  const Real scaled = m * normal, trial_normal = scaled - normal_w;
  // As below, but does not cancel w where m is huge.
  if (mu == 0) return length(normal_w < scaled ? normal_w : scaled, (f * m).length());
  const Tangential<Real> trial = f * m - w;
  const Real size = trial.length();
  if (trial_normal >= 0 && mu * trial_normal >= size) return length(normal_w, w.length());
  const Real sum = (trial_normal + mu * size) / (1 + mu * mu);
  const Real height = sum > 0 ? sum : Real{0};
  const Real share = size == 0 ? Real{0} : mu * height / size;
  return length(scaled - height, (f * m - trial * share).length());
}

}  // namespace lcpbench
