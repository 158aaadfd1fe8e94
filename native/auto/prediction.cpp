#include "native/auto/prediction.h"

#include <algorithm>
#include <cmath>

#include "native/auto/prediction_table.h"

namespace lcpbench {
namespace {

constexpr double kLargestLog = 60;

/// 2 to the power of the row's sum; linear between powers of two, as the logarithms.
template <std::size_t kCount>
double power_of_sum(const std::array<double, kCount>& row, const Features& features) {
  double sum = 0;
  for (std::size_t k = 0; k < kCount; ++k) sum += row[k] * features.values()[k];
  sum = std::clamp(sum, 0.0, kLargestLog);
  const double whole = std::floor(sum);
  return std::ldexp(1 + (sum - whole), static_cast<int>(whole));
}

}  // namespace

Entrant predict(AutoMethod method, bool frictional, const Features& features) {
  const prediction::Row& row = prediction::row_of(method, frictional);
  const double load = power_of_sum(row.load, features);
  return {.cost = load + power_of_sum(row.solve, features),
          .load_cost = load,
          .weight = row.weight,
          .learns = method == AutoMethod::kPsor};
}

}  // namespace lcpbench
