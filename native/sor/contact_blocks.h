#pragma once

#include <cstddef>
#include <span>
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
  /// Makes the impulses admissible: normal ones >= 0, and friction in the pyramid. The velocity stays.
  void project();
  /// Writes the impulses to the state. Its velocity stays.
  void write(ContactImpulses& state) const;

  /// What a sweep changed.
  struct Step {
    double off = 0;   ///< the largest step before relaxation, in the units of w; of normals |min(w, M_ii f)|. Infinity
                      ///< where it is not a number
    double size = 0;  ///< sum of the squares of all steps, each weighted by its curvature
  };

  /// One update of every contact, from the first to the last. @pre relaxation > 0
  ///
  /// The normal impulse becomes max(0, f - relaxation w / M_ii). Then the friction impulses take a gradient step of
  /// length relaxation / (the largest eigenvalue of their own block of M) and are projected onto sum |g| <= mu f.
  Step sweep(double relaxation);
  /// The same, of these contacts in this order.
  Step sweep(std::span<const Index> contacts, double relaxation);

  Index contacts() const { return static_cast<Index>(contacts_.size()); }
  Index first_row(Index contact) const { return of(contact).first_row; }
  Index rows(Index contact) const { return of(contact).rows; }

  /// Whether the velocity consists of separate bodies. Only then these may be called:
  bool has_bodies() const { return !bodies_.empty(); }
  std::size_t bodies() const { return bodies_.size(); }
  Index first_coordinate(std::size_t body) const { return bodies_[body].first; }
  Index coordinates(std::size_t body) const { return bodies_[body].size; }
  /// visit(body) for each body that the contact touches.
  template <class Visit>
  void for_each_body(Index contact, Visit&& visit) const {
    const Contact& block = of(contact);
    for (const Run& run : runs_of(block)) {
      std::size_t last = bodies_.size();
      for (Index i = run.first; i < run.first + run.size; ++i) {
        const std::size_t body = body_of_[static_cast<std::size_t>(i)];
        if (body != last) visit(body);
        last = body;
      }
    }
  }

  /// Of soft friction: what the tangents of a contact see beside the velocity.
  struct Softness {
    double normal = 0, tangential = 0;  ///< r_n, r_t
    Eigen::Vector2d offset{0, 0};       ///< in the units of the island
  };
  bool is_soft() const { return !soft_.empty(); }
  /// @pre is_soft()
  const Softness& softness(Index contact) const { return soft_[static_cast<std::size_t>(contact)]; }

  double mu(Index contact) const { return of(contact).mu; }
  double offset(Index contact) const { return offset_.size() > 0 ? offset_(contact) : 0.0; }
  bool has_offset() const { return offset_.size() > 0; }
  /// The least curvature by which the contact's row is divided in an update; 0: no impulse.
  double curvature(Index contact, Index row) const { return row == 0 ? of(contact).normal : of(contact).friction; }
  /// Of a sweep over all contacts, see BudgetedSolver::work().
  double work() const { return work_; }
  /// Numbers that a sweep reads for all columns.
  std::size_t entries() const { return values_.size(); }
  /// visit(row, coordinate, entry) for the columns of the contact.
  template <class Visit>
  void for_each_entry(Index contact, Visit&& visit) const {
    const Contact& block = of(contact);
    const double* entry = values_.data() + block.value;
    for (const Run& run : runs_of(block)) {
      for (Index row = 0; row < block.rows; ++row) {
        for (Index i = 0; i < run.size; ++i, ++entry) visit(row, run.first + i, *entry);
      }
    }
  }
  /// Adds these steps, one for each row, to the contact's impulses, and to the velocity what they change.
  void add(Index contact, const double* steps);

  Vector impulses;  ///< per row: of each contact the normal one, then one for each of its first directions
  Vector velocity;  ///< L'u, or u
  Vector errors;    ///< per contact: Step::off of its own in the last sweep that it was in, but NaN stays

 private:
  struct Body {
    Index first;  // of its coordinates
    Index size;
    std::size_t root;  // first of its values in roots_
  };
  struct Run {
    Index first;
    Index size;
  };
  struct Contact {
    Index first_row;    // of its impulses
    std::size_t run;    // first of its runs
    std::size_t value;  // first of its values: run by run, row by row
    double mu;
    double normal;    // M_ii; 0: no impulse
    double friction;  // the largest eigenvalue of its friction rows' block of M; 0: no impulse
    double normal_inverse, friction_inverse;
    int rows;      // 1, or 1 + directions where friction can act
    int runs;      // number of them
    int run_size;  // of all its runs; 0 where they differ
  };

  bool factor(const Inertia& inertia);
  void load_softness(const ContactImpulses& state, Index rows);
  void find_runs(const ContactImpulses& state, Index contact, Contact& block);
  template <class Finish>
  void add_values(const PackedColumns& columns, Index contact, const Contact& block, std::vector<double>& to,
                  const Finish& finish) const;
  void add_responses(const ContactImpulses& state, const BlockInverse& inverse, Index contact, const Contact& block);
  void find_curvature(const ContactImpulses& state, Index contact, Contact& block);
  double product(const Contact& block, Index i, Index j) const;
  std::span<const Run> runs_of(const Contact& block) const {
    return {runs_.data() + block.run, static_cast<std::size_t>(block.runs)};
  }
  /// Column of the contact's row in ContactImpulses.
  Index column_of(Index contact, Index row) const {
    return row == 0 ? contact : column_[static_cast<std::size_t>(contact)] + row - 1;
  }
  const Contact& of(Index contact) const { return contacts_[static_cast<std::size_t>(contact)]; }
  static Step checked(const Step& sum);
  template <bool kSoft>
  void update(Index contact, double relaxation, Step& sum);
  template <bool kSoft, int kRows, int kSize>
  void update(const Contact& block, Index contact, double relaxation, Step& sum);
  template <int kRows, int kSize>
  void find_velocities(const Contact& block, double* w) const;
  void add_softness(const Contact& block, Index contact, double* w) const;
  template <int kRows, int kSize>
  void add_steps(const Contact& block, const double* step);

  std::vector<Contact> contacts_;
  std::vector<Index> column_;  // per contact: first of its friction in ContactImpulses
  Vector offset_;              // per contact; empty: zero
  std::vector<Softness> soft_;  // per contact; empty where all are hard
  Eigen::Matrix2Xd tangents_;   // per row: its direction by the contact's tangents
  std::vector<Run> runs_;
  std::vector<double> values_;
  std::vector<double> responses_;     // G* J; empty where values_ serves both
  Vector coupling_;                   // per friction row: its entry of M with the normal row
  Vector velocities_, steps_;         // scratch of one contact
  std::vector<Body> bodies_;          // none where responses_ are stored
  std::vector<double> roots_;         // L of each block of the inertia, by columns
  std::vector<std::size_t> body_of_;  // per coordinate
  double work_ = 0;
};

/// Euclidean projection of y onto {sum |y_i| <= radius}, radius >= 0: shrinks all |y_i| by one threshold, found by
/// dropping entries that it brings to zero. O(size^2), of which O(size) is usual. [Michelot 1986; Duchi et al. 2008]
void project_on_cross_polytope(double* y, Index size, double radius);

}  // namespace lcpbench
