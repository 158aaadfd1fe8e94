#include "study/certify/exact_problem.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/compliance.h"

namespace lcpbench::exact {
namespace {

/// Of one entry of a product, in steps of Deadline.
constexpr double kEntry = 0.002;
/// The most entries of a system: 512 MiB of them.
constexpr Index kMostEntries = Index{1} << 26;

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

/// K, B, R, Y and what is proven of them.
void set_inertia(const ContactProblem& contact, const Dyadic& C, ExactProblem& problem, const Deadline& deadline) {
  problem.R = transposed(C);
  problem.shape = to_dyadic(Matrix::Identity(contact.ngc(), contact.ngc()));
  if (const auto* factors = std::get_if<FactoredInertia>(&contact.inertia)) {
    std::vector<Index> weighted;
    for (Index j = 0; j < factors->alpha.size(); ++j) {
      if (factors->alpha(j) != 0) weighted.push_back(j);
    }
    problem.shape = to_dyadic(factors->X(Eigen::all, weighted));
    const Dyadic gram = transposed(problem.shape) * problem.shape;
    problem.K = gram * to_dyadic(Matrix(factors->alpha(weighted).asDiagonal())) * gram;
    problem.R = problem.R * problem.shape;
    problem.semidefinite = (factors->alpha.array() >= 0).all();
    problem.full_rank =
        problem.semidefinite && std::ssize(independent_columns(problem.shape.m, deadline)) == contact.ngc();
    if (!problem.semidefinite) problem.refusal = "the inertia has a factor with a negative weight";
  } else if (const auto* inverse = std::get_if<InverseInertia>(&contact.inertia)) {
    problem.K = problem.shape;
    problem.B = to_dyadic(inverse->Ginv) * C;
    const bool is_symmetric = symmetric(inverse->Ginv);
    problem.semidefinite = problem.full_rank = is_symmetric && positive_definite(inverse->Ginv, deadline);
    if (!is_symmetric) problem.refusal = "the inverse of the inertia is not symmetric";
    return;
  } else {
    const Matrix G = dense_inertia(contact.inertia);
    problem.K = to_dyadic(G);
    problem.semidefinite = problem.full_rank = symmetric(G) && positive_definite(G, deadline);
    if (!problem.full_rank) {
      problem.refusal = "the inertia is not symmetric positive definite, and no factors are given";
    }
  }
  problem.B = transposed(problem.R);
}

void set_contacts(const ContactProblem& contact, ExactProblem& problem, const Deadline& deadline) {
  const ContactLayout layout = contact_layout(contact);
  const RowUnknowns rows(contact);
  if (contact.has_rows()) problem.rows = rows;
  const Index impulses = layout.lambda_offset(), velocities = rows.cone_offset();
  const Index slacks = std::ssize(rows.slacks);
  Matrix C(contact.ngc(), velocities);
  C.leftCols(impulses) << to_dense(contact.N), to_dense(contact.D);
  // Of bounded rows: the signs of their parts; b, compliance; and the impulses of their origin, by parts.
  Matrix signs = Matrix::Zero(velocities, layout.rows);
  Vector row_b = Vector::Zero(layout.rows), row_compliance = row_b, origin = Vector::Zero(velocities);
  const Matrix R = contact.has_rows() ? to_dense(contact.rows.R) : Matrix(contact.ngc(), 0);
  for (Index k = 0; k < std::ssize(rows.parts); ++k) {
    const auto [row, sign] = rows.parts[index(k)];
    C.col(impulses + k) = sign * R.col(row);
    signs(impulses + k, row) = sign;
    row_b(row) = contact.rows.offset(row);
    row_compliance(row) = contact.rows.yields(row);
    origin(impulses + k) = sign * rows.origin(row);
  }
  // Of the velocities: b and r_n; the directions of friction in both tangents of each contact, where they have an
  // offset or yield; lambda. Then the cone rows, mu_i f_N,i - sum of f_D.
  Vector b = Vector::Zero(velocities);
  Vector yielding = Vector::Zero(velocities);
  Vector offset_t = Vector::Zero(2 * layout.nc);
  Vector compliance_t = Vector::Zero(2 * layout.nc);
  Matrix directions = Matrix::Zero(velocities, contact.is_soft() ? 2 * layout.nc : 0);
  Matrix slip = Matrix::Zero(velocities, layout.cones + slacks);
  Matrix cones = Matrix::Zero(layout.cones + slacks, velocities + layout.cones + slacks);
  for (Index i = 0; i < layout.nc; ++i) {
    b(i) = contact.offset(i);
    yielding(i) = contact.normal_compliance(i);
    for (const int tangent : {0, 1}) offset_t(2 * i + tangent) = contact.tangential_offset(i, tangent);
    compliance_t.segment<2>(2 * i).setConstant(contact.tangential_compliance(i));
    const Index edges = contact.edges[index(i)];
    if (edges > 0) cones(layout.lambda[index(i)], i) = contact.mu(i);
    for (Index k = 0; k < edges; ++k) {
      const Index row = layout.friction_offset() + layout.friction_begin[index(i)] + k;
      const std::array<double, 2> direction = edge_direction(k, edges);
      if (contact.is_soft()) directions.row(row).segment<2>(2 * i) << direction[0], direction[1];
      slip(row, layout.lambda[index(i)]) = 1;
      cones(layout.lambda[index(i)], row) = -1;
    }
  }
  Vector upper = Vector::Zero(layout.cones + slacks), lower = upper;
  for (Index k = 0; k < slacks; ++k) {
    const RowUnknowns::Slack& slack = rows.slacks[index(k)];
    const Index at = layout.cones + k, first = impulses + slack.first;
    for (Index part = first; part <= first + (slack.is_friction() ? 1 : 0); ++part) {
      slip(part, at) = 1;
      cones(at, part) = -1;
    }
    if (slack.is_friction()) {
      cones(at, impulses + slack.load) = rows.bounds.mu(slack.row);
    } else {
      upper(at) = rows.bounds.upper(slack.row);
      lower(at) = rows.bounds.lower(slack.row);
    }
  }
  problem.v = to_dyadic(contact.v);
  const Dyadic columns = to_dyadic(C);
  set_inertia(contact, columns, problem, deadline);
  if (!problem.refusal.empty()) return;
  problem.q = transposed(columns) * problem.v + to_dyadic(b);
  Dyadic S{IntegerMatrix(velocities, velocities), 0};
  if (contact.is_soft()) {
    deadline.require(kEntry * static_cast<double>(2 * layout.nc * velocities * velocities));
    const Dyadic D = to_dyadic(directions);
    problem.q = problem.q + D * to_dyadic(offset_t);
    S = to_dyadic(Matrix(yielding.asDiagonal())) + D * to_dyadic(Matrix(compliance_t.asDiagonal())) * transposed(D);
  }
  if (contact.has_rows()) {
    const Dyadic T = to_dyadic(signs), r = to_dyadic(Matrix(row_compliance.asDiagonal()));
    problem.q = problem.q + T * (to_dyadic(row_b) + r * to_dyadic(rows.origin));
    S = S + T * r * transposed(T);
  }
  const auto zeros = [](Index height, Index width) { return Dyadic{IntegerMatrix(height, width), 0}; };
  const Index k = problem.K.m.rows();
  const Dyadic at_origin = origin.isZero(0) ? zeros(k, 1) : -(problem.B * to_dyadic(origin));
  problem.system = {beside(at_origin, problem.K, -problem.B, zeros(k, slip.cols())),
                    beside(problem.q, problem.R, S, to_dyadic(slip)),
                    beside(to_dyadic(upper) + -to_dyadic(lower), zeros(slip.cols(), k), to_dyadic(cones))};
}

bool is_too_large(const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  Index order = 1 + problem.size();
  if (contact != nullptr) order += 2 * contact->rows.size();
  if (contact != nullptr) {
    const auto* factors = std::get_if<FactoredInertia>(&contact->inertia);
    order += factors != nullptr ? factors->alpha.size() : contact->ngc();
  }
  return order > kMostEntries / order;
}

}  // namespace

ExactSystem::ExactSystem(Dyadic equations, Dyadic w, Dyadic more_w)
    : potentials(equations.m.rows()),
      size(w.m.rows() + more_w.m.rows()),
      rows(potentials + size, 1 + potentials + size) {
  for (Dyadic* block : {&equations, &w, &more_w}) {
    for (Index i = 0; i < block->m.rows(); ++i) {
      const auto to = std::ssize(exponents);
      constexpr ulong kNone = std::numeric_limits<ulong>::max();
      ulong common = kNone;
      for (Index j = 0; j < rows.cols(); ++j) {
        if (!block->m.is_zero(i, j)) common = std::min(common, ulong{fmpz_val2(block->m(i, j))});
      }
      if (common == kNone) common = 0;
      for (Index j = 0; j < rows.cols(); ++j) {
        if (!block->m.is_zero(i, j)) fmpz_tdiv_q_2exp(rows(to, j), block->m(i, j), common);
      }
      exponents.push_back(block->exponent + static_cast<slong>(common));
    }
  }
}

IntegerMatrix ExactSystem::w_in_one_unit() const {
  IntegerMatrix w = part(rows, range(potentials, potentials + size), range(0, rows.cols()));
  for (Index i = 0; i < size; ++i) {
    const slong least = *std::min_element(exponents.begin() + potentials, exponents.end());
    const auto shift = static_cast<ulong>(exponents[index(row_of(i))] - least);
    for (Index j = 0; j < w.cols(); ++j) fmpz_mul_2exp(w(i, j), w(i, j), shift);
  }
  return w;
}

IntegerMatrix ExactSystem::values(const Point& point, const Deadline& deadline) const {
  const double words = static_cast<double>(1 + std::abs(fmpz_mat_max_bits(point.get())) / 64);
  deadline.require(kEntry * words * static_cast<double>(rows.rows() * rows.cols()));
  return rows * point;
}

ExactProblem::ExactProblem(const Problem& problem, const Deadline& deadline) {
  if (is_too_large(problem)) {
    refusal = "too large";
  } else if (problem.contact() == nullptr && problem.lcp().is_mixed()) {
    refusal = "only LCPs with z >= 0 alone are certified, and this one has other bounds";
  } else if (problem.contact() != nullptr) {
    set_contacts(*problem.contact(), *this, deadline);
  } else {
    const Lcp& lcp = problem.lcp();
    system = {Dyadic{IntegerMatrix(0, 1 + lcp.size()), 0}, beside(to_dyadic(lcp.q), to_dyadic(lcp.M))};
  }
}

ExactSystem edge_system(const ContactProblem& contact, const ExactProblem& problem, const Deadline& deadline) {
  const ContactLayout layout = contact_layout(contact);
  const Index count = layout.lambda_offset();
  Matrix in_columns = Matrix::Identity(count, count);
  for (Index i = 0; i < layout.nc; ++i) {
    for (Index t = layout.friction_begin[index(i)]; t < layout.friction_begin[index(i) + 1]; ++t) {
      in_columns(layout.friction_offset() + t, i) = 1;
      in_columns(layout.friction_offset() + t, layout.friction_offset() + t) = contact.mu(i);
    }
  }
  const Index k = problem.K.m.rows();
  deadline.require(kEntry * static_cast<double>(count * count * k));
  const Dyadic edges = to_dyadic(in_columns);
  return {beside(Dyadic{IntegerMatrix(k, 1), 0}, problem.K, -(problem.B * transposed(edges))),
          beside(edges * problem.q, edges * problem.R, Dyadic{IntegerMatrix(count, count), 0})};
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
  const IntegerMatrix sums = transposed(system.w_in_one_unit()) * u;
  if (sums.sign(0) >= 0) return false;
  for (Index i = 0; i < system.size; ++i) {
    if (sums.sign(system.column_of(i)) > 0) return false;
  }
  const IntegerMatrix moved =
      part(system.rows, range(0, system.potentials), range(system.column_of(0), system.rows.cols())) * u;
  return fmpz_mat_is_zero(moved.get()) != 0;
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
