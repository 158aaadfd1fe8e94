#include "study/evaluation/backward_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Candidate {
  Quad ratio = 0;  ///< the least tau that sets the entry to zero
  std::size_t index = 0;
};

using Rows = std::span<const std::size_t>;

// The nonzero entries of an island's z in the order in which a growing tau sets them to zero.
std::vector<Candidate> order_of_removal(const QuadLcp& lcp, const QuadVector& z, Rows rows) {
  Quad impulse = 0;
  Quad lambda = 0;
  for (const std::size_t i : rows) {
    Quad& largest = i < lcp.lambda_offset() ? impulse : lambda;
    largest = std::max(largest, abs(z[i]));
  }
  std::vector<Candidate> order;
  for (const std::size_t i : rows) {
    if (z[i] != 0) order.push_back({abs(z[i]) / (i < lcp.lambda_offset() ? impulse : lambda), i});
  }
  std::sort(order.begin(), order.end(), [](const Candidate& a, const Candidate& b) {
    return a.ratio < b.ratio || (a.ratio == b.ratio && a.index < b.index);
  });
  return order;
}

// z_tau of one island after the other for a growing tau, with what is needed to measure it. What is removed from one
// island is never seen by another.
class ThinningPoint {
 public:
  ThinningPoint(QuadLcp& lcp, const QuadVector& z, BackwardScale scale)
      : lcp_(lcp), scale_(scale), z_(z), u_(lcp.response(z)), w_(z.size()) {}

  void enter(Rows island) {
    island_ = island;
    order_ = order_of_removal(lcp_, z_, island);
    indices_.clear();
    for (const Candidate& candidate : order_) indices_.push_back(candidate.index);
    set_removed(0);
  }

  // The least tau that leaves no negative entry.
  Quad least_tau() const {
    Quad tau = 0;
    for (const Candidate& candidate : order_) {
      if (z_[candidate.index] < 0) tau = candidate.ratio;
    }
    return tau;
  }

  void set_tau(Quad tau) {
    std::size_t removed = removed_;
    for (; removed < order_.size() && !(order_[removed].ratio > tau); ++removed) {
      const std::size_t i = order_[removed].index;
      lcp_.remove(i, z_[i], u_);
      z_[i] = 0;
    }
    set_removed(removed);
  }

  // The entry of largest ratio among those set to zero.
  std::optional<std::size_t> last_removed() const {
    if (removed_ == 0) return std::nullopt;
    return order_[removed_ - 1].index;
  }

  // The next tau at which z_tau changes; nothing when all is zero.
  std::optional<Quad> next_tau() const {
    if (removed_ == order_.size()) return std::nullopt;
    return order_[removed_].ratio;
  }

  Quad violation(std::size_t i) const { return violation(i, lcp_.row(i, z_, u_)); }
  // The nonzero entries, smallest ratio first.
  std::span<const std::size_t> support() const { return std::span(indices_).subspan(removed_); }

  // eta(z_tau). Rows are measured in the order of an upper bound of their quotients until the bound settles the rest.
  BackwardError eta() {
    struct Row {
      Quad bound = 0;
      Quad violation = 0;
      std::size_t index = 0;
    };
    lcp_.fill_rows(island_, z_, u_, w_);
    std::vector<Row> rows;
    for (const std::size_t i : island_) {
      const Quad violation_i = violation(i, w_[i]);
      if (violation_i != 0) rows.push_back({quotient(violation_i, scale_bounds(i).low), violation_i, i});
    }
    std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
      return a.bound > b.bound || (a.bound == b.bound && a.index < b.index);
    });
    BackwardError eta;
    for (const Row& row : rows) {
      if (!(row.bound > eta.error)) break;
      const Quad error = quotient(row.violation, scale(row.index));
      if (error > eta.error) eta = {error, row.index};
    }
    return eta;
  }

  // Whether estimates of s_i are at hand: while few entries are left, s_i itself costs less than the estimate of M.
  bool estimated() {
    constexpr std::size_t kFew = 64;
    if (estimate_ == nullptr && support().size() > kFew) estimate_ = lcp_.estimate();
    return estimate_ != nullptr;
  }

  struct Bounds {
    Quad low = 0;
    Quad high = kInfinity;
  };

  // Bounds of s_i.
  Bounds scale_bounds(std::size_t i) {
    const Quad q = abs(lcp_.q(i));
    if (!estimated()) return {q + abs(lcp_.diagonal(i)) * least_weight(i), kInfinity};
    const auto [sum, error] = estimated_scale(i);
    Bounds bounds{q, kInfinity};
    const double rounding = static_cast<double>(lcp_.size() + 8) * 0x1p-52;
    if (std::isfinite(sum) && std::isfinite(error)) {
      bounds.low = q + std::max(Quad{0}, Quad{sum} * (1 - rounding) - error);
      bounds.high = q + Quad{sum} * (1 + rounding) + error;
    }
    return bounds;
  }

  // Violations of the island's rows, in double and without a bound on their error.
  std::vector<double> estimated_violations() const {
    std::vector<double> violations = lcp_.estimate_w(z_, u_, island_);
    for (const std::size_t i : island_) {
      violations[i] = z_[i] > 0 ? std::abs(violations[i]) : std::max(0.0, -violations[i]);
    }
    return violations;
  }

  // s_i
  Quad scale(std::size_t i) {
    const Quad q = abs(lcp_.q(i));
    if (scale_ == BackwardScale::kComponentwise) return q + lcp_.abs_row_times(i, z_, support());
    return z_norm() > 0 ? q + lcp_.abs_row_sum(i) * z_norm() : q;
  }

 private:
  Quad violation(std::size_t i, Quad w) const {
    if (z_[i] > 0) return abs(w);
    return w < 0 ? -w : Quad{0};
  }

  void set_removed(std::size_t removed) {
    removed_ = removed;
    z_norm_.reset();
    rounded_z_.clear();
  }

  Quad z_norm() {
    if (!z_norm_) {
      z_norm_ = 0;
      for (const std::size_t i : support()) *z_norm_ = std::max(*z_norm_, abs(z_[i]));
    }
    return *z_norm_;
  }

  // A lower bound of the factor of |M_ii| in s_i.
  Quad least_weight(std::size_t i) { return scale_ == BackwardScale::kComponentwise ? z_[i] : z_norm(); }

  struct Estimate {
    double sum = 0;
    double error = 0;
  };

  // s_i less |q_i|, but for the rounding of the sums.
  Estimate estimated_scale(std::size_t i) {
    if (rounded_z_.empty()) round_z();
    if (scale_ == BackwardScale::kRowNorm) {
      const double norm = to_double(z_norm());
      return {estimate_->row_sums[i] * norm, 2 * estimate_->row_error[i] * error_weight_ * norm};
    }
    double sum = 0;
    for (std::size_t e = estimate_->begin[i]; e < estimate_->begin[i + 1]; ++e) {
      sum += estimate_->entries[e] * rounded_z_[estimate_->columns[e]];
    }
    return {sum, 2 * estimate_->row_error[i] * error_weight_};
  }

  void round_z() {
    rounded_z_.assign(z_.size(), 0);
    for (const std::size_t j : island_) rounded_z_[j] = to_double(z_[j]);
    error_weight_ = 0;
    for (const std::size_t j : island_) {
      error_weight_ += estimate_->column_scale[j] * (scale_ == BackwardScale::kRowNorm ? 1 : rounded_z_[j]);
    }
  }

  QuadLcp& lcp_;
  BackwardScale scale_;
  QuadVector z_;
  QuadVector u_;
  QuadVector w_;  // of the island's rows, as eta() last found them
  Rows island_;
  std::vector<Candidate> order_;
  std::vector<std::size_t> indices_;  // of order_
  std::size_t removed_ = 0;
  std::optional<Quad> z_norm_;
  const MagnitudeEstimate* estimate_ = nullptr;
  std::vector<double> rounded_z_;  // z_ in double; empty until an estimate needs it
  double error_weight_ = 0;        // sum of column_scale times the weight of the column in s_i
};

// A row that alone shows the present z_tau to be no better than the best error found. Removing entries only lowers s_i,
// so the scale that was found with it bounds all later ones.
struct Witness {
  std::size_t row = 0;
  Quad scale = 0;

  bool refutes(ThinningPoint& point, Quad best) {
    const Quad violation = point.violation(row);
    if (violation == 0) return false;
    if (!(quotient(violation, scale) < best)) return true;
    scale = std::min(scale, point.scale_bounds(row).high);
    if (!(quotient(violation, scale) < best)) return true;
    scale = point.scale(row);
    return !(quotient(violation, scale) < best);
  }
};

// Looks for a witness among the rows whose entry stays in z the longest.
std::optional<Witness> find_witness(ThinningPoint& point, Quad best) {
  constexpr int kAttempts = 4;
  constexpr double kSlack = 1 - 1e-9;  // a row that only equals the best error still refutes
  const bool estimated = point.estimated();
  const std::vector<double> violations = estimated ? point.estimated_violations() : std::vector<double>{};
  const std::span<const std::size_t> support = point.support();
  int attempts = 0;
  for (auto i = support.rbegin(); i != support.rend() && attempts < kAttempts; ++i) {
    if (estimated && quotient(violations[*i], point.scale_bounds(*i).low) < best * kSlack) continue;
    ++attempts;
    Witness witness{*i, kInfinity};
    if (witness.refutes(point, best)) return witness;
  }
  return std::nullopt;
}

// Of the island that the point has entered.
BackwardError island_error(ThinningPoint& point) {
  std::optional<Quad> tau = point.least_tau();
  std::optional<Witness> witness;
  BackwardError best{kInfinity, std::nullopt};
  while (tau && *tau < best.error) {
    point.set_tau(*tau);
    if (best.error < kInfinity && !(witness && witness->refutes(point, best.error))) {
      witness = find_witness(point, best.error);
    }
    if (!witness) {
      const BackwardError eta = point.eta();
      const BackwardError error = *tau > eta.error ? BackwardError{*tau, point.last_removed()} : eta;
      if (error.error < best.error) best = error;
    }
    tau = point.next_tau();
  }
  return best;
}

}  // namespace

IslandRows::IslandRows(const RowIslands& islands)
    : begin_(static_cast<std::size_t>(islands.count) + 1, 0), rows_(islands.of_row.size()) {
  for (const Index island : islands.of_row) ++begin_[static_cast<std::size_t>(island) + 1];
  for (std::size_t island = 0; island < count(); ++island) begin_[island + 1] += begin_[island];
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    rows_[next[static_cast<std::size_t>(islands.of_row[row])]++] = row;
  }
}

BackwardError mixed_backward_error(QuadLcp& lcp, const QuadVector& z, BackwardScale scale, const IslandRows& islands) {
  ThinningPoint point(lcp, z, scale);
  BackwardError worst;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    point.enter(islands.rows(island));
    const BackwardError error = island_error(point);
    if (error.error > worst.error) worst = error;
  }
  return worst;
}

}  // namespace lcpbench
