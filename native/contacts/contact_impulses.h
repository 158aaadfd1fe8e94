#pragma once

#include <limits>
#include <vector>

#include "core/problem.h"
#include "native/contacts/contact_columns.h"
#include "native/contacts/island_units.h"

namespace lcpbench {

/// A contact's friction as signed impulses: g_t along each of its first directions, f_D = (max(g, 0), max(-g, 0)).
struct SignedFriction {
  Index contact = 0;
  Index first_column = 0;  ///< in [N D]; the opposite of column t is t + directions
  Index directions = 0;
  Index lambda = 0;  ///< index in z
};

/// What methods that change one impulse after the other keep of a problem: its columns, the impulses, the velocity that
/// they give, and how far they are from a solution. M is not formed for contact problems. Of a bare LCP every row is a
/// frictionless contact, u is w, J = I and G*J = M.
///
/// Velocities and impulses are kept in the units of their islands, so that residual() relative to `scale` is that of
/// each island relative to its own scale.
struct ContactImpulses {
  /// Everything that follows from the problem; sizes the rest. Memory: the columns, which for block inertia is what the
  /// contacts touch.
  void load(const Problem& problem);

  /// Another velocity before the impact (ngc; q of a bare LCP), the same columns.
  void set_velocity(const Vector& v);

  /// u = u0 + G* (the impulses).
  void recompute_velocity();

  /// Whether G* is held by blocks, as add_response() asks.
  bool has_inverse() const { return momentum_.size() > 0; }
  /// velocity += G* times an impulse of ngc entries. @pre has_inverse()
  void add_response(const Vector& momentum, Vector& velocity) const { inverse_.add_product(momentum, velocity); }

  /// The velocity residual of the evaluation [m/s], in double: max |min(M_ii z_i, w_i)|, of cone rows
  /// |min(lambda_i, M_nn w_i)|, at lambda = slip_bound. Infinity where it is not a number. @pre u is recomputed.
  double residual() const;

  /// Sets to zero the impulses that residual() takes for zero, M_ii z_i < w_i, and recomputes u. Methods that end
  /// inside have no zeros of their own.
  void drop_what_counts_as_zero();

  /// w of a contact's normal row at u: its velocity, its offset and what it yields; w of a row of a bare LCP.
  double normal_velocity(Index contact) const {
    const double velocity = with_offset(contact, columns.J.dot(contact, u));
    return compliance.size() > 0 ? velocity + compliance(contact) * impulse(contact) : velocity;
  }

  /// Of recompute_velocity() and residual() together, see BudgetedSolver::work(); and of AnswerTest::settle() in
  /// double, to no more than a factor of two. Fitted to times of 14 to 20,842 contacts.
  double work_of_residual() const { return 14 * static_cast<double>(columns.nonzeros()); }
  double work_of_test() const { return 45 * static_cast<double>(columns.nonzeros()); }

  /// Velocities of a contact's tangents beside those of the coordinates: offsets, and what it yields.
  using Tangential = Eigen::Vector2d;
  Tangential tangential_offset(const SignedFriction& friction) const;
  /// w of a friction row at u, without lambda. @param beside  tangential_offset() of its contact
  double slip(Index column, const Tangential& beside) const {
    const double velocity = columns.J.dot(column, u);
    return tangents.cols() > 0 ? velocity + tangents.col(column).dot(beside) : velocity;
  }
  /// Largest |slip|: what lambda has to bound.
  double slip_bound(const SignedFriction& friction) const;

  /// The impulses of z (lcp_size entries, in the units of the problem), and the velocity that they give.
  void set_impulses(const Vector& z);
  /// Impulses in the units of the problem become those kept here.
  void scale_impulses();
  /// z of lcp_size entries, in the units of the problem. @pre u is recomputed.
  void write_answer(Vector& z) const;

  ContactColumns columns;  ///< without the response where G is given by blocks: their inverses give the velocity
  Vector mu;               ///< nc
  std::vector<SignedFriction> frictions;
  std::vector<Index> friction_of;  ///< nc: index in frictions, -1 without
  Index contacts = 0;              ///< nc; n of a bare LCP
  Vector u0;                       ///< velocity before the impact; q of a bare LCP
  Vector offset;                   ///< nc, in the units of the islands; empty: zero
  Vector compliance;               ///< r_n; empty: zero
  Vector compliance_t;             ///< r_t; empty: zero
  Vector offset_t;                 ///< 2 nc, in the units of the islands; empty: zero
  Eigen::Matrix2Xd tangents;       ///< columns of [N D] by the two tangents of their contact, 0 of normals and of
                                   ///< opposite directions; empty where no friction is soft
  double scale = 0;                ///< see ContactScale; 0 where no contact approaches: no impulses solve it. Of a
                                   ///< bare LCP max|q|. Infinite where some q is not finite
  double speed = 0;                ///< the largest approach or slip [m/s], the size of what impulses have to change
  IslandUnits units;

  Vector u;        ///< velocity; w of a bare LCP
  Vector impulse;  ///< per column of [N D]: f_N, then g at the first directions of each contact (the rest is not used)

 private:
  Vector b_, given_offset_t_;  // as given
  BlockInverse inverse_;     // where columns have no response
  Vector momentum_;          // scratch: the impulses on the coordinates; empty where columns have a response
  bool is_bare_ = false;
  std::vector<Index> idle_;  // contacts that nothing moves: their w is b, and no scale of the others

  /// Calls visit(column of [N D], its contact) for every entry of `impulse` that is used.
  template <class Visit>
  void for_each_impulse(Visit&& visit) const {
    for (Index i = 0; i < contacts; ++i) visit(i, i);
    for (const SignedFriction& friction : frictions) {
      for (Index t = 0; t < friction.directions; ++t) visit(friction.first_column + t, friction.contact);
    }
  }
  void load_lcp(const Lcp& lcp);
  void load_contacts(const ContactProblem& problem);
  double with_offset(Index contact, double velocity) const {
    return offset.size() > 0 && contact < contacts ? velocity + offset(contact) : velocity;
  }
  void load_tangents(const ContactProblem& problem);
  IslandUnits::Row measure_row(Index column, Index contact);
  void scale_islands();
  void add_impulses(const PackedColumns& of, Vector& to) const;
  double friction_residual(const SignedFriction& friction) const;
};

/// max(worst, value), infinity where value is NaN.
template <class Real>
Real max_or_infinity(Real worst, Real value) {
  if (value <= worst) return worst;
  return value > worst ? value : Real{std::numeric_limits<double>::infinity()};
}

}  // namespace lcpbench
