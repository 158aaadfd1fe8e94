#pragma once

#include <array>
#include <string>
#include <vector>

#include "native/auto/prediction.h"

namespace lcpbench::testing {

/// Of the residuals that methods are measured to.
inline constexpr std::array<double, 4> kDigits{2, 4, 6, 9};

/// What one method took for one problem to one residual.
struct MeasuredCost {
  std::string set;  ///< without its options
  AutoMethod method{};
  bool frictional = false;
  std::array<double, kFeatures> features{};
  double load_ns = 0, work = 0, solve_ns = 0;
  bool reached = false;  ///< false: `work` is what it had done when it gave up or was stopped
};

/// The rows of a file that `auto_table measure` wrote. What a dense method took, which knows no error, stands for all
/// digits. @throws InputError naming the line
std::vector<MeasuredCost> read_costs(const std::string& path);

/// The table's row for a method: linear least squares on the logarithms, with a small ridge. A method that did not
/// reach the residual counts as if it had taken four times what it did.
prediction::Row fit_row(const std::vector<MeasuredCost>& costs, AutoMethod method, bool frictional);

/// The six rows as C++, the text of native/auto/prediction_rows.inc.
std::string rows_text(const std::vector<MeasuredCost>& costs);

}  // namespace lcpbench::testing
