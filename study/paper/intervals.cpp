#include "study/paper/intervals.h"

#include <algorithm>
#include <cmath>

namespace lcpbench::paper {

namespace {

bool holds_values(const PooledMean& mean) {
  return mean.problems > 1 && mean.values.mean > 0 && std::isfinite(mean.values.sigma);
}

/// (standard error of the mean / mean)^2
double relative_variance(const PooledMean& mean) {
  const double ratio = mean.values.sigma / mean.values.mean;
  return ratio * ratio / mean.problems;
}

}  // namespace

double normal_quantile(double alpha) {
  double low = 0;
  double high = 40;  // erfc underflows before
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (std::erfc(middle / std::sqrt(2.0)) > alpha ? low : high) = middle;
  }
  return low;
}

double Proportion::value() const { return trials > 0 ? successes / trials : kNoNumber; }

Interval Proportion::interval(double z) const {
  if (!(trials > 0)) return {kNoNumber, kNoNumber};
  const double p = value();
  const double z2 = z * z;
  const double centre = (successes + z2 / 2) / (trials + z2);
  const double half = z / (trials + z2) * std::sqrt(trials * p * (1 - p) + z2 / 4);
  return {successes <= 0 ? 0 : std::max(0.0, centre - half), successes >= trials ? 1 : std::min(1.0, centre + half)};
}

double LinearCombination::value() const {
  double sum = 0;
  for (const Term& term : terms) sum += term.coefficient * term.share.value();
  return sum;
}

Interval LinearCombination::interval(double z) const {
  double below = 0;
  double above = 0;
  for (const auto& [coefficient, share] : terms) {
    const Interval range = share.interval(z);
    const double down = coefficient * (share.value() - (coefficient > 0 ? range.low : range.high));
    const double up = coefficient * ((coefficient > 0 ? range.high : range.low) - share.value());
    below += down * down;
    above += up * up;
  }
  return {value() - std::sqrt(below), value() + std::sqrt(above)};
}

LinearCombination difference(const Proportion& first, const Proportion& second) { return {{{1, first}, {-1, second}}}; }

double RatioOfMeans::value() const {
  return holds_values(numerator) && holds_values(denominator) ? numerator.values.mean / denominator.values.mean
                                                              : kNoNumber;
}

Interval RatioOfMeans::interval(double z) const {
  const double factor = std::exp(z * std::sqrt(relative_variance(numerator) + relative_variance(denominator)));
  return {value() / factor, value() * factor};
}

Spread pooled(const std::vector<Spread>& parts) {
  Spread whole{0, kNoNumber, kNoNumber, kNoNumber, kNoNumber};
  double sum = 0;
  for (const Spread& part : parts) {
    if (part.count == 0) continue;
    whole.count += part.count;
    sum += static_cast<double>(part.count) * part.mean;
    whole.max = std::isnan(whole.max) ? part.max : std::max(whole.max, part.max);
  }
  if (whole.count == 0) return whole;
  whole.mean = sum / static_cast<double>(whole.count);
  double squares = 0;
  for (const Spread& part : parts) {
    if (part.count == 0) continue;
    const double distance = part.mean - whole.mean;
    squares += static_cast<double>(part.count) * distance * distance;
    if (part.count > 1) squares += static_cast<double>(part.count - 1) * part.sigma * part.sigma;
  }
  if (whole.count > 1) whole.sigma = std::sqrt(squares / static_cast<double>(whole.count - 1));
  return whole;
}

PooledMean pooled_mean(const std::vector<Spread>& parts) {
  const auto holding = std::count_if(parts.begin(), parts.end(), [](const Spread& part) { return part.count > 0; });
  const Spread values = pooled(parts);
  return {values, holding > 0 ? static_cast<double>(values.count) / static_cast<double>(holding) : 0};
}

double PairedShares::value() const {
  return problems() > 0 ? static_cast<double>(only_first - only_second) / static_cast<double>(problems()) : kNoNumber;
}

Interval PairedShares::interval(double z) const {
  if (problems() == 0) return {kNoNumber, kNoNumber};
  const double n = static_cast<double>(problems()) + 2;
  const double first = static_cast<double>(only_first) + 0.5;
  const double second = static_cast<double>(only_second) + 0.5;
  const double centre = (first - second) / n;
  const double half = z / n * std::sqrt(first + second - (first - second) * (first - second) / n);
  return {std::max(-1.0, centre - half), std::min(1.0, centre + half)};
}

}  // namespace lcpbench::paper
