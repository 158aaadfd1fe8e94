#pragma once

#include "native/contact_lemke/engine.h"
#include "native/kernels/arithmetic.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// One or two intervals of coordinates, first[k] to end[k] - 1 for k < count, outside of which some columns are zero.
/// Inside they may be zero, too.
struct Runs {
  Count count = 1;
  Count first[2] = {0, 0}, end[2] = {0, 0};
};

/// The contacts of a problem: normals by rows, friction directions transposed on first use of their contact, since most
/// contacts of a problem never press.
///
/// The directions of a contact are numbered 0 .. edges - 1 as in D, and `edges` is one more, the zero vector: the share
/// mu f_N - sum f_D that friction leaves unused. With it a contact's friction impulses are a point of a simplex of size
/// mu f_N, and sticking needs no case of its own.
///
/// Where contacts are soft, velocities and impulses have entries behind those of the coordinates: what each contact
/// yields along its normal, and what along its two tangents. To the kernel each is a coordinate of its own, with
/// inertia 1 / r and an entry 1 in J.
template <class Scalar>
class Contacts {
 public:
  /// Takes all memory that load() needs; touches none of it.
  void reserve(const contact_lemke::Input& input) {
    input_ = input;
    padded_ngc_ = P::padded(input.ngc);
    padded_nc_ = P::padded(input.nc);
    extent_ = padded_ngc_ + (is_soft() ? padded_nc_ + P::padded(2 * nc()) : 0);
    velocity_.resize(extent_);
    compliance_.resize(extent_ - padded_ngc_);
    normals_.resize(ngc() * padded_nc_);
    block_at_.resize(nc() + 1);
    transposed_.resize(nc());
    most_padded_half_ = 0;
    Count entries = 0;
    for (Count c = 0; c < nc(); ++c) {
      entries += rows_of_block() * padded_half(c);
      if (padded_half(c) > most_padded_half_) most_padded_half_ = padded_half(c);
    }
    blocks_.resize(entries);
    zeros_.resize(ngc());
    runs_.resize(nc() + padded_nc_ / P::kWidth);
  }

  /// @pre reserve(input)
  void load(const contact_lemke::Input& input) {
    input_ = input;
    zeros_.fill(ngc(), 0);
    load_normals();
    load_layout();
    if (is_soft()) load_softness();
    set_velocity(input.v);
  }

  void set_velocity(const double* v) {
    input_.v = v;
    widen(v, ngc(), velocity_.data());
    speed_ = square_root(dot(velocity_.data(), velocity_.data(), padded_ngc_));
  }

  Count ngc() const { return input_.ngc; }
  /// The coordinates that impulses may move: all but that of an offset.
  Count moving() const { return has_offset() ? ngc() - 1 : ngc(); }
  bool has_offset() const { return input_.has_offset; }
  /// b of a normal row, of its column in the data.
  Scalar offset_of(const double* column) const {
    return has_offset() ? static_cast<Scalar>(column[ngc() - 1]) * velocity_[ngc() - 1] : Scalar(0);
  }
  Count nc() const { return input_.nc; }
  Count padded_ngc() const { return padded_ngc_; }
  Count padded_nc() const { return padded_nc_; }
  /// extent() entries
  const Scalar* velocity() const { return velocity_.data(); }

  bool is_soft() const { return input_.compliance_n != nullptr; }
  /// Of velocities and impulses with what contacts yield; padded_ngc() where none is soft.
  Count extent() const { return extent_; }
  Count normal_at(Count contact) const { return padded_ngc_ + contact; }
  /// The first of two entries.
  Count tangents_at(Count contact) const { return padded_ngc_ + padded_nc_ + 2 * contact; }
  /// What the impulses a (extent()) make contacts yield, behind the coordinates of c.
  void yield(const Scalar* a, Scalar* c) const {
    for (Count i = padded_ngc_; i < extent_; i += P::kWidth) {
      P::store(c + i, P::load(a + i) * P::load(compliance_.data() + i - padded_ngc_));
    }
  }
  Scalar normal_compliance(Count contact) const { return is_soft() ? compliance_[contact] : Scalar(0); }
  const Scalar* compliance() const { return compliance_.data(); }
  /// A direction by its two tangents.
  struct Tangents {
    Scalar first = 0, second = 0;
  };
  Tangents tangents(Count contact, Count direction) const {
    if (direction == edges(contact)) return {};
    const double* const of = input_.tangents + 2 * (first_direction(contact) + direction);
    return {static_cast<Scalar>(of[0]), static_cast<Scalar>(of[1])};
  }
  /// The norm of the tangential offsets.
  Scalar creep() const {
    return square_root(dot(velocity_.data() + padded_ngc_, velocity_.data() + padded_ngc_, extent_ - padded_ngc_));
  }
  /// Whether the offset of a contact that nothing moves is negative: then there is no answer. Or it is not known.
  bool asks_too_much() const {
    for (Count c = 0; has_offset() && c < nc(); ++c) {
      if (island_of_contact(c) < 0 && !(impulse_column(c)[ngc() - 1] >= 0)) return true;
    }
    return false;
  }
  Scalar speed() const { return speed_; }
  const Scalar* normals() const { return normals_.data(); }
  /// The largest Euclidean norm of a normal.
  Scalar reach() const { return reach_; }

  /// At least the largest Euclidean norm of a direction of friction.
  Scalar direction_reach() const { return direction_reach_; }

  Count islands() const { return input_.island_of_contact == nullptr ? 1 : input_.islands; }
  Count island_of_contact(Count contact) const {
    return input_.island_of_contact == nullptr ? 0 : input_.island_of_contact[contact];
  }
  Count island_of_coordinate(Count coordinate) const {
    return input_.island_of_coordinate == nullptr ? 0 : input_.island_of_coordinate[coordinate];
  }

  Count edges(Count contact) const { return input_.friction_begin[contact + 1] - input_.friction_begin[contact]; }
  Count half(Count contact) const { return edges(contact) >> 1; }
  Count padded_half(Count contact) const { return (half(contact) + P::kWidth - 1) & -P::kWidth; }
  Count most_padded_half() const { return most_padded_half_; }
  Count first_direction(Count contact) const { return input_.friction_begin[contact]; }
  Scalar mu(Count contact) const { return static_cast<Scalar>(input_.mu[contact]); }
  bool has_friction(Count contact) const { return edges(contact) > 0 && input_.mu[contact] > 0; }

  void get_normal(Count contact, Scalar* to) const { widen(input_.N + contact * ngc(), ngc(), to); }

  /// to = a + factor * b, padded, of columns as impulse_column() and direction() give them.
  void get_sum(const double* a, Scalar factor, const double* b, Scalar* to) const {
    Count i = 0;
    if constexpr (kHasDoubles) {
      const auto factors = P::broadcast(factor);
      for (; i + P::kWidth <= ngc(); i += P::kWidth) P::store(to + i, P::load(a + i) + factors * P::load(b + i));
      const Count left = ngc() - i;
      if (left == 0) return;
      P::store(to + i, load_first<Scalar>(a + i, left) + factors * load_first<Scalar>(b + i, left));
      return;
    }
    for (; i < ngc(); ++i) to[i] = static_cast<Scalar>(a[i]) + factor * static_cast<Scalar>(b[i]);
    for (; i < padded_ngc_; ++i) to[i] = 0;
  }
  /// The zero direction is the one behind the last.
  const double* direction(Count contact, Count direction) const {
    return direction == edges(contact) ? zeros_.data() : input_.D + (first_direction(contact) + direction) * ngc();
  }

  /// to (extent()) += factor * direction
  void add_direction(Count contact, Count direction, Scalar factor, Scalar* to) const {
    if (direction == edges(contact)) return;
    const double* const column = input_.D + (first_direction(contact) + direction) * ngc();
    for (Count i = 0; i < ngc(); ++i) to[i] += factor * static_cast<Scalar>(column[i]);
    if (!is_soft()) return;
    const Tangents along = tangents(contact, direction);
    to[tangents_at(contact)] += factor * along.first;
    to[tangents_at(contact) + 1] += factor * along.second;
  }

  /// The first half of the contact's directions by rows, padded_half() apart; the second half are their negatives.
  /// Where contacts are soft, two rows more have tangents().
  const Scalar* block(Count contact) {
    Scalar* const to = blocks_.data() + block_at_[contact];
    if (!transposed_[contact]) {
      transpose(input_.D + first_direction(contact) * ngc(), ngc(), ngc(), half(contact), to);
      if (is_soft()) {
        transpose(input_.tangents + 2 * first_direction(contact), 2, 2, half(contact),
                  to + ngc() * padded_half(contact));
      }
      if (skips_zeros()) runs_[contact] = find_runs(input_.D + first_direction(contact) * ngc(), half(contact));
      transposed_[contact] = true;
    }
    return to;
  }
  /// Whether zeros of J are looked for and left out of products. Of few coordinates they are not: to look for them
  /// takes as long as to multiply them.
  bool skips_zeros() const { return ngc() > contact_lemke::kLeastRange; }
  /// Of the rows of block(). @pre skips_zeros(), and block() was called
  const Runs& runs(Count contact) const { return runs_[contact]; }
  /// Coordinates of the runs of the normals' tiles, on the average; those of a contact's directions are about as many.
  Count length_of_runs() const { return length_of_runs_; }
  /// Of the normals of a tile of contacts. @pre skips_zeros()
  const Runs& normal_runs(Count first) const { return runs_[nc() + first / P::kWidth]; }

  /// slip[t] = direction_t'u of the first half; slip holds padded_half() entries.
  void slip(Count contact, const Scalar* u, Scalar* slip) {
    const Count width = padded_half(contact);
    combine(block(contact), width, ngc(), u, slip, width);
    if (is_soft()) combine_onto(block(contact) + ngc() * width, width, 2, u + tangents_at(contact), slip, slip, width);
  }

  /// The largest |direction'u| of a contact, without transposing anything.
  Scalar largest_slip(Count contact, const Scalar* u) const {
    Scalar largest = 0;
    Count t = 0;
    for (; t + kTogether <= half(contact); t += kTogether) raise_by_slips<kTogether>(contact, t, u, largest);
    for (; t < half(contact); ++t) raise_by_slips<1>(contact, t, u, largest);
    return largest;
  }

  /// Of the directions of one contact together, the largest Euclidean norm. The second halves are negatives of the
  /// first.
  double largest_norm_of_directions() const {
    using D = Packed<double>;
    double largest = 0;
    for (Count c = 0; c < nc(); ++c) {
      const double* const first = input_.D + first_direction(c) * ngc();
      const Count entries = half(c) * ngc();
      D::Pack squares = typename D::Pack{}, others = typename D::Pack{};  // neither waits for the other
      Count k = 0;
      for (; k + 2 * D::kWidth <= entries; k += 2 * D::kWidth) {
        squares += D::load(first + k) * D::load(first + k);
        others += D::load(first + k + D::kWidth) * D::load(first + k + D::kWidth);
      }
      double sum = D::sum(squares + others);
      for (; k < entries; ++k) sum += first[k] * first[k];
      largest = sum <= largest ? largest : sum;
    }
    return __builtin_sqrt(largest);
  }

  const double* impulse_column(Count column) const {
    return column < nc() ? input_.N + column * ngc() : input_.D + (column - nc()) * ngc();
  }

 private:
  using P = Packed<Scalar>;

  static constexpr double kRoundedUp = 1 + 0x1p-30;
  /// Whether the arrays of the problem can be loaded as packs.
  static constexpr bool kHasDoubles = P::kWidth > 1 && sizeof(Scalar) == sizeof(double);

  /// Directions whose products run side by side: each alone would wait for its own last addition.
  static constexpr Count kTogether = 4;

  template <Count kCount>
  void raise_by_slips(Count contact, Count first, const Scalar* u, Scalar& largest) const {
    const double* const columns = direction(contact, first);
    Scalar slips[static_cast<std::size_t>(kCount)];
    for (Count t = 0; t < kCount; ++t) slips[t] = 0;
    for (Count i = 0; i < ngc(); ++i) {
      for (Count t = 0; t < kCount; ++t) slips[t] += static_cast<Scalar>(columns[t * ngc() + i]) * u[i];
    }
    for (Count t = 0; t < kCount; ++t) {
      if (is_soft()) {
        const Tangents along = tangents(contact, first + t);
        slips[t] += along.first * u[tangents_at(contact)] + along.second * u[tangents_at(contact) + 1];
      }
      if (!(magnitude(slips[t]) <= largest)) largest = number_or_infinity(magnitude(slips[t]));
    }
  }

  /// The rows in which any of `count` consecutive columns is not zero. The zero rows at both ends and the longest gap
  /// of zero rows between are left out; shorter gaps stay inside a run.
  Runs find_runs(const double* columns, Count count) const {
    Runs runs;
    Count longest = 0, nonzero_before = -1;
    for (Count at = 0; at < ngc(); ++at) {
      bool is_zero = true;
      for (Count t = 0; t < count; ++t) is_zero = is_zero & (columns[t * ngc() + at] == 0);
      if (is_zero) continue;
      if (nonzero_before < 0) runs.first[0] = at;
      const Count gap = at - nonzero_before - 1;
      if (nonzero_before >= 0 && gap > longest) {
        longest = gap;
        runs.end[0] = nonzero_before + 1;
        runs.first[1] = at;
      }
      nonzero_before = at;
    }
    if (longest > 0) runs.count = 2;
    runs.end[runs.count - 1] = nonzero_before + 1;
    return runs;
  }

  void load_normals() {
    transpose(input_.N, ngc(), ngc(), nc(), normals_.data());
    length_of_runs_ = ngc();
    if (skips_zeros()) find_normal_runs();
    typename P::Pack largest = typename P::Pack{};
    for (Count j = 0; j < padded_nc_; j += P::kWidth) {
      typename P::Pack squares = typename P::Pack{};
      for (Count i = 0; i < ngc(); ++i) {
        const typename P::Pack entries = P::load(normals_.data() + i * padded_nc_ + j);
        squares += entries * entries;
      }
      largest = P::max(squares, largest);
    }
    reach_ = square_root(P::max(largest));
    direction_reach_ = static_cast<Scalar>(kRoundedUp * largest_norm_of_directions());
  }

  void find_normal_runs() {
    Count length = 0, tiles = 0;
    for_each_tile<Scalar>(padded_nc_, [&](auto packs, Count at) {
      const Count end = at + packs.kValue * P::kWidth;
      Runs& runs = runs_[nc() + at / P::kWidth];
      runs = find_runs(input_.N + at * ngc(), (end < nc() ? end : nc()) - at);
      for (Count k = 0; k < runs.count; ++k) length += runs.end[k] - runs.first[k];
      ++tiles;
    });
    if (tiles > 0) length_of_runs_ = length / tiles;
  }

  void load_layout() {
    transposed_.fill(nc(), false);
    Count at = 0;
    for (Count c = 0; c < nc(); ++c) {
      block_at_[c] = at;
      at += rows_of_block() * padded_half(c);
    }
  }

  Count rows_of_block() const { return ngc() + (is_soft() ? 2 : 0); }

  void load_softness() {
    velocity_.fill(extent_, Scalar(0));
    compliance_.fill(extent_ - padded_ngc_, Scalar(0));
    for (Count c = 0; c < nc(); ++c) {
      compliance_[c] = static_cast<Scalar>(input_.compliance_n[c]);
      for (Count tangent = 0; tangent < 2; ++tangent) {
        compliance_[tangents_at(c) - padded_ngc_ + tangent] = static_cast<Scalar>(input_.compliance_t[c]);
        velocity_[tangents_at(c) + tangent] = static_cast<Scalar>(input_.offset_t[2 * c + tangent]);
      }
    }
  }

  contact_lemke::Input input_;
  Count length_of_runs_ = 0;
  Count padded_ngc_ = 0, padded_nc_ = 0, most_padded_half_ = 0, extent_ = 0;
  Buffer<Scalar> velocity_, normals_, blocks_;
  Buffer<Scalar> compliance_;  ///< of what lies behind the coordinates
  Buffer<double> zeros_;
  Buffer<Count> block_at_;
  Buffer<bool> transposed_;
  Buffer<Runs> runs_;  ///< of the directions of each contact; then of the normals, by packs of contacts
  Scalar speed_ = 0, reach_ = 0, direction_reach_ = 0;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
