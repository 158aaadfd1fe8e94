#include "study/certify/candidates.h"

#include <algorithm>
#include <cmath>

#include "core/registry.h"

namespace lcpbench::exact {
namespace {

/// |w_i| below this many roundings of its terms may be zero.
constexpr double kTight = 1e-8;

}  // namespace

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

std::vector<Index> tight_rows(const Problem& problem, const Vector& z) {
  std::vector<Index> tight;
  if (z.size() != problem.size() || !z.allFinite()) return tight;
  const Lcp& lcp = problem.lcp();
  const Vector w = lcp.q + lcp.M * z;
  const Vector scale = lcp.q.cwiseAbs() + lcp.M.cwiseAbs() * z.cwiseAbs();
  for (Index i = 0; i < z.size(); ++i) {
    if (!(z(i) > 0) && std::abs(w(i)) <= kTight * scale(i)) tight.push_back(i);
  }
  return tight;
}

Guess classified(const Problem& problem, const Vector& z, double clear) {
  Guess guess;
  const Lcp& lcp = problem.lcp();
  if (z.size() != lcp.size() || !z.allFinite()) return guess;
  const Vector w = lcp.q + lcp.M * z;
  const Vector terms = lcp.q.cwiseAbs() + lcp.M.cwiseAbs() * z.cwiseAbs();
  for (Index i = 0; i < z.size(); ++i) {
    double part = 0;  // of z_i in the rows that it moves
    for (Index j = 0; j < z.size(); ++j) {
      if (lcp.M(j, i) != 0 && terms(j) > 0) part = std::max(part, std::abs(lcp.M(j, i)) * z(i) / terms(j));
    }
    const bool pressed = part > clear;
    const bool open = w(i) > clear * terms(i);
    if (pressed && !open) guess.basis.push_back(i);
    if (pressed == open) guess.unclear.push_back(i);
  }
  return guess;
}

}  // namespace lcpbench::exact
