#pragma once

#include "native/active_set/arithmetic.h"
#include "native/active_set/inverse_trace.h"
#include "native/active_set/orthogonal_basis.h"
#include "native/active_set_engine.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// The contact normals in coordinates in which the inertia is the identity: W with W'W = N'G*N.
///
/// Positive definite G = C'C (C upper triangular): W = C^-T N, and the velocity v becomes C v. W comes from eliminating
/// [G N] by rows, square roots last, so that few operations wait for one another. O(ngc^3 / 6 + nc ngc^2 / 2); of
/// blocks O(nc ngc) times their order.
///
/// G of lower rank, or G* alone: G* = S S' with S (ngc x rank), W = S'N. From factors, G = Y Y': Y = Q R, then R' = P
/// T, both by Gram-Schmidt, so that G = Q T'T Q' and S = Q T^-1; the condition number is never squared. From G* by
/// Cholesky with diagonal pivoting. O(ngc^3).
template <class Scalar>
class Whitening {
  using L = Lanes<Scalar>;

 public:
  void reserve(const Input& input) {
    set_dimensions(input);
    rows_.resize(ngc_ * stride_ + 1);
    normals_.resize(ngc_ * contact_lanes_ + 1);
    whitened_.resize(nc_ * velocity_lanes_ + 1);
    is_gathered_.resize(nc_ + 1);
    squared_norm_.resize(contact_lanes_ + 1);
    weight_.resize(contact_lanes_ + 1);
    columns_.resize(ngc_ * velocity_lanes_ + 1);
    inverse_diagonal_.resize(velocity_lanes_ + 1);
    inverse_trace_.reserve(ngc_);
    pivots_.resize(velocity_lanes_ + 1);
    solution_.resize(velocity_lanes_ + 1);
    if (kLastPrecision || input.form != InertiaForm::kDense) reserve_factors(input);
  }

  /// False when the inertia is indefinite, not a number, or (dense G) singular to this precision.
  bool load(const Input& input) {
    reserve(input);
    given_normals_ = input.N;
    given_inertia_ = input.matrix;
    read_normals(input);
    rank_ = 0;
    triangular_ = false;
    if (!factor_inertia(input)) return false;
    if (!triangular_) apply_to_normals();
    measure_normals();
    return true;
  }

  Count ngc() const { return ngc_; }
  Count nc() const { return nc_; }
  Count rank() const { return rank_; }
  Count velocity_lanes() const { return velocity_lanes_; }
  Count contact_lanes() const { return contact_lanes_; }
  /// Whether C exists: G positive definite. Else S does.
  bool triangular() const { return triangular_; }

  /// Coordinate `i` of all whitened normals.
  const Scalar* row(Count i) const { return rows_.data() + i * stride_ + velocity_lanes_; }
  Count row_stride() const { return stride_; }
  /// Coordinate `i` of all normals as given.
  const Scalar* normals(Count i) const { return normals_.data() + i * contact_lanes_; }
  /// Normal `contact` as given, ngc() entries.
  const double* given_normal(Count contact) const { return given_normals_ + contact * ngc_; }
  Scalar squared_norm(Count contact) const { return squared_norm_[contact]; }
  const Scalar* squared_norms() const { return squared_norm_.data(); }
  /// 1 / |W_j|^2 by contact; 0 for contacts that no impulse moves.
  const Scalar* weights() const { return weight_.data(); }

  /// Relative size of the rounding errors in a whitened normal, about.
  Scalar noise() const { return noise_; }

  /// Entry of G. @pre triangular()
  double inertia(Count i, Count j) const { return given_inertia_[j * ngc_ + i]; }
  /// Column of G, ngc() entries. @pre triangular()
  const double* inertia_column(Count j) const { return given_inertia_ + j * ngc_; }
  /// C'C differs from G by no more than this times the roots of G_ii G_jj in each entry. @pre triangular()
  Scalar backward_error() const {
    return static_cast<Scalar>(static_cast<double>(ngc_ + 1)) * static_cast<Scalar>(L::kUnitRoundoff);
  }
  /// At least the inverse of the least eigenvalue of C'C scaled to unit diagonal, with room for what rounding adds
  /// where G itself keeps nine tenths of that eigenvalue. @pre triangular()
  Scalar condition() const { return condition_; }

  /// Sharpens condition(), once for each problem. @pre triangular()
  ///
  /// The trace of the inverse is never less than its norm. O(ngc^3 / 6); of blocks O(ngc) times their order.
  [[gnu::noinline]] void sharpen_condition() {
    if (condition_is_sharp_) return;
    condition_is_sharp_ = true;
    const Scalar trace = inverse_trace_.of(columns_.data(), inverse_diagonal_.data(), given_inertia_, ngc_);
    const Scalar bound = static_cast<Scalar>(kConditionRoom) * trace;
    if (!(bound > condition_)) condition_ = bound;
    if (!finite(condition_)) condition_ = kInfinity<Scalar>;
  }

  /// Whitened normal `contact`, velocity_lanes() entries. Gathered from the rows on first use: many contacts never
  /// press.
  const Scalar* normal(Count contact) {
    Scalar* const to = whitened_.data() + contact * velocity_lanes_;
    if (!is_gathered_[contact]) gather(contact, to);
    return to;
  }

  /// to = C v. @pre triangular()
  void whiten_velocity(const Scalar* v, Scalar* to) const {
    set_zero(to, velocity_lanes_);
    combine_rows(to, to, columns_.data(), velocity_lanes_, v, ngc_, velocity_lanes_);
  }

  /// x := C^-1 x. @pre triangular()
  void solve(Scalar* x) {
    for (Count i = ngc_ - 1; i >= 0; --i) {
      const Scalar value = x[i] * inverse_diagonal_[i];
      add_multiple(x, -value, columns_.data() + i * velocity_lanes_, (i / L::kWidth + 1) * L::kWidth);
      solution_[i] = value;
    }
    take_solution(x);
  }

  /// x := C^-T x. @pre triangular()
  [[gnu::always_inline]] inline void solve_transposed(Scalar* x) {
    for (Count i = 0; i < ngc_; ++i) {
      const Scalar value = x[i] * inverse_diagonal_[i];
      const Count first = i / L::kWidth * L::kWidth;
      add_multiple(x + first, -value, rows_.data() + i * stride_ + first, velocity_lanes_ - first);
      solution_[i] = value;
    }
    take_solution(x);
  }

  /// to = v + S x. @pre !triangular(); to holds velocity_lanes() entries.
  void add_response(const Scalar* v, const Scalar* x, Scalar* to) const {
    combine_rows(to, v, rows_.data(), stride_, x, rank_, velocity_lanes_);
  }

  /// to (rank) = S' x. @pre !triangular()
  void project(const Scalar* x, Scalar* to) const {
    for (Count i = 0; i < rank_; ++i) to[i] = dot(rows_.data() + i * stride_, x, velocity_lanes_);
  }

 private:
  static constexpr bool kLastPrecision = sizeof(Scalar) > sizeof(double);
  static constexpr Scalar kEpsilon = 2 * L::kUnitRoundoff;
  static constexpr double kConditionRoom = 1.2;
#if defined(LCPBENCH_WITH_QUAD)
  static constexpr double kLeastPivot = 0;
#else
  static constexpr double kLeastPivot = sizeof(Scalar) < sizeof(double) ? 0x1p-100 : 0x1p-900;
#endif

  void set_dimensions(const Input& input) {
    ngc_ = input.ngc;
    nc_ = input.nc;
    velocity_lanes_ = L::padded(ngc_);
    contact_lanes_ = L::padded(nc_);
    stride_ = velocity_lanes_ + contact_lanes_;
  }

  /// Solutions stand apart until all are known: a number stored among others holds up the next load of the register.
  void take_solution(Scalar* x) {
    for (Count i = ngc_; i < velocity_lanes_; ++i) solution_[i] = 0;
    copy(x, solution_.data(), velocity_lanes_);
  }

  Scalar* work_row(Count i) { return rows_.data() + i * stride_; }

  void read_normals(const Input& input) {
    for (Count i = 0; i < ngc_; ++i) {
      Scalar* row = normals_.data() + i * contact_lanes_;
      for (Count j = 0; j < nc_; ++j) row[j] = static_cast<Scalar>(input.N[j * ngc_ + i]);
      for (Count j = nc_; j < contact_lanes_; ++j) row[j] = 0;
    }
  }

  bool factor_inertia(const Input& input) {
    switch (input.form) {
      case InertiaForm::kDense: return factor_dense(input.matrix);
      case InertiaForm::kFactors: return factor_factors(input);
      case InertiaForm::kInverse: return factor_semidefinite(input.matrix, kEpsilon) && use_as_response();
    }
    return false;
  }

  // --- positive definite ---

  bool factor_dense(const double* G) {
    if (eliminate(G)) {
      triangular_ = true;
      rank_ = ngc_;
      return scale_rows();
    }
    // Singular to this precision. Only the last precision may say that it is singular: to within the rounding of the
    // doubles that it was given in, the cut of the pseudo-inverse everywhere in this program.
    if (!kLastPrecision || mixes_scales(G)) return false;
    return factor_semidefinite(G, Scalar(0x1p-52)) && make_response(factor_count_);
  }

  /// Whether a coordinate is so light beside another that the cut of the pseudo-inverse might take it for none.
  bool mixes_scales(const double* G) const {
    double largest = 0;
    for (Count i = 0; i < ngc_; ++i) largest = G[i * ngc_ + i] > largest ? G[i * ngc_ + i] : largest;
    for (Count i = 0; i < ngc_; ++i) {
      const double entry = G[i * ngc_ + i];
      if (entry != 0 && !(entry > 0x1p-40 * largest)) return true;
    }
    return false;
  }

  /// Rows of [G N] become unit upper triangular times pivots.
  bool eliminate(const double* G) {
    for (Count i = 0; i < ngc_; ++i) {
      Scalar* row = work_row(i);
      widen(row, G + i * ngc_, ngc_, velocity_lanes_);
      copy(row + velocity_lanes_, normals_.data() + i * contact_lanes_, contact_lanes_);
      inverse_diagonal_[i] = row[i];  // G_ii, until scale_rows
    }
    const Scalar least = static_cast<Scalar>(static_cast<double>(ngc_)) * kEpsilon;
    Scalar pivot = ngc_ > 0 ? work_row(0)[0] : Scalar(0);
    Count end = 0;
    for (Count k = 0; k < ngc_; ++k) {
      const Scalar* pivot_row = work_row(k);
      end = profile_end(pivot_row, end > k ? end : k + 1);
      if (!(pivot > least * inverse_diagonal_[k])) return false;
      pivots_[k] = pivot;
      const Scalar inverse = 1 / pivot;
      // The next pivot is computed apart from its row, so that its reciprocal need not wait for that to be written.
      if (k + 1 < ngc_) pivot = work_row(k + 1)[k + 1] + -pivot_row[k + 1] * inverse * pivot_row[k + 1];
      const Count first = k / L::kWidth * L::kWidth;
      eliminate_below(k, end, first, inverse);
    }
    return true;
  }

  /// Behind the last nonzero of the row's entries from `least` on: no row after those is changed by it.
  Count profile_end(const Scalar* row, Count least) const {
    Count end = ngc_;
    while (end > least && row[end - 1] == 0) --end;
    return end;
  }

  void eliminate_below(Count k, Count end, Count first, Scalar inverse_pivot) {
    constexpr int kMostPacks = 4;
    Scalar* A = rows_.data();
    for (; stride_ - first > kMostPacks * L::kWidth; first += kMostPacks * L::kWidth) {
      LCPBENCH_LEVEL::eliminate_below<kMostPacks>(A, stride_, k, end, first, inverse_pivot);
    }
    switch ((stride_ - first) / L::kWidth) {
      case 1: return LCPBENCH_LEVEL::eliminate_below<1>(A, stride_, k, end, first, inverse_pivot);
      case 2: return LCPBENCH_LEVEL::eliminate_below<2>(A, stride_, k, end, first, inverse_pivot);
      case 3: return LCPBENCH_LEVEL::eliminate_below<3>(A, stride_, k, end, first, inverse_pivot);
      case 4: return LCPBENCH_LEVEL::eliminate_below<4>(A, stride_, k, end, first, inverse_pivot);
    }
  }

  /// Makes rows of [C W] of the eliminated ones, and the columns of C. False where pivots have too few digits left that
  /// doubles do not lose to underflow.
  bool scale_rows() {
    for (Count i = ngc_; i < velocity_lanes_; ++i) inverse_diagonal_[i] = pivots_[i] = 1;
    auto growth = L::broadcast(1), product = L::broadcast(1), least = L::broadcast(1);
    for (Count i = 0; i < velocity_lanes_; i += L::kWidth) {
      const auto pivots = L::load(pivots_.data() + i);
      const auto ratio = L::load(inverse_diagonal_.data() + i) / pivots;
      least = L::min(pivots, least);
      growth = L::max(ratio, growth);
      product *= ratio;
    }
    bound_condition(product);
    // A loop of its own, which compilers turn into roots of whole registers.
    for (Count i = 0; i < velocity_lanes_; ++i) inverse_diagonal_[i] = 1 / L::square_root(pivots_[i]);
    for (Count i = 0; i < ngc_; ++i) {
      Scalar* row = work_row(i);
      scale(row, inverse_diagonal_[i], stride_);
      Scalar* column = columns_.data() + i * velocity_lanes_;
      for (Count j = 0; j <= i; ++j) column[j] = work_row(j)[i];
      for (Count j = i + 1; j < velocity_lanes_; ++j) column[j] = 0;
    }
    set_noise(L::square_root(L::max(growth)));
    for (Count i = 0; i < ngc_; ++i) {  // what elimination left below the diagonal
      for (Count j = i / L::kWidth * L::kWidth; j < i; ++j) work_row(i)[j] = 0;
    }
    return !(-L::max(-least) < static_cast<Scalar>(kLeastPivot));
  }

  /// Of the eigenvalues of G scaled to unit diagonal, whose sum is ngc, all but the least have a product of at most
  /// (ngc / (ngc - 1))^(ngc - 1) < e: the least is no less than the determinant over e. @param product  of G_ii over
  /// the pivots, by lanes
  void bound_condition(typename L::Pack product) {
    Scalar lanes[L::kWidth];
    L::store(lanes, product);
    Scalar whole = static_cast<Scalar>(kConditionRoom * 2.7182818284590453);
    for (const Scalar lane : lanes) whole *= lane;
    condition_ = finite(whole) ? whole : kInfinity<Scalar>;
    condition_is_sharp_ = false;
  }

  /// Rounding errors grow with the cancellation in the pivots; the constant leaves room for their number.
  void set_noise(Scalar growth) { noise_ = 16 * kEpsilon * growth; }

  // --- any rank ---

  void reserve_factors(const Input& input) {
    const Count count = input.form == InertiaForm::kFactors ? input.factors : ngc_;
    const Count most = count > ngc_ ? count : ngc_;
    factors_.resize(count * velocity_lanes_ + 1);
    coefficients_.resize(L::padded(most) * (ngc_ + 1) + 1);
    rest_.resize(L::padded(most) + 1);
    order_.resize(most + 1);
    range_.reserve(velocity_lanes_, ngc_);
    rank_basis_.reserve(L::padded(most), ngc_);
  }

  /// Y = X diag(alpha)^(1/2).
  bool factor_factors(const Input& input) {
    factor_count_ = input.factors;
    for (Count k = 0; k < factor_count_; ++k) {
      const Scalar weight = L::square_root(static_cast<Scalar>(input.alpha[k]));
      Scalar* column = factors_.data() + k * velocity_lanes_;
      for (Count i = 0; i < ngc_; ++i) column[i] = weight * static_cast<Scalar>(input.matrix[k * ngc_ + i]);
      for (Count i = ngc_; i < velocity_lanes_; ++i) column[i] = 0;
    }
    return make_response(factor_count_);
  }

  /// A = Y Y' to within `cut` times ngc times its largest diagonal entry, by Cholesky with diagonal pivoting.
  /// False when A is indefinite. Uses the rows as memory.
  bool factor_semidefinite(const double* A, Scalar cut) {
    Scalar largest = 0;
    for (Count i = 0; i < ngc_; ++i) {
      Scalar* row = work_row(i);
      for (Count j = 0; j < ngc_; ++j) row[j] = static_cast<Scalar>(A[i * ngc_ + j]);
      if (!finite(row[i])) return false;
      largest = row[i] > largest ? row[i] : largest;
    }
    const Scalar least = static_cast<Scalar>(static_cast<double>(ngc_)) * cut * largest;
    Scalar last = largest;
    for (factor_count_ = 0; factor_count_ < ngc_; ++factor_count_) {
      Count pivot = 0;
      for (Count i = 1; i < ngc_; ++i) {
        if (work_row(i)[i] > work_row(pivot)[pivot]) pivot = i;
      }
      if (!(work_row(pivot)[pivot] > least)) break;
      last = work_row(pivot)[pivot];
      take_factor(pivot);
    }
    for (Count i = 0; i < ngc_; ++i) {
      if (!(work_row(i)[i] >= -least)) return false;
    }
    set_noise(factor_count_ > 0 ? L::square_root(largest / last) : Scalar(1));
    return true;
  }

  /// The next column of Y, and A less its part.
  void take_factor(Count pivot) {
    Scalar* column = factors_.data() + factor_count_ * velocity_lanes_;
    const Scalar inverse = 1 / L::square_root(work_row(pivot)[pivot]);
    for (Count i = 0; i < ngc_; ++i) column[i] = inverse * work_row(pivot)[i];
    for (Count i = ngc_; i < velocity_lanes_; ++i) column[i] = 0;
    for (Count i = 0; i < ngc_; ++i) {
      for (Count j = 0; j < ngc_; ++j) work_row(i)[j] -= column[i] * column[j];
    }
    for (Count i = 0; i < ngc_; ++i) work_row(i)[pivot] = work_row(pivot)[i] = 0;
  }

  /// S = Y, for G* = Y Y'.
  bool use_as_response() {
    rank_ = factor_count_;
    for (Count k = 0; k < rank_; ++k) copy(work_row(k), factors_.data() + k * velocity_lanes_, velocity_lanes_);
    return true;
  }

  /// S for G = Y Y'.
  bool make_response(Count count) {
    if (!factor_range(count)) return false;
    // R' = P T: the rows of R, which are independent.
    const Count length = L::padded(count > ngc_ ? count : ngc_);
    rank_basis_.clear(length, ngc_);
    Scalar least = kInfinity<Scalar>;
    Scalar largest = 0;
    for (Count i = 0; i < rank_; ++i) {
      const Scalar* row = coefficients_.data() + i * length;
      Scalar* t = coefficients_.data() + ngc_ * length;
      const Scalar left = rank_basis_.split(row, dot(row, row, length), t, rest_.data());
      if (!(left > 0)) return false;
      rank_basis_.append(t, rest_.data(), left);
      least = left < least ? left : least;
      largest = left > largest ? left : largest;
    }
    for (Count i = 0; i < rank_; ++i) {
      copy(work_row(i), range_.q(i), velocity_lanes_);
      for (Count j = 0; j < i; ++j) add_multiple(work_row(i), -rank_basis_.r(j, i), work_row(j), velocity_lanes_);
      scale(work_row(i), 1 / rank_basis_.r(i, i), velocity_lanes_);
    }
    set_noise(rank_ > 0 ? L::square_root(largest / least) : Scalar(1));
    return true;
  }

  /// Q of Y = Q R, always the column that stands out most next; rows of R in coefficients_. A factor belongs to the
  /// range of the others when less than 2^-46 of its length stands out of it (single precision: 2^-18).
  bool factor_range(Count count) {
    const Count length = L::padded(count > ngc_ ? count : ngc_);
    const Scalar cut = sizeof(Scalar) < sizeof(double) ? Scalar(0x1p-18) : Scalar(0x1p-46);
    set_zero(coefficients_.data(), length * (ngc_ + 1));
    range_.clear(velocity_lanes_, ngc_);
    for (Count k = 0; k < count; ++k) order_[k] = k;
    Scalar* c = coefficients_.data() + ngc_ * length;
    for (rank_ = 0; rank_ < ngc_ && rank_ < count; ++rank_) {
      Count best = -1;
      Scalar most = 0;
      for (Count k = rank_; k < count; ++k) {
        const Scalar* factor = factors_.data() + order_[k] * velocity_lanes_;
        const Scalar squared = dot(factor, factor, velocity_lanes_);
        if (!finite(squared)) return false;
        const Scalar left = range_.split(factor, squared, c, rest_.data());
        if (left > cut * cut * squared && left > most) {
          most = left;
          best = k;
        }
      }
      if (best < 0) break;
      const Count chosen = order_[best];
      order_[best] = order_[rank_];
      order_[rank_] = chosen;
      const Scalar* factor = factors_.data() + chosen * velocity_lanes_;
      const Scalar left = range_.split(factor, dot(factor, factor, velocity_lanes_), c, rest_.data());
      range_.append(c, rest_.data(), left);
    }
    for (Count i = 0; i < rank_; ++i) {
      for (Count k = 0; k < count; ++k) {
        coefficients_[i * length + k] = dot(range_.q(i), factors_.data() + k * velocity_lanes_, velocity_lanes_);
      }
    }
    set_zero(c, length);
    return true;
  }

  /// W = S'N.
  void apply_to_normals() {
    for (Count k = 0; k < rank_; ++k) {
      Scalar* whitened = work_row(k) + velocity_lanes_;
      set_zero(whitened, contact_lanes_);
      combine_rows(whitened, whitened, normals_.data(), contact_lanes_, work_row(k), ngc_, contact_lanes_);
    }
  }

  // --- both ---

  void measure_normals() {
    for (Count j = 0; j < contact_lanes_; j += L::kWidth) {
      auto sum = L::broadcast(0);
      for (Count i = 0; i < rank_; ++i) {
        const auto entry = L::load(row(i) + j);
        sum += entry * entry;
      }
      L::store(squared_norm_.data() + j, sum);
    }
    if (!triangular_) discard_rounding();
    is_gathered_.fill(nc_, false);
    const auto one = L::broadcast(1);
    const auto zero = L::broadcast(0);
    for (Count j = 0; j < contact_lanes_; j += L::kWidth) {
      const auto squared = L::load(squared_norm_.data() + j);
      L::store(weight_.data() + j, squared > zero ? one / squared : zero);
    }
  }

  void gather(Count contact, Scalar* to) {
    const Scalar* const from = row(0) + contact;
    for (Count i = 0; i < rank_; ++i) to[i] = from[i * stride_];
    for (Count i = rank_; i < velocity_lanes_; ++i) to[i] = 0;
    is_gathered_[contact] = true;
  }

  /// Normals in null(G): what S leaves of them is rounding.
  void discard_rounding() {
    Scalar response = 0;
    for (Count k = 0; k < rank_; ++k) response += dot(work_row(k), work_row(k), velocity_lanes_);
    for (Count j = 0; j < nc_; ++j) {
      Scalar given = 0;
      for (Count i = 0; i < ngc_; ++i) given += normals(i)[j] * normals(i)[j];
      if (squared_norm_[j] > noise_ * noise_ * response * given) continue;
      squared_norm_[j] = 0;
      for (Count k = 0; k < rank_; ++k) work_row(k)[velocity_lanes_ + j] = 0;
    }
  }

  Count ngc_ = 0;
  Count nc_ = 0;
  Count rank_ = 0;
  Count velocity_lanes_ = 0;
  Count contact_lanes_ = 0;
  Count stride_ = 0;
  bool triangular_ = false;
  Scalar noise_ = 0;
  Scalar condition_ = 0;
  bool condition_is_sharp_ = false;

  Buffer<Scalar> rows_;              // rank rows: [C W], or [S' W]
  Buffer<Scalar> columns_;           // of C
  Buffer<Scalar> inverse_diagonal_;  // of C; during the elimination the diagonal of G
  Buffer<Scalar> pivots_;            // of the elimination
  InverseTrace<Scalar> inverse_trace_;
  Buffer<Scalar> solution_;
  Buffer<Scalar> normals_;   // N by rows
  Buffer<Scalar> whitened_;  // W by columns, those that is_gathered_
  Buffer<bool> is_gathered_;
  const double* given_normals_ = nullptr;
  const double* given_inertia_ = nullptr;
  Buffer<Scalar> squared_norm_;  // |W_j|^2
  Buffer<Scalar> weight_;

  Count factor_count_ = 0;
  Buffer<Scalar> factors_;  // Y by columns
  Buffer<Scalar> coefficients_;
  Buffer<Scalar> rest_;
  Buffer<Count> order_;
  OrthogonalBasis<Scalar> range_;
  OrthogonalBasis<Scalar> rank_basis_;
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
