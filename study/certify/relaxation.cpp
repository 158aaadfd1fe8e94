#include "study/certify/relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace lcpbench::exact {
namespace {

/// Rounds of evening out the rows and columns of M.
constexpr int kScalings = 4;
/// The entries have about size 1. A pivot up to kZero, or a variable up to kInfeasible, may be nothing but rounding.
constexpr double kZero = 1e-9;
constexpr double kInfeasible = 1e-7;
/// Ratios that differ by less tie; the largest pivot wins.
constexpr double kTie = 1e-12;
/// After more pivots than this for each row the dual simplex method is taken to cycle.
constexpr int kPivotsPerRow = 20;
/// See Deadline::passed().
constexpr Index kEntriesAStep = 2000;
/// Of the room that a contradiction has, how much is used, and the most of it.
constexpr double kRoomUsed = 0.5;
constexpr double kMostRoom = 1e-3;

double power_of_two_below(double x) { return x > 0 && std::isfinite(x) ? std::exp2(std::floor(std::log2(x))) : 1.0; }

/// 1, 1.01, ... 1.36, and again: different prices, so that few vertices cost the same.
double price(Index i) { return 1 + 0.01 * static_cast<double>(i % 37); }

}  // namespace

Relaxation::Relaxation(const Lcp& lcp)
    : row_unit_(Vector::Ones(lcp.size())),
      column_unit_(Vector::Ones(lcp.size())),
      A_(lcp.M),
      b_(lcp.q),
      cost_(lcp.size()),
      basic_(static_cast<std::size_t>(lcp.size())),
      nonbasic_(static_cast<std::size_t>(lcp.size())),
      imposed_(static_cast<std::size_t>(2 * lcp.size()), 0) {
  const Index n = lcp.size();
  for (int round = 0; round < kScalings; ++round) {
    for (Index i = 0; i < n; ++i) {
      const double unit = power_of_two_below(std::sqrt(A_.row(i).cwiseAbs().maxCoeff()));
      A_.row(i) /= unit;
      row_unit_(i) *= unit;
    }
    for (Index j = 0; j < n; ++j) {
      const double unit = power_of_two_below(std::sqrt(A_.col(j).cwiseAbs().maxCoeff()));
      A_.col(j) /= unit;
      column_unit_(j) /= unit;
    }
  }
  b_.array() /= row_unit_.array();
  const double largest = power_of_two_below(n > 0 ? b_.cwiseAbs().maxCoeff() : 1.0);
  b_ /= largest;
  row_unit_ *= largest;
  column_unit_ *= largest;
  for (Index i = 0; i < n; ++i) cost_(i) = price(i);
  std::iota(basic_.begin(), basic_.end(), Index{0});
  std::iota(nonbasic_.begin(), nonbasic_.end(), n);
}

void Relaxation::pivot(Index row, Index column) {
  const double inverse = 1 / A_(row, column);
  Vector entering = A_.col(column);
  entering(row) = 0;
  A_.col(column).setZero();
  A_.row(row) *= -inverse;
  A_(row, column) = inverse;
  b_(row) *= -inverse;
  const Eigen::RowVectorXd solved = A_.row(row);
  A_.noalias() += entering * solved;
  b_ += entering * b_(row);
  const double reduced = cost_(column);
  cost_(column) = 0;
  cost_ += reduced * solved.transpose();
  std::swap(basic_[static_cast<std::size_t>(row)], nonbasic_[static_cast<std::size_t>(column)]);
}

Relaxation::Ending Relaxation::solve(const Deadline& deadline) {
  const Index n = size();
  for (Index count = 0; count < kPivotsPerRow * n; ++count) {
    Index leaving = -1;
    double worst = kInfeasible;
    for (Index i = 0; i < n; ++i) {
      const bool too_large = b_(i) > worst && is_imposed(basic_[static_cast<std::size_t>(i)]);
      if (!too_large && !(-b_(i) > worst)) continue;
      worst = std::abs(b_(i));
      leaving = i;
      side_ = too_large ? -1 : 1;
    }
    if (leaving < 0) return Ending::kFeasible;
    if (deadline.passed(1 + n * n / kEntriesAStep)) return Ending::kStuck;
    Index entering = -1;
    double best = std::numeric_limits<double>::infinity();
    for (Index j = 0; j < n; ++j) {
      const double slope = side_ * A_(leaving, j);
      if (!(slope > kZero) || is_imposed(nonbasic_[static_cast<std::size_t>(j)])) continue;
      const double ratio = std::max(cost_(j), 0.0) / slope;
      const bool ties = ratio < best + kTie && entering >= 0 && slope > side_ * A_(leaving, entering);
      if (ratio < best - kTie || ties || entering < 0) {
        best = ratio;
        entering = j;
      }
    }
    if (entering < 0) {
      contradicting_row_ = leaving;
      return Ending::kInfeasible;
    }
    pivot(leaving, entering);
  }
  return Ending::kStuck;
}

Vector Relaxation::z() const {
  Vector z = Vector::Zero(size());
  for (Index i = 0; i < size(); ++i) {
    const Index variable = basic_[static_cast<std::size_t>(i)] - size();
    if (variable >= 0) z(variable) = column_unit_(variable) * b_(i);
  }
  return z;
}

Vector Relaxation::w() const {
  Vector w = Vector::Zero(size());
  for (Index i = 0; i < size(); ++i) {
    const Index variable = basic_[static_cast<std::size_t>(i)];
    if (variable < size()) w(variable) = row_unit_(variable) * b_(i);
  }
  return w;
}

// The contradicting row says x = b + a'nonbasic with b < 0 and a <= 0 (all times `side_`).
Vector Relaxation::contradiction(double epsilon, const Eigen::RowVectorXd& slope) const {
  const Index n = size();
  Vector y = Vector::Zero(n);
  for (Index j = 0; j < n; ++j) {
    const Index variable = nonbasic_[static_cast<std::size_t>(j)];
    if (variable >= n) continue;
    const double coefficient = -side_ * A_(contradicting_row_, j) - epsilon * slope(j);
    y(variable) = is_imposed(variable) ? coefficient : std::max(coefficient, 0.0);
  }
  if (const Index own = basic_[static_cast<std::size_t>(contradicting_row_)]; own < n) y(own) = side_;
  y.array() /= row_unit_.array();
  return y / y.cwiseAbs().maxCoeff();
}

Vector Relaxation::contradiction() const { return contradiction(0, Eigen::RowVectorXd::Zero(size())); }

// Adding epsilon times the rows of basic z makes their coefficients in the contradicting row, which were zero, strictly
// positive; what it costs the others is taken out of the room that they have.
Vector Relaxation::contradiction_with_room() const {
  Eigen::RowVectorXd slope = Eigen::RowVectorXd::Zero(size());
  double constant = 0;
  for (Index i = 0; i < size(); ++i) {
    const Index variable = basic_[static_cast<std::size_t>(i)];
    if (variable < size() || is_imposed(variable) || i == contradicting_row_ || !has_room(i)) continue;
    slope += A_.row(i);
    constant += b_(i);
  }
  return contradiction(room(slope, constant), slope);
}

std::vector<Index> Relaxation::tight_columns() const {
  std::vector<Index> tight;
  for (Index i = 0; i < size(); ++i) {
    const Index variable = basic_[static_cast<std::size_t>(i)];
    if (variable >= size() && i != contradicting_row_) tight.push_back(variable - size());
  }
  return tight;
}

bool Relaxation::has_room(Index row) const {
  for (Index j = 0; j < size(); ++j) {
    if (is_imposed(nonbasic_[static_cast<std::size_t>(j)])) continue;
    if (A_(row, j) > kZero && -side_ * A_(contradicting_row_, j) <= kZero) return false;
  }
  return true;
}

double Relaxation::room(const Eigen::RowVectorXd& slope, double constant) const {
  double epsilon = kMostRoom;
  if (constant > 0) epsilon = std::min(epsilon, kRoomUsed * std::abs(b_(contradicting_row_)) / constant);
  for (Index j = 0; j < size(); ++j) {
    if (is_imposed(nonbasic_[static_cast<std::size_t>(j)]) || !(slope(j) > 0)) continue;
    const double own = -side_ * A_(contradicting_row_, j);
    if (own > kZero) epsilon = std::min(epsilon, kRoomUsed * own / slope(j));
  }
  return epsilon;
}

}  // namespace lcpbench::exact
