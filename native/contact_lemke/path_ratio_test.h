#pragma once

#include "native/contact_lemke/path.h"

// Which basic variable leaves.

namespace lcpbench::lemke::LCPBENCH_LEVEL {

template <class Scalar>
template <class Visit>
inline void Path<Scalar>::for_each_segment(Visit visit) const {
  visit(Count(0), contacts_.padded_nc());
  visit(column_slots_, column_slots_ + P::padded(kernel_.order()));
  for (Count k = 0; k < living_count_; ++k) {
    const Count first = slot_at_[living_[k]];
    visit(first, first + slots_of(living_[k]));
  }
}

/// Harris's test: the least ratio with values moved up by the tie tolerance; of all that are then not above it the
/// one with the fastest rate leaves, z0 before all.
template <class Scalar>
inline auto Path<Scalar>::choose_leaving() const -> Leaving {
  Scalar least_rate = static_cast<Scalar>(rules_.pivot_tolerance) * rate_scale_;
  if (static_cast<Scalar>(kSafeNoises) * rate_noise_ > least_rate) {
    least_rate = static_cast<Scalar>(kSafeNoises) * rate_noise_;
  }
  const Scalar slack = static_cast<Scalar>(rules_.tie_tolerance) * value_scale_;
  Scalar theta = least_ratio(least_rate, slack);
  if (!(theta >= 0)) return {Kind::kBroken, -1, {}};
  if (!(theta < kInfinity<Scalar>)) return {};
  theta *= static_cast<Scalar>(1 + 8 * kUnitRoundoff<Scalar>);  // the least ratio's own row is to stay among the tied
  if (artificial_ < 0) {
    if (theta >= 1) return {Kind::kColumn, kPastEnd, Label{}};
  } else if (dx_[artificial_] < 0 && x_[artificial_] <= theta * -dx_[artificial_]) {
    return {Kind::kColumn, artificial_, Label{}};
  }
  return decode(fastest_of_tied(least_rate, theta));
}

template <class Scalar>
inline Scalar Path<Scalar>::least_ratio(Scalar least_rate, Scalar slack) const {
  const Pack infinity = P::broadcast(kInfinity<Scalar>);
  const Pack zero = Pack{};
  const Pack one = P::broadcast(Scalar(1));
  Pack least = infinity;
  Pack poison = zero;
  for_each_segment([&](Count first, Count last) {
    for (Count i = first; i < last; i += P::kWidth) {
      const Pack fall = -P::load(rate_.data() + i);
      const Pack value = P::load(value_.data() + i);
      const auto candidate = fall > least_rate;
      const Pack ratio = (P::max(value, zero) + slack) / (candidate ? fall : one);
      least = P::min(candidate ? ratio : infinity, least);
      poison += Scalar(0) * fall + Scalar(0) * value;
    }
  });
  if (!(P::sum(poison) == 0)) return -1;
  return lane_min(least);
}

template <class Scalar>
inline Scalar Path<Scalar>::lane_min(Pack pack) {
  Scalar lanes[static_cast<std::size_t>(P::kWidth)];
  P::store(lanes, pack);
  for (Count i = 1; i < P::kWidth; ++i) lanes[0] = lanes[i] < lanes[0] ? lanes[i] : lanes[0];
  return lanes[0];
}

template <class Scalar>
inline Count Path<Scalar>::fastest_of_tied(Scalar least_rate, Scalar theta) const {
  const Pack zero = Pack{};
  const Pack lowest = P::broadcast(least_rate);
  const Pack width = P::broadcast(static_cast<Scalar>(static_cast<double>(P::kWidth)));
  Pack fastest = lowest;
  Pack where = P::broadcast(Scalar(-1));
  for_each_segment([&](Count first, Count last) {
    Pack at = P::broadcast(static_cast<Scalar>(static_cast<double>(first)));
    for (Count i = first; i < last; i += P::kWidth) {
      const Pack fall = -P::load(rate_.data() + i);
      const Pack value = P::max(P::load(value_.data() + i), zero);
      const Pack tied = value <= theta * fall ? fall : lowest;
      where = tied > fastest ? at : where;
      fastest = P::max(tied, fastest);
      at += width;
    }
  });
  Scalar rates[static_cast<std::size_t>(P::kWidth)];
  Scalar places[static_cast<std::size_t>(P::kWidth)];
  P::store(rates, fastest);
  P::store(places, where);
  Count best = -1;
  Scalar best_rate = least_rate;
  for (Count lane = 0; lane < P::kWidth; ++lane) {
    if (places[lane] >= 0 && rates[lane] > best_rate) {
      best_rate = rates[lane];
      best = static_cast<Count>(static_cast<double>(places[lane])) + lane;
    }
  }
  return best;
}

template <class Scalar>
inline auto Path<Scalar>::decode(Count slot) const -> Leaving {
  if (slot < 0) return {Kind::kBroken, -1, {}};
  if (slot < contacts_.padded_nc()) return {Kind::kVelocity, -1, Label{slot, kNormal}};
  if (slot < column_slots_ + kernel_.stride()) {
    const Count column = slot - column_slots_;
    return {Kind::kColumn, column, kernel_.column_label(column)};
  }
  Count contact = 0;
  for (Count k = 0; k < living_count_; ++k) {
    const Count first = slot_at_[living_[k]];
    if (slot >= first && slot < first + slots_of(living_[k])) contact = living_[k];
  }
  const Count width = contacts_.padded_half(contact);
  const Count half = contacts_.half(contact);
  const Count place = slot - slot_at_[contact];
  if (place == 2 * width + 1) return {Kind::kBase, -1, Label{contact, base_[contact]}};
  if (place == 2 * width) return {Kind::kVelocity, -1, Label{contact, 2 * half}};
  return {Kind::kVelocity, -1, Label{contact, place < width ? place : place - width + half}};
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
