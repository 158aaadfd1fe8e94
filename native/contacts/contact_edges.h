#pragma once

#include <variant>

#include "core/contact_problem.h"

namespace lcpbench {

/// Calls visit(row, entry) for the nonzero entries of a column of a contact Jacobian.
template <class Visit>
void for_each_entry(const Jacobian& J, Index column, Visit&& visit) {
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    for (Index i = 0; i < dense->rows(); ++i) {
      if ((*dense)(i, column) != 0) visit(i, (*dense)(i, column));
    }
    return;
  }
  for (SparseMatrix::InnerIterator it(std::get<SparseMatrix>(J), column); it; ++it) {
    if (it.value() != 0) visit(it.row(), it.value());
  }
}

}  // namespace lcpbench
