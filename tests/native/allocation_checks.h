#pragma once

#include <vector>

#include <gtest/gtest.h>

#include "core/solver.h"
#include "tests/support/allocation_counter.h"

namespace lcpbench::testing {

/// One solver reserves memory for all problems. Each is then loaded and solved to the answer of a solver of its own,
/// and what has a solution without allocating: a search for a proof that there is none allocates. @param make returns a
/// solver that has reserve()
template <class Make>
void expect_loads_without_allocating(Make&& make, const std::vector<Problem>& problems) {
  auto solver = make();
  for (const Problem& problem : problems) solver.reserve(problem);
  for (const Problem& problem : problems) {
    auto own = make();
    own.load(problem);
    Answer fresh;
    own.solve({}, fresh);
    Answer answer;
    answer.reserve(problem);
    const auto allocations = count_allocations([&] {
      solver.load(problem);
      solver.update(problem.contact()->v);
      solver.solve({}, answer);
    });
    if (fresh.claim == Claim::kSolved) {
      EXPECT_EQ(allocations, 0) << problem.name();
    }
    EXPECT_EQ(answer.claim, fresh.claim) << problem.name();
    EXPECT_EQ(answer.z, fresh.z) << problem.name();
  }
}

}  // namespace lcpbench::testing
