#include "native/auto/prediction.h"

#include <algorithm>
#include <cmath>

#include "native/active_set/active_set.h"
#include "native/auto/prediction_table.h"
#include "native/contact_lemke/contact_lemke.h"

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

Entrant predict(AutoMethod method, const Problem& problem, const Features& features) {
  const prediction::Row& row = prediction::row_of(method, problem.contact()->frictional());
  const bool is_dense = method == AutoMethod::kContactLemke || method == AutoMethod::kActiveSet;
  const double load = method == AutoMethod::kContactLemke ? row.weight * ContactLemke::load_work(problem)
                      : is_dense                          ? row.weight * ActiveSet::load_work(problem)
                                                          : power_of_sum(row.load, features);
  return {.cost = load + power_of_sum(row.solve, features),
          .load_cost = load,
          .weight = row.weight,
          .converges = !is_dense,
          .learns = method == AutoMethod::kPsor};
}

}  // namespace lcpbench
