#pragma once

#include "native/contact_lemke/kernel.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Which contacts have basic friction impulses: the friction of these is active. One of a contact's basic friction
/// impulses is its base, which is eliminated (see Basis); `support` counts the others, which are unknowns of the kernel.
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

  /// With no friction impulse but the base. @pre it is not active
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
  /// The contacts with active friction, in an order that only activate() and deactivate() change.
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

/// What the ratio test reads at each pivot of a contact with active friction, in one place. t is the direction of its
/// base; the zero direction is that of the unused share mu f_N - sum f_D (see Contacts).
template <class Scalar>
struct FrictionSimplex {
  const Scalar* directions = nullptr;  ///< Contacts::block()
  const Scalar* allowed = nullptr;     ///< RatioTest::allowed_of()
  Count width = 0;                     ///< Contacts::padded_half()
  Count twin = 0;                      ///< the one of t and -t that is in the first half; 0 for the zero direction
  Scalar sign = 0;                     ///< 1 where t is in the first half, -1 in the second, 0 for the zero direction
  Scalar is_zero = 0;                  ///< 1 where t is the zero direction, else 0
  Scalar cover = 0;                    ///< CoveringVector::of_directions()
  Scalar value = 0, rate = 0;          ///< of f_t
  /// Coefficients in f_t of the other friction impulses, -1, and of f_N, mu. Both 0 in the entry for no contact.
  Scalar weights[2] = {0, 0};
  /// [1]: Kernel::norm() of the normal. [0] is written only so that compute_base_values() needs no branch.
  Scalar norms[2] = {0, 0};

  void set_base(Count base, Count half) {
    is_zero = static_cast<Scalar>(base == 2 * half ? 1 : 0);
    twin = base == 2 * half ? 0 : (base < half ? base : base - half);
    sign = static_cast<Scalar>(base == 2 * half ? 0 : (base < half ? 1 : -1));
  }
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
