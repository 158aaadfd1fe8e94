#include "native/proofs/farkas_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "core/answer/farkas.h"
#include "core/timed_solve.h"
#include "native/proofs/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Multiplications and additions above which a search is not made: about a second, and some milliseconds.
constexpr double kMostWork = 1e9;
constexpr double kMostQuadWork = 5e4;

/// Entries of a scaled tableau below this are rounding; reduced costs within the second are in doubt.
template <class Scalar>
constexpr Scalar kNoise = Scalar(sizeof(Scalar) == sizeof(double) ? 1e-11 : 0x1p-96);
template <class Scalar>
constexpr Scalar kDoubt = Scalar(sizeof(Scalar) == sizeof(double) ? 1e-8 : 0x1p-96);

/// Scaled entries below 2^-kWidestExponents may be data, but double does not tell them from rounding.
constexpr int kWidestExponents = 24;

/// Above this number of rows 113 bits do not try again what double has found but could not round.
constexpr std::size_t kFewRows = 24;

/// How nearly a ray of double has to prove, relative to the magnitudes of its terms: M'u <= 0, and q'u < 0.
constexpr double kNearlyZero = 1e-12;
constexpr double kClearlyNegative = 1e-3;

/// Ratios of two entries of a ray with denominators up to this become integers.
constexpr double kLargestDenominator = 0x1p20;

/// Relative errors of the entries of a ray.
template <class Scalar>
constexpr Quad kRayError = Quad(sizeof(Scalar) == sizeof(double) ? 0x1p-40 : 0x1p-80);

/// The nearest integer. @param x at least 0 and below 2^62
Quad nearest_integer(Quad x) { return static_cast<Quad>(static_cast<std::int64_t>(x + Quad{0.5})); }

/// The denominator of the first convergent of x's continued fraction that is x to within that relative error; 0: none
/// that is small.
std::int64_t denominator_of(Quad x, Quad error) {
  std::int64_t before = 0;
  std::int64_t denominator = 1;
  Quad rest = x;
  for (int step = 0; step < 40; ++step) {
    const Quad multiple = x * static_cast<Quad>(denominator);
    if (multiple >= Quad{0x1p52}) return 0;
    if (abs(multiple - nearest_integer(multiple)) <= error * std::max(multiple, Quad{1})) return denominator;
    const Quad whole = static_cast<Quad>(static_cast<std::int64_t>(rest));
    const Quad fraction = rest - whole;
    if (!(fraction > 0)) return 0;
    rest = 1 / fraction;
    if (rest > static_cast<Quad>(kLargestDenominator)) return 0;
    const std::int64_t next = static_cast<std::int64_t>(rest) * denominator + before;
    before = denominator;
    denominator = next;
    if (static_cast<double>(denominator) > kLargestDenominator) return 0;
  }
  return 0;
}

}  // namespace

/// s + A x = 0 with s, x >= 0, and the value c'x, which is to be negative. One row for each s, one
/// column for each x.
template <class Scalar>
struct FarkasSearch::Tableau {
  Scalar* entries = nullptr;  // by columns, the last row c
  Index rows = 0;
  Index columns = 0;

  Scalar* column(Index k) const { return entries + k * (rows + 1); }
  Scalar& cost(Index k) const { return column(k)[rows]; }

  /// Exchanges the basic variable of row r with the nonbasic one of column k. The caller exchanges their numbers.
  void exchange(Index r, Index k) const {
    Scalar* const pivot_column = column(k);
    const Scalar inverse = 1 / pivot_column[r];
    for (Index l = 0; l < columns; ++l) {
      Scalar* const other = column(l);
      if (l == k || other[r] == 0) continue;
      const Scalar factor = other[r] * inverse;
      for (Index i = 0; i <= rows; ++i) other[i] -= pivot_column[i] * factor;
      other[r] = factor;
    }
    for (Index i = 0; i <= rows; ++i) pivot_column[i] *= -inverse;
    pivot_column[r] = inverse;
  }
};

void FarkasSearch::load(const Lcp& lcp) {
  const Index n = lcp.size();
  const auto count = static_cast<std::size_t>(n);
  lcp_ = &lcp;
  proof_.resize(n);
  in_.resize(count);
  ray_.resize(count);
  for (auto* list : {&rows_, &columns_, &support_}) list->reserve(count);
  at_row_.resize(count + 1);
  at_column_.resize(count + 1);
  for (auto* exponents : {&row_exponent_, &column_exponent_}) exponents->resize(count);
  if (n <= room_) return;
  room_ = n;
  double_ = std::make_unique_for_overwrite<double[]>((count + 2) * (count + 1));
  const auto quad_rows = static_cast<std::size_t>(std::min(n, kLargestQuad));
  quad_ = std::make_unique_for_overwrite<Quad[]>((count + 2) * (quad_rows + 1));
}

bool FarkasSearch::find(const std::vector<char>& candidates, double deadline_s) {
  in_ = candidates;
  near_proof_ = false;
  drop_rows_without_part();
  if (!scale_rows_and_columns()) return false;
  const double entries = static_cast<double>(rows_.size()) * static_cast<double>(columns_.size() + 1);
  const double pivots = static_cast<double>(std::min(rows_.size(), columns_.size()) + 1);
  if (entries * pivots > kMostWork) return false;
  if (!wide_) {
    const End end = search(double_.get(), Goal::kSteepest, deadline_s);
    if (end == End::kNone) return false;
    if (end == End::kRay) {
      if (rounds_to_proof()) return true;
      near_proof_ = is_near_proof();
      if (search(double_.get(), Goal::kInterior, deadline_s) == End::kRay && rounds_to_proof()) return true;
      if (near_proof_ && rows_.size() > kFewRows) return false;
    }
  }
  if (static_cast<Index>(rows_.size()) > kLargestQuad || entries * pivots > kMostQuadWork) return false;
  if (search(quad_.get(), Goal::kSteepest, deadline_s) != End::kRay) return false;
  if (rounds_to_proof()) return true;
  return search(quad_.get(), Goal::kInterior, deadline_s) == End::kRay && rounds_to_proof();
}

/// A column of M without negative entries forbids the rows of its positive ones, and so on.
void FarkasSearch::drop_rows_without_part() {
  const Index n = lcp_->size();
  for (bool changed = true; changed;) {
    changed = false;
    for (Index j = 0; j < n; ++j) {
      bool positive = false;
      bool negative = false;
      for (Index i = 0; i < n && !negative; ++i) {
        if (in_[static_cast<std::size_t>(i)] == 0) continue;
        positive = positive || lcp_->M(i, j) > 0;
        negative = lcp_->M(i, j) < 0;
      }
      if (negative || !positive) continue;
      changed = true;
      for (Index i = 0; i < n; ++i) {
        if (lcp_->M(i, j) > 0) in_[static_cast<std::size_t>(i)] = 0;
      }
    }
  }
}

/// Chooses the rows and columns of the tableau, and powers of two that scale the largest entry of each to about one.
/// @returns whether a search can find anything: there are rows, and one of them has q_i < 0
bool FarkasSearch::scale_rows_and_columns() {
  const Index n = lcp_->size();
  rows_.clear();
  columns_.clear();
  bool has_negative = false;
  for (Index i = 0; i < n; ++i) {
    if (in_[static_cast<std::size_t>(i)] == 0) continue;
    rows_.push_back(i);
    has_negative = has_negative || lcp_->q(i) < 0;
  }
  if (!has_negative) return false;
  std::fill(row_exponent_.begin(), row_exponent_.end(), 0);
  for (Index j = 0; j < n; ++j) {
    if (std::any_of(rows_.begin(), rows_.end(), [&](Index i) { return lcp_->M(i, j) > 0; })) columns_.push_back(j);
  }
  std::fill(column_exponent_.begin(), column_exponent_.end(), 0);
  // Of the entries that are not zero; kNoExponent where there are none.
  const auto largest = [](const std::vector<Index>& members, const std::vector<int>& scaling, auto&& entry) {
    int result = kNoExponent;
    for (const Index k : members) {
      const int own = exponent_of(entry(k));
      if (own != kNoExponent) result = std::max(result, own + scaling[static_cast<std::size_t>(k)]);
    }
    return result;
  };
  for (int pass = 0; pass < 2; ++pass) {
    for (const Index i : rows_) {
      int exponent = largest(columns_, column_exponent_, [&](Index j) { return lcp_->M(i, j); });
      if (exponent == kNoExponent) exponent = std::max(exponent_of(lcp_->q(i)), -2000);
      row_exponent_[static_cast<std::size_t>(i)] = -exponent;
    }
    for (const Index j : columns_) {
      column_exponent_[static_cast<std::size_t>(j)] =
          -largest(rows_, row_exponent_, [&](Index i) { return lcp_->M(i, j); });
    }
  }
  cost_exponent_ = -largest(rows_, row_exponent_, [&](Index i) { return lcp_->q(i); });
  wide_ = false;
  for (const Index i : rows_) {
    const int row = row_exponent_[static_cast<std::size_t>(i)];
    const int cost = exponent_of(lcp_->q(i));
    wide_ = wide_ || (cost != kNoExponent && cost + row + cost_exponent_ < -kWidestExponents);
    for (const Index j : columns_) {
      const int own = exponent_of(lcp_->M(i, j));
      wide_ = wide_ ||
              (own != kNoExponent && own + row + column_exponent_[static_cast<std::size_t>(j)] < -kWidestExponents);
    }
  }
  return true;
}

/// kInterior: another nonbasic variable t, whose column asks each inequality to hold by t, is to grow.
template <class Scalar>
void FarkasSearch::fill(Tableau<Scalar>& tableau, Goal goal) {
  const bool interior = goal == Goal::kInterior;
  const auto rows = static_cast<Index>(columns_.size());
  tableau.rows = rows + (interior ? 1 : 0);
  tableau.columns = static_cast<Index>(rows_.size()) + (interior ? 1 : 0);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Index i = rows_[k];
    const int exponent = row_exponent_[static_cast<std::size_t>(i)];
    Scalar* const column = tableau.column(static_cast<Index>(k));
    for (std::size_t j = 0; j < columns_.size(); ++j) {
      const double entry = lcp_->M(i, columns_[j]);
      const int all = exponent + column_exponent_[static_cast<std::size_t>(columns_[j])];
      column[j] = entry == 0 ? Scalar(0) : static_cast<Scalar>(scaled(static_cast<Quad>(entry), all));
    }
    const Scalar cost = static_cast<Scalar>(scaled(static_cast<Quad>(lcp_->q(i)), exponent + cost_exponent_));
    column[rows] = cost;
    if (interior) column[rows + 1] = 0;
    at_column_[k] = static_cast<Index>(k);
  }
  if (interior) {
    Scalar* const column = tableau.column(tableau.columns - 1);
    std::fill(column, column + tableau.rows, Scalar(1));
    column[tableau.rows] = Scalar(-1);
    at_column_[rows_.size()] = static_cast<Index>(rows_.size());
  }
  for (Index j = 0; j < tableau.rows; ++j) at_row_[static_cast<std::size_t>(j)] = tableau.columns + j;
}

template <class Scalar>
FarkasSearch::End FarkasSearch::search(Scalar* storage, Goal goal, double deadline_s) {
  Tableau<Scalar> tableau{storage};
  fill(tableau, goal);
  return pivot_to_end(tableau, deadline_s);
}

/// Every vertex is the origin, so that each exchange is degenerate: the largest pivot is taken while that ends, and
/// then the lowest numbers among the pivots that are not small, which hardly goes round; a count ends it.
template <class Scalar>
FarkasSearch::End FarkasSearch::pivot_to_end(Tableau<Scalar>& tableau, double deadline_s) {
  const Index usual = 4 * (tableau.rows + tableau.columns);
  for (Index pivots = 0; pivots < 4 * usual; ++pivots) {
    if (pivots % 8 == 0 && !(wall_clock_s() < deadline_s)) return End::kDoubtful;
    const bool by_number = pivots >= usual;
    Index entering = -1;
    bool doubtful = false;
    for (Index k = 0; k < tableau.columns; ++k) {
      const Scalar cost = tableau.cost(k);
      if (!(cost < -kNoise<Scalar>)) {
        doubtful = doubtful || !(cost > kDoubt<Scalar>);
        continue;
      }
      const bool better = entering < 0 || (by_number ? at_column_[static_cast<std::size_t>(k)] <
                                                           at_column_[static_cast<std::size_t>(entering)]
                                                     : cost < tableau.cost(entering));
      if (better) entering = k;
    }
    if (entering < 0) return doubtful ? End::kDoubtful : End::kNone;
    const Scalar* const column = tableau.column(entering);
    Scalar largest = 0;
    Scalar size = 0;
    for (Index r = 0; r < tableau.rows; ++r) {
      largest = std::max(largest, column[r]);
      size = std::max(size, magnitude(column[r]));
    }
    if (!(size - size == 0)) return End::kDoubtful;
    if (!(largest > kNoise<Scalar> * std::max(size, Scalar(1)))) {
      take_ray(tableau, entering);
      return End::kRay;
    }
    Index leaving = -1;
    for (Index r = 0; r < tableau.rows; ++r) {
      if (by_number ? !(column[r] > Scalar(1e-3) * largest) : !(column[r] >= largest)) continue;
      if (leaving < 0 || at_row_[static_cast<std::size_t>(r)] < at_row_[static_cast<std::size_t>(leaving)]) leaving = r;
    }
    tableau.exchange(leaving, entering);
    std::swap(at_row_[static_cast<std::size_t>(leaving)], at_column_[static_cast<std::size_t>(entering)]);
  }
  return End::kDoubtful;
}

/// ray_ := u of the ray along which the entering variable grows, in the units of the data.
template <class Scalar>
void FarkasSearch::take_ray(const Tableau<Scalar>& tableau, Index entering) {
  std::fill(ray_.begin(), ray_.end(), Quad{0});
  ray_error_ = kRayError<Scalar>;
  const auto set = [&](Index variable, Quad value) {
    if (variable >= static_cast<Index>(rows_.size()) || !(value > 0)) return;
    const Index i = rows_[static_cast<std::size_t>(variable)];
    ray_[static_cast<std::size_t>(i)] = scaled(value, row_exponent_[static_cast<std::size_t>(i)]);
  };
  const Scalar* const column = tableau.column(entering);
  Scalar largest = 1;
  for (Index r = 0; r < tableau.rows; ++r) largest = std::max(largest, -column[r]);
  set(at_column_[static_cast<std::size_t>(entering)], 1);
  for (Index r = 0; r < tableau.rows; ++r) {
    if (!(-column[r] > kNoise<Scalar> * largest)) continue;
    set(at_row_[static_cast<std::size_t>(r)], static_cast<Quad>(-column[r]));
  }
}

/// In 113 bits, whose range holds products of entries far apart in scale. @pre rounds_to_proof() was false
bool FarkasSearch::is_near_proof() const {
  const auto nearly = [this](const auto& column, double zero) {
    Quad sum = 0;
    Quad size = 0;
    for (const Index i : support_) {
      const Quad term = column(i) * ray_[static_cast<std::size_t>(i)];
      sum += term;
      size += abs(term);
    }
    return sum <= zero * size;
  };
  if (!nearly(lcp_->q, -kClearlyNegative)) return false;
  return std::all_of(columns_.begin(), columns_.end(), [&](Index j) { return nearly(lcp_->M.col(j), kNearlyZero); });
}

bool FarkasSearch::round(const Vector& u) {
  if (u.size() != lcp_->size() || !u.allFinite() || !(u.minCoeff() >= 0)) return false;
  for (Index i = 0; i < u.size(); ++i) ray_[static_cast<std::size_t>(i)] = u(i);
  ray_error_ = kRayError<double>;
  columns_.clear();
  near_proof_ = false;
  return rounds_to_proof();
}

/// proof_ := a multiple of ray_, rounded to doubles, that proves it exactly: of small integers; with one entry equal to
/// 1; or, for few rows, one by which two rows cancel in a column. O(n) tries of O(n^2) each. @returns whether one does
bool FarkasSearch::rounds_to_proof() {
  support_.clear();
  for (std::size_t i = 0; i < ray_.size(); ++i) {
    if (ray_[i] > 0) support_.push_back(static_cast<Index>(i));
  }
  if (support_.empty()) return false;
  const auto entry = [this](Index i) { return ray_[static_cast<std::size_t>(i)]; };
  if (rounds_to_integers()) return true;
  constexpr std::size_t kMostUnits = 12;
  for (std::size_t k = 0; k < std::min(support_.size(), kMostUnits); ++k) {
    if (rounds_with_unit(entry(support_[k]))) return true;
  }
  // Two rows i, o cancel in column j exactly if their weights are |M_oj| and |M_ij|. (round() leaves no columns to
  // try.)
  constexpr std::size_t kMostRows = 4;
  if (support_.size() > kMostRows) return false;
  for (const Index i : support_) {
    for (const Index other : support_) {
      for (const Index j : columns_) {
        const double size = std::abs(lcp_->M(other, j));
        if (other != i && size > 0 && rounds_with_unit(entry(i) / static_cast<Quad>(size))) return true;
      }
    }
  }
  return false;
}

/// proof_ := ray_ / unit, each entry rounded.
bool FarkasSearch::rounds_with_unit(Quad unit) {
  proof_.setZero();
  for (const Index i : support_) {
    const double value = to_double(ray_[static_cast<std::size_t>(i)] / unit);
    if (!(value > 0 && value < std::numeric_limits<double>::infinity())) return false;
    proof_(i) = value;
  }
  return proves_unsolvable(*lcp_, proof_);
}

/// proof_ := the multiple of ray_ in small integers, where there is one.
bool FarkasSearch::rounds_to_integers() {
  Quad least = ray_[static_cast<std::size_t>(support_.front())];
  for (const Index i : support_) least = std::min(least, ray_[static_cast<std::size_t>(i)]);
  std::int64_t common = 1;
  for (const Index i : support_) {
    const std::int64_t own = denominator_of(ray_[static_cast<std::size_t>(i)] / least, ray_error_);
    if (own == 0) return false;
    common = std::lcm(common, own);
    if (static_cast<double>(common) > kLargestDenominator) return false;
  }
  proof_.setZero();
  for (const Index i : support_) {
    const Quad multiple = ray_[static_cast<std::size_t>(i)] / least * static_cast<Quad>(common);
    if (!(multiple < Quad{0x1p53})) return false;
    proof_(i) = to_double(nearest_integer(multiple));
  }
  return proves_unsolvable(*lcp_, proof_);
}

}  // namespace lcpbench
