#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/solver.h"
#include "tests/support/allocation_counter.h"

namespace lcpbench::testing {

/// Loads the problem and solves it once. From then on solves allocate nothing: within a time limit that is over, at
/// another velocity, and at none.
inline void expect_solves_without_allocating(Solver& solver, const Problem& problem) {
  solver.load(problem);
  Answer answer;
  solver.solve({.time_limit_s = 0}, answer);  // leaves no text
  solver.solve({}, answer);
  const std::string what = problem.name() + ": " + to_string(answer.claim) + ", " + answer.detail;
  EXPECT_EQ(count_allocations([&] { solver.solve({}, answer); }), 0) << what;
  EXPECT_EQ(count_allocations([&] { solver.solve({.time_limit_s = 0}, answer); }), 0) << what;
  if (answer.claim == Claim::kUnsupported) return;  // an update loads again
  Vector v = 0.5 * problem.contact()->v;
  EXPECT_EQ(count_allocations([&] { solver.update(v); }), 0) << what;
  EXPECT_EQ(count_allocations([&] { solver.solve({}, answer); }), 0) << what;
  v.setZero();
  solver.update(v);
  EXPECT_EQ(count_allocations([&] { solver.solve({}, answer); }), 0) << what << ", at rest";
}

/// One solver reserves memory for all problems. Each is then loaded and solved without allocating, to the answer of a
/// solver of its own. @param make returns a solver that has reserve()
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
    EXPECT_EQ(count_allocations([&] {
                solver.load(problem);
                solver.update(problem.contact()->v);
                solver.solve({}, answer);
              }),
              0)
        << problem.name();
    EXPECT_EQ(answer.claim, fresh.claim) << problem.name();
    EXPECT_EQ(answer.z, fresh.z) << problem.name();
  }
}

}  // namespace lcpbench::testing
