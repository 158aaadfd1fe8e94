#include "core/suggestion.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace lcpbench::suggestion_test {
namespace {

const std::vector<std::string> kKnown{"lemke", "contact_lemke", "psor", "paper/monotone/exp1", "--solver"};

TEST(SuggestionTest, FindsTheNameThatASlipAwayIs) {
  EXPECT_EQ(did_you_mean("lemk", kKnown), " (did you mean 'lemke'?)") << "one missing";
  EXPECT_EQ(did_you_mean("lemkee", kKnown), " (did you mean 'lemke'?)") << "one too many";
  EXPECT_EQ(did_you_mean("lenke", kKnown), " (did you mean 'lemke'?)") << "one wrong";
  EXPECT_EQ(did_you_mean("lmeke", kKnown), " (did you mean 'lemke'?)") << "two changed places";
  EXPECT_EQ(did_you_mean("--sovler", kKnown), " (did you mean '--solver'?)");
  EXPECT_EQ(did_you_mean("contactlenke", kKnown), " (did you mean 'contact_lemke'?)") << "two slips in a longer name";
}

TEST(SuggestionTest, IsSilentWhereNoNameIsClose) {
  EXPECT_EQ(did_you_mean("nope", kKnown), "");
  EXPECT_EQ(did_you_mean("", kKnown), "");
  EXPECT_EQ(did_you_mean("ps", kKnown), "") << "two slips in two letters";
  EXPECT_EQ(did_you_mean("paper/copositive/exp1", kKnown), "") << "never more than three slips";
  EXPECT_EQ(did_you_mean("lemke", {}), "");
  EXPECT_EQ(did_you_mean(std::string(1'000'000, 'l'), kKnown), "");
}

TEST(SuggestionTest, PrefersTheClosestAndThenTheFirst) {
  const std::vector<std::string> known{"exp11", "exp21", "exp2"};
  EXPECT_EQ(did_you_mean("exp2x", known), " (did you mean 'exp21'?)") << "exp21 and exp2 are one slip away";
  EXPECT_EQ(did_you_mean("exp2", known), " (did you mean 'exp2'?)");
}

}  // namespace
}  // namespace lcpbench::suggestion_test
