#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/contact_problem.h"
#include "core/quad_inertia.h"

namespace lcpbench::testing {

/// v* in 113-bit arithmetic, when the contacts that z presses are those of the solution: their impulses solved for
/// afresh are positive, and no other contact is violated. The projection being unique, that proves v*.
inline bool exact_velocity(const ContactProblem& problem, const Vector& z, QuadVector& velocity) {
  const QuadInertia inertia(problem.inertia);
  const QuadMatrix N(to_dense(problem.N));
  const auto along = [&](std::size_t contact, const QuadVector& x) {
    Quad sum = 0;
    for (std::size_t i = 0; i < N.rows; ++i) sum += N(i, contact) * x[i];
    return sum;
  };
  velocity.assign(problem.v.begin(), problem.v.end());
  std::vector<std::size_t> active;
  std::vector<QuadVector> responses;
  for (std::size_t j = 0; j < N.cols; ++j) {
    if (!(z(static_cast<Index>(j)) > 0)) continue;
    active.push_back(j);
    QuadVector response(N.rows);
    for (std::size_t i = 0; i < N.rows; ++i) response[i] = N(i, j);
    inertia.solve(response);
    responses.push_back(std::move(response));
  }
  QuadMatrix M(active.size(), active.size());
  QuadVector impulses(active.size());
  Quad scale = 0;
  for (std::size_t j = 0; j < N.cols; ++j) scale = std::max(scale, abs(along(j, velocity)));
  for (std::size_t i = 0; i < active.size(); ++i) {
    impulses[i] = -along(active[i], velocity);
    for (std::size_t j = 0; j < active.size(); ++j) M(i, j) = along(active[i], responses[j]);
  }
  QuadCholesky factor;
  if (!active.empty()) {
    QuadMatrix shifted = M;
    for (std::size_t i = 0; i < active.size(); ++i) shifted(i, i) *= 1 - Quad{0x1p-90};
    if (!QuadCholesky().factor(shifted) || !factor.factor(M)) return false;
    factor.solve(impulses.data());
  }
  for (std::size_t k = 0; k < active.size(); ++k) {
    if (!(impulses[k] > 0)) return false;
    for (std::size_t i = 0; i < N.rows; ++i) velocity[i] += responses[k][i] * impulses[k];
  }
  for (std::size_t j = 0; j < N.cols; ++j) {
    // M_aa has a condition number of up to 1e18 (two normals 1e-9 apart): 1e-34 times that is left.
    if (!(along(j, velocity) >= -Quad(1e-15) * scale)) return false;
  }
  return true;
}

/// ||u - v*||_G / ||v||_G.
inline double velocity_error(const ContactProblem& problem, const Vector& u, const QuadVector& exact) {
  const QuadInertia inertia(problem.inertia);
  QuadVector off(exact.size());
  const QuadVector before(problem.v.begin(), problem.v.end());
  for (std::size_t i = 0; i < off.size(); ++i) off[i] = Quad(u(static_cast<Index>(i))) - exact[i];
  const QuadVector weighted = inertia.apply(off);
  const QuadVector weighted_before = inertia.apply(before);
  Quad error = 0;
  Quad size = 0;
  for (std::size_t i = 0; i < off.size(); ++i) {
    error += off[i] * weighted[i];
    size += before[i] * weighted_before[i];
  }
  return to_double(sqrt(error / size));
}

}  // namespace lcpbench::testing
