// Lemke's pivoting with LEMKE's rules over two representations of the basis. Compiled once per instruction-set level
// into the namespace LCPBENCH_LEVEL; see lemke_engine.h for what may cross the border.
#include "native/lemke_engine.h"

#include <Eigen/Core>
#include <Eigen/LU>

#if !defined(LCPBENCH_LEVEL)
#error "LCPBENCH_LEVEL names the instruction-set level"
#endif

namespace lcpbench::lemke::LCPBENCH_LEVEL {
namespace {

using Count = std::ptrdiff_t;

#if defined(__AVX512F__)
constexpr Count kPackBytes = 64;
#elif defined(__AVX2__)
constexpr Count kPackBytes = 32;
#else
constexpr Count kPackBytes = 16;
#endif

/// As many scalars as one register of this level holds, and the integer mask that comparing two of them gives.
template <class Scalar>
struct Packed {
  typedef Scalar Pack __attribute__((vector_size(kPackBytes)));
  typedef decltype(Pack{} < Pack{}) Mask;
  static constexpr Count kWidth = kPackBytes / static_cast<Count>(sizeof(Scalar));

  static Pack load(const Scalar* from) {
    Pack pack;
    __builtin_memcpy(&pack, from, sizeof(pack));
    return pack;
  }
  static void store(Scalar* to, Pack pack) { __builtin_memcpy(to, &pack, sizeof(pack)); }
  static Pack broadcast(Scalar value) { return Pack{} + value; }
  static Pack min(Pack a, Pack b) { return a < b ? a : b; }
  static Pack max(Pack a, Pack b) { return a > b ? a : b; }

  /// Combines the lanes pairwise, in the same order at every call.
  template <class Combine>
  static Scalar reduce(Pack pack, Combine combine) {
    Scalar lanes[static_cast<std::size_t>(kWidth)];
    store(lanes, pack);
    for (Count half = kWidth / 2; half > 0; half /= 2) {
      for (Count lane = 0; lane < half; ++lane) lanes[lane] = combine(lanes[lane], lanes[lane + half]);
    }
    return lanes[0];
  }
  static Scalar sum(Pack pack) {
    return reduce(pack, [](Scalar a, Scalar b) { return a + b; });
  }
  static Scalar min(Pack pack) {
    return reduce(pack, [](Scalar a, Scalar b) { return a < b ? a : b; });
  }
  static Scalar max(Pack pack) {
    return reduce(pack, [](Scalar a, Scalar b) { return a > b ? a : b; });
  }
  static Count padded(Count size) { return (size + kWidth - 1) / kWidth * kWidth; }
};

/// Aligned memory that only grows; its content is undefined after resize().
template <class T>
class Buffer {
 public:
  Buffer() = default;
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { free_aligned(data_); }

  void resize(Count size) {
    if (size <= capacity_) return;
    free_aligned(data_);
    data_ = nullptr;
    capacity_ = 0;
    data_ = static_cast<T*>(allocate_aligned(static_cast<std::size_t>(size) * sizeof(T)));
    capacity_ = size;
  }
  void fill(Count size, T value) {
    resize(size);
    for (Count i = 0; i < size; ++i) data_[i] = value;
  }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](Count i) { return data_[i]; }
  const T& operator[](Count i) const { return data_[i]; }

 private:
  T* data_ = nullptr;
  Count capacity_ = 0;
};

template <class Scalar>
constexpr Scalar kInfinity = static_cast<Scalar>(__builtin_inf());

template <class Scalar>
Scalar magnitude(Scalar x) {
  return x < 0 ? -x : x;
}
inline double magnitude(double x) { return __builtin_fabs(x); }

/// A column of a sum: where it stands in memory and its factor in each of the two sums.
template <class Scalar>
struct Term {
  const Scalar* column;
  Scalar factor[2];
};

/// sums[s][0..size) += sum over the terms of factor[s] * column, s < kSums, reading each column once. `size` is a
/// multiple of the pack's width. Every entry is summed in the order of the terms, so that equal rows have equal sums.
template <std::size_t kSums, class Scalar>
void add_terms(const Term<Scalar>* terms, Count count, Count size, Scalar* const (&sums)[kSums]) {
  using P = Packed<Scalar>;
  constexpr std::size_t kRun = 4;
  constexpr Count kRunSize = static_cast<Count>(kRun) * P::kWidth;
  const auto offset = [](std::size_t r) { return static_cast<Count>(r) * P::kWidth; };
  Count i = 0;
  for (; i + kRunSize <= size; i += kRunSize) {
    typename P::Pack sum[kSums][kRun];
    for (std::size_t s = 0; s < kSums; ++s) {
      for (std::size_t r = 0; r < kRun; ++r) sum[s][r] = P::load(sums[s] + i + offset(r));
    }
    for (const Term<Scalar>* term = terms; term != terms + count; ++term) {
      for (std::size_t r = 0; r < kRun; ++r) {
        const typename P::Pack column = P::load(term->column + i + offset(r));
        for (std::size_t s = 0; s < kSums; ++s) sum[s][r] += term->factor[s] * column;
      }
    }
    for (std::size_t s = 0; s < kSums; ++s) {
      for (std::size_t r = 0; r < kRun; ++r) P::store(sums[s] + i + offset(r), sum[s][r]);
    }
  }
  for (; i < size; i += P::kWidth) {
    typename P::Pack sum[kSums];
    for (std::size_t s = 0; s < kSums; ++s) sum[s] = P::load(sums[s] + i);
    for (const Term<Scalar>* term = terms; term != terms + count; ++term) {
      const typename P::Pack column = P::load(term->column + i);
      for (std::size_t s = 0; s < kSums; ++s) sum[s] += term->factor[s] * column;
    }
    for (std::size_t s = 0; s < kSums; ++s) P::store(sums[s] + i, sum[s]);
  }
}

/// q and M of one problem, columns of its dense block formed when they are first asked for.
template <class Scalar>
class MatrixColumns {
 public:
  void load(const Input& input) {
    n_ = input.n;
    dense_ = input.dense;
    cones_ = input.cones;
    stride_ = Packed<Scalar>::padded(dense_);
    formed_ = 0;
    place_.fill(dense_, -1);
    columns_.resize(dense_ * stride_);
    copy_jacobian(input);
    copy_cones(input);
    matrix_.resize(input.M != nullptr ? dense_ * dense_ : 0);
    factored_ = input.M == nullptr;
    for (Count i = 0; !factored_ && i < dense_ * dense_; ++i) matrix_[i] = static_cast<Scalar>(input.M[i]);
  }

  Count n() const { return n_; }
  Count dense() const { return dense_; }
  Count cones() const { return cones_; }
  Count stride() const { return stride_; }  ///< entries of a column with their padding of zeros

  /// Column j < dense() of the dense block.
  const Scalar* column(Count j) {
    if (place_[j] < 0) form(j);
    return columns_.data() + place_[j] * stride_;
  }

  /// M(row, col) for any row and column.
  Scalar entry(Count row, Count col) {
    if (col >= dense_) return friction_cone_[row] == col - dense_ ? Scalar(1) : Scalar(0);
    if (row >= dense_) return cone_[col] == row - dense_ ? cone_coefficient_[col] : Scalar(0);
    return column(col)[row];
  }

  /// The friction rows of a cone, [first, last).
  Count friction_first(Count cone) const { return friction_begin_[cone]; }
  Count friction_last(Count cone) const { return friction_begin_[cone + 1]; }
  /// The cone whose row meets column j < dense(), -1 for none, and the entry there.
  Count cone(Count j) const { return cone_[j]; }
  Scalar cone_coefficient(Count j) const { return cone_coefficient_[j]; }

 private:
  void copy_jacobian(const Input& input) {
    ngc_ = input.ngc;
    J_.resize(ngc_ * stride_);
    for (Count g = 0; g < ngc_; ++g) {
      for (Count i = 0; i < dense_; ++i) J_[g * stride_ + i] = static_cast<Scalar>(input.J[g * dense_ + i]);
      for (Count i = dense_; i < stride_; ++i) J_[g * stride_ + i] = 0;
    }
    Ginv_.resize(ngc_ * ngc_);
    for (Count i = 0; i < ngc_ * ngc_; ++i) Ginv_[i] = static_cast<Scalar>(input.Ginv[i]);
    terms_.resize(ngc_);
  }

  void copy_cones(const Input& input) {
    cone_.fill(dense_, -1);
    friction_cone_.fill(n_, -1);
    cone_coefficient_.fill(dense_, 0);
    friction_begin_.resize(cones_ + 1);
    for (Count c = 0; c < cones_; ++c) {
      friction_begin_[c] = input.friction_begin[c];
      friction_begin_[c + 1] = input.friction_begin[c + 1];
      cone_[input.cone_normal[c]] = c;
      cone_coefficient_[input.cone_normal[c]] = static_cast<Scalar>(input.mu[c]);
      for (Count t = friction_begin_[c]; t < friction_begin_[c + 1]; ++t) {
        cone_[t] = friction_cone_[t] = c;
        cone_coefficient_[t] = -1;
      }
    }
  }

  void form(Count j) {
    Scalar* column = columns_.data() + formed_ * stride_;
    place_[j] = formed_++;
    for (Count i = 0; i < stride_; ++i) column[i] = 0;
    if (!factored_) {
      for (Count i = 0; i < dense_; ++i) column[i] = matrix_[j * dense_ + i];
      return;
    }
    for (Count g = 0; g < ngc_; ++g) {
      Scalar velocity = 0;
      for (Count h = 0; h < ngc_; ++h) velocity += Ginv_[h * ngc_ + g] * J_[h * stride_ + j];
      terms_[g] = {J_.data() + g * stride_, {velocity, Scalar(0)}};
    }
    Scalar* const sums[1] = {column};
    add_terms(terms_.data(), ngc_, stride_, sums);
  }

  Count n_ = 0, dense_ = 0, cones_ = 0, stride_ = 0, ngc_ = 0, formed_ = 0;
  bool factored_ = false;
  Buffer<Count> place_;  ///< of each dense column among the formed ones, -1 before that
  Buffer<Scalar> columns_;
  Buffer<Scalar> matrix_;
  Buffer<Scalar> J_;  ///< row g at g * stride_
  Buffer<Scalar> Ginv_;
  Buffer<Term<Scalar>> terms_;
  Buffer<Count> cone_, friction_cone_, friction_begin_;
  Buffer<Scalar> cone_coefficient_;
};

/// The basic variables as the ratio test sees them: value, rate and number, in any order. Slots that hold no variable
/// have d = 0. All arrays are padded to packs with d = x = 0.
template <class Scalar>
struct Slots {
  Count count = 0;  ///< a multiple of the pack's width
  Scalar* x = nullptr;
  Scalar* d = nullptr;
  Scalar* ratio = nullptr;     ///< scratch
  const Scalar* id = nullptr;  ///< variable numbers; exact in any Scalar for n < 2^22
};

enum class Block { kFound, kRay, kBreakdown };

template <class Scalar>
struct Blocking {
  Block kind = Block::kBreakdown;
  Count slot_id = 0;  ///< number of the leaving variable
};

/// Pivots whose d is this close to the largest count as equally large: rounding must not choose between duplicates.
constexpr double kEqualPivots = 1e-9;

/// LEMKE's ratio test. Theta = min (x_i + zero_tolerance) / d_i over d_i > pivot_tolerance; tied are all with
/// x_i / d_i <= theta; of these the artificial variable leaves if it is there, else the one with the largest d_i, and
/// of equally large ones that of the lowest number (LEMKE draws lots).
template <class Scalar>
Blocking<Scalar> ratio_test(const Slots<Scalar>& slots, Scalar pivot_tolerance, Scalar zero_tolerance,
                            Count artificial_id, Count artificial_slot) {
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  const Pack infinity = P::broadcast(kInfinity<Scalar>);
  Pack least = infinity;
  Pack largest = Pack{};
  Pack poison = Pack{};  // becomes NaN when any x or d is not finite
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    const Pack x = P::load(slots.x + i);
    const Pack d = P::load(slots.d + i);
    const auto candidate = d > pivot_tolerance;
    const Pack divisor = candidate ? d : P::broadcast(1);
    P::store(slots.ratio + i, candidate ? x / divisor : infinity);
    least = P::min(candidate ? (x + zero_tolerance) / divisor : infinity, least);
    largest = P::max(d, largest);
    poison += Scalar(0) * x + Scalar(0) * d;
  }
  if (!(P::sum(poison) == 0)) return {Block::kBreakdown, 0};
  if (!(P::max(largest) > pivot_tolerance)) return {Block::kRay, 0};
  const Scalar theta = P::min(least);
  if (!(theta < kInfinity<Scalar>)) return {Block::kBreakdown, 0};
  if (slots.ratio[artificial_slot] <= theta) return {Block::kFound, artificial_id};

  largest = Pack{};
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    largest = P::max(P::load(slots.ratio + i) <= theta ? P::load(slots.d + i) : Pack{}, largest);
  }
  const Scalar enough = static_cast<Scalar>(1 - kEqualPivots) * P::max(largest);
  Pack lowest = infinity;
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    const auto eligible = (P::load(slots.ratio + i) <= theta) & (P::load(slots.d + i) >= enough);
    lowest = P::min(eligible ? P::load(slots.id + i) : infinity, lowest);
  }
  return {Block::kFound, static_cast<Count>(P::min(lowest))};
}

/// x -= (x_leaving / d_leaving) d; returns that ratio.
template <class Scalar>
Scalar advance(const Slots<Scalar>& slots, Count leaving_slot) {
  using P = Packed<Scalar>;
  const Scalar ratio = slots.x[leaving_slot] / slots.d[leaving_slot];
  for (Count i = 0; i < slots.count; i += P::kWidth) {
    P::store(slots.x + i, P::load(slots.x + i) - ratio * P::load(slots.d + i));
  }
  return ratio;
}

/// What both bases keep: q, the covering vector, and where each variable stands.
template <class Scalar>
struct Problem {
  MatrixColumns<Scalar> M;
  Buffer<Scalar> q;
  Buffer<Count> slot_of;  ///< of each of the 2 n + 1 variables; meaningful while it is basic

  Count n() const { return M.n(); }
  Count artificial() const { return 2 * M.n(); }

  void load(const Input& input) {
    M.load(input);
    q.resize(n());
    for (Count i = 0; i < n(); ++i) q[i] = static_cast<Scalar>(input.q[i]);
    slot_of.fill(2 * n() + 1, -1);
  }

  bool zero_solves(Scalar zero_tolerance) const {
    for (Count i = 0; i < n(); ++i) {
      if (!(q[i] > -zero_tolerance)) return false;
    }
    return true;
  }

  Count most_negative_row() const {
    Count row = 0;
    for (Count i = 1; i < n(); ++i) {
      if (q[i] < q[row]) row = i;
    }
    return row;
  }

  Scalar cover(Count row) const { return q[row] < 0 ? Scalar(1) : Scalar(0); }
};

/// The basis as one n x n matrix B, in the signs of w - M z - cover z0 = q: x = B^-1 q, d = B^-1 (entering column), by
/// LU with partial pivoting of all of B at each pivot. Slot i is the variable of B's column i.
template <class Scalar>
class DenseBasis {
 public:
  void load(const Input& input) {
    problem_.load(input);
    const Count n = problem_.n();
    const Count padded = Packed<Scalar>::padded(n);
    B_.resize(n, n);
    rhs_.resize(n, 2);
    solution_.resize(n, 2);
    lu_ = LU(n);
    M_.resize(n, n);
    for (Count j = 0; j < n; ++j) {
      for (Count i = 0; i < n; ++i) M_(i, j) = problem_.M.entry(i, j);
    }
    for (Buffer<Scalar>* slots : {&x_, &d_, &ratio_}) slots->fill(padded, 0);
    id_.fill(padded, kInfinity<Scalar>);
    slots_ = {padded, x_.data(), d_.data(), ratio_.data(), id_.data()};
  }

  const Problem<Scalar>& problem() const { return problem_; }
  const Slots<Scalar>& slots() const { return slots_; }
  Count slot_of(Count variable) const { return problem_.slot_of[variable]; }

  /// Brings the artificial variable in for w of `row`.
  void start(Count row) {
    const Count n = problem_.n();
    B_.setIdentity();
    const Scalar value = -problem_.q[row];
    for (Count i = 0; i < n; ++i) {
      x_[i] = problem_.q[i] + problem_.cover(i) * value;
      put(i, i);
    }
    place(row, problem_.artificial(), value);
  }

  /// d for the entering variable; with kResolve also x anew.
  template <bool kResolve>
  bool solve(Count entering) {
    lu_.compute(B_);
    write_column(entering, rhs_.col(0));
    solution_.col(0).noalias() = lu_.permutationP() * rhs_.col(0);
    substitute(solution_.col(0));
    store(d_, 0);
    if constexpr (kResolve) solve_for_values();
    return true;
  }

  /// x of the present basis.
  bool resolve() {
    lu_.compute(B_);
    solve_for_values();
    return true;
  }

  void exchange(Count entering, Count leaving, Scalar value) { place(slot_of(leaving), entering, value); }

 private:
  using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using LU = Eigen::PartialPivLU<Dense>;

  void solve_for_values() {
    for (Count i = 0; i < problem_.n(); ++i) rhs_(i, 1) = problem_.q[i];
    solution_.col(1).noalias() = lu_.permutationP() * rhs_.col(1);
    substitute(solution_.col(1));
    store(x_, 1);
  }

  template <class Column>
  void substitute(Column column) {
    lu_.matrixLU().template triangularView<Eigen::UnitLower>().solveInPlace(column);
    lu_.matrixLU().template triangularView<Eigen::Upper>().solveInPlace(column);
  }

  void store(Buffer<Scalar>& slots, Count column) {
    for (Count i = 0; i < problem_.n(); ++i) slots[i] = solution_(i, column);
  }

  template <class Column>
  void write_column(Count variable, Column column) {
    const Count n = problem_.n();
    if (variable < n) {
      column.setZero();
      column(variable) = 1;
    } else if (variable < 2 * n) {
      column = -M_.col(variable - n);
    } else {
      for (Count i = 0; i < n; ++i) column(i) = -problem_.cover(i);
    }
  }

  void put(Count slot, Count variable) {
    id_[slot] = static_cast<Scalar>(variable);
    problem_.slot_of[variable] = slot;
  }

  void place(Count slot, Count variable, Scalar value) {
    write_column(variable, B_.col(slot));
    put(slot, variable);
    x_[slot] = value;
  }

  Problem<Scalar> problem_;
  Dense M_, B_, rhs_, solution_;
  LU lu_;
  Buffer<Scalar> x_, d_, ratio_, id_;
  Slots<Scalar> slots_;
};

/// Solves A X = [b_0 b_1] by Gaussian elimination with partial pivoting, A stored by rows with both right-hand sides at
/// their ends. Rows are exchanged by pointer; U is left with a unit diagonal, L is not kept.
template <class Scalar>
class SmallSystem {
 public:
  static constexpr Count kSides = 2;

  void reserve(Count most) {
    work_.resize(most * stride_of(most));
    rows_.resize(most);
    column_.resize(most);
  }

  /// Begins a system of the given order; every row is then to be written.
  void begin(Count order) {
    order_ = order;
    stride_ = stride_of(order);
  }

  /// Row r: `order` entries at `entries`, followed in memory by whatever fills the last pack.
  void write_row(Count r, const Scalar* entries, Scalar side_0, Scalar side_1) {
    Scalar* const row = work_.data() + r * stride_;
    for (Count c = 0; c < order_; c += P::kWidth) P::store(row + c, P::load(entries + c));
    row[order_] = side_0;
    row[order_ + 1] = side_1;
    for (Count c = order_ + kSides; c < stride_; ++c) row[c] = 0;
    rows_[r] = row;
    column_[r] = row[0];
  }

  /// False when a column has no nonzero pivot. `solution_*`: order entries each, padded with zeros.
  bool solve(Scalar* solution_0, Scalar* solution_1) {
    if (!eliminate()) return false;
    substitute(solution_0, solution_1);
    return true;
  }

 private:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  static constexpr Count kMostUnrolled = 8;

  static Count stride_of(Count order) { return P::padded(order + kSides); }

  bool eliminate() {
    Count pivot = largest_of_first_column();
    for (Count step = 0; step < order_; ++step) {
      const Scalar value = column_[pivot];
      if (!(magnitude(value) > 0)) return false;
      Scalar* const pivot_row = rows_[pivot];
      rows_[pivot] = rows_[step];
      column_[pivot] = column_[step];
      rows_[step] = pivot_row;
      pivot = subtract_below(step, pivot_row, Scalar(1) / value);
    }
    return true;
  }

  Count largest_of_first_column() const {
    Largest largest{0, -1};
    for (Count r = 0; r < order_; ++r) largest.offer(r, column_[r]);
    return largest.at;
  }

  /// A running maximum of magnitudes, without branches: where it lies is not predictable.
  struct Largest {
    Count at;
    Scalar size;
    void offer(Count place, Scalar value) {
      const Scalar candidate = magnitude(value);
      at = candidate > size ? place : at;
      size = candidate > size ? candidate : size;
    }
  };

  /// Scales the pivot row to a unit pivot, clears column `step` below it and gathers the next column, of which it
  /// returns the largest entry's row. Entries left of the pivot that share its pack are overwritten: nothing reads them
  /// again.
  Count subtract_below(Count step, Scalar* pivot_row, Scalar reciprocal) {
    const Count first = (step + 1) / P::kWidth * P::kWidth;
    switch ((stride_ - first) / P::kWidth) {
      case 1: return subtract_unrolled<1>(step, pivot_row, reciprocal);
      case 2: return subtract_unrolled<2>(step, pivot_row, reciprocal);
      case 3: return subtract_unrolled<3>(step, pivot_row, reciprocal);
      case 4: return subtract_unrolled<4>(step, pivot_row, reciprocal);
      case 5: return subtract_unrolled<5>(step, pivot_row, reciprocal);
      case 6: return subtract_unrolled<6>(step, pivot_row, reciprocal);
      case 7: return subtract_unrolled<7>(step, pivot_row, reciprocal);
      case kMostUnrolled: return subtract_unrolled<kMostUnrolled>(step, pivot_row, reciprocal);
      default: return subtract_long(step, first, pivot_row, reciprocal);
    }
  }

  /// The pivot row's packs stay in registers.
  template <Count kPacks>
  Count subtract_unrolled(Count step, Scalar* pivot_row, Scalar reciprocal) {
    const Count first = stride_ - kPacks * P::kWidth;
    Pack pivot[static_cast<std::size_t>(kPacks)];
    for (Count k = 0; k < kPacks; ++k) {
      pivot[k] = P::load(pivot_row + first + k * P::kWidth) * reciprocal;
      P::store(pivot_row + first + k * P::kWidth, pivot[k]);
    }
    Scalar* const column = column_.data();
    Scalar* const* const rows = rows_.data();
    const Count order = order_;
    Largest largest{step + 1, -1};
    for (Count r = step + 1; r < order; ++r) {
      Scalar* const row = rows[r] + first;
      const Scalar factor = column[r];
      for (Count k = 0; k < kPacks; ++k) {
        P::store(row + k * P::kWidth, P::load(row + k * P::kWidth) - factor * pivot[k]);
      }
      column[r] = row[step + 1 - first];
      largest.offer(r, column[r]);
    }
    return largest.at;
  }

  Count subtract_long(Count step, Count first, Scalar* pivot_row, Scalar reciprocal) {
    const Count stride = stride_;
    for (Count c = first; c < stride; c += P::kWidth) P::store(pivot_row + c, P::load(pivot_row + c) * reciprocal);
    Largest largest{step + 1, -1};
    for (Count r = step + 1; r < order_; ++r) {
      Scalar* const row = rows_[r];
      const Scalar factor = column_[r];
      for (Count c = first; c < stride; c += P::kWidth) {
        P::store(row + c, P::load(row + c) - factor * P::load(pivot_row + c));
      }
      column_[r] = row[step + 1];
      largest.offer(r, column_[r]);
    }
    return largest.at;
  }

  void substitute(Scalar* solution_0, Scalar* solution_1) const {
    const Count padded = P::padded(order_);
    for (Count i = 0; i < padded; i += P::kWidth) {
      P::store(solution_0 + i, Pack{});
      P::store(solution_1 + i, Pack{});
    }
    for (Count r = order_ - 1; r >= 0; --r) {
      const Scalar* const row = rows_[r];
      Pack sum_0 = Pack{};
      Pack sum_1 = Pack{};
      for (Count c = r / P::kWidth * P::kWidth; c < padded; c += P::kWidth) {
        const Pack entries = P::load(row + c);
        sum_0 += entries * P::load(solution_0 + c);
        sum_1 += entries * P::load(solution_1 + c);
      }
      solution_0[r] = row[order_] - P::sum(sum_0);
      solution_1[r] = row[order_ + 1] - P::sum(sum_1);
    }
  }

  Count order_ = 0, stride_ = 0;
  Buffer<Scalar> work_;
  Buffer<Scalar*> rows_;
  Buffer<Scalar> column_;  ///< of the rows not yet eliminated, the entries of the column that comes next
};

/// The basis as its kernel: rows whose w is nonbasic against columns of the basic z and the artificial variable, in the
/// signs of w = q + M z + cover z0. Everything else of the basis is a unit column and needs no factoring:
///
///     d_kernel = A^-1 M_kernel,e    (entering z_e)    or   -A^-1 e_r   (entering w of kernel row r)
///     d_w      = M_w,kernel d_kernel - M_w,e                M_w,kernel d_kernel
///     x_kernel = -A^-1 q_kernel,    x_w = q_w + M_w,kernel x_kernel
///
/// Slots: w of the dense rows, w of the cone rows, kernel columns, each padded. Slots of nonbasic w hold zeros.
template <class Scalar>
class KernelBasis {
 public:
  void load(const Input& input) {
    problem_.load(input);
    const Count n = problem_.n();
    cone_slots_ = problem_.M.stride();
    column_slots_ = cone_slots_ + P::padded(problem_.M.cones());
    most_slots_ = column_slots_ + P::padded(n);
    for (Buffer<Scalar>* slots : {&x_, &d_, &ratio_}) slots->fill(most_slots_, 0);
    id_.fill(most_slots_, kInfinity<Scalar>);
    q_.fill(column_slots_, 0);
    cover_.fill(column_slots_, 0);
    for (Count i = 0; i < n; ++i) {
      q_[row_slot(i)] = problem_.q[i];
      cover_[row_slot(i)] = problem_.cover(i);
    }
    rows_.resize(n);
    columns_.resize(n);
    entering_column_.resize(n);
    terms_.resize(n + 1);
    A_.resize(n * P::padded(n));
    system_.reserve(n);
    slots_ = {column_slots_, x_.data(), d_.data(), ratio_.data(), id_.data()};
  }

  const Problem<Scalar>& problem() const { return problem_; }
  const Slots<Scalar>& slots() const { return slots_; }
  Count slot_of(Count variable) const { return problem_.slot_of[variable]; }

  void start(Count row) {
    const Count n = problem_.n();
    const Scalar value = -problem_.q[row];
    for (Count i = 0; i < n; ++i) {
      const Count slot = row_slot(i);
      x_[slot] = problem_.q[i] + problem_.cover(i) * value;
      id_[slot] = static_cast<Scalar>(i);
      problem_.slot_of[i] = slot;
    }
    order_ = 0;
    stride_ = P::padded(kFirstStride < n ? kFirstStride : n);
    entering_column_[0] = 0;
    add_column(problem_.artificial(), value);
    add_row(row);
  }

  template <bool kResolve>
  bool solve(Count entering) {
    return solve_sides<true, kResolve>(entering);
  }

  bool resolve() { return solve_sides<false, true>(problem_.artificial()); }

  void exchange(Count entering, Count leaving, Scalar value) {
    const Count n = problem_.n();
    if (entering < n) {
      const Count row = kernel_row(entering);
      if (leaving < n) {
        replace_row(row, leaving);
      } else {
        const Count slot = slot_of(leaving);
        remove(row, slot - column_slots_);
      }
      put_row_variable(entering, value);
    } else if (leaving < n) {
      add_column(entering, value);
      add_row(leaving);
    } else {
      replace_column(slot_of(leaving) - column_slots_, entering, value);
    }
  }

 private:
  using P = Packed<Scalar>;
  static constexpr Count kFirstStride = 64;

  Count row_slot(Count row) const { return row < problem_.M.dense() ? row : cone_slots_ + row - problem_.M.dense(); }

  /// Position in the kernel of the row whose w is nonbasic.
  Count kernel_row(Count variable) const {
    Count row = 0;
    while (rows_[row] != variable) ++row;
    return row;
  }

  /// Entry of M, or of the covering vector, in the column of a basic variable that is no w.
  Scalar entry(Count row, Count variable) {
    if (variable == problem_.artificial()) return problem_.cover(row);
    return problem_.M.entry(row, variable - problem_.n());
  }

  template <bool kDirection, bool kValues>
  bool solve_sides(Count entering) {
    write_system<kDirection>(entering);
    Scalar* const direction = d_.data() + column_slots_;
    if constexpr (kValues) {
      if (!system_.solve(direction, x_.data() + column_slots_)) return false;
      extend(entering);
    } else {
      // Without new values the second right-hand side is idle; its solution must not touch x.
      if (!system_.solve(direction, ratio_.data() + column_slots_)) return false;
      extend_direction(entering);
    }
    return true;
  }

  template <bool kDirection>
  void write_system(Count entering) {
    if constexpr (kDirection) write_entering_column(entering);
    system_.begin(order_);
    for (Count r = 0; r < order_; ++r) {
      const Scalar direction = kDirection ? entering_column_[r] : Scalar(0);
      system_.write_row(r, A_.data() + r * stride_, direction, -problem_.q[rows_[r]]);
    }
  }

  void write_entering_column(Count entering) {
    const bool is_row = entering < problem_.n();
    for (Count r = 0; r < order_; ++r) {
      entering_column_[r] = is_row ? Scalar(rows_[r] == entering ? -1 : 0) : entry(rows_[r], entering);
    }
  }

  /// From the kernel's d and x to those of the basic w.
  void extend(Count entering) {
    using Pack = typename P::Pack;
    for (Count i = 0; i < column_slots_; i += P::kWidth) {
      P::store(x_.data() + i, P::load(q_.data() + i));
      P::store(d_.data() + i, Pack{});
    }
    Scalar* const sums[2] = {d_.data(), x_.data()};
    add_columns(entering, sums);
    clear_nonbasic(sums);
  }

  void extend_direction(Count entering) {
    for (Count i = 0; i < column_slots_; i += P::kWidth) P::store(d_.data() + i, typename P::Pack{});
    Scalar* const sums[1] = {d_.data()};
    add_columns(entering, sums);
    clear_nonbasic(sums);
  }

  template <std::size_t kSums>
  void add_columns(Count entering, Scalar* const (&sums)[kSums]) {
    const Count n = problem_.n();
    Count terms = 0;
    for (Count c = 0; c < order_; ++c) {
      terms = add_column_to(sums, columns_[c], d_[column_slots_ + c], x_[column_slots_ + c], terms);
    }
    if (entering >= n && entering != problem_.artificial()) {
      terms = add_column_to(sums, entering, Scalar(-1), Scalar(0), terms);
    }
    add_terms(terms_.data(), terms, cone_slots_, sums);
  }

  /// Adds the sparse part of one column at once and appends its dense part to the terms.
  template <std::size_t kSums>
  Count add_column_to(Scalar* const (&sums)[kSums], Count variable, Scalar d, Scalar x, Count terms) {
    const Scalar factor[2] = {d, x};
    if (variable == problem_.artificial()) {
      // The covering vector is zero on cone rows, whose q is zero.
      terms_[terms] = {cover_.data(), {d, x}};
      return terms + 1;
    }
    const MatrixColumns<Scalar>& M = problem_.M;
    const Count j = variable - problem_.n();
    if (j >= M.dense()) {
      for (std::size_t s = 0; s < kSums; ++s) {
        for (Count t = M.friction_first(j - M.dense()); t < M.friction_last(j - M.dense()); ++t)
          sums[s][t] += factor[s];
      }
      return terms;
    }
    if (const Count cone = M.cone(j); cone >= 0) {
      for (std::size_t s = 0; s < kSums; ++s) sums[s][cone_slots_ + cone] += M.cone_coefficient(j) * factor[s];
    }
    terms_[terms] = {problem_.M.column(j), {d, x}};
    return terms + 1;
  }

  template <std::size_t kSums>
  void clear_nonbasic(Scalar* const (&sums)[kSums]) {
    for (Count r = 0; r < order_; ++r) {
      for (std::size_t s = 0; s < kSums; ++s) sums[s][row_slot(rows_[r])] = 0;
    }
  }

  void add_column(Count variable, Scalar value) {
    if (order_ + 1 > stride_) widen();
    for (Count r = 0; r < order_; ++r) A_[r * stride_ + order_] = entering_column_[r];
    put_column_variable(order_, variable, value);
  }

  /// Completes add_column: the order grows here.
  void add_row(Count row) {
    rows_[order_] = row;
    ++order_;
    write_row(order_ - 1);
    clear_row_slot(row);
    set_column_slots();
  }

  void replace_row(Count position, Count row) {
    rows_[position] = row;
    write_row(position);
    clear_row_slot(row);
  }

  void replace_column(Count position, Count variable, Scalar value) {
    for (Count r = 0; r < order_; ++r) A_[r * stride_ + position] = entering_column_[r];
    put_column_variable(position, variable, value);
  }

  /// Removes a row and a column; the last ones take their places.
  void remove(Count row, Count column) {
    const Count last = order_ - 1;
    rows_[row] = rows_[last];
    for (Count c = 0; c < order_; ++c) A_[row * stride_ + c] = A_[last * stride_ + c];
    for (Count r = 0; r < last; ++r) A_[r * stride_ + column] = A_[r * stride_ + last];
    const Scalar value = x_[column_slots_ + last];
    if (column != last) put_column_variable(column, columns_[last], value);
    clear_slot(column_slots_ + last);
    id_[column_slots_ + last] = kInfinity<Scalar>;
    order_ = last;
    set_column_slots();
  }

  void write_row(Count position) {
    for (Count c = 0; c < order_; ++c) A_[position * stride_ + c] = entry(rows_[position], columns_[c]);
  }

  void put_column_variable(Count position, Count variable, Scalar value) {
    columns_[position] = variable;
    const Count slot = column_slots_ + position;
    problem_.slot_of[variable] = slot;
    id_[slot] = static_cast<Scalar>(variable);
    x_[slot] = value;
  }

  void put_row_variable(Count row, Scalar value) { x_[row_slot(row)] = value; }

  void clear_row_slot(Count row) { clear_slot(row_slot(row)); }

  void clear_slot(Count slot) { x_[slot] = d_[slot] = 0; }

  void set_column_slots() { slots_.count = column_slots_ + P::padded(order_); }

  /// Doubles the room of A's rows, from the last row to the first since they move up in place.
  void widen() {
    const Count n = problem_.n();
    const Count wider = 2 * stride_ < P::padded(n) ? 2 * stride_ : P::padded(n);
    for (Count r = order_ - 1; r > 0; --r) {
      for (Count c = order_ - 1; c >= 0; --c) A_[r * wider + c] = A_[r * stride_ + c];
    }
    stride_ = wider;
  }

  Problem<Scalar> problem_;
  Count cone_slots_ = 0, column_slots_ = 0, most_slots_ = 0;
  Count order_ = 0, stride_ = 0;
  Buffer<Count> rows_, columns_;  ///< the kernel's rows (of M) and columns (variables)
  Buffer<Scalar> A_;              ///< the kernel by rows, stride_ apart
  Buffer<Scalar> entering_column_;
  Buffer<Scalar> q_, cover_;  ///< by slots
  Buffer<Scalar> x_, d_, ratio_, id_;
  Buffer<Term<Scalar>> terms_;
  SmallSystem<Scalar> system_;
  Slots<Scalar> slots_;
};

Count complement(Count variable, Count n) { return variable < n ? variable + n : variable - n; }

bool out_of_time(const Rules& rules) {
  return rules.deadline_s < kInfinity<double> && !(rules.clock_s() < rules.deadline_s);
}

/// Lemke's path from the first exchange to its end. On kSolved the basis holds the solution's values.
template <bool kResolve, class Scalar, class Basis>
Outcome follow_path(Basis& basis, const Rules& rules) {
  const Count n = basis.problem().n();
  const Count artificial = basis.problem().artificial();
  const Scalar pivot_tolerance = static_cast<Scalar>(rules.pivot_tolerance);
  const Scalar zero_tolerance = static_cast<Scalar>(rules.zero_tolerance);
  Outcome outcome;
  Count leaving = basis.problem().most_negative_row();
  basis.start(leaving);
  while (leaving != artificial) {
    if (outcome.pivots >= rules.max_pivots) return outcome.ending = Ending::kPivotLimit, outcome;
    if (outcome.pivots % 16 == 0 && out_of_time(rules)) return outcome.ending = Ending::kTimeLimit, outcome;
    const Count entering = complement(leaving, n);
    ++outcome.factorizations;
    if (!basis.template solve<kResolve>(entering)) return outcome;
    const Blocking<Scalar> blocking =
        ratio_test(basis.slots(), pivot_tolerance, zero_tolerance, artificial, basis.slot_of(artificial));
    if (blocking.kind == Block::kRay) return outcome.ending = Ending::kRay, outcome;
    if (blocking.kind == Block::kBreakdown) return outcome;
    leaving = blocking.slot_id;
    const Scalar value = kResolve ? Scalar(0) : advance(basis.slots(), basis.slot_of(leaving));
    basis.exchange(entering, leaving, value);
    ++outcome.pivots;
    if (rules.on_pivot != nullptr) rules.on_pivot(rules.context, entering, leaving);
  }
  if constexpr (kResolve) {
    ++outcome.factorizations;
    if (!basis.resolve()) return outcome;
  }
  outcome.ending = Ending::kSolved;
  return outcome;
}

/// Writes z; false when a value is not finite.
template <class Scalar, class Basis>
bool write_solution(const Basis& basis, double* z) {
  const Slots<Scalar>& slots = basis.slots();
  const Count n = basis.problem().n();
  for (Count i = 0; i < slots.count; ++i) {
    if (!(slots.x[i] - slots.x[i] == 0)) return false;
  }
  for (Count i = 0; i < slots.count; ++i) {
    const Scalar id = slots.id[i];
    if (id >= static_cast<Scalar>(n) && id < static_cast<Scalar>(2 * n)) {
      z[static_cast<Count>(id) - n] = static_cast<double>(slots.x[i]);
    }
  }
  return true;
}

template <class Scalar, class Basis>
struct Interface {
  static void* create() { return new (allocate_aligned(sizeof(Basis))) Basis; }
  static void destroy(void* basis) {
    static_cast<Basis*>(basis)->~Basis();
    free_aligned(basis);
  }
  static void load(void* basis, const Input& input) { static_cast<Basis*>(basis)->load(input); }
  static Outcome solve(void* memory, const Rules& rules, double* z) {
    Basis& basis = *static_cast<Basis*>(memory);
    Outcome outcome;
    if (basis.problem().zero_solves(static_cast<Scalar>(rules.zero_tolerance))) {
      outcome.ending = Ending::kSolved;
      return outcome;
    }
    outcome = rules.resolve ? follow_path<true, Scalar>(basis, rules) : follow_path<false, Scalar>(basis, rules);
    if (outcome.ending == Ending::kSolved && !write_solution<Scalar>(basis, z)) outcome.ending = Ending::kBreakdown;
    return outcome;
  }
};

template <class Basis>
constexpr Engine engine_over() {
  using I = Interface<double, Basis>;
  return {I::create, I::destroy, I::load, I::solve};
}

}  // namespace

const Engine kDenseEngine = engine_over<DenseBasis<double>>();
const Engine kKernelEngine = engine_over<KernelBasis<double>>();

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
