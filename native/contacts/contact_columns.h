#pragma once

#include "core/contact_problem.h"
#include "native/contacts/block_inverse.h"
#include "native/contacts/packed_columns.h"

namespace lcpbench {

/// What methods that go through the rows of M one by one need of a contact problem: M is never formed.
struct ContactColumns {
  PackedColumns J;         ///< the columns of [N D], ngc rows
  PackedColumns response;  ///< the columns of G* [N D], ngc rows; may be left out
  /// J_i'G*J_i; 0 where it is not above an estimate of its own rounding: the impulse moves nothing.
  Vector diagonal;

  /// Numbers stored, the zeros within a block that a column touches among them.
  std::size_t nonzeros() const { return J.nonzeros() + response.nonzeros(); }
};

enum class Opposites { kStored, kEmpty };

/// A column takes the time of the squared orders of the blocks of G* that it touches, and memory for the orders
/// themselves. Inertia that is not given in blocks is one block of order ngc.
/// @param inverse of the problem's inertia
/// @param opposites kStored: all columns of D, whose number need not follow from `edges`; kEmpty: the second half of
///     each contact's friction columns, the negatives of the first half, have no entries and a diagonal of 0
/// @param with_response false: `columns.response` gets no columns
/// @param columns is overwritten, and its memory used again
void find_contact_columns(const ContactProblem& problem, const BlockInverse& inverse, Opposites opposites,
                          bool with_response, ContactColumns& columns);
/// The same with all columns of D and the response.
ContactColumns contact_columns(const ContactProblem& problem);

}  // namespace lcpbench
