#include "study/evaluation/bounded_inertia.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <initializer_list>
#include <numeric>
#include <span>
#include <utility>

#include "core/islands.h"

namespace lcpbench {
namespace {

constexpr double kUnitRoundoff = bounded::kRoundoff;
/// The least eigenvalue of a block with diagonal entries from 1 to 4: its pivots are beyond the doubt of QuadInertia.
constexpr double kLeastEigenvalue = 0x1p-36;
constexpr double kLargestContraction = 0x1p-6;
constexpr int kRefinements = 6;

double max_norm(const Matrix& A) { return A.size() == 0 ? 0 : A.cwiseAbs().rowwise().sum().maxCoeff(); }

bool is_symmetric(const Matrix& G) {
  for (Index j = 0; j < G.cols(); ++j) {
    for (Index i = 0; i < j; ++i) {
      if (G(i, j) != G(j, i)) return false;
    }
  }
  return true;
}

/// x times a power of two.
Bounded times_unit(const Bounded& x, double unit) {
  if (unit == 1 || (x.high == 0 && x.error == 0)) return x;
  return {x.high * unit, x.low * unit, x.error * unit + bounded::kLost};
}

/// The power of two that brings `diagonal` to 1 to 4 when multiplied twice.
double unit_of(double diagonal) { return std::ldexp(1.0, -static_cast<int>(std::floor(std::ilogb(diagonal) / 2.0))); }

/// NaN where an entry is.
double largest_magnitude(std::span<const double> x) {
  double largest = 0;
  for (const double value : x) {
    if (std::isnan(value)) return value;
    largest = std::max(largest, std::abs(value));
  }
  return largest;
}

/// y and the residual b - G y of one block.
struct Refinement {
  /// In memory of the caller's, which only grows.
  Refinement(std::size_t n, std::vector<double>& memory) {
    const std::initializer_list<std::span<double>*> parts = {&b_high, &b_low, &b_error,  &high,       &low,  &sum,
                                                             &rest,   &lows,  &residual, &correction, &bound};
    if (memory.size() < parts.size() * n) memory.resize(parts.size() * n);
    std::span<double> free = memory;
    for (std::span<double>* const part : parts) {
      *part = free.first(n);
      free = free.subspan(n);
    }
  }

  std::span<double> b_high, b_low, b_error;
  std::span<double> high, low;        ///< y
  std::span<double> sum, rest, lows;  ///< of the residual: leading and low part, and what bounds its error
  std::span<double> residual, correction;
  std::span<double> bound;  ///< of what the correction leaves, but for the error of the inverse

  void find_residual(const Matrix& G);
  void subtract_column(const double* column, double y_high, double y_low);
  bool may_have_lost_bits(const Matrix& G) const;
  void find_correction(const Matrix& inverse);
  void correct();
};

// The same steps as BoundedSum's, for all rows at once.
void Refinement::subtract_column(const double* column, double y_high, double y_low) {
  const auto [c_high, c_low] = bounded::split(y_high);
  const std::size_t n = sum.size();
  double* const sums = sum.data();
  double* const rests = rest.data();
  double* const magnitudes = lows.data();
  for (std::size_t i = 0; i < n; ++i) {
    const double g = column[i];
    const double scaled = 134217729.0 * g;
    const double g_high = scaled - (scaled - g);
    const double g_low = g - g_high;
    const double product = g * y_high;
    const double of_product = ((g_high * c_high - product) + g_high * c_low + g_low * c_high) + g_low * c_low;
    const double before = sums[i];
    const double total = before - product;
    const double part = total - before;
    const double of_sum = (before - (total - part)) + (-product - part);
    const double of_low = g * y_low;
    sums[i] = total;
    rests[i] += of_sum - (of_product + of_low);
    magnitudes[i] += std::abs(of_sum) + std::abs(of_product) + std::abs(of_low);
  }
}

void Refinement::find_residual(const Matrix& G) {
  const std::size_t n = sum.size();
  for (std::size_t i = 0; i < n; ++i) {
    sum[i] = b_high[i];
    rest[i] = b_low[i];
    lows[i] = std::abs(b_low[i]);
  }
  for (std::size_t j = 0; j < n; ++j) {
    if (high[j] != 0) subtract_column(G.col(static_cast<Index>(j)).data(), high[j], low[j]);
  }
  for (std::size_t i = 0; i < n; ++i) residual[i] = sum[i] + rest[i];
}

bool Refinement::may_have_lost_bits(const Matrix& G) const {
  double smallest = 1;
  for (const double value : high) smallest = value == 0 ? smallest : std::min(smallest, std::abs(value));
  return !(smallest > 0x1p-400) || (G.array() != 0 && G.array().abs() < 0x1p-400).any();
}

/// The correction, R times the residual, and |R| times what the residual may be off by.
void Refinement::find_correction(const Matrix& inverse) {
  const std::size_t n = sum.size();
  const double order = static_cast<double>(n);
  std::fill(correction.begin(), correction.end(), 0.0);
  std::fill(bound.begin(), bound.end(), 0.0);
  for (std::size_t j = 0; j < n; ++j) {
    const double* const column = inverse.col(static_cast<Index>(j)).data();
    const double r = residual[j];
    const double off = 2 * b_error[j] + (order + 8) * kUnitRoundoff * (lows[j] + 2 * std::abs(r)) + bounded::kLost;
    for (std::size_t i = 0; i < n; ++i) {
      correction[i] += column[i] * r;
      bound[i] += std::abs(column[i]) * off;
    }
  }
}

void Refinement::correct() {
  for (std::size_t i = 0; i < high.size(); ++i) {
    const bounded::Pair total = bounded::exact_sum(high[i], correction[i]);
    const bounded::Pair normal = bounded::exact_sum(total.high, low[i] + total.low);
    high[i] = normal.high;
    low[i] = normal.low;
  }
}

void multiply_by(const Matrix& A, std::span<const double> x, std::span<double> y) {
  const auto n = static_cast<Index>(x.size());
  Eigen::Map<Vector>(y.data(), n).noalias() = A * Eigen::Map<const Vector>(x.data(), n);
}

}  // namespace

BoundedInertia::BoundedInertia(const Inertia& inertia) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    reserve(dense->G.rows());
    add_inertia(dense->G, 0);
  } else if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    Index ngc = 0;
    for (const Matrix& block : bodies->blocks) ngc += block.rows();
    reserve(ngc);
    std::size_t offset = 0;
    for (const Matrix& block : bodies->blocks) {
      add_inertia(block, offset);
      offset += static_cast<std::size_t>(block.rows());
      if (!well_defined_) return;
    }
  } else if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    has_inertia_ = false;
    reserve(inverse->Ginv.rows());
    Block block;
    block.matrix = inverse->Ginv;
    block.coordinates.resize(singles_.size());
    std::iota(block.coordinates.begin(), block.coordinates.end(), std::size_t{0});
    block.units.assign(singles_.size(), 1);
    well_defined_ = block.matrix.allFinite();
    blocks_.push_back(std::move(block));
  } else {
    well_defined_ = false;
  }
}

void BoundedInertia::reserve(Index ngc) {
  singles_.assign(static_cast<std::size_t>(ngc), 0);
  block_of_row_.assign(static_cast<std::size_t>(ngc), 0);
}

void BoundedInertia::add_inertia(const Matrix& G, std::size_t offset) {
  well_defined_ = well_defined_ && G.allFinite() && (G.diagonal().array() > 0).all() && is_symmetric(G);
  if (!well_defined_) return;
  if (G.isDiagonal(0)) {
    for (Index i = 0; i < G.rows(); ++i) add_single(G(i, i), offset + static_cast<std::size_t>(i));
    return;
  }
  find_row_islands(G, parts_, queue_);
  for (Index part = 0; part < parts_.count; ++part) {
    Block block;
    for (std::size_t i = 0; i < parts_.of_row.size(); ++i) {
      if (parts_.of_row[i] != part) continue;
      if (block.coordinates.empty()) block.coordinates.reserve(parts_.of_row.size() - i);
      block.coordinates.push_back(i);
    }
    if (block.coordinates.size() == 1) {
      const auto row = static_cast<Index>(block.coordinates[0]);
      add_single(G(row, row), offset + block.coordinates[0]);
      continue;
    }
    well_defined_ = well_defined_ && scale_and_prove(block, G);
    if (!well_defined_) return;
    for (std::size_t& row : block.coordinates) {
      row += offset;
      block_of_row_[row] = blocks_.size();
    }
    blocks_.push_back(std::move(block));
  }
}

void BoundedInertia::add_single(double inertia, std::size_t row) {
  well_defined_ = well_defined_ && inertia > 0x1p-600 && inertia < 0x1p600;
  singles_[row] = inertia;
}

/// Scales the block's rows and columns of G. False unless it is then proven to have no eigenvalue below
/// kLeastEigenvalue: L L' is the matrix that is factored up to (n + 1) n roundings of 4, and half of what was
/// subtracted exceeds that.
bool BoundedInertia::scale_and_prove(Block& block, const Matrix& G) {
  const auto n = static_cast<Index>(block.coordinates.size());
  const auto entry = [&](Index i, Index j) {
    return G(static_cast<Index>(block.coordinates[static_cast<std::size_t>(i)]),
             static_cast<Index>(block.coordinates[static_cast<std::size_t>(j)]));
  };
  block.units.resize(block.coordinates.size());
  for (Index i = 0; i < n; ++i) {
    if (!(entry(i, i) > 0x1p-600 && entry(i, i) < 0x1p600)) return false;
    block.units[static_cast<std::size_t>(i)] = unit_of(entry(i, i));
  }
  block.matrix.resize(n, n);
  for (Index j = 0; j < n; ++j) {
    const double unit_j = block.units[static_cast<std::size_t>(j)];
    for (Index i = 0; i < n; ++i) {
      const double unit_i = block.units[static_cast<std::size_t>(i)];
      const double scaled = unit_i * entry(i, j) * unit_j;
      // As of any definite block; and so no overflow makes a NaN of a pivot, which LLT takes for a positive one.
      if (!(std::abs(scaled) <= 4) || 1 / unit_i * scaled * (1 / unit_j) != entry(i, j)) return false;
      block.matrix(i, j) = scaled;
    }
  }
  const auto order = static_cast<double>(n);
  Matrix work = block.matrix;
  work.diagonal().array() -= std::max(2 * kLeastEigenvalue, 16 * order * (order + 4) * kUnitRoundoff);
  return Eigen::LLT<Eigen::Ref<Matrix>>(work).info() == Eigen::Success;
}

/// Finds R and the numbers that bound what it leaves: NaN where it is no inverse.
void BoundedInertia::invert(Block& block) {
  const Index n = block.size();
  block.approximate = Eigen::LLT<Matrix>(block.matrix).solve(Matrix::Identity(n, n));
  if (!block.approximate.allFinite()) {  // maxCoeff() may pass over NaN
    block.approximate.setZero();
    block.contraction = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const Matrix rest = Matrix::Identity(n, n) - block.approximate * block.matrix;
  const double product_norm = max_norm(block.approximate) * max_norm(block.matrix);
  const double rounding = (static_cast<double>(n) + 4) * kUnitRoundoff * (product_norm + 1);
  block.contraction = (max_norm(rest) + rounding) * (1 + 0x1p-20);
  if (!(block.contraction < kLargestContraction)) block.contraction = std::numeric_limits<double>::quiet_NaN();
}

/// With E = I - R G, what a correction leaves of x - y is R r less its computed value, and E (x - y). The bound of the
/// first is found for each coordinate: small ones beside large ones are known as well as the data allow.
void BoundedInertia::solve(Block& block, BoundedVector& x) const {
  const std::size_t n = block.coordinates.size();
  Refinement y(n, refinement_);
  bool zero = true, finite = true, exact = true;
  for (std::size_t i = 0; i < n; ++i) {
    const Bounded b = times_unit(x[block.coordinates[i]], block.units[i]);
    zero = zero && b.high == 0 && b.error == 0;
    finite = finite && is_finite(b);
    exact = exact && b.error == 0;
    y.b_high[i] = y.residual[i] = b.high;
    y.b_low[i] = b.low;
    y.b_error[i] = b.error;
    y.low[i] = 0;
  }
  if (zero) return;
  if (!finite) {
    for (const std::size_t i : block.coordinates) x[i] = bounded::unknown();
    return;
  }
  if (block.approximate.size() == 0) invert(block);
  multiply_by(block.approximate, y.residual, y.high);
  double spread = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kRefinements; ++step) {
    y.find_residual(block.matrix);
    if (exact && largest_magnitude(y.residual) == 0 && largest_magnitude(y.lows) == 0 &&
        !y.may_have_lost_bits(block.matrix)) {
      for (std::size_t i = 0; i < n; ++i)
        x[block.coordinates[i]] = times_unit({y.high[i], y.low[i], 0}, block.units[i]);
      return;
    }
    y.find_correction(block.approximate);
    y.correct();
    const double left = largest_magnitude(y.correction) + largest_magnitude(y.bound);
    const double next = block.contraction / (1 - block.contraction) * left;
    const bool done = !(next < spread / 2) || next <= 4 * *std::min_element(y.bound.begin(), y.bound.end());
    spread = next;
    if (done) break;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double error = (y.bound[i] + spread) * (1 + 0x1p-20) + 0x1p-104 * std::abs(y.high[i]);
    x[block.coordinates[i]] = times_unit({y.high[i], y.low[i], error}, block.units[i]);
  }
}

/// The block's coordinates of y: those of x times G, or |G|, in the units of the block.
void BoundedInertia::multiply(const Block& block, bool magnitudes, const BoundedVector& x, BoundedVector& y) {
  const std::size_t n = block.coordinates.size();
  std::vector<BoundedSum> sums(n);
  for (std::size_t j = 0; j < n; ++j) {
    const Bounded scaled = times_unit(x[block.coordinates[j]], 1 / block.units[j]);
    if (scaled.high == 0 && scaled.error == 0) continue;
    const double* const column = block.matrix.col(static_cast<Index>(j)).data();
    for (std::size_t i = 0; i < n; ++i) sums[i].add(magnitudes ? std::abs(column[i]) : column[i], scaled);
  }
  for (std::size_t i = 0; i < n; ++i) y[block.coordinates[i]] = times_unit(sums[i].value(), 1 / block.units[i]);
}

/// A coordinate by itself.
void BoundedInertia::divide(std::size_t row, BoundedVector& x) const {
  if (x[row].high != 0 || x[row].error != 0) x[row] = x[row] / Bounded(singles_[row]);
}

void BoundedInertia::solve(BoundedVector& x) const {
  if (!has_inertia_) {
    x = apply(x);
    return;
  }
  for (std::size_t row = 0; row < singles_.size(); ++row) {
    if (singles_[row] != 0) divide(row, x);
  }
  for (Block& block : blocks_) solve(block, x);
}

void BoundedInertia::couple(std::vector<std::size_t>& pattern) const {
  touched_.clear();
  const auto is_single = [this](std::size_t row) {
    if (singles_[row] == 0) touched_.push_back(block_of_row_[row]);
    return singles_[row] != 0;
  };
  std::size_t singles = 0;
  for (const std::size_t row : pattern) {
    if (is_single(row)) pattern[singles++] = row;
  }
  pattern.resize(singles);
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
  for (const std::size_t b : touched_) {
    pattern.insert(pattern.end(), blocks_[b].coordinates.begin(), blocks_[b].coordinates.end());
  }
}

void BoundedInertia::solve(BoundedVector& x, std::vector<std::size_t>& pattern) const {
  for (const std::size_t row : pattern) {
    if (singles_[row] != 0) divide(row, x);
  }
  couple(pattern);
  if (has_inertia_) {
    for (const std::size_t b : touched_) solve(blocks_[b], x);
  } else if (!touched_.empty()) {
    x = apply(x);
  }
}

double BoundedInertia::estimate(std::vector<double>& x, std::vector<std::size_t>& pattern) const {
  double error = bounded::kLost;
  for (const std::size_t row : pattern) {
    if (singles_[row] == 0) continue;
    x[row] /= singles_[row];
    error = std::max(error, kUnitRoundoff * std::abs(x[row]));
  }
  couple(pattern);
  for (const std::size_t b : touched_) error = std::max(error, estimate(blocks_[b], x));
  return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
}

/// With y the computed R b, the error is that of y and E (I - E)^-1 R b for E = I - R G, as in solve().
double BoundedInertia::estimate(Block& block, std::vector<double>& x) const {
  const std::size_t n = block.coordinates.size();
  if (has_inertia_ && block.approximate.size() == 0) invert(block);
  const Matrix& inverse = has_inertia_ ? block.approximate : block.matrix;
  if (refinement_.size() < 2 * n) refinement_.resize(2 * n);
  const std::span<double> y = std::span(refinement_).first(n), magnitudes = std::span(refinement_).subspan(n, n);
  std::fill(y.begin(), y.end(), 0.0);
  std::fill(magnitudes.begin(), magnitudes.end(), 0.0);
  for (std::size_t j = 0; j < n; ++j) {
    const double b = x[block.coordinates[j]] * block.units[j];
    if (b == 0) continue;
    const double* const column = inverse.col(static_cast<Index>(j)).data();
    for (std::size_t i = 0; i < n; ++i) {
      y[i] += column[i] * b;
      magnitudes[i] += std::abs(column[i] * b);
    }
  }
  const double rounding = (static_cast<double>(n) + 4) * kUnitRoundoff * largest_magnitude(magnitudes) + bounded::kLost;
  const double contraction = has_inertia_ ? block.contraction : 0;
  const double of_scaled = rounding + contraction / (1 - contraction) * (largest_magnitude(y) + rounding);
  double unit = 0;
  for (std::size_t i = 0; i < n; ++i) {
    x[block.coordinates[i]] = y[i] * block.units[i];
    unit = std::max(unit, block.units[i]);
  }
  const double error = of_scaled * unit * (1 + 0x1p-20) + bounded::kLost;
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
}

BoundedVector BoundedInertia::product(const BoundedVector& x, bool magnitudes) const {
  BoundedVector y(x.size());
  for (std::size_t row = 0; row < singles_.size(); ++row) {
    if (singles_[row] != 0) y[row] = x[row] * Bounded(singles_[row]);
  }
  for (const Block& block : blocks_) multiply(block, magnitudes, x, y);
  return y;
}

BoundedVector BoundedInertia::apply(const BoundedVector& x) const { return product(x, false); }

BoundedVector BoundedInertia::scale(const BoundedVector& x) const { return product(x, true); }

}  // namespace lcpbench
