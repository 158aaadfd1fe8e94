#include "generators/random.h"

#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/generators/generator_checks.h"

namespace lcpbench::random_test {
namespace {

using Block = std::array<std::uint64_t, 4>;

// The known answers that come with Random123: all zeros, all ones, and the digits of pi.
TEST(PhiloxTest, GivesTheKnownAnswers) {
  EXPECT_EQ(philox_block({0, 0, 0, 0}, {0, 0}),
            (Block{0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b, 0x7e68b68aec7ba23b}));
  constexpr std::uint64_t kOnes = ~std::uint64_t{0};
  EXPECT_EQ(philox_block({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}),
            (Block{0x87b092c3013fe90b, 0x438c3c67be8d0224, 0x9cc7d7c69cd777b6, 0xa09caebf594f0ba0}));
  EXPECT_EQ(philox_block({0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89},
                         {0x452821e638d01377, 0xbe5466cf34e90c6c}),
            (Block{0xa528f45403e61d95, 0x38c72dbd566e9788, 0xa5a1610e72fd18b5, 0x57bd43b5e52b7fe6}));
}

// Published test vectors of FNV-1a, 64 bits.
TEST(StreamIdTest, IsFnv1a) {
  EXPECT_EQ(stream_id(""), 0xcbf29ce484222325U);
  EXPECT_EQ(stream_id("a"), 0xaf63dc4c8601ec8cU);
  EXPECT_EQ(stream_id("foobar"), 0x85944171f73967e8U);
}

TEST(DrawSequenceTest, FollowsTheDocumentedLayout) {
  const TrialKey key{.stream = 11, .seed = 22, .trial = 33};
  DrawSequence draws(key, Purpose::kNormals, 44);
  for (std::uint64_t block = 0; block < 3; ++block) {
    const Block expected = philox_block({block, 33, 7, 44}, {22, 11});
    for (const std::uint64_t word : expected) EXPECT_EQ(draws.word(), word);
  }
}

TEST(DrawSequenceTest, EveryPartOfTheKeyMatters) {
  const TrialKey key{1, 2, 3};
  std::set<std::uint64_t> first_words;
  first_words.insert(DrawSequence(key, Purpose::kNormals).word());
  first_words.insert(DrawSequence({9, 2, 3}, Purpose::kNormals).word());
  first_words.insert(DrawSequence({1, 9, 3}, Purpose::kNormals).word());
  first_words.insert(DrawSequence({1, 2, 9}, Purpose::kNormals).word());
  first_words.insert(DrawSequence(key, Purpose::kTangents).word());
  first_words.insert(DrawSequence(key, Purpose::kNormals, 1).word());
  EXPECT_EQ(first_words.size(), 6u);
}

TEST(DrawSequenceTest, GridDrawsAreTheUpperBitsOfOneWord) {
  const TrialKey key{1, 2, 3};
  DrawSequence words(key, Purpose::kVelocity);
  DrawSequence draws(key, Purpose::kVelocity);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(draws.signed_grid(), static_cast<std::int64_t>(words.word() / (std::uint64_t{1} << 43)) - 1048576);
    EXPECT_EQ(draws.unit_grid(), static_cast<std::int64_t>(words.word() / (std::uint64_t{1} << 44)));
  }
}

TEST(DrawSequenceTest, IntegersAreUniformWithBothEnds) {
  DrawSequence draws({4, 5, 6}, Purpose::kContactCount);
  std::vector<int> counts(19);
  for (int i = 0; i < 190000; ++i) {
    const std::int64_t drawn = draws.integer(2, 20);
    ASSERT_TRUE(drawn >= 2 && drawn <= 20);
    ++counts[static_cast<std::size_t>(drawn - 2)];
  }
  checks::ChiSquare uniform;
  uniform.add_uniform(counts);
  EXPECT_TRUE(uniform.plausible()) << uniform.statistic();
}

// With 3 * 2^62 values, taking a word modulo their number alone would give the lowest third half of all draws.
TEST(DrawSequenceTest, IntegersOfAWideRangeAreNotBiased) {
  DrawSequence draws({4, 5, 6}, Purpose::kContactCount);
  constexpr std::int64_t kThird = std::int64_t{1} << 62;
  constexpr std::int64_t kLow = std::numeric_limits<std::int64_t>::min();
  std::vector<int> counts(3);
  for (int i = 0; i < 30000; ++i) {
    const std::int64_t drawn = draws.integer(kLow, kThird - 1);
    ASSERT_LT(drawn, kThird);
    ++counts[drawn < -kThird ? 0 : drawn < 0 ? 1 : 2];
  }
  checks::ChiSquare uniform;
  uniform.add_uniform(counts);
  EXPECT_TRUE(uniform.plausible()) << uniform.statistic();
}

TEST(DrawSequenceTest, IntegersOfTheWidestAndTheNarrowestRange) {
  DrawSequence words({1, 2, 3}, Purpose::kVelocity);
  DrawSequence draws({1, 2, 3}, Purpose::kVelocity);
  using Limits = std::numeric_limits<std::int64_t>;
  EXPECT_EQ(static_cast<std::uint64_t>(draws.integer(Limits::min(), Limits::max())), words.word());
  EXPECT_EQ(draws.integer(7, 7), 7);
}

}  // namespace
}  // namespace lcpbench::random_test
