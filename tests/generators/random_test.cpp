#include "generators/random.h"

#include <limits>

#include <gtest/gtest.h>

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

TEST(DrawSequenceTest, FollowsTheDocumentedLayout) {
  const TrialKey key{.stream = 11, .seed = 22, .trial = 33};
  DrawSequence draws(key, Purpose::kNormals, 44);
  for (std::uint64_t block = 0; block < 3; ++block) {
    const Block expected = philox_block({block, 33, 7, 44}, {22, 11});
    for (const std::uint64_t word : expected) EXPECT_EQ(draws.word(), word);
  }
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
