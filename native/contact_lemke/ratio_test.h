#pragma once

#include "native/contact_lemke/basic_variables.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The least of (max(value, 0) + slack) / fall over the values that are offered with the rates at which they fall, as
/// far as these are above `least_rate`.
template <class Scalar>
class LeastRatio {
 public:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;

  LeastRatio(Scalar least_rate, Scalar slack)
      : least_rate_(P::broadcast(least_rate)), slack_(P::broadcast(slack)), least_(P::broadcast(kInfinity<Scalar>)) {}

  [[gnu::always_inline]] inline void offer(Pack value, Pack fall) {
    const Pack ratio = P::max(value + slack_, slack_) / fall;
    least_ = P::min(fall > least_rate_ ? ratio : P::broadcast(kInfinity<Scalar>), least_);
  }
  /// Has value() report a NaN or an infinity in either: offer() may pass over it. For what the offered values and falls
  /// are computed from.
  [[gnu::always_inline]] inline void check(Pack values, Pack rates) {
    poison_ += Scalar(0) * values * rates;
  }

  /// Infinity where no fall is above `least_rate`, -1 where check() has met a NaN or an infinity.
  Scalar value() const { return P::sum(poison_) == 0 ? P::min(least_) : Scalar(-1); }

 private:
  Pack least_rate_, slack_, least_;
  Pack poison_ = Pack{};  ///< 0, or NaN once check() has met a NaN or an infinity
};

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

/// The ratio test over all basic variables: values, how fast they fall, and which of them may leave.
///
/// All stand in m/s, velocities as they are, impulses times |c| |N|. Their slots: normal velocities | columns of the
/// kernel | per contact with active friction, in its order: velocities of the first half of the directions, of the
/// second half, {of the zero direction, the base}; each in whole packs.
template <class Scalar>
class RatioTest {
 public:
  RatioTest(Basis<Scalar>& basis, BasicVariables<Scalar>& variables)
      : variables_(variables),
        contacts_(basis.contacts),
        kernel_(basis.kernel),
        friction_(basis.friction),
        covering_(basis.covering),
        simplex_(basis.simplex) {}

  /// Takes all memory; writes only where the contacts' parts of allowed_ begin. @pre the basis is reserved
  void reserve() {
    allowed_at_.resize(contacts_.nc());
    Count allowed = contacts_.padded_nc();
    for (Count c = 0; c < contacts_.nc(); ++c) {
      allowed_at_[c] = allowed;
      if (contacts_.has_friction(c)) allowed += slots_of(c);
    }
    allowed_.resize(allowed);
    Buffer<Scalar>* const by_slot[] = {&value_, &fall_};
    for (Buffer<Scalar>* buffer : by_slot) buffer->resize(allowed + kernel_.stride());
  }

  /// Velocities that the kernel holds at zero may not leave.
  void allow(Label label) { allowed_[place_of(label)] = 1; }
  void forbid(Label label) { allowed_[place_of(label)] = 0; }
  void allow_normals() {
    for (Count c = 0; c < contacts_.padded_nc(); ++c) allowed_[c] = c < contacts_.nc() ? Scalar(1) : Scalar(0);
  }
  /// All velocities of a contact whose friction was just activated.
  void allow_friction(Count contact) {
    const Count width = contacts_.padded_half(contact);
    const Count half = contacts_.half(contact);
    Scalar* const allowed = allowed_.data() + allowed_at_[contact];
    for (Count t = 0; t < slots_of(contact); ++t) allowed[t] = 0;
    for (Count t = 0; t < half; ++t) allowed[t] = allowed[width + t] = 1;
    allowed[2 * width] = 1;
    forbid(Label{contact, friction_.base(contact)});
  }
  /// 1 where a velocity of the contact may leave, else 0, by its slots.
  const Scalar* allowed_of(Count contact) const { return allowed_.data() + allowed_at_[contact]; }

  /// The variable that leaves as `entering` enters, by Harris's test: the least ratio theta with values moved up by the
  /// tie tolerance; of all that are then not above it the one with the fastest rate leaves, z0 before all. Rounding
  /// alone breaks ties, so that a path may cycle, until the limit on its pivots.
  /// @pre the variables have values and rates
  LeavingVariable find_leaving(const Entering& entering) {
    Scalar theta =
        contacts_.skips_zeros() ? compute_candidates<true>(entering) : compute_candidates<false>(entering);
    if (!(theta >= 0)) return {Kind::kBroken, -1, {}};
    if (!(theta < kInfinity<Scalar>)) return {};
    theta *= static_cast<Scalar>(1 + 8 * kUnitRoundoff<Scalar>);  // the least ratio's own row is to stay among the tied
    const Count z0 = kernel_.artificial();
    if (z0 < 0 && theta >= 1) return {};  // of z0 itself, which enters at 1 and comes to its end
    if (z0 >= 0 && variables_.dx[z0] < 0 && variables_.x[z0] <= theta * -variables_.dx[z0]) {
      return {Kind::kColumn, z0, Label{}};
    }
    return decode(fastest_of_tied(variables_.least_rate(rate_scale_), theta));
  }

  /// Of all contacts, padded: N'u. Valid until the next find_leaving().
  const Scalar* normal_velocities(const Scalar* u) {
    const Count length = contacts_.padded_nc();
    combine(contacts_.normals(), length, contacts_.ngc(), u, value_.data(), length);
    return value_.data();
  }

  /// Slots of the last find_leaving().
  Count slots() const { return end_; }

 private:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  using Kind = LeavingVariable::Kind;
  static constexpr Count kTogether = 64;  ///< slots whose bits one word holds
  /// Where slip ends, lambda and the slip in the opposite direction reach zero together. In the ratio test lambda is
  /// multiplied by this, so that it leaves first: the unused share of friction becomes basic, instead of the opposite
  /// direction.
  static constexpr double kStickingFirst = 4;

  /// Values of all candidates and how fast they fall. @returns their least ratio
  /// @tparam kSkips  Contacts::skips_zeros(): asked once for all products, because each is short where it is false
  template <bool kSkips>
  [[gnu::noinline]] Scalar compute_candidates(const Entering& entering) {
    compute_base_values(entering);
    compute_column_candidates();
    LeastRatio<Scalar> least(variables_.least_rate(rate_scale_), variables_.tie_tolerance());
    for (Count i = 0; i < contacts_.extent(); i += P::kWidth) {
      least.check(P::load(variables_.u.data() + i), P::load(variables_.du.data() + i));
    }
    offer_normals<kSkips>(least);
    const Count end_of_columns = first_column() + P::padded(kernel_.order());
    for (Count i = first_column(); i < end_of_columns; i += P::kWidth) {
      const Pack value = P::load(value_.data() + i), fall = P::load(fall_.data() + i);
      least.check(value, fall);
      least.offer(value, fall);
    }
    const bool is_friction = !entering.is_velocity && entering.label.direction != kNormal;
    const Count entering_contact = is_friction ? entering.label.contact : kArtificial;
    compute_slips<kSkips>(end_of_columns);
    end_ = end_of_columns;
    for (Count k = 0; k < friction_.count(); ++k) {
      const Count contact = friction_.contact(k);
      offer_contact(contact, contact == entering_contact, end_, least);
      end_ += 2 * simplex_[contact].width + P::padded(2);
    }
    return least.value();
  }

  /// f_t = mu f_N + cover z0 - (the contact's other friction impulses)
  void compute_base_values(const Entering& entering) {
    for (Count k = 0; k < friction_.count(); ++k) {
      const Count c = friction_.contact(k);
      const Scalar cover = covering_.of_cone(c);
      simplex_[c].value = cover * variables_.artificial_value();
      simplex_[c].rate = cover * variables_.artificial_rate();
    }
    FrictionSimplex<Scalar>* const simplices = simplex_.data();
    const Scalar* const x = variables_.x.data();
    const Scalar* const dx = variables_.dx.data();
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
    if (entering.is_velocity || entering.label.contact == kArtificial) return;
    if (!friction_.is_active(entering.label.contact)) return;
    FrictionSimplex<Scalar>& own = simplices[entering.label.contact];
    own.rate += own.weights[entering.label.is_normal() ? 1 : 0];
    if (entering.label.is_normal()) own.norms[1] = variables_.entering_norm;
  }

  void compute_column_candidates() {
    const Count order = kernel_.order();
    const Scalar* const norms = kernel_.norms();
    Scalar* const values = value_.data() + first_column();
    Scalar* const falls = fall_.data() + first_column();
    Pack largest = P::broadcast(variables_.entering_norm);
    for (Count j = 0; j < order; j += P::kWidth) {
      const Pack norm = P::load(norms + j);
      const Pack rate = entries_of<Scalar>(P::load(variables_.dx.data() + j) * norm, j, order);
      P::store(values + j, entries_of<Scalar>(P::load(variables_.x.data() + j) * norm, j, order));
      P::store(falls + j, -rate);
      largest = larger_magnitude<Scalar>(rate, largest);
    }
    rate_scale_ = P::max(largest);
  }

  template <bool kSkips>
  [[gnu::always_inline]] inline void offer_normals(LeastRatio<Scalar>& least) {
    const Count length = contacts_.padded_nc();
    const Scalar* const u = variables_.u.data();
    const Scalar* const du = variables_.du.data();
    const Scalar z0 = variables_.artificial_value();
    const Scalar dz0 = variables_.artificial_rate();
    const bool is_soft = contacts_.is_soft();
    const Scalar* const yields = u + contacts_.normal_at(0);
    const Scalar* const yield_rates = du + contacts_.normal_at(0);
    for_each_tile<Scalar>(length, [&](auto packs, Count at) {
      const auto sums = products<kSkips, packs.kValue>(contacts_.normals() + at, length, contacts_.ngc(),
                                                       contacts_.normal_runs(at), u, du);
      for (Count p = 0; p < packs.kValue; ++p) {
        const Count i = at + p * P::kWidth;
        const Pack cover = P::load(covering_.of_normals() + i);
        Pack value = sums.of[0][p], rate = sums.of[1][p];
        if (is_soft) value += P::load(yields + i), rate += P::load(yield_rates + i);
        value += cover * z0;
        const Pack fall = (-rate - cover * dz0) * P::load(allowed_.data() + i);
        P::store(value_.data() + i, value);
        P::store(fall_.data() + i, fall);
        least.offer(value, fall);
      }
    });
  }

  /// The products of the directions of all contacts with active friction with u and its rate, where the values and
  /// falls of their first halves are to stand; the first one's slots begin at `slot`.
  template <bool kSkips>
  [[gnu::noinline]] void compute_slips(Count slot) {
    const Count ngc = contacts_.ngc();
    const Count count = friction_.count();
    const Scalar* const u = variables_.u.data();
    const Scalar* const du = variables_.du.data();
    Scalar* slips = value_.data() + slot;
    Scalar* rates = fall_.data() + slot;
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
  [[gnu::noinline]] void add_yields_to_slips(Count slot) {
    for (Count k = 0; k < friction_.count(); ++k) {
      const FrictionSimplex<Scalar>& simplex = simplex_[friction_.contact(k)];
      const Count width = simplex.width, tangents = contacts_.tangents_at(friction_.contact(k));
      const Scalar* const rows = simplex.directions + contacts_.ngc() * width;
      Scalar* const slips = value_.data() + slot;
      Scalar* const rates = fall_.data() + slot;
      combine_onto(rows, width, 2, variables_.u.data() + tangents, slips, slips, width);
      combine_onto(rows, width, 2, variables_.du.data() + tangents, rates, rates, width);
      slot += 2 * width + P::padded(2);
    }
  }

  /// @param enters  whether the entering variable is a friction impulse of the contact. @pre compute_slips()
  [[gnu::always_inline]] inline void offer_contact(Count contact, bool enters, Count first, LeastRatio<Scalar>& least) {
    const FrictionSimplex<Scalar>& simplex = simplex_[contact];
    const Count width = simplex.width;
    Scalar* const values = value_.data() + first;
    Scalar* const falls = fall_.data() + first;
    const Scalar* const allowed = simplex.allowed;
    const auto put = [&](Count at, Pack value, Pack fall) __attribute__((always_inline)) {
      P::store(values + at, value);
      P::store(falls + at, fall);
      least.offer(value, fall);
    };
    // Without branches, which from one contact to the next nothing could foretell.
    const Scalar z0 = simplex.cover * variables_.artificial_value();
    const Scalar dz0 = simplex.cover * variables_.artificial_rate();
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

  /// Of all whose ratio is not above `theta`, the slot with the fastest fall; -1 where there is none. Of equal
  /// ones the one in the first lane of a pack.
  /// @pre least_rate and theta are at least 0
  Count fastest_of_tied(Scalar least_rate, Scalar theta) const {
    const Pack least = P::broadcast(least_rate);
    Scalar fastest = least_rate;
    Count best = -1;
    for (Count first = 0; first < end_; first += kTogether) {
      const Count end = end_ < first + kTogether ? end_ : first + kTogether;
      std::uint64_t tied = 0;  // one bit for each slot: few are
      for (Count i = first; i < end; i += P::kWidth) {
        const Pack fall = P::load(fall_.data() + i);
        const auto is_tied = (P::load(value_.data() + i) <= theta * fall) & (fall > least);
        tied |= lanes_where<Scalar>(is_tied) << (i - first);
      }
      for (; tied != 0; tied &= tied - 1) {
        const Count slot = first + __builtin_ctzll(tied);
        const bool is_first = fall_[slot] == fastest && best >= 0 && slot % P::kWidth < best % P::kWidth;
        best = fall_[slot] > fastest || is_first ? slot : best;
        fastest = fall_[best];
      }
    }
    return best;
  }

  /// What stands in a slot.
  LeavingVariable decode(Count slot) const {
    if (slot < 0) return {Kind::kBroken, -1, {}};
    if (slot < contacts_.padded_nc()) return {Kind::kVelocity, -1, Label{slot, kNormal}};
    Count first = first_column() + P::padded(kernel_.order());
    if (slot < first) {
      const Count column = slot - first_column();
      return {Kind::kColumn, column, kernel_.column_label(column)};
    }
    Count k = 0;
    for (; slot >= first + slots_of(friction_.contact(k)); ++k) first += slots_of(friction_.contact(k));
    const Count contact = friction_.contact(k);
    const Count width = contacts_.padded_half(contact);
    const Count half = contacts_.half(contact);
    const Count place = slot - first;
    if (place == 2 * width + 1) return {Kind::kBase, -1, Label{contact, friction_.base(contact)}};
    if (place == 2 * width) return {Kind::kVelocity, -1, Label{contact, 2 * half}};
    return {Kind::kVelocity, -1, Label{contact, place < width ? place : place - width + half}};
  }

  Count first_column() const { return contacts_.padded_nc(); }
  Count slots_of(Count contact) const { return 2 * contacts_.padded_half(contact) + P::padded(2); }

  /// In allowed_.
  Count place_of(Label label) const {
    if (label.is_normal()) return label.contact;
    const Count half = contacts_.half(label.contact);
    const Count width = contacts_.padded_half(label.contact);
    const Count at = allowed_at_[label.contact];
    if (label.direction == 2 * half) return at + 2 * width;
    return label.direction < half ? at + label.direction : at + width + label.direction - half;
  }

  const BasicVariables<Scalar>& variables_;
  const Contacts<Scalar>& contacts_;
  const Kernel<Scalar>& kernel_;
  const FrictionState& friction_;
  const CoveringVector<Scalar>& covering_;
  Buffer<FrictionSimplex<Scalar>>& simplex_;
  Count end_ = 0;
  Scalar rate_scale_ = 0;  ///< the largest rate of an impulse, in m/s
  Buffer<Count> allowed_at_;
  Buffer<Scalar> value_, fall_, allowed_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
