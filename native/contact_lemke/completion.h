#pragma once

#include "native/contact_lemke/contacts.h"
#include "native/contact_lemke/response.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Completes impulses by the lambdas that they allow, and measures the answer from the raw data.
template <class Scalar>
class Completion {
 public:
  Completion(Contacts<Scalar>& contacts, Response<Scalar>& response) : contacts_(contacts), response_(response) {}

  /// Takes all memory that load() needs. @pre the contacts are reserved
  void reserve() {
    Buffer<Scalar>* const by_coordinate[] = {&impulse_, &magnitude_, &change_, &u_};
    for (Buffer<Scalar>* buffer : by_coordinate) buffer->resize(contacts_.padded_ngc());
    normal_velocity_.resize(contacts_.padded_nc());
    slip_.resize(contacts_.most_padded_half());
  }

  void load() {
    reserve();
    fill_with_zeros(contacts_.padded_ngc(), impulse_, magnitude_, change_, u_);
  }

  contact_lemke::Residual run(double* z) {
    add_impulses(z, contacts_.nc() + contacts_.first_direction(contacts_.nc()));
    response_.apply(impulse_.data(), change_.data());
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) u_[i] = contacts_.velocity()[i] + change_[i];
    worst_ = 0;
    measure_normals(z);
    Count lambda = contacts_.nc() + contacts_.first_direction(contacts_.nc());
    for (Count c = 0; c < contacts_.nc(); ++c) {
      if (contacts_.edges(c) > 0) measure_friction(c, z, z[lambda++]);
    }
    contact_lemke::Residual residual;
    const Scalar with_rounding = worst_ + rounding();
    const Scalar scale = q_max(with_rounding);
    residual.velocity = relative(worst_, scale);
    residual.certain = relative(with_rounding, scale);
    return residual;
  }

  /// velocity (ngc) := v + G* [N D] z
  void respond(const double* z, double* velocity) {
    add_impulses(z, contacts_.nc() + contacts_.first_direction(contacts_.nc()));
    response_.apply(impulse_.data(), change_.data());
    for (Count i = 0; i < contacts_.ngc(); ++i) {
      velocity[i] = static_cast<double>(contacts_.velocity()[i] + change_[i]);
    }
  }

  /// Whether u proves to rounding that there is no solution, see engine.h.
  bool disproves(const double* u) {
    if (!response_.may_be_singular()) return false;
    add_impulses(u, contacts_.nc());
    response_.apply(impulse_.data(), change_.data());
    const Count length = contacts_.padded_ngc();
    const Scalar terms = square_root(dot(magnitude_.data(), magnitude_.data(), length));
    const Scalar moved = square_root(dot(change_.data(), change_.data(), length));
    const Scalar blocked = -dot(impulse_.data(), contacts_.velocity(), length);
    const Scalar rounding = static_cast<Scalar>(kProofRoundings * kUnitRoundoff<Scalar>) * terms;
    return moved <= rounding * response_.norm() && blocked > rounding * contacts_.speed();
  }

 private:
  void add_impulses(const double* z, Count columns) {
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) impulse_[i] = magnitude_[i] = 0;
    for (Count j = 0; j < columns; ++j) {
      if (z[j] == 0) continue;
      const Scalar f = static_cast<Scalar>(z[j]);
      const double* const column = contacts_.impulse_column(j);
      for (Count i = 0; i < contacts_.ngc(); ++i) {
        const Scalar part = f * static_cast<Scalar>(column[i]);
        impulse_[i] += part;
        magnitude_[i] += magnitude(part);
      }
    }
  }

  /// A row with z_i > 0 is off by min(M_ii z_i, w_i) <= |w_i|, one with z_i = 0 by -w_i.
  void offer(Scalar w, double z) { note(z > 0 || !(w >= 0) ? magnitude(w) : Scalar(0)); }

  /// What is no number, or too large for one, stays the worst.
  void note(Scalar off) {
    if (!(off <= worst_)) worst_ = number_or_infinity(off);
  }

  void measure_normals(const double* z) {
    const Count length = contacts_.padded_nc();
    combine(contacts_.normals(), length, contacts_.ngc(), u_.data(), normal_velocity_.data(), length);
    for (Count c = 0; c < contacts_.nc(); ++c) offer(normal_velocity_[c], z[c]);
  }

  void measure_friction(Count contact, const double* z, double& lambda) {
    const Count first = contacts_.nc() + contacts_.first_direction(contact);
    const Count edges = contacts_.edges(contact);
    if (!(z[contact] > 0)) {
      lambda = static_cast<double>(contacts_.largest_slip(contact, u_.data()));
      if (!(lambda - lambda == 0)) note(kInfinity<Scalar>);
      for (Count t = 0; t < edges; ++t) {
        if (z[first + t] > 0) worst_ = kInfinity<Scalar>;  // friction without a normal impulse
      }
      return;
    }
    const Count half = edges / 2;
    contacts_.slip(contact, u_.data(), slip_.data());
    Scalar largest = 0;
    for (Count t = 0; t < half; ++t) {
      if (!(magnitude(slip_[t]) <= largest)) largest = number_or_infinity(magnitude(slip_[t]));
    }
    lambda = static_cast<double>(largest);
    if (!(lambda - lambda == 0)) note(kInfinity<Scalar>);
    const Scalar bound = static_cast<Scalar>(lambda);
    Scalar unused = contacts_.mu(contact) * static_cast<Scalar>(z[contact]);
    for (Count t = 0; t < half; ++t) {
      offer(bound + slip_[t], z[first + t]);
      offer(bound - slip_[t], z[first + half + t]);
      unused -= static_cast<Scalar>(z[first + t]) + static_cast<Scalar>(z[first + half + t]);
    }
    offer_cone(contact, bound, unused);
  }

  /// |min(lambda, M_nn unused)|
  void offer_cone(Count contact, Scalar lambda, Scalar unused) {
    contacts_.get_normal(contact, impulse_.data());
    const Scalar velocity = response_.square(impulse_.data()) * unused;
    note(magnitude(velocity < lambda ? velocity : lambda));
    if (!(velocity - velocity == 0)) note(kInfinity<Scalar>);
  }

  /// Of J f, whose terms may cancel, and of G's factors. Infinite where products with v may have underflowed.
  Scalar rounding() const {
    if (contacts_.nc() == 0) return 0;
    const Scalar largest_product = contacts_.reach() * contacts_.speed();
    if (contacts_.moves() && !(largest_product > static_cast<Scalar>(kSmallestSafe<Scalar>))) return kInfinity<Scalar>;
    const Count length = contacts_.padded_ngc();
    const Scalar terms = square_root(dot(magnitude_.data(), magnitude_.data(), length)) * response_.norm();
    const Scalar change = square_root(dot(change_.data(), change_.data(), length)) * response_.condition();
    return static_cast<Scalar>(2 * kUnitRoundoff<Scalar>) * contacts_.reach() * (terms + change);
  }

  static double relative(Scalar residual, Scalar q_max) {
    if (q_max == 0) return residual == 0 ? 0 : __builtin_inf();
    return is_scale(q_max) ? static_cast<double>(residual / q_max) : __builtin_inf();
  }

  /// Answers are doubles: where 113 bits reach further, nothing is vouched for.
  static bool is_scale(Scalar q_max) {
    if constexpr (sizeof(Scalar) > sizeof(double)) {
      return q_max >= static_cast<Scalar>(__DBL_MIN__) && q_max <= static_cast<Scalar>(__DBL_MAX__);
    } else {
      return q_max > 0 && q_max < kInfinity<Scalar>;
    }
  }

  /// max|q|; the friction part, which costs the most, only where the normals' leaves `error` above kNoDoubt of it.
  Scalar q_max(Scalar error) {
    const Count length = contacts_.padded_nc();
    combine(contacts_.normals(), length, contacts_.ngc(), contacts_.velocity(), normal_velocity_.data(), length);
    Scalar largest = largest_magnitude(normal_velocity_.data(), contacts_.nc());
    if (error <= static_cast<Scalar>(kNoDoubt) * largest) return largest;
    for (Count c = 0; c < contacts_.nc(); ++c) {
      const Scalar slip = contacts_.largest_slip(c, contacts_.velocity());
      if (slip > largest) largest = slip;
    }
    return largest;
  }

  static constexpr double kNoDoubt = 1e-9;
  static constexpr double kProofRoundings = 256;  // of the elimination that led to u; small against any real motion

  Contacts<Scalar>& contacts_;
  Response<Scalar>& response_;
  Buffer<Scalar> impulse_, magnitude_, change_, u_, normal_velocity_, slip_;
  Scalar worst_ = 0;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
