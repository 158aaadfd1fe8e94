#include "study/backward_error.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Quad quotient(Quad violation, Quad scale) {
  if (violation == 0) return 0;
  return scale == 0 ? Quad{kInfinity} : violation / scale;
}

struct Candidate {
  Quad ratio = 0;  ///< the least tau that sets the entry to zero
  std::size_t index = 0;
};

Quad largest_magnitude(const QuadVector& z, std::size_t begin, std::size_t end) {
  Quad largest = 0;
  for (std::size_t i = begin; i < end; ++i) largest = std::max(largest, abs(z[i]));
  return largest;
}

// The nonzero entries of z in the order in which a growing tau sets them to zero.
std::vector<Candidate> order_of_removal(const QuadLcp& lcp, const QuadVector& z) {
  const Quad impulse = largest_magnitude(z, 0, lcp.lambda_offset());
  const Quad lambda = largest_magnitude(z, lcp.lambda_offset(), z.size());
  std::vector<Candidate> order;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (z[i] != 0) order.push_back({abs(z[i]) / (i < lcp.lambda_offset() ? impulse : lambda), i});
  }
  std::sort(order.begin(), order.end(), [](const Candidate& a, const Candidate& b) {
    return a.ratio < b.ratio || (a.ratio == b.ratio && a.index < b.index);
  });
  return order;
}

// z_tau for a growing tau, with what is needed to measure it.
class ThinningPoint {
 public:
  ThinningPoint(QuadLcp& lcp, const QuadVector& z, BackwardScale scale)
      : lcp_(lcp), scale_(scale), z_(z), u_(lcp.response(z)), order_(order_of_removal(lcp, z)) {
    for (const Candidate& candidate : order_) indices_.push_back(candidate.index);
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
    for (; removed_ < order_.size() && !(order_[removed_].ratio > tau); ++removed_) {
      const std::size_t i = order_[removed_].index;
      lcp_.remove(i, z_[i], u_);
      z_[i] = 0;
    }
    z_norm_.reset();
  }

  // The next tau at which z_tau changes; nothing when all is zero.
  std::optional<Quad> next_tau() const {
    if (removed_ == order_.size()) return std::nullopt;
    return order_[removed_].ratio;
  }

  Quad violation(std::size_t i) const { return violation(i, lcp_.row(i, z_, u_)); }
  const QuadVector& z() const { return z_; }
  // The nonzero entries, smallest ratio first.
  std::span<const std::size_t> support() const { return std::span(indices_).subspan(removed_); }

  // eta(z_tau). Rows are measured in the order of an upper bound of their quotients until the bound settles the rest.
  Quad eta() {
    struct Row {
      Quad bound = 0;
      Quad violation = 0;
      std::size_t index = 0;
    };
    const QuadVector w = lcp_.all_rows(z_, u_);
    std::vector<Row> rows;
    for (std::size_t i = 0; i < w.size(); ++i) {
      const Quad violation_i = violation(i, w[i]);
      if (violation_i != 0) rows.push_back({quotient(violation_i, least_scale(i)), violation_i, i});
    }
    std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.bound > b.bound; });
    Quad eta = 0;
    for (const Row& row : rows) {
      if (!(row.bound > eta)) break;
      eta = std::max(eta, quotient(row.violation, scale(row.index)));
    }
    return eta;
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

  Quad z_norm() {
    if (!z_norm_) z_norm_ = largest_magnitude(z_, 0, z_.size());
    return *z_norm_;
  }

  // A lower bound of s_i that needs one entry of M.
  Quad least_scale(std::size_t i) {
    const Quad z = scale_ == BackwardScale::kComponentwise ? z_[i] : z_norm();
    return z > 0 ? abs(lcp_.q(i)) + abs(lcp_.diagonal(i)) * z : abs(lcp_.q(i));
  }

  QuadLcp& lcp_;
  BackwardScale scale_;
  QuadVector z_;
  QuadVector u_;
  std::vector<Candidate> order_;
  std::vector<std::size_t> indices_;  // of order_
  std::size_t removed_ = 0;
  std::optional<Quad> z_norm_;
};

// A row whose entry stays in z for long and whose quotient alone already exceeds the best error found. Removing entries
// only lowers s_i, so the scale it was chosen with bounds all later ones.
struct Witness {
  std::size_t row = 0;
  Quad scale = 0;

  bool refutes(const ThinningPoint& point, Quad best) const {
    return point.z()[row] > 0 && !(quotient(point.violation(row), scale) < best);
  }
};

std::optional<Witness> find_witness(ThinningPoint& point, Quad best) {
  constexpr int kAttempts = 8;
  int attempts = 0;
  const std::span<const std::size_t> support = point.support();
  for (auto i = support.rbegin(); i != support.rend() && attempts < kAttempts; ++i) {
    const Quad violation = point.violation(*i);
    if (violation == 0) continue;
    ++attempts;
    const Witness witness{*i, point.scale(*i)};
    if (!(quotient(violation, witness.scale) < best)) return witness;
  }
  return std::nullopt;
}

}  // namespace

Quad mixed_backward_error(QuadLcp& lcp, const QuadVector& z, BackwardScale scale) {
  ThinningPoint point(lcp, z, scale);
  std::optional<Quad> tau = point.least_tau();
  std::optional<Witness> witness;
  Quad best = kInfinity;
  while (tau && *tau < best) {
    point.set_tau(*tau);
    if (!witness || !witness->refutes(point, best)) {
      best = std::min(best, std::max(*tau, point.eta()));
      witness = find_witness(point, best);
    }
    tau = point.next_tau();
  }
  return best;
}

}  // namespace lcpbench
