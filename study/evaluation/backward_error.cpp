#include "study/evaluation/backward_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Rows = std::span<const std::size_t>;

// a >= b. For Bounded errors >= 0: a falls short of b by at most kForgiven of it, or by kForgivenError, so that equal
// numbers of which only bounds are known are not told apart in vain. The result makes up for what was forgiven.
constexpr double kForgiven = 0x1p-53;
// An error without units is relative to the data, which are known to 2^-53. Of one below 2^-48 this leaves four digits.
constexpr double kForgivenError = 0x1p-62;
double forgiven(double b) { return std::isfinite(b) ? std::max(kForgiven * b, kForgivenError) : 0; }
bool at_least(Quad a, Quad b) { return b <= a; }
bool at_least(const Bounded& a, const Bounded& b) {
  const double missing = (b.high - a.high) + (b.low - a.low);
  return missing + 4 * (a.error + b.error) < forgiven(b.high) || surely_at_most(b, a);
}
bool at_least(const Bounded& a, double b) {
  const double least = a.high + (a.low - 4 * a.error);
  return b - least < forgiven(b) || (a.exact() && a.low == 0 && b <= a.high);
}
Quad made_up(Quad error) { return error; }
Bounded made_up(Bounded error) {
  if (std::isfinite(error.high)) error.error += 8 * std::max(kForgiven * error.high, kForgivenError);
  return error;
}

// Numbers that surely are at most or at least x >= 0; 0 and infinity where little is known of it. They put rows in
// order and pass over rows, and never enter a measure: a double does in Bounded arithmetic.
template <class Real>
using Limit = std::conditional_t<std::is_same_v<Real, Quad>, Quad, double>;
Quad lower_limit(Quad x) { return x; }
Quad upper_limit(Quad x) { return x; }
double lower_limit(const Bounded& x) {
  if (x.low == 0 && x.exact()) return x.high;
  const double least = (x.high - 2 * x.error) * (1 - 0x1p-50) - bounded::kLost;
  return least > 0 ? least : 0;
}
double upper_limit(const Bounded& x) {
  if (x.low == 0 && x.exact()) return x.high;
  const double most = (x.high + 2 * x.error) * (1 + 0x1p-50) + bounded::kLost;
  return most >= 0 ? most : kInfinity;
}

// At least the quotient of numbers of which one is at most `value` and the other at least `scale`, but for the rounding
// that at_least() forgives.
Quad limit_of_quotient(Quad value, Quad scale) { return quotient(value, scale); }
double limit_of_quotient(double value, double scale) {
  if (value == 0) return 0;
  const double limit = value / scale;
  return limit > 0 ? limit + bounded::kLost : kInfinity;
}

// The nonzero entries of an island's z in the order in which a growing tau sets them to zero: by their ratio to the
// largest magnitude of their kind.
template <class Real>
class Removal {
 public:
  explicit Removal(const EvaluatedLcp<Real>& lcp) : lambdas_from_(lcp.lambda_offset()) {}

  // Finds the entries; they are put in order when it is first asked for.
  void find(const std::vector<Real>& z, Rows rows) {
    impulse_ = lambda_ = 0;
    ordered_ = false;
    order_.clear();
    for (const std::size_t i : rows) {
      const double magnitude = std::abs(to_double(z[i]));
      if (magnitude == 0) continue;
      double& largest_of_kind = i < lambdas_from_ ? impulse_ : lambda_;
      largest_of_kind = std::max(largest_of_kind, magnitude);
      order_.push_back({magnitude, 0, i});
    }
    for (Entry& entry : order_) entry.rounded = entry.magnitude / largest(entry.index);
  }
  void order() {
    if (!std::exchange(ordered_, true)) std::sort(order_.begin(), order_.end(), Earlier{*this});
  }
  bool is_ordered() const { return ordered_; }
  // Of all entries.
  Real least_ratio() const { return ratio(*std::min_element(order_.begin(), order_.end(), Earlier{*this})); }

  std::size_t size() const { return order_.size(); }
  // Magnitude of either kind.
  double largest() const { return std::max(impulse_, lambda_); }
  std::size_t index(std::size_t place) const { return order_[place].index; }
  // The least tau that sets the entry to zero.
  Real ratio(std::size_t place) const { return ratio(order_[place]); }
  // Behind the last entry of the same ratio.
  std::size_t end_of_ratio(std::size_t place) const {
    std::size_t end = place + 1;
    while (end < size() && compare(order_[place], order_[end]) == 0) ++end;
    return end;
  }

 private:
  struct Entry {
    double magnitude;
    double rounded;  // ratio
    std::size_t index;
  };
  // Divisions that round differently are in the order of the exact ratios.
  struct Earlier {
    const Removal& removal;

    bool operator()(const Entry& a, const Entry& b) const {
      if (a.rounded != b.rounded) return a.rounded < b.rounded;
      const int sign = removal.compare(a, b);
      return sign < 0 || (sign == 0 && a.index < b.index);
    }
  };

  Real ratio(const Entry& entry) const { return Real(entry.magnitude) / Real(largest(entry.index)); }
  double largest(std::size_t index) const { return index < lambdas_from_ ? impulse_ : lambda_; }
  int compare(const Entry& a, const Entry& b) const {
    if (largest(a.index) == largest(b.index)) {
      return a.magnitude < b.magnitude ? -1 : a.magnitude > b.magnitude ? 1 : 0;
    }
    const Quad left = Quad{a.magnitude} * largest(b.index), right = Quad{b.magnitude} * largest(a.index);
    return left < right ? -1 : left > right ? 1 : 0;
  }

  std::size_t lambdas_from_;
  double impulse_ = 0, lambda_ = 0;
  bool ordered_ = false;
  std::vector<Entry> order_;
};

// z_tau of one island after the other for a growing tau, with what is needed to measure it. What is removed from one
// island is never seen by another.
template <class Real>
class ThinningPoint {
 public:
  ThinningPoint(EvaluatedLcp<Real>& lcp, const std::vector<Real>& z, const std::vector<Real>& u,
                const std::vector<Real>& w, BackwardScale scale)
      : lcp_(lcp), scale_(scale), z_(&z), u_(&u), w_(&w), order_(lcp), lambdas_from_(lcp.lambda_offset()) {}
  ThinningPoint(const ThinningPoint&) = delete;
  ThinningPoint& operator=(const ThinningPoint&) = delete;

  // Of the island's errors none matters that is at most `floor`, another island's.
  void enter(Rows island, const Real& floor) {
    island_ = island;
    floor_ = floor;
    order_.find(*z_, island);
    response_of_ = 0;
    indices_.clear();
    indices_.reserve(order_.size());
    impulses_ = 0;
    for (std::size_t place = 0; place < order_.size(); ++place) {
      indices_.push_back(order_.index(place));
      impulses_ += is_impulse(place) ? 1 : 0;
    }
    removed_ = 0;
    weighed_ = false;
  }

  const Real& floor() const { return floor_; }

  // How many entries the least tau sets to zero that leaves no negative one.
  std::size_t least_removals() {
    const auto negative = [this](std::size_t i) { return to_double((*z_)[i]) < 0; };
    if (std::none_of(indices_.begin(), indices_.end(), negative)) return 0;
    put_in_order();
    for (std::size_t place = order_.size(); place-- > 0;) {
      if (negative(order_.index(place))) return order_.end_of_ratio(place);
    }
    return 0;
  }
  // The same for the next tau at which z_tau changes; nothing when all is zero.
  std::optional<std::size_t> next_removals() {
    if (removed_ == order_.size()) return std::nullopt;
    put_in_order();
    return order_.end_of_ratio(removed_);
  }
  // Whether no tau that changes z_tau is less than `error`, where this shows without the order of the entries.
  bool none_is_below(const Real& error) const {
    return order_.size() > 0 && !order_.is_ordered() && at_least(order_.least_ratio(), error);
  }
  // The least tau that removes so many.
  Real tau(std::size_t removals) const { return removals == 0 ? Real(0) : order_.ratio(removals - 1); }

  void remove(std::size_t removals) {
    if (removals > removed_) own();
    for (std::size_t place = removed_; place < removals; ++place) {
      const std::size_t i = order_.index(place);
      lcp_.remove(i, own_z_[i], own_u_);
      own_z_[i] = 0;
    }
    set_removed(removals);
  }

  // Finds the response to z_tau anew. True when it was the corrected one, which keeps the errors of what was removed.
  bool refresh_response() {
    const bool corrected = response_of_ != removed_;
    if (corrected) lcp_.respond(island_, own_z_, own_u_);
    response_of_ = removed_;
    return corrected;
  }

  // The entry of largest ratio among those set to zero.
  std::optional<std::size_t> last_removed() const {
    if (removed_ == 0) return std::nullopt;
    return order_.index(removed_ - 1);
  }

  Real violation(std::size_t i) const { return violation(i, lcp_.row(i, *z_, *u_)); }
  // The nonzero entries, smallest ratio first.
  std::span<const std::size_t> support() const { return std::span(indices_).subspan(removed_); }

  // eta(z_tau), or a number that is at most floor() where eta is. Rows are measured in the order of an upper bound of
  // their quotients until the bound settles the rest. A row's first bound is by least_scale(), unless estimates
  // of M come first: any other costs a solve with G. Infinity, and the row, where a row shows it to be no better than
  // `best`: in 113 bits no such thing is looked for.
  BackwardError<Real> eta(const Real& best) {
    const Limit<Real> enough = std::is_same_v<Real, Quad> ? kInfinity : upper_limit(best) * (1 + 0x1p-50);
    if (removed_ > 0) lcp_.fill_rows(island_, own_z_, own_u_, own_w_);
    rows_.clear();
    const bool at_once = std::is_same_v<Real, Quad> && estimated();
    for (const std::size_t i : island_) {
      const Real& w_i = (*w_)[i];
      if (positive(i) ? surely_equal(w_i, 0) : surely_less(0, w_i)) continue;
      const Real violation_i = violation(i, w_i);
      if (surely_equal(violation_i, 0)) continue;
      const Bounds scale = at_once ? scale_bounds(i) : Bounds{least_scale(i), kInfinity};
      rows_.push_back({limit_of_quotient(upper_limit(violation_i), scale.low), violation_i, i, scale.high, at_once});
    }
    const auto comes_later = [](const Row& a, const Row& b) {
      return a.limit < b.limit || (a.limit == b.limit && a.index > b.index);
    };
    std::make_heap(rows_.begin(), rows_.end(), comes_later);
    BackwardError<Real> eta;
    while (!rows_.empty() && !at_least(larger(floor_, eta.error), rows_.front().limit)) {
      std::pop_heap(rows_.begin(), rows_.end(), comes_later);
      Row& row = rows_.back();
      if (!row.bounded) {
        const Bounds scale = scale_bounds(row.index);
        if (lower_limit(row.violation) > enough * scale.high) return {kInfinity, row.index};
        row.limit = limit_of_quotient(upper_limit(row.violation), scale.low);
        row.most_scale = scale.high;
        row.bounded = true;
        std::push_heap(rows_.begin(), rows_.end(), comes_later);
        continue;
      }
      const std::optional<Real> small = small_error(row);
      const Real error = small ? *small : row_error(row.index, row.violation);
      const std::size_t index = row.index;
      rows_.pop_back();
      if (std::isnan(to_double(error))) {
        eta.open = true;
        continue;
      }
      if (leading(error) > leading(eta.error)) eta.row = index;
      eta.error = larger(eta.error, error);
      if (std::is_same_v<Real, Bounded> && std::isfinite(to_double(best)) && at_least(error, best)) {
        return {kInfinity, index};
      }
    }
    return eta;
  }

  // Whether s_i is estimated: while few entries are left, s_i itself costs less in 113 bits.
  bool estimated() const {
    if (std::is_same_v<Real, Bounded>) return true;
    constexpr std::ptrdiff_t kFew = 64;
    return scale_ == BackwardScale::kRowNorm ? std::ssize(support()) > kFew : impulses_ > kFew;
  }

  // A lower bound of s_i that takes no solve with G.
  Limit<Real> least_scale(std::size_t i) {
    if constexpr (std::is_same_v<Real, Quad>) {
      return lower_limit(abs(lcp_.q(i)));
    } else {
      return plain_bounds(i).low;
    }
  }

  struct Bounds {
    Limit<Real> low = 0;
    Limit<Real> high = kInfinity;
  };

  // Bounds of s_i.
  Bounds scale_bounds(std::size_t i) {
    const Real q = abs(lcp_.q(i));
    if constexpr (std::is_same_v<Real, Bounded>) {
      if (i >= lcp_.lambda_offset() || (scale_ == BackwardScale::kComponentwise && impulses_ == 0)) {
        return plain_bounds(i);  // the row has no other entries, or they meet zeros
      }
    }
    const MagnitudeEstimate::Row* const row = estimated() ? lcp_.estimated_row(i) : nullptr;
    if (row == nullptr) {
      const Real weight = least_weight(i);
      return {lower_limit(surely_equal(weight, 0) ? q : q + abs(lcp_.diagonal(i)) * weight), kInfinity};
    }
    const auto [sum, error] = estimated_scale(*row);
    Bounds bounds{lower_limit(q), kInfinity};
    if (std::isfinite(sum) && std::isfinite(error)) {
      // Of the sums, and of the four operations that follow.
      const double rounding = static_cast<double>(lcp_.size() + 8) * 0x1p-52;
      const Limit<Real> least = sum * (1 - rounding) - error;
      if (least > 0) bounds.low = (bounds.low + least) * (1 - 0x1p-51);
      bounds.high = (upper_limit(q) + sum * (1 + rounding) + error) * (1 + 0x1p-51);
    }
    return bounds;
  }

  // Bounds of |q_i| and of what the entries of M that are in the data add to it.
  Bounds plain_bounds(std::size_t i) {
    const Real q = abs(lcp_.q(i));
    const double moved =
        scale_ == BackwardScale::kComponentwise ? lcp_.plain_row_times(i, *z_) : lcp_.plain_row_sum(i) * z_norm();
    const double rounding = static_cast<double>(lcp_.size() + 8) * 0x1p-52;
    return {(lower_limit(q) + moved * (1 - rounding)) * (1 - 0x1p-50),
            (upper_limit(q) + moved * (1 + rounding)) * (1 + 0x1p-50) + bounded::kLost};
  }

  // Violations of the island's rows, in double and without a bound on their error.
  std::vector<double> estimated_violations() const {
    std::vector<double> violations = lcp_.estimate_w(*z_, *u_, island_);
    for (const std::size_t i : island_) {
      violations[i] = positive(i) ? std::abs(violations[i]) : std::max(0.0, -violations[i]);
    }
    return violations;
  }

  // s_i
  Real scale(std::size_t i) { return abs(lcp_.q(i)) + coupling(i); }

 private:
  void put_in_order() {
    if (order_.is_ordered()) return;
    order_.order();
    for (std::size_t place = 0; place < order_.size(); ++place) indices_[place] = order_.index(place);
  }

  // s_i less |q_i|
  Real coupling(std::size_t i) {
    if (scale_ == BackwardScale::kComponentwise) return lcp_.abs_row_times(i, *z_, support());
    return z_norm() > 0 ? lcp_.abs_row_sum(i) * Real(z_norm()) : Real(0);
  }

  // Of a row that no entry of z_tau moves w_i is q_i, which is violated by all of it or not at all.
  Real row_error(std::size_t i, const Real& violation_i) {
    const Real moved = coupling(i);
    if (surely_equal(moved, 0) && surely_less(lcp_.q(i), 0)) return 1;
    return quotient(violation_i, abs(lcp_.q(i)) + moved);
  }

  bool positive(std::size_t i) const { return to_double((*z_)[i]) > 0; }
  Real violation(std::size_t i, const Real& w) const { return positive(i) ? abs(w) : larger(Real(0), -w); }

  // Copies what was given, before the first change of it.
  void own() {
    if (z_ == &own_z_) return;
    own_z_ = *std::exchange(z_, &own_z_);
    own_u_ = *std::exchange(u_, &own_u_);
    own_w_ = *std::exchange(w_, &own_w_);
  }

  void set_removed(std::size_t removed) {
    for (std::size_t place = removed_; place < removed; ++place) impulses_ -= is_impulse(place) ? 1 : 0;
    removed_ = removed;
    weighed_ = false;
  }

  bool is_impulse(std::size_t place) const { return order_.index(place) < lambdas_from_; }

  // The largest entries of both kinds are set to zero together, and last.
  double z_norm() const { return removed_ < order_.size() ? order_.largest() : 0; }

  // A lower bound of the factor of |M_ii| in s_i.
  Real least_weight(std::size_t i) { return scale_ == BackwardScale::kComponentwise ? (*z_)[i] : Real(z_norm()); }

  struct Estimate {
    double sum = 0;
    double error = 0;
  };

  // s_i less |q_i|, but for the rounding of the sums.
  Estimate estimated_scale(const MagnitudeEstimate::Row& row) {
    if (!weighed_) weigh();
    const double error = 2 * row.error * error_weight_;
    if (scale_ == BackwardScale::kRowNorm) return {row.sum * z_norm(), error * z_norm()};
    const MagnitudeEstimate& estimate = lcp_.estimate();
    double sum = 0;
    for (std::size_t e = row.begin; e < row.end; ++e) sum += estimate.entries[e] * weights_[estimate.columns[e]];
    return {sum, error};
  }

  // The island's z_tau in double, summed over the columns of the same magnitudes.
  void weigh() {
    weights_.resize(z_->size());
    for (const std::size_t j : island_) weights_[j] = 0;
    error_weight_ = 0;
    for (const std::size_t j : island_) {
      const double z = to_double((*z_)[j]);
      weights_[lcp_.representative(j)] += z;
      error_weight_ += lcp_.estimate().column_scale[j] * (scale_ == BackwardScale::kRowNorm ? 1 : z);
    }
    weighed_ = true;
  }

  struct Row {
    Limit<Real> limit;  // of its quotient
    Real violation;
    std::size_t index;
    Limit<Real> most_scale;
    bool bounded;  // limit is by scale_bounds(), and not by least_scale()
  };

  // The row's quotient, where bounds of s_i leave no more than kForgivenError of it open.
  static std::optional<Real> small_error(const Row& row) {
    if constexpr (std::is_same_v<Real, Bounded>) {
      const double least = lower_limit(row.violation) / row.most_scale;
      const double open = row.limit - least;
      if (open <= kForgivenError) return Bounded(least + open / 2, 0, open + 0x1p-50 * row.limit);
    }
    return std::nullopt;
  }

  EvaluatedLcp<Real>& lcp_;
  BackwardScale scale_;
  const std::vector<Real>*z_, *u_;  // as given, or as removals left them
  const std::vector<Real>* w_;      // of the island's rows, as given or as eta() last found them
  std::vector<Real> own_z_, own_u_, own_w_;
  Rows island_;
  Real floor_ = 0;
  Removal<Real> order_;
  std::size_t lambdas_from_;
  std::vector<std::size_t> indices_;  // of order_
  std::size_t removed_ = 0;
  std::ptrdiff_t impulses_ = 0;  // that are not removed
  std::size_t response_of_ = 0;  // the removals for which u_ was found, and not corrected
  bool weighed_ = false;
  std::vector<double> weights_;  // of the island's representative columns in s_i
  double error_weight_ = 0;      // sum of column_scale times the weight of the column in s_i
  std::vector<Row> rows_;        // scratch of eta()
};

// A row that alone shows the present z_tau to be no better than the best error found. Removing entries only lowers s_i,
// so the scale that was found with it bounds all later ones.
template <class Real>
struct Witness {
  std::size_t row = 0;
  Real scale = 0;

  bool refutes(ThinningPoint<Real>& point, const Real& best) {
    const Real violation = point.violation(row);
    if (surely_equal(violation, 0)) return false;
    if (at_least(quotient(violation, scale), best)) return true;
    scale = smaller(scale, Real(point.scale_bounds(row).high));
    if (at_least(quotient(violation, scale), best)) return true;
    scale = point.scale(row);
    return at_least(quotient(violation, scale), best);
  }
};

// Looks for a witness among the rows whose entry stays in z the longest.
template <class Real>
std::optional<Witness<Real>> find_witness(ThinningPoint<Real>& point, const Real& best) {
  constexpr int kAttempts = 4;
  constexpr double kSlack = 1 - 1e-9;  // a row that only equals the best error still refutes
  const bool estimated = point.estimated();
  const std::vector<double> violations = estimated ? point.estimated_violations() : std::vector<double>{};
  const std::span<const std::size_t> support = point.support();
  const auto enough = leading(best * Real(kSlack));
  int attempts = 0;
  for (auto i = support.rbegin(); i != support.rend() && attempts < kAttempts; ++i) {
    if (estimated && limit_of_quotient(Limit<Real>(violations[*i]), point.scale_bounds(*i).low) < enough) {
      continue;
    }
    ++attempts;
    Witness<Real> witness{*i, kInfinity};
    if (witness.refutes(point, best)) return witness;
  }
  return std::nullopt;
}

// That the errors are known well enough to go on, and that what is left open of the last one cannot matter.
// @throws Doubt
void demand_minimum(const BackwardError<Quad>&, Quad, bool) {}
void demand_minimum(const BackwardError<Bounded>& best, const Bounded& error, bool open) {
  if (std::isnan(error.high) || (open && !at_least(error, best.error))) throw Doubt();
}

// Whether the error is known as well as one that is passed on. None is larger than 1, but by what removals left behind.
bool is_known(const BackwardError<Quad>& eta) { return eta.error <= 1 + 0x1p-50; }
bool is_known(const BackwardError<Bounded>& eta) {
  return !eta.open && (eta.error.exact() || 2 * eta.error.error <= kSettled * std::abs(eta.error.high));
}

// Of z_tau, from which so many entries are removed. That of zero is 1, as tau is, and a row is then violated by all of
// q_i or not at all: no bound on the rounding is needed to see it.
template <class Real>
BackwardError<Real> error_at(ThinningPoint<Real>& point, std::size_t removals, const Real& best) {
  if constexpr (std::is_same_v<Real, Bounded>) {
    if (removals > 0 && !point.next_removals()) return {1.0, point.last_removed()};
  }
  BackwardError<Real> eta = point.eta(best);
  if (!is_known(eta) && point.refresh_response()) eta = point.eta(best);
  const Real tau = point.tau(removals);
  if (leading(tau) > leading(eta.error)) eta.row = point.last_removed();
  eta.error = larger(eta.error, tau);
  return eta;
}

// Of the island that the point has entered; or a number that is at most its floor where the error is.
template <class Real>
BackwardError<Real> island_error(ThinningPoint<Real>& point) {
  std::optional<std::size_t> removals = point.least_removals();
  std::optional<Witness<Real>> witness;
  BackwardError<Real> best{kInfinity, std::nullopt};
  while (removals && !at_least(point.tau(*removals), best.error)) {
    point.remove(*removals);
    const bool improving = surely_less(best.error, Real(kInfinity));
    if (improving && !(witness && witness->refutes(point, best.error))) {
      witness = find_witness(point, best.error);
    }
    if (!witness) {
      const BackwardError<Real> found = error_at(point, *removals, best.error);
      if (improving && found.row && surely_equal(found.error, kInfinity))
        witness = Witness<Real>{*found.row, kInfinity};
      demand_minimum(best, found.error, found.open);
      if (leading(found.error) < leading(best.error)) best.row = found.row;
      best.error = smaller(best.error, found.error);
      if (!found.open && at_least(point.floor(), found.error)) break;
    }
    if (point.none_is_below(best.error)) break;
    removals = point.next_removals();
  }
  best.error = made_up(best.error);
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

template <class Real>
BackwardError<Real> mixed_backward_error(EvaluatedLcp<Real>& lcp, const std::vector<Real>& z,
                                         const std::vector<Real>& u, const std::vector<Real>& w, BackwardScale scale,
                                         const IslandRows& islands) {
  ThinningPoint<Real> point(lcp, z, u, w, scale);
  BackwardError<Real> worst;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    point.enter(islands.rows(island), worst.error);
    const BackwardError<Real> error = island_error(point);
    if (leading(error.error) > leading(worst.error)) worst.row = error.row;
    worst.error = larger(worst.error, error.error);
  }
  return worst;
}

template BackwardError<Quad> mixed_backward_error(QuadLcp&, const QuadVector&, const QuadVector&, const QuadVector&,
                                                  BackwardScale, const IslandRows&);
template BackwardError<Bounded> mixed_backward_error(EvaluatedLcp<Bounded>&, const BoundedVector&, const BoundedVector&,
                                                     const BoundedVector&, BackwardScale, const IslandRows&);

}  // namespace lcpbench
