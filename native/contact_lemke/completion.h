#pragma once

#include "core/answer/contact_scale.h"
#include "native/contact_lemke/contacts.h"
#include "native/kernels/response.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Completes impulses by the lambdas that they allow, and measures the answer from the raw data, island by island.
///
/// It bounds its own rounding, by coordinate first. The change c = G* p that the impulses p = J f make comes from the
/// factors of a neighbour G + E of G (Response::backward_error()), and p is off by some d, so that c is off by
/// G* (d - E c). With t_k = sqrt(G*_kk), by Cauchy and Schwarz in the metric of G*, a row a of J sees of that no more
/// than
///
///     (sum |a_k| t_k) (sum t_k d_k + backward_error (sum t_k root_k) (sum root_k |c_k|)),
///
/// the sums over the row's island. bound_ is all that multiplies |a_k|, the rounding of a'(v + c) included. What
/// contacts yield stands behind the coordinates, each for its own rounding alone.
template <class Scalar>
class Completion {
 public:
  Completion(Contacts<Scalar>& contacts, Response<Scalar>& response) : contacts_(contacts), response_(response) {}

  /// Takes all memory that load() needs. @pre the contacts are reserved
  void reserve() {
    Buffer<Scalar>* const by_coordinate[] = {&impulse_, &magnitude_, &change_, &u_, &bound_, &residual_};
    for (Buffer<Scalar>* buffer : by_coordinate) buffer->resize(contacts_.extent());
    // Islands have contacts: there are no more of them. Their number is known to load() only.
    Buffer<Scalar>* const by_island[] = {&worst_, &certain_, &rounded_, &lost_, &moved_};
    for (Buffer<Scalar>* buffer : by_island) buffer->resize(contacts_.nc() + 1);
    scales_.resize(contacts_.nc() + 1);
    normal_velocity_.resize(contacts_.padded_nc());
    normal_q_.resize(contacts_.padded_nc());
    exact_.resize(contacts_.ngc());
    slip_.resize(contacts_.most_padded_half());
  }

  void load() {
    reserve();
    fill_with_zeros(contacts_.extent(), impulse_, magnitude_, change_, u_, bound_);
  }

  contact_lemke::Residual run(double* z) {
    if (contacts_.asks_too_much()) return {__builtin_inf(), __builtin_inf()};
    add_impulses(z, contacts_.nc() + contacts_.first_direction(contacts_.nc()));
    response_.apply(impulse_.data(), change_.data());
    contacts_.yield(impulse_.data(), change_.data());
    for (Count i = 0; i < contacts_.extent(); ++i) u_[i] = contacts_.velocity()[i] + change_[i];
    const Count length = contacts_.padded_nc();
    combine(contacts_.normals(), length, contacts_.ngc(), u_.data(), normal_velocity_.data(), length);
    if (contacts_.is_soft()) take_yields();
    contact_lemke::Residual residual;
    if (contacts_.islands() == 1 && is_beyond_doubt(z, residual)) return residual;
    bound_rounding();
    residual = measure(z);
    if constexpr (sizeof(Scalar) == sizeof(double)) {
      const bool in_doubt = residual.velocity <= kLittle && !(residual.certain <= kLittle);
      if (in_doubt && is_known_ && contacts_.islands() == 1 && response_.has_blocks()) {
        bound_rounding_by_residual(z);
        residual = measure(z);
      }
    }
    return residual;
  }

  /// velocity (moving()) := v + G* [N D] z
  void respond(const double* z, double* velocity) {
    add_impulses(z, contacts_.nc() + contacts_.first_direction(contacts_.nc()));
    response_.apply(impulse_.data(), change_.data());
    for (Count i = 0; i < contacts_.moving(); ++i) {
      velocity[i] = static_cast<double>(contacts_.velocity()[i] + change_[i]);
    }
  }

 private:
  contact_lemke::Residual measure(double* z) {
    contact_lemke::Residual residual;
    measure_friction(z, [this](Count contact) { return rounding_of_directions(contact); });
    for (Count c = 0; c < contacts_.nc(); ++c) {
      const Scalar rounding = product(contacts_.impulse_column(c), bound_.data());
      offer(c, normal_velocity_[c], z[c], contacts_.is_soft() ? rounding + bound_[contacts_.normal_at(c)] : rounding);
    }
    measure_scales();
    for (Count k = 0; k < contacts_.islands(); ++k) {
      residual.velocity = larger(residual.velocity, relative(worst_[k], scales_[k].value()));
      residual.certain = larger(residual.certain, relative(certain_[k], scales_[k].value()));
    }
    return residual;
  }

  void add_impulses(const double* z, Count columns) {
    for (Count i = 0; i < contacts_.extent(); ++i) impulse_[i] = magnitude_[i] = 0;
    if (contacts_.is_soft()) add_impulses_that_yield(z);
    terms_ = 0;
    for (Count j = next_nonzero<Scalar>(z, 0, columns); j < columns; j = next_nonzero<Scalar>(z, j + 1, columns)) {
      ++terms_;
      const Scalar f = static_cast<Scalar>(z[j]);
      const double* const column = contacts_.impulse_column(j);
      for (Count i = 0; i < contacts_.ngc(); ++i) {
        const Scalar part = f * static_cast<Scalar>(column[i]);
        impulse_[i] += part;
        magnitude_[i] += magnitude(part);
      }
    }
  }

  /// Behind the coordinates: f_N and C f_D of each contact.
  void add_impulses_that_yield(const double* z) {
    for (Count c = 0; c < contacts_.nc(); ++c) {
      const auto add = [&](Count at, Scalar part) {
        impulse_[at] += part;
        magnitude_[at] += magnitude(part);
      };
      add(contacts_.normal_at(c), static_cast<Scalar>(z[c]));
      for (Count t = 0; t < contacts_.edges(c); ++t) {
        const Scalar f = static_cast<Scalar>(z[contacts_.nc() + contacts_.first_direction(c) + t]);
        if (f == 0) continue;
        const auto along = contacts_.tangents(c, t);
        add(contacts_.tangents_at(c), f * along.first);
        add(contacts_.tangents_at(c) + 1, f * along.second);
      }
    }
  }

  /// Into the normal velocities, and how far off all that contacts yield may be.
  void take_yields() {
    largest_yield_rounding_ = 0;
    for (Count c = 0; c < contacts_.nc(); ++c) {
      normal_velocity_[c] += u_[contacts_.normal_at(c)];
      const Count tangents = contacts_.tangents_at(c);
      const Count all[] = {contacts_.normal_at(c), tangents, tangents + 1};
      const double roundings = 8 + static_cast<double>(contacts_.edges(c));  // of C f_D, r f, and the sum with the rest
      for (const Count i : all) {
        const Scalar r = contacts_.compliance()[i - contacts_.padded_ngc()];
        const Scalar terms = r * magnitude_[i] + magnitude(contacts_.velocity()[i]);
        bound_[i] = static_cast<Scalar>(kUnitRoundoff<Scalar> * roundings) * terms;
      }
      const Scalar of_contact = bound_[all[0]] + bound_[all[1]] + bound_[all[2]];
      if (!(of_contact <= largest_yield_rounding_)) largest_yield_rounding_ = number_or_infinity(of_contact);
    }
  }

  /// bound_ by the backward error of the factors.
  void bound_rounding() {
    const Scalar roundoff = static_cast<Scalar>(kUnitRoundoff<Scalar>);
    const Scalar sums = roundoff * static_cast<Scalar>(static_cast<double>(4 + 2 * contacts_.ngc() + terms_));
    const Scalar dots = roundoff * static_cast<Scalar>(static_cast<double>(2 + contacts_.ngc()));
    const Scalar* const reach = response_.reach();
    const Scalar* const root = response_.root();
    const Scalar error = response_.backward_error();
    is_known_ = error < kInfinity<Scalar>;
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) {
      if (magnitude_[i] > 0 && magnitude_[i] < static_cast<Scalar>(kSmallestSafe<Scalar>)) is_known_ = false;
      bound_[i] = magnitude(change_[i]);
    }
    for (Count k = 0; k < contacts_.islands(); ++k) rounded_[k] = lost_[k] = moved_[k] = 0;
    for (Count i = 0; i < contacts_.ngc(); ++i) {
      const Count k = contacts_.island_of_coordinate(i);
      if (k < 0) continue;
      rounded_[k] += reach[i] * magnitude_[i];
      lost_[k] += reach[i] * root[i];
      moved_[k] += root[i] * bound_[i];
    }
    for (Count k = 0; k < contacts_.islands(); ++k) {
      rounded_[k] = sums * rounded_[k] + (is_known_ ? error * lost_[k] * moved_[k] : Scalar(0));
    }
    for (Count i = 0; i < contacts_.ngc(); ++i) {
      const Count k = contacts_.island_of_coordinate(i);
      bound_[i] = dots * (magnitude(contacts_.velocity()[i]) + bound_[i]);
      if (k >= 0) bound_[i] += reach[i] * rounded_[k];
    }
  }

  /// Sharper, by what the change at hand leaves: r = J f - G c, in more bits, of which a row a sees no more than
  /// (sum |a_k| t_k) |r|_G*. @pre one island, is_known_
  void bound_rounding_by_residual(const double* z) {
    const Count ngc = contacts_.ngc();
    const Count columns = contacts_.nc() + contacts_.first_direction(contacts_.nc());
    exact_.fill(ngc, 0);
    for (Count j = 0; j < columns; ++j) {
      if (z[j] == 0) continue;
      const double* const column = contacts_.impulse_column(j);
      for (Count i = 0; i < ngc; ++i) exact_[i] += static_cast<long double>(column[i]) * static_cast<long double>(z[j]);
    }
    response_.subtract_inertia(change_.data(), exact_.data());
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) {
      residual_[i] = i < contacts_.moving() ? static_cast<Scalar>(exact_[i]) : Scalar(0);
      bound_[i] = magnitude(change_[i]);
    }
    const Scalar* const reach = response_.reach();
    const Count length = contacts_.padded_ngc();
    const Scalar bits = static_cast<Scalar>(kLongUnitRoundoff * static_cast<double>(4 + ngc + terms_));
    const Scalar own = bits * (dot(reach, magnitude_.data(), length) +
                               dot(reach, response_.root(), length) * dot(response_.root(), bound_.data(), length));
    const Scalar off = static_cast<Scalar>(kRoom) * (square_root(response_.square(residual_.data())) + own);
    const Scalar dots = static_cast<Scalar>(kUnitRoundoff<Scalar> * static_cast<double>(4 + ngc));
    for (Count i = 0; i < length; ++i) {
      bound_[i] = reach[i] * off + dots * (magnitude(contacts_.velocity()[i]) + bound_[i]);
    }
  }

  /// Where nothing is known of G*, all that impulses do is uncertain.
  void begin_measuring() {
    const bool is_certain = is_known_ || terms_ == 0;
    for (Count k = 0; k < contacts_.islands(); ++k) {
      worst_[k] = 0;
      certain_[k] = is_certain ? Scalar(0) : kInfinity<Scalar>;
    }
  }

  /// |column|'x
  Scalar product(const double* column, const Scalar* x) const {
    Scalar sum = 0;
    for (Count i = 0; i < contacts_.ngc(); ++i) sum += static_cast<Scalar>(__builtin_fabs(column[i])) * x[i];
    return sum;
  }

  /// What a row is off whose w is known to within `rounding`. A row with z_i > 0 is off by min(M_ii z_i, w_i) <= |w_i|,
  /// one with z_i = 0 by -w_i.
  void offer(Count contact, Scalar w, double z, Scalar rounding) {
    if (z > 0 || !(w >= 0)) return note(contact, magnitude(w), magnitude(w) + rounding);
    note(contact, 0, rounding > w ? rounding - w : Scalar(0));
    if (!(rounding <= rounding)) note(contact, 0, kInfinity<Scalar>);
  }

  /// What is no number, or too large for one, stays the worst.
  void note(Count contact, Scalar off, Scalar certain) {
    const Count k = contacts_.island_of_contact(contact);
    if (k < 0) return;
    if (!(off <= worst_[k])) worst_[k] = number_or_infinity(off);
    if (!(certain <= certain_[k])) certain_[k] = number_or_infinity(certain);
  }
  void note_infinite(Count contact) { note(contact, kInfinity<Scalar>, kInfinity<Scalar>); }

  Scalar rounding_of_directions(Count contact) const {
    const Count first = contacts_.nc() + contacts_.first_direction(contact);
    Scalar most = 0;
    const Scalar* const yields = bound_.data() + contacts_.tangents_at(contact);
    for (Count t = 0; t < contacts_.half(contact); ++t) {
      Scalar of_row = product(contacts_.impulse_column(first + t), bound_.data());
      if (contacts_.is_soft()) of_row += yields[0] + yields[1];
      if (!(of_row <= most)) most = number_or_infinity(of_row);
    }
    return most;
  }

  /// Of all contacts; sets the lambdas. @param rounding  of the slips of a contact
  template <class Rounding>
  void measure_friction(double* z, Rounding&& rounding) {
    begin_measuring();
    Count lambda = contacts_.nc() + contacts_.first_direction(contacts_.nc());
    for (Count c = 0; c < contacts_.nc(); ++c) {
      if (contacts_.edges(c) == 0) continue;
      measure_friction(c, z, z[lambda++], rounding(c));
    }
  }

  void measure_friction(Count contact, const double* z, double& lambda, Scalar rounding) {
    const Count first = contacts_.nc() + contacts_.first_direction(contact);
    const Count half = contacts_.half(contact);
    if (!(z[contact] > 0)) {
      const Scalar largest = contacts_.largest_slip(contact, u_.data());
      lambda = static_cast<double>(largest);
      offer(contact, static_cast<Scalar>(lambda) - largest, 0, rounding);
      if (!(lambda - lambda == 0)) note_infinite(contact);
      const double* const friction = z + first;
      for (Count t = next_nonzero<Scalar>(friction, 0, 2 * half); t < 2 * half;
           t = next_nonzero<Scalar>(friction, t + 1, 2 * half)) {
        if (friction[t] > 0) note_infinite(contact);  // friction without a normal impulse
      }
      return;
    }
    contacts_.slip(contact, u_.data(), slip_.data());
    Scalar largest = 0;
    for (Count t = 0; t < half; ++t) {
      if (!(magnitude(slip_[t]) <= largest)) largest = number_or_infinity(magnitude(slip_[t]));
    }
    Scalar unused = contacts_.mu(contact) * static_cast<Scalar>(z[contact]);
    Scalar terms = magnitude(unused);
    for (Count t = 0; t < half; ++t) {
      const Scalar both = static_cast<Scalar>(z[first + t]) + static_cast<Scalar>(z[first + half + t]);
      unused -= both;
      terms += both;
    }
    contacts_.get_normal(contact, impulse_.data());
    const Scalar square = response_.square(impulse_.data()) + contacts_.normal_compliance(contact);
    // Where friction is left over, the contact sticks and lambda is zero: what slips then is rounding.
    lambda = largest < square * unused ? 0 : static_cast<double>(largest);
    if (!(lambda - lambda == 0)) note_infinite(contact);
    const Scalar bound = static_cast<Scalar>(lambda);
    for (Count t = 0; t < half; ++t) {
      offer(contact, bound + slip_[t], z[first + t], rounding);
      offer(contact, bound - slip_[t], z[first + half + t], rounding);
    }
    offer_cone(contact, bound, square, unused,
               terms * static_cast<Scalar>(kUnitRoundoff<Scalar> * (2 + 4 * static_cast<double>(half))));
  }

  /// |min(lambda, M_nn unused)|, `unused` known to within `rounding` and M_nn = `square` to within kTrusted of itself.
  void offer_cone(Count contact, Scalar lambda, Scalar square, Scalar unused, Scalar rounding) {
    const Scalar velocity = square * unused;
    const Scalar most =
        static_cast<Scalar>(1 + 2 * Response<Scalar>::kTrusted) * square * (magnitude(unused) + rounding);
    const Scalar off = magnitude(velocity < lambda ? velocity : lambda);
    note(contact, off, unused > rounding && lambda < most ? lambda : most);
    if (!(velocity - velocity == 0)) note_infinite(contact);
  }

  /// measure() in less time: one bound on the rounding of all rows, relative to the largest approach, which is at
  /// most the scale. Sets the lambdas. @pre one island; u_ and normal_velocity_ are those of z
  /// @param residual is set where that suffices @returns whether it does: the residual and its bound are small enough
  bool is_beyond_doubt(double* z, contact_lemke::Residual& residual) {
    is_known_ = true;
    measure_friction(z, [](Count) { return Scalar(0); });
    for (Count c = 0; c < contacts_.nc(); ++c) {
      const Scalar w = normal_velocity_[c];
      const Scalar off = z[c] > 0 || !(w >= 0) ? magnitude(w) : Scalar(0);
      if (!(off <= worst_[0])) worst_[0] = number_or_infinity(off);
    }
    const Count length = contacts_.padded_nc();
    combine(contacts_.normals(), length, contacts_.ngc(), contacts_.velocity(), normal_q_.data(), length);
    Scalar scale = static_cast<Scalar>(ContactScale<Scalar>::kLeast);
    for (Count c = 0; c < contacts_.nc(); ++c) {
      const bool counts = contacts_.island_of_contact(c) >= 0;  // else its offset is no scale of the others
      if (counts && !(-normal_q_[c] <= scale)) scale = number_or_infinity(-normal_q_[c]);
    }
    if (!(scale < kInfinity<Scalar> && worst_[0] <= static_cast<Scalar>(kNoDoubt) * scale)) return false;
    const Scalar at_rest = worst_[0] > certain_[0] ? worst_[0] : certain_[0];
    const Scalar reach =
        contacts_.reach() > contacts_.direction_reach() ? contacts_.reach() : contacts_.direction_reach();
    if (!(reach * reach > static_cast<Scalar>(kSmallestSafe<Scalar>))) return false;  // squares may have underflowed
    const Scalar of_yields = contacts_.is_soft() ? largest_yield_rounding_ : Scalar(0);
    Scalar certain = at_rest + reach * largest_rounding(reach, scale) + of_yields;
    const auto is_little = [&] { return certain <= static_cast<Scalar>(kLittle) * scale; };
    const auto take_bound = [&] {
      certain = at_rest + reach * square_root(dot(bound_.data(), bound_.data(), contacts_.padded_ngc())) + of_yields;
    };
    if (!is_little()) {
      bound_rounding();
      if (terms_ > 0 && !is_known_) return false;
      take_bound();
    }
    if constexpr (sizeof(Scalar) == sizeof(double)) {
      if (!is_little() && is_known_ && response_.has_blocks()) {
        bound_rounding_by_residual(z);
        take_bound();
      }
    }
    if (!is_little()) return false;
    residual.velocity = relative(worst_[0], scale);
    residual.certain = relative(certain, scale);
    return residual.certain < __builtin_inf();
  }

  /// At least the Euclidean norm of bound_, from norms and traces: no coordinate is looked at. Infinite where products
  /// may have underflowed by what counts beside a velocity of `scale` of a row of norm `reach`.
  Scalar largest_rounding(Scalar reach, Scalar scale) const {
    const Scalar roundoff = static_cast<Scalar>(kUnitRoundoff<Scalar>);
    const Scalar sums = roundoff * static_cast<Scalar>(static_cast<double>(4 + 2 * contacts_.ngc() + terms_));
    const Scalar dots = roundoff * static_cast<Scalar>(static_cast<double>(2 + contacts_.ngc()));
    const Count length = contacts_.padded_ngc();
    const Scalar change = square_root(dot(change_.data(), change_.data(), length));
    const Scalar of_velocity = dots * (contacts_.speed() + change);
    if (terms_ == 0) return of_velocity;
    const Scalar gain = response_.inverse_trace();
    const Scalar smallest = static_cast<Scalar>(kSmallestSafe<Scalar>);
    if (!((gain + 1) * reach * smallest <= roundoff * scale && scale > smallest)) return kInfinity<Scalar>;
    const Scalar impulse = square_root(dot(magnitude_.data(), magnitude_.data(), length));
    const Scalar lost = response_.largest_backward_error() * response_.trace() * change;
    return gain * (sums * impulse + lost) + of_velocity;
  }

  /// scales_, of each island.
  void measure_scales() {
    for (Count k = 0; k < contacts_.islands(); ++k) scales_[k] = {};
    for (Count c = 0; c < contacts_.nc(); ++c) {
      const Count k = contacts_.island_of_contact(c);
      if (k < 0) continue;
      const double* const normal = contacts_.impulse_column(c);
      scales_[k].add_approach(add_row(normal, scales_[k]) + contacts_.offset_of(normal));
      const Count first = contacts_.nc() + contacts_.first_direction(c);
      for (Count t = 0; t < contacts_.half(c); ++t) add_row(contacts_.impulse_column(first + t), scales_[k]);
    }
  }

  /// @returns J_i'v, without an offset
  Scalar add_row(const double* column, ContactScale<Scalar>& scale) const {
    Scalar velocity = 0, terms = 0;
    Count entries = 0;
    for (Count i = 0; i < contacts_.moving(); ++i) {
      if (column[i] == 0) continue;
      const Scalar part = static_cast<Scalar>(column[i]) * contacts_.velocity()[i];
      velocity += part;
      terms += magnitude(part);
      ++entries;
    }
    scale.add_row(velocity, terms, static_cast<double>(entries));
    return velocity;
  }

  static double larger(double a, double b) { return a >= b ? a : b; }

  static double relative(Scalar residual, Scalar scale) {
    return is_scale(scale) && residual < kInfinity<Scalar> ? static_cast<double>(residual / scale) : __builtin_inf();
  }

  /// Answers are doubles: where 113 bits reach further, nothing is vouched for. Nor where doubles may have underflowed.
  static bool is_scale(Scalar scale) {
    if constexpr (sizeof(Scalar) > sizeof(double)) {
      return scale >= static_cast<Scalar>(__DBL_MIN__) && scale <= static_cast<Scalar>(__DBL_MAX__);
    } else {
      return scale > static_cast<Scalar>(kSmallestSafe<Scalar>) && scale < kInfinity<Scalar>;
    }
  }

  static constexpr double kNoDoubt = 1e-7;  ///< is_beyond_doubt() leaves larger residuals to measure()
  static constexpr double kLittle = 3e-5;   ///< less than the solver's claims allow
  static constexpr double kRoom = 1.25;    ///< for G instead of the matrix of the factors within kTrusted
  static constexpr double kLongUnitRoundoff = static_cast<double>(__LDBL_EPSILON__) / 2;

  Contacts<Scalar>& contacts_;
  Response<Scalar>& response_;
  Buffer<Scalar> impulse_, magnitude_, change_, u_, bound_, residual_;
  Buffer<long double> exact_;
  Buffer<Scalar> normal_velocity_, normal_q_, slip_;
  Buffer<Scalar> worst_, certain_, rounded_, lost_, moved_;  ///< by island
  Buffer<ContactScale<Scalar>> scales_;                      ///< by island
  Scalar largest_yield_rounding_ = 0;
  Count terms_ = 0;                                                  ///< impulses that are not zero
  bool is_known_ = false;  ///< whether bound_ bounds the error of what G* makes of the impulses
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
