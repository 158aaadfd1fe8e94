#pragma once

#include "core/contact_problem.h"
#include "native/contacts/block_inverse.h"
#include "native/contacts/packed_columns.h"

namespace lcpbench {

/// What methods that go through the rows of M one by one need of a contact problem: M is never formed.
struct ContactColumns {
  PackedColumns J;         ///< the columns of [N D], ngc rows
  PackedColumns response;  ///< the columns of G* [N D], ngc rows; may be left out
  /// J_i'G*J_i; exactly 0 where the impulse moves nothing to within the rounding of this product.
  Vector diagonal;

  std::size_t nonzeros() const { return J.nonzeros() + response.nonzeros(); }
};

enum class Opposites { kStored, kEmpty };

/// For block inertia a column costs the blocks that it touches, else O(ngc^2). Memory alike.
/// @param opposites kStored: all columns of D, which need not be those of `edges`; kEmpty: the second half of each
///     contact's friction columns, the negatives of the first, have no entries
/// @param inverse of the problem's inertia
/// @param with_response false: it gets no columns
/// @param columns its memory is used again
void find_contact_columns(const ContactProblem& problem, const BlockInverse& inverse, Opposites opposites,
                          bool with_response, ContactColumns& columns);
/// The same with all columns of D and the response.
ContactColumns contact_columns(const ContactProblem& problem);

}  // namespace lcpbench
