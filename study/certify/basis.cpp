#include "study/certify/basis.h"

#include "core/selection.h"
#include "study/certify/exact_checks.h"

namespace lcpbench::exact {

Equations basis_equations(const ExactSystem& system, const std::vector<Index>& basis, const std::vector<Index>& rows) {
  const Index k = system.potentials();
  std::vector<Index> position(index(system.size()), -1);
  for (std::size_t j = 0; j < basis.size(); ++j) position[index(basis[j])] = static_cast<Index>(j);

  Equations e{IntegerMatrix(k + static_cast<Index>(rows.size()), k + static_cast<Index>(basis.size())),
              IntegerMatrix(k + static_cast<Index>(rows.size()), 1)};
  for (Index i = 0; i < k; ++i) {
    for (Index j = 0; j < k; ++j) fmpz_set(e.A(i, j), system.K(i, j));
    for (std::size_t j = 0; j < basis.size(); ++j) fmpz_neg(e.A(i, k + static_cast<Index>(j)), system.L(i, basis[j]));
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Index row = k + static_cast<Index>(r);
    for (Index j = 0; j < k; ++j) fmpz_set(e.A(row, j), system.R(j, rows[r]));
    for (const Term& term : system.S[index(rows[r])]) {
      const Index column = position[index(term.column)];
      if (column >= 0) fmpz_set(e.A(row, k + column), term.value.get());
    }
    fmpz_neg(e.b(row, 0), system.q[index(rows[r])].get());
  }
  return e;
}

/// The point of the unknowns `columns` in x = [p; z of `basis`] that solve the square equations e; the others are zero.
std::optional<ExactPoint> point_of(const ExactSystem& system, const std::vector<Index>& basis, const Equations& e,
                                   const std::vector<Index>& columns, const Deadline& deadline) {
  IntegerMatrix x;
  ExactPoint point;
  if (!Lifting(e.A, deadline).solve(e.b, x, point.denominator)) return std::nullopt;
  const Index k = system.potentials();
  point.p.resize(index(k));
  point.z.resize(index(system.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const Index column = columns[j];
    Integer& target = column < k ? point.p[index(column)] : point.z[index(basis[index(column - k)])];
    fmpz_swap(target.get(), x(static_cast<Index>(j), 0));
  }
  return point;
}

std::optional<ExactPoint> basis_point(const ExactSystem& system, const std::vector<Index>& basis,
                                      const Deadline& deadline) {
  const Equations e = basis_equations(system, basis, basis);
  return point_of(system, basis, e, all_indices(e.A.cols()), deadline);
}

std::optional<ExactPoint> purified_point(const ExactSystem& system, const std::vector<Index>& basis,
                                         const std::vector<Index>& tight, const Deadline& deadline) {
  std::vector<Index> rows = basis;
  rows.insert(rows.end(), tight.begin(), tight.end());
  const Equations e = basis_equations(system, basis, rows);
  const Minor minor = independent_minor(e.A, deadline);
  return point_of(system, basis, part(e, minor), minor.columns, deadline);
}

std::vector<Index> exchanged_basis(const ExactSystem& system, const ExactPoint& point, const Deadline& deadline) {
  std::vector<Index> basis;
  for (Index i = 0; i < system.size(); ++i) {
    deadline.check();
    const int sign = point.z[index(i)].sign();
    if (sign > 0 || (sign == 0 && complement(system, point, i).sign() < 0)) basis.push_back(i);
  }
  return basis;
}

std::optional<IntegerVector> annihilator(const ExactSystem& system, const std::vector<Index>& support,
                                         const Deadline& deadline) {
  const Index k = system.potentials();
  Equations e{IntegerMatrix(k + 1, static_cast<Index>(support.size())), IntegerMatrix(k + 1, 1)};
  for (std::size_t j = 0; j < support.size(); ++j) {
    fmpz_set(e.A(0, static_cast<Index>(j)), system.q[index(support[j])].get());
    for (Index i = 0; i < k; ++i) fmpz_set(e.A(1 + i, static_cast<Index>(j)), system.L(i, support[j]));
  }
  fmpz_set_si(e.b(0, 0), -1);
  const std::optional<IntegerVector> x = solve_independent_part(e, deadline);
  if (!x) return std::nullopt;
  IntegerVector u(index(system.size()));
  for (std::size_t j = 0; j < support.size(); ++j) u[index(support[j])] = (*x)[j];
  return u;
}

}  // namespace lcpbench::exact
