#include "core/mixed_lcp.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <limits>
#include <numeric>

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Reciprocal condition, of equilibrated blocks, below which a block counts as singular: elimination would leave four
/// digits.
constexpr double kLeastRegular = 1e-12;

/// Powers of two by which the largest entry of each row comes near 1; 1 for a row of zeros.
Vector row_scales(const Matrix& A) {
  return A.cwiseAbs().rowwise().maxCoeff().unaryExpr([](double largest) {
    return largest > 0 && std::isfinite(largest) ? std::exp2(-std::round(std::log2(largest))) : 1.0;
  });
}

/// R A C = `scaled`, with rows and columns of about the same size.
struct Equilibrated {
  explicit Equilibrated(const Matrix& A) : rows(row_scales(A)) {
    scaled = rows.asDiagonal() * A;
    columns = row_scales(scaled.transpose());
    scaled *= columns.asDiagonal();
  }

  Vector rows, columns;
  Matrix scaled;
};

std::vector<Index> all_but(Index count, const std::vector<Index>& left_out) {
  std::vector<char> is_out(static_cast<std::size_t>(count), 0);
  for (const Index i : left_out) is_out[static_cast<std::size_t>(i)] = 1;
  std::vector<Index> rest;
  for (Index i = 0; i < count; ++i) {
    if (is_out[static_cast<std::size_t>(i)] == 0) rest.push_back(i);
  }
  return rest;
}

}  // namespace

LcpBounds LcpBounds::nonnegative(Index n) {
  return {Vector::Zero(n), Vector::Constant(n, kInfinity), std::vector<int>(static_cast<std::size_t>(n), -1),
          Vector::Zero(n)};
}

bool LcpBounds::is_free(Index i) const {
  return lower(i) == -kInfinity && upper(i) == kInfinity && friction_of[static_cast<std::size_t>(i)] < 0;
}

LcpBounds LcpBounds::of_rows(const std::vector<Index>& rows) const {
  if (lower.size() == 0) return {};
  LcpBounds part{lower(rows), upper(rows), std::vector<int>(rows.size(), -1), mu(rows)};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const int of = friction_of[static_cast<std::size_t>(rows[k])];
    if (of < 0) continue;
    const auto place = std::find(rows.begin(), rows.end(), of);
    const auto row = static_cast<Index>(k);
    if (place != rows.end()) {
      part.friction_of[k] = static_cast<int>(place - rows.begin());
    } else {
      part.lower(row) = part.upper(row) = part.mu(row) = 0;
    }
  }
  return part;
}

void LcpBounds::simplify() {
  const bool plain = lower.isZero(0) && (upper.array() == kInfinity).all() &&
                     std::all_of(friction_of.begin(), friction_of.end(), [](int of) { return of < 0; });
  if (plain) *this = {};
}

Index LcpBounds::drop_huge() {
  Index dropped = 0;
  const auto drop = [&](double& bound, double none) {
    if (!std::isfinite(bound) || std::abs(bound) < kNoBound || std::signbit(bound) != std::signbit(none)) return;
    bound = none;
    ++dropped;
  };
  for (double& bound : lower) drop(bound, -kInfinity);
  for (double& bound : upper) drop(bound, kInfinity);
  return dropped;
}

bool LcpBounds::needs_slacks() const {
  for (Index i = 0; i < lower.size(); ++i) {
    const bool two = lower(i) > -kInfinity && upper(i) < kInfinity && lower(i) < upper(i);
    if (two || friction_of[static_cast<std::size_t>(i)] >= 0) return true;
  }
  return false;
}

LcpReduction::LcpReduction(const Lcp& mixed) {
  expand(mixed);
  std::vector<Index> free;
  for (std::size_t k = 0; k < unknowns_.size(); ++k) {
    if (unknowns_[k].row >= 0 && mixed.bounds.is_free(unknowns_[k].row)) free.push_back(static_cast<Index>(k));
  }
  kept_.resize(unknowns_.size());
  std::iota(kept_.begin(), kept_.end(), Index{0});
  if (free.empty() || eliminate(free, {})) return;
  const std::vector<Index> exchanged = exchanged_with(free);
  if (exchanged.empty() || !eliminate(free, exchanged)) split(free);
}

void LcpReduction::expand(const Lcp& mixed) {
  const LcpBounds& bounds = mixed.bounds;
  const Index n = mixed.size();
  struct Range {
    Index unknown;
    double length;
  };
  struct Friction {
    Index positive;  ///< the unknown of the other sign follows it
    Index of;
    double mu;
  };
  std::vector<Range> ranges;
  std::vector<Friction> frictions;
  std::vector<Index> of_row(static_cast<std::size_t>(n), -1);
  origin_ = Vector::Zero(n);
  for (Index i = 0; i < n; ++i) {
    const auto next = static_cast<Index>(unknowns_.size());
    const double lower = bounds.lower(i);
    const double upper = bounds.upper(i);
    const int of = bounds.friction_of[static_cast<std::size_t>(i)];
    of_row[static_cast<std::size_t>(i)] = next;
    if (of >= 0) {
      frictions.push_back({next, of, bounds.mu(i)});
      unknowns_.push_back({i, 1.0});
      unknowns_.push_back({i, -1.0});
    } else if (lower == upper) {
      origin_(i) = lower;
      of_row[static_cast<std::size_t>(i)] = -1;
    } else if (lower > -kInfinity) {
      origin_(i) = lower;
      unknowns_.push_back({i, 1.0});
      if (upper < kInfinity) ranges.push_back({next, upper - lower});
    } else {
      if (upper < kInfinity) origin_(i) = upper;
      unknowns_.push_back({i, upper < kInfinity ? -1.0 : 1.0});
    }
  }
  exact_ = origin_.isZero(0);
  const auto primary = static_cast<Index>(unknowns_.size());
  unknowns_.resize(unknowns_.size() + ranges.size() + frictions.size(), {-1, 0.0});
  const auto count = static_cast<Index>(unknowns_.size());
  lcp_.M = Matrix::Zero(count, count);
  lcp_.q = Vector::Zero(count);
  const Vector at_origin = exact_ ? mixed.q : Vector(mixed.q + mixed.M * origin_);
  for (Index b = 0; b < primary; ++b) {
    const Unknown& column = unknowns_[static_cast<std::size_t>(b)];
    lcp_.q(b) = column.sign * at_origin(column.row);
    for (Index a = 0; a < primary; ++a) {
      const Unknown& row = unknowns_[static_cast<std::size_t>(a)];
      lcp_.M(a, b) = row.sign * column.sign * mixed.M(row.row, column.row);
    }
  }
  Index k = primary;
  for (const Range& range : ranges) {
    lcp_.M(range.unknown, k) = 1;
    lcp_.M(k, range.unknown) = -1;
    lcp_.q(k++) = range.length;
  }
  for (const Friction& friction : frictions) {
    for (const Index side : {friction.positive, friction.positive + 1}) {
      lcp_.M(side, k) = 1;
      lcp_.M(k, side) = -1;
    }
    const Index limiting = of_row[static_cast<std::size_t>(friction.of)];
    if (limiting >= 0) lcp_.M(k, limiting) = friction.mu;
    lcp_.q(k++) = friction.mu * origin_(friction.of);
  }
}

/// Rows with a bound that make the block of the free unknowns, of which some combinations are singular, regular: as
/// many as there are such combinations, and those that these move most. None where that is not enough.
std::vector<Index> LcpReduction::exchanged_with(const std::vector<Index>& free) const {
  const Matrix block = lcp_.M(free, free);
  const Equilibrated equilibrated(block);
  Eigen::FullPivLU<Matrix> right(equilibrated.scaled);
  Eigen::FullPivLU<Matrix> left(equilibrated.scaled.transpose());
  right.setThreshold(kLeastRegular);
  left.setThreshold(kLeastRegular);
  const std::vector<Index> rest = all_but(lcp_.size(), free);
  const Index missing = right.dimensionOfKernel();
  if (missing == 0 || missing != left.dimensionOfKernel() || missing > static_cast<Index>(rest.size())) return {};
  const Matrix nothing = equilibrated.columns.asDiagonal() * Matrix(right.kernel());
  const Matrix unmoved = equilibrated.rows.asDiagonal() * Matrix(left.kernel());
  const Matrix moved_by = lcp_.M(rest, free) * nothing;
  const Matrix moves = unmoved.transpose() * lcp_.M(free, rest);
  const Matrix both = moves * moved_by.rowwise().norm().asDiagonal();
  const Eigen::ColPivHouseholderQR<Matrix> order(both);
  std::vector<Index> exchanged;
  for (Index k = 0; k < missing; ++k) {
    exchanged.push_back(rest[static_cast<std::size_t>(order.colsPermutation().indices()(k))]);
  }
  return exchanged;
}

/// A principal pivot on the block of both lists: their z follow from the other unknowns and the w of the second list,
/// which are unknowns now. False, and nothing is changed, where the block counts as singular.
bool LcpReduction::eliminate(const std::vector<Index>& free, const std::vector<Index>& exchanged) {
  std::vector<Index> block = free;
  block.insert(block.end(), exchanged.begin(), exchanged.end());
  const Equilibrated equilibrated(lcp_.M(block, block));
  const Eigen::PartialPivLU<Matrix> factors(equilibrated.scaled);
  // The estimate of the condition means nothing where a pivot is zero.
  const double least_pivot = factors.matrixLU().diagonal().cwiseAbs().minCoeff();
  if (!(least_pivot >= kLeastRegular && factors.rcond() >= kLeastRegular)) return false;
  const auto solve = [&](const Matrix& right) {
    const Matrix scaled = equilibrated.rows.asDiagonal() * right;
    return Matrix(equilibrated.columns.asDiagonal() * Matrix(factors.solve(scaled)));
  };
  const bool symmetric = exchanged.empty() && lcp_.M == lcp_.M.transpose();
  const std::vector<Index> kept = all_but(lcp_.size(), free);
  const std::vector<Index> rest = all_but(lcp_.size(), block);
  std::vector<Index> place(static_cast<std::size_t>(lcp_.size()), -1);
  for (std::size_t k = 0; k < kept.size(); ++k) place[static_cast<std::size_t>(kept[k])] = static_cast<Index>(k);
  const auto places = [&](const std::vector<Index>& of) {
    std::vector<Index> result;
    for (const Index i : of) result.push_back(place[static_cast<std::size_t>(i)]);
    return result;
  };
  const std::vector<Index> of_exchanged = places(exchanged);
  const std::vector<Index> of_rest = places(rest);
  const auto order = static_cast<Index>(block.size());
  const auto count = static_cast<Index>(exchanged.size());
  recover_ = Matrix::Zero(order, static_cast<Index>(kept.size()));
  recover_(Eigen::all, of_rest) = -solve(lcp_.M(block, rest));
  recover_(Eigen::all, of_exchanged) = solve(Matrix::Identity(order, order).rightCols(count));
  recover_origin_ = -solve(lcp_.q(block));
  Lcp reduced;
  reduced.M.resize(recover_.cols(), recover_.cols());
  reduced.q.resize(recover_.cols());
  reduced.M(of_exchanged, Eigen::all) = recover_.bottomRows(count);
  reduced.q(of_exchanged) = recover_origin_.tail(count);
  Matrix others = lcp_.M(rest, block) * recover_;
  others(Eigen::all, of_rest) += lcp_.M(rest, rest);
  reduced.M(of_rest, Eigen::all) = others;
  reduced.q(of_rest) = lcp_.q(rest) + lcp_.M(rest, block) * recover_origin_;
  if (symmetric) reduced.M = Matrix((reduced.M + reduced.M.transpose()) / 2);
  lcp_ = std::move(reduced);
  kept_ = kept;
  eliminated_ = std::move(block);
  exchanged_ = count;
  exact_ = false;
  return true;
}

void LcpReduction::split(const std::vector<Index>& free) {
  const Index before = lcp_.size();
  const Index count = before + static_cast<Index>(free.size());
  lcp_.M.conservativeResize(count, count);
  lcp_.q.conservativeResize(count);
  for (std::size_t k = 0; k < free.size(); ++k) {
    const Index other = before + static_cast<Index>(k);
    const Unknown unknown = unknowns_[static_cast<std::size_t>(free[k])];
    lcp_.M.col(other).head(other) = -lcp_.M.col(free[k]).head(other);
    lcp_.M.row(other).head(other + 1) = -lcp_.M.row(free[k]).head(other + 1);
    lcp_.q(other) = -lcp_.q(free[k]);
    unknowns_.push_back({unknown.row, -unknown.sign});
    kept_.push_back(other);
  }
}

Vector LcpReduction::restore(const Vector& x) const {
  Vector all(static_cast<Index>(unknowns_.size()));
  all(kept_) = x;
  if (!eliminated_.empty()) {
    Vector found = recover_origin_ + recover_ * x;
    found.tail(exchanged_) = found.tail(exchanged_).cwiseMax(0.0).eval();  // rounding of what is at its bound
    all(eliminated_) = found;
  }
  Vector z = origin_;
  for (std::size_t k = 0; k < unknowns_.size(); ++k) {
    if (unknowns_[k].row >= 0) z(unknowns_[k].row) += unknowns_[k].sign * all(static_cast<Index>(k));
  }
  return z;
}

std::vector<std::pair<Index, Index>> split_unknowns(const Lcp& lcp) {
  std::vector<std::pair<Index, Index>> pairs;
  std::vector<char> is_paired(static_cast<std::size_t>(lcp.size()), 0);
  // Rounding has no sign: opposite rows have opposite sums.
  const Vector row_sums = lcp.M.rowwise().sum();
  const Vector column_sums = lcp.M.colwise().sum().transpose();
  const auto are_opposite = [&](Index i, Index k) {
    return lcp.q(k) == -lcp.q(i) && row_sums(k) == -row_sums(i) && column_sums(k) == -column_sums(i) &&
           lcp.M(k, k) == lcp.M(i, i) && lcp.M(i, k) == -lcp.M(i, i) && lcp.M(k, i) == -lcp.M(i, i) &&
           lcp.M.col(k) == -lcp.M.col(i) && lcp.M.row(k) == -lcp.M.row(i) && !lcp.M.col(i).isZero(0) &&
           !lcp.M.row(i).isZero(0);
  };
  for (Index i = 0; i < lcp.size(); ++i) {
    for (Index k = i + 1; k < lcp.size() && is_paired[static_cast<std::size_t>(i)] == 0; ++k) {
      if (is_paired[static_cast<std::size_t>(k)] != 0 || !are_opposite(i, k)) continue;
      pairs.emplace_back(i, k);
      is_paired[static_cast<std::size_t>(i)] = is_paired[static_cast<std::size_t>(k)] = 1;
    }
  }
  return pairs;
}

Lcp with_free_unknowns(const Lcp& lcp, const std::vector<std::pair<Index, Index>>& pairs, std::vector<Index>& rows) {
  std::vector<Index> second;
  for (const auto& pair : pairs) second.push_back(pair.second);
  rows = all_but(lcp.size(), second);
  Lcp mixed{lcp.M(rows, rows), lcp.q(rows), LcpBounds::nonnegative(static_cast<Index>(rows.size()))};
  for (const auto& pair : pairs) {
    const auto place = std::lower_bound(rows.begin(), rows.end(), pair.first) - rows.begin();
    mixed.bounds.lower(place) = -kInfinity;
  }
  return mixed;
}

}  // namespace lcpbench
