#include "study/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace lcpbench {

namespace {

double sum(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }

double sample_sigma(std::span<const double> values, double mean) {
  if (values.size() < 2) return kNoNumber;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

std::vector<double> sorted_copy(std::span<const double> values) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace

Interval wilson(std::int64_t successes, std::int64_t trials, double quantile) {
  if (successes < 0 || successes > trials) throw std::invalid_argument("wilson: successes must lie in 0 .. trials");
  const auto n = static_cast<double>(trials);
  return wilson_of_share(static_cast<double>(successes) / n, n, quantile);
}

Interval wilson_of_share(double share, double trials, double quantile) {
  if (!(trials > 0)) return {kNoNumber, kNoNumber};
  const double z2_n = quantile * quantile / trials;
  const double centre = share + z2_n / 2;
  const double half = quantile * std::sqrt(share * (1 - share) / trials + z2_n / (4 * trials));
  const double scale = 1 + z2_n;
  // The exact ends at shares of 0 and 1, which rounding would miss by an ulp.
  return {share <= 0 ? 0.0 : (centre - half) / scale, share >= 1 ? 1.0 : (centre + half) / scale};
}

double normal_quantile(double alpha) {
  double low = 0;
  double high = 40;  // erfc underflows before
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (std::erfc(middle / std::sqrt(2.0)) > alpha ? low : high) = middle;
  }
  return low;
}

Estimate combination_of_shares(std::span<const double> terms, double quantile) {
  if (terms.empty() || terms.size() % 3 != 0)
    throw std::invalid_argument("combination_of_shares: three numbers a term");
  double value = 0;
  double below = 0;
  double above = 0;
  for (std::size_t i = 0; i < terms.size(); i += 3) {
    const double share = terms[i + 2] > 0 ? terms[i + 1] : kNoNumber;
    const Interval range = wilson_of_share(share, terms[i + 2], quantile);
    const double down = terms[i] * (share - (terms[i] > 0 ? range.low : range.high));
    const double up = terms[i] * ((terms[i] > 0 ? range.high : range.low) - share);
    value += terms[i] * share;
    below += down * down;
    above += up * up;
  }
  return {value, value - std::sqrt(below), value + std::sqrt(above)};
}

Estimate ratio_of_means(std::span<const double, 6> terms, double quantile) {
  double variance = 0;  // of the logarithm
  for (std::size_t i = 0; i < 6; i += 3) {
    const double relative = terms[i + 1] / terms[i];
    if (!(terms[i] > 0 && terms[i + 2] > 1 && std::isfinite(relative))) return {kNoNumber, kNoNumber, kNoNumber};
    variance += relative * relative / terms[i + 2];
  }
  const double ratio = terms[0] / terms[3];
  const double factor = std::exp(quantile * std::sqrt(variance));
  return {ratio, ratio / factor, ratio * factor};
}

Estimate paired_difference(double problems, double only_first, double only_second, double quantile) {
  if (!(problems > 0)) return {kNoNumber, kNoNumber, kNoNumber};
  const double n = problems + 2;
  const double difference = only_first - only_second;
  const double half = quantile / n * std::sqrt(only_first + only_second + 1 - difference * difference / n);
  return {difference / problems, std::max(-1.0, difference / n - half), std::min(1.0, difference / n + half)};
}

double quantile(std::span<const double> sorted, double p) {
  if (sorted.empty()) return kNoNumber;
  const auto n = static_cast<double>(sorted.size());
  // p n can be a whole number and round above it: 0.07 * 700 gives 49.00000000000001.
  const double rank = std::clamp(std::ceil(p * n * (1 - 1e-12)), 1.0, n);
  return sorted[static_cast<std::size_t>(rank) - 1];
}

double median(std::span<const double> sorted) {
  if (sorted.empty()) return kNoNumber;
  const double lower = sorted[(sorted.size() - 1) / 2];
  const double upper = sorted[sorted.size() / 2];
  return std::midpoint(lower, upper);
}

Spread spread_of_sorted(std::span<const double> sorted) {
  if (sorted.empty()) return {0, kNoNumber, kNoNumber, kNoNumber, kNoNumber};
  const double mean = sum(sorted) / static_cast<double>(sorted.size());
  return {static_cast<std::int64_t>(sorted.size()), mean, sample_sigma(sorted, mean), sorted.back(), median(sorted)};
}

Spread spread(std::span<const double> values) { return spread_of_sorted(sorted_copy(values)); }

Estimate median_estimate(std::span<const double> values) {
  const std::vector<double> sorted = sorted_copy(values);
  if (sorted.size() < 6) return {median(sorted), kNoNumber, kNoNumber};  // 1 - 2 / 2^5 is below 95 %
  const auto n = static_cast<double>(sorted.size());
  const auto rank = static_cast<std::size_t>((n + 1 - kNormal975 * std::sqrt(n)) / 2);
  return {median(sorted), sorted[rank - 1], sorted[sorted.size() - rank]};
}

Estimate ratio_of_sums(std::span<const double> numerator, std::span<const double> denominator) {
  if (numerator.size() != denominator.size()) throw std::invalid_argument("ratio_of_sums: times must come in pairs");
  const double above = sum(numerator);
  const double below = sum(denominator);
  if (!(above > 0 && below > 0)) return {kNoNumber, kNoNumber, kNoNumber};
  const double ratio = above / below;
  if (numerator.size() == 1) return {ratio, kNoNumber, kNoNumber};
  const auto n = static_cast<double>(numerator.size());
  double squares = 0;  // of what each pair moves the logarithm of the ratio by
  for (std::size_t i = 0; i < numerator.size(); ++i) {
    const double moved = numerator[i] / above - denominator[i] / below;
    squares += moved * moved;
  }
  const double factor = std::exp(kNormal975 * std::sqrt(squares * n / (n - 1)));
  return {ratio, ratio / factor, ratio * factor};
}

bool is_tie_in_time(const Estimate& ratio) {
  const bool within_noise = ratio.value < kTieInTime && ratio.value > 1 / kTieInTime;
  return within_noise || (ratio.low <= 1 && ratio.high >= 1);
}

double mcnemar_exact(std::int64_t only_first, std::int64_t only_second) {
  if (only_first < 0 || only_second < 0) throw std::invalid_argument("mcnemar_exact: counts must not be negative");
  // The sign test: the chance that a fair coin splits so many tosses at least this unevenly.
  const std::int64_t tosses = only_first + only_second;
  const std::int64_t fewer = std::min(only_first, only_second);
  // Sum of C(tosses, k) / 2^tosses for k <= fewer, each term from the one before, in logarithms against underflow.
  double log_term = -static_cast<double>(tosses) * std::log(2.0);
  double tail = 0;
  for (std::int64_t k = 0; k <= fewer; ++k) {
    tail += std::exp(log_term);
    log_term += std::log(static_cast<double>(tosses - k)) - std::log(static_cast<double>(k + 1));
  }
  return std::min(1.0, 2 * tail);
}

void LogSums::add(double logarithm) {
  ++n;
  sum += logarithm;
  square_sum += logarithm * logarithm;
}

LogSums& LogSums::operator+=(const LogSums& other) {
  n += other.n;
  sum += other.sum;
  square_sum += other.square_sum;
  return *this;
}

Estimate LogSums::geometric_mean() const {
  if (n == 0) return {kNoNumber, kNoNumber, kNoNumber};
  const auto count = static_cast<double>(n);
  const double mean = sum / count;
  if (n == 1) return {std::exp(mean), kNoNumber, kNoNumber};
  const double variance = std::max(0.0, (square_sum - sum * mean) / (count - 1));
  const double half = kNormal975 * std::sqrt(variance / count);
  return {std::exp(mean), std::exp(mean - half), std::exp(mean + half)};
}

}  // namespace lcpbench
