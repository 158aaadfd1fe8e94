#include "native/answer_test/bare_lcp_test.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/answer/exact_sum.h"
#include "core/answer/lcp_error.h"

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

/// By which part of itself the exact solution of a basis may be away, at most.
constexpr double kLargestChange = 1e-2;

/// Rows whose w_i exceeds this, relative to its scale, have no part in a proof u against an answer that almost solves:
/// u'w < 0 with w_i no lower than -kClaimedBackwardError leaves them a share of 1/2000 of it.
constexpr double kSlack = 2000 * kClaimedBackwardError;

/// Orders up to which a basis is inverted to see whether it gives a solution.
constexpr Index kLargestInverted = 32;

}  // namespace

void BareLcpTest::load(const Lcp& lcp) {
  const Index n = lcp.size();
  lcp_ = &lcp;
  norm_.assign(static_cast<std::size_t>(n), 0);
  const Vector norms = lcp.M.cwiseAbs().rowwise().sum();
  for (Index i = 0; i < n; ++i) {
    Quad& norm = norm_[static_cast<std::size_t>(i)] = norms(i);
    if (norm == 0) norm = 1;
    if (std::isfinite(norms(i))) continue;
    norm = 0;
    for (const double entry : lcp.M.row(i)) norm += std::abs(entry);
  }
  least_scale_ = lcp_floors(lcp, row_islands(lcp.M), norm_);
  for (Quad& floor : least_scale_) floor *= kLcpFloorShare;
  for (Vector* vector : {&w_, &terms_, &basis_}) vector->resize(n);
  support_.reserve(static_cast<std::size_t>(n));
  candidates_.resize(static_cast<std::size_t>(n));
  search_.load(lcp);
}

void BareLcpTest::evaluate(const Vector& z) {
  w_ = lcp_->q;
  terms_ = w_.cwiseAbs();
  for (Index j = 0; j < z.size(); ++j) {
    if (z(j) == 0) continue;
    w_ += z(j) * lcp_->M.col(j);
    terms_ += z(j) * lcp_->M.col(j).cwiseAbs();
  }
}

double BareLcpTest::backward_error(const Vector& z) {
  const Index n = lcp_->size();
  if (z.size() != n || !z.allFinite()) return kInfinity;
  if (n == 0) return 0;
  if (!(z.minCoeff() >= 0)) return kInfinity;
  evaluate(z);
  double worst = 0;
  for (Index i = 0; i < n; ++i) worst = std::max(worst, row_error(i, z));
  return worst;
}

double BareLcpTest::scale(Index row) const {
  return std::max(terms_(row), to_double(least_scale_[static_cast<std::size_t>(row)]));
}

double BareLcpTest::row_error(Index row, const Vector& z) const {
  const double scale = this->scale(row), norm = to_double(norm_[static_cast<std::size_t>(row)]);
  if (!(scale >= kSmallestSafe && scale <= kLargestSafe && norm <= kLargestSafe)) return row_error_in_quad(row, z);
  // n products and n sums in w and in its scale, each rounded once, as many sums in the norm, and twice in the floor.
  const double rounding = static_cast<double>(6 * z.size() + 8) * kUnitRoundoff;
  return std::abs(std::min(norm * z(row), w_(row))) / scale + rounding;
}

double BareLcpTest::row_error_in_quad(Index row, const Vector& z) const {
  Quad w = lcp_->q(row);
  Quad terms = abs(w);
  for (Index j = 0; j < z.size(); ++j) {
    const Quad term = static_cast<Quad>(lcp_->M(row, j)) * z(j);
    w += term;
    terms += abs(term);
  }
  const auto i = static_cast<std::size_t>(row);
  const Quad violation = abs(std::min(norm_[i] * z(row), w));
  return violation == 0 ? 0 : to_double(violation / std::max(terms, least_scale_[i]));
}

/// z with zeros where w is what does not vanish, and its w.
void BareLcpTest::find_basis(const Vector& z) {
  for (Index i = 0; i < z.size(); ++i) {
    basis_(i) = norm_[static_cast<std::size_t>(i)] * z(i) > w_(i) ? z(i) : 0.0;
  }
  if (basis_ != z) evaluate(basis_);
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
  const double change = 10 * norm * (largest + rounding);  // of each z, relative to it, and of each w to its scale
  if (!(change < kLargestChange)) return false;
  for (Index i = 0; i < z.size(); ++i) {
    if (!(z(i) > 0 || w_(i) > change * scale(i))) return false;
  }
  return true;
}

}  // namespace lcpbench
