#pragma once

#include "core/contact_problem.h"
#include "native/contacts/growing_vector.h"

namespace lcpbench {

/// diag(blocks) by columns.
void copy_dense(const BlockInertia& inertia, Index dimension, GrowingVector& to);

/// The entries of J by columns: its own where it is dense, else those of the copy that is made.
const double* dense_data(const Jacobian& J, GrowingVector& copy);

}  // namespace lcpbench
