#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {

/// Contacts in the order of a sweep. All numbers that the update of one contact reads stand next to each other, and its
/// impulses change together: one pass over its columns gives the velocities of the contact, a second one changes the
/// velocities of what it touches.
///
/// Between separate bodies, G = L L' by blocks, the columns are L^-1 J and the velocity is L'u, so that one array
/// serves both passes. Any other inertia stores the columns of J and those of G* J.
class ContactBlocks {
 public:
  /// @param state loaded with the same problem
  void load(const Inertia& inertia, const ContactImpulses& state);

  /// Takes the impulses, the velocity and the offsets of the state. Allocates nothing.
  void take(const ContactImpulses& state);
  /// Writes the impulses to the state. Its velocity stays.
  void write(ContactImpulses& state) const;

  /// One update of every contact, from the first to the last or from the last to the first.
  ///
  /// The normal impulse becomes max(0, f - relaxation w / M_ii). Then the friction impulses take a gradient step of
  /// length relaxation / (the largest eigenvalue of their own block of M) and are projected onto sum |g| <= mu f.
  /// @returns the largest step before relaxation, in the units of w; of normals |min(w, M_ii f)|. Infinity where it is
  ///     not a number
  double sweep(double relaxation, bool backwards);

  Vector impulses;  ///< per row: of each contact the normal one, then one for each of its first directions
  Vector velocity;  ///< L'u, or u
  Vector
      curvature;  ///< per row: M_ii of normals, of friction rows the largest eigenvalue of their block; 0: no impulse

 private:
  struct Run {
    Index first;
    Index size;
  };
  struct Contact {
    Index first_row;    // of its impulses
    Index rows;         // 1, or 1 + directions where friction can act
    std::size_t run;    // first of its runs
    std::size_t runs;   // number of them
    std::size_t value;  // first of its values: run by run, row by row
    Index column;       // first of its friction in ContactImpulses
    double mu;
    Index run_size;     // of all its runs; 0 where they differ
  };

  bool factor(const Inertia& inertia);
  void find_runs(const ContactImpulses& state, const SignedFriction* friction, Contact& block);
  void add_values(const ContactImpulses& state, const SignedFriction* friction, Contact& block);
  void whiten(const Run& run, double* part) const;
  void find_curvature(const ContactImpulses& state, Contact& block);
  double product(const Contact& block, Index i, Index j) const;
  template <int kRows, int kSize>
  double update(const Contact& block, double relaxation);

  std::vector<Contact> contacts_;
  Vector offset_;  // per contact; empty: zero
  std::vector<Run> runs_;
  std::vector<double> values_;
  std::vector<double> responses_;  // G* J; empty where values_ serves both
  Vector coupling_;                // per friction row: its entry of M with the normal row
  Vector velocities_, steps_;      // scratch of one contact
  std::vector<Matrix> roots_;      // L of each block of the inertia; none where responses_ are stored
  std::vector<Index> root_of_;     // per coordinate: its block
};

/// Euclidean projection of y onto {sum |y_i| <= radius}, radius >= 0: shrinks all |y_i| by one threshold, found by
/// dropping entries that it brings to zero. O(size^2), of which O(size) is usual. [Michelot 1986; Duchi et al. 2008]
void project_on_cross_polytope(double* y, Index size, double radius);

}  // namespace lcpbench
