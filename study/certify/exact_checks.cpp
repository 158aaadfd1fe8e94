#include "study/certify/exact_checks.h"

#include <algorithm>

namespace lcpbench::exact {
namespace {

bool nonnegative(const IntegerVector& x) {
  return std::all_of(x.begin(), x.end(), [](const Integer& value) { return value.sign() >= 0; });
}

// sum += column j of A times x
void add_column_product(const IntegerMatrix& A, Index j, const IntegerVector& x, Integer& sum) {
  for (Index i = 0; i < A.rows(); ++i) fmpz_addmul(sum.get(), A(i, j), x[index(i)].get());
}

// A x - B y is zero.
bool equal_products(const IntegerMatrix& A, const IntegerVector& x, const IntegerMatrix& B, const IntegerVector& y,
                    const Deadline& deadline) {
  for (Index i = 0; i < A.rows(); ++i) {
    deadline.check();
    Integer difference;
    for (Index j = 0; j < A.cols(); ++j) {
      fmpz_addmul(difference.get(), A(i, j), x[index(j)].get());
    }
    for (Index j = 0; j < B.cols(); ++j) {
      const Integer& y_j = y[index(j)];
      if (y_j.sign() != 0) fmpz_submul(difference.get(), B(i, j), y_j.get());
    }
    if (difference.sign() != 0) return false;
  }
  return true;
}

// q_i denominator + R_i'p
Integer velocity_row(const ExactSystem& system, const ExactPoint& point, Index i) {
  Integer w;
  fmpz_mul(w.get(), system.q[index(i)].get(), point.denominator.get());
  add_column_product(system.R, i, point.p, w);
  return w;
}

Integer dot(const IntegerVector& a, const IntegerVector& b) {
  Integer sum;
  for (std::size_t i = 0; i < a.size(); ++i) fmpz_addmul(sum.get(), a[i].get(), b[i].get());
  return sum;
}

// S'y <= 0
bool no_column_rises(const ExactSystem& system, const IntegerVector& y, const Deadline& deadline) {
  IntegerVector columns(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    deadline.check();
    if (y[i].sign() == 0) continue;
    for (const Term& term : system.S[i]) {
      fmpz_addmul(columns[index(term.column)].get(), term.value.get(), y[i].get());
    }
  }
  return std::all_of(columns.begin(), columns.end(), [](const Integer& value) { return value.sign() <= 0; });
}

}  // namespace

Integer complement(const ExactSystem& system, const ExactPoint& point, Index i) {
  Integer w = velocity_row(system, point, i);
  for (const Term& term : system.S[index(i)]) {
    fmpz_addmul(w.get(), term.value.get(), point.z[index(term.column)].get());
  }
  return w;
}

bool is_solution(const ExactSystem& system, const ExactPoint& point, const Deadline& deadline) {
  if (point.denominator.sign() <= 0 || !nonnegative(point.z)) return false;
  if (!equal_products(system.K, point.p, system.L, point.z, deadline)) return false;
  for (Index i = 0; i < system.size(); ++i) {
    deadline.check();
    const int sign = complement(system, point, i).sign();
    if (sign < 0 || (sign > 0 && point.z[index(i)].sign() > 0)) return false;
  }
  return true;
}

bool is_contradiction(const ExactSystem& system, const IntegerVector& u, const Deadline& deadline) {
  return nonnegative(u) && equal_products(IntegerMatrix(system.potentials(), 0), {}, system.L, u, deadline) &&
         dot(system.q, u).sign() < 0 && no_column_rises(system, u, deadline);
}

bool is_solvability_proof(const ExactSystem& contact, const ContactProblem& problem, const ExactPoint& point,
                          const Deadline& deadline) {
  if (point.denominator.sign() <= 0 || !(problem.mu.array() >= 0).all()) return false;
  const ContactLayout layout = contact_layout(problem);
  const Dyadic mu = to_dyadic(problem.mu);
  for (Index i = 0; i < layout.nc; ++i) {
    if (problem.normal_compliance(i) > 0) continue;  // it has no impulse where nothing yields
    const Integer normal = velocity_row(contact, point, i);
    if (normal.sign() < 0) return false;
    // Impulses that move nothing and do not yield cancel in pairs; those of more edges need not.
    if (problem.tangential_compliance(i) > 0 && problem.edges[index(i)] <= 4) continue;
    for (Index t = layout.friction_begin[index(i)]; t < layout.friction_begin[index(i) + 1]; ++t) {
      deadline.check();
      // normal + mu 2^exponent slip >= 0
      Integer left = normal;
      Integer right = velocity_row(contact, point, layout.friction_offset() + t);
      fmpz_mul(right.get(), right.get(), mu.m(i, 0));
      Integer& scaled = mu.exponent < 0 ? left : right;
      fmpz_mul_2exp(scaled.get(), scaled.get(), static_cast<ulong>(mu.exponent < 0 ? -mu.exponent : mu.exponent));
      fmpz_add(left.get(), left.get(), right.get());
      if (left.sign() < 0) return false;
    }
  }
  return true;
}

bool same_potential(const ExactPoint& a, const ExactPoint& b) {
  Integer left;
  Integer right;
  for (std::size_t i = 0; i < a.p.size(); ++i) {
    fmpz_mul(left.get(), a.p[i].get(), b.denominator.get());
    fmpz_mul(right.get(), b.p[i].get(), a.denominator.get());
    if (!fmpz_equal(left.get(), right.get())) return false;
  }
  return true;
}

}  // namespace lcpbench::exact
