#include "core/answer/refined_inertia.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>

#include "core/islands.h"

namespace lcpbench {
namespace {

/// Of a block scaled to diagonal entries from 1 to 4. Below, it may be what QuadInertia takes for singular.
constexpr double kLeastPivot = 0x1p-36;
constexpr int kMostCorrections = 10;
/// Of a correction to the one before it.
constexpr double kSlowest = 0x1p-4;
/// Of the next correction to the solution.
constexpr double kRefined = 0x1p-104;
constexpr double kRough = 0x1p-30;

/// The range in which products of the numbers of a block and its units neither overflow nor lose bits.
bool in_range(double magnitude) { return magnitude > 0x1p-300 && magnitude < 0x1p300; }

/// The power of two u with 1 <= u * diagonal * u < 4.
double unit_of(double diagonal) { return std::ldexp(1.0, -(std::ilogb(diagonal) >> 1)); }

}  // namespace

RefinedInertia::RefinedInertia(const Inertia& inertia) : inertia_(inertia) {
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    has_inertia_ = false;
    finite_ = inverse->Ginv.allFinite();
  } else if (std::holds_alternative<FactoredInertia>(inertia)) {
    make_precise();
  } else {
    for_each_matrix(inertia, [&](const Matrix& G, Index first) { add(G, static_cast<std::size_t>(first)); });
  }
}

void RefinedInertia::make_precise() const { precise_.emplace(inertia_); }

void RefinedInertia::add(const Matrix& given, std::size_t offset) {
  if (precise_) return;
  if (given != given.transpose()) return make_precise();  // NaN, too
  RowIslands parts;
  std::vector<Index> queue;
  find_row_islands(given, parts, queue);
  std::vector<std::size_t> size(static_cast<std::size_t>(parts.count), 0), place(parts.of_row.size());
  for (std::size_t i = 0; i < place.size(); ++i) place[i] = size[static_cast<std::size_t>(parts.of_row[i])]++;
  std::size_t first = coordinates_.size();
  const std::size_t first_block = blocks_.size();
  for (const std::size_t each : size) {
    blocks_.push_back({.first = first, .size = each});
    first += each;
  }
  coordinates_.resize(first);
  units_.resize(first);
  for (std::size_t i = 0; i < place.size(); ++i) {
    const std::size_t block = first_block + static_cast<std::size_t>(parts.of_row[i]);
    const double diagonal = given(static_cast<Index>(i), static_cast<Index>(i));
    if (!(diagonal > 0) || !in_range(diagonal)) return make_precise();
    coordinates_[blocks_[block].first + place[i]] = offset + i;
    units_[blocks_[block].first + place[i]] = unit_of(diagonal);
    block_of_.push_back(block);
  }
  for (std::size_t b = first_block; b < blocks_.size(); ++b) {
    for (std::size_t j = 0; j < blocks_[b].size; ++j) {
      const auto column = static_cast<Index>(coordinates_[blocks_[b].first + j] - offset);
      for (std::size_t i = 0; i < blocks_[b].size; ++i) {
        const double entry = given(static_cast<Index>(coordinates_[blocks_[b].first + i] - offset), column);
        if (entry == 0) continue;
        given_.rows.push_back(i);
        given_.values.push_back(entry);
      }
      given_.begin.push_back(given_.rows.size());
    }
    if (!factor(blocks_[b])) return make_precise();
  }
}

/// Appends the factors, and finds out how well they solve for a vector whose products have to be rounded: rounding has
/// a part along each direction, that in which the block is nearest to singular among them.
bool RefinedInertia::factor(Block& block) {
  if (!eliminate(block, 0, U_, pivots_)) return false;
  if (block.size == 1) return true;
  const auto expected = [](std::size_t i) { return 1 + 1 / static_cast<double>(3 + i % 61); };
  std::vector<double> x(block.size, 0);
  for (std::size_t j = 0; j < block.size; ++j) {
    const std::size_t column = block.first + j;
    for (std::size_t e = given_.begin[column]; e < given_.begin[column + 1]; ++e) {
      x[given_.rows[e]] += units_[block.first + given_.rows[e]] * given_.values[e] * units_[column] * expected(j);
    }
  }
  solve_in_double(block, x.data());
  for (std::size_t i = 0; i < x.size(); ++i) block.rough = block.rough || !(std::abs(x[i] - expected(i)) <= kRough / 8);
  // Rounding may be small by luck: it may be as much as what the inverse makes of a unit in the last place.
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = i % 2 == 0 ? expected(i) : -expected(i);
  solve_in_double(block, x.data());
  for (const double value : x) block.rough = block.rough || !(std::abs(value) * 0x1p-53 <= kRough / 8);
  return true;
}

/// The last row is eliminated first. The inertia of a robot whose coordinates are listed from its root to its leaves
/// then fills in no entry, and zeros cost nothing. @param shift  the share of the diagonal that is subtracted from it
/// @returns false unless all pivots are above kLeastPivot, or above 0 with a shift
bool RefinedInertia::eliminate(const Block& block, double shift, Columns& U, std::vector<double>& pivots) const {
  const std::size_t n = block.size;
  std::vector<double> A(n * n, 0);
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t column = block.first + j;
    for (std::size_t e = given_.begin[column]; e < given_.begin[column + 1]; ++e) {
      const std::size_t i = given_.rows[e];
      A[j * n + i] = units_[block.first + i] * given_.values[e] * units_[column];
    }
    A[j * n + j] -= shift * A[j * n + j];
  }
  for (std::size_t j = n; j-- > 0;) {
    const double* const last = A.data() + j * n;
    if (!(last[j] > (shift > 0 ? 0 : kLeastPivot))) return false;
    for (std::size_t i = 0; i < j; ++i) {
      if (last[i] == 0) continue;
      const double value = last[i] / last[j];
      U.rows.push_back(i);
      U.values.push_back(value);
      double* const rest = A.data() + i * n;
      for (std::size_t k = 0; k <= i; ++k) rest[k] -= value * last[k];
    }
    U.begin.push_back(U.rows.size());
    pivots.push_back(last[j]);
  }
  return true;
}

/// @param x  in the scaled coordinates of the block
void RefinedInertia::solve_in_double(const Block& block, double* x) const {
  const std::size_t last = block.first + block.size - 1;  // the place of column 0 in U_
  for (std::size_t j = block.size; j-- > 0;) {
    if (x[j] == 0) continue;
    for (std::size_t e = U_.begin[last - j]; e < U_.begin[last - j + 1]; ++e) x[U_.rows[e]] -= U_.values[e] * x[j];
    x[j] /= pivots_[last - j];
  }
  for (std::size_t j = 0; j < block.size; ++j) {
    for (std::size_t e = U_.begin[last - j]; e < U_.begin[last - j + 1]; ++e) x[j] -= U_.values[e] * x[U_.rows[e]];
  }
}

/// Solves for the entries of one block. @returns false, and leaves x, where the refinement does not converge
bool RefinedInertia::refine(const Block& block, QuadVector& x) const {
  const std::size_t n = block.size;
  const std::size_t* const coordinates = coordinates_.data() + block.first;
  const double* const units = units_.data() + block.first;
  if (n == 1) {
    Quad& value = x[coordinates[0]];
    if (value != 0) value /= given_.values[given_.begin[block.first]];
    return true;
  }
  residual_.resize(n);
  double largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    residual_[i] = x[coordinates[i]];
    largest = std::max(largest, std::abs(to_double(residual_[i])));
    if (residual_[i] != 0 && !is_finite(residual_[i])) return false;
  }
  if (largest == 0 && std::all_of(residual_.begin(), residual_.end(), [](Quad value) { return value == 0; })) {
    return true;
  }
  if (!in_range(largest)) return false;
  solution_.assign(n, 0);
  correction_.resize(n);
  double before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kMostCorrections; ++step) {
    for (std::size_t i = 0; i < n; ++i) correction_[i] = to_double(residual_[i]) * units[i];
    solve_in_double(block, correction_.data());
    double size = 0, whole = 0;
    for (std::size_t i = 0; i < n; ++i) {
      size = std::max(size, std::abs(correction_[i]));
      if (std::isnan(correction_[i])) return false;
      correction_[i] *= units[i];
      solution_[i] += correction_[i];
      whole = std::max(whole, std::abs(to_double(solution_[i]) / units[i]));
    }
    if (!(size <= kSlowest * before)) return false;
    // In a rough block the first corrections may hide how slowly the last direction converges.
    bool done = step > (block.rough ? 1 : 0) && size * (size / before) <= kRefined * whole;
    if (!done) {
      for (std::size_t j = 0; j < n; ++j) {
        const Quad of_column = correction_[j];
        if (of_column == 0) continue;
        const std::size_t column = block.first + j;
        for (std::size_t e = given_.begin[column]; e < given_.begin[column + 1]; ++e) {
          residual_[given_.rows[e]] -= given_.values[e] * of_column;
        }
      }
      done = std::all_of(residual_.begin(), residual_.end(), [](Quad value) { return value == 0; });
    }
    if (done) {
      for (std::size_t i = 0; i < n; ++i) x[coordinates[i]] = solution_[i];
      return true;
    }
    before = size;
  }
  return false;
}

void RefinedInertia::solve(QuadVector& x) const {
  if (!has_inertia_) {
    x = apply(x);
    return;
  }
  if (!precise_) {
    solved_ = x;
    const bool solved =
        std::all_of(blocks_.begin(), blocks_.end(), [&](const Block& block) { return refine(block, solved_); });
    if (solved) {
      x.swap(solved_);
      return;
    }
    make_precise();
  }
  if (precise_->well_defined()) {
    precise_->solve(x);
  } else {
    std::fill(x.begin(), x.end(), std::numeric_limits<double>::quiet_NaN());
  }
}

void RefinedInertia::load(std::span<const std::size_t> rows, const double* entries) const {
  rough_.resize(static_cast<std::size_t>(dimension(inertia_)), 0);
  for (const std::size_t i : pattern_) rough_[i] = 0;
  pattern_.assign(rows.begin(), rows.end());
  for (std::size_t e = 0; e < rows.size(); ++e) rough_[rows[e]] = entries[e];
}

/// rough_ := G* x for the x with these entries in `rows`; the rows of pattern_ may not be zero in it.
/// @returns is_moderate(): false, and no solution, where a refinement does not converge
bool RefinedInertia::solve_roughly(std::span<const std::size_t> rows, const double* entries) const {
  if (precise_) return false;
  load(rows, entries);
  wide_.resize(rough_.size(), 0);
  if (!has_inertia_) {
    const Matrix& Ginv = std::get<InverseInertia>(inertia_).Ginv;
    const Vector x = Eigen::Map<const Vector>(rough_.data(), Ginv.cols());
    Eigen::Map<Vector>(rough_.data(), Ginv.cols()) = Ginv * x;
    pattern_.resize(rough_.size());
    std::iota(pattern_.begin(), pattern_.end(), std::size_t{0});
    return true;
  }
  find_touched(rows);
  pattern_.clear();
  for (const std::size_t b : touched_) {
    const Block& block = blocks_[b];
    const std::span<const std::size_t> coordinates(coordinates_.data() + block.first, block.size);
    pattern_.insert(pattern_.end(), coordinates.begin(), coordinates.end());
    if (block.rough) {
      for (const std::size_t i : coordinates) wide_[i] = rough_[i];
      const bool refined = refine(block, wide_);
      for (const std::size_t i : coordinates) {
        rough_[i] = to_double(wide_[i]);
        wide_[i] = 0;
      }
      if (!refined) {
        make_precise();
        return false;
      }
      continue;
    }
    correction_.resize(block.size);
    for (std::size_t i = 0; i < block.size; ++i) correction_[i] = rough_[coordinates[i]] * units_[block.first + i];
    solve_in_double(block, correction_.data());
    for (std::size_t i = 0; i < block.size; ++i) rough_[coordinates[i]] = correction_[i] * units_[block.first + i];
  }
  return true;
}

/// The same for wide_, in 113 bits; NaN where G* is not well-defined. @pre precise_
void RefinedInertia::solve_precisely(std::span<const std::size_t> rows, const double* entries) const {
  wide_.resize(precise_->dimension(), 0);
  for (const std::size_t i : pattern_) wide_[i] = 0;
  pattern_.assign(rows.begin(), rows.end());
  for (std::size_t e = 0; e < rows.size(); ++e) wide_[rows[e]] = entries[e];
  if (precise_->well_defined()) {
    precise_->solve(wide_, pattern_);
  } else {
    for (const std::size_t i : pattern_) wide_[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

/// The blocks of these coordinates.
void RefinedInertia::find_touched(std::span<const std::size_t> rows) const {
  touched_.clear();
  for (const std::size_t i : rows) touched_.push_back(block_of_[i]);
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
}

/// wide_ := G* x for the x with these entries in `rows`; the rows of pattern_ may not be zero in it.
void RefinedInertia::respond(std::span<const std::size_t> rows, const double* entries) const {
  if (precise_) return solve_precisely(rows, entries);
  wide_.resize(static_cast<std::size_t>(dimension(inertia_)), 0);
  rough_.resize(wide_.size(), 0);
  for (const std::size_t i : pattern_) rough_[i] = 0, wide_[i] = 0;
  pattern_.clear();
  if (!has_inertia_) {
    const Matrix& Ginv = std::get<InverseInertia>(inertia_).Ginv;
    pattern_.resize(wide_.size());
    std::iota(pattern_.begin(), pattern_.end(), std::size_t{0});
    for (std::size_t e = 0; e < rows.size(); ++e) {
      for (std::size_t i = 0; i < wide_.size(); ++i) {
        wide_[i] += Quad{Ginv(static_cast<Index>(i), static_cast<Index>(rows[e]))} * entries[e];
      }
    }
    return;
  }
  for (std::size_t e = 0; e < rows.size(); ++e) wide_[rows[e]] = entries[e];
  find_touched(rows);
  for (const std::size_t b : touched_) {
    const Block& block = blocks_[b];
    const std::span<const std::size_t> coordinates(coordinates_.data() + block.first, block.size);
    pattern_.insert(pattern_.end(), coordinates.begin(), coordinates.end());
    if (refine(block, wide_)) continue;
    make_precise();
    return solve_precisely(rows, entries);
  }
}

Quad RefinedInertia::energy(std::span<const std::size_t> rows, const double* entries) const {
  Quad energy = 0;
  if (!has_inertia_) {
    const Matrix& Ginv = std::get<InverseInertia>(inertia_).Ginv;
    for (std::size_t j = 0; j < rows.size(); ++j) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        energy += Quad{Ginv(static_cast<Index>(rows[i]), static_cast<Index>(rows[j]))} * entries[i] * entries[j];
      }
    }
  } else if (solve_roughly(rows, entries)) {
    double sum = 0;
    for (std::size_t e = 0; e < rows.size(); ++e) sum += entries[e] * rough_[rows[e]];
    energy = sum;
    if (std::isfinite(sum)) return energy;
    energy = 0;  // beyond the range of double
    QuadVector x(rough_.size(), 0);
    for (std::size_t e = 0; e < rows.size(); ++e) x[rows[e]] = entries[e];
    solve(x);
    for (std::size_t e = 0; e < rows.size(); ++e) energy += entries[e] * x[rows[e]];
  } else {
    solve_precisely(rows, entries);
    for (std::size_t e = 0; e < rows.size(); ++e) energy += entries[e] * wide_[rows[e]];
  }
  return energy;
}

template <class Number>
std::vector<Number> RefinedInertia::apply(const std::vector<Number>& x, bool magnitudes) const {
  if constexpr (std::is_same_v<Number, Quad>) {
    if (precise_) return magnitudes ? precise_->scale(x) : precise_->apply(x);
  }
  std::vector<Number> y(x.size(), 0);
  const auto add = [&](std::size_t i, double entry, Number factor) {
    y[i] += (magnitudes ? std::abs(entry) : entry) * factor;
  };
  if (!has_inertia_) {
    const Matrix& Ginv = std::get<InverseInertia>(inertia_).Ginv;
    for (std::size_t j = 0; j < x.size(); ++j) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        if (x[j] != 0) add(i, Ginv(static_cast<Index>(i), static_cast<Index>(j)), x[j]);
      }
    }
  }
  for (const Block& block : blocks_) {
    for (std::size_t column = block.first; column < block.first + block.size; ++column) {
      for (std::size_t e = given_.begin[column]; e < given_.begin[column + 1]; ++e) {
        add(coordinates_[block.first + given_.rows[e]], given_.values[e], x[coordinates_[column]]);
      }
    }
  }
  return y;
}

template std::vector<double> RefinedInertia::apply(const std::vector<double>&, bool) const;
template QuadVector RefinedInertia::apply(const QuadVector&, bool) const;

bool RefinedInertia::proven_positive_definite() const {
  const auto proven = [this](const Block& block) {
    const auto n = static_cast<double>(block.size);
    Columns U;
    std::vector<double> pivots;
    return block.size == 1 || eliminate(block, 2 * n * (n + 4) * 0x1p-53, U, pivots);
  };
  if (has_inertia_ && !precise_ && std::all_of(blocks_.begin(), blocks_.end(), proven)) return true;
  return precise_ ? precise_->proven_positive_definite() : QuadInertia(inertia_).proven_positive_definite();
}

}  // namespace lcpbench
