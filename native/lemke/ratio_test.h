#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/lemke_engine.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The basic variables as the ratio test sees them: value, rate and number, in any order. Slots that hold no variable
/// have d = 0. All arrays are padded to packs with d = x = 0.
struct Slots {
  Count count = 0;  ///< a multiple of the pack's width
  double* x = nullptr;
  double* d = nullptr;
  double* ratio = nullptr;     ///< scratch
  const double* id = nullptr;  ///< variable numbers; exact for n < 2^52
};

enum class Block { kFound, kRay, kBreakdown };

/// What the ratio test finds.
struct Blocking {
  Block kind = Block::kBreakdown;
  Count leaving = 0;  ///< number of the leaving variable
};

/// Pivots whose d is this close to the largest count as equally large: rounding must not choose between duplicates.
constexpr double kEqualPivots = 1e-9;

/// Tied are all rows with ratio <= theta. Of these the artificial variable leaves if it is there, else the one with the
/// largest d, and of equally large ones that of the lowest number (LEMKE draws lots).
inline Count leaving_of_tied(const Slots& slots, double theta, Count artificial_id, Count artificial_slot) {
  using P = Packed<double>;
  using Pack = P::Pack;
  if (slots.ratio[artificial_slot] <= theta) return artificial_id;
  Pack most = Pack{};
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    most = P::max(P::load(slots.ratio + i) <= theta ? P::load(slots.d + i) : Pack{}, most);
  }
  const double enough = (1 - kEqualPivots) * P::max(most);
  const Pack infinity = P::broadcast(kInfinity<double>);
  Pack lowest = infinity;
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    const auto eligible = (P::load(slots.ratio + i) <= theta) & (P::load(slots.d + i) >= enough);
    lowest = P::min(eligible ? P::load(slots.id + i) : infinity, lowest);
  }
  return static_cast<Count>(P::min(lowest));
}

/// LEMKE's ratio test: theta is the minimum of (x_i + zero_tolerance) / d_i over d_i > pivot_tolerance; tied are all
/// rows with x_i / d_i <= theta. Leaves the ratios of the candidates in slots.ratio, infinity elsewhere.
inline Blocking ratio_test(const Slots& slots, const Rules& rules, Count artificial_id, Count artificial_slot) {
  using P = Packed<double>;
  using Pack = P::Pack;
  const Pack infinity = P::broadcast(kInfinity<double>);
  Pack least = infinity;
  Pack most = Pack{};
  Pack poison = Pack{};  // becomes NaN when any x or d is not finite
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    const Pack x = P::load(slots.x + i);
    const Pack d = P::load(slots.d + i);
    const auto candidate = d > rules.pivot_tolerance;
    const Pack divisor = candidate ? d : P::broadcast(1);
    P::store(slots.ratio + i, candidate ? x / divisor : infinity);
    least = P::min(candidate ? (x + rules.zero_tolerance) / divisor : infinity, least);
    most = P::max(d, most);
    poison += 0.0 * x + 0.0 * d;
  }
  if (!(P::sum(poison) == 0)) return {Block::kBreakdown};
  if (!(P::max(most) > rules.pivot_tolerance)) return {Block::kRay};
  const double theta = P::min(least);
  if (!(theta < kInfinity<double>)) return {Block::kBreakdown};
  return {Block::kFound, leaving_of_tied(slots, theta, artificial_id, artificial_slot)};
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
