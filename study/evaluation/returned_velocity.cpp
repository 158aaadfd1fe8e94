#include "study/evaluation/returned_velocity.h"

#include <limits>

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

/// Errors::velocity_mismatch
double ReturnedVelocity::mismatch(const Vector& returned) const {
  const RefinedInertia& inertia = contact_.inertia;
  const QuadVector velocity = numbers(returned);
  const QuadVector& v = contact_.lcp->velocity_before();
  const QuadVector apart = difference(velocity, v_plus_);
  if (max_abs(apart) == 0) return 0;
  QuadVector speeds = magnitudes(velocity);
  for (std::size_t i = 0; i < v.size(); ++i) speeds[i] += abs(v[i]);
  const QuadVector impulse_scale = contact_.lcp->generalized_impulse_scale(z_);
  const bool known = inertia.has_inertia();
  Quad largest = 0;
  const auto take = [&]<class Number>(const std::vector<Number>& differences, const std::vector<Number>& scales,
                                      const QuadVector& rest) {
    for (std::size_t i = 0; i < rest.size(); ++i) {
      largest = larger(largest, quotient(abs(Quad{differences[i]}), scales[i] + rest[i]));
    }
  };
  if (!known) {
    take(apart, inertia.apply(impulse_scale, true), speeds);
  } else if (inertia.is_moderate()) {  // no sum of magnitudes cancels
    const auto rounded = [](const QuadVector& x) { return std::vector<double>(x.begin(), x.end()); };
    take(inertia.apply(rounded(apart)), inertia.apply(rounded(speeds), true), impulse_scale);
  } else {
    take(inertia.apply(apart), inertia.apply(speeds, true), impulse_scale);
  }
  const Quad outside = max_abs(inertia.outside_range(difference(velocity, v)));
  return to_double(larger(largest, quotient(outside, max_abs(velocity) + max_abs(v))));
}

/// The most by which rounding may part a returned velocity from v+. The terms of v + G* J f may cancel: each is at most
/// sqrt(G*_ii) times its norm, since |u_i| <= sqrt(G*_ii) |u|_G, and |G* J_j|_G <= sqrt(M_jj). Solving
/// G (v+ - v) = J f with a relative error of 2^-53 in each entry of G adds to it. See Errors::returned_velocity_error.
Quad ReturnedVelocity::rounding(std::size_t coordinate, const Response& response) {
  const ImpulseScale& scale = impulse_scale();
  const IslandImpulses& island = scale.islands[static_cast<std::size_t>(scale.numbers.of_coordinate[coordinate] + 1)];
  const Quad size = sqrt(response.own) * island.size;
  Quad rounding = Quad{island.count + 1} * (Quad{0x1p-53} * size + Quad{0x1p-1074});
  if (!scale.root.empty()) {
    const Quad solving = Quad{0x1p-53 * island.coordinates} * response.to_inertia;
    const Quad most = quotient(Quad{kSolvedReturnedVelocity} * island.change, scale.root[coordinate]);
    rounding += solving > most ? most : solving;
  }
  return rounding;
}

/// Made by the first call, for all islands in one pass over coordinates and contacts.
const ReturnedVelocity::ImpulseScale& ReturnedVelocity::impulse_scale() {
  if (impulse_scale_) return *impulse_scale_;
  ImpulseScale& scale = impulse_scale_.emplace();
  scale.generalized = contact_.lcp->generalized_impulse_scale(z_);
  scale.inertial.resize(scale.generalized.size(), 0);
  scale.numbers.find(contact_.problem);
  scale.islands.resize(static_cast<std::size_t>(scale.numbers.count) + 1);
  if (contact_.inertia.has_inertia()) {
    const QuadVector& v = contact_.lcp->velocity_before();
    const QuadVector momentum = contact_.inertia.apply(v);
    const QuadVector change = magnitudes(difference(v_plus_, v));
    scale.inertial = contact_.inertia.apply(change, true);
    const Vector diagonal = inertia_diagonal(contact_.problem.inertia);
    scale.root.reserve(v.size());
    for (std::size_t i = 0; i < v.size(); ++i) {
      scale.root.push_back(sqrt(Quad(diagonal(static_cast<Index>(i)))));
      IslandImpulses& island = scale.islands[static_cast<std::size_t>(scale.numbers.of_coordinate[i] + 1)];
      ++island.coordinates;
      island.change = larger(island.change, scale.root[i] * change[i]);
    }
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (v[i] == 0 && is_finite(momentum[i])) continue;
      scale.islands[static_cast<std::size_t>(scale.numbers.of_coordinate[i] + 1)].energy += v[i] * momentum[i];
    }
    for (IslandImpulses& island : scale.islands) island.size = sqrt(island.energy);
  }
  const ContactLayout& layout = contact_.lcp->layout();
  const auto add = [&](Index number, Index row) {
    const auto j = static_cast<std::size_t>(row);
    if (number < 0 || z_[j] == 0) return;
    IslandImpulses& island = scale.islands[static_cast<std::size_t>(number + 1)];
    island.size += sqrt(contact_.lcp->diagonal(j)) * abs(z_[j]);
    ++island.count;
  };
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto at = static_cast<std::size_t>(contact);
    add(scale.numbers.of_contact[at], contact);
    for (Index d = layout.friction_begin[at]; d < layout.friction_begin[at + 1]; ++d) {
      add(scale.numbers.of_contact[at], layout.friction_offset() + d);
    }
  }
  for (Index row = 0; row < layout.rows; ++row) {
    add(scale.numbers.of_row[static_cast<std::size_t>(row)], layout.row_offset() + row);
  }
  return scale;
}

ReturnedVelocity::Response ReturnedVelocity::respond(std::size_t coordinate) {
  const ImpulseScale& scale = impulse_scale();
  Response response;
  contact_.inertia.for_each_inverse(coordinate, [&](std::size_t j, Quad inverse) {
    response.to_impulses += abs(inverse) * scale.generalized[j];
    response.to_inertia += abs(inverse) * scale.inertial[j];
    if (j == coordinate) response.own = inverse;
  });
  return response;
}

/// (|v| + |G*| |J| |f|)_i + rounding_i / kSolvedReturnedVelocity, so that an error by rounding alone passes; at least
/// kEnergyShare of what the energy of the island could give the coordinate.
Quad ReturnedVelocity::scale_of(std::size_t coordinate) {
  constexpr double kEnergyShare = 1e-8;
  const Response response = respond(coordinate);
  const ImpulseScale& scale = impulse_scale();
  const Quad energy = scale.islands[static_cast<std::size_t>(scale.numbers.of_coordinate[coordinate] + 1)].energy;
  return larger(abs(contact_.lcp->velocity_before()[coordinate]) + response.to_impulses +
                    rounding(coordinate, response) / Quad{kSolvedReturnedVelocity},
                Quad{kEnergyShare} * sqrt(response.own * energy));
}

bool ReturnedVelocity::measure(const Vector& returned, Errors& errors) {
  if (returned.size() == 0) return true;
  errors.returned_velocity_error = errors.velocity_mismatch = std::numeric_limits<double>::infinity();
  if (returned.size() == contact_.problem.ngc() && returned.allFinite()) {
    errors.velocity_mismatch = mismatch(returned);
    const QuadVector& v = contact_.lcp->velocity_before();
    constexpr double kLeastSpeed = 1e-8;  // m/s or rad/s
    const QuadVector off = contact_.lcp->response_error(z_);
    Quad largest = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double given = returned(static_cast<Index>(i));
      const Quad apart = abs(Quad{given} - v_plus_[i]);
      if (apart == 0) continue;
      Quad scale = larger(kLeastSpeed, abs(v[i]) + abs(v_plus_[i] - v[i]));
      const auto is_known = [&] {
        const Quad margin = abs(apart - Quad{kSolvedReturnedVelocity} * scale);
        return off.empty() || off[i] == 0 || (off[i] <= Quad{kResolvedError} * scale && off[i] < margin);
      };
      if (!(apart / scale <= kSolvedReturnedVelocity) || !is_known()) scale = larger(kLeastSpeed, scale_of(i));
      if (!contact_.inertia.well_defined() || !is_known()) return false;
      Quad error = apart / scale;
      if (!is_finite(error)) error = std::numeric_limits<double>::infinity();  // NaN, too
      if (error > largest) {
        errors.worst_coordinate = {static_cast<Index>(i), given, to_double(v_plus_[i]), to_double(apart / error)};
      }
      largest = larger(largest, error);
    }
    errors.returned_velocity_error = to_double(largest);
  }
  errors.decide(errors.limit);
  return true;
}

}  // namespace lcpbench
