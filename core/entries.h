#pragma once

#include <variant>

#include "core/contact_problem.h"

namespace lcpbench {

/// Calls visit(row, entry) for each nonzero entry of a column, in the order of the rows.
template <class Visit>
void for_each_entry(const Matrix& matrix, Index column, Visit&& visit) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    if (matrix(row, column) != 0) visit(row, matrix(row, column));
  }
}

template <class Visit>
void for_each_entry(const SparseMatrix& matrix, Index column, Visit&& visit) {
  for (SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry) {
    if (entry.value() != 0) visit(entry.row(), entry.value());
  }
}

template <class Visit>
void for_each_entry(const Jacobian& J, Index column, Visit&& visit) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return for_each_entry(*dense, column, visit);
  for_each_entry(std::get<SparseMatrix>(J), column, visit);
}

}  // namespace lcpbench
