#include "native/contacts/island_units.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/answer/contact_scale.h"

namespace lcpbench {
namespace {

/// The rounding error of q_i = J_i'v + b_i, a sum of few terms, relative to the sum of their magnitudes.
constexpr double kRounding = 0x1p-50;
/// A unit raises this rounding error to less than twice this times the largest scale of all islands (2.3e-10).
constexpr double kLargestRounding = 0x1p-33;
/// Of a unit and of scaled velocities, so that neither overflows.
constexpr int kLargestExponent = 1000;

/// Sets `largest` to `value` if that is larger, and to infinity if `value` is NaN.
void raise(double& largest, double value) {
  if (!(value <= largest)) largest = value > largest ? value : std::numeric_limits<double>::infinity();
}

}  // namespace

void IslandUnits::load(const ContactProblem& problem) {
  if (couples_all(problem.inertia) && !problem.is_soft()) {  // a soft contact may be an island of its own
    numbers_ = {};
  } else {
    numbers_.find(problem);
  }
  islands_.assign(static_cast<std::size_t>(numbers_.count), {});
}

void IslandUnits::load(const Matrix& M) {
  RowIslands rows = row_islands(M);
  numbers_.of_coordinate = rows.of_row;
  numbers_.of_contact = std::move(rows.of_row);
  numbers_.count = rows.count;
  islands_.assign(static_cast<std::size_t>(rows.count), {});
}

void IslandUnits::clear() { std::fill(islands_.begin(), islands_.end(), Island{}); }

IslandUnits::Row row_of_units(bool is_normal, double velocity, double terms, double entries, double offset,
                              double magnitude) {
  ContactScale<double> scale;
  scale.add_row(velocity, terms, entries);
  if (is_normal) scale.add_approach(velocity + offset);
  return {.approach = scale.without, .floor = scale.floor(), .magnitudes = terms + magnitude};
}

void IslandUnits::add_row(Index contact, const Row& row) {
  if (!several()) return;
  const Index number = numbers_.of_contact[static_cast<std::size_t>(contact)];
  if (number < 0) return;
  Row& largest = islands_[static_cast<std::size_t>(number)].largest;
  raise(largest.approach, row.approach);
  raise(largest.floor, row.floor);
  raise(largest.magnitudes, row.magnitudes);
}

/// The smallest power of two that brings the island's scale to at least the largest; less where its speed would
/// overflow. An island whose q nearly cancels counts with 2^-17 of the magnitudes of its terms instead. 1 without an
/// approach, where the island needs no scaling, and where the largest scale is not finite.
double IslandUnits::unit_for(const Island& island, double largest_scale) {
  const double own = std::max(island.scale(), kRounding / kLargestRounding * island.largest.magnitudes);
  const bool is_scaled = island.largest.approach > 0 && own < largest_scale;
  if (!(is_scaled && largest_scale <= std::numeric_limits<double>::max())) return 1;
  int exponent = std::ilogb(largest_scale) - std::ilogb(own);
  if (std::ldexp(own, exponent) < largest_scale) ++exponent;
  // The speed is zero where q comes from the offset b alone.
  const int most =
      island.speed > 0 ? std::min(kLargestExponent, kLargestExponent - std::ilogb(island.speed)) : kLargestExponent;
  return std::ldexp(1.0, std::max(0, std::min(exponent, most)));
}

void IslandUnits::choose(const Vector& v) {
  if (!several()) return;
  largest_scale_ = 0;
  for (const Island& island : islands_) {
    if (island.largest.approach > 0) largest_scale_ = std::max(largest_scale_, island.scale());
  }
  for (Index i = 0; i < v.size(); ++i) {
    const Index number = numbers_.of_coordinate[static_cast<std::size_t>(i)];
    if (number >= 0) raise(islands_[static_cast<std::size_t>(number)].speed, std::abs(v(i)));
  }
  for (Island& island : islands_) island.unit = unit_for(island, largest_scale_);
}

void IslandUnits::scale(Vector& v) const {
  if (!several()) return;
  for (Index i = 0; i < v.size(); ++i) v(i) *= of_coordinate(i);
}

void IslandUnits::restore(Vector& v) const {
  if (!several()) return;
  for (Index i = 0; i < v.size(); ++i) v(i) /= of_coordinate(i);
}

}  // namespace lcpbench
