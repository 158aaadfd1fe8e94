#pragma once

#include "native/active_set/active_set_engine.h"
#include "native/active_set/arithmetic.h"
#include "native/active_set/inverse_trace.h"
#include "native/active_set/semidefinite_root.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// The contact normals in coordinates in which the inertia is the identity: W with W'W = N'G*N.
///
/// Positive definite G = C'C (C upper triangular): W = C^-T N, and the velocity v becomes C v. W comes from eliminating
/// [G N] by rows, square roots last, so that few operations wait for one another. O(ngc^3 / 6 + nc ngc^2 / 2); of
/// blocks O(nc ngc) times their order.
///
/// A compliance r_j adds to each W_j an entry r_j^(1/2) of its own, which the rows do not hold: squared norms have it.
///
/// G of lower rank, or G* alone: G* = S S' with S (ngc x rank), W = S'N. For the cost see SemidefiniteRoot.
class Whitening {
  using L = Lanes<double>;

 public:
  /// What SemidefiniteRoot may be asked to decompose: -1 nothing, else the number of factors.
  static Count root_factors(const Input& input) {
    if (input.form == InertiaForm::kFactors) return input.factors;
    return input.form == InertiaForm::kInverse ? input.ngc : -1;
  }

  /// Room for all problems that are not larger. @param factors  root_factors()
  void reserve(Count ngc, Count nc, Count factors) {
    const Count velocities = L::padded(ngc);
    const Count contacts = L::padded(nc);
    rows_.resize(velocities * (velocities + contacts) + 1);
    normals_.resize(ngc * contacts + 1);
    whitened_.resize(nc * velocities + 1);
    resize_all(nc + 1, is_gathered_, moves_, squared_length_);
    resize_all(contacts + 1, squared_norm_, weight_);
    columns_.resize(velocities * velocities + 1);
    resize_all(velocities + 1, inverse_diagonal_, root_diagonal_, inverse_bound_, pivots_, solution_);
    inverse_trace_.reserve(ngc);
    if (factors >= 0) root_.reserve(ngc, factors);
  }

  /// False when the inertia is indefinite, not a number, or (dense G) singular to double. @pre reserve()
  bool load(const Input& input) {
    set_dimensions(input);
    given_normals_ = input.N;
    given_inertia_ = input.matrix;
    is_of_inverse_ = input.form == InertiaForm::kInverse;
    compliance_ = input.compliance;
    transpose(input.N, ngc_, ngc_, nc_, normals_.data());
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
  /// Whether G* was given, and is what inertia_column() gives.
  bool is_of_inverse() const { return is_of_inverse_; }

  /// Coordinate `i` of all whitened normals.
  const double* row(Count i) const { return rows_.data() + i * stride_ + velocity_lanes_; }
  Count row_stride() const { return stride_; }
  /// Coordinate `i` of all normals as given.
  const double* normals(Count i) const { return normals_.data() + i * contact_lanes_; }
  bool is_soft() const { return compliance_ != nullptr; }
  /// r_n. @pre is_soft()
  double compliance(Count contact) const { return compliance_[contact]; }
  /// Normal `contact` as given, ngc() entries.
  const double* given_normal(Count contact) const { return given_normals_ + contact * ngc_; }
  /// The square of what the rounding of W_j = S'N_j is relative to, to within a factor of kMostCancelled: |W_j|^2, and
  /// more where nearly all of W_j cancels. Where only rounding is left, W_j is zero: 0 then, since no impulse presses
  /// there, but of a contact that yields the square of |S| |N_j|, of which noise() was dropped. @pre not triangular()
  double squared_length(Count contact) const { return squared_length_[contact]; }
  /// Whether nearly all of some W_j cancels.
  bool cancels() const { return cancels_; }
  /// Whether an impulse at the contact moves anything.
  bool moves(Count contact) const { return triangular_ || moves_[contact]; }
  double squared_norm(Count contact) const { return squared_norm_[contact]; }
  const double* squared_norms() const { return squared_norm_.data(); }
  double largest_squared_norm() const { return largest_squared_norm_; }
  /// 1 / |W_j|^2 by contact; 0 for contacts that no impulse moves.
  const double* weights() const { return weight_.data(); }

  /// Relative size of the rounding errors in a whitened normal, about.
  double noise() const { return noise_; }

  /// Roots of the diagonal of G, velocity_lanes() entries. @pre triangular()
  const double* root_diagonal() const { return root_diagonal_.data(); }
  /// Column of G, ngc() entries. @pre triangular()
  const double* inertia_column(Count j) const { return given_inertia_ + j * ngc_; }
  /// C'C differs from G by no more than this times the roots of G_ii G_jj in each entry. @pre triangular()
  double backward_error() const {
    return static_cast<double>(ngc_ + 1) * kUnitRoundoff<double>;
  }
  /// At least the inverse of the least eigenvalue of C'C scaled to unit diagonal, with room for what rounding adds
  /// where G itself keeps nine tenths of that eigenvalue. @pre triangular()
  double condition() const { return condition_; }

  /// An upper bound of the share of the least eigenvalue of G, scaled to unit diagonal, that backward_error() may take.
  /// @pre triangular()
  double lost() const { return lost_; }

  /// Sharpens condition() and lost(), once for each problem. @pre triangular()
  ///
  /// The trace of the inverse is never less than its norm. Cost: see InverseTrace.
  [[gnu::noinline]] void sharpen_condition() {
    if (condition_is_sharp_) return;
    condition_is_sharp_ = true;
    const double trace =
        inverse_trace_.of(rows_.data(), stride_, inverse_diagonal_.data(), root_diagonal_.data(), ngc_);
    const double bound = kConditionRoom * trace;
    const double share = static_cast<double>(ngc_) * backward_error() * bound;
    if (bound < condition_) condition_ = bound;
    if (share < lost_) lost_ = share;
  }

  /// Whitened normal `contact`, velocity_lanes() entries. Gathered from the rows on first use: many contacts never
  /// press.
  const double* normal(Count contact) {
    double* const to = whitened_.data() + contact * velocity_lanes_;
    if (!is_gathered_[contact]) gather(contact, to);
    return to;
  }

  /// to = C v. @pre triangular()
  void whiten_velocity(const double* v, double* to) const {
    set_zero(to, velocity_lanes_);
    combine_rows(to, to, columns_.data(), velocity_lanes_, v, ngc_, velocity_lanes_);
  }

  /// x := C^-1 x. @pre triangular()
  void solve(double* x) {
    for (Count i = ngc_ - 1; i >= 0; --i) {
      const double value = x[i] * inverse_diagonal_[i];
      add_multiple(x, -value, columns_.data() + i * velocity_lanes_, (i / L::kWidth + 1) * L::kWidth);
      solution_[i] = value;
    }
    take_solution(x);
  }

  /// x := C^-T x. @pre triangular()
  [[gnu::always_inline]] inline void solve_transposed(double* x) {
    for (Count i = 0; i < ngc_; ++i) {
      const double value = x[i] * inverse_diagonal_[i];
      const Count first = i / L::kWidth * L::kWidth;
      add_multiple(x + first, -value, rows_.data() + i * stride_ + first, velocity_lanes_ - first);
      solution_[i] = value;
    }
    take_solution(x);
  }

  /// to = v + S x. @pre !triangular(); to holds velocity_lanes() entries.
  void add_response(const double* v, const double* x, double* to) const {
    combine_rows(to, v, rows_.data(), stride_, x, rank_, velocity_lanes_);
  }

  /// to (rank) = S' x. @pre !triangular()
  void project(const double* x, double* to) const {
    for (Count i = 0; i < rank_; ++i) to[i] = dot(rows_.data() + i * stride_, x, velocity_lanes_);
  }

 private:
  static constexpr double kEpsilon = 2 * kUnitRoundoff<double>;
  static constexpr double kConditionRoom = 1.2;
  /// Of the length of a whitened normal. Singular inertia is tested to kSureResidual, 1e-9: with twice this factor its
  /// rounding stays below 2e-6 of the scale, where the verdict allows 1e-4.
  static constexpr double kMostCancelled = 0x1p10;
  static constexpr double kLeastPivot = 0x1p-900;

  void set_dimensions(const Input& input) {
    ngc_ = input.ngc;
    nc_ = input.nc;
    velocity_lanes_ = L::padded(ngc_);
    contact_lanes_ = L::padded(nc_);
    stride_ = velocity_lanes_ + contact_lanes_;
  }

  /// Solutions stand apart until all are known: a number stored among others holds up the next load of the register.
  void take_solution(double* x) {
    for (Count i = ngc_; i < velocity_lanes_; ++i) solution_[i] = 0;
    copy(x, solution_.data(), velocity_lanes_);
  }

  double* work_row(Count i) { return rows_.data() + i * stride_; }

  bool factor_inertia(const Input& input) {
    root_.set_rows(rows_.data(), stride_, ngc_);
    switch (input.form) {
      case InertiaForm::kDense: return factor_dense(input.matrix);
      case InertiaForm::kFactors: return take_root(root_.find_of_factors(input));
      case InertiaForm::kInverse: return take_root(root_.find_of_inverse(input.matrix, kEpsilon));
    }
    return false;
  }

  // --- positive definite ---

  bool factor_dense(const double* G);

  /// Rows of [G N] become unit upper triangular times pivots.
  bool eliminate(const double* G);

  /// Behind the last nonzero of the row's entries from `least` on: no row after those is changed by it.
  Count profile_end(const double* row, Count least) const {
    Count end = ngc_;
    while (end > least && row[end - 1] == 0) --end;
    return end;
  }

  /// Makes rows of [C W] of the eliminated ones, and the columns of C. Left of the registers that hold the diagonal the
  /// rows keep what elimination left there, which nobody reads.
  void scale_rows();

  /// columns_ of the rows of C, as many as fill registers: the last ones are zero.
  void make_columns();

  /// With D the diagonal matrix of the roots of G_ii and e of ones, B = (C D^-1)^-T: the inverse of G scaled to unit
  /// diagonal is B'B. Where all entries of C but its diagonal are replaced by minus their magnitudes, B e becomes a
  /// bound on |B| e [Higham 2002, section 8.3], and its squared length one on the squared norm of B, and one on
  /// the norm of |B| e e'|B'|, in whose terms backward_error() takes from the least eigenvalue.
  void bound_condition(double squared_bound) {
    condition_ = kConditionRoom * squared_bound;
    if (!finite(condition_)) condition_ = kInfinity<double>;
    lost_ = backward_error() * condition_;
    condition_is_sharp_ = false;
  }

  /// Rounding errors grow with the cancellation in the pivots; the constant leaves room for their number.
  void set_noise(double growth) { noise_ = 16 * kEpsilon * growth; }

  // --- any rank ---

  bool take_root(bool found) {
    if (!found) return false;
    rank_ = root_.rank();
    set_noise(root_.growth());
    return true;
  }

  /// W = S'N.
  void apply_to_normals() {
    for (Count k = 0; k < rank_; ++k) {
      double* whitened = work_row(k) + velocity_lanes_;
      set_zero(whitened, contact_lanes_);
      combine_rows(whitened, whitened, normals_.data(), contact_lanes_, work_row(k), ngc_, contact_lanes_);
    }
  }

  // --- both ---

  void measure_normals() {
    Count j = 0;
    for (; j + 3 * L::kWidth <= contact_lanes_; j += 3 * L::kWidth) measure_packs<3>(j);
    for (; j < contact_lanes_; j += L::kWidth) measure_packs<1>(j);
    if (!triangular_) discard_rounding();
    for (j = 0; j < nc_ && compliance_ != nullptr; ++j) squared_norm_[j] += compliance_[j];
    is_gathered_.fill(nc_, false);
    const auto one = L::broadcast(1);
    const auto zero = L::broadcast(0);
    auto largest = zero;
    for (j = 0; j < contact_lanes_; j += L::kWidth) {
      const auto squared = L::load(squared_norm_.data() + j);
      largest = L::max(squared, largest);
      L::store(weight_.data() + j, squared > zero ? one / squared : zero);
    }
    largest_squared_norm_ = L::max(largest);
  }

  /// squared_norm_ of kPacks registers of contacts from `first` on.
  template <int kPacks>
  void measure_packs(Count first) {
    L::Pack sums[static_cast<unsigned>(kPacks)];
    for (auto& sum : sums) sum = L::broadcast(0);
    for (Count i = 0; i < rank_; ++i) {
      for (int p = 0; p < kPacks; ++p) {
        const auto entry = L::load(row(i) + first + p * L::kWidth);
        sums[p] += entry * entry;
      }
    }
    for (int p = 0; p < kPacks; ++p) L::store(squared_norm_.data() + first + p * L::kWidth, sums[p]);
  }

  void gather(Count contact, double* to) {
    const double* const from = row(0) + contact;
    Count i = 0;
#if defined(__AVX2__) && !defined(__AVX512F__)  // what is stored by lanes and loaded by registers waits for the memory
    for (; i + 3 < rank_; i += 4) {
      const double* const first = from + i * stride_;
      L::store(to + i, L::Pack{first[0], first[stride_], first[2 * stride_], first[3 * stride_]});
    }
#endif
    for (; i < rank_; ++i) to[i] = from[i * stride_];
    for (; i < velocity_lanes_; ++i) to[i] = 0;
    is_gathered_[contact] = true;
  }

  /// Normals in null(G): what S leaves of them is rounding.
  void discard_rounding() {
    cancels_ = false;
    double response = 0;
    for (Count k = 0; k < rank_; ++k) response += dot(work_row(k), work_row(k), velocity_lanes_);
    for (Count j = 0; j < nc_; ++j) {
      double given = 0;
      for (Count i = 0; i < ngc_; ++i) given += normals(i)[j] * normals(i)[j];
      const double least = response * given / (kMostCancelled * kMostCancelled);
      const bool cancels = squared_norm_[j] < least;
      squared_length_[j] = cancels ? least : squared_norm_[j];
      const bool yields = compliance_ != nullptr && compliance_[j] > 0;
      moves_[j] = squared_norm_[j] > noise_ * noise_ * response * given;
      cancels_ = cancels_ || (moves_[j] ? cancels : yields);
      if (moves_[j]) continue;
      squared_length_[j] = yields ? response * given : 0.0;
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
  bool cancels_ = false;
  bool is_of_inverse_ = false;
  double noise_ = 0;
  double condition_ = 0;
  double lost_ = 0;
  bool condition_is_sharp_ = false;
  bool underflows_ = false;  // pivots have too few digits left

  Buffer<double> rows_;              // rank rows: [C W], or [S' W]
  Buffer<double> columns_;           // of C
  Buffer<double> inverse_diagonal_;  // of C
  Buffer<double> root_diagonal_;     // of G; during the elimination the diagonal itself
  Buffer<double> inverse_bound_;     // what bound_condition() tells of
  Buffer<double> pivots_;            // of the elimination
  Buffer<double> solution_;
  InverseTrace inverse_trace_;
  Buffer<double> normals_;   // N by rows
  Buffer<double> whitened_;  // W by columns, those that is_gathered_
  Buffer<bool> is_gathered_;
  Buffer<bool> moves_;       // see moves(); of a root S
  const double* given_normals_ = nullptr;
  const double* given_inertia_ = nullptr;
  const double* compliance_ = nullptr;  // nullptr: zero
  Buffer<double> squared_norm_;  // |W_j|^2
  Buffer<double> squared_length_;
  double largest_squared_norm_ = 0;
  Buffer<double> weight_;

  SemidefiniteRoot root_;  // S
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL

#include "native/active_set/whitening_cholesky.h"
