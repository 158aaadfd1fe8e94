#pragma once

#include "native/kernels/pack.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The basic variables as the ratio test sees them: value, rate and number, in any order. Slots that hold no variable
/// have d = 0. All arrays are padded to packs with d = x = 0.
struct Slots {
  Count count = 0;  ///< a multiple of the pack's width
  double* x = nullptr;
  double* d = nullptr;
  double* ratio = nullptr;     ///< scratch
  const double* id = nullptr;  ///< variable numbers; exact for n < 2^52
  bool first_largest = false;  ///< how ties are broken: the rule of 2012
};

enum class Block { kFound, kRay, kBreakdown };

/// What the ratio test finds.
struct Blocking {
  Block kind = Block::kBreakdown;
  Count leaving = 0;  ///< number of the leaving variable
};

/// Pivots whose d is this close to the largest count as equally large: rounding must not choose between duplicates.
constexpr double kEqualPivots = 1e-9;

/// What leaves among the rows that are tied.
struct Leaving {
  Count variable = 0;
  double largest = 0;  ///< the largest d of the tied rows; infinity when the artificial variable leaves
};

/// By the rules of 2012: of the tied rows the one with the largest d, and of exactly equal ones that of the first slot.
/// kEqualPivots has no part in it.
inline Leaving first_largest(const Slots& slots, double theta) {
  Leaving leaving{-1, 0};
  for (Count i = 0; i < slots.count; ++i) {
    if (!(slots.ratio[i] <= theta)) continue;
    if (slots.d[i] > leaving.largest) leaving = {static_cast<Count>(slots.id[i]), slots.d[i]};
  }
  return leaving;
}

/// Tied are all rows with ratio <= theta. Of these the artificial variable leaves if it is there, else the one with the
/// largest d, and of equally large ones that of the lowest number (LEMKE draws lots).
inline Leaving leaving_of_tied(const Slots& slots, double theta, Count artificial_id, Count artificial_slot) {
  using P = Packed<double>;
  using Pack = P::Pack;
  if (slots.ratio[artificial_slot] <= theta) return {artificial_id, kInfinity<double>};
  if (slots.first_largest) return first_largest(slots, theta);
  Pack most = Pack{};
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    most = P::max(P::load(slots.ratio + i) <= theta ? P::load(slots.d + i) : Pack{}, most);
  }
  const double largest = P::max(most);
  const double enough = (1 - kEqualPivots) * largest;
  const Pack infinity = P::broadcast(kInfinity<double>);
  Pack lowest = infinity;
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    const auto eligible = (P::load(slots.ratio + i) <= theta) & (P::load(slots.d + i) >= enough);
    lowest = P::min(eligible ? P::load(slots.id + i) : infinity, lowest);
  }
  return {static_cast<Count>(P::min(lowest)), largest};
}

/// All tolerances between two pairs of them.
struct ToleranceBox {
  double pivot_low = 0, pivot_high = 0;
  double zero_low = 0, zero_high = 0;
};

/// Whether all tolerances of a box find the same, or else along which tolerance the box is to be halved.
enum class Consent { kAlike, kHalvePivot, kHalveZero };

struct BoxBlocking {
  Consent consent = Consent::kAlike;
  Blocking blocking;  ///< with kAlike: what the ratio test finds for every pair of tolerances in the box
};

/// Whether one row alone has ratio <= theta.
inline bool one_is_tied(const Slots& slots, double theta) {
  using P = Packed<double>;
  using Pack = P::Pack;
  Pack tied = Pack{};
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    tied += P::load(slots.ratio + i) <= theta ? P::broadcast(1) : Pack{};
  }
  return P::sum(tied) == 1;
}

/// Theta of a smaller zero tolerance. A row that is not tied at `theta` has (x + zero) / d >= x / d > theta: the rows
/// that are tied decide.
inline double smaller_theta(const Slots& slots, double theta, double zero_tolerance) {
  using P = Packed<double>;
  using Pack = P::Pack;
  const Pack infinity = P::broadcast(kInfinity<double>);
  Pack least = infinity;
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    const auto tied = P::load(slots.ratio + i) <= theta;
    const Pack divisor = tied ? P::load(slots.d + i) : P::broadcast(1);
    least = P::min(tied ? (P::load(slots.x + i) + zero_tolerance) / divisor : infinity, least);
  }
  return P::min(least);
}

/// What is left to decide once the candidates are the same for the whole box: theta, and with it the set of tied rows,
/// grows with the zero tolerance. Two ends that choose the same variable by the same largest d enclose no other choice:
/// the rows nearly as large as it are nested too.
inline BoxBlocking leaving_of_box(const Slots& slots, const ToleranceBox& box, double theta_high, Count artificial_id,
                                  Count artificial_slot) {
  const Leaving high = leaving_of_tied(slots, theta_high, artificial_id, artificial_slot);
  const BoxBlocking alike{Consent::kAlike, {Block::kFound, high.variable}};
  if (box.zero_low == box.zero_high || one_is_tied(slots, theta_high)) return alike;
  const double theta_low = smaller_theta(slots, theta_high, box.zero_low);
  const Leaving low = leaving_of_tied(slots, theta_low, artificial_id, artificial_slot);
  if (low.variable == high.variable && low.largest == high.largest) return alike;
  return {Consent::kHalveZero, {}};
}

/// LEMKE's ratio test for all tolerances of a box at once, which may be one pair. For one pair theta is the minimum of
/// (x_i + zero_tolerance) / d_i over d_i > pivot_tolerance; tied are all rows with x_i / d_i <= theta. Exact: IEEE
/// addition and division are monotone, so what is said here of real numbers holds for rounded ones. Leaves the ratios
/// of the candidates in slots.ratio, infinity elsewhere.
///
/// A row with pivot_low < d <= pivot_high is a candidate for some of the pivot tolerances only. It changes nothing when
/// its x / d is above theta of the others at zero_high: it is then neither tied nor lowers theta, at any zero
/// tolerance.
inline BoxBlocking ratio_test(const Slots& slots, const ToleranceBox& box, Count artificial_id,
                              Count artificial_slot) {
  using P = Packed<double>;
  using Pack = P::Pack;
  const Pack infinity = P::broadcast(kInfinity<double>);
  Pack least = infinity;
  Pack least_doubtful = infinity;
  Pack most = Pack{};
  Pack poison = Pack{};  // becomes NaN when any x or d is not finite
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    const Pack x = P::load(slots.x + i);
    const Pack d = P::load(slots.d + i);
    const auto candidate = d > box.pivot_high;
    const auto possible = d > box.pivot_low;
    const Pack divisor = possible ? d : P::broadcast(1);
    const Pack ratio = possible ? x / divisor : infinity;
    P::store(slots.ratio + i, candidate ? ratio : infinity);
    least_doubtful = P::min(candidate ? infinity : ratio, least_doubtful);
    least = P::min(candidate ? (x + box.zero_high) / divisor : infinity, least);
    most = P::max(d, most);
    poison += 0.0 * x + 0.0 * d;
  }
  if (!(P::sum(poison) == 0)) return {Consent::kAlike, {Block::kBreakdown, 0}};
  const double largest = P::max(most);
  if (!(largest > box.pivot_low)) return {Consent::kAlike, {Block::kRay, 0}};
  if (!(largest > box.pivot_high)) return {Consent::kHalvePivot, {}};
  const double theta = P::min(least);
  const double doubtful = P::min(least_doubtful);
  if (!(theta < kInfinity<double>)) {
    if (box.zero_low < box.zero_high) return {Consent::kHalveZero, {}};
    if (doubtful < kInfinity<double>) return {Consent::kHalvePivot, {}};
    return {Consent::kAlike, {Block::kBreakdown, 0}};
  }
  if (doubtful <= theta) return {Consent::kHalvePivot, {}};
  return leaving_of_box(slots, box, theta, artificial_id, artificial_slot);
}

/// x -= (x_leaving / d_leaving) d; returns that ratio.
inline double advance(const Slots& slots, Count leaving_slot) {
  using P = Packed<double>;
  const double ratio = slots.x[leaving_slot] / slots.d[leaving_slot];
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    P::store(slots.x + i, P::load(slots.x + i) - ratio * P::load(slots.d + i));
  }
  return ratio;
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
