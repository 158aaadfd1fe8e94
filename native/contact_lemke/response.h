#pragma once

#include "native/contact_lemke/arithmetic.h"
#include "native/contact_lemke/engine.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// G* applied to impulses: what velocity they cause.
///
/// G is factored by Cholesky with diagonal pivoting, P'GP = L D L' with |L| <= 1, and W = P L^-T D^-1/2 is kept, so
/// that G* = W W'. The factors of a badly conditioned G differ in their scales D but hardly in their unit triangle, so
/// that W has small relative errors row by row where G^-1 itself would not. Singular G: L has rank columns and W = L
/// (L'L)^-1; fewer than ngc factors x, alpha > 0 are the columns sqrt(alpha) x of L, so that the range of G is theirs
/// and not what rounding leaves of it. Where G* was given, it is used as it is.
template <class Scalar>
class Response {
 public:
  /// The share of G's least eigenvalue, scaled to unit diagonal, that rounding may take before nothing is known of G*.
  static constexpr double kTrusted = 0.1;

  /// Takes all memory that load() needs; touches none of it.
  void reserve(const contact_lemke::Input& input) {
    ngc_ = input.ngc;
    padded_ = P::padded(ngc_);
    given_ = input.inertia.Ginv != nullptr;
    by_factors_ = input.inertia.factors >= 0;
    columns_.resize(ngc_ * padded_);
    white_.resize(padded_);
    reach_.resize(padded_);
    root_.resize(padded_);
    if (given_) return;
    work_.resize(ngc_ * padded_);
    L_.resize(ngc_ * padded_);
    rows_.resize(ngc_ * padded_);
    pivots_.resize(ngc_);
    done_.resize(padded_);
  }

  void load(const contact_lemke::Input& input) {
    reserve(input);
    inertia_ = input.inertia;
    if (given_) {
      load_inverse(input.inertia.Ginv);
      return measure_given();
    }
    bool sound = load_columns(input.inertia);
    const bool by_columns = sound;
    if (!by_columns) {
      form(input.inertia);
      factor(by_factors_ && input.inertia.factors < ngc_ ? input.inertia.factors : ngc_);
      if (rank_ == ngc_) {
        invert_triangle();
        sound = true;
      } else {
        sound = pseudo_invert() && is_cut_cleanly();
      }
    }
    transpose();
    measure_factored(sound, by_columns);
    norm_ = 0;
    for (Count k = by_columns || rank_ == 0 ? 0 : rank_ - 1; k < rank_; ++k) {  // the last is of the smallest pivot
      const Scalar* const column = columns_.data() + k * padded_;
      const Scalar square = dot(column, column, padded_);
      norm_ = square > norm_ ? square : norm_;
    }
  }

  Count rank() const { return rank_; }
  /// G given whole is positive definite by contract, however ill-conditioned; fewer than ngc factors, or a G* as it is,
  /// may leave directions in which nothing moves.
  bool may_be_singular() const { return given_ || (by_factors_ && rank_ < ngc_); }
  bool full_rank() const { return !given_ && rank_ == ngc_; }

  /// Per coordinate the square root of (G*)_kk: no impulse p moves the coordinate by more than that times |p|_G*.
  /// Padded.
  const Scalar* reach() const { return reach_.data(); }
  /// Per coordinate the square root of G_kk; 0 where G* was given. Padded.
  const Scalar* root() const { return root_.data(); }
  /// The factors in use are those of a matrix that differs from G by no more than this times root_i root_j in each
  /// entry. Infinite where that may be a singular matrix, so that nothing is known of G*.
  Scalar backward_error() const { return backward_error_; }

  /// Whether G was given by blocks, one or many.
  bool has_blocks() const { return full_rank() && !by_factors_; }
  /// r (ngc) -= G c, in the bits of long double. @pre has_blocks()
  void subtract_inertia(const double* c, long double* r) const {
    for (Count b = 0; b < inertia_.blocks; ++b) {
      const Count first = inertia_.offsets[b];
      const Count size = inertia_.offsets[b + 1] - first;
      for (Count i = 0; i < size; ++i) {
        const double* const column = inertia_.G[b] + i * size;
        long double sum = 0;
        for (Count j = 0; j < size; ++j)
          sum += static_cast<long double>(column[j]) * static_cast<long double>(c[first + j]);
        r[first + i] -= sum;
      }
    }
  }

  /// The largest diagonal entry of W'W or, where it was given, of G*: an estimate of the norm of G*.
  Scalar norm() const { return norm_; }

  /// c := G* a; both ngc long, padded with zeros.
  void apply(const Scalar* a, Scalar* c) {
    if (given_) {
      combine(columns_.data(), padded_, ngc_, a, c, padded_);
      return;
    }
    whiten(a, white_.data());
    combine(columns_.data(), padded_, rank_, white_.data(), c, padded_);
  }

  /// L^-1 a, padded as a is. @pre full_rank()
  void whiten(const Scalar* a, Scalar* white) const {
    combine(rows_.data(), rank_padded_, ngc_, a, white, rank_padded_);
  }
  /// L'u
  void whiten_velocity(const Scalar* u, Scalar* white) const {
    for (Count k = 0; k < rank_; ++k) white[k] = dot(L_.data() + k * padded_, u, padded_);
  }
  /// L^-T white
  void unwhiten(const Scalar* white, Scalar* u) const { combine(columns_.data(), padded_, rank_, white, u, padded_); }

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

  void load_inverse(const double* Ginv) {
    white_.fill(padded_, Scalar(0));
    norm_ = 0;
    rank_ = ngc_;
    rank_padded_ = padded_;
    for (Count j = 0; j < ngc_; ++j) {
      for (Count i = 0; i < ngc_; ++i) columns_[j * padded_ + i] = static_cast<Scalar>(Ginv[j * ngc_ + i]);
      for (Count i = ngc_; i < padded_; ++i) columns_[j * padded_ + i] = 0;
      norm_ = columns_[j * padded_ + j] > norm_ ? columns_[j * padded_ + j] : norm_;
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

  /// Right-looking, on whole rows of the symmetric rest. Rows stay where they are: pivots_ tells their order.
  void factor(Count most) {
    Scalar* const left = done_.data();  // 1 where the row is not yet eliminated
    for (Count i = 0; i < padded_; ++i) left[i] = i < ngc_ ? Scalar(1) : Scalar(0);
    // What elimination leaves of an entry is compared with that entry: another coordinate may have another unit.
    Scalar* const whole = white_.data();
    for (Count i = 0; i < ngc_; ++i) whole[i] = root_[i] = work_[i * padded_ + i];
    for (Count i = ngc_; i < padded_; ++i) root_[i] = 0;
    first_pivot_ = last_pivot_ = 0;
    rank_ = 0;
    for (Count tried = 0; tried < ngc_ && rank_ < most; ++tried) {
      const Count pivot = largest_diagonal();
      const Scalar value = work_[pivot * padded_ + pivot];
      if (!(value > static_cast<Scalar>(2 * kUnitRoundoff<Scalar> * static_cast<double>(ngc_)) * whole[pivot])) {
        done_[pivot] = 0;  // depends on those before it
        continue;
      }
      if (rank_ == 0) first_pivot_ = value;
      last_pivot_ = value;
      eliminate(pivot, value);
      ++rank_;
    }
    rank_padded_ = P::padded(rank_);
  }

  Count largest_diagonal() const {
    Count pivot = 0;
    Scalar largest = -1;
    for (Count i = 0; i < ngc_; ++i) {
      const Scalar value = done_[i] * work_[i * padded_ + i];
      if (done_[i] != 0 && value > largest) {
        largest = value;
        pivot = i;
      }
    }
    return pivot;
  }

  void eliminate(Count pivot, Scalar value) {
    const Scalar root = square_root(value);
    const Scalar reciprocal = Scalar(1) / root;
    Scalar* const l = L_.data() + rank_ * padded_;
    const Scalar* const row = work_.data() + pivot * padded_;
    for (Count i = 0; i < padded_; i += P::kWidth) {
      P::store(l + i, P::load(row + i) * P::load(done_.data() + i) * reciprocal);
    }
    l[pivot] = root;
    done_[pivot] = 0;
    pivots_[rank_] = pivot;
    for (Count i = 0; i < ngc_; ++i) {
      if (done_[i] != 0) add_multiple(work_.data() + i * padded_, -l[i], l, padded_);
    }
  }

  /// The columns of W = L^-T are the rows of L^-1, by forward substitution.
  void invert_triangle() {
    for (Count k = 0; k < ngc_; ++k) {
      Scalar* const column = columns_.data() + k * padded_;
      const Count pivot = pivots_[k];
      for (Count i = 0; i < padded_; i += P::kWidth) P::store(column + i, typename P::Pack{});
      for (Count j = 0; j < k; ++j) {
        add_multiple(column, -L_[j * padded_ + pivot], columns_.data() + j * padded_, padded_);
      }
      column[pivot] += 1;
      scale(column, Scalar(1) / L_[k * padded_ + pivot], padded_);
    }
  }

  /// W = L S^-1 with S = L'L, by Cholesky of S. False where S is singular to working precision, W worthless.
  bool pseudo_invert() {
    Scalar* const S = work_.data();  // by rows, rank x rank, as far apart as the rows of G were
    for (Count i = 0; i < rank_; ++i) {
      for (Count j = 0; j <= i; ++j) {
        S[i * padded_ + j] = dot(L_.data() + i * padded_, L_.data() + j * padded_, padded_);
      }
    }
    bool independent = true;
    for (Count j = 0; j < rank_; ++j) {
      const Scalar whole = S[j * padded_ + j];
      for (Count k = 0; k < j; ++k) S[j * padded_ + j] -= S[j * padded_ + k] * S[j * padded_ + k];
      const Scalar left = S[j * padded_ + j];
      if (!(left > static_cast<Scalar>(4 * kUnitRoundoff<Scalar> * static_cast<double>(ngc_)) * whole)) {
        independent = false;
      }
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
    return independent;
  }

  /// Of a G that is not of full rank: whether what was cut is rounding of the doubles that it was given in, and all
  /// else far above that. Of a precision of few bits nothing can be told.
  bool is_cut_cleanly() const {
    if (kUnitRoundoff < Scalar >> kCleanCut * kCleanCut) return false;
    return last_pivot_ > static_cast<Scalar>(kCleanCut * static_cast<double>(ngc_)) * first_pivot_;
  }

  void measure_given() {
    for (Count i = 0; i < padded_; ++i) {
      reach_[i] = i < ngc_ ? square_root(columns_[i * padded_ + i]) : Scalar(0);
      root_[i] = 0;
    }
    backward_error_ = 0;
  }

  /// @pre transpose()
  void measure_factored(bool sound, bool by_columns) {
    if (by_columns) {
      for (Count i = 0; i < padded_; ++i) root_[i] = 0;
      for (Count k = 0; k < rank_; ++k) add_squares(L_.data() + k * padded_, root_.data());
    }
    for (Count i = 0; i < padded_; ++i) reach_[i] = 0;
    for (Count k = 0; k < rank_; ++k) add_squares(columns_.data() + k * padded_, reach_.data());
    for (Count i = 0; i < padded_; ++i) reach_[i] = square_root(reach_[i]);
    for (Count i = 0; i < padded_; ++i) root_[i] = square_root(root_[i]);
    const Scalar condition = rank_ == ngc_ ? condition_of_whole() : condition_of_columns();
    const Scalar roundings = static_cast<Scalar>((8 + 4 * static_cast<double>(ngc_)) * kUnitRoundoff<Scalar>);
    backward_error_ = rank_ == ngc_ ? roundings : roundings * condition;
    // The factors are those of a neighbour of G: they bound G* only where no neighbour is singular.
    const Scalar lost = roundings * static_cast<Scalar>(static_cast<double>(ngc_)) * condition;
    if (!sound || !(lost < static_cast<Scalar>(kTrusted))) backward_error_ = kInfinity<Scalar>;
  }

  void add_squares(const Scalar* x, Scalar* to) const {
    for (Count i = 0; i < padded_; i += P::kWidth) P::store(to + i, P::load(to + i) + P::load(x + i) * P::load(x + i));
  }

  /// The trace of the inverse of G scaled to unit diagonal: never less than its norm.
  Scalar condition_of_whole() {
    for (Count i = 0; i < padded_; ++i) white_[i] = root_[i] * reach_[i];
    return dot(white_.data(), white_.data(), padded_);
  }

  /// The same of L'L, whose inverse is W'W.
  Scalar condition_of_columns() const {
    Scalar trace = 1;
    for (Count k = 0; k < rank_; ++k) {
      const Scalar* const w = columns_.data() + k * padded_;
      const Scalar* const l = L_.data() + k * padded_;
      trace += dot(w, w, padded_) * dot(l, l, padded_);
    }
    return trace;
  }

  void subtract_column(Count to, Count from, Scalar factor) {
    add_multiple(columns_.data() + to * padded_, -factor, columns_.data() + from * padded_, padded_);
  }

  void transpose() {
    white_.fill(padded_, Scalar(0));
    for (Count i = 0; i < ngc_; ++i) {
      for (Count k = 0; k < rank_; ++k) rows_[i * rank_padded_ + k] = columns_[k * padded_ + i];
      for (Count k = rank_; k < rank_padded_; ++k) rows_[i * rank_padded_ + k] = 0;
    }
  }

  Count ngc_ = 0, padded_ = 0, rank_ = 0, rank_padded_ = 0;
  static constexpr double kCleanCut = 0x1p-52;  ///< relative to the largest entry: the cut of inverse_inertia()
  bool given_ = false, by_factors_ = false;
  contact_lemke::InertiaInput inertia_;
  Scalar norm_ = 0, first_pivot_ = 0, last_pivot_ = 0, backward_error_ = 0;
  Buffer<Scalar> work_, L_, done_, white_;
  Buffer<Scalar> reach_, root_;  ///< per coordinate
  Buffer<Scalar> columns_;       ///< of W (of G* where it is given), padded_ apart
  Buffer<Scalar> rows_;          ///< of W, rank_padded_ apart
  Buffer<Count> pivots_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
