#include "study/evaluation/returned_velocity.h"

#include <algorithm>
#include <limits>
#include <type_traits>

#include "study/evaluation/measures.h"

namespace lcpbench {
namespace {

/// @pre the inertia is not given by its inverse
Vector inertia_diagonal(const Inertia& inertia) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return dense->G.diagonal();
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) return factors->X.cwiseAbs2() * factors->alpha;
  Vector diagonal(dimension(inertia));
  Index first = 0;
  for (const Matrix& block : std::get<BlockInertia>(inertia).blocks) {
    diagonal.segment(first, block.rows()) = block.diagonal();
    first += block.rows();
  }
  return diagonal;
}

}  // namespace

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

/// The most by which rounding may part a returned velocity from v+. The terms of v + G* J f may cancel: each is at most
/// sqrt(G*_ii) times its norm, since |u_i| <= sqrt(G*_ii) |u|_G, and |G* J_j|_G <= sqrt(M_jj). Solving
/// G (v+ - v) = J f with a relative error of 2^-53 in each entry of G adds to it. See Errors::returned_velocity_error.
template <class Real>
Real ReturnedVelocity<Real>::rounding(std::size_t coordinate, const Response& response) {
  const ImpulseScale& scale = impulse_scale();
  const IslandImpulses& island = scale.islands[static_cast<std::size_t>(scale.numbers.of_coordinate[coordinate] + 1)];
  const Real size = root(response.own) * island.size;
  Real rounding = Real(island.count + 1) * (Real(0x1p-53) * size + Real(0x1p-1074));
  if (!scale.root.empty()) {
    const Real solving = Real(0x1p-53 * island.coordinates) * response.to_inertia;
    const Real most = quotient(Real(kSolvedReturnedVelocity) * island.change, scale.root[coordinate]);
    rounding += leading(solving) > leading(most) ? most : solving;
  }
  if (std::is_same_v<Real, Bounded> && !is_finite(rounding)) throw Doubt();
  return rounding;
}

template <class Real>
Real ReturnedVelocity<Real>::root(const Real& square) {
  return leading(square) > 0 ? sqrt(square) : Real(0);
}

/// Made by the first call, for all islands in one pass over coordinates and contacts.
template <class Real>
const typename ReturnedVelocity<Real>::ImpulseScale& ReturnedVelocity<Real>::impulse_scale() {
  if (impulse_scale_) return *impulse_scale_;
  ImpulseScale& scale = impulse_scale_.emplace();
  scale.generalized = contact_.lcp->generalized_impulse_scale(z_);
  scale.inertial.resize(scale.generalized.size(), 0);
  scale.numbers.find(contact_.problem);
  scale.islands.resize(static_cast<std::size_t>(scale.numbers.count) + 1);
  if (contact_.inertia.has_inertia()) {
    const RealVector& v = contact_.lcp->velocity_before();
    const RealVector momentum = contact_.inertia.apply(v);
    const RealVector change = magnitudes(difference(v_plus_, v));
    scale.inertial = contact_.inertia.scale(change);
    const Vector diagonal = inertia_diagonal(contact_.problem.inertia);
    scale.root.reserve(v.size());
    for (std::size_t i = 0; i < v.size(); ++i) {
      scale.root.push_back(sqrt(Real(diagonal(static_cast<Index>(i)))));
      IslandImpulses& island = scale.islands[static_cast<std::size_t>(scale.numbers.of_coordinate[i] + 1)];
      ++island.coordinates;
      island.change = larger(island.change, scale.root[i] * change[i]);
    }
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

template <class Real>
typename ReturnedVelocity<Real>::Response ReturnedVelocity<Real>::respond(std::size_t coordinate) {
  const ImpulseScale& scale = impulse_scale();
  Response response;
  const auto add = [&](std::size_t j, const Real& inverse) {
    response.to_impulses += abs(inverse) * scale.generalized[j];
    response.to_inertia += abs(inverse) * scale.inertial[j];
  };
  if constexpr (std::is_same_v<Real, Quad>) {
    if (contact_.exact) {
      const auto i = static_cast<Index>(coordinate);
      for (std::size_t j = 0; j < scale.generalized.size(); ++j) {
        if (scale.generalized[j] != 0 || scale.inertial[j] != 0) {
          add(j, contact_.exact->inverse(i, static_cast<Index>(j)));
        }
      }
      response.own = contact_.exact->inverse(i, i);
      return response;
    }
  }
  inverse_row_.resize(scale.generalized.size(), 0);
  inverse_row_[coordinate] = 1;
  pattern_.assign(1, coordinate);
  contact_.inertia.solve(inverse_row_, pattern_);
  response.own = inverse_row_[coordinate];
  for (const std::size_t j : pattern_) {
    add(j, inverse_row_[j]);
    inverse_row_[j] = 0;
  }
  return response;
}

/// (|v| + |G*| |J| |f|)_i + rounding_i / kSolvedReturnedVelocity: an error by rounding alone passes.
template <class Real>
Real ReturnedVelocity<Real>::scale_of(std::size_t coordinate) {
  const Response response = respond(coordinate);
  return abs(contact_.lcp->velocity_before()[coordinate]) + response.to_impulses +
         rounding(coordinate, response) / Real(kSolvedReturnedVelocity);
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
