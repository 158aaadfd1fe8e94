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

/// The least ratio of values moved up by `slack` to rates of fall above `least_rate`.
template <class Scalar>
class LeastRatio {
 public:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;

  LeastRatio(Scalar least_rate, Scalar slack)
      : least_rate_(P::broadcast(least_rate)), slack_(P::broadcast(slack)), least_(P::broadcast(kInfinity<Scalar>)) {}

  void offer(Pack value, Pack rate) {
    const Pack fall = -rate;
    const Pack ratio = (P::max(value, Pack{}) + slack_) / fall;
    least_ = P::min(fall > least_rate_ ? ratio : P::broadcast(kInfinity<Scalar>), least_);
    poison_ += Scalar(0) * fall + Scalar(0) * value;
  }

  /// Infinity where there is none, -1 where a value or rate is no number.
  Scalar value() const { return P::sum(poison_) == 0 ? P::min(least_) : Scalar(-1); }

 private:
  Pack least_rate_, slack_, least_;
  Pack poison_ = Pack{};
};

/// The ratio test over all basic variables: values, rates, and which of them may leave.
///
/// All stand in m/s, velocities as they are, impulses times |c| |N|. Their slots: normal velocities | columns of the
/// kernel | per contact with friction: velocities of the first half of the directions, of the second half, {of the zero
/// direction, the base}.
template <class Scalar>
class RatioTest {
 public:
  RatioTest(const Contacts<Scalar>& contacts, const Kernel<Scalar>& kernel, const FrictionState& friction)
      : contacts_(contacts), kernel_(kernel), friction_(friction) {}

  /// Takes all memory; writes only where slots begin. @pre the contacts and the kernel are reserved
  void reserve() {
    slot_at_.resize(contacts_.nc());
    first_column_ = contacts_.padded_nc();
    slots_ = first_column_ + kernel_.stride();
    for (Count c = 0; c < contacts_.nc(); ++c) {
      slot_at_[c] = slots_;
      if (contacts_.has_friction(c)) slots_ += slots_of(c);
    }
    Buffer<Scalar>* const by_slot[] = {&value_, &rate_, &allowed_};
    for (Buffer<Scalar>* buffer : by_slot) buffer->resize(slots_);
  }

  Scalar* values() { return value_.data(); }
  Scalar* rates() { return rate_.data(); }
  /// 1 where a slot may leave, else 0.
  const Scalar* allowed() const { return allowed_.data(); }
  Count first_column() const { return first_column_; }
  Count first_slot(Count contact) const { return slot_at_[contact]; }

  /// Velocities that the kernel holds at zero may not leave.
  void allow(Label label) { allowed_[slot(label)] = 1; }
  void forbid(Label label) { allowed_[slot(label)] = 0; }
  void allow_normals() {
    for (Count c = 0; c < contacts_.padded_nc(); ++c) allowed_[c] = c < contacts_.nc() ? Scalar(1) : Scalar(0);
  }
  /// All velocities of a contact whose friction was just activated.
  void allow_friction(Count contact) {
    const Count width = contacts_.padded_half(contact);
    const Count half = contacts_.half(contact);
    Scalar* const allowed = allowed_.data() + slot_at_[contact];
    for (Count t = 0; t < slots_of(contact); ++t) allowed[t] = 0;
    for (Count t = 0; t < half; ++t) allowed[t] = allowed[width + t] = 1;
    allowed[2 * width] = 1;
    forbid(Label{contact, friction_.base(contact)});
  }

  /// All slots in use, in ranges of whole packs.
  template <class Visit>
  void for_each_segment(Visit visit) const {
    visit(Count(0), contacts_.padded_nc());
    visit(first_column_, first_column_ + P::padded(kernel_.order()));
    for (Count k = 0; k < friction_.count(); ++k) {
      const Count first = slot_at_[friction_.contact(k)];
      visit(first, first + slots_of(friction_.contact(k)));
    }
  }

  /// Of all whose ratio is not above `theta`, the slot with the fastest rate; -1 where there is none.
  Count fastest_of_tied(Scalar least_rate, Scalar theta) const {
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

  /// What stands in a slot.
  LeavingVariable decode(Count slot) const {
    if (slot < 0) return {Kind::kBroken, -1, {}};
    if (slot < contacts_.padded_nc()) return {Kind::kVelocity, -1, Label{slot, kNormal}};
    if (slot < first_column_ + kernel_.stride()) {
      const Count column = slot - first_column_;
      return {Kind::kColumn, column, kernel_.column_label(column)};
    }
    Count contact = 0;
    for (Count k = 0; k < friction_.count(); ++k) {
      const Count first = slot_at_[friction_.contact(k)];
      if (slot >= first && slot < first + slots_of(friction_.contact(k))) contact = friction_.contact(k);
    }
    const Count width = contacts_.padded_half(contact);
    const Count half = contacts_.half(contact);
    const Count place = slot - slot_at_[contact];
    if (place == 2 * width + 1) return {Kind::kBase, -1, Label{contact, friction_.base(contact)}};
    if (place == 2 * width) return {Kind::kVelocity, -1, Label{contact, 2 * half}};
    return {Kind::kVelocity, -1, Label{contact, place < width ? place : place - width + half}};
  }

 private:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  using Kind = LeavingVariable::Kind;

  Count slots_of(Count contact) const { return 2 * contacts_.padded_half(contact) + P::padded(2); }

  Count slot(Label label) const {
    if (label.is_normal()) return label.contact;
    const Count half = contacts_.half(label.contact);
    const Count width = contacts_.padded_half(label.contact);
    const Count at = slot_at_[label.contact];
    if (label.direction == 2 * half) return at + 2 * width;
    return label.direction < half ? at + label.direction : at + width + label.direction - half;
  }

  const Contacts<Scalar>& contacts_;
  const Kernel<Scalar>& kernel_;
  const FrictionState& friction_;
  Count first_column_ = 0, slots_ = 0;
  Buffer<Count> slot_at_;
  Buffer<Scalar> value_, rate_, allowed_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
