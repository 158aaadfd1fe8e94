#pragma once

#include "native/contacts/contact_arrays.h"
#include "native/kernels/arithmetic.h"
#include "native/kernels/ranges.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// G* applied to impulses: what velocity they cause.
///
/// G is factored by Cholesky with diagonal pivoting, P'GP = L D L' with |L| <= 1, and W = P L^-T D^-1/2 is kept, so
/// that G* = W W'. The factors of a badly conditioned G differ in their scales D but hardly in their unit triangle, so
/// that W has small relative errors row by row where G^-1 itself would not. From here on, also in the code, L stands
/// for P L D^1/2, so that G = L L'. If G has full rank, W = L^-T. If it is singular, L has rank columns, and W = L
/// (L'L)^-1. If G is given by fewer than ngc factors, as the sum of alpha x x', the columns of L are sqrt(alpha) x for
/// alpha > 0: the column space of G is then exact, and not what rounding leaves of it. A given G* is used as it is.
///
/// If G is given by blocks, each block is factored by itself, and consecutive blocks are put together into ranges of
/// kLeastRange coordinates or more. If G has full rank, a load costs O(ngc^2) and the cubes of the sizes of the
/// blocks, a response O(ngc) and the squares of the sizes of the ranges in which the impulse is not zero. If any block
/// is singular, or G is given otherwise, all ranges count as one: a load costs O(ngc^3), a response O(ngc rank).
template <class Scalar>
class Response {
 public:
  /// The share of G's least eigenvalue, scaled to unit diagonal, that rounding may take before nothing is known of G*.
  static constexpr double kTrusted = 0.1;

  /// Takes all memory that load() needs; touches none of it.
  void reserve(const contact_lemke::Input& input) {
    ngc_ = input.has_offset ? input.ngc - 1 : input.ngc;
    padded_ = P::padded(input.ngc);
    given_ = input.inertia.Ginv != nullptr;
    by_factors_ = input.inertia.factors >= 0;
    columns_.resize(ngc_ * padded_);
    white_.resize(padded_);
    reach_.resize(padded_);
    root_.resize(padded_);
    diagonal_.resize(padded_);
    ranges_.reserve(ngc_);
    if (given_) return;
    work_.resize(ngc_ * padded_);
    L_.resize(ngc_ * padded_);
    rows_.resize(ngc_ * padded_);
    pivots_.resize(ngc_);
    rest_.resize(ngc_);
    place_.resize(ngc_);
    left_.resize(padded_);
    is_left_.resize(padded_);
  }

  void load(const contact_lemke::Input& input) {
    reserve(input);
    inertia_ = input.inertia;
    is_measured_ = false;
    ranges_.take_all(ngc_);
    if (given_) {
      by_columns_ = false;
      is_sound_ = true;
      return load_inverse(input.inertia.Ginv);
    }
    by_columns_ = is_sound_ = load_columns(input.inertia);
    if (!by_columns_) {
      form(input.inertia);
      if (!by_factors_) ranges_.find(input.inertia, ngc_);
      factor(by_factors_ && input.inertia.factors < ngc_ ? input.inertia.factors : ngc_);
      if (rank_ == ngc_) {
        invert_triangle();
        is_sound_ = true;
      } else {
        is_sound_ = pseudo_invert() && is_cut_cleanly();
      }
    }
    white_.fill(padded_, Scalar(0));
    transpose(columns_.data(), padded_, ngc_, rank_, rows_.data());
    inverse_trace_ = dot(columns_.data(), columns_.data(), rank_ * padded_);
    trace_ = by_columns_ ? dot(L_.data(), L_.data(), rank_ * padded_) : sum(diagonal_.data());
  }

  bool full_rank() const { return !given_ && rank_ == ngc_; }
  /// Whether whiten() and what goes with it may be called.
  bool has_factors() const { return !given_; }

  /// The sum of the diagonal of G*.
  Scalar inverse_trace() const { return inverse_trace_; }
  /// The sum of the diagonal of G; 0 where G* was given.
  Scalar trace() const { return trace_; }
  /// At least backward_error(), from the traces alone: infinite where they do not tell.
  Scalar largest_backward_error() const {
    if (given_) return 0;
    const Scalar condition = rank_ == ngc_ ? 1 + inverse_trace_ * trace_ : condition_of_columns_;
    return is_trusted(condition) ? (rank_ == ngc_ ? roundings() : roundings() * condition) : kInfinity<Scalar>;
  }

  /// Per coordinate the square root of (G*)_kk: no impulse p moves the coordinate by more than that times |p|_G*.
  /// Padded.
  const Scalar* reach() {
    measure();
    return reach_.data();
  }
  /// Per coordinate the square root of G_kk; 0 where G* was given. Padded.
  const Scalar* root() {
    measure();
    return root_.data();
  }
  /// The factors in use are those of a matrix that differs from G by no more than this times root_i root_j in each
  /// entry. Infinite where that may be a singular matrix, so that nothing is known of G*.
  Scalar backward_error() {
    measure();
    return backward_error_;
  }
  /// Whether G was given by blocks, one or many, and is of full rank.
  bool has_blocks() const { return full_rank() && !by_factors_; }
  /// r (ngc) -= G c, in the bits of long double. @pre has_blocks()
  void subtract_inertia(const double* c, long double* r) const {
    for (Count b = 0; b < inertia_.blocks; ++b) {
      const Count first = inertia_.offsets[b];
      const Count size = inertia_.offsets[b + 1] - first;
      for (Count i = 0; i < size; ++i) {
        const double* const column = inertia_.G[b] + i * size;
        long double sum = 0;
        for (Count j = 0; j < size; ++j) sum += static_cast<long double>(column[j]) * c[first + j];
        r[first + i] -= sum;
      }
    }
  }

  /// c := G* a; both ngc long, padded with zeros.
  void apply(const Scalar* a, Scalar* c) {
    if (given_) {
      combine(columns_.data(), padded_, ngc_, a, c, padded_);
      return;
    }
    whiten(a, white_.data());
    combine_ranges(columns_.data(), padded_, rank_, white_.data(), c);
  }

  /// W'a, with zeros up to the end of its last pack and nothing behind; |W'a|^2 = a'G* a. @pre has_factors()
  void whiten(const Scalar* a, Scalar* white) const {
    combine_ranges(rows_.data(), rank_padded_, ngc_, a, white);
  }

  /// Multiplications of a response to a contact's impulse, which pushes two ranges at most, on the average.
  Count work() const { return is_by_ranges() ? 4 * ranges_.cubes() / ngc_ : 2 * ngc_ * rank_; }

  /// a'G* a
  Scalar square(const Scalar* a) {
    if (given_) {
      apply(a, white_.data());
      return dot(a, white_.data(), padded_);
    }
    whiten(a, white_.data());
    return dot(white_.data(), white_.data(), rank_padded_);
  }

 private:
  using P = Packed<Scalar>;

  using Range = typename Ranges<Scalar>::Range;
  bool is_by_ranges() const { return ranges_.count() > 1 && rank_ == ngc_; }

  /// to (`apart` entries) := the sum over k < count of coefficients[k] times vector k. The vectors are the columns of W
  /// or its rows, `apart` entries from one to the next. If the work is by ranges, a vector is zero outside of its own,
  /// and ranges whose coefficients are all zero take no multiplications.
  void combine_ranges(const Scalar* vectors, Count apart, Count count, const Scalar* coefficients, Scalar* to) const {
    if (!is_by_ranges()) return combine(vectors, apart, count, coefficients, to, apart);
    for (Count i = 0; i < apart; i += P::kWidth) P::store(to + i, typename P::Pack{});
    for (Count r = 0; r < ranges_.count(); ++r) {
      const Range own = ranges_[r];
      const Scalar* const own_coefficients = coefficients + own.first;
      Count zeros = 0;
      while (zeros < own.size() && own_coefficients[zeros] == 0) ++zeros;
      if (zeros == own.size()) continue;
      Scalar* const own_to = to + own.first_of_packs;
      combine_onto(vectors + own.first * apart + own.first_of_packs, apart, own.size(), own_coefficients, own_to,
                   own_to, own.length());
    }
  }

  void load_inverse(const double* Ginv) {
    white_.fill(padded_, Scalar(0));
    trace_ = inverse_trace_ = 0;
    rank_ = ngc_;
    rank_padded_ = padded_;
    for (Count j = 0; j < ngc_; ++j) {
      for (Count i = 0; i < ngc_; ++i) columns_[j * padded_ + i] = static_cast<Scalar>(Ginv[j * ngc_ + i]);
      for (Count i = ngc_; i < padded_; ++i) columns_[j * padded_ + i] = 0;
      const Scalar entry = columns_[j * padded_ + j];
      inverse_trace_ += entry >= 0 ? entry : kInfinity<Scalar>;
    }
  }

  /// L and W straight from fewer than ngc factors. False where there are not such, or where they are dependent.
  bool load_columns(const contact_lemke::InertiaInput& inertia) {
    if (!by_factors_ || inertia.factors >= ngc_) return false;
    rank_ = 0;
    for (Count k = 0; k < inertia.factors; ++k) {
      if (!(inertia.alpha[k] > 0)) {
        if (inertia.alpha[k] == 0) continue;
        return false;
      }
      Scalar* const l = L_.data() + rank_ * padded_;
      const Scalar root = square_root(static_cast<Scalar>(inertia.alpha[k]));
      for (Count i = 0; i < ngc_; ++i) l[i] = root * static_cast<Scalar>(inertia.X[k * ngc_ + i]);
      for (Count i = ngc_; i < padded_; ++i) l[i] = 0;
      ++rank_;
    }
    rank_padded_ = P::padded(rank_);
    return pseudo_invert();
  }

  void form(const contact_lemke::InertiaInput& inertia) {
    if (inertia.factors < 0 && inertia.blocks == 1 && P::padded(ngc_) == padded_) {
      for (Count j = 0; j < ngc_; ++j) widen(inertia.G[0] + j * ngc_, ngc_, work_.data() + j * padded_);
      return;
    }
    for (Count i = 0; i < ngc_ * padded_; ++i) work_[i] = 0;
    if (inertia.factors >= 0) return form_factors(inertia);
    for (Count b = 0; b < inertia.blocks; ++b) {
      const Count first = inertia.offsets[b];
      const Count size = inertia.offsets[b + 1] - first;
      for (Count j = 0; j < size; ++j) {
        const double* column = inertia.G[b] + j * size;
        for (Count i = 0; i < size; ++i) work_[(first + j) * padded_ + first + i] = static_cast<Scalar>(column[i]);
      }
    }
  }

  void form_factors(const contact_lemke::InertiaInput& inertia) {
    for (Count k = 0; k < inertia.factors; ++k) {
      const double* x = inertia.X + k * ngc_;
      for (Count j = 0; j < ngc_; ++j) {
        const Scalar weight = static_cast<Scalar>(inertia.alpha[k]) * static_cast<Scalar>(x[j]);
        for (Count i = 0; i < ngc_; ++i) work_[j * padded_ + i] += weight * static_cast<Scalar>(x[i]);
      }
    }
  }

  /// Calls visit(its range) for each block of G, one where G is not given by blocks.
  template <class Visit>
  void for_each_block(const Visit& visit) const {
    const Count whole[] = {0, ngc_};
    const Count* const offsets = by_factors_ ? whole : inertia_.offsets;
    const Count blocks = by_factors_ ? 1 : inertia_.blocks;
    for (Count b = 0; b < blocks; ++b) visit(Ranges<Scalar>::between(offsets[b], offsets[b + 1]));
  }

  /// Eliminates block by block, and in each only within its packs. Rows are not moved: pivots_ has the pivots in the
  /// order of elimination, rest_ the rows of the present block that are left, in any order. For these rows left_ has
  /// what is left of the diagonal, and is_left_ is 1. For others left_ is not positive; is_left_ is 0 but in an earlier
  /// block that ended without a positive pivot.
  void factor(Count most) {
    // What elimination leaves of an entry is compared with that entry: another coordinate may have another unit.
    for (Count i = 0; i < padded_; ++i) {
      left_[i] = kNone;
      diagonal_[i] = i < ngc_ ? work_[i * padded_ + i] : Scalar(0);
      is_left_[i] = 0;
    }
    if (inertia_.blocks > 1 || P::padded(ngc_) < padded_) fill_with_zeros(ngc_ * padded_, L_, columns_);
    largest_pivot_ = 0;
    least_pivot_ = kInfinity<Scalar>;
    rank_ = 0;
    for_each_block([&](const Range& own) { factor(own, most); });
    rank_padded_ = P::padded(rank_);
  }

  void factor(const Range& own, Count most) {
    for (Count i = own.first; i < own.end; ++i) {
      left_[i] = diagonal_[i];
      is_left_[i] = 1;
      rest_[i - own.first] = i;
      place_[i] = i - own.first;
    }
    for (Count rest = own.size(); rest > 0 && rank_ < most; --rest) {
      const auto [pivot, value] = largest_left(own);
      if (!(value > 0)) return;  // no pivot is left in the block: G is singular, or not positive semidefinite
      close(pivot);
      const Count last = rest_[rest - 1];
      rest_[place_[pivot]] = last;
      place_[last] = place_[pivot];
      if (!(value > static_cast<Scalar>(2 * kUnitRoundoff<Scalar> * static_cast<double>(ngc_)) * diagonal_[pivot])) {
        continue;  // depends on those before it
      }
      if (value > largest_pivot_) largest_pivot_ = value;
      if (value < least_pivot_) least_pivot_ = value;
      eliminate(own, pivot, value, rest - 1);
      ++rank_;
    }
  }

  struct Pivot {
    Count row = 0;
    Scalar value = 0;
  };

  /// The first of the largest; NaN is passed over. Without a branch that nothing could foretell.
  Pivot largest_left(const Range& own) const {
    typename P::Pack most = P::broadcast(kNone);
    for (Count i = own.first_of_packs; i < own.end_of_packs; i += P::kWidth) {
      most = P::max(P::load(left_.data() + i), most);
    }
    Pivot pivot;
    pivot.value = P::max(most);
    for (Count i = own.end_of_packs - P::kWidth; i >= own.first_of_packs; i -= P::kWidth) {
      const std::uint64_t lanes = lanes_where<Scalar>(P::load(left_.data() + i) == P::broadcast(pivot.value));
      pivot.row = lanes != 0 ? i + __builtin_ctzll(lanes) : pivot.row;
    }
    return pivot;
  }

  /// The row is a pivot no more. By packs: a number stored alone would hold up the load of its pack.
  void close(Count row) {
    const Count first = row & -P::kWidth;
    P::store(left_.data() + first, with_entry<Scalar>(P::load(left_.data() + first), first, row, kNone));
    P::store(is_left_.data() + first, with_entry<Scalar>(P::load(is_left_.data() + first), first, row, Scalar(0)));
  }

  [[gnu::always_inline]] inline void eliminate(const Range& own, Count pivot, Scalar value, Count rest) {
    const Scalar root = square_root(value);
    const typename P::Pack reciprocal = P::broadcast(Scalar(1) / root);
    Scalar* const l = L_.data() + rank_ * padded_;
    const Scalar* const row = work_.data() + pivot * padded_;
    for (Count i = own.first_of_packs; i < own.end_of_packs; i += P::kWidth) {
      const typename P::Pack entries = P::load(row + i) * P::load(is_left_.data() + i) * reciprocal;
      P::store(l + i, with_entry<Scalar>(entries, i, pivot, root));
      P::store(left_.data() + i, P::load(left_.data() + i) + -entries * entries);
    }
    pivots_[rank_] = pivot;
    for_each_tile<Scalar>(own.length(), [&](auto packs, Count at) {
      typename P::Pack column[static_cast<std::size_t>(packs.kValue)];
      for (Count p = 0; p < packs.kValue; ++p) column[p] = P::load(l + own.first_of_packs + at + p * P::kWidth);
      for (Count k = 0; k < rest; ++k) {
        Scalar* const to = work_.data() + rest_[k] * padded_ + own.first_of_packs + at;
        const typename P::Pack factor = P::broadcast(-l[rest_[k]]);
        for (Count p = 0; p < packs.kValue; ++p) {
          P::store(to + p * P::kWidth, P::load(to + p * P::kWidth) + factor * column[p]);
        }
      }
    });
  }

  /// The columns of W = L^-T are the rows of L^-1, by forward substitution. @pre full rank
  void invert_triangle() {
    for_each_block([&](const Range& own) {
      for (Count k = own.first; k < own.end; ++k) invert_row(own, k);
    });
  }

  void invert_row(const Range& own, Count k) {
    const Count pivot = pivots_[k];
    const Scalar reciprocal = Scalar(1) / L_[k * padded_ + pivot];
    for_each_tile<Scalar>(own.length(), [&](auto packs, Count tile) {
      const Count at = own.first_of_packs + tile;
      typename P::Pack sums[static_cast<std::size_t>(packs.kValue)];
      for (Count p = 0; p < packs.kValue; ++p) sums[p] = typename P::Pack{};
      const Scalar* from = columns_.data() + own.first * padded_ + at;
      for (Count j = own.first; j < k; ++j, from += padded_) {
        const typename P::Pack factor = P::broadcast(-L_[j * padded_ + pivot]);
        for (Count p = 0; p < packs.kValue; ++p) sums[p] += factor * P::load(from + p * P::kWidth);
      }
      for (Count p = 0; p < packs.kValue; ++p) {  // no column before it has an entry at the pivot
        const Count first = at + p * P::kWidth;
        P::store(columns_.data() + k * padded_ + first,
                 with_entry<Scalar>(sums[p] * reciprocal, first, pivot, reciprocal));
      }
    });
  }

  /// W = L S^-1 with S = L'L, by Cholesky of S. False where S, scaled to unit diagonal, may be singular for all that
  /// its rounding tells, and W worthless.
  bool pseudo_invert() {
    Scalar* const S = work_.data();  // by rows, rank x rank, as far apart as the rows of G were
    for (Count i = 0; i < rank_; ++i) {
      for (Count j = 0; j <= i; ++j) {
        S[i * padded_ + j] = dot(L_.data() + i * padded_, L_.data() + j * padded_, padded_);
      }
    }
    for (Count j = 0; j < rank_; ++j) {
      for (Count k = 0; k < j; ++k) S[j * padded_ + j] -= S[j * padded_ + k] * S[j * padded_ + k];
      S[j * padded_ + j] = square_root(S[j * padded_ + j]);
      for (Count i = j + 1; i < rank_; ++i) {
        for (Count k = 0; k < j; ++k) S[i * padded_ + j] -= S[i * padded_ + k] * S[j * padded_ + k];
        S[i * padded_ + j] /= S[j * padded_ + j];
      }
    }
    for (Count k = 0; k < rank_; ++k) copy(columns_.data() + k * padded_, L_.data() + k * padded_, padded_);
    for (Count k = 0; k < rank_; ++k) {  // W R' = L, then W R = that
      for (Count j = 0; j < k; ++j) subtract_column(k, j, S[k * padded_ + j]);
      scale(columns_.data() + k * padded_, Scalar(1) / S[k * padded_ + k], padded_);
    }
    for (Count k = rank_ - 1; k >= 0; --k) {
      for (Count j = k + 1; j < rank_; ++j) subtract_column(k, j, S[j * padded_ + k]);
      scale(columns_.data() + k * padded_, Scalar(1) / S[k * padded_ + k], padded_);
    }
    condition_of_columns_ = condition_of_columns(S);
    return is_small(condition_of_columns_);
  }

  /// Of a G that is not of full rank: whether what was cut is rounding of the doubles that it was given in, and all
  /// else far above that. Of a precision of few bits nothing can be told.
  bool is_cut_cleanly() const {
    if (rank_ == 0 || (kUnitRoundoff<Scalar>) > kCleanCut * kCleanCut) return false;
    return least_pivot_ > static_cast<Scalar>(kCleanCut * static_cast<double>(ngc_)) * largest_pivot_;
  }

  /// reach_, root_ and backward_error_, when they are first asked for.
  void measure() {
    if (is_measured_) return;
    is_measured_ = true;
    for (Count i = 0; i < padded_; ++i) reach_[i] = root_[i] = 0;
    backward_error_ = 0;
    if (given_) {
      for (Count i = 0; i < ngc_; ++i) reach_[i] = square_root(columns_[i * padded_ + i]);
      return;
    }
    if (by_columns_) {
      for (Count k = 0; k < rank_; ++k) add_squares(L_.data() + k * padded_, root_.data());
    } else {
      copy(root_.data(), diagonal_.data(), padded_);
    }
    for (Count k = 0; k < rank_; ++k) add_squares(columns_.data() + k * padded_, reach_.data());
    for (Count i = 0; i < padded_; ++i) reach_[i] = square_root(reach_[i]), root_[i] = square_root(root_[i]);
    const Scalar condition = rank_ == ngc_ ? condition_of_whole() : condition_of_columns_;
    backward_error_ = rank_ == ngc_ ? roundings() : roundings() * condition;
    if (!is_trusted(condition)) backward_error_ = kInfinity<Scalar>;
  }

  /// Of G formed from its factors, one for each term of its entries, and of what is done with it.
  Scalar roundings() const {
    const Count terms = 8 + 3 * ngc_ + (inertia_.factors > ngc_ ? inertia_.factors : ngc_);
    return static_cast<Scalar>(static_cast<double>(terms) * kUnitRoundoff<Scalar>);
  }
  /// The factors are those of a neighbour of G: they bound G* only where no neighbour is singular.
  bool is_trusted(Scalar condition) const { return is_sound_ && is_small(condition); }
  /// Whether rounding takes at most kTrusted of the least eigenvalue of G, scaled to unit diagonal.
  bool is_small(Scalar condition) const {
    return roundings() * static_cast<Scalar>(static_cast<double>(ngc_)) * condition < static_cast<Scalar>(kTrusted);
  }

  /// Of padded_ entries.
  Scalar sum(const Scalar* x) const {
    typename P::Pack total = typename P::Pack{};
    for (Count i = 0; i < padded_; i += P::kWidth) total += P::load(x + i);
    return P::sum(total);
  }

  void add_squares(const Scalar* x, Scalar* to) const {
    for (Count i = 0; i < padded_; i += P::kWidth) P::store(to + i, P::load(to + i) + P::load(x + i) * P::load(x + i));
  }

  /// The trace of the inverse of G scaled to unit diagonal: never less than its norm.
  Scalar condition_of_whole() {
    for (Count i = 0; i < padded_; ++i) white_[i] = root_[i] * reach_[i];
    return dot(white_.data(), white_.data(), padded_);
  }

  /// The same of L'L = R R', from the inverse of R and not from W: where the columns of L are dependent but for
  /// rounding, all of W is rounding, and may be small. The inverse takes the triangle of S that R leaves free.
  Scalar condition_of_columns(Scalar* S) const {
    Scalar trace = 1;
    for (Count j = 0; j < rank_; ++j) {
      Scalar* const column = S + j * padded_;  // entries j + 1 to rank_ of column j of the inverse
      const Scalar* const l = L_.data() + j * padded_;
      const Scalar first = Scalar(1) / S[j * padded_ + j];
      Scalar squares = first * first;
      for (Count i = j + 1; i < rank_; ++i) {
        const Scalar* const row = S + i * padded_;
        Scalar sum = row[j] * first;
        for (Count k = j + 1; k < i; ++k) sum += row[k] * column[k];
        column[i] = -sum / row[i];
        squares += column[i] * column[i];
      }
      trace += dot(l, l, padded_) * squares;
    }
    return trace;
  }

  void subtract_column(Count to, Count from, Scalar factor) {
    add_multiple(columns_.data() + to * padded_, -factor, columns_.data() + from * padded_, padded_);
  }

  Count ngc_ = 0, rank_ = 0, rank_padded_ = 0;
  Count padded_ = 0;  ///< the coordinate of an offset included, where all is zero
  static constexpr Scalar kNone = -1;           ///< less than any pivot
  static constexpr double kCleanCut = 0x1p-52;  ///< relative to the largest entry: the cut of inverse_inertia()
  bool given_ = false, by_factors_ = false;
  bool by_columns_ = false;    ///< L are the given factors
  bool is_sound_ = false;      ///< the rank in use is that of G
  bool is_measured_ = false;   ///< reach_, root_ and backward_error_ are those of this G
  contact_lemke::InertiaInput inertia_;
  Scalar largest_pivot_ = 0, least_pivot_ = 0, backward_error_ = 0, trace_ = 0, inverse_trace_ = 0;
  Scalar condition_of_columns_ = 1;  ///< of rank_ < ngc_
  Buffer<Scalar> work_, L_, is_left_, left_, white_, diagonal_, reach_, root_;
  Buffer<Scalar> columns_;                  ///< of W (of G* where it is given), padded_ apart
  Buffer<Scalar> rows_;                     ///< of W, rank_padded_ apart
  Buffer<Count> pivots_;
  Buffer<Count> rest_, place_;  ///< of the block at hand: rows that are left, and the place of each there
  Ranges<Scalar> ranges_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
