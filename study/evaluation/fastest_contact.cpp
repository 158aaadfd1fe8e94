#include "study/evaluation/fastest_contact.h"

#include <algorithm>
#include <cmath>

namespace lcpbench {

FastestContact fastest_contact(const ContactProblem& problem, const Vector& u) {
  FastestContact fastest;
  Index contact = 0;
  const auto look_at = [&](const Jacobian& J, Index column) {
    const double speed = std::abs(dot_column(J, column, u));
    if (!(speed <= fastest.m_per_s) && !std::isnan(fastest.m_per_s)) fastest = {speed, contact};  // NaN stays
  };
  Index direction = 0;
  for (; contact < problem.nc(); ++contact) {
    look_at(problem.N, contact);
    const int edges = problem.edges[static_cast<std::size_t>(contact)];
    for (int t = 0; t < edges / 2; ++t) look_at(problem.D, direction + t);
    direction += edges;
  }
  return fastest;
}

double least_difference(const ContactProblem& problem) {
  double largest = fastest_contact(problem, problem.v).m_per_s;
  for (const double offset : problem.b) largest = std::max(largest, std::abs(offset));
  for (const double offset : problem.offset_t) largest = std::max(largest, std::abs(offset));
  return 1e-3 * largest;
}

}  // namespace lcpbench
