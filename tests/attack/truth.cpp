#include "tests/attack/truth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/attack/judge.h"

namespace lcpbench::attack {
namespace {

// Contact problems about which no theorem decides are searched as LCPs up to this order and number of linear programs.
constexpr Index kLargestSearched = 24;
constexpr int kNodes = 3000;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

DyadicMatrix beside(const DyadicVector& b, const DyadicMatrix& A) {
  DyadicMatrix result(A.rows, A.cols + 1);
  for (Index i = 0; i < A.rows; ++i) {
    result(i, 0) = b[at(i)];
    for (Index j = 0; j < A.cols; ++j) result(i, j + 1) = A(i, j);
  }
  return result;
}

/// Whether the inequalities w = q + M z >= 0, z >= 0 have a point with w_i z_i = 0 for all i, which they then stand at.
/// kUnknown when that would take more than `nodes` linear programs.
Truth find_complementary_point(Inequalities& inequalities, int& nodes) {
  if (--nodes < 0) return Truth::kUnknown;
  if (!inequalities.feasible()) return Truth::kUnsolvable;
  const Index n = inequalities.rows();
  Index i = 0;
  while (i < n && !(inequalities.sign(i) > 0 && inequalities.sign(n + i) > 0)) ++i;
  if (i == n) return Truth::kSolvable;
  for (const Index variable : {i, n + i}) {
    Inequalities branch = inequalities;
    const Truth found = branch.impose(variable) ? find_complementary_point(branch, nodes) : Truth::kUnsolvable;
    if (found == Truth::kSolvable) inequalities = std::move(branch);
    if (found != Truth::kUnsolvable) return found;
  }
  return Truth::kUnsolvable;
}

/// [q M] of a bare LCP whose solutions are those of a mixed one: two unknowns for one that is free or a friction
/// impulse, a slack for a second bound, and a multiplier for the limit of a friction impulse.
struct Expanded {
  struct Unknown {
    Index row;
    Dyadic sign;
  };
  DyadicMatrix rows;
  DyadicVector origin;            ///< z of the mixed one where all unknowns are zero
  std::vector<Unknown> unknowns;  ///< the first ones

  /// The doubles next to the z of the point that the search ended at.
  Vector restored(const Inequalities& found) const {
    DyadicVector z = origin;
    for (Dyadic& value : z) value = value * Dyadic(found.denominator(), 0);
    for (std::size_t a = 0; a < unknowns.size(); ++a) {
      z[at(unknowns[a].row)] =
          z[at(unknowns[a].row)] + unknowns[a].sign * found.value(rows.rows + static_cast<Index>(a));
    }
    Vector result(static_cast<Index>(z.size()));
    for (Index i = 0; i < result.size(); ++i) {
      result(i) = z[at(i)].sign() * quotient(abs(z[at(i)]), Dyadic(found.denominator(), 0));
    }
    return result;
  }
};

/// @param given  [q M] of the mixed LCP
Expanded expanded(const DyadicMatrix& given, const LcpBounds& bounds) {
  const Index n = given.rows;
  Expanded result;
  std::vector<Expanded::Unknown>& unknowns = result.unknowns;
  DyadicVector& origin = result.origin;
  origin.resize(at(n));
  Index limits = 0;
  for (Index i = 0; i < n; ++i) {
    const bool has_lower = std::isfinite(bounds.lower(i)), has_upper = std::isfinite(bounds.upper(i));
    if (has_lower || has_upper) origin[at(i)] = Dyadic(has_lower ? bounds.lower(i) : bounds.upper(i));
    const bool is_fixed = has_lower && bounds.lower(i) == bounds.upper(i);
    if (!is_fixed && (has_lower || !has_upper)) unknowns.push_back({i, Dyadic(1.0)});
    if (!is_fixed && !has_lower) unknowns.push_back({i, Dyadic(-1.0)});
    limits += (has_lower && has_upper && !is_fixed) || bounds.friction_of[at(i)] >= 0 ? 1 : 0;
  }
  DyadicVector q(at(n));  // at the origin
  for (Index i = 0; i < n; ++i) {
    q[at(i)] = given(i, 0);
    for (Index j = 0; j < n; ++j) q[at(i)] = q[at(i)] + given(i, j + 1) * origin[at(j)];
  }
  const auto count = static_cast<Index>(unknowns.size());
  DyadicMatrix& rows = result.rows = DyadicMatrix(count + limits, count + limits + 1);
  for (Index a = 0; a < count; ++a) {
    const auto& [i, sign] = unknowns[at(a)];
    rows(a, 0) = sign * q[at(i)];
    for (Index b = 0; b < count; ++b) rows(a, b + 1) = sign * unknowns[at(b)].sign * given(i, unknowns[at(b)].row + 1);
  }
  Index limit = count;
  for (Index i = 0; i < n; ++i) {
    const int of = bounds.friction_of[at(i)];
    const bool is_range = std::isfinite(bounds.lower(i)) && bounds.lower(i) < bounds.upper(i) &&
                          std::isfinite(bounds.upper(i));
    if (of < 0 && !is_range) continue;
    const Dyadic mu(of >= 0 ? bounds.mu(i) : 0.0);
    rows(limit, 0) = of >= 0 ? mu * origin[at(of)] : Dyadic(bounds.upper(i)) - Dyadic(bounds.lower(i));
    for (Index a = 0; a < count; ++a) {
      if (unknowns[at(a)].row == of) rows(limit, a + 1) = mu * unknowns[at(a)].sign;
      if (unknowns[at(a)].row != i) continue;
      rows(limit, a + 1) = Dyadic(-1.0);
      rows(a, limit + 1) = Dyadic(1.0);
    }
    ++limit;
  }
  return result;
}

ExactTruth lcp_truth(const Problem& problem) {
  const Lcp& lcp = problem.lcp();
  const DyadicMatrix given = beside(exact(lcp.q), exact(lcp.M));
  const DyadicMatrix rows = lcp.is_mixed() ? expanded(given, lcp.bounds).rows : given;
  Inequalities inequalities(rows);
  if (!inequalities.feasible()) return {Truth::kUnsolvable};
  int nodes = std::numeric_limits<int>::max();
  return {find_complementary_point(inequalities, nodes)};
}

/// b of a contact.
Dyadic offset_of(const ContactProblem& contact, Index i) {
  return i < contact.b.size() ? Dyadic(contact.b(i)) : Dyadic();
}

/// P with P'f = 0 exactly where f lies in the null space of the inertia.
DyadicMatrix range_basis(const Inertia& inertia) {
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) return exact(factors->X);
  if (const auto* given = std::get_if<InverseInertia>(&inertia)) return exact(given->Ginv);
  return exact(dense_inertia(inertia));
}

DyadicMatrix below(const DyadicMatrix& A, const DyadicMatrix& B) {
  DyadicMatrix result(A.rows + B.rows, A.cols);
  for (Index j = 0; j < A.cols; ++j) {
    for (Index i = 0; i < A.rows; ++i) result(i, j) = A(i, j);
    for (Index i = 0; i < B.rows; ++i) result(A.rows + i, j) = B(i, j);
  }
  return result;
}

/// What compliance makes of the impulses along the cones' edges: r_n f_N, and r_t f_T along both tangents. Its rows are
/// zero where no compliance is. Contacts have 0, 2 or 4 edges.
DyadicMatrix yielding(const ContactProblem& contact, Index columns) {
  DyadicMatrix rows(3 * contact.nc(), columns);
  Index column = contact.nc();
  for (Index c = 0; c < contact.nc(); ++c) {
    const Dyadic r_n(contact.normal_compliance(c));
    const Dyadic r_t = Dyadic(contact.tangential_compliance(c)) * Dyadic(contact.mu(c));
    rows(c, c) = r_n;
    const int edges = contact.edges[at(c)];
    for (int t = 0; columns > contact.nc() && t < edges; ++t, ++column) {
      rows(c, column) = r_n;
      const Index tangent = edges == 4 ? t % 2 : 0;
      rows(contact.nc() + 2 * c + tangent, column) = 2 * t < edges ? r_t : -r_t;
    }
  }
  return rows;
}

/// Whether some c >= 0 has P'C c = 0, yields nowhere, and q'c = -1.
bool moves_nothing_and_falls(const DyadicMatrix& P, const DyadicMatrix& C, const DyadicVector& q,
                             const ContactProblem& contact) {
  const DyadicMatrix null_rows = below(product(transposed(P), C), yielding(contact, C.cols));
  DyadicMatrix rows(null_rows.rows + 1, C.cols + 1);
  rows(null_rows.rows, 0) = Dyadic(1.0);
  for (Index j = 0; j < C.cols; ++j) {
    for (Index i = 0; i < null_rows.rows; ++i) rows(i, j + 1) = null_rows(i, j);
    rows(null_rows.rows, j + 1) = q[at(j)];
  }
  Inequalities inequalities(rows);
  for (Index i = 0; i < rows.rows; ++i) {
    if (!inequalities.impose(i)) return false;
  }
  return inequalities.feasible();
}

/// N_i of every contact, then N_i + mu_i D_t of every friction column t of it.
DyadicMatrix cone_edges(const ContactProblem& contact) {
  const DyadicMatrix N = exact(to_dense(contact.N));
  const DyadicMatrix D = exact(to_dense(contact.D));
  DyadicMatrix edges(N.rows, N.cols + D.cols);
  Index column = 0;
  for (Index c = 0; c < N.cols; ++c) {
    for (Index k = 0; k < N.rows; ++k) edges(k, c) = N(k, c);
    const Dyadic mu(contact.mu(c));
    for (int t = 0; t < contact.edges[at(c)]; ++t, ++column) {
      for (Index k = 0; k < N.rows; ++k) edges(k, N.cols + column) = N(k, c) + mu * D(k, column);
    }
  }
  return edges;
}

/// By the examination of the cones alone.
ExactTruth truth_with_rows(const Problem& problem) {
  const Expanded all = expanded(Judge(problem).rows(), bounds_of_impulses(*problem.contact()));
  Inequalities inequalities(all.rows);
  int nodes = kNodes;
  ExactTruth result{find_complementary_point(inequalities, nodes)};
  if (result.truth == Truth::kSolvable) result.z = all.restored(inequalities);
  return result;
}

ExactTruth contact_truth(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  if (contact.has_rows()) return truth_with_rows(problem);
  const bool nothing_asked =
      contact.offset_t.size() == 0 && std::all_of(contact.b.begin(), contact.b.end(), [](double b) { return b >= 0; });
  if (nothing_asked && positive_definite(exact_inertia(contact.inertia))) return {Truth::kSolvable};
  const DyadicMatrix P = range_basis(contact.inertia);
  const DyadicMatrix edges = cone_edges(contact);
  DyadicVector q = product(transposed(edges), exact(contact.v));
  Index column = contact.nc();
  for (Index c = 0; c < contact.nc(); ++c) {
    q[at(c)] = q[at(c)] + offset_of(contact, c);
    for (int t = 0; t < contact.edges[at(c)]; ++t, ++column) {
      q[at(column)] = q[at(column)] + offset_of(contact, c) + Dyadic(contact.mu(c)) * slip_offset(contact, c, t);
    }
  }
  if (moves_nothing_and_falls(P, exact(to_dense(contact.N)), q, contact)) return {Truth::kUnsolvable};
  const bool copositive = positive_semidefinite(exact_inertia(contact.inertia));
  if (copositive && !moves_nothing_and_falls(P, edges, q, contact)) return {Truth::kSolvable};
  if (problem.size() > kLargestSearched) return {};
  Inequalities inequalities(Judge(problem).rows());
  int nodes = kNodes;
  return {find_complementary_point(inequalities, nodes)};
}

bool nonnegative(const DyadicVector& x) {
  return std::all_of(x.begin(), x.end(), [](const Dyadic& value) { return value.sign() >= 0; });
}

}  // namespace

Dyadic slip_offset(const ContactProblem& contact, Index c, int direction) {
  const int edges = contact.edges[at(c)];
  const Dyadic along(contact.tangential_offset(c, edges == 4 ? direction % 2 : 0));
  return 2 * direction < edges ? along : -along;
}

ExactTruth exact_truth(const Problem& problem) {
  return problem.contact() != nullptr ? contact_truth(problem) : lcp_truth(problem);
}

LcpBounds bounds_of_impulses(const ContactProblem& contact) {
  const Index n = lcp_size(contact), m = contact.rows.size();
  LcpBounds bounds = LcpBounds::nonnegative(n);
  for (Index i = 0; i < m; ++i) {
    const LcpBounds& given = contact.rows.bounds;
    bounds.lower(n - m + i) = given.lower(i);
    bounds.upper(n - m + i) = given.upper(i);
    bounds.mu(n - m + i) = given.mu(i);
    if (const int of = given.friction_of[at(i)]; of >= 0) {
      bounds.friction_of[at(n - m + i)] = of + static_cast<int>(n - m);
    }
  }
  return bounds;
}

bool disproves(const Problem& problem, const DyadicVector& u) {
  if (const ContactProblem* contact = problem.contact()) {
    const Index nc = contact->nc(), m = contact->rows.size();
    if (static_cast<Index>(u.size()) != nc + m) return false;
    const DyadicVector of_contacts(u.begin(), u.begin() + nc), of_rows(u.begin() + nc, u.end());
    if (!nonnegative(of_contacts)) return false;
    DyadicVector f = product(exact(to_dense(contact->N)), of_contacts);
    const DyadicMatrix R = m > 0 ? exact(to_dense(contact->rows.R)) : DyadicMatrix(contact->ngc(), 0);
    const DyadicVector f_R = product(R, of_rows);
    for (std::size_t k = 0; k < f.size(); ++k) f[k] = f[k] + f_R[k];
    const DyadicVector moved = product(transposed(range_basis(contact->inertia)), f);
    const bool still = std::all_of(moved.begin(), moved.end(), [](const Dyadic& x) { return x.sign() == 0; });
    Dyadic falls = dot(exact(contact->v), f);
    for (Index i = 0; i < contact->nc(); ++i) {
      falls = falls + offset_of(*contact, i) * u[at(i)];
      if (contact->normal_compliance(i) != 0 && u[at(i)].sign() != 0) return false;
    }
    for (Index i = 0; i < m; ++i) {
      const int sign = of_rows[at(i)].sign();
      if (sign == 0) continue;
      const LcpBounds& bounds = contact->rows.bounds;
      const double bound = sign > 0 ? bounds.upper(i) : bounds.lower(i);
      if (std::isfinite(bound) || bounds.friction_of[at(i)] >= 0 || contact->rows.yields(i) != 0) return false;
      falls = falls + Dyadic(contact->rows.offset(i)) * of_rows[at(i)];
    }
    return still && falls.sign() < 0;
  }
  const Lcp& lcp = problem.lcp();
  if (static_cast<Index>(u.size()) != lcp.size() || !nonnegative(u)) return false;
  const DyadicVector slope = product(transposed(exact(lcp.M)), u);
  return std::none_of(slope.begin(), slope.end(), [](const Dyadic& x) { return x.sign() > 0; }) &&
         dot(exact(lcp.q), u).sign() < 0;
}

bool disproves(const Problem& problem, const Vector& u) { return u.allFinite() && disproves(problem, exact(u)); }

DyadicMatrix exact_inertia(const Inertia& inertia) {
  if (const auto* given = std::get_if<InverseInertia>(&inertia)) return exact(given->Ginv);
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    DyadicMatrix weighted = exact(factors->X);
    for (Index i = 0; i < weighted.rows; ++i) {
      for (Index k = 0; k < weighted.cols; ++k) weighted(i, k) = weighted(i, k) * Dyadic(factors->alpha(k));
    }
    return product(weighted, transposed(exact(factors->X)));
  }
  return exact(dense_inertia(inertia));
}

Inverse exact_response(const Inertia& inertia) {
  if (const auto* given = std::get_if<InverseInertia>(&inertia)) return {exact(given->Ginv), Dyadic(1.0)};
  const DyadicMatrix G = exact_inertia(inertia);
  if (const std::optional<Inverse> regular = inverse(G)) return *regular;
  const DyadicMatrix X = range_basis(inertia);
  const std::vector<Index> chosen = independent_columns(X);
  DyadicMatrix basis(X.rows, static_cast<Index>(chosen.size()));
  for (Index i = 0; i < X.rows; ++i) {
    for (std::size_t k = 0; k < chosen.size(); ++k) basis(i, static_cast<Index>(k)) = X(i, chosen[k]);
  }
  Inverse part = inverse(product(product(transposed(basis), G), basis)).value();
  return {product(product(basis, part.numerator), transposed(basis)), part.denominator};
}

}  // namespace lcpbench::attack
