// What the engines of `lemke` allocate in a solve, and what they refuse.

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "native/lemke/lemke.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::lemke_memory_test {
namespace {

TEST(LemkeEnginesTest, ALevelTheProcessorLacksIsRefused) {
  if (best_isa_level() == IsaLevel::kAvx512) GTEST_SKIP() << "this processor has every level";
  EXPECT_THROW(Lemke(LemkeSettings{}, IsaLevel::kAvx512), std::invalid_argument);
}

TEST(LemkeEnginesTest, AllocateNothingInASolve) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "the allocator of this build cannot be replaced";
  Vector nearly_at_rest = testing::ones(400);
  nearly_at_rest.head(3) *= -1;
  const Problem frictional = open_set("paper/copositive/exp2")->generate(1, 0);
  const auto bare = [](Matrix M, Vector q) { return Problem("test", Lcp{std::move(M), std::move(q)}); };
  Lemke solver(LemkeSettings{});
  ASSERT_TRUE(solver.capabilities().allocation_free);
  Answer answer;
  for (const Problem& problem : {frictional, bare(testing::tridiagonal(150, 4, -1), -testing::ones(150)),
                                 bare(testing::tridiagonal(400, 4, -1), nearly_at_rest),
                                 bare(testing::matrix_of(2, {1, -1, -1, 1}), testing::vector_of({-1, -1}))}) {
    solver.load(problem);
    answer.reserve(problem);
    EXPECT_EQ(testing::count_allocations([&] { solver.solve({}, answer); }), 0) << problem.size();
  }
  EXPECT_EQ(answer.claim, Claim::kUnsolvable);
  LemkeSettings dense;
  dense.engine = LemkeEngine::kDense;
  EXPECT_FALSE(Lemke(dense).capabilities().allocation_free);  // Eigen's LU of large matrices takes memory
}

}  // namespace
}  // namespace lcpbench::lemke_memory_test
