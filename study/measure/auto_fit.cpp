#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "core/error.h"
#include "native/auto/methods.h"
#include "study/measure/auto_table.h"
#include "study/statistics/statistics.h"

namespace lcpbench::testing {
namespace {

/// Work of a method that did not reach the residual, over what it did.
constexpr double kPenalty = 4;
/// Of the squared coefficients, for each row of the table; features are of the order of 10.
constexpr double kRidge = 1e-2;

template <std::size_t kCount>
std::array<double, kCount> least_squares(const Matrix& rows, const Vector& values) {
  const Index count = static_cast<Index>(kCount);
  Matrix normal = rows.leftCols(count).transpose() * rows.leftCols(count);
  normal.diagonal().array() += kRidge * static_cast<double>(std::max<Index>(rows.rows(), 1));
  const Vector solution = normal.ldlt().solve(rows.leftCols(count).transpose() * values);
  std::array<double, kCount> row{};
  // Three digits are far more than the fit knows, and the same with every compiler.
  for (std::size_t k = 0; k < kCount; ++k) row[k] = std::round(1000 * solution(static_cast<Index>(k))) / 1000;
  return row;
}

/// The median of nanoseconds over work, of solves whose time the clock knows.
double weight_of(const std::vector<const MeasuredCost*>& costs) {
  constexpr double kLeastNs = 1e4;
  std::vector<double> weights;
  for (const MeasuredCost* cost : costs) {
    if (cost->solve_ns >= kLeastNs && cost->work > 0) weights.push_back(cost->solve_ns / cost->work);
  }
  if (weights.empty()) return 1;
  return std::round(1000 * spread(weights).median) / 1000;
}

std::string text_of(const char* name, const prediction::Row& row) {
  std::string text = std::string("inline constexpr Row ") + name + "{";
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%.3f, {", row.weight);
  text += number.data();
  const auto add = [&](const auto& values) {
    if (values == std::remove_cvref_t<decltype(values)>{}) return;
    for (std::size_t k = 0; k < values.size(); ++k) {
      std::snprintf(number.data(), number.size(), "%s%.3f", k == 0 ? "" : ", ", values[k]);
      text += number.data();
    }
  };
  add(row.load);
  text += "},\n    {";
  add(row.solve);
  return text + "}};\n";
}

}  // namespace

std::vector<MeasuredCost> read_costs(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw InputError(path + ": cannot be read");
  std::string line;
  std::getline(file, line);  // the names of the columns
  std::vector<MeasuredCost> costs;
  for (int number = 2; std::getline(file, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    MeasuredCost cost;
    long trial = 0;
    int method = 0;
    words >> cost.set >> trial >> method >> cost.frictional >> cost.load_ns;
    cost.features[static_cast<std::size_t>(Feature::kOne)] = 1;
    for (std::size_t k = 1; k + 1 < kFeatures; ++k) words >> cost.features[k];
    const bool is_known = words && method >= 0 && method < static_cast<int>(kAutoMethods);
    if (is_known) cost.method = static_cast<AutoMethod>(method);
    for (const double digits : kDigits) {
      const bool is_next = digits == kDigits.front() || !Methods::is_dense(cost.method);
      if (is_next) words >> cost.work >> cost.solve_ns >> cost.reached;
      if (!is_known || !words) {
        throw InputError(path + ": line " + std::to_string(number) + " is no row of measured costs");
      }
      cost.features[static_cast<std::size_t>(Feature::kDigits)] = digits;
      costs.push_back(cost);
    }
  }
  return costs;
}

prediction::Row fit_row(const std::vector<MeasuredCost>& costs, AutoMethod method, bool frictional) {
  std::vector<const MeasuredCost*> own;
  for (const MeasuredCost& cost : costs) {
    if (cost.method == method && cost.frictional == frictional) own.push_back(&cost);
  }
  const double weight = weight_of(own);
  const Index count = static_cast<Index>(own.size());
  Matrix rows(count, static_cast<Index>(kFeatures));
  Vector load(count), solve(count);
  for (Index i = 0; i < count; ++i) {
    const MeasuredCost& cost = *own[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < kFeatures; ++k) rows(i, static_cast<Index>(k)) = cost.features[k];
    load(i) = std::log2(std::max(cost.load_ns, 1.0));
    solve(i) = std::log2(std::max((cost.reached ? weight : kPenalty * weight) * cost.work, 1.0));
  }
  prediction::Row row{weight, {}, least_squares<kFeatures>(rows, solve)};
  if (!Methods::is_dense(method)) row.load = least_squares<kSizes>(rows, load);
  return row;
}

std::string rows_text(const std::vector<MeasuredCost>& costs) {
  using enum AutoMethod;
  return text_of("kContactLemke", fit_row(costs, kContactLemke, true)) +
         text_of("kFrictionIpm", fit_row(costs, kFrictionIpm, true)) + text_of("kPsor", fit_row(costs, kPsor, true)) +
         text_of("kActiveSet", fit_row(costs, kActiveSet, false)) +
         text_of("kVelocityIpm", fit_row(costs, kVelocityIpm, false)) +
         text_of("kSweeps", fit_row(costs, kPsor, false));
}

}  // namespace lcpbench::testing
