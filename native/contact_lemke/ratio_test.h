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

/// The least ratio of values moved up by `slack` to falls, the rates at which they fall, above `least_rate`.
template <class Scalar>
class LeastRatio {
 public:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;

  LeastRatio(Scalar least_rate, Scalar slack)
      : least_rate_(P::broadcast(least_rate)), slack_(P::broadcast(slack)), least_(P::broadcast(kInfinity<Scalar>)) {}

  [[gnu::always_inline]] inline void offer(Pack value, Pack fall) {
    const Pack ratio = (P::max(value, Pack{}) + slack_) / fall;
    least_ = P::min(fall > least_rate_ ? ratio : P::broadcast(kInfinity<Scalar>), least_);
    poison_ += Scalar(0) * fall + Scalar(0) * value;
  }

  /// Infinity where there is none, -1 where a value or fall is no number.
  Scalar value() const { return P::sum(poison_) == 0 ? P::min(least_) : Scalar(-1); }

 private:
  Pack least_rate_, slack_, least_;
  Pack poison_ = Pack{};
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
    for (Buffer<Scalar>* buffer : by_slot) buffer->resize(allowed + kernel_.stride() + P::kWidth);
  }

  Scalar* values() { return value_.data(); }
  /// Where a slot may leave, minus its rate, else 0.
  Scalar* falls() { return fall_.data(); }
  /// 1 where a velocity may leave, else 0: of normals, and of a contact's slots.
  const Scalar* allowed_normals() const { return allowed_.data(); }
  const Scalar* allowed_of(Count contact) const { return allowed_.data() + allowed_at_[contact]; }
  Count first_column() const { return contacts_.padded_nc(); }
  Count slots_of(Count contact) const { return 2 * contacts_.padded_half(contact) + P::padded(2); }
  /// One behind the last slot in use. What is between that and the next pair of packs does not fall.
  Count end() const { return end_; }
  void end_at(Count slot) {
    end_ = slot;
    P::store(fall_.data() + slot, Pack{});
    P::store(value_.data() + slot, Pack{});
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

  /// Of all whose ratio is not above `theta`, the slot with the fastest fall; -1 where there is none.
  /// @pre least_rate and theta are at least 0
  Count fastest_of_tied(Scalar least_rate, Scalar theta) const {
    // Two races side by side, in which the first of equals wins.
    const Pack step = P::broadcast(static_cast<Scalar>(static_cast<double>(2 * P::kWidth)));
    Pack fastest = P::broadcast(least_rate), other_fastest = fastest;
    Pack where = P::broadcast(Scalar(-1)), other_where = where;
    Pack at = Pack{}, other_at = P::broadcast(static_cast<Scalar>(static_cast<double>(P::kWidth)));
    for (Count i = 0; i < end_; i += 2 * P::kWidth) {
      const Pack tied = tied_falls(i, theta), other_tied = tied_falls(i + P::kWidth, theta);
      where = tied > fastest ? at : where;
      other_where = other_tied > other_fastest ? other_at : other_where;
      fastest = P::max(tied, fastest);
      other_fastest = P::max(other_tied, other_fastest);
      at += step;
      other_at += step;
    }
    const auto is_faster = other_fastest > fastest;
    const auto is_equal = other_fastest == fastest;
    const auto is_before = other_where < where;
    where = is_faster | (is_equal & is_before) ? other_where : where;
    fastest = P::max(other_fastest, fastest);
    Scalar falls[static_cast<std::size_t>(P::kWidth)];
    Scalar places[static_cast<std::size_t>(P::kWidth)];
    P::store(falls, fastest);
    P::store(places, where);
    Count best = 0;  // the first lane with the fastest: those without a place have least_rate
    for (Count lane = 1; lane < P::kWidth; ++lane) best = falls[lane] > falls[best] ? lane : best;
    return places[best] >= 0 ? static_cast<Count>(static_cast<double>(places[best])) + best : -1;
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

  /// Falls of those in a pack whose ratio is not above theta, zeros of the others.
  Pack tied_falls(Count first, Scalar theta) const {
    const Pack fall = P::load(fall_.data() + first);
    return P::load(value_.data() + first) <= theta * fall ? fall : Pack{};
  }

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
