#pragma once

#include "native/contact_lemke/kernel.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Which contacts have friction in the basis. The friction of such a contact is active: one of its basic impulses is
/// its base, which is eliminated (see Path), and `support` counts the others, which are unknowns of the kernel.
class FrictionState {
 public:
  /// Takes all memory; touches none of it.
  void reserve(Count contacts) {
    is_active_.resize(contacts);
    Buffer<Count>* const counts[] = {&active_, &base_, &support_};
    for (Buffer<Count>* buffer : counts) buffer->resize(contacts);
  }

  /// No friction is active.
  void clear(Count contacts) {
    count_ = 0;
    is_active_.fill(contacts, false);
  }

  void activate(Count contact, Count base) {
    is_active_[contact] = true;
    active_[count_++] = contact;
    base_[contact] = base;
    support_[contact] = 0;
  }

  /// @pre it is active
  void deactivate(Count contact) {
    is_active_[contact] = false;
    Count k = 0;
    while (active_[k] != contact) ++k;
    active_[k] = active_[--count_];
  }

  /// The unknown of this label enters the kernel (`change` 1) or leaves it (-1).
  void count_unknown(Label label, Count change) {
    if (label.contact != kArtificial && !label.is_normal()) support_[label.contact] += change;
  }
  void set_base(Count contact, Count direction) { base_[contact] = direction; }

  bool is_active(Count contact) const { return is_active_[contact]; }
  /// The contacts with active friction, in no order.
  Count count() const { return count_; }
  Count contact(Count k) const { return active_[k]; }
  // Of a contact with active friction:
  Count base(Count contact) const { return base_[contact]; }
  Count support(Count contact) const { return support_[contact]; }

 private:
  Buffer<bool> is_active_;
  Buffer<Count> active_, base_, support_;
  Count count_ = 0;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
