#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "core/contact_problem.h"

namespace lcpbench {

/// Bounded rows by their states: at the lower bound, between the bounds, at the upper one.
///
/// With the states known, the impulses at bounds are known, rows between bounds are equations of the velocity, and what
/// is left is a problem of contacts in fewer coordinates. Rows whose impulse or velocity then has the wrong sign change
/// their states, all at once: block principal pivoting, here on the rows alone. [Kostreva 1978; Judice, Pires 1994]
/// It need not end. Small inertia only: the coordinates that rows between bounds connect become one dense block.
class RowStates {
 public:
  /// Most coordinates that rows may connect.
  static constexpr Index kMostCoordinates = 64;

  /// Whether the inertia is given whole or by blocks, no friction grows with a load, and rows connect few coordinates.
  static bool takes(const ContactProblem& problem);

  /// @param problem  taken, and must stay as it is
  void load(const ContactProblem& problem);
  /// The states to begin with. @param z  the last answer, or one of the same order; nullptr: from the velocity alone
  void guess(const Vector* z);

  /// Eliminates the rows between bounds. @returns false where these contradict one another, ask contacts for a velocity
  /// that others may not allow (jaws that close on a body), or where the inertia is singular in double
  bool reduce();
  /// The problem of contacts that is left: its contacts are those of the problem, in their order.
  const ContactProblem& contacts() const { return contacts_; }
  /// After these impulses of contacts(), by the factors of reduce().
  Vector velocity_after(const Vector& z_of_contacts) const;

  /// Takes an answer of contacts() as one of the problem. @returns whether all rows have the right signs; if not, those
  /// that have not change their states
  bool settle(const Vector& z_of_contacts, const Vector& velocity_of_contacts);
  const Vector& z() const { return z_; }
  const Vector& velocity() const { return velocity_; }
  /// Whether double shows that the answer holds: momentum is in balance, and no row misses its condition by more than
  /// rounding, so that no scale is needed. O(nnz)
  bool holds() const;

 private:
  enum class State : char { kLower, kBetween, kUpper };

  /// Coordinates that rows between bounds connect, alone: a dense block of the reduced inertia.
  struct Group {
    std::vector<Index> coordinates;
    std::vector<Index> rows;  ///< between bounds
    std::vector<Index> free, pivots;  ///< of `coordinates`; each pivot is one of `equations`
    std::vector<Index> equations;     ///< of `rows`: hard and not redundant
    Matrix T;      ///< pivots x free: velocity of the pivots = T velocity of the free + constant
    Vector constant;
    Matrix A;      ///< G and what rows that yield add to it
    Vector momentum;
    Index first = 0;  ///< of the reduced coordinates
    Eigen::LLT<Matrix> reduced;  ///< factors of Z'A Z
  };

  void load_blocks(const ContactProblem& problem);
  void group_coordinates();
  bool eliminate(Group& group);
  Jacobian reduced(const Jacobian& J, Index coordinates) const;
  bool reduce_contacts();
  bool add_offsets(const Vector& velocity);
  void find_impulses();
  double bound(Index row) const;
  bool is_wrong(Index row, State& state) const;

  const ContactProblem* problem_ = nullptr;
  std::vector<State> states_;
  Vector diagonal_;           ///< M_ii of the rows, but for rows of a singular block
  std::vector<Index> begins_;  ///< of the blocks of G
  std::vector<Index> block_of_;
  Vector momentum_;           ///< G v and the impulses at bounds
  std::vector<Group> groups_;
  std::vector<Index> group_of_, place_in_;  ///< by coordinate
  ContactProblem contacts_;
  Vector z_, velocity_, impulse_;  ///< impulse_: J f of the contacts
};

}  // namespace lcpbench
