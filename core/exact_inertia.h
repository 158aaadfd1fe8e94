#pragma once

#include <optional>
#include <vector>

#include "core/contact_problem.h"
#include "core/exact_matrix.h"

namespace lcpbench {

/// The most coordinates of a block of G, or of a given G*, that exact arithmetic takes. The largest block takes
/// seconds, one of twelve coordinates a millisecond or two.
inline constexpr Index kMostExactCoordinates = 64;

/// G* of an inertia without any rounding: the definition that proofs of native solvers and certificates share.
///
/// The numbers of the problem are the truth. G* is the inverse of a positive definite G. Of a singular G it is the
/// pseudo-inverse, B (B'G B)^-1 B' with any basis B of the range of G; G = X diag(alpha) X' has the range of X.
/// See docs/explanation/verdicts.md, "Singular inertia".
class ExactResponse {
 public:
  /// A diagonal block of G*: numerator / denominator.
  struct Block {
    Index first = 0;  ///< of its coordinates
    Index size() const { return numerator.rows; }
    /// x := G* x, for size() entries, each rounded once.
    void multiply(Quad* x) const;
    ExactMatrix numerator{0, 0};
    Dyadic denominator{1.0};  ///< positive
    std::optional<Matrix> range;  ///< basis of the range of G, in doubles; none where G is regular or G* is given
  };

  /// nullopt where a block is not finite, has more than kMostExactCoordinates or a determinant of more than
  /// kMostExactBits, where an alpha is negative, or where a block of G is indefinite, even if only because its entries
  /// are rounded. The definiteness of a given G* is not tested.
  /// @param indefinite  receives whether the last is the reason
  static std::optional<ExactResponse> of(const Inertia& inertia, bool* indefinite = nullptr);

  const std::vector<Block>& blocks() const { return blocks_; }
  const Block& block_of(Index coordinate) const {
    return blocks_[block_of_[static_cast<std::size_t>(coordinate)]];
  }

 private:
  bool add(std::optional<Block> block);

  std::vector<Block> blocks_;
  std::vector<std::size_t> block_of_;
};

/// Numbers of the LCP of a contact problem, computed exactly and rounded once to Quad.
class ExactContacts {
 public:
  /// @param problem  must outlive this object. @pre its data are finite
  ExactContacts(const ContactProblem& problem, ExactResponse response);

  // z has an entry for each row of the LCP, all finite.

  /// w = M z + q.
  std::vector<Quad> complement(const Vector& z) const;
  /// v + G* J f, f the impulses in z.
  std::vector<Quad> velocity(const Vector& z) const;
  /// G*_ij; zero where no block has both coordinates.
  Quad inverse(Index i, Index j) const;
  /// M_ii of a normal or friction row.
  Quad diagonal(Index row) const;
  /// The verdict's measure, Errors::velocity_residual_relative, in 113 bits from complement() and diagonal().
  double velocity_residual(const Vector& z) const;

 private:
  struct Entry {
    Index row;
    Dyadic value;
  };
  using Column = std::vector<Entry>;
  struct Fraction {
    Dyadic numerator;
    Dyadic denominator{1.0};
    Fraction& operator+=(const Fraction& x);
    Quad value() const { return quotient(numerator, denominator); }
  };

  struct Direction {
    Index contact, k;
  };
  Direction direction_of(Index row) const;
  Dyadic offset(Index row) const;
  std::vector<Dyadic> respond(std::vector<Dyadic> x) const;
  std::vector<Dyadic> change(const Vector& z) const;
  Fraction project(const Column& column, const std::vector<Dyadic>& numerators) const;
  Quad scale(Index row) const;

  const ContactProblem& problem_;
  ContactLayout layout_;
  ExactResponse response_;
  std::vector<Column> columns_;
  std::vector<Dyadic> q_;
};

}  // namespace lcpbench
