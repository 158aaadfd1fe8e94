#pragma once

// Shared by DART's boxed solvers.

#include <string>
#include <vector>

#include <dart/constraint/BoxedLcpSolver.hpp>

#include "core/contact_problem.h"
#include "core/solver.h"

namespace lcpbench {

/// Contacts in the boxed form of DART: A x = b + w with bounds on x, where a friction row's bounds are proportional to
/// the unknown of its normal row.
///
/// A pyramid of 4 edges is exactly the square |a| <= mu f_N / 2, |c| <= mu f_N / 2 on the rows t1 + t2 and t1 - t2,
/// and one of 2 edges is |a| <= mu f_N on the row t1. A pyramid of more edges is no box.
class BoxedContacts {
 public:
  /// @returns why the form does not hold the problem, or "".
  std::string load(const ContactProblem& contact);

  /// Where x of the next solve starts: at the impulses of z, or at zero.
  void start_at(const Vector* z);

  /// Writes z: opposite directions carry the two signs of a friction impulse, lambda is the largest
  /// slip along a direction. @returns what the library returned.
  bool solve(dart::constraint::BoxedLcpSolver& solver, bool early_termination, Vector& z);

  bool frictional() const { return layout_.cones > 0; }

 private:
  void split_friction(Vector& z) const;

  Lcp lcp_;
  ContactLayout layout_;
  SparseMatrix rows_;  ///< n x m: what each of the m boxed unknowns adds to z, opposite directions merged
  Matrix padded_;      ///< A, in DART's stride
  Vector b_;
  Vector lower_;
  Vector upper_;
  std::vector<int> normal_row_;  ///< m: of a friction row, else -1
  // What the library works in, and destroys.
  Matrix destroyed_A_;
  Vector destroyed_b_;
  Vector destroyed_lower_;
  Vector destroyed_upper_;
  std::vector<int> destroyed_normal_row_;
  Vector x_;
};

/// One of DART's boxed solvers.
class BoxedSolver : public Solver {
 protected:
  /// Sets claim, z and detail. @pre there are contacts
  virtual void solve(BoxedContacts& contacts, Answer& answer) = 0;

  void on_load(const Problem& problem) final { refusal_ = contacts_.load(*problem.contact()); }
  void on_solve(const SolveRequest&, Answer& answer) final;

 private:
  std::string refusal_;
  BoxedContacts contacts_;
};

}  // namespace lcpbench
