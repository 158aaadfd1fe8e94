#include "native/lcp_ladder/covering_lemke.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "core/timed_solve.h"
#include "native/proofs/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Relative to the entries of a scaled tableau: below this is rounding.
template <class Scalar>
constexpr Scalar kNoise = Scalar(sizeof(Scalar) == sizeof(double) ? 1e-11 : 0x1p-90);

constexpr int kPivotsPerClockReading = 8;

/// Different numbers in (1, 2): the second right-hand side. Where a combination of them vanishes, as of the first and
/// the fourth less the second and the third, rounding breaks the tie.
double generic(Index i) {
  const double turn = 0.6180339887498949 * static_cast<double>(i + 1);
  return 1 + (turn - std::floor(turn));
}

/// In lanes, so that one maximum need not wait for the other.
template <class Scalar>
Scalar largest_magnitude(const Scalar* x, Index n) {
  constexpr Index kLanes = 4;
  Scalar largest[kLanes] = {};
  Index i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    for (Index lane = 0; lane < kLanes; ++lane) largest[lane] = std::max(largest[lane], magnitude(x[i + lane]));
  }
  for (; i < n; ++i) largest[0] = std::max(largest[0], magnitude(x[i]));
  return std::max(std::max(largest[0], largest[1]), std::max(largest[2], largest[3]));
}

}  // namespace

/// basic = q + epsilon p + A nonbasic, by columns: those of A, q, p.
template <class Scalar>
struct CoveringLemke::Tableau {
  Scalar* entries = nullptr;
  Index n = 0;

  Scalar* column(Index k) const { return entries + k * n; }
  Scalar* q() const { return column(n + 1); }
  Scalar* p() const { return column(n + 2); }

  /// Exchanges the basic variable of row r with the nonbasic one of column k.
  void exchange(Index r, Index k) const {
    Scalar* const pivot = column(k);
    const Scalar inverse = 1 / pivot[r];
    for (Index l = 0; l < n + 3; ++l) {
      Scalar* const other = column(l);
      if (l == k || other[r] == 0) continue;
      const Scalar factor = -other[r] * inverse;
      for (Index i = 0; i < n; ++i) other[i] += pivot[i] * factor;
      other[r] = factor;
    }
    for (Index i = 0; i < n; ++i) pivot[i] *= inverse;
    pivot[r] = inverse;
  }
};

void CoveringLemke::load(const Lcp& lcp) {
  lcp_ = &lcp;
  n_ = lcp.size();
  const auto count = static_cast<std::size_t>(n_);
  exponent_.resize(count);
  power_.resize(n_);
  basic_.resize(count);
  nonbasic_.resize(count + 1);
  const auto reserve = [&]<class Scalar>(std::unique_ptr<Scalar[]>& entries, Index& room) {
    if (n_ <= room) return;
    room = n_;
    entries = std::make_unique_for_overwrite<Scalar[]>(count * (count + 3));
  };
  reserve(double_, room_);
  if (n_ <= kLargestQuad) reserve(quad_, quad_room_);
}

/// Diagonal entries to about one, and rows without one so that their largest entry is.
void CoveringLemke::scale() {
  for (Index i = 0; i < n_; ++i) {
    const int own = exponent_of(lcp_->M(i, i));
    exponent_[static_cast<std::size_t>(i)] = own == kNoExponent ? kNoExponent : -own / 2;
  }
  for (Index i = 0; i < n_; ++i) {
    if (exponent_[static_cast<std::size_t>(i)] != kNoExponent) continue;
    int largest = kNoExponent;
    for (Index j = 0; j < n_; ++j) {
      const int other = exponent_[static_cast<std::size_t>(j)];
      const int entry = std::max(exponent_of(lcp_->M(i, j)), exponent_of(lcp_->M(j, i)));
      if (entry != kNoExponent) largest = std::max(largest, entry + (other == kNoExponent ? 0 : other));
    }
    exponent_[static_cast<std::size_t>(i)] = largest == kNoExponent ? 0 : -largest;
  }
}

/// Of the largest entry of the scaled q; 0 where q is zero.
int CoveringLemke::exponent_of_q() const {
  int largest = kNoExponent;
  for (Index i = 0; i < n_; ++i) {
    if (lcp_->q(i) != 0) largest = std::max(largest, std::ilogb(lcp_->q(i)) + exponent_[static_cast<std::size_t>(i)]);
  }
  return largest == kNoExponent ? 0 : largest;
}

template <class Scalar>
void CoveringLemke::fill(Tableau<Scalar>& tableau, Cover cover) {
  const int largest = exponent_of_q();
  // Products of two powers of two that are doubles, in this range, without calls for each entry.
  const auto in_range = [](int exponent) { return exponent >= -500 && exponent <= 500; };
  const bool narrow = std::all_of(exponent_.begin(), exponent_.end(), in_range);
  for (Index i = 0; i < n_ && narrow; ++i) power_(i) = std::ldexp(1.0, exponent_[static_cast<std::size_t>(i)]);
  for (Index j = 0; j < n_; ++j) {
    Scalar* const column = tableau.column(j);
    const double* const entries = lcp_->M.col(j).data();
    nonbasic_[static_cast<std::size_t>(j)] = n_ + j;
    if (narrow) {
      const double own = power_(j);
      for (Index i = 0; i < n_; ++i) column[i] = static_cast<Scalar>(entries[i]) * static_cast<Scalar>(power_(i) * own);
      continue;
    }
    for (Index i = 0; i < n_; ++i) {
      const int exponent = exponent_[static_cast<std::size_t>(i)] + exponent_[static_cast<std::size_t>(j)];
      column[i] = scaled(static_cast<Scalar>(entries[i]), exponent);
    }
  }
  for (Index i = 0; i < n_; ++i) {
    const int exponent = exponent_[static_cast<std::size_t>(i)] - largest;
    tableau.q()[i] = scaled(static_cast<Scalar>(lcp_->q(i)), exponent);
    tableau.p()[i] = static_cast<Scalar>(generic(i));
    tableau.column(n_)[i] = Scalar(cover == Cover::kAll || lcp_->q(i) < 0 ? 1 : 0);
    basic_[static_cast<std::size_t>(i)] = i;
  }
  nonbasic_[static_cast<std::size_t>(n_)] = 2 * n_;
}

/// Where the artificial variable comes in: the last w_i to become nonnegative as it grows.
template <class Scalar>
Index CoveringLemke::first_row(const Tableau<Scalar>& tableau) const {
  const Scalar* const q = tableau.q();
  const Scalar* const p = tableau.p();
  Index row = -1;
  for (Index i = 0; i < n_; ++i) {
    if (!(q[i] < 0)) continue;
    if (row < 0 || q[i] < q[row] || (q[i] == q[row] && p[i] < p[row])) row = i;
  }
  return row;
}

/// The row whose variable falls to zero first; -1: none. The artificial variable's where that is tied.
template <class Scalar>
Index CoveringLemke::blocking_row(const Tableau<Scalar>& tableau, Index entering, Index artificial_row) const {
  const Scalar* const column = tableau.column(entering);
  const Scalar* const q = tableau.q();
  const Scalar* const p = tableau.p();
  const Scalar least_pivot = kNoise<Scalar> * std::max(largest_magnitude(column, n_), Scalar(1));
  const Scalar zero = kNoise<Scalar> * largest_magnitude(q, n_);
  Scalar least = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < n_; ++i) {
    if (-column[i] > least_pivot) least = std::min(least, (std::max(q[i], Scalar(0)) + zero) / -column[i]);
  }
  Index row = -1;
  for (Index i = 0; i < n_; ++i) {
    if (!(-column[i] > least_pivot) || !(std::max(q[i], Scalar(0)) <= least * -column[i])) continue;
    if (i == artificial_row) return i;
    // Ties, within a tolerance, are decided by the second right-hand side: the smaller p_i / -a_i.
    if (row < 0 || p[i] * -column[row] < p[row] * -column[i]) row = i;
  }
  return row;
}

template <class Scalar>
void CoveringLemke::write_solution(const Tableau<Scalar>& tableau, Vector& z) const {
  const int largest = exponent_of_q();
  z.setZero();
  const Scalar* const q = tableau.q();
  for (Index r = 0; r < n_; ++r) {
    const Index variable = basic_[static_cast<std::size_t>(r)];
    if (variable < n_ || variable >= 2 * n_ || !(q[r] > 0)) continue;
    const Index i = variable - n_;
    z(i) = static_cast<double>(scaled(q[r], exponent_[static_cast<std::size_t>(i)] + largest));
  }
}

template <class Scalar>
CoveringLemke::End CoveringLemke::run(Cover cover, const Limits& limits, Vector& z) {
  pivots_ = 0;
  scale();
  Tableau<Scalar> tableau;
  tableau.n = n_;
  if constexpr (std::is_same_v<Scalar, Quad>) {
    tableau.entries = quad_.get();
  } else {
    tableau.entries = double_.get();
  }
  fill(tableau, cover);
  Index row = first_row(tableau);
  z.setZero();
  if (row < 0) return End::kSolved;
  Index entering = n_;
  for (Index artificial_row = row;;) {
    if (pivots_ % kPivotsPerClockReading == 0 && !(wall_clock_s() < limits.deadline_s)) return End::kTimeLimit;
    if (pivots_ >= limits.pivots) return End::kPivotLimit;
    tableau.exchange(row, entering);
    ++pivots_;
    auto& leaving = basic_[static_cast<std::size_t>(row)];
    std::swap(leaving, nonbasic_[static_cast<std::size_t>(entering)]);
    const Index left = nonbasic_[static_cast<std::size_t>(entering)];
    if (left == 2 * n_) break;
    const Index complement = left < n_ ? left + n_ : left - n_;
    const auto found = std::find(nonbasic_.begin(), nonbasic_.end(), complement);
    entering = static_cast<Index>(found - nonbasic_.begin());
    row = blocking_row(tableau, entering, artificial_row);
    if (row < 0) return End::kRay;
  }
  write_solution(tableau, z);
  return z.allFinite() ? End::kSolved : End::kBreakdown;
}

template CoveringLemke::End CoveringLemke::run<double>(Cover, const Limits&, Vector&);
template CoveringLemke::End CoveringLemke::run<Quad>(Cover, const Limits&, Vector&);

}  // namespace lcpbench
