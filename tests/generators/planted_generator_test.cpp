// What a user relies on: the answer that was planted is the answer, exactly.

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "generators/planted.h"
#include "generators/sets.h"
#include "tests/generators/generator_checks.h"
#include "tests/generators/opened_set.h"

namespace lcpbench::planted_generator_test {
namespace {

using Opened = testing::OpenedSet<PlantedSet, draw_planted>;

Opened open(const std::string& text) { return testing::opened_set<draw_planted>(planted_sets(), text); }

const std::vector<std::string> kReadings = {"planted/definite", "planted/definite{n_max=1}",
                                            "planted/definite{n_max=100,condition=1e6}",
                                            "planted/definite{condition=1}"};

/// (M z + q)_i in steps of 2^-44, in integers; `exact` fails when a number is not on its grid.
std::int64_t slack_steps(const PlantedSample& sample, std::size_t i, bool& exact) {
  std::int64_t slack = checks::in_steps(sample.q[i], 0x1p-44, exact);
  for (std::size_t j = 0; j < sample.z.size(); ++j) {
    slack += checks::in_steps(sample.M(i, j), 0x1p-36, exact) * checks::in_steps(sample.z[j], 0x1p-8, exact);
  }
  return slack;
}

TEST(PlantedGeneratorTest, ThePlantedAnswerHoldsExactly) {
  for (const std::string& name : kReadings) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    for (std::uint64_t trial = 0; trial < 40; ++trial) {
      const PlantedSample sample = set.draw(trial);
      bool exact = true;
      for (std::size_t i = 0; i < sample.z.size(); ++i) {
        ASSERT_EQ(slack_steps(sample, i, exact), checks::in_steps(sample.w[i], 0x1p-44, exact)) << trial;
        ASSERT_TRUE(sample.z[i] >= 0x1p-8 && sample.z[i] <= 1
                        ? sample.w[i] == 0
                        : sample.z[i] == 0 && sample.w[i] > 0 && sample.w[i] <= 1);
      }
      ASSERT_TRUE(exact) << trial;
    }
  }
}

}  // namespace
}  // namespace lcpbench::planted_generator_test
