#include "study/certify/exact_problem.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/compliance.h"

namespace lcpbench::exact {
namespace {

constexpr int kDirectionBits = 40;
/// The most entries of a system: 512 MiB of them.
constexpr Index kMostEntries = Index{1} << 26;

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

/// Where doubles do not prove it, integers do: elimination exchanges no rows of a definite matrix, and leaves its
/// leading minors on the diagonal. @pre symmetric
bool positive_definite(const Matrix& A, const Deadline& deadline) {
  if (A.rows() == 0 || definite_in_double(A)) return true;
  IntegerMatrix minors = to_dyadic(A).m;
  const std::vector<Index> in_order = range(0, A.rows());
  std::vector<slong> order(in_order.begin(), in_order.end());
  const double n = static_cast<double>(A.rows());
  deadline.require(1e-5 * n * n * n * n * static_cast<double>(1 + std::abs(fmpz_mat_max_bits(minors.get())) / 64));
  Integer determinant;
  fmpz_mat_fflu(minors.get(), determinant.get(), order.data(), minors.get(), 0);
  return std::equal(order.begin(), order.end(), in_order.begin()) &&
         std::all_of(in_order.begin(), in_order.end(), [&](Index i) { return minors.sign(i, i) > 0; });
}

/// Divides each row by the largest power of two that divides it.
void shorten_rows(ExactSystem& system) {
  for (Index i = 0; i < system.rows.rows(); ++i) {
    slong common = std::numeric_limits<slong>::max();
    for (Index j = 0; j < system.rows.cols(); ++j) {
      if (system.rows.sign(i, j) != 0) common = std::min(common, static_cast<slong>(fmpz_val2(system.rows(i, j))));
    }
    if (common == 0 || common == std::numeric_limits<slong>::max()) continue;
    for (Index j = 0; j < system.rows.cols(); ++j) {
      fmpz_tdiv_q_2exp(system.rows(i, j), system.rows(i, j), static_cast<ulong>(common));
    }
    if (i >= system.potentials) system.exponents[index(i - system.potentials)] += common;
  }
}

/// A system of zeros. @returns false where it would be too large
bool set_size(Index potentials, Index size, ExactSystem& system) {
  if (potentials + size >= kMostEntries || (potentials + size) * (1 + potentials + size) > kMostEntries) return false;
  system = {potentials, size, IntegerMatrix(potentials + size, 1 + potentials + size), {}};
  system.exponents.assign(index(size), 0);
  return true;
}

/// Sets a part of the rows, from entry (row, column) on. @pre exponent <= block.exponent
void place(const Dyadic& block, slong exponent, int sign, Index row, Index column, ExactSystem& system) {
  for (Index i = 0; i < block.m.rows(); ++i) {
    for (Index j = 0; j < block.m.cols(); ++j) {
      add_shifted(system.rows(row + i, column + j), block.m(i, j), block.exponent - exponent, sign);
    }
  }
}

/// Adds b, C'(offset_t + r_t C f_D) and r_n f_N to the rows of the velocities, whose unit is 2^exponent.
void add_offsets(const ContactProblem& contact, const ContactLayout& layout, slong exponent, ExactSystem& system,
                 const std::array<Dyadic, 4>& softness) {
  const auto& [b, r_n, r_t, offset_t] = softness;
  for (Index i = 0; i < layout.nc; ++i) {
    add_shifted(system.rows(system.row_of(i), 0), b.m(i), b.exponent - exponent);
    add_shifted(system.rows(system.row_of(i), system.column_of(i)), r_n.m(i), r_n.exponent - exponent);
    if (fmpz_is_zero(r_t.m(i)) && fmpz_is_zero(offset_t.m(2 * i)) && fmpz_is_zero(offset_t.m(2 * i + 1))) continue;
    const Index first = layout.friction_offset() + layout.friction_begin[index(i)];
    const Index edges = contact.edges[index(i)];
    for (Index k = 0; k < edges; ++k) {
      const Index row = system.row_of(first + k);
      const std::array<slong, 2> a = whole_direction(k, edges);
      for (const Index tangent : {0, 1}) {
        const slong along = a[index(tangent)];
        add_shifted(system.rows(row, 0), offset_t.m(2 * i + tangent), offset_t.exponent - kDirectionBits - exponent,
                    along);
        for (Index l = 0; l < edges; ++l) {
          Integer yielding(r_t.m(i));
          fmpz_mul_si(yielding.get(), yielding.get(), whole_direction(l, edges)[index(tangent)]);
          add_shifted(system.rows(row, system.column_of(first + l)), yielding.get(),
                      r_t.exponent - 2 * kDirectionBits - exponent, along);
        }
      }
    }
  }
}

/// lambda in the rows of the friction columns, and the rows mu_i f_N,i - sum of f_D.
void add_friction_rows(const ContactProblem& contact, const ContactLayout& layout, slong exponent,
                       ExactSystem& system) {
  const Dyadic mu = to_dyadic(contact.mu);
  const slong unit = std::min(mu.exponent, slong{0});
  const Integer one(1);
  for (Index c = 0; c < layout.cones; ++c) {
    const Index i = layout.cone_contact[index(c)];
    const Index lambda = layout.lambda_offset() + c;
    const Index row = system.row_of(lambda);
    system.exponents[index(lambda)] = unit;
    add_shifted(system.rows(row, system.column_of(i)), mu.m(i), mu.exponent - unit);
    for (Index t = layout.friction_begin[index(i)]; t < layout.friction_begin[index(i) + 1]; ++t) {
      const Index friction = layout.friction_offset() + t;
      add_shifted(system.rows(system.row_of(friction), system.column_of(lambda)), one.get(), -exponent);
      add_shifted(system.rows(row, system.column_of(friction)), one.get(), -unit, -1);
    }
  }
}

/// K p = B f, and q = C'v, R.
struct Parts {
  Dyadic K, B, R, q;
};

Parts parts_of(const ContactProblem& contact, ExactProblem& problem, const Deadline& deadline) {
  Matrix dense(contact.ngc(), contact.nc() + cols(contact.D));
  dense << to_dense(contact.N), to_dense(contact.D);
  const Dyadic C = transposed(to_dyadic(dense));
  Parts parts{.K = Dyadic(), .B = Dyadic(), .R = C, .q = C * problem.v};
  if (const auto* factors = std::get_if<FactoredInertia>(&contact.inertia)) {
    std::vector<Index> weighted;
    for (Index j = 0; j < factors->alpha.size(); ++j) {
      if (factors->alpha(j) != 0) weighted.push_back(j);
    }
    const Dyadic X = to_dyadic(factors->X(Eigen::all, weighted));
    const Dyadic gram = transposed(X) * X;
    parts.K = gram * to_dyadic(Matrix(factors->alpha(weighted).asDiagonal())) * gram;
    parts.R = C * X;
    problem.shape = X;
    problem.semidefinite = (factors->alpha.array() >= 0).all();
    problem.full_rank = problem.semidefinite && std::ssize(independent_columns(X.m, deadline)) == contact.ngc();
    if (!problem.semidefinite) problem.refusal = "the inertia has a factor with a negative weight";
  } else if (const auto* inverse = std::get_if<InverseInertia>(&contact.inertia)) {
    parts.K = to_dyadic(Matrix::Identity(contact.ngc(), contact.ngc()));
    parts.B = to_dyadic(inverse->Ginv) * transposed(C);
    const bool is_symmetric = symmetric(inverse->Ginv);
    problem.semidefinite = problem.full_rank = is_symmetric && positive_definite(inverse->Ginv, deadline);
    if (!is_symmetric) problem.refusal = "the inverse of the inertia is not symmetric";
    return parts;
  } else {
    const Matrix G = dense_inertia(contact.inertia);
    parts.K = to_dyadic(G);
    problem.semidefinite = problem.full_rank = symmetric(G) && positive_definite(G, deadline);
    if (!problem.full_rank) {
      problem.refusal = "the inertia is not symmetric positive definite, and no factors are given";
    }
  }
  parts.B = transposed(parts.R);
  return parts;
}

void set_contacts(const ContactProblem& contact, ExactProblem& problem, const Deadline& deadline) {
  const ContactLayout layout = contact_layout(contact);
  problem.v = to_dyadic(contact.v);
  const Parts parts = parts_of(contact, problem, deadline);
  ExactSystem& system = problem.system;
  if (problem.refusal.empty() && !set_size(parts.K.m.rows(), layout.size(), system)) problem.refusal = "too large";
  if (!problem.refusal.empty()) return;
  const slong inertia_unit = std::min(parts.K.exponent, parts.B.exponent);
  place(parts.K, inertia_unit, 1, 0, 1, system);
  place(parts.B, inertia_unit, -1, 0, system.column_of(0), system);
  const auto of_contacts = [&](auto&& value) { return to_dyadic(Vector::NullaryExpr(layout.nc, value)); };
  const std::array<Dyadic, 4> softness{
      of_contacts([&](Index i) { return contact.offset(i); }),
      of_contacts([&](Index i) { return contact.normal_compliance(i); }),
      of_contacts([&](Index i) { return contact.tangential_compliance(i); }),
      to_dyadic(Vector::NullaryExpr(2 * layout.nc, [&](Index i) { return contact.tangential_offset(i / 2, static_cast<int>(i % 2)); }))};
  const auto& [b, r_n, r_t, offset_t] = softness;
  const slong unit = std::min({slong{0}, parts.q.exponent, parts.R.exponent, b.exponent, r_n.exponent,
                               r_t.exponent - 2 * kDirectionBits, offset_t.exponent - kDirectionBits});
  std::fill_n(system.exponents.begin(), layout.lambda_offset(), unit);
  place(parts.q, unit, 1, system.row_of(0), 0, system);
  place(parts.R, unit, 1, system.row_of(0), 1, system);
  add_offsets(contact, layout, unit, system, softness);
  add_friction_rows(contact, layout, unit, system);
  shorten_rows(system);
}

void set_bare(const Lcp& lcp, ExactProblem& problem) {
  if (!set_size(0, lcp.size(), problem.system)) {
    problem.refusal = "too large";
    return;
  }
  for (Index i = 0; i < lcp.size(); ++i) {
    Matrix row(1, 1 + lcp.size());
    row << lcp.q(i), lcp.M.row(i);
    const Dyadic exact = to_dyadic(row);
    problem.system.exponents[index(i)] = exact.exponent;
    place(exact, exact.exponent, 1, i, 0, problem.system);
  }
  shorten_rows(problem.system);
}

}  // namespace

IntegerMatrix ExactSystem::values(const Point& point, const Deadline& deadline) const {
  const double words = static_cast<double>(1 + std::abs(fmpz_mat_max_bits(point.get())) / 64);
  deadline.require(0.002 * words * static_cast<double>(rows.rows() * rows.cols()));
  return rows * point;
}

IntegerMatrix ExactSystem::in_one_unit() const {
  IntegerMatrix result = part(rows, range(potentials, potentials + size), range(0, rows.cols()));
  const slong least = exponents.empty() ? 0 : *std::min_element(exponents.begin(), exponents.end());
  for (Index i = 0; i < size; ++i) {
    const auto shift = static_cast<ulong>(exponents[index(i)] - least);
    for (Index j = 0; j < result.cols(); ++j) fmpz_mul_2exp(result(i, j), result(i, j), shift);
  }
  return result;
}

ExactProblem::ExactProblem(const Problem& problem, const Deadline& deadline) {
  if (problem.contact() != nullptr) {
    set_contacts(*problem.contact(), *this, deadline);
  } else {
    set_bare(problem.lcp(), *this);
  }
}

ExactSystem edge_system(const ContactProblem& contact, const ExactProblem& problem) {
  const ContactLayout layout = contact_layout(contact);
  const ExactSystem& all = problem.system;
  const Dyadic mu = to_dyadic(contact.mu);
  ExactSystem edges{all.potentials, layout.lambda_offset(), IntegerMatrix(), {}};
  const Index order = edges.potentials + edges.size;
  edges.rows = part(all.rows, range(0, order), range(0, 1 + order));
  edges.exponents.assign(all.exponents.begin(), all.exponents.begin() + edges.size);
  // to = normal + mu to, times a power of two, where the two are units 2^from and 2^own
  const auto add_normal = [&](fmpz* to, const fmpz* normal, Index i, slong from, slong own) {
    const slong unit = std::min(from, mu.exponent + own);
    Integer sum;
    fmpz_mul(sum.get(), to, mu.m(i));
    fmpz_mul_2exp(sum.get(), sum.get(), static_cast<ulong>(mu.exponent + own - unit));
    add_shifted(sum.get(), normal, from - unit);
    fmpz_swap(to, sum.get());
  };
  for (Index i = 0; i < layout.nc; ++i) {
    for (Index t = layout.friction_begin[index(i)]; t < layout.friction_begin[index(i) + 1]; ++t) {
      const Index friction = layout.friction_offset() + t;
      for (Index row = 0; row < edges.potentials; ++row) {
        add_normal(edges.rows(row, edges.column_of(friction)), edges.rows(row, edges.column_of(i)), i, 0, 0);
      }
      for (Index column = 0; column <= edges.potentials; ++column) {
        add_normal(edges.rows(edges.row_of(friction), column), edges.rows(edges.row_of(i), column), i,
                   edges.exponents[index(i)], edges.exponents[index(friction)]);
      }
    }
  }
  for (Index i = 0; i < edges.size; ++i) {
    for (Index j = 0; j < edges.size; ++j) fmpz_zero(edges.rows(edges.row_of(i), edges.column_of(j)));
  }
  return edges;
}

bool is_solution(const ExactSystem& system, const Point& point, const IntegerMatrix& values) {
  if (point.sign(0) <= 0) return false;
  for (Index i = 0; i < system.potentials; ++i) {
    if (values.sign(i) != 0) return false;
  }
  for (Index i = 0; i < system.size; ++i) {
    const int w = values.sign(system.row_of(i));
    const int z = point.sign(system.column_of(i));
    if (w < 0 || z < 0 || (w > 0 && z > 0)) return false;
  }
  return true;
}

bool is_contradiction(const ExactSystem& system, const IntegerMatrix& u) {
  for (Index i = 0; i < system.size; ++i) {
    if (u.sign(i) < 0) return false;
  }
  const std::vector<Index> columns = range(system.column_of(0), system.rows.cols());
  const IntegerMatrix moved = part(system.rows, range(0, system.potentials), columns) * u;
  if (fmpz_mat_is_zero(moved.get()) == 0) return false;
  const IntegerMatrix sums = transposed(system.in_one_unit()) * u;
  return sums.sign(0) < 0 &&
         std::all_of(columns.begin(), columns.end(), [&](Index column) { return sums.sign(column) <= 0; });
}

bool is_solvability_proof(const ContactProblem& contact, const ExactSystem& edges, const IntegerMatrix& values) {
  const ContactLayout layout = contact_layout(contact);
  if (!(contact.mu.array() >= 0).all()) return false;
  for (Index i = 0; i < layout.nc; ++i) {
    if (contact.normal_compliance(i) > 0) continue;  // it has no impulse where nothing yields
    if (values.sign(edges.row_of(i)) < 0) return false;
    // Impulses that move nothing and do not yield cancel in pairs; those of more edges need not.
    if (contact.tangential_compliance(i) > 0 && contact.edges[index(i)] <= 4) continue;
    for (Index t = layout.friction_begin[index(i)]; t < layout.friction_begin[index(i) + 1]; ++t) {
      if (values.sign(edges.row_of(layout.friction_offset() + t)) < 0) return false;
    }
  }
  return true;
}

}  // namespace lcpbench::exact
