#include "native/answer_test/bare_lcp_test.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/answer/exact_sum.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnitRoundoff = 0x1p-53;

/// Between these, products and sums of a row neither overflow nor lose to underflow what counts against the row's
/// scale.
constexpr double kSmallestSafe = 0x1p-900;
constexpr double kLargestSafe = 0x1p900;

/// A w_i or z_i of less than this, relative to its scale, may vanish or be negative in the exact solution of a basis.
constexpr double kClear = 1e-6;

/// Rows whose w_i exceeds this, relative to its scale, have no part in a proof against an answer that almost solves.
constexpr double kSlack = 1e-6;

/// Orders up to which a basis is inverted to see whether it gives a solution.
constexpr Index kLargestInverted = 32;

}  // namespace

void BareLcpTest::load(const Lcp& lcp) {
  const Index n = lcp.size();
  lcp_ = &lcp;
  find_row_islands(lcp.M, islands_, support_);
  row_norm_ = lcp.M.cwiseAbs().rowwise().sum();
  row_norm_ = (row_norm_.array() == 0).select(1.0, row_norm_);
  w_.resize(n);
  basis_.resize(n);
  largest_.resize(static_cast<std::size_t>(islands_.count));
  support_.reserve(static_cast<std::size_t>(n));
  candidates_.resize(static_cast<std::size_t>(n));
  search_.load(lcp);
}

double BareLcpTest::backward_error(const Vector& z) {
  const Index n = lcp_->size();
  if (z.size() != n || !z.allFinite()) return kInfinity;
  if (n == 0) return 0;
  if (!(z.minCoeff() >= 0)) return kInfinity;
  w_ = lcp_->q;
  w_.noalias() += lcp_->M * z;
  find_largest(z);
  double worst = 0;
  for (Index i = 0; i < n; ++i) {
    const double error = row_error(i, z);
    if (!(error <= worst)) worst = std::isnan(error) ? kInfinity : error;
  }
  return worst;
}

void BareLcpTest::find_largest(const Vector& z) {
  std::fill(largest_.begin(), largest_.end(), 0.0);
  for (Index i = 0; i < z.size(); ++i) largest_[block_of(i)] = std::max(largest(i), z(i));
}

double BareLcpTest::scale(Index row) const {
  return LcpRow<double>{.norm = row_norm_(row), .q = lcp_->q(row), .largest = largest(row)}.scale();
}

double BareLcpTest::row_error(Index row, const Vector& z) const {
  const LcpRow<double> of{row_norm_(row), lcp_->q(row), z(row), w_(row), largest(row)};
  const double scale = of.scale();
  if (!(scale >= kSmallestSafe && scale <= kLargestSafe)) return row_error_in_quad(row, z);
  // n products and n sums, each rounded once, and as many of the norm, and two roundings here.
  return of.violation() / scale + static_cast<double>(4 * z.size() + 2) * kUnitRoundoff;
}

double BareLcpTest::row_error_in_quad(Index row, const Vector& z) const {
  LcpRow<Quad> of{0, lcp_->q(row), z(row), lcp_->q(row), largest(row)};
  for (Index j = 0; j < z.size(); ++j) {
    const Quad entry = lcp_->M(row, j);
    of.w += entry * static_cast<Quad>(z(j));
    of.norm += abs(entry);
  }
  if (of.norm == 0) of.norm = 1;
  const Quad violation = of.violation();
  return violation == 0 ? 0 : to_double(violation / of.scale());
}

/// z with zeros where w is what does not vanish, and its w.
void BareLcpTest::find_basis(const Vector& z) {
  basis_ = (row_norm_.array() * z.array() > w_.array()).select(z, 0.0);
  if (basis_ == z) return;
  w_ = lcp_->q;
  w_.noalias() += lcp_->M * basis_;
}

bool BareLcpTest::disproves(const Vector& answer, double deadline_s) {
  find_basis(answer);
  const Vector& z = basis_;
  if (has_clear_basis(z)) return false;
  const Index n = z.size();
  bool is_feasible = true;
  for (Index i = 0; i < n && is_feasible; ++i) {
    const double rounding = static_cast<double>(2 * n + 2) * kUnitRoundoff * scale(i);
    is_feasible = w_(i) > rounding || sign_of_w(i, z) >= 0;
  }
  if (is_feasible) return false;
  for (Index i = 0; i < n; ++i) {
    candidates_[static_cast<std::size_t>(i)] = w_(i) > kSlack * scale(i) ? char{0} : char{1};
  }
  return search_.find(candidates_, deadline_s);
}

bool BareLcpTest::disproves(double deadline_s) {
  std::fill(candidates_.begin(), candidates_.end(), char{1});
  return search_.find(candidates_, deadline_s);
}

bool BareLcpTest::disproves_near(const Vector& u, double deadline_s) {
  return search_.round(u) || disproves(deadline_s);
}

/// Exactly.
int BareLcpTest::sign_of_w(Index row, const Vector& z) const {
  ExactSum sum;
  sum.add(lcp_->q(row), 1.0);
  for (Index j = 0; j < z.size(); ++j) {
    if (z(j) != 0) sum.add(lcp_->M(row, j), z(j));
  }
  return sum.sign();
}

/// Whether the exact solution of M z = -q on the support of z is so near that it has the same support and w >= 0: then
/// it solves the problem. The margins are wide enough for all that is rounded here.
bool BareLcpTest::has_clear_basis(const Vector& z) {
  support_.clear();
  for (Index i = 0; i < z.size(); ++i) {
    const double scale = this->scale(i);
    if (!(scale >= kSmallestSafe && scale <= kLargestSafe)) return false;
    if (z(i) > 0) {
      support_.push_back(i);
    } else if (!(w_(i) > kClear * scale)) {
      return false;
    }
  }
  const auto order = static_cast<Index>(support_.size());
  if (order == 0) return true;
  if (order > kLargestInverted) return false;
  const auto member = [this](Index k) { return support_[static_cast<std::size_t>(k)]; };
  // In the scale of z, and each row by its own: w and the change of z that it asks for become relative.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kLargestInverted, kLargestInverted> block(
      order, order);
  for (Index c = 0; c < order; ++c) {
    for (Index r = 0; r < order; ++r) block(r, c) = lcp_->M(member(r), member(c)) * (z(member(c)) / scale(member(r)));
  }
  const auto factors = block.partialPivLu();
  if (!(factors.matrixLU().diagonal().cwiseAbs().minCoeff() > kClear)) return false;
  // With entries of the block at most 1: |block^-1| against the errors of w, and again for those of the inverse.
  const double norm = factors.inverse().eval().cwiseAbs().rowwise().sum().maxCoeff();
  double largest = 0;
  for (Index r = 0; r < order; ++r) largest = std::max(largest, std::abs(w_(member(r))) / scale(member(r)));
  const double rounding = static_cast<double>(2 * z.size() + 2) * kUnitRoundoff;
  return norm * (largest + rounding) <= 0.1 * kClear;
}

}  // namespace lcpbench
