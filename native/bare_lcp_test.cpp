#include "native/bare_lcp_test.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnitRoundoff = 0x1p-53;

/// Between these, products and sums of a row neither overflow nor lose to underflow what counts against the row's
/// scale.
constexpr double kSmallestSafe = 0x1p-900;
constexpr double kLargestSafe = 0x1p900;

/// How finely an exact proof has to hold: the products of doubles are exact, their sums nearly so.
constexpr Quad kExact = 4 * kQuadUnitRoundoff;

}  // namespace

void BareLcpTest::load(const Lcp& lcp) {
  const Index n = lcp.size();
  lcp_ = &lcp;
  row_norm_ = lcp.M.cwiseAbs().rowwise().sum();
  for (Vector* vector : {&w_, &u_, &weights_}) vector->resize(n);
  support_.reserve(static_cast<std::size_t>(n));
  block_.resize(n, n);
}

double BareLcpTest::backward_error(const Vector& z) {
  const Index n = lcp_->size();
  if (z.size() != n || !z.allFinite()) return kInfinity;
  if (n == 0) return 0;
  if (!(z.minCoeff() >= 0)) return kInfinity;
  w_ = lcp_->q;
  w_.noalias() += lcp_->M * z;
  const double largest = z.maxCoeff();
  double worst = 0;
  for (Index i = 0; i < n; ++i) {
    const double error = row_error(i, z, largest);
    if (!(error <= worst)) worst = std::isnan(error) ? kInfinity : error;
  }
  return worst;
}

double BareLcpTest::row_error(Index row, const Vector& z, double largest) const {
  const double scale = std::abs(lcp_->q(row)) + row_norm_(row) * largest;
  if (!(scale >= kSmallestSafe && scale <= kLargestSafe)) return row_error_in_quad(row, z);
  const double violation = z(row) > 0 ? std::abs(w_(row)) : std::max(0.0, -w_(row));
  // n products and n sums, each rounded once, and two roundings here.
  return violation / scale + static_cast<double>(2 * z.size() + 2) * kUnitRoundoff;
}

double BareLcpTest::row_error_in_quad(Index row, const Vector& z) const {
  Quad w = lcp_->q(row);
  Quad norm = 0;
  Quad largest = 0;
  for (Index j = 0; j < z.size(); ++j) {
    const Quad entry = lcp_->M(row, j);
    w += entry * static_cast<Quad>(z(j));
    norm += abs(entry);
    largest = std::max(largest, static_cast<Quad>(z(j)));
  }
  const Quad violation = z(row) > 0 ? abs(w) : std::max(Quad{0}, -w);
  if (violation == 0) return 0;
  return to_double(violation / (abs(static_cast<Quad>(lcp_->q(row))) + norm * largest));
}

/// The row where -w_i is the largest; -1: none.
Index BareLcpTest::worst_violated(const Vector& z) const {
  Index worst = -1;
  Quad most = 0;
  for (Index i = 0; i < z.size(); ++i) {
    if (!(w_(i) < 0)) continue;
    Quad w = lcp_->q(i);
    for (Index j = 0; j < z.size(); ++j) {
      if (z(j) != 0) w += static_cast<Quad>(lcp_->M(i, j)) * static_cast<Quad>(z(j));
    }
    if (!(-w > most)) continue;
    most = -w;
    worst = i;
  }
  return worst;
}

bool BareLcpTest::disproves(const Vector& z) {
  const Index violated = worst_violated(z);
  if (violated < 0) return false;
  if (find_witness(violated, z) && proves(u_, kExact)) return true;
  if (!(z(violated) > 0)) return false;
  // Its z would remove the violation: at the cost of the row nearest to its bound.
  Index nearest = -1;
  for (Index i = 0; i < z.size(); ++i) {
    if (!(z(i) > 0) && (nearest < 0 || w_(i) < w_(nearest))) nearest = i;
  }
  return nearest >= 0 && find_witness(nearest, z) && proves(u_, kExact);
}

/// u_: 1 for the violated row, and for the other rows of the support what keeps their z out of the sum.
bool BareLcpTest::find_witness(Index violated, const Vector& z) {
  support_.clear();
  for (Index i = 0; i < z.size(); ++i) {
    if (z(i) > 0 && i != violated) support_.push_back(i);
  }
  const auto order = static_cast<Index>(support_.size());
  u_.setZero();
  u_(violated) = 1;
  for (Index k = 0; k < order; ++k) {
    const auto j = support_[static_cast<std::size_t>(k)];
    weights_(k) = -lcp_->M(violated, j);
    for (Index l = 0; l < order; ++l) block_(k, l) = lcp_->M(support_[static_cast<std::size_t>(l)], j);
  }
  if (!solve_block(order)) return false;
  for (Index k = 0; k < order; ++k) u_(support_[static_cast<std::size_t>(k)]) = weights_(k);
  return true;
}

/// weights_ := block_^-1 weights_, by elimination with partial pivoting, without the heap.
bool BareLcpTest::solve_block(Index order) {
  for (Index step = 0; step < order; ++step) {
    Index pivot = 0;
    const double largest = block_.col(step).segment(step, order - step).cwiseAbs().maxCoeff(&pivot);
    pivot += step;
    if (!(largest > 0)) return false;
    block_.row(step).segment(step, order - step).swap(block_.row(pivot).segment(step, order - step));
    std::swap(weights_(step), weights_(pivot));
    for (Index row = step + 1; row < order; ++row) {
      const double factor = block_(row, step) / block_(step, step);
      block_.row(row).segment(step + 1, order - step - 1) -=
          factor * block_.row(step).segment(step + 1, order - step - 1);
      weights_(row) -= factor * weights_(step);
    }
  }
  for (Index step = order; step-- > 0;) {
    weights_(step) /= block_(step, step);
    weights_.head(step) -= weights_(step) * block_.col(step).head(step);
  }
  return true;
}

bool BareLcpTest::proves(const Vector& u, Quad unit) const {
  const Index n = lcp_->size();
  if (u.size() != n || n == 0 || !u.allFinite() || !(u.minCoeff() >= 0)) return false;
  const Quad tolerance = unit * static_cast<Quad>(n);
  const auto sums = [&u](const auto& column) {
    std::pair<Quad, Quad> sum{0, 0};  // of the products, and of their magnitudes
    for (Index i = 0; i < u.size(); ++i) {
      if (u(i) == 0) continue;
      const Quad product = static_cast<Quad>(column(i)) * static_cast<Quad>(u(i));
      sum.first += product;
      sum.second += abs(product);
    }
    return sum;
  };
  for (Index j = 0; j < n; ++j) {
    const auto [sum, magnitude] = sums(lcp_->M.col(j));
    if (!(sum <= tolerance * magnitude)) return false;
  }
  const auto [sum, magnitude] = sums(lcp_->q);
  return sum < -tolerance * magnitude;
}

}  // namespace lcpbench
