#pragma once

#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "study/evaluation/evaluation.h"
#include "study/run/open_solver.h"

// Libraries run in their workers, as in a study. Missing ones are skipped by name.

namespace lcpbench {

inline TimedAnswer run(const std::string& solver, const Problem& problem, const TimedRequest& request = {}) {
  TimedAnswer result;
  open_solver(parse_spec(solver))->run(problem, request, result);
  return result;
}

inline bool missing(const std::string& solver) {
  const std::string& why = find_solver(parse_spec(solver).name).unavailable;
  if (!why.empty()) std::printf("%s: not built: %s\n", solver.c_str(), why.c_str());
  return !why.empty();
}

/// A contact that sticks below its limit may push along a direction and its opposite at once: only their difference is
/// determined, which stands here in the place of the first, 0 in that of the second. Contacts have 4 edges, or none.
inline Vector without_opposites(const Problem& problem, Vector z) {
  if (problem.contact() == nullptr) return z;
  const ContactLayout layout = contact_layout(*problem.contact());
  for (Index c = 0; c < layout.cones; ++c) {
    auto f_D = z.segment<4>(layout.friction_offset() + 4 * c);
    f_D.head<2>() -= f_D.tail<2>();
    f_D.tail<2>().setZero();
  }
  return z;
}

inline void expect_solution(const std::string& solver, const Problem& problem, const Vector& z, double tolerance) {
  if (missing(solver)) return;
  const Answer answer = run(solver, problem).answer;
  EXPECT_EQ(answer.claim, Claim::kSolved) << solver << " on " << problem.name() << ": " << answer.detail;
  ASSERT_EQ(answer.z.size(), z.size()) << solver;
  const Vector difference = without_opposites(problem, answer.z) - without_opposites(problem, z);
  EXPECT_LE(difference.lpNorm<Eigen::Infinity>(), tolerance)
      << solver << " on " << problem.name() << " returned " << answer.z.transpose();
}

}  // namespace lcpbench
