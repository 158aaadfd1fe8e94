#include "study/certify/candidates.h"

#include <algorithm>

#include "core/registry.h"

namespace lcpbench::exact {

const Answer& Candidates::answer(const std::string& spec, const Problem& problem, double time_limit_s) {
  Kept& kept = kept_[spec];
  if (kept.solver == nullptr) kept.solver = make_solver(parse_spec(spec));
  kept.solver->load(problem);
  kept.solver->solve({.start = nullptr, .time_limit_s = time_limit_s}, kept.answer);
  return kept.answer;
}

std::vector<Index> support(const Vector& z, Index n) {
  std::vector<Index> positive;
  if (z.size() != n || !z.allFinite()) return positive;
  for (Index i = 0; i < n; ++i) {
    if (z(i) > 0) positive.push_back(i);
  }
  std::stable_sort(positive.begin(), positive.end(), [&](Index a, Index b) { return z(a) > z(b); });
  return positive;
}

}  // namespace lcpbench::exact
