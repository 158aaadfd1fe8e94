#include "study/evaluation/bounded_inertia.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <span>

#include "core/islands.h"
#include "study/evaluation/at_isa_level.h"
#include "study/evaluation/bounded_refinement.h"

namespace lcpbench {
namespace {

/// A block, scaled to diagonal entries from 1 to 4, is taken only if all of its eigenvalues are proven to be larger.
/// They are then far from what QuadInertia takes for zero.
constexpr double kLeastEigenvalue = 0x1p-36;
constexpr int kRefinements = 6;

/// Without a branch for each entry, which would cost more than to look at all. NaN may pass; add_single() and
/// BoundedFactors refuse it.
bool is_symmetric(const Matrix& G) {
  const Index n = G.rows();
  std::uint64_t apart = 0;
  for (Index j = 0; j < n; ++j) {
    const double* const column = G.data() + j * n;
    const double* const row = G.data() + j;
    for (Index i = 0; i < j; ++i) {
      apart |= std::bit_cast<std::uint64_t>(column[i]) ^ std::bit_cast<std::uint64_t>(row[i * n]);
    }
  }
  return apart == 0 || G == G.transpose();  // 0 is -0
}

/// x times a power of two. The error grows by kLost, because the product may underflow.
Bounded times_unit(const Bounded& x, double unit) {
  if (unit == 1 || (x.high == 0 && x.error == 0)) return x;
  return {x.high * unit, x.low * unit, x.error * unit + bounded::kLost};
}

/// The power of two u with 1 <= u * diagonal * u < 4.
/// @pre diagonal is a positive normal number
double unit_of(double diagonal) {
  constexpr int kBias = 1023, kFractionBits = 52;
  const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(diagonal) >> kFractionBits) - kBias;
  return std::bit_cast<double>(static_cast<std::uint64_t>(kBias - (exponent >> 1)) << kFractionBits);
}

/// Without a sign: larger for a larger magnitude, and larger still for what is not finite.
[[gnu::always_inline]] inline std::int64_t bits_of_magnitude(double x) {
  return std::bit_cast<std::int64_t>(x) & ~(std::int64_t{1} << 63);
}

/// A number < 0 where |scaled| > 4, which no entry of a definite block is, and where |scaled| < 2^-400 though `entry`
/// is not zero: scaling may have lost bits. Signs of integers, because SSE2 cannot compare those of 64 bits.
[[gnu::always_inline]] inline std::int64_t loss(double scaled, double entry) {
  const std::int64_t most = std::bit_cast<std::int64_t>(4.0), least = std::bit_cast<std::int64_t>(0x1p-400);
  const std::int64_t magnitude = bits_of_magnitude(scaled);
  const std::int64_t zero_or_negative = -bits_of_magnitude(entry);
  return (most - magnitude) | ((magnitude - least) & zero_or_negative);
}

/// A whole matrix, n x n by columns, and the units of its coordinates.
struct Unscaled {
  const double* entries;
  const double* units;
  std::size_t n;
};

/// Multiplies each entry by the units of its row and its column. Whether those up to the diagonal lose nothing: the
/// others are the same.
[[gnu::always_inline]] inline bool scale_all(const Unscaled& G, double* __restrict scaled) {
  const double* __restrict const units = G.units;
  std::int64_t lost = 0;
  for (std::size_t j = 0; j < G.n; ++j, scaled += G.n) {
    const double* __restrict const column = G.entries + j * G.n;
    const double unit = units[j];
    for (std::size_t i = 0; i < G.n; ++i) scaled[i] = units[i] * column[i] * unit;
    for (std::size_t i = 0; i <= j; ++i) lost |= loss(scaled[i], column[i]);
  }
  return lost >= 0;
}

bool scale_plain(const Unscaled& G, double* scaled) { return scale_all(G, scaled); }

LCPBENCH_AVX2 bool scale_avx2(const Unscaled& G, double* scaled) { return scale_all(G, scaled); }

}  // namespace

BoundedInertia::BoundedInertia(const Inertia& inertia, std::pmr::memory_resource* memory)
    : singles_(memory),
      inverse_diagonal_(memory),
      units_(memory),
      blocks_(memory),
      coordinates_(memory),
      entries_(memory),
      factors_(memory),
      block_of_row_(memory) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    reserve(dense->G.rows());
    add_inertia(dense->G, 0);
  } else if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    Index ngc = 0;
    for (const Matrix& block : bodies->blocks) ngc += block.rows();
    reserve(ngc);
    std::size_t entries = 0;
    for (const Matrix& block : bodies->blocks) entries += static_cast<std::size_t>(block.size());
    entries_.reserve(entries);
    coordinates_.reserve(singles_.size());
    blocks_.reserve(bodies->blocks.size());
    factors_.reserve(bodies->blocks.size(), singles_.size(), entries / 2);
    std::size_t offset = 0;
    for (const Matrix& block : bodies->blocks) {
      add_inertia(block, offset);
      offset += static_cast<std::size_t>(block.rows());
      if (!well_defined_) return;
    }
  } else if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    add_inverse(inverse->Ginv);
  } else {
    well_defined_ = false;
  }
}

void BoundedInertia::reserve(Index ngc) {
  const auto n = static_cast<std::size_t>(ngc);
  singles_.assign(n, 0);
  inverse_diagonal_.assign(n, 0);
  units_.assign(n, 1);
  block_of_row_.assign(n, 0);
}

void BoundedInertia::add_inverse(const Matrix& Ginv) {
  has_inertia_ = false;
  well_defined_ = Ginv.allFinite();
  reserve(Ginv.rows());
  coordinates_.resize(singles_.size());
  std::iota(coordinates_.begin(), coordinates_.end(), std::size_t{0});
  entries_.assign(Ginv.data(), Ginv.data() + Ginv.size());
  blocks_.push_back({.size = singles_.size()});
}

void BoundedInertia::add_inertia(const Matrix& G, std::size_t offset) {
  well_defined_ = well_defined_ && is_symmetric(G);
  if (!well_defined_) return;
  if (G.isDiagonal(0)) {
    for (Index i = 0; i < G.rows(); ++i) add_single(G(i, i), offset + static_cast<std::size_t>(i));
    return;
  }
  find_row_islands(G, parts_, queue_);
  for (Index part = 0; part < parts_.count && well_defined_; ++part) {
    const std::size_t first = coordinates_.size();
    for (std::size_t i = 0; i < parts_.of_row.size(); ++i) {
      if (parts_.of_row[i] == part) coordinates_.push_back(offset + i);
    }
    if (coordinates_.size() > first + 1) {
      well_defined_ = add_block(G, offset, first);
      continue;
    }
    const std::size_t row = coordinates_.back();
    coordinates_.pop_back();
    add_single(G(static_cast<Index>(row - offset), static_cast<Index>(row - offset)), row);
  }
}

/// Clears well_defined_ unless the inertia is between 2^-600 and 2^600; NaN is not.
void BoundedInertia::add_single(double inertia, std::size_t row) {
  well_defined_ = well_defined_ && inertia > 0x1p-600 && inertia < 0x1p600;
  singles_[row] = inertia;
  inverse_diagonal_[row] = 1 / inertia;
}

/// Scales the rows and columns of G that the coordinates from `first` on name, and factors the block that they are.
/// False unless it is then proven to have no eigenvalue below kLeastEigenvalue.
bool BoundedInertia::add_block(const Matrix& G, std::size_t offset, std::size_t first) {
  const Block block{.first = first, .size = coordinates_.size() - first, .entries = entries_.size()};
  const std::size_t* const rows = coordinates_.data() + first;
  for (std::size_t i = 0; i < block.size; ++i) {
    const auto row = static_cast<Index>(rows[i] - offset);
    if (!(G(row, row) > 0x1p-600 && G(row, row) < 0x1p600)) return false;
    units_[rows[i]] = unit_of(G(row, row));
    inverse_diagonal_[rows[i]] = 1 / G(row, row);
    block_of_row_[rows[i]] = blocks_.size();
  }
  entries_.resize(block.entries + block.size * block.size);
  double* const entries = entries_.data() + block.entries;
  bool representable = true;
  if (block.size == static_cast<std::size_t>(G.rows())) {
    static const auto scale_whole = at_isa_level(scale_plain, scale_avx2);
    representable = scale_whole({G.data(), units_.data() + offset, block.size}, entries);
  } else {
    for (std::size_t j = 0; j < block.size; ++j) {
      const double* const column_of_G = G.col(static_cast<Index>(rows[j] - offset)).data();
      for (std::size_t i = 0; i < block.size; ++i) {
        double& scaled = entries[j * block.size + i];
        scaled = units_[rows[i]] * column_of_G[rows[i] - offset] * units_[rows[j]];
        representable = representable && loss(scaled, column_of_G[rows[i] - offset]) >= 0;
      }
    }
  }
  blocks_.push_back(block);
  return representable && factors_.add(std::span(entries, block.size * block.size), block.size, kLeastEigenvalue);
}

/// Let A be the scaled block, c the correction that is computed for the computed residual r, d what r may be off by
/// (y.bound), and f = factors_.residual(b): A c = r but for f |c|_1 in each row. The corrected y is then off by at most
/// |A^-1| (d + f |c|_1). |A^-1| d is bounded for each coordinate, so that small ones beside large ones are known as
/// well as the data allow.
void BoundedInertia::solve(std::size_t b, BoundedVector& x) const {
  const Block& block = blocks_[b];
  const std::size_t n = block.size;
  const std::size_t* const rows = coordinates_.data() + block.first;
  BoundedRefinement y(n, refinement_);
  bool zero = true, finite = true, exact = true;
  for (std::size_t i = 0; i < n; ++i) {
    const Bounded of_row = times_unit(x[rows[i]], units_[rows[i]]);
    zero = zero && of_row.high == 0 && of_row.error == 0;
    finite = finite && is_finite(of_row);
    exact = exact && of_row.error == 0;
    y.b_high[i] = y.high[i] = of_row.high;
    y.b_low[i] = of_row.low;
    y.b_error[i] = of_row.error;
    y.low[i] = 0;
  }
  if (zero) return;
  if (!finite) {
    for (const std::size_t row : coordinates(block)) x[row] = bounded::unknown();
    return;
  }
  factors_.solve(b, y.high);
  const std::span<const double> matrix(column(block, 0), n * n);
  const std::span<const double> ones = factors_.bound_of_ones(b);
  double size = std::numeric_limits<double>::infinity(), of_correction = size;
  for (int step = 0; step < kRefinements; ++step) {
    y.find_residual(matrix.data());
    if (exact && y.is_zero() && !y.may_have_lost_bits(matrix)) {
      for (std::size_t i = 0; i < n; ++i) x[rows[i]] = times_unit({y.high[i], y.low[i], 0}, units_[rows[i]]);
      return;
    }
    factors_.solve(b, y.correction);
    y.correct();
    double next = 0;
    for (const double value : y.correction) next += std::abs(value);
    of_correction = factors_.residual(b) * next * (1 + 0x1p-20);
    const bool done = !(next < size / 2) || of_correction <= *std::min_element(y.bound.begin(), y.bound.end());
    size = next;
    if (done) break;
  }
  factors_.bound(b, y.bound);
  for (std::size_t i = 0; i < n; ++i) {
    // A Bounded may be off by twice its error; 2^-20 of it is left for the rounding of errors to come. The last term is
    // the rounding of correct().
    const double error = (y.bound[i] + of_correction * ones[i]) * (0.5 + 0x1p-20) + 0x1p-104 * std::abs(y.high[i]);
    x[rows[i]] = times_unit({y.high[i], y.low[i], error}, units_[rows[i]]);
  }
}

double BoundedInertia::least_energy(std::span<const std::size_t> rows, const double* entries) const {
  double of_singles = 0, of_a_block = 0;
  for (std::size_t e = 0; e < rows.size(); ++e) {
    const double energy = entries[e] * (entries[e] * inverse_diagonal_[rows[e]]);
    if (!(energy > bounded::kSmallProduct)) continue;  // an underflow may have rounded it up
    if (singles_[rows[e]] != 0) {
      of_singles += energy;
    } else {
      of_a_block = std::max(of_a_block, energy);
    }
  }
  return (of_singles + of_a_block) * (1 - 0x1p-20);
}

/// y := G x in the block's coordinates; G* x where only that was given.
void BoundedInertia::multiply(const Block& block, const BoundedVector& x, BoundedVector& y) const {
  const std::size_t n = block.size;
  const std::size_t* const rows = coordinates_.data() + block.first;
  sums_.assign(n, BoundedSum());
  for (std::size_t j = 0; j < n; ++j) {
    const Bounded scaled = times_unit(x[rows[j]], 1 / units_[rows[j]]);
    if (scaled.high == 0 && scaled.error == 0) continue;
    const double* const entries = column(block, j);
    for (std::size_t i = 0; i < n; ++i) sums_[i].add(entries[i], scaled);
  }
  for (std::size_t i = 0; i < n; ++i) y[rows[i]] = times_unit(sums_[i].value(), 1 / units_[rows[i]]);
}

/// The same, or |G| times x, in double. A sum of n products is off by at most (n + 2) 2^-53 of the sum of their
/// magnitudes, and by what the leading parts of x leave out.
void BoundedInertia::multiply_in_double(const Block& block, bool magnitudes, const BoundedVector& x,
                                        BoundedVector& y) const {
  const std::size_t n = block.size;
  const std::size_t* const rows = coordinates_.data() + block.first;
  if (refinement_.size() < 3 * n) refinement_.resize(3 * n);
  std::fill_n(refinement_.begin(), 3 * n, 0.0);
  double* __restrict const sums = refinement_.data();
  double* __restrict const sizes = sums + n;
  double* __restrict const errors = sizes + n;
  for (std::size_t j = 0; j < n; ++j) {
    const Bounded scaled = times_unit(x[rows[j]], 1 / units_[rows[j]]);
    const double left_out = std::abs(scaled.low) + 2 * scaled.error;
    const double* const entries = column(block, j);
    for (std::size_t i = 0; i < n; ++i) {
      const double entry = magnitudes ? std::abs(entries[i]) : entries[i];
      sums[i] += entry * scaled.high;
      sizes[i] += std::abs(entry * scaled.high);
      errors[i] += std::abs(entry) * left_out;
    }
  }
  const double rounding = (static_cast<double>(n) + 2) * bounded::kRoundoff;
  for (std::size_t i = 0; i < n; ++i) {
    const double error = (rounding * sizes[i] + errors[i]) * (1 + 0x1p-20) + bounded::kLost;
    y[rows[i]] = times_unit({sums[i], 0, error}, 1 / units_[rows[i]]);
  }
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
  for (std::size_t b = 0; b < blocks_.size(); ++b) solve(b, x);
}

void BoundedInertia::couple(std::vector<std::size_t>& pattern) const {
  touched_.clear();
  const auto is_single = [this](std::size_t row) {
    if (singles_[row] != 0) return true;
    const std::size_t block = block_of_row_[row];
    if (touched_.empty() || touched_.back() != block) touched_.push_back(block);
    return false;
  };
  std::size_t singles = 0;
  for (const std::size_t row : pattern) {
    if (is_single(row)) pattern[singles++] = row;
  }
  pattern.resize(singles);
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
  for (const std::size_t b : touched_) {
    const std::span<const std::size_t> rows = coordinates(blocks_[b]);
    pattern.insert(pattern.end(), rows.begin(), rows.end());
  }
}

void BoundedInertia::solve(BoundedVector& x, std::vector<std::size_t>& pattern) const {
  for (const std::size_t row : pattern) {
    if (singles_[row] != 0) divide(row, x);
  }
  couple(pattern);
  if (has_inertia_) {
    for (const std::size_t b : touched_) solve(b, x);
  } else if (!touched_.empty()) {
    x = apply(x);
  }
}

/// G x in the coordinates that are coupled to no other, 0 in the others.
BoundedVector BoundedInertia::product_with_singles(const BoundedVector& x) const {
  BoundedVector y(x.size());
  for (std::size_t row = 0; row < singles_.size(); ++row) {
    if (singles_[row] != 0) y[row] = x[row] * Bounded(singles_[row]);
  }
  return y;
}

BoundedVector BoundedInertia::apply(const BoundedVector& x) const {
  BoundedVector y = product_with_singles(x);
  for (const Block& block : blocks_) multiply(block, x, y);
  return y;
}

BoundedVector BoundedInertia::apply_in_double(const BoundedVector& x) const {
  BoundedVector y = product_with_singles(x);
  for (const Block& block : blocks_) multiply_in_double(block, false, x, y);
  return y;
}

BoundedVector BoundedInertia::scale(const BoundedVector& x) const {
  BoundedVector y = product_with_singles(x);
  for (const Block& block : blocks_) multiply_in_double(block, true, x, y);
  return y;
}

}  // namespace lcpbench
