#include "study/evaluation/farkas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/dyadic.h"

namespace lcpbench {
namespace {

using DyadicVector = std::vector<Dyadic>;

DyadicVector exact(const Vector& x) {
  DyadicVector y;
  for (const double value : x) y.emplace_back(value);
  return y;
}

bool is_zero(const DyadicVector& x) {
  return std::all_of(x.begin(), x.end(), [](const Dyadic& value) { return value.sign() == 0; });
}

Dyadic dot(const Vector& a, const DyadicVector& b) {
  Dyadic sum;
  for (Index i = 0; i < a.size(); ++i) sum += Dyadic(a(i)) * b[static_cast<std::size_t>(i)];
  return sum;
}

// A'y, y the A.rows() entries of x from `begin` on.
DyadicVector transposed_times(const Matrix& A, const DyadicVector& x, std::size_t begin) {
  DyadicVector y(static_cast<std::size_t>(A.cols()));
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = 0; i < A.rows(); ++i) {
      y[static_cast<std::size_t>(j)] += Dyadic(A(i, j)) * x[begin + static_cast<std::size_t>(i)];
    }
  }
  return y;
}

DyadicVector times(const Jacobian& N, const DyadicVector& u) {
  DyadicVector p(static_cast<std::size_t>(rows(N)));
  for (Index j = 0; j < cols(N); ++j) {
    const Dyadic& u_j = u[static_cast<std::size_t>(j)];
    if (u_j.sign() == 0) continue;
    if (const auto* dense = std::get_if<Matrix>(&N)) {
      for (Index i = 0; i < dense->rows(); ++i) p[static_cast<std::size_t>(i)] += Dyadic((*dense)(i, j)) * u_j;
    } else {
      for (SparseMatrix::InnerIterator entry(std::get<SparseMatrix>(N), j); entry; ++entry) {
        p[static_cast<std::size_t>(entry.row())] += Dyadic(entry.value()) * u_j;
      }
    }
  }
  return p;
}

// u'(N'v + b): what u'w_N is after any impulses, if u is a proof.
Dyadic weighted_velocity(const ContactProblem& problem, const DyadicVector& u) {
  Dyadic sum = dot(problem.v, times(problem.N, u));
  sum += dot(problem.b, u);
  return sum;
}

double least_violation(const ContactProblem& problem, const DyadicVector& u) {
  Dyadic total;
  for (const Dyadic& value : u) total += value;
  if (total.sign() <= 0) return std::numeric_limits<double>::quiet_NaN();
  const Dyadic missing = -weighted_velocity(problem, u);
  const double nearest = to_double(quotient(missing, total));
  if (!std::isfinite(nearest)) return std::numeric_limits<double>::max();
  return missing < Dyadic(nearest) * total ? std::nextafter(nearest, 0) : nearest;
}

// @param digits  of a decimal integer >= 0, nothing else
Dyadic integer(const std::string& digits) {
  Dyadic value;
  for (const char digit : digits) value = value * Dyadic(10.0) + Dyadic(static_cast<double>(digit - '0'));
  return value;
}

bool annihilates(const Matrix& A, const DyadicVector& p, std::size_t begin) {
  return A.allFinite() && is_zero(transposed_times(A, p, begin));
}

// Whether p = N u is in the null space of the inertia.
struct NullSpaceTest {
  const DyadicVector& p;

  bool operator()(const DenseInertia& inertia) const { return annihilates(inertia.G, p, 0); }
  bool operator()(const BlockInertia& inertia) const {
    std::size_t begin = 0;
    for (const Matrix& block : inertia.blocks) {
      if (!annihilates(block, p, begin)) return false;
      begin += static_cast<std::size_t>(block.rows());
    }
    return true;
  }
  bool operator()(const FactoredInertia& inertia) const {
    if (!inertia.X.allFinite() || !inertia.alpha.allFinite()) return false;
    for (Index k = 0; k < inertia.X.cols(); ++k) {
      if (inertia.alpha(k) != 0 && dot(inertia.X.col(k), p).sign() != 0) return false;
    }
    return true;
  }
  bool operator()(const InverseInertia& inertia) const { return annihilates(inertia.Ginv, p, 0); }
};

bool nonnegative(const Vector& u) {
  return std::all_of(u.begin(), u.end(), [](double value) { return value >= 0 && std::isfinite(value); });
}

}  // namespace

bool proves_unsolvable(const ContactProblem& problem, const Vector& u) {
  if (u.size() != problem.nc() || !nonnegative(u) || !all_finite(problem.N) || !problem.v.allFinite()) return false;
  if (!problem.b.allFinite()) return false;
  // The impulse of a contact with compliance raises its own w_N: a proof must not count on such a contact.
  if (problem.compliance_n.size() > 0 && (problem.compliance_n.array() != 0 && u.array() != 0).any()) return false;
  const DyadicVector exact_u = exact(u);
  return weighted_velocity(problem, exact_u).sign() < 0 &&
         std::visit(NullSpaceTest{times(problem.N, exact_u)}, problem.inertia);
}

bool proves_unsolvable(const Lcp& lcp, const Vector& u) {
  if (u.size() != lcp.size() || !nonnegative(u) || !lcp.M.allFinite() || !lcp.q.allFinite()) return false;
  const DyadicVector exact_u = exact(u);
  if (!(dot(lcp.q, exact_u).sign() < 0)) return false;
  const DyadicVector columns = transposed_times(lcp.M, exact_u, 0);
  return std::all_of(columns.begin(), columns.end(), [](const Dyadic& value) { return value.sign() <= 0; });
}

double least_violation(const ContactProblem& problem, const Vector& u) { return least_violation(problem, exact(u)); }

double least_violation(const ContactProblem& problem, std::span<const std::string> u) {
  DyadicVector exact_u;
  for (const std::string& digits : u) exact_u.push_back(integer(digits));
  return least_violation(problem, exact_u);
}

}  // namespace lcpbench
