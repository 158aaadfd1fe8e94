#include "study/evaluation/returned_velocity.h"

#include <algorithm>
#include <limits>
#include <type_traits>

#include "study/evaluation/measures.h"

namespace lcpbench {

template <class Real>
double ReturnedVelocity<Real>::mismatch(const Vector& returned) const {
  if (returned.size() == 0) return Errors::kNone;
  const bool usable = returned.size() == contact_.problem.ngc() && returned.allFinite();
  if (!usable) return std::numeric_limits<double>::infinity();
  const auto& inertia = contact_.inertia;
  const auto same = [](const Real& x, double y) { return std::is_same_v<Real, Bounded> && surely_equal(x, y); };
  if (std::equal(v_plus_.begin(), v_plus_.end(), returned.begin(), same)) return 0;
  const RealVector velocity = numbers<Real>(returned);
  const RealVector& v = contact_.lcp->velocity_before();
  const RealVector apart = difference(velocity, v_plus_);
  const RealVector speeds = sum(magnitudes(velocity), magnitudes(v));
  const RealVector impulse_scale = contact_.lcp->generalized_impulse_scale(z_);
  if (!inertia.has_inertia()) {
    return settled(largest_quotient(apart, sum(speeds, inertia.scale(impulse_scale))), kSettledByData);
  }
  if constexpr (std::is_same_v<Real, Quad>) {
    const Real in_range = largest_quotient(inertia.apply(apart), sum(inertia.scale(speeds), impulse_scale));
    const Real outside = max_abs(inertia.outside_range(difference(velocity, v)));
    return settled(larger(in_range, quotient(outside, max_abs(velocity) + max_abs(v))));
  } else {  // a BoundedInertia is regular
    const RealVector scale = sum(inertia.scale(speeds), impulse_scale);
    const Real in_double = largest_quotient(inertia.apply_in_double(apart), scale);
    if (is_settled(in_double, kSettledByData)) return to_double(in_double);
    return settled(largest_quotient(inertia.apply(apart), scale), kSettledByData);
  }
}

/// What rounding may leave where exact sums cancel. |u_i| <= sqrt(G*_ii) |u|_G for all u, so |G*_i' J_j| <= sqrt(G*_ii
/// M_jj).
template <class Real>
Real ReturnedVelocity<Real>::rounding(std::size_t coordinate, const Real& inverse) {
  const ImpulseScale& of = impulse_scale();
  const IslandImpulses& island = of.islands[static_cast<std::size_t>(of.numbers.of_coordinate[coordinate] + 1)];
  const Real rounding = Real(island.count + 1) * (Real(0x1p-53) * root(inverse) * island.size + Real(0x1p-1074));
  if (std::is_same_v<Real, Bounded> && !is_finite(rounding)) throw Doubt();
  return rounding;
}

template <class Real>
Real ReturnedVelocity<Real>::root(const Real& square) {
  return leading(square) > 0 ? sqrt(square) : Real(0);
}

/// All islands in one pass over the scene, however many coordinates ask.
template <class Real>
const typename ReturnedVelocity<Real>::ImpulseScale& ReturnedVelocity<Real>::impulse_scale() {
  if (impulse_scale_) return *impulse_scale_;
  ImpulseScale& scale = impulse_scale_.emplace();
  scale.generalized = contact_.lcp->generalized_impulse_scale(z_);
  scale.numbers.find(contact_.problem);
  scale.islands.resize(static_cast<std::size_t>(scale.numbers.count) + 1);
  if (contact_.inertia.has_inertia()) {
    const RealVector& v = contact_.lcp->velocity_before();
    const RealVector momentum = contact_.inertia.apply(v);
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (surely_equal(v[i], 0) && is_finite(momentum[i])) continue;
      scale.islands[static_cast<std::size_t>(scale.numbers.of_coordinate[i] + 1)].size += v[i] * momentum[i];
    }
    for (IslandImpulses& island : scale.islands) island.size = root(island.size);
  }
  const ContactLayout& layout = contact_.lcp->layout();
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto at = static_cast<std::size_t>(contact);
    if (scale.numbers.of_contact[at] < 0) continue;
    IslandImpulses& island = scale.islands[static_cast<std::size_t>(scale.numbers.of_contact[at] + 1)];
    const auto add = [&](Index row) {
      const auto j = static_cast<std::size_t>(row);
      if (surely_equal(z_[j], 0)) return;
      island.size += root(contact_.diagonal(j)) * abs(z_[j]);
      ++island.count;
    };
    add(contact);
    for (Index d = layout.friction_begin[at]; d < layout.friction_begin[at + 1]; ++d) {
      add(layout.friction_offset() + d);
    }
  }
  return scale;
}

/// (|v| + |G*| x)_i for x >= 0, and G*_ii.
template <class Real>
std::pair<Real, Real> ReturnedVelocity<Real>::moved_by(std::size_t coordinate, const RealVector& x) {
  Real sum = abs(contact_.lcp->velocity_before()[coordinate]);
  if constexpr (std::is_same_v<Real, Quad>) {
    if (contact_.exact) {
      const auto i = static_cast<Index>(coordinate);
      for (std::size_t j = 0; j < x.size(); ++j) {
        if (x[j] != 0) sum += abs(contact_.exact->inverse(i, static_cast<Index>(j))) * x[j];
      }
      return {sum, contact_.exact->inverse(i, i)};
    }
  }
  inverse_row_.resize(x.size(), 0);
  inverse_row_[coordinate] = 1;
  pattern_.assign(1, coordinate);
  contact_.inertia.solve(inverse_row_, pattern_);
  const Real own = inverse_row_[coordinate];
  for (const std::size_t j : pattern_) {
    sum += abs(inverse_row_[j]) * x[j];
    inverse_row_[j] = 0;
  }
  return {sum, own};
}

/// (|v| + |G*| |J| |f|)_i + rounding_i / 1e-4
template <class Real>
Real ReturnedVelocity<Real>::scale_of(std::size_t coordinate) {
  const auto [moved, inverse] = moved_by(coordinate, impulse_scale().generalized);
  return moved + rounding(coordinate, inverse) / Real(kSolvedReturnedVelocity);
}

template <class Real>
void ReturnedVelocity<Real>::measure(const Vector& returned, Errors& errors) {
  if (returned.size() == 0) return;
  errors.returned_velocity_error = std::numeric_limits<double>::infinity();
  if (returned.size() == contact_.problem.ngc() && returned.allFinite()) {
    const RealVector& v = contact_.lcp->velocity_before();
    Real largest = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double given = returned(static_cast<Index>(i));
      const Real apart = abs(Real(given) - v_plus_[i]);
      if (surely_equal(apart, 0)) continue;
      Real error = quotient(apart, abs(v[i]) + abs(v_plus_[i] - v[i]));
      if (!surely_at_most(error, kSolvedReturnedVelocity)) error = quotient(apart, scale_of(i));
      if (leading(error) > leading(largest)) {
        errors.worst_coordinate = {static_cast<Index>(i), given, to_double(v_plus_[i])};
      }
      largest = larger(largest, error);
    }
    at_most(largest, kSolvedReturnedVelocity);  // @throws Doubt
    errors.returned_velocity_error = settled(largest, kSettledByData);
  }
  errors.solved = errors.solved && errors.velocity_passes();
}

template class ReturnedVelocity<Quad>;
template class ReturnedVelocity<Bounded>;

}  // namespace lcpbench
