#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/ratio_test.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// All tolerances between two pairs of them.
struct ToleranceBox {
  double pivot_low = 0, pivot_high = 0;
  double zero_low = 0, zero_high = 0;
};

/// Whether all tolerances of a box find the same, or else along which tolerance the box is to be halved.
enum class Consent { kAlike, kHalvePivot, kHalveZero };

struct CommonBlocking {
  Consent consent = Consent::kAlike;
  Blocking blocking;  ///< with kAlike: what ratio_test returns for every pair of tolerances in the box
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
inline CommonBlocking common_leaving(const Slots& slots, const ToleranceBox& box, double theta_high,
                              Count artificial_id, Count artificial_slot) {
  const Leaving high = leaving_of_tied(slots, theta_high, artificial_id, artificial_slot);
  const CommonBlocking alike{Consent::kAlike, {Block::kFound, high.variable}};
  if (box.zero_low == box.zero_high || one_is_tied(slots, theta_high)) return alike;
  const double theta_low = smaller_theta(slots, theta_high, box.zero_low);
  const Leaving low = leaving_of_tied(slots, theta_low, artificial_id, artificial_slot);
  if (low.variable == high.variable && low.largest == high.largest) return alike;
  return {Consent::kHalveZero, {}};
}

/// LEMKE's ratio test for all tolerances of a box at once. Exact: IEEE addition and division are monotone, so what is
/// said here of real numbers holds for rounded ones.
///
/// A row with pivot_low < d <= pivot_high is a candidate for some of the pivot tolerances only. It changes nothing when
/// its x / d is above theta of the others at zero_high: it is then neither tied nor lowers theta, at any zero
/// tolerance.
inline CommonBlocking common_ratio_test(const Slots& slots, const ToleranceBox& box, Count artificial_id,
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
  return common_leaving(slots, box, theta, artificial_id, artificial_slot);
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
