#pragma once

#include "native/contact_lemke/path.h"

// Values and rates of the basic variables, and the candidates of the ratio test made of them.

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// x, u and the scale of rounding in them. The rows of the kernel should have velocity zero: where they miss it by
/// more than rounding the inverse has lost accuracy, and x is refined, or the kernel inverted afresh.
template <class Scalar>
inline bool Path<Scalar>::compute_values() {
  compute_values_once();
  Scalar missed = largest_residual();
  refines_rates_ = missed > residual_tolerance();
  if (missed > static_cast<Scalar>(kWorthRefining) * value_scale_ && !invert_and_recompute(missed)) return false;
  if (missed > residual_tolerance()) missed = refine();
  if (rules_.reinvert || !(missed > lost_residual())) return true;
  missed = refine();
  if (!(missed > lost_residual())) return true;
  if (!invert_and_recompute(missed)) return false;
  if (missed > residual_tolerance()) missed = refine();
  return true;
}

template <class Scalar>
inline void Path<Scalar>::measure_value_scale() {
  Pack largest = P::broadcast(speed_scale_);
  for (Count j = 0; j < kernel_.order(); j += P::kWidth) {
    const Pack value = without_entry<Scalar>(P::load(x_.data() + j), j, artificial_) * P::load(kernel_.norms() + j);
    largest = larger_magnitude<Scalar>(entries_of<Scalar>(value, j, kernel_.order()), largest);
  }
  value_scale_ = P::max(largest);
}

/// Of the velocities of the kernel's rows, which should be zero. Writes all of them to residual_.
template <class Scalar>
inline Scalar Path<Scalar>::largest_residual() {
  kernel_.measure(u_.data(), residual_.data());
  const Scalar z0 = artificial_value();
  Pack largest = Pack{};
  for (Count r = 0; r < kernel_.order(); r += P::kWidth) {
    const Pack missed = P::load(residual_.data() + r) + P::load(kernel_.covers() + r) * z0;
    P::store(residual_.data() + r, missed);
    largest = larger_magnitude<Scalar>(entries_of<Scalar>(missed, r, kernel_.order()), largest);
  }
  return P::max(largest);
}

/// One step of iterative refinement from residual_. @returns the largest residual after it.
template <class Scalar>
inline Scalar Path<Scalar>::refine() {
  count_refinement();
  kernel_.solve(residual_.data(), coefficients_.data());
  add_multiple(x_.data(), Scalar(-1), coefficients_.data(), kernel_.order());
  respond_to_values();
  return largest_residual();
}

template <class Scalar>
inline void Path<Scalar>::compute_rates(const Entering& entering) {
  const Count order = kernel_.order();
  rate_noise_ = 0;
  if (entering.is_velocity) {
    const Count row = kernel_.find_row(entering.label);
    copy(dx_.data(), kernel_.inverse_column(row), order);
    kernel_.respond(dx_.data(), du_.data());
    entering_norm_ = 1;
    if (large()) refine_large_rates(row);
  } else {
    load_column(entering.label);
    respond(column_.data(), entering_response_.data());
    entering_norm_ = norm_of(entering_response_.data());
    solve_for_rates();
  }
}

/// dx and du of an unknown that enters with entering_response_.
template <class Scalar>
inline void Path<Scalar>::solve_for_rates() {
  kernel_.measure(entering_response_.data(), residual_.data());
  kernel_.solve(residual_.data(), dx_.data());
  scale(dx_.data(), Scalar(-1), kernel_.order());
  kernel_.respond_from(entering_response_.data(), dx_.data(), du_.data());
  if (refines_rates_) {
    measure_rates(-1);
    correct_rates(-1);
  }
  if (large()) refine_large_rates(-1);
}

/// Refines the rates of a large kernel as long as that at least halves the residual of its rows. rate_noise_ becomes
/// what is left: the rates of velocities that depend on those rows are not known any better.
/// @param row  of the entering velocity; -1 where an impulse or z0 enters
template <class Scalar>
inline void Path<Scalar>::refine_large_rates(Count row) {
  rate_noise_ = measure_rates(row);
  // Contacts that yield do not depend on each other: mostly the noise is far below what counts as a rate at all.
  const Scalar harmless = static_cast<Scalar>(kPivotTolerance / kSafeNoises) * entering_norm_;
  for (Count k = 0; k < kRateRefinements && !(contacts_.is_soft() && rate_noise_ <= harmless); ++k) {
    correct_rates(row);
    const Scalar before = rate_noise_;
    rate_noise_ = measure_rates(row);
    if (!(rate_noise_ <= before / 2)) return;
  }
}

/// residual_ := the rates of the kernel's rows, which should be zero, and 1 in `row`. @returns the largest error
template <class Scalar>
inline Scalar Path<Scalar>::measure_rates(Count row) {
  kernel_.measure(du_.data(), residual_.data());
  Scalar largest = 0;
  for (Count r = 0; r < kernel_.order(); ++r) {
    residual_[r] += kernel_.cover(r) * artificial_rate();
    if (r == row) residual_[r] -= Scalar(1);
    largest = magnitude(residual_[r]) > largest ? magnitude(residual_[r]) : largest;
  }
  return largest;
}

/// One step of iterative refinement of the rates from residual_. @pre measure_rates(row)
template <class Scalar>
inline void Path<Scalar>::correct_rates(Count row) {
  count_refinement();
  kernel_.solve(residual_.data(), coefficients_.data());
  add_multiple(dx_.data(), Scalar(-1), coefficients_.data(), kernel_.order());
  if (row < 0) kernel_.respond_from(entering_response_.data(), dx_.data(), du_.data());
  if (row >= 0) kernel_.respond(dx_.data(), du_.data());
}

/// Values of all candidates and how fast they fall. @returns their least ratio
template <class Scalar>
inline Scalar Path<Scalar>::compute_candidates(const Entering& entering) {
  return contacts_.skips_zeros() ? compute_candidates_by<true>(entering) : compute_candidates_by<false>(entering);
}

/// @tparam kSkips  Contacts::skips_zeros(): asked once for all products, because each is short where it is false
template <class Scalar>
template <bool kSkips>
[[gnu::noinline]] Scalar Path<Scalar>::compute_candidates_by(const Entering& entering) {
  compute_base_values(entering);
  compute_column_candidates();
  LeastRatio<Scalar> least(least_rate(), static_cast<Scalar>(kTieTolerance) * value_scale_);
  for (Count i = 0; i < contacts_.extent(); i += P::kWidth) {
    least.check(P::load(u_.data() + i), P::load(du_.data() + i));
  }
  offer_normals<kSkips>(least);
  const Count end_of_columns = ratio_test_.first_column() + P::padded(kernel_.order());
  for (Count i = ratio_test_.first_column(); i < end_of_columns; i += P::kWidth) {
    const Pack value = P::load(ratio_test_.values() + i), fall = P::load(ratio_test_.falls() + i);
    least.check(value, fall);
    least.offer(value, fall);
  }
  const bool is_friction = !entering.is_velocity && entering.label.direction != kNormal;
  const Count entering_contact = is_friction ? entering.label.contact : kArtificial;
  compute_slips<kSkips>(end_of_columns);
  Count slot = end_of_columns;
  for (Count k = 0; k < friction_.count(); ++k) {
    const Count contact = friction_.contact(k);
    offer_contact(contact, contact == entering_contact, slot, least);
    slot += 2 * simplex_[contact].width + P::padded(2);
  }
  ratio_test_.end_at(slot);
  return least.value();
}

/// The products with u and du of a tile of columns of a matrix that has `count` rows, `stride` apart.
/// @param runs  outside of which the columns are zero; read only where kSkips
template <bool kSkips, Count kPacks, class Scalar>
[[gnu::always_inline]] inline TileSums<kPacks, Scalar, 2> products(const Scalar* rows, Count stride, Count count,
                                                                   const Runs& runs, const Scalar* u,
                                                                   const Scalar* du) {
  using Sums = TileSums<kPacks, Scalar, 2>;
  if constexpr (kSkips) {
    const auto of_run = [&](Count run) __attribute__((always_inline)) {
      const Count first = runs.first[run];
      return Sums(rows + first * stride, stride, runs.end[run] - first, {u + first, du + first});
    };
    Sums sums = of_run(0);
    if (runs.count > 1) sums += of_run(1);
    return sums;
  } else {
    return Sums(rows, stride, count, {u, du});
  }
}

template <class Scalar>
template <bool kSkips>
[[gnu::always_inline]] inline void Path<Scalar>::offer_normals(LeastRatio<Scalar>& least) {
  const Count length = contacts_.padded_nc();
  const Scalar z0 = artificial_value();
  const Scalar dz0 = artificial_rate();
  const bool is_soft = contacts_.is_soft();
  const Scalar* const yields = u_.data() + contacts_.normal_at(0);
  const Scalar* const yield_rates = du_.data() + contacts_.normal_at(0);
  for_each_tile<Scalar>(length, [&](auto packs, Count at) {
    const auto sums = products<kSkips, packs.kValue>(contacts_.normals() + at, length, contacts_.ngc(),
                                                     contacts_.normal_runs(at), u_.data(), du_.data());
    for (Count p = 0; p < packs.kValue; ++p) {
      const Count i = at + p * P::kWidth;
      const Pack cover = P::load(covering_.of_normals() + i);
      Pack value = sums.of[0][p], rate = sums.of[1][p];
      if (is_soft) value += P::load(yields + i), rate += P::load(yield_rates + i);
      value += cover * z0;
      const Pack fall = (-rate - cover * dz0) * P::load(ratio_test_.allowed_normals() + i);
      P::store(ratio_test_.values() + i, value);
      P::store(ratio_test_.falls() + i, fall);
      least.offer(value, fall);
    }
  });
}

template <class Scalar>
inline void Path<Scalar>::compute_column_candidates() {
  const Count order = kernel_.order();
  const Scalar* const norms = kernel_.norms();
  Scalar* const values = ratio_test_.values() + ratio_test_.first_column();
  Scalar* const falls = ratio_test_.falls() + ratio_test_.first_column();
  Pack largest = P::broadcast(entering_norm_);
  for (Count j = 0; j < order; j += P::kWidth) {
    const Pack norm = P::load(norms + j);
    const Pack rate = entries_of<Scalar>(P::load(dx_.data() + j) * norm, j, order);
    P::store(values + j, entries_of<Scalar>(P::load(x_.data() + j) * norm, j, order));
    P::store(falls + j, -rate);
    largest = larger_magnitude<Scalar>(rate, largest);
  }
  rate_scale_ = P::max(largest);
}

/// f_t = mu f_N + cover z0 - (the contact's other friction impulses)
template <class Scalar>
inline void Path<Scalar>::compute_base_values(const Entering& entering) {
  for (Count k = 0; k < friction_.count(); ++k) {
    const Count c = friction_.contact(k);
    const Scalar cover = covering_.of_cone(c);
    simplex_[c].value = cover * artificial_value();
    simplex_[c].rate = cover * artificial_rate();
  }
  FrictionSimplex<Scalar>* const simplices = simplex_.data();
  const Scalar* const x = x_.data();
  const Scalar* const dx = dx_.data();
  const Scalar* const norms = kernel_.norms();
  const Count none = contacts_.nc();  // for columns that belong to no such contact: no branch asks
  FrictionSimplex<Scalar>& nowhere = simplices[none];
  nowhere.value = nowhere.rate = 0;
  const Count order = kernel_.order();
  for (Count j = 0; j < order; ++j) {
    const Label label = kernel_.column_label(j);
    const Count of = label.contact == kArtificial ? none : label.contact;
    const Count place = friction_.is_active(of) ? of : none;
    const Count is_normal = label.direction == kNormal ? 1 : 0;
    FrictionSimplex<Scalar>& own = simplices[place];
    const Scalar weight = own.weights[is_normal];
    own.value += weight * x[j];
    own.rate += weight * dx[j];
    own.norms[is_normal] = norms[j];
  }
  if (!entering.is_velocity && entering.label.contact != kArtificial && friction_.is_active(entering.label.contact)) {
    simplex_[entering.label.contact].rate += simplex_weight(entering.label);
    if (entering.label.is_normal()) simplex_[entering.label.contact].norms[1] = entering_norm_;
  }
}

/// The products of the directions of all contacts with active friction with u and its rate, where the values and falls
/// of their first halves are to stand; the first one's slots begin at `slot`.
template <class Scalar>
template <bool kSkips>
[[gnu::noinline]] void Path<Scalar>::compute_slips(Count slot) {
  const Count ngc = contacts_.ngc();
  const Count count = friction_.count();
  const Scalar* const u = u_.data();
  const Scalar* const du = du_.data();
  Scalar* slips = ratio_test_.values() + slot;
  Scalar* rates = ratio_test_.falls() + slot;
  for (Count k = 0; k < count; ++k) {
    const FrictionSimplex<Scalar>& simplex = simplex_[friction_.contact(k)];
    const Count width = simplex.width;
    const Runs& runs = contacts_.runs(friction_.contact(k));
    for_each_tile<Scalar>(width, [&](auto packs, Count at) __attribute__((always_inline)) {
      const auto sums = products<kSkips, packs.kValue>(simplex.directions + at, width, ngc, runs, u, du);
      for (Count p = 0; p < packs.kValue; ++p) {
        P::store(slips + at + p * P::kWidth, sums.of[0][p]);
        P::store(rates + at + p * P::kWidth, sums.of[1][p]);
      }
    });
    slips += 2 * width + P::padded(2);
    rates += 2 * width + P::padded(2);
  }
  if (contacts_.is_soft()) add_yields_to_slips(slot);
}

/// By itself, so that compute_slips() has no branch for it in its loop.
template <class Scalar>
[[gnu::noinline]] void Path<Scalar>::add_yields_to_slips(Count slot) {
  for (Count k = 0; k < friction_.count(); ++k) {
    const FrictionSimplex<Scalar>& simplex = simplex_[friction_.contact(k)];
    const Count width = simplex.width, tangents = contacts_.tangents_at(friction_.contact(k));
    const Scalar* const rows = simplex.directions + contacts_.ngc() * width;
    Scalar* const slips = ratio_test_.values() + slot;
    Scalar* const rates = ratio_test_.falls() + slot;
    combine_onto(rows, width, 2, u_.data() + tangents, slips, slips, width);
    combine_onto(rows, width, 2, du_.data() + tangents, rates, rates, width);
    slot += 2 * width + P::padded(2);
  }
}

/// @param enters  whether the entering variable is a friction impulse of the contact. @pre compute_slips()
template <class Scalar>
[[gnu::always_inline]] inline void Path<Scalar>::offer_contact(Count contact, bool enters, Count first,
                                                               LeastRatio<Scalar>& least) {
  const FrictionSimplex<Scalar>& simplex = simplex_[contact];
  const Count width = simplex.width;
  Scalar* const values = ratio_test_.values() + first;
  Scalar* const falls = ratio_test_.falls() + first;
  const Scalar* const allowed = simplex.allowed;
  const auto put = [&](Count at, Pack value, Pack fall) __attribute__((always_inline)) {
    P::store(values + at, value);
    P::store(falls + at, fall);
    least.offer(value, fall);
  };
  // Without branches, which from one contact to the next nothing could foretell.
  const Scalar z0 = simplex.cover * artificial_value();
  const Scalar dz0 = simplex.cover * artificial_rate();
  // What is added to +-slip, of the first and second half alike: -d_t'u, or the cover where the base is zero.
  const Scalar shift = simplex.is_zero * z0 - simplex.sign * values[simplex.twin];
  const Scalar shift_rate = simplex.is_zero * dz0 - simplex.sign * falls[simplex.twin];
  const Pack shifts = P::broadcast(shift);
  const Pack shift_falls = P::broadcast(-shift_rate);
  for (Count t = 0; t < width; t += P::kWidth) {
    const Pack slip = P::load(values + t);
    const Pack rate = P::load(falls + t);
    put(t, shifts + slip, (shift_falls - rate) * P::load(allowed + t));
    put(width + t, shifts - slip, (shift_falls + rate) * P::load(allowed + width + t));
  }
  const Scalar preferred = static_cast<Scalar>(kStickingFirst);
  const Scalar uncovered = 1 - simplex.is_zero;
  const Scalar zero_value = preferred * (shift - uncovered * z0);
  const Scalar zero_rate = preferred * allowed[2 * width] * (shift_rate - uncovered * dz0);
  const bool is_supported = friction_.support(contact) > 0;
  const Scalar base_value = simplex.value * simplex.norms[1];
  const Scalar base_rates[] = {0, simplex.rate * simplex.norms[1]};
  const Scalar base_rate = base_rates[is_supported | enters];
  if constexpr (P::kWidth == 1) {
    put(2 * width, zero_value, -zero_rate);
    put(2 * width + 1, base_value, -base_rate);
  } else {
    Pack value = Pack{}, fall = Pack{};
    value[0] = zero_value, value[1] = base_value;
    fall[0] = -zero_rate, fall[1] = -base_rate;
    put(2 * width, value, fall);
  }
}

/// Harris's test: the least ratio `theta` with values moved up by the tie tolerance; of all that are then not above it
/// the one with the fastest rate leaves, z0 before all.
template <class Scalar>
inline LeavingVariable Path<Scalar>::choose_leaving(Scalar theta) const {
  if (!(theta >= 0)) return {Kind::kBroken, -1, {}};
  if (!(theta < kInfinity<Scalar>)) return {};
  theta *= static_cast<Scalar>(1 + 8 * kUnitRoundoff<Scalar>);  // the least ratio's own row is to stay among the tied
  if (artificial_ < 0) {
    if (theta >= 1) return {Kind::kColumn, kPastEnd, Label{}};
  } else if (dx_[artificial_] < 0 && x_[artificial_] <= theta * -dx_[artificial_]) {
    return {Kind::kColumn, artificial_, Label{}};
  }
  return ratio_test_.decode(ratio_test_.fastest_of_tied(least_rate(), theta));
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
