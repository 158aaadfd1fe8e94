#include "study/evaluation/backward_error.h"

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "study/evaluation/measures.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double entry(const Lcp& lcp, std::size_t i, std::size_t j) {
  return lcp.M(static_cast<Index>(i), static_cast<Index>(j));
}

/// z_tau of one island for a growing tau.
class ThinningPoint {
 public:
  ThinningPoint(const Lcp& lcp, std::span<const std::size_t> island, const QuadVector& z, const QuadVector& w)
      : lcp_(lcp), island_(island), z_(z), w_(w) {
    for (const std::size_t i : island) {
      if (z[i] != 0) support_.push_back(i);
    }
    std::stable_sort(support_.begin(), support_.end(),
                     [&z](std::size_t a, std::size_t b) { return abs(z[a]) < abs(z[b]); });
    magnitudes_.reserve(support_.size());
    for (const std::size_t i : support_) magnitudes_.push_back(abs(z[i]));
    row_sums_.resize(island.size());
    for (std::size_t k = 0; k < island.size(); ++k) {
      for (const std::size_t j : island) row_sums_[k] += abs(Quad{entry(lcp, island[k], j)});
    }
  }

  /// How many entries the least tau sets to zero that leaves no negative one.
  std::size_t least_removals() const {
    for (std::size_t place = support_.size(); place-- > 0;) {
      if (z_[support_[place]] < 0) return end_of_ratio(place);
    }
    return 0;
  }
  /// The same for the next tau at which z_tau changes; nothing when all is zero.
  std::optional<std::size_t> next_removals() const {
    if (removed_ == support_.size()) return std::nullopt;
    return end_of_ratio(removed_);
  }
  /// The least tau that removes so many.
  Quad tau(std::size_t removals) const {
    return removals == 0 ? Quad{0} : magnitudes_[removals - 1] / magnitudes_.back();
  }

  void remove(std::size_t removals) {
    for (; removed_ < removals; ++removed_) {
      const std::size_t j = support_[removed_];
      for (const std::size_t i : island_) w_[i] -= entry(lcp_, i, j) * z_[j];
      z_[j] = 0;
    }
    if (removed_ == support_.size()) find_w();  // which is q
  }

  /// Of max(tau, eta(z_tau)).
  BackwardError error() {
    BackwardError found = eta();
    if (found.error > 1 + 0x1p-50) {  // only by the rounding of removals: no violation exceeds s_i
      find_w();
      found = eta();
    }
    if (tau(removed_) > found.error) return {tau(removed_), support_[removed_ - 1]};
    return found;
  }

 private:
  std::size_t end_of_ratio(std::size_t place) const {
    std::size_t end = place + 1;
    while (end < support_.size() && magnitudes_[end] == magnitudes_[place]) ++end;
    return end;
  }

  void find_w() {
    for (const std::size_t i : island_) {
      w_[i] = lcp_.q(static_cast<Index>(i));
      for (std::size_t place = removed_; place < support_.size(); ++place) {
        w_[i] += entry(lcp_, i, support_[place]) * z_[support_[place]];
      }
    }
  }

  BackwardError eta() const {
    const Quad norm = removed_ < support_.size() ? magnitudes_.back() : Quad{0};
    BackwardError eta;
    for (std::size_t k = 0; k < island_.size(); ++k) {
      const std::size_t i = island_[k];
      const Quad violation = z_[i] > 0 ? abs(w_[i]) : larger(Quad{0}, -w_[i]);
      const Quad error = quotient(violation, abs(Quad{lcp_.q(static_cast<Index>(i))}) + row_sums_[k] * norm);
      if (error > eta.error) eta = {error, i};
    }
    return eta;
  }

  const Lcp& lcp_;
  std::span<const std::size_t> island_;
  QuadVector z_, w_;
  std::vector<std::size_t> support_;  // nonzero entries of the given z, smallest magnitude first
  QuadVector magnitudes_;             // of the support
  QuadVector row_sums_;               // ||M_i||_1 of the island's rows
  std::size_t removed_ = 0;           // of the support, which are zero in z_
};

BackwardError island_error(ThinningPoint point) {
  BackwardError best{kInfinity, std::nullopt};
  std::optional<std::size_t> removals = point.least_removals();
  while (removals && point.tau(*removals) < best.error) {
    point.remove(*removals);
    const BackwardError found = point.error();
    if (found.error < best.error) best = found;
    removals = point.next_removals();
  }
  return best;
}

}  // namespace

QuadVector complement(const Lcp& lcp, const QuadVector& z) {
  QuadVector w(lcp.q.begin(), lcp.q.end());
  for (std::size_t j = 0; j < z.size(); ++j) {
    if (z[j] == 0) continue;
    for (std::size_t i = 0; i < w.size(); ++i) w[i] += entry(lcp, i, j) * z[j];
  }
  return w;
}

BackwardError mixed_backward_error(const Lcp& lcp, const QuadVector& z, const QuadVector& w,
                                   const IslandRows& islands) {
  BackwardError worst;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const BackwardError error = island_error(ThinningPoint(lcp, islands.rows(island), z, w));
    if (error.error > worst.error) worst = error;
  }
  return worst;
}

}  // namespace lcpbench
