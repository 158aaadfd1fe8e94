#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/contact_problem.h"
#include "core/quad.h"

namespace lcpbench {

/// Proves that frictionless contacts have no solution: that some u, positive for the given normals and zero for all
/// others, has X'N u = 0 and v'N u < 0, for the data as they are.
///
/// - With A = X'N of the given normals, some of A's rows and sum u = 1 are a square system. 113 bits enclose its only
///   solution. [Rump 1983]
/// - A has no full column rank, so that the other rows vanish at that solution too: but for powers of two, the minors
/// of
///   A are integers, and they are zero if they are zero modulo primes whose product exceeds the bound of Hadamard.
class FarkasSupport {
 public:
  /// Room for problems that are not larger. Allocates.
  void reserve(Index ngc, Index factors, Index contacts);

  /// Allocates nothing. False where there is no such u, and where it is not found. @pre there is room
  /// @param X of G = X diag(alpha) X' with alpha > 0, or G*, or G @param v ngc entries
  bool proves_unsolvable(const ContactProblem& contact, const Eigen::Ref<const Matrix>& X, const double* v,
                         const std::vector<Index>& normals);

 private:
  /// Matrices by rows, order_ entries from one row to the next.
  Quad& at(std::vector<Quad>& matrix, Index row, Index column) const {
    return matrix[static_cast<std::size_t>(row * order_ + column)];
  }
  Index normal(Index column) const { return (*normals_)[static_cast<std::size_t>(column)]; }
  template <class Visit>
  void for_each_term(Index row, Index column, Visit&& visit) const;
  void find_exponents();
  bool choose_rows();
  void form_system();
  bool invert_system();
  bool encloses_negative(const double* v);
  std::size_t bits_of_minors() const;
  bool lacks_rank();
  bool lacks_rank(std::uint64_t prime);

  const ContactProblem* contact_ = nullptr;
  const Eigen::Ref<const Matrix>* X_ = nullptr;
  const std::vector<Index>* normals_ = nullptr;
  Index order_ = 0;                                  // of the square system: the number of normals
  std::vector<int> row_exponent_, column_exponent_;  // powers of two that bring the terms of A to at most about one
  std::vector<Index> rows_;                          // of A in the square system
  std::vector<char> is_chosen_;                      // by row of A
  std::vector<Quad> eliminated_;                     // A, while rows are chosen
  std::vector<Quad> system_, terms_, inverse_;       // the system, the magnitudes its entries add up, its inverse
  std::vector<std::uint64_t> residues_of_X_, residues_;
};

}  // namespace lcpbench
