#include "study/paper/intervals.h"

#include <algorithm>
#include <cmath>

namespace lcpbench::paper {

namespace {

bool holds_values(const Mean& mean) {
  return mean.problems > 1 && mean.mean > 0 && std::isfinite(mean.sigma);
}

/// (standard error of the mean / mean)^2
double relative_variance(const Mean& mean) {
  const double ratio = mean.sigma / mean.mean;
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
  return holds_values(numerator) && holds_values(denominator) ? numerator.mean / denominator.mean : kNoNumber;
}

Interval RatioOfMeans::interval(double z) const {
  const double factor = std::exp(z * std::sqrt(relative_variance(numerator) + relative_variance(denominator)));
  return {value() / factor, value() * factor};
}

double PairedShares::value() const { return problems > 0 ? (only_first - only_second) / problems : kNoNumber; }

Interval PairedShares::interval(double z) const {
  if (!(problems > 0)) return {kNoNumber, kNoNumber};
  const double n = problems + 2;
  const double sum = only_first + only_second + 1;
  const double difference = only_first - only_second;
  const double half = z / n * std::sqrt(sum - difference * difference / n);
  return {std::max(-1.0, difference / n - half), std::min(1.0, difference / n + half)};
}

}  // namespace lcpbench::paper
