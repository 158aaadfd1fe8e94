#include "generators/made/made.h"

#include <fstream>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench::made_test {
namespace {

Problem generate(const MadeSet& set, const std::string& options, std::int64_t trial) {
  return open_set(set.name + "{" + options + "}")->generate(1, trial);
}

TEST(MadeTest, TheNumberOfContactsIsNearItsAim) {
  for (const MadeSet& set : made_sets()) {
    for (const std::size_t aim : {std::size_t{10}, std::size_t{100}, static_cast<std::size_t>(set.features.nc_max)}) {
      const std::string size = std::to_string(aim);
      for (std::int64_t trial = 0; trial < (aim > 100 ? 1 : 8); ++trial) {
        const MadeReading reading = set.parse(set.name, {{"nc_min", size}, {"nc_max", size}, {"edges", "0"}});
        const auto nc = draw_made(set, reading, 1, static_cast<std::uint64_t>(trial)).N.size();
        EXPECT_GE(nc, aim / 2 - 2) << set.name << " " << trial;
        EXPECT_LE(nc, aim + aim / 4 + 12) << set.name << " " << trial;
      }
    }
  }
}

TEST(MadeTest, OptionsHold) {
  for (const MadeSet& set : made_sets()) {
    for (std::int64_t trial = 0; trial < 5; ++trial) {
      const Problem rough = generate(set, "nc_max=60,mu_min=0.5,mu_max=0.75,edges=6,offsets=0", trial);
      for (const int edges : rough.contact()->edges) EXPECT_EQ(edges, 6);
      EXPECT_GE(rough.contact()->mu.minCoeff(), 0.5);
      EXPECT_LE(rough.contact()->mu.maxCoeff(), 0.75);
      EXPECT_FALSE(rough.contact()->has_offset());
      EXPECT_FALSE(generate(set, "nc_max=60,edges=0", trial).contact()->frictional());
    }
  }
}

TEST(MadeTest, RefusesARangeOfFrictionThatIsEmpty) {
  EXPECT_THROW(open_set("made/tower{mu_min=3}"), InputError);  // mu_max is 2
  EXPECT_NO_THROW(open_set("made/tower{mu_min=3,mu_max=3}"));
  EXPECT_NO_THROW(open_set("made/hand{nc_min=1000}"));
}

TEST(MadeTest, BodiesAtRestHaveASolution) {
  for (const MadeSet& set : made_sets()) {
    for (std::int64_t trial = 0; trial < 6; ++trial) {
      const Problem problem = generate(set, "nc_max=40,motion=rest", trial);
      const auto solver = make_solver(parse_spec("auto"));
      solver->load(problem);
      Answer answer;
      solver->solve({.time_limit_s = 20}, answer);
      EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << problem.name();
    }
  }
}

TEST(MadeTest, ThePageStatesTheSplit) {
  std::map<std::string, std::string> uses;
  std::ifstream page(GENERATORS_PAGE);
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| `made/")) continue;
    const std::size_t end = line.find('`', 3);
    uses[line.substr(3, end - 3)] = line.find("| held out |") != std::string::npos ? "held out" : "for fits";
  }
  ASSERT_EQ(uses.size(), made_sets().size());
  std::size_t held_out = 0;
  for (const MadeSet& set : made_sets()) {
    EXPECT_EQ(uses[set.name], set.features.held_out ? "held out" : "for fits") << set.name;
    held_out += set.features.held_out ? 1 : 0;
  }
  EXPECT_EQ(held_out, made_sets().size() / 2);
}

}  // namespace
}  // namespace lcpbench::made_test
