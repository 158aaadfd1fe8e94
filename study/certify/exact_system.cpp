#include "study/certify/exact_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/compliance.h"
#include "core/exact_inertia.h"
#include "study/certify/integer_solve.h"

namespace lcpbench::exact {
namespace {

constexpr int kEvenings = 4;
constexpr int kDirectionBits = 40;

/// edge_direction() times 2^kDirectionBits.
std::array<slong, 2> whole_direction(Index k, Index edges) {
  const std::array<double, 2> direction = edge_direction(k, edges);
  const auto whole = [](double x) { return static_cast<slong>(std::ldexp(x, kDirectionBits)); };
  return {whole(direction[0]), whole(direction[1])};
}

bool symmetric(const Matrix& G) { return G == G.transpose(); }

/// Proven by Cholesky's method in double on A less a bound of its rounding error, at most (n + 1) u trace(A) to first
/// order in the spectral norm; that of the subtraction is below u trace(A), and four times as much leaves room for the
/// higher orders. [Rump, Verification of positive definiteness, BIT 46 (2006)]
bool definite_in_double(const Matrix& A) {
  // So far from the ends of the range nothing underflows to any effect. An entry beside the diagonal may overflow.
  if (!(A.diagonal().minCoeff() >= 1e-140 && A.diagonal().maxCoeff() <= 1e140)) return false;
  Matrix shifted = A;
  shifted.diagonal().array() -=
      4 * static_cast<double>(A.rows() + 2) * std::numeric_limits<double>::epsilon() * A.trace();
  const Eigen::LLT<Matrix> factor(shifted);
  return factor.info() == Eigen::Success && factor.matrixLLT().allFinite();
}

/// Where doubles do not prove it, the signs of the leading minors do, exactly. @pre symmetric
bool positive_definite(const Matrix& A) {
  if (A.rows() == 0 || definite_in_double(A)) return true;
  return A.rows() <= kMostExactCoordinates && is_positive_definite(ExactMatrix(A)).value_or(false);
}

ExactInertia of_matrix(const Matrix& G) {
  ExactInertia inertia;
  inertia.K = to_dyadic(G);
  inertia.semidefinite = inertia.full_rank = symmetric(G) && positive_definite(G);
  if (!inertia.full_rank) inertia.refusal = "the inertia is not symmetric positive definite, and no factors are given";
  return inertia;
}

// K = (X1'X) A (X'X1), X1 the columns that span the range of G = X A X'.
ExactInertia of_factors(const FactoredInertia& factors, const std::vector<Index>& spanning, const Deadline& deadline) {
  ExactInertia inertia;
  const Dyadic X = to_dyadic(factors.X);
  const Dyadic X1{columns(X.m, spanning), X.exponent};
  const Dyadic alpha = to_dyadic(factors.alpha);
  Dyadic weighted = product(transposed(X1), X, deadline);
  const Dyadic gram = weighted;
  for (Index j = 0; j < X.m.cols(); ++j) {
    for (Index i = 0; i < weighted.m.rows(); ++i) fmpz_mul(weighted.m(i, j), weighted.m(i, j), alpha.m(j, 0));
  }
  weighted.exponent += alpha.exponent;
  inertia.K = product(weighted, transposed(gram), deadline);
  inertia.left = inertia.right = transposed(X1);
  inertia.velocity = X1;
  inertia.semidefinite = (factors.alpha.array() >= 0).all();
  inertia.full_rank = inertia.semidefinite && X1.m.cols() == X1.m.rows();
  if (!inertia.semidefinite) inertia.refusal = "the inertia has a factor with a negative weight";
  return inertia;
}

ExactInertia of_inverse(const Matrix& Ginv) {
  ExactInertia inertia;
  inertia.K.m = IntegerMatrix(Ginv.rows(), Ginv.rows());
  fmpz_mat_one(inertia.K.m.get());
  inertia.left = to_dyadic(Ginv);
  inertia.semidefinite = inertia.full_rank = symmetric(Ginv) && positive_definite(Ginv);
  if (!symmetric(Ginv)) inertia.refusal = "the inverse of the inertia is not symmetric";
  return inertia;
}

Dyadic applied(const std::optional<Dyadic>& map, const Dyadic& C, const Deadline& deadline) {
  return map ? product(*map, C, deadline) : C;
}

/// C = [N D 0] (ngc x n): a column of zeros for each of so many lambdas.
Dyadic contact_columns(const ContactProblem& problem, Index lambdas) {
  const Index nc = cols(problem.N);
  const Index friction = cols(problem.D);
  Matrix C = Matrix::Zero(problem.ngc(), nc + friction + lambdas);
  C.leftCols(nc) = to_dense(problem.N);
  C.middleCols(nc, friction) = to_dense(problem.D);
  return to_dyadic(C);
}

// The doubles mu over 2^exponent, with an exponent <= 0: then 1 is a whole number of units too.
Dyadic coefficients(const Vector& mu) {
  const Dyadic exact = to_dyadic(mu);
  return refined(exact, std::min(exact.exponent, slong{0}));
}

void add_friction_rows(const ContactProblem& problem, const ContactLayout& layout, ExactSystem& system) {
  const Dyadic mu = coefficients(problem.mu);
  Integer minus_one(-1);
  shift_left(minus_one, -mu.exponent);
  for (Index c = 0; c < layout.cones; ++c) {
    const Index contact = layout.cone_contact[index(c)];
    const Index lambda = layout.lambda_offset() + c;
    system.w_exponent[index(lambda)] = mu.exponent + system.z_exponent[index(contact)];
    auto& cone_row = system.S[index(lambda)];
    Integer coefficient;
    fmpz_set(coefficient.get(), mu.m(contact, 0));
    cone_row.push_back({contact, coefficient});
    for (Index t = layout.friction_begin[index(contact)]; t < layout.friction_begin[index(contact) + 1]; ++t) {
      const Index row = layout.friction_offset() + t;
      system.S[index(row)].push_back({lambda, Integer(1)});
      cone_row.push_back({row, minus_one});
    }
  }
}

/// Units of z, powers of two, in which the columns of M differ as little as they can: entries that lie hundreds of
/// orders of magnitude apart would make long integers of short ones.
std::vector<slong> even_columns(const Lcp& lcp) {
  const Matrix present = (lcp.M.array() != 0).cast<double>();
  const Matrix logs = lcp.M.unaryExpr([](double x) { return x == 0 ? 0.0 : static_cast<double>(std::ilogb(x)); });
  const Vector in_row = present.rowwise().sum().cwiseMax(1);
  const Vector in_column = present.colwise().sum().transpose().cwiseMax(1);
  Vector columns = Vector::Zero(lcp.size());
  for (int round = 0; round < kEvenings; ++round) {
    const Vector rows = (logs.rowwise().sum() + present * columns).cwiseQuotient(in_row);
    columns = (present.transpose() * rows - logs.colwise().sum().transpose()).cwiseQuotient(in_column);
  }
  std::vector<slong> exponents(index(lcp.size()));
  std::transform(columns.begin(), columns.end(), exponents.begin(), [](double c) { return std::lround(c); });
  return exponents;
}

}  // namespace

std::vector<Index> weighted_factors(const FactoredInertia& inertia) {
  std::vector<Index> weighted;
  for (Index j = 0; j < inertia.X.cols(); ++j) {
    if (inertia.alpha(j) != 0) weighted.push_back(j);
  }
  return weighted;
}

std::vector<Index> independent_factors(const FactoredInertia& inertia, const Deadline& deadline) {
  const std::vector<Index> weighted = weighted_factors(inertia);
  std::vector<Index> independent;
  for (const Index j : independent_minor(columns(to_dyadic(inertia.X).m, weighted), deadline).columns) {
    independent.push_back(weighted[index(j)]);
  }
  return independent;
}

ExactInertia exact_inertia(const Inertia& inertia, const std::vector<Index>& factors, const Deadline& deadline) {
  if (const auto* factored = std::get_if<FactoredInertia>(&inertia)) return of_factors(*factored, factors, deadline);
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) return of_inverse(inverse->Ginv);
  return of_matrix(dense_inertia(inertia));
}

Dyadic velocities_before(const Dyadic& C, const Dyadic& v, const Dyadic& offsets, const Deadline& deadline) {
  Dyadic q = product(transposed(C), v, deadline);
  if (offsets.m.rows() == 0) return q;
  const slong unit = std::min(q.exponent, offsets.exponent);
  q = refined(std::move(q), unit);
  const Dyadic added = refined(offsets, unit);
  for (Index i = 0; i < added.m.rows(); ++i) fmpz_add(q.m(i, 0), q.m(i, 0), added.m(i, 0));
  return q;
}

ExactSystem frictionless_system(const ExactInertia& inertia, const Dyadic& C, const Dyadic& q,
                                const Deadline& deadline) {
  ExactSystem system;
  const Dyadic left = applied(inertia.left, C, deadline);
  const Dyadic right = applied(inertia.right, C, deadline);
  const Index n = C.m.cols();
  system.K = inertia.K.m;
  system.L = left.m;
  system.R = right.m;
  system.S.resize(index(n));
  system.q.resize(index(n));
  for (Index i = 0; i < n; ++i) fmpz_set(system.q[index(i)].get(), q.m(i, 0));
  // K 2^eK p 2^ep = L 2^eL z 2^ez and R 2^eR p 2^ep in the units 2^eq of q.
  system.p_exponent = q.exponent - right.exponent;
  system.z_exponent.assign(index(n), inertia.K.exponent + system.p_exponent - left.exponent);
  system.w_exponent.assign(index(n), q.exponent);
  return system;
}

/// The offsets of the rows of J; no rows where the problem has none.
Dyadic offsets_of_rows(const ContactProblem& problem, const ContactLayout& layout) {
  if (!problem.has_offset() && problem.offset_t.size() == 0) return {IntegerMatrix(0, 1), 0};
  Vector normal = Vector::Zero(layout.lambda_offset());
  if (problem.has_offset()) normal.head(layout.nc) = problem.b;
  Dyadic offsets = to_dyadic(normal);
  if (problem.offset_t.size() == 0) return offsets;
  const Dyadic along = to_dyadic(problem.offset_t);
  const slong exponent = std::min(offsets.exponent, along.exponent - kDirectionBits);
  offsets = refined(std::move(offsets), exponent);
  for (Index i = 0; i < layout.nc; ++i) {
    const Index begin = layout.friction_begin[index(i)];
    const Index edges = layout.friction_begin[index(i) + 1] - begin;
    for (Index k = 0; k < edges; ++k) {
      fmpz* const to = offsets.m(layout.friction_offset() + begin + k, 0);
      const std::array<slong, 2> direction = whole_direction(k, edges);
      fmpz_addmul_si(to, along.m(2 * i, 0), direction[0]);
      fmpz_addmul_si(to, along.m(2 * i + 1, 0), direction[1]);
      fmpz_mul_2exp(to, to, static_cast<ulong>(along.exponent - kDirectionBits - exponent));
    }
  }
  return offsets;
}

/// Adds r_n and r_t C'C to the rows of w. z gets coarser units where these need it to be integers.
void add_compliance(const ContactProblem& problem, const ContactLayout& layout, ExactSystem& system) {
  struct Entry {
    Index row, column;
    Integer value;  ///< times 2^exponent
    slong exponent;
  };
  std::vector<Entry> entries;
  for (Index i = 0; i < layout.nc; ++i) {
    const Parts n = dyadic(problem.normal_compliance(i));
    if (n.odd != 0) entries.push_back({i, i, Integer(n.odd), n.exponent});
    const Parts t = dyadic(problem.tangential_compliance(i));
    const Index edges = t.odd != 0 ? problem.edges[index(i)] : 0;
    const Index first = layout.friction_offset() + layout.friction_begin[index(i)];
    for (Index k = 0; k < edges; ++k) {
      const std::array<slong, 2> a = whole_direction(k, edges);
      for (Index l = 0; l < edges; ++l) {
        const std::array<slong, 2> b = whole_direction(l, edges);
        Integer cosine;  // of the angle between the two directions
        fmpz_addmul_si(cosine.get(), Integer(a[0]).get(), b[0]);
        fmpz_addmul_si(cosine.get(), Integer(a[1]).get(), b[1]);
        fmpz_mul_si(cosine.get(), cosine.get(), t.odd);
        if (cosine.sign() != 0) entries.push_back({first + k, first + l, cosine, t.exponent - 2 * kDirectionBits});
      }
    }
  }
  const auto shift = [&](const Entry& entry) {
    return entry.exponent + system.z_exponent[index(entry.column)] - system.w_exponent[index(entry.row)];
  };
  slong missing = 0;
  for (const Entry& entry : entries) missing = std::max(missing, -shift(entry));
  if (missing > 0) {
    fmpz_mat_scalar_mul_2exp(system.L.get(), system.L.get(), static_cast<ulong>(missing));
    for (slong& exponent : system.z_exponent) exponent += missing;
  }
  for (Entry& entry : entries) {
    fmpz_mul_2exp(entry.value.get(), entry.value.get(), static_cast<ulong>(shift(entry)));
    system.S[index(entry.row)].push_back({entry.column, std::move(entry.value)});
  }
}

ExactSystem contact_system(const ContactProblem& problem, const ExactInertia& inertia, const Deadline& deadline) {
  const ContactLayout layout = contact_layout(problem);
  const Dyadic C = contact_columns(problem, layout.cones);
  const Dyadic q = velocities_before(C, to_dyadic(problem.v), offsets_of_rows(problem, layout), deadline);
  ExactSystem system = frictionless_system(inertia, C, q, deadline);
  if (problem.is_soft()) add_compliance(problem, layout, system);
  std::fill(system.z_exponent.begin() + layout.lambda_offset(), system.z_exponent.end(), q.exponent);
  add_friction_rows(problem, layout, system);
  return system;
}

/// From a column for each contact and for each friction direction, columns for the edges of all cones: column i of
/// every contact, and column i + mu_i column t of each of its directions t.
Dyadic of_edges(const ContactProblem& problem, const Dyadic& columns) {
  const ContactLayout layout = contact_layout(problem);
  const Dyadic mu = coefficients(problem.mu);
  Dyadic edges = refined(columns, columns.exponent + mu.exponent);
  for (Index contact = 0; contact < layout.nc; ++contact) {
    for (Index t = layout.friction_begin[index(contact)]; t < layout.friction_begin[index(contact) + 1]; ++t) {
      const Index column = layout.friction_offset() + t;
      for (Index i = 0; i < edges.m.rows(); ++i) {
        fmpz_mul(edges.m(i, column), columns.m(i, column), mu.m(contact, 0));
        fmpz_add(edges.m(i, column), edges.m(i, column), edges.m(i, contact));
      }
    }
  }
  return edges;
}

Dyadic cone_edges(const ContactProblem& problem) { return of_edges(problem, contact_columns(problem, 0)); }

Dyadic offsets_of_edges(const ContactProblem& problem) {
  const Dyadic rows = offsets_of_rows(problem, contact_layout(problem));
  return rows.m.rows() == 0 ? rows : transposed(of_edges(problem, transposed(rows)));
}

ExactSystem bare_system(const Lcp& lcp) {
  ExactSystem system;
  const Index n = lcp.size();
  system.L = system.R = IntegerMatrix(0, n);
  system.S.resize(index(n));
  system.q.resize(index(n));
  system.z_exponent = even_columns(lcp);
  system.w_exponent.resize(index(n));
  for (Index i = 0; i < n; ++i) {
    // The terms of w_i: q_i, then M_ij 2^z_exponent[j].
    slong least = std::numeric_limits<slong>::max();
    if (lcp.q(i) != 0) least = dyadic(lcp.q(i)).exponent;
    for (Index j = 0; j < n; ++j) {
      if (lcp.M(i, j) == 0) continue;
      least = std::min(least, dyadic(lcp.M(i, j)).exponent + system.z_exponent[index(j)]);
    }
    if (least == std::numeric_limits<slong>::max()) least = 0;
    system.w_exponent[index(i)] = least;
    fmpz_set_d_2exp(system.q[index(i)].get(), lcp.q(i), -least);
    for (Index j = 0; j < n; ++j) {
      if (lcp.M(i, j) == 0) continue;
      Term term{j, {}};
      fmpz_set_d_2exp(term.value.get(), lcp.M(i, j), system.z_exponent[index(j)] - least);
      system.S[index(i)].push_back(std::move(term));
    }
  }
  return system;
}

}  // namespace lcpbench::exact
