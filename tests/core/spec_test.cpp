#include "core/spec.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace lcpbench::spec_test {
namespace {

TEST(SpecTest, NameAloneHasNoOptions) {
  const Spec spec = parse_spec("  lemke ");
  EXPECT_EQ(spec.name, "lemke");
  EXPECT_TRUE(spec.options.empty());
  EXPECT_EQ(spec.text(), "lemke");
  EXPECT_EQ(parse_spec("lemke{}").text(), "lemke");
}

TEST(SpecTest, OptionsKeepTheirOrderAndReadBack) {
  const Spec spec = parse_spec("lemke{ engine = kernel , pivot_tolerance=1e-8}");
  ASSERT_EQ(spec.options.size(), 2u);
  EXPECT_EQ(spec.options[0].second, "kernel");
  EXPECT_EQ(spec.text(), "lemke{engine=kernel,pivot_tolerance=1e-8}");
  EXPECT_EQ(parse_spec(spec.text()).text(), spec.text());
}

TEST(SpecTest, AValueMayHoldASpecOfItsOwn) {
  const Spec spec = parse_spec("regularized{solver=lemke{engine=kernel,zero_tolerance=0},first=1e-12}");
  ASSERT_EQ(spec.options.size(), 2u);
  EXPECT_EQ(spec.options[0].second, "lemke{engine=kernel,zero_tolerance=0}");
  EXPECT_EQ(parse_spec(spec.options[0].second).options[1].first, "zero_tolerance");
}

TEST(SpecTest, AValueMayHoldAnEqualsSign) {
  EXPECT_EQ(parse_spec("external{command=./mine.py --tol=1e-8}").options[0].second, "./mine.py --tol=1e-8");
}

class BadSpecTest : public ::testing::TestWithParam<const char*> {};

TEST_P(BadSpecTest, IsRefusedInOneLine) {
  try {
    parse_spec(GetParam());
    FAIL() << "accepted: " << GetParam();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

INSTANTIATE_TEST_SUITE_P(SpecTest, BadSpecTest,
                         ::testing::Values("", "  ", "{a=1}", "lemke{a=1", "lemke{a=1}}", "lemke{a=1}x", "lemke{a}",
                                         "lemke{=1}", "lemke{a=1,a=2}", "lemke{a={}", "lemke{a=1,}", "lem}ke",
                                         "lemke{a}=1}"));

/// A plan may hold a megabyte: each level of a nested solver reads all levels below it again.
TEST(SpecTest, NestingAndOptionsAreCountedBeforeTheyAreRead) {
  const auto nested = [](int depth) {
    std::string text;
    for (int i = 0; i < depth; ++i) text += "regularized{solver=";
    return text + "lemke" + std::string(static_cast<std::size_t>(depth), '}');
  };
  EXPECT_EQ(parse_spec(nested(16)).name, "regularized");
  std::string options;
  for (int i = 0; i < 100000; ++i) options += (i > 0 ? ",o" : "o") + std::to_string(i) + "=1";
  for (const auto& [text, cause] : {std::pair{nested(20000), "more than 16 braces inside each other"},
                                    std::pair{"lemke{" + options + "}", "more than 256 options"}}) {
    try {
      parse_spec(text);
      FAIL() << cause;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(cause), std::string::npos) << error.what();
      EXPECT_LT(std::string(error.what()).size(), 2000U);
    }
  }
}

TEST(SpecTest, SplitsAtTopLevelCommasOnly) {
  EXPECT_EQ(split_top_level("a{b,c},d"), (std::vector<std::string>{"a{b,c}", "d"}));
  EXPECT_EQ(split_top_level("a"), (std::vector<std::string>{"a"}));
  EXPECT_THROW(split_top_level("a},{b"), InputError);
}

}  // namespace
}  // namespace lcpbench::spec_test
