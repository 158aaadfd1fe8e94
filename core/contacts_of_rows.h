#pragma once

#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// A problem with bounded rows as one of contacts alone, for solvers that know no others. The solutions are the same.
///
/// A row with one bound is a contact without friction; an equality is two of them that face each other, of which at
/// most one presses where it yields. A row with two bounds is the friction of a contact that presses with half their
/// distance: the impulse that stops a coordinate of its own. Friction that grows with a load is that of the load's
/// contact. Rows of angles are scaled so that their residuals count as the verdict counts them.
class ContactsOfRows {
 public:
  /// Whether the rows have such contacts: no load has two rows of friction, or an upper bound.
  static bool can_express(const BoundedRows& rows);

  /// O(nnz) and the cubes of the orders of the blocks of G; with angles beside contacts the products of a dense M.
  /// @pre can_express(problem.rows) @param problem  finite
  explicit ContactsOfRows(const ContactProblem& problem);

  /// Its first contacts are those of the problem, its first ngc coordinates, too.
  const ContactProblem& contacts() const { return contacts_; }

  /// The z of the problem, impulses of rows within their bounds. @param x  of contacts()
  Vector restore(const Vector& x) const;
  /// The x of contacts() whose impulses are these; lambdas of rows are zero.
  Vector start(const Vector& z) const;
  /// The proof for the problem. @param u  for contacts(), one entry for each
  Vector proof(const Vector& u) const;
  /// Whether contacts() may have allowed this answer a larger error than the verdict does: bounds that are not alike act
  /// by an impulse before the contacts, which adds to their scale; a row at a bound that is large beside all velocities
  /// was scaled down; units of angles are rounded. O(nnz(R)) @param z  restore(x) @param velocity  after the impact
  bool is_in_doubt(const ContactProblem& problem, const Vector& x, const Vector& z, const Vector& velocity) const;

 private:
  struct Row {
    enum class Kind { kEquality, kLimit, kBox, kFrictionOf } kind;
    Index contact;         ///< the first of contacts() that stands for it
    double unit;           ///< f = unit f' + middle
    double diagonal, weight;  ///< M_ii, and what its residual counts relative to the scale
    double middle = 0;        ///< of the bounds; of a limit its bound
    bool is_large = false;    ///< its bounds are scaled down
  };
  class RowSizes;

  bool enlarges_scale(const RowSizes& sizes) const;

  double impulse(const Row& row, const Vector& x) const;

  std::vector<Row> rows_;
  LcpBounds bounds_;
  ContactLayout from_, to_;
  ContactProblem contacts_;
  bool enlarges_scale_ = false;
};

}  // namespace lcpbench
