#pragma once

#include <limits>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench::testing {

/// A bounded row as a test writes it down: an equality, unless bounds are given.
struct Row {
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  std::vector<double> direction;
  double lower = -kNone;
  double upper = kNone;
  double b = 0;
  double compliance = 0;
  int friction_of = -1;
  double mu = 0;
  bool is_angle = false;
};

/// The problem with these rows, R dense.
inline ContactProblem with_rows(ContactProblem problem, const std::vector<Row>& rows) {
  const auto count = static_cast<Index>(rows.size());
  Matrix R(problem.ngc(), count);
  BoundedRows& to = problem.rows = {};
  to.bounds = LcpBounds::nonnegative(count);
  to.b = to.compliance = Vector::Zero(count);
  for (Index i = 0; i < count; ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    R.col(i) = Eigen::Map<const Vector>(row.direction.data(), problem.ngc());
    to.bounds.lower(i) = row.lower;
    to.bounds.upper(i) = row.upper;
    to.bounds.friction_of[static_cast<std::size_t>(i)] = row.friction_of;
    to.bounds.mu(i) = row.mu;
    to.b(i) = row.b;
    to.compliance(i) = row.compliance;
    to.is_angle.push_back(row.is_angle ? 1 : 0);
  }
  for (Vector* numbers : {&to.b, &to.compliance}) {
    if (numbers->isZero(0)) numbers->resize(0);
  }
  to.R = R;
  return problem;
}

}  // namespace lcpbench::testing
