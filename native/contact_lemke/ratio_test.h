#pragma once

#include "native/contact_lemke/contacts.h"
#include "native/contact_lemke/friction_state.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// What leaves the basis.
struct LeavingVariable {
  enum class Kind { kNone, kColumn, kBase, kVelocity, kBroken };
  Kind kind = Kind::kNone;
  Count column = -1;  ///< kColumn
  Label label;        ///< kBase: the contact; kVelocity: whose
};

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

/// The ratio test over all basic variables: values, how fast they fall, and which of them may leave.
///
/// All stand in m/s, velocities as they are, impulses times |c| |N|. Their slots: normal velocities | columns of the
/// kernel | per contact with active friction, in its order: velocities of the first half of the directions, of the
/// second half, {of the zero direction, the base}; each in whole packs.
template <class Scalar>
class RatioTest {
 public:
  RatioTest(const Contacts<Scalar>& contacts, const Kernel<Scalar>& kernel, const FrictionState& friction)
      : contacts_(contacts), kernel_(kernel), friction_(friction) {}

  /// Takes all memory; writes only where the contacts' parts of allowed_ begin. @pre the contacts and the kernel are
  /// reserved
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

  Scalar* values() { return value_.data(); }
  /// Where a slot may leave, minus its rate, else 0.
  Scalar* falls() { return fall_.data(); }
  /// 1 where a velocity may leave, else 0: of normals, and of a contact's slots.
  const Scalar* allowed_normals() const { return allowed_.data(); }
  const Scalar* allowed_of(Count contact) const { return allowed_.data() + allowed_at_[contact]; }
  Count first_column() const { return contacts_.padded_nc(); }
  Count slots_of(Count contact) const { return 2 * contacts_.padded_half(contact) + P::padded(2); }
  /// One behind the last slot in use.
  Count end() const { return end_; }
  void end_at(Count slot) { end_ = slot; }

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

 private:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  using Kind = LeavingVariable::Kind;
  static constexpr Count kTogether = 64;  ///< slots whose bits one word holds

  /// In allowed_.
  Count place_of(Label label) const {
    if (label.is_normal()) return label.contact;
    const Count half = contacts_.half(label.contact);
    const Count width = contacts_.padded_half(label.contact);
    const Count at = allowed_at_[label.contact];
    if (label.direction == 2 * half) return at + 2 * width;
    return label.direction < half ? at + label.direction : at + width + label.direction - half;
  }

  const Contacts<Scalar>& contacts_;
  const Kernel<Scalar>& kernel_;
  const FrictionState& friction_;
  Count end_ = 0;
  Buffer<Count> allowed_at_;
  Buffer<Scalar> value_, fall_, allowed_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
