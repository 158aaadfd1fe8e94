#pragma once

#include "native/contact_lemke/contacts.h"
#include "native/contact_lemke/polish.h"
#include "native/contact_lemke/response.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Polishes the answer of another method from its basis.
///
/// A contact presses where f_N is basic. Where its lambda is basic its friction is used up: one basic direction t, the
/// largest, is eliminated by f_t = mu f_N - (the others), and the slips of the others equal its own. Else each basic
/// direction stands for itself, and its slip is zero.
template <class Scalar>
class BasisPolish {
 public:
  BasisPolish(Contacts<Scalar>& contacts, Response<Scalar>& response) : contacts_(contacts), response_(response) {}

  void load() {
    polish_.load(contacts_.ngc());
    fill_with_zeros(contacts_.padded_ngc(), a_, b_, u_);
    parts_.resize(contacts_.ngc());
  }

  /// On success z has the impulses, and velocity (moving()) what they lead to; else both are left alone. Lambdas are
  /// not touched. False where G is singular, or so is the basis.
  bool run(const char* basic, double* velocity, double* z) {
    if (!response_.full_rank()) return false;
    polish_.clear();
    count_ = 0;
    Count lambda = contacts_.nc() + contacts_.first_direction(contacts_.nc());
    for (Count c = 0; c < contacts_.nc(); ++c) {
      const bool slides = contacts_.edges(c) > 0 && basic[lambda++] != 0;
      if (basic[c] != 0 && !add_contact(c, slides && contacts_.has_friction(c), basic, z)) return false;
    }
    if (count_ == 0) {
      copy(u_.data(), contacts_.velocity(), contacts_.padded_ngc());
    } else if (!polish_.run(contacts_, response_, u_.data())) {
      return false;
    }
    for (Count i = 0; i < contacts_.moving(); ++i) velocity[i] = static_cast<double>(u_[i]);
    write_impulses(z);
    return true;
  }

 private:
  static constexpr Count kNormal = -1;

  /// What a column of the projection stands for.
  struct Part {
    Count contact;
    Count direction;  ///< kNormal: the normal impulse
    Count base;       ///< of a normal: the direction that its contact's friction is used up with, or kNormal
  };

  bool add_contact(Count contact, bool slides, const char* basic, const double* z) {
    const Count first = contacts_.nc() + contacts_.first_direction(contact);
    const double* const friction = z + first;
    const char* const is_basic = basic + first;
    Count base = kNormal;
    for (Count t = 0; slides && t < contacts_.edges(contact); ++t) {
      if (is_basic[t] != 0 && (base == kNormal || friction[t] > friction[base])) base = t;
    }
    if (slides && base == kNormal) return false;
    if (!add_normal(contact, base)) return false;
    if (!contacts_.has_friction(contact)) return true;
    for (Count t = 0; t < contacts_.edges(contact); ++t) {
      if (t != base && is_basic[t] != 0 && !add_direction(contact, t, base)) return false;
    }
    return true;
  }

  bool add_normal(Count contact, Count base) {
    contacts_.get_normal(contact, b_.data());
    contacts_.get_normal(contact, a_.data());
    if (base != kNormal) contacts_.add_direction(contact, base, contacts_.mu(contact), a_.data());
    return add_part({contact, kNormal, base});
  }

  bool add_direction(Count contact, Count direction, Count base) {
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) a_[i] = 0;
    contacts_.add_direction(contact, direction, Scalar(1), a_.data());
    if (base != kNormal) contacts_.add_direction(contact, base, Scalar(-1), a_.data());
    copy(b_.data(), a_.data(), contacts_.padded_ngc());
    return add_part({contact, direction, base});
  }

  /// Of the column a_ and the row b_.
  bool add_part(Part part) {
    Scalar* const column = polish_.next_column();
    Scalar* const row = polish_.next_row(contacts_.offset_in(b_.data()));
    if (column == nullptr || row == nullptr) return false;
    response_.whiten(a_.data(), column);
    response_.whiten(b_.data(), row);
    parts_[count_++] = part;
    return true;
  }

  void write_impulses(double* z) {
    const Count friction = contacts_.nc();
    for (Count j = 0; j < friction + contacts_.first_direction(contacts_.nc()); ++j) z[j] = 0;
    Scalar base_impulse = 0;
    for (Count k = 0; k < count_; ++k) {
      const Part& part = parts_[k];
      const Scalar impulse = polish_.impulse(k);
      const Count first = friction + contacts_.first_direction(part.contact);
      if (part.direction == kNormal) {
        z[part.contact] = static_cast<double>(impulse);
        base_impulse = contacts_.mu(part.contact) * impulse;
      } else {
        z[first + part.direction] = static_cast<double>(impulse);
        base_impulse -= impulse;
      }
      const bool last_of_contact = k + 1 == count_ || parts_[k + 1].contact != part.contact;
      if (last_of_contact && part.base != kNormal) z[first + part.base] = static_cast<double>(base_impulse);
    }
  }

  Contacts<Scalar>& contacts_;
  Response<Scalar>& response_;
  Polish<Scalar> polish_;
  Buffer<Scalar> a_, b_, u_;
  Buffer<Part> parts_;
  Count count_ = 0;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
