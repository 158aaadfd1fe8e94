#pragma once

#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// Contacts and bounded rows, and all generalized coordinates that their impulses may move; indices of the whole
/// problem, ascending.
struct Island {
  std::vector<Index> contacts;
  std::vector<Index> coordinates;
  std::vector<Index> rows;  ///< bounded rows
};

/// The parts of a problem that nothing couples, in the order of their first contacts, then of their first rows.
///
/// Two coordinates belong together when a column of G (or of the given G*, or of the factors) has nonzero entries for
/// both, or when the normal and the friction directions of one contact, taken together, have, or a bounded row, taken
/// together with the row that bounds its friction. Only entries that are exactly zero count as zero, so that solving the
/// islands one by one solves the whole problem. A contact without any nonzero entry is an island of its own if it yields
/// along its normal, else in no island, whatever its offset; and alike a row.
std::vector<Island> find_islands(const ContactProblem& problem);

/// The same islands as numbers. The memory only grows, so that find() allocates nothing for sizes that it has met.
struct IslandNumbers {
  std::vector<Index> of_contact;     ///< nc entries; -1 for contacts without any nonzero entry that do not yield
  std::vector<Index> of_row;         ///< alike of each bounded row
  std::vector<Index> of_coordinate;  ///< ngc entries; -1 where no impulse moves the coordinate
  Index count = 0;

  void reserve(Index ngc, Index nc);
  /// O(entries of the data), of sparse matrices the stored ones, and less where neighbouring coordinates were found
  /// together before: of most sparse columns it then reads few. Rows of sparse columns ascend, as Eigen keeps them.
  void find(const ContactProblem& problem);
  /// What find() would find in a problem that is known to be one island. O(ngc + nc)
  void take_as_one(const ContactProblem& problem);
  /// What find() found, as find_islands() returns it, into memory that is used again.
  void list(std::vector<Island>& islands) const;

 private:
  std::vector<Index> parent_;   // per coordinate
  std::vector<Index> run_end_;  // per coordinate i: coordinates i to run_end_[i] - 1 are in one island
  std::vector<Index> number_;   // per representative
};

/// True when the inertia alone shows in O(ngc) that one island has all coordinates, or that there are none. A contact
/// that moves nothing may be an island of its own beside it, if it yields.
bool couples_all(const Inertia& inertia);

/// The island of each row of LCP(q, M), numbered from 0 in the order of their first rows.
struct RowIslands {
  std::vector<Index> of_row;  ///< n entries
  Index count = 0;            ///< number of islands; 0 for n = 0
};

/// The islands of find_islands(), per row: a contact's normal row, its friction rows and its cone row are in its
/// island. Unlike there, every contact and every bounded row without a nonzero entry is an island of its own.
/// O(n + entries of the data), of sparse matrices the stored ones.
RowIslands row_islands(const ContactProblem& problem);

/// The connected blocks of M: rows i and j belong together when M_ij or M_ji is not zero. O(n^2); O(n) where
/// the first column or row of M has no zero.
RowIslands row_islands(const Matrix& M);

/// The same into memory of the caller's, which suffices for every later problem of that order. @param queue scratch
void find_row_islands(const Matrix& M, RowIslands& rows, std::vector<Index>& queue);

}  // namespace lcpbench
