#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"
#include "core/prime_field.h"
#include "core/quad.h"

namespace lcpbench {

/// Proves that contacts have no solution: that some u, positive for the given normals and zero for all others, has
/// X'N u = 0 and (N'v + b)'u < 0, for the data as they are.
///
/// - With A = X'N of the given normals, some of A's rows and sum u = 1 are a square system. Its only solution is enclosed
///   in double or, where that does not decide, in 113 bits. [Rump 1983]
/// - A has no full column rank, so that the other rows vanish at that solution too: but for powers of two, the minors of
///   A are integers, and they are zero if they are zero modulo primes whose product exceeds the bound of Hadamard.
class FarkasSupport {
 public:
  using ConstMatrixMap = Eigen::Map<const Matrix>;

  /// Room for problems that are not larger. Allocates.
  void reserve(Index ngc, Index factors, Index contacts);

  /// Allocates nothing. False where there is no such u, and where it is not found. @pre there is room
  /// @param X of G = X diag(alpha) X' with alpha > 0, or G*, or G (ngc rows). Null: I @param v ngc entries
  bool proves_unsolvable(const ContactProblem& contact, const ConstMatrixMap* X, const double* v,
                         const std::vector<Index>& normals);

  /// u (nc) := what the last proves_unsolvable() proved, rounded: small integers where there are such in the same
  /// proportion. @pre it was true
  void write_proof(Eigen::Ref<Vector> u) const;

 private:
  /// The square system in one arithmetic. Matrices by rows, order_ entries from one row to the next.
  template <class Real>
  struct System {
    std::vector<Real> A, terms_of_A;    // scaled; the magnitudes that its entries add up
    std::vector<Real> eliminated;       // A, while rows are chosen
    std::vector<Real> entries, terms;   // of the square system
    std::vector<Real> inverse;
  };
  template <class Real>
  Real& at(std::vector<Real>& matrix, Index row, Index column) const {
    return matrix[static_cast<std::size_t>(row * order_ + column)];
  }
  Index reach_size() const { return X_ != nullptr ? X_->cols() : contact_->ngc(); }
  /// Entry (i, k) of X.
  double reach(Index i, Index k) const { return X_ != nullptr ? (*X_)(i, k) : static_cast<double>(i == k); }
  Index normal(Index column) const { return (*normals_)[static_cast<std::size_t>(column)]; }
  void find_exponents();
  template <class Real>
  bool finds_negative(System<Real>& system, const double* v);
  template <class Real>
  void form(System<Real>& system) const;
  template <class Real>
  bool choose_rows(System<Real>& system);
  template <class Real>
  bool invert(System<Real>& system) const;
  template <class Real>
  bool encloses_negative(System<Real>& system, const double* v);
  std::size_t bits_of_minors() const;
  bool lacks_rank();
  bool lacks_rank(const PrimeField& field);

  const ContactProblem* contact_ = nullptr;
  const ConstMatrixMap* X_ = nullptr;  // null: I
  const std::vector<Index>* normals_ = nullptr;
  Index order_ = 0;                                  // of the square system: the number of normals
  std::vector<int> row_exponent_, column_exponent_;  // powers of two that bring the terms of A to at most about one
  std::vector<int> coordinate_exponent_;             // of the largest scaled entry of X in the coordinate's row
  std::vector<char> is_chosen_;                      // by row of A
  System<double> in_double_;
  System<Quad> in_quad_;
  std::vector<Quad> u_;  // of the last proof, scaled
  std::vector<PrimeField::Element> residues_of_X_, residues_;
};

}  // namespace lcpbench
