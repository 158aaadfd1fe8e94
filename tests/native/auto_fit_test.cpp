// The table of auto's predictions is what `auto_table fit` makes of the measured costs in results/auto.

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "study/measure/auto_table.h"

namespace lcpbench {
namespace {

/// The numbers of the rows, in their order.
std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const bool begins = k > 0 && (text[k - 1] == '{' || text[k - 1] == ' ');
    if (!begins || (text[k] != '-' && std::isdigit(static_cast<unsigned char>(text[k])) == 0)) continue;
    numbers.push_back(std::atof(text.c_str() + k));
  }
  return numbers;
}

TEST(AutoFitTest, TheTableIsFittedToTheMeasuredCosts) {
  const std::string root = LCPBENCH_SOURCE_DIR;
  const std::vector<double> fitted =
      numbers_of(testing::rows_text(testing::read_costs(root + "/results/auto/costs.csv")));
  std::ifstream file(root + "/native/auto/prediction_rows.inc");
  std::stringstream text;
  text << file.rdbuf();
  const std::vector<double> table = numbers_of(text.str());
  ASSERT_EQ(fitted.size(), table.size());
  EXPECT_EQ(table.size(), 86U);
  // Rounded to three digits, of sums that each compiler may round its own way.
  for (std::size_t k = 0; k < table.size(); ++k) EXPECT_NEAR(fitted[k], table[k], 1.5e-3) << k;
}

TEST(AutoFitTest, RefusesWhatIsNoTable) {
  EXPECT_THROW(testing::read_costs("no/such/file"), InputError);
  EXPECT_THROW(testing::read_costs(std::string(LCPBENCH_SOURCE_DIR) + "/README.md"), InputError);
}

}  // namespace
}  // namespace lcpbench
