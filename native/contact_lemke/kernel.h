#pragma once

#include "native/contact_lemke/contacts.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Number of a contact's normal among its directions.
constexpr Count kNormal = -1;
/// Contact of the artificial variable.
constexpr Count kArtificial = -1;

/// An impulse of a contact, its velocity, or the artificial variable.
struct Label {
  Count contact = kArtificial;
  Count direction = kNormal;
  bool operator==(const Label& other) const {
    return (contact == other.contact) & (direction == other.direction);  // no branch that nothing could foretell
  }
  bool is_normal() const { return contact != kArtificial && direction == kNormal; }
};

/// The kernel K of a basis and its inverse: rows are velocities held at zero, columns the basic impulses and the
/// artificial variable z0. K_rj = b_r'c_j + cover_r [j is z0], with b_r the generalized direction of the row's velocity
/// and c_j = G* a_j the response to the column's impulse. Exchanges update the inverse in O(order^2).
///
/// Of what contacts yield (see Contacts), a row and a column have the three entries of their own contact behind those
/// of the coordinates; the column of z0 may have all.
template <class Scalar>
class Kernel {
 public:
  /// Takes all memory; touches none of it.
  void reserve(const Contacts<Scalar>& contacts, Count most) {
    ngc_ = contacts.ngc();
    padded_ngc_ = contacts.padded_ngc();
    extent_ = contacts.extent();
    first_tangents_ = contacts.tangents_at(0);
    entries_of_row_ = ngc_ + (is_soft() ? kYields : 0);
    column_length_ = padded_ngc_ + (is_soft() ? P::padded(kYields) : 0);
    most_ = most;
    stride_ = P::padded(most);
    inverse_.resize(stride_ * stride_);
    rows_.resize(entries_of_row_ * stride_);
    columns_.resize(most_ * column_length_);
    artificial_yields_.resize(extent_ - padded_ngc_);
    Buffer<Scalar>* const by_row[] = {&cover_, &target_, &norm_, &entries_};
    for (Buffer<Scalar>* buffer : by_row) buffer->resize(stride_);
    exchanged_.resize(most_);
    row_label_.resize(most_);
    column_label_.resize(most_);
  }

  void clear() {
    order_ = 0;
    artificial_ = -1;
  }
  /// Order 1: the row and the column at 0 were put; their entry's inverse is given.
  void start(Scalar inverse) {
    order_ = 1;
    P::store(inverse_.data(), typename P::Pack{});
    inverse_[0] = inverse;
  }
  bool full() const { return order_ == most_; }
  Count order() const { return order_; }
  Count stride() const { return stride_; }
  Label row_label(Count r) const { return row_label_[r]; }
  Label column_label(Count j) const { return column_label_[j]; }
  /// Column of z0; -1: it is not basic.
  Count artificial() const { return artificial_; }
  Scalar norm(Count j) const { return norm_[j]; }
  const Scalar* norms() const { return norm_.data(); }
  Scalar* column(Count j) { return columns_.data() + j * column_length_; }
  const Scalar* column(Count j) const { return columns_.data() + j * column_length_; }
  /// With what its contact yields. Of any but z0.
  Count column_length() const { return column_length_; }
  /// The rows are of velocity v, and not covered.
  void set_velocity(const Scalar* v) {
    measure(v, target_.data());
    for (Count r = 0; r < order_; ++r) {
      target_[r] = -target_[r];
      cover_[r] = 0;
    }
  }
  Scalar cover(Count r) const { return cover_[r]; }
  const Scalar* covers() const { return cover_.data(); }
  const Scalar* inverse_column(Count r) const { return inverse_.data() + r * stride_; }

  Count find_row(Label label) const { return find(row_label_, label); }
  Count find_column(Label label) const { return find(column_label_, label); }

  // --- what the inverse is for ---

  /// x := K^-1 target
  void solve_target(Scalar* x) const { combine(inverse_.data(), stride_, order_, target_.data(), x, order_); }
  /// x := K^-1 r
  void solve(const Scalar* r, Scalar* x) const { combine(inverse_.data(), stride_, order_, r, x, order_); }
  /// u := sum of x_j c_j
  void respond(const Scalar* x, Scalar* u) const {
    combine(columns_.data(), column_length_, order_, x, u, padded_ngc_);
    if (!is_soft()) return;
    for (Count i = padded_ngc_; i < extent_; i += P::kWidth) P::store(u + i, Pack{});
    add_yields(x, u);
  }
  /// u := start + sum of x_j c_j
  void respond_from(const Scalar* start, const Scalar* x, Scalar* u) const {
    combine_onto(columns_.data(), column_length_, order_, x, start, u, padded_ngc_);
    if (!is_soft()) return;
    copy(u + padded_ngc_, start + padded_ngc_, extent_ - padded_ngc_);
    add_yields(x, u);
  }
  /// r := b_r'u for all rows
  void measure(const Scalar* u, Scalar* r) const {
    combine(rows_.data(), stride_, ngc_, u, r, order_);
    if (is_soft()) measure_yields(u, r);
  }

  // --- labels and vectors; the inverse is not touched ---

  void put_row(Count r, Label label, const Scalar* b, Scalar cover, Scalar target) {
    row_label_[r] = label;
    if (begins_pack(r)) clear_pack(rows_.data() + r, entries_of_row_);
    for (Count i = 0; i < ngc_; ++i) rows_[i * stride_ + r] = b[i];
    for (Count k = 0; k < entries_of_row_ - ngc_; ++k) rows_[(ngc_ + k) * stride_ + r] = b[place(label, k)];
    cover_[r] = cover;
    target_[r] = target;
  }
  void put_column(Count j, Label label, const Scalar* c, Scalar norm) {
    column_label_[j] = label;
    if (label.contact == kArtificial) artificial_ = j;
    if (label.contact != kArtificial && artificial_ == j) artificial_ = -1;
    copy(column(j), c, padded_ngc_);
    norm_[j] = norm;
    if (!is_soft()) return;
    if (label.contact == kArtificial) return copy(artificial_yields_.data(), c + padded_ngc_, extent_ - padded_ngc_);
    for (Count k = 0; k < kYields; ++k) column(j)[padded_ngc_ + k] = c[place(label, k)];
    for (Count k = kYields; k < column_length_ - padded_ngc_; ++k) column(j)[padded_ngc_ + k] = 0;
  }
  /// c := c_j, with all that contacts yield. Of any column but z0's.
  void get_column(Count j, Scalar* c) const {
    copy(c, column(j), padded_ngc_);
    if (!is_soft()) return;
    for (Count i = padded_ngc_; i < extent_; i += P::kWidth) P::store(c + i, Pack{});
    for (Count k = 0; k < kYields; ++k) c[place(column_label_[j], k)] = column(j)[padded_ngc_ + k];
  }
  /// c_j += factor * c, of a column of the same contact or z0.
  void add_to_column(Count j, Scalar factor, const Scalar* c) {
    add_multiple(column(j), factor, c, padded_ngc_);
    if (!is_soft()) return;
    const Label label = column_label_[j];
    if (label.contact == kArtificial) {
      add_multiple(artificial_yields_.data(), factor, c + padded_ngc_, extent_ - padded_ngc_);
    } else {
      for (Count k = 0; k < kYields; ++k) column(j)[padded_ngc_ + k] += factor * c[place(label, k)];
    }
  }
  void drop_row_label(Count r) { row_label_[r] = row_label_[--rows_left_]; }
  void drop_column_label(Count j) { column_label_[j] = column_label_[--columns_left_]; }

  /// Between begin_labels() and end_labels() labels of rows and of columns are dropped and added one at a time, and
  /// rows_left() and columns_left() count them. Rows, columns and inverse stay those of the old labels.
  void begin_labels() { rows_left_ = columns_left_ = order_; }
  Count rows_left() const { return rows_left_; }
  Count columns_left() const { return columns_left_; }
  void add_column_label(Label label) { column_label_[columns_left_++] = label; }
  /// The number of row labels becomes the order. False unless there are as many column labels.
  bool end_labels() {
    order_ = rows_left_;
    artificial_ = find_column(Label{});
    return rows_left_ == columns_left_;
  }

  // --- exchanges; rate = -K^-1 (the entering column) as the pivoting rule found it. replace_column(), append(),
  // replace_row() and add_outer() change the inverse alone: see put_row(), put_column(), grow() ---

  /// The entering column takes the place of column j. rate = -K^-1 g.
  void replace_column(Count j, const Scalar* rate) {
    const Scalar reciprocal = Scalar(1) / rate[j];
    for (Count r = 0; r < order_; ++r) {
      Scalar* const h = inverse_.data() + r * stride_;
      const Scalar factor = h[j] * reciprocal;
      add_multiple(h, -factor, rate, order_);
      h[j] = -factor;
    }
  }

  /// Row r and column j go; the last ones take their places. @pre (K^-1)_jr is not 0
  void remove(Count r, Count j) {
    const Scalar* const gone = inverse_column(r);
    const Scalar reciprocal = Scalar(1) / gone[j];
    for (Count k = 0; k < order_; ++k) {
      if (k == r) continue;
      Scalar* const h = inverse_.data() + k * stride_;
      add_multiple(h, -h[j] * reciprocal, gone, order_);
    }
    const Count last = --order_;
    if (r != last) {
      copy(inverse_.data() + r * stride_, inverse_column(last), last + 1);
      row_label_[r] = row_label_[last];
      cover_[r] = cover_[last];
      target_[r] = target_[last];
      for (Count i = 0; i < entries_of_row_; ++i) rows_[i * stride_ + r] = rows_[i * stride_ + last];
    }
    if (j != last) {
      for (Count k = 0; k < last; ++k) inverse_[k * stride_ + j] = inverse_[k * stride_ + last];
      column_label_[j] = column_label_[last];
      norm_[j] = norm_[last];
      copy(column(j), column(last), column_length_);
    }
    artificial_ = artificial_ == j ? -1 : (artificial_ == last ? j : artificial_);
  }

  /// Appends the row (b, cover) and the entering column c. rate = -K^-1 g as above.
  /// False when the new kernel is singular.
  bool append(const Scalar* b, Scalar cover, const Scalar* c, const Scalar* rate) {
    write_entries(b, cover);
    const Scalar pivot = dot(b, c, extent_) + dot_entries(rate);
    if (!(magnitude(pivot) > 0)) return false;
    const Scalar reciprocal = Scalar(1) / pivot;
    if (begins_pack(order_)) clear_pack(inverse_.data() + order_, order_);
    for_each_entry_of_row([&](Count r, Scalar entry) {
      Scalar* const h = inverse_.data() + r * stride_;
      const Scalar factor = entry * reciprocal;
      add_multiple(h, -factor, rate, order_);
      h[order_] = -factor;
    });
    Scalar* const h = inverse_.data() + order_ * stride_;
    for (Count j = 0; j < order_; ++j) h[j] = rate[j] * reciprocal;
    h[order_] = reciprocal;
    for (Count j = order_ + 1; j < P::padded(order_ + 1); ++j) h[j] = 0;
    return true;
  }
  void grow() { ++order_; }

  /// The row (b, cover) takes the place of row r. False when the new kernel is singular.
  bool replace_row(Count r, const Scalar* b, Scalar cover) {
    write_entries(b, cover);
    Scalar* const place = inverse_.data() + r * stride_;
    const Scalar pivot = dot_entries(place);
    if (!(magnitude(pivot) > 0)) return false;
    scale(place, Scalar(1) / pivot, order_);
    for_each_entry_of_row([&](Count k, Scalar entry) {
      if (k != r) add_multiple(inverse_.data() + k * stride_, -entry, place, order_);
    });
    return true;
  }

  /// The inverse becomes that of K + g m', m zero but for m_j = a and m_k = b (-1: no such entry); rate = -K^-1 g. The
  /// caller changes the columns. False when the new kernel is singular: then nothing has changed.
  bool add_outer(Count j, Scalar a, Count k, Scalar b, const Scalar* rate) {
    Scalar pivot = 1;
    if (j >= 0) pivot -= a * rate[j];
    if (k >= 0) pivot -= b * rate[k];
    if (!(magnitude(pivot) > 0)) return false;
    const Scalar reciprocal = Scalar(1) / pivot;
    for (Count r = 0; r < order_; ++r) {
      Scalar* const h = inverse_.data() + r * stride_;
      Scalar factor = 0;
      if (j >= 0) factor += a * h[j];
      if (k >= 0) factor += b * h[k];
      add_multiple(h, factor * reciprocal, rate, order_);
    }
    return true;
  }

  /// Row r := -row r
  void negate_row(Count r) {
    scale(inverse_.data() + r * stride_, Scalar(-1), order_);
    for (Count i = 0; i < entries_of_row_; ++i) rows_[i * stride_ + r] = -rows_[i * stride_ + r];
    cover_[r] = -cover_[r];
    target_[r] = -target_[r];
  }

  /// Row r -= row s, with the inverse: column s of K^-1 gains column r of it.
  void subtract_row(Count r, Count s) {
    add_multiple(inverse_.data() + s * stride_, Scalar(1), inverse_.data() + r * stride_, order_);
    for (Count i = 0; i < entries_of_row_; ++i) rows_[i * stride_ + r] -= rows_[i * stride_ + s];
    cover_[r] -= cover_[s];
    target_[r] -= target_[s];
  }

  /// The inverse after unknown j := sum of coefficients times unknowns (that of j itself is -1). The caller changes the
  /// columns.
  void substitute_unknown(Count j, const Scalar* coefficients) {
    for (Count r = 0; r < order_; ++r) {
      Scalar* const h = inverse_.data() + r * stride_;
      h[j] = dot(coefficients, h, order_);
    }
  }

  void relabel_row(Count r, Label label) { row_label_[r] = label; }
  void relabel_column(Count j, Label label) { column_label_[j] = label; }
  void set_norm(Count j, Scalar norm) { norm_[j] = norm; }

  /// The inverse from rows and columns, by Gauss-Jordan elimination in the place where it is to stand, with pivots
  /// among the rows of K. False when singular, and the inverse is lost.
  bool invert() {
    write_transposed();
    for (Count step = 0; step < order_; ++step) {
      if (!eliminate(step)) return false;
    }
    for (Count step = order_ - 1; step >= 0; --step) {
      Scalar* const a = inverse_.data() + step * stride_;
      Scalar* const b = inverse_.data() + exchanged_[step] * stride_;
      for (Count j = 0; j < order_; ++j) swap(a[j], b[j]);
    }
    return true;
  }

 private:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  static constexpr Count kYields = 3;  ///< of a contact: along its normal and its tangents

  bool is_soft() const { return extent_ > padded_ngc_; }
  /// Where what the label's contact yields stands in a vector of extent_ entries.
  Count place(Label label, Count k) const {
    return k == 0 ? padded_ngc_ + label.contact : first_tangents_ + 2 * label.contact + k - 1;
  }

  void add_yields(const Scalar* x, Scalar* u) const {
    for (Count j = 0; j < order_; ++j) {
      const Label label = column_label_[j];
      if (label.contact == kArtificial) {
        add_multiple(u + padded_ngc_, x[j], artificial_yields_.data(), extent_ - padded_ngc_);
        continue;
      }
      const Scalar* const own = column(j) + padded_ngc_;
      for (Count k = 0; k < kYields; ++k) u[place(label, k)] += x[j] * own[k];
    }
  }
  void measure_yields(const Scalar* u, Scalar* r) const {
    const Scalar* const own = rows_.data() + ngc_ * stride_;
    for (Count i = 0; i < order_; ++i) {
      Scalar sum = 0;
      for (Count k = 0; k < kYields; ++k) sum += own[k * stride_ + i] * u[place(row_label_[i], k)];
      r[i] += sum;
    }
  }
  /// What column j and the row b have of it.
  Scalar yields_of(Count j, const Scalar* b) const {
    const Label label = column_label_[j];
    if (label.contact == kArtificial) return dot(b + padded_ngc_, artificial_yields_.data(), extent_ - padded_ngc_);
    Scalar sum = 0;
    for (Count k = 0; k < kYields; ++k) sum += b[place(label, k)] * column(j)[padded_ngc_ + k];
    return sum;
  }

  /// What lies between the last row or column and the end of its pack is multiplied by zero, and must be a number:
  /// packs are cleared when they come into use.
  bool begins_pack(Count k) const { return k >= order_ && k % P::kWidth == 0; }
  void clear_pack(Scalar* first, Count count) {
    for (Count k = 0; k < count; ++k) P::store(first + k * stride_, typename P::Pack{});
  }

  Count find(const Buffer<Label>& labels, Label label) const {
    Count found = -1;  // all are looked at: where it stands nothing could foretell
    for (Count k = 0; k < order_; ++k) found = labels[k] == label ? k : found;
    return found;
  }

  /// K' in the place of K^-T, zeros in what fills the last pack of each row.
  void write_transposed() {
    for (Count j = 0; j < order_; ++j) {
      Scalar* const row = inverse_.data() + j * stride_;
      combine(rows_.data(), stride_, ngc_, column(j), row, order_);
      if (is_soft()) add_yields_of_column(j, row);
      for (Count r = order_; r < P::padded(order_); ++r) row[r] = 0;
    }
    if (artificial_ < 0) return;
    Scalar* const row = inverse_.data() + artificial_ * stride_;
    for (Count r = 0; r < order_; ++r) row[r] += cover_[r];
  }

  void add_yields_of_column(Count j, Scalar* row) const {
    const Label label = column_label_[j];
    if (label.contact == kArtificial) return measure_yields(artificial_yields_.data() - padded_ngc_, row);
    const Scalar* const own = rows_.data() + ngc_ * stride_;
    for (Count r = 0; r < order_; ++r) {
      if (row_label_[r].contact != label.contact) continue;
      for (Count k = 0; k < kYields; ++k) row[r] += own[k * stride_ + r] * column(j)[padded_ngc_ + k];
    }
  }

  /// The entries of a further row against all columns.
  void write_entries(const Scalar* b, Scalar cover) {
    for (Count j = 0; j < order_; j += P::kWidth) {
      const Pack covered = P::broadcast(cover);
      const Pack own = covered - without_entry<Scalar>(covered, j, artificial_);
      const Pack entries = dots_with(b, columns_.data(), column_length_, j, padded_ngc_) + own;
      P::store(entries_.data() + j, entries_of<Scalar>(entries, j, order_));
    }
    for (Count j = 0; is_soft() && j < order_; ++j) entries_[j] += yields_of(j, b);
  }
  /// The dot products of x with those of the order_ vectors, `stride` apart, that follow number k; places of the pack
  /// behind the last vector repeat it.
  typename P::Pack dots_with(const Scalar* x, const Scalar* vectors, Count stride, Count k, Count length) const {
    const Scalar* of[static_cast<std::size_t>(P::kWidth)];
    for (Count lane = 0; lane < P::kWidth; ++lane) {
      of[lane] = vectors + (k + lane < order_ ? k + lane : order_ - 1) * stride;
    }
    return dots(x, of, length);
  }
  /// Calls visit(r, entry r) for the row entries_' K^-1. `visit` may change column r of the inverse, and no later one.
  template <class Visit>
  void for_each_entry_of_row(const Visit& visit) const {
    Scalar lanes[static_cast<std::size_t>(P::kWidth)];
    for (Count r = 0; r < order_; r += P::kWidth) {
      P::store(lanes, dots_with(entries_.data(), inverse_.data(), stride_, r, order_));
      for (Count lane = 0; lane < P::kWidth && r + lane < order_; ++lane) visit(r + lane, lanes[lane]);
    }
  }
  Scalar dot_entries(const Scalar* h) const { return dot(entries_.data(), h, order_); }

  /// One step on K': unknown `step` against the row of K in which it counts most, which takes place `step`.
  bool eliminate(Count step) {
    Scalar* const pivot_row = inverse_.data() + step * stride_;
    Count pivot = step;
    for (Count r = step + 1; r < order_; ++r) {
      if (magnitude(pivot_row[r]) > magnitude(pivot_row[pivot])) pivot = r;
    }
    exchanged_[step] = pivot;
    if (pivot != step) {
      for (Count j = 0; j < order_; ++j) swap(inverse_[j * stride_ + step], inverse_[j * stride_ + pivot]);
    }
    if (!(magnitude(pivot_row[step]) > 0)) return false;
    const Scalar reciprocal = Scalar(1) / pivot_row[step];
    pivot_row[step] = 1;
    scale(pivot_row, reciprocal, order_);
    for (Count j = 0; j < order_; ++j) {
      if (j == step) continue;
      Scalar* const row = inverse_.data() + j * stride_;
      const Scalar factor = row[step];
      row[step] = 0;
      add_multiple(row, -factor, pivot_row, order_);
    }
    return true;
  }

  Count ngc_ = 0, padded_ngc_ = 0, most_ = 0, stride_ = 0, order_ = 0;
  Count artificial_ = -1;
  Count extent_ = 0, first_tangents_ = 0, entries_of_row_ = 0, column_length_ = 0;
  Count rows_left_ = 0, columns_left_ = 0;
  Buffer<Scalar> inverse_;  ///< column r of K^-1 (one entry per unknown) at r * stride_
  Buffer<Scalar> rows_;     ///< b_r, one per lane, by generalized coordinates
  Buffer<Scalar> columns_;  ///< c_j, column_length_ apart
  Buffer<Scalar> artificial_yields_;  ///< of z0's column
  Buffer<Scalar> cover_, target_, norm_;
  Buffer<Scalar> entries_;   ///< of the further row of K that write_entries() wrote
  Buffer<Count> exchanged_;  ///< by step of an inversion: the row that came to its place
  Buffer<Label> row_label_, column_label_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
