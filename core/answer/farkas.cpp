#include "core/answer/farkas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/answer/exact_sum.h"
#include "core/answer/lcp_error.h"
#include "core/entries.h"

namespace lcpbench {
namespace {

bool is_nonnegative(const Vector& u) {
  return std::all_of(u.begin(), u.end(), [](double value) { return value >= 0 && std::isfinite(value); });
}

/// Calls visit(u_i, J, column, b_i) for the normal row of each contact and for each bounded row where u_i is not zero.
template <class Visit>
void for_each_weight(const ContactProblem& problem, const Vector& u, const Visit& visit) {
  const Index nc = problem.nc();
  for (Index i = 0; i < u.size(); ++i) {
    if (u(i) == 0) continue;
    if (i < nc) {
      visit(u(i), problem.N, i, problem.offset(i));
    } else {
      visit(u(i), problem.rows.R, i - nc, problem.rows.offset(i - nc));
    }
  }
}

/// Adds sign * u'(J'v + b). @param sign  1 or -1
void add_velocity(const ContactProblem& problem, const Vector& v, const Vector& u, double sign, ExactSum& sum) {
  for_each_weight(problem, u, [&](double weight, const Jacobian& J, Index column, double offset) {
    for_each_entry(J, column, [&](Index row, double entry) { sum.add(sign * weight, entry, v(row)); });
    sum.add(sign * weight, offset);
  });
}

/// Whether the velocities w of all rows have the signs that make u'w >= 0: of contacts w >= 0, of a bounded row w >= 0
/// where its impulse has no upper bound, w <= 0 where it has no lower one. The impulse of a row with compliance changes
/// its own w: a proof must not count on such a row.
bool counts_on_signs(const ContactProblem& problem, const Vector& u) {
  const Index nc = problem.nc();
  if (!is_nonnegative(u.head(nc)) || !u.allFinite()) return false;
  const LcpBounds& bounds = problem.rows.bounds;
  for (Index i = 0; i < u.size(); ++i) {
    if (u(i) == 0) continue;
    if (i < nc) {
      if (problem.normal_compliance(i) != 0) return false;
      continue;
    }
    const Index row = i - nc;
    const double bound = u(i) > 0 ? bounds.upper(row) : -bounds.lower(row);
    if (std::isfinite(bound) || bounds.friction_of[static_cast<std::size_t>(row)] >= 0) return false;
    if (problem.rows.yields(row) != 0) return false;
  }
  return true;
}

/// The terms J_ik u_k of each coordinate of J u that is not zero; none of those that are.
std::vector<std::vector<std::pair<double, double>>> moved(const ContactProblem& problem, const Vector& u) {
  std::vector<std::vector<std::pair<double, double>>> terms(static_cast<std::size_t>(problem.ngc()));
  for_each_weight(problem, u, [&](double weight, const Jacobian& J, Index column, double) {
    for_each_entry(J, column,
                   [&](Index i, double entry) { terms[static_cast<std::size_t>(i)].emplace_back(entry, weight); });
  });
  ExactSum sum;
  for (auto& of_coordinate : terms) {
    sum.clear();
    for (const auto& [entry, weight] : of_coordinate) sum.add(entry, weight);
    if (sum.sign() == 0) of_coordinate.clear();
  }
  return terms;
}

bool is_in_null_space(const ContactProblem& problem, const Vector& u) {
  const auto terms = moved(problem, u);
  const auto* factors = std::get_if<FactoredInertia>(&problem.inertia);
  bool holds = factors == nullptr || factors->alpha.allFinite();
  ExactSum sum;
  for_each_matrix(problem.inertia, [&](const Matrix& A, Index first) {
    holds = holds && A.allFinite();
    for (Index k = 0; k < A.cols() && holds; ++k) {
      if (factors != nullptr && factors->alpha(k) == 0) continue;
      sum.clear();
      for (Index i = 0; i < A.rows(); ++i) {
        if (A(i, k) == 0) continue;
        for (const auto& [entry, weight] : terms[static_cast<std::size_t>(first + i)]) sum.add(A(i, k), entry, weight);
      }
      holds = sum.sign() == 0;
    }
  });
  return holds;
}

}  // namespace

bool proves_unsolvable(const ContactProblem& problem, const Vector& v, const Vector& u) {
  if (u.size() != problem.nc() + problem.rows.size() || !counts_on_signs(problem, u)) return false;
  if (!all_finite(problem.N) || !v.allFinite() || !problem.b.allFinite()) return false;
  if (problem.has_rows() && !(all_finite(problem.rows.R) && problem.rows.b.allFinite())) return false;
  ExactSum sum;
  add_velocity(problem, v, u, 1, sum);
  return sum.sign() < 0 && is_in_null_space(problem, u);
}

bool proves_unsolvable(const Lcp& lcp, const Vector& u) {
  if (lcp.is_mixed() || u.size() != lcp.size() || !is_nonnegative(u)) return false;
  if (!lcp.M.allFinite() || !lcp.q.allFinite()) return false;
  ExactSum sum;
  const auto sign = [&](const auto& column) {
    sum.clear();
    for (Index i = 0; i < u.size(); ++i) {
      if (u(i) != 0 && column(i) != 0) sum.add(column(i), u(i));
    }
    return sum.sign();
  };
  if (sign(lcp.q) >= 0) return false;
  for (Index j = 0; j < u.size(); ++j) {
    if (sign(lcp.M.col(j)) > 0) return false;
  }
  return true;
}

double proof_margin(const Lcp& lcp, const Vector& u) {
  const std::vector<Quad> floors = lcp_floors(lcp, row_islands(lcp.M), lcp_norms<Quad>(lcp));
  ExactSum missing;
  Quad size = 0;
  for (Index i = 0; i < u.size(); ++i) {
    missing.add(-lcp.q(i), u(i));
    size += Quad{u(i)} * std::max(Quad{std::abs(lcp.q(i))}, floors[static_cast<std::size_t>(i)]);
  }
  return to_double(missing.value() / size);
}

double least_violation(const ContactProblem& problem, const Vector& u) {
  ExactSum missing, total;
  add_velocity(problem, problem.v, u, -1, missing);
  for (const double weight : u) total.add(std::abs(weight), 1);
  if (total.sign() <= 0) return std::numeric_limits<double>::quiet_NaN();
  const double nearest = to_double(missing.value() / total.value());
  if (!std::isfinite(nearest)) return std::numeric_limits<double>::max();
  for (const double weight : u) missing.add(-nearest, std::abs(weight));
  return missing.sign() < 0 ? std::nextafter(nearest, 0) : nearest;
}

}  // namespace lcpbench
