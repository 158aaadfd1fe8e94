#pragma once

#include <cstdint>
#include <memory>

#include "core/contact_problem.h"
#include "native/active_set/active_set_engine.h"
#include "native/contacts/growing_vector.h"

namespace lcpbench {

/// The impulses inside the friction pyramids that leave the least kinetic energy; with an offset b, the least sum of
/// that energy and b'f_N.
///
/// That is the projection of v onto {u : (N_i + mu_i d)'u + b_i >= 0} for every contact i and direction d of its
/// friction, in the metric of the inertia: the problem of active_set, with the edges of the pyramids for normals. A
/// solution of the contact problem in which no contact slips is this projection, so that all such solutions have one
/// velocity. The projection solves the contact problem unless a contact with friction presses and slips: such
/// a contact separates at mu times its slip speed. [Anitescu 2006]
///
/// Contacts that yield need no such choice: their velocity decides their impulses. Those that solve the contact problem
/// are found by Newton's method, whether contacts slip or not, or it gives up. Used by `auto`; here because it is the
/// problem of active_set on the pyramids' edges.
class LeastEnergy {
 public:
  LeastEnergy();

  /// Whether the inertia is given as G, with at least one coordinate, and either the contacts are rigid or all yield
  /// along their normals, enough for accurate impulses in double. Those with friction must then yield along their
  /// tangents, too, and have at most 4 edges.
  static bool takes(const ContactProblem& contact);

  /// Takes all memory that load() and solve() need for this problem, and touches hardly any of it.
  void reserve(const ContactProblem& contact);

  /// Multiplications that load() and solve() take, about, with one change of the active set for each coordinate.
  /// @param idle coordinates that no contact moves, which are left out
  static double work(const ContactProblem& contact, Index idle);

  /// In double: O(ngc^3 / 6 + edges ngc^2 / 2). Allocates nothing for a problem that was reserved.
  /// @pre takes() @param contact must outlive the next load @param v velocity before the impact
  void load(const ContactProblem& contact, const Vector& v);
  void update(const Vector& v) { engine_->update(v.data()); }

  /// Allocates nothing. O(ngc (ngc + edges)) for each change of the active set, O(ngc^2 (ngc + nc)) for a step of
  /// Newton's method.
  /// @param warm from the active set of the last solve since load(), if there is one
  /// @param deadline_s on wall_clock_s() @param steps writes the number of changes of the active set, or Newton steps
  /// @returns whether z() is the minimum, or, of contacts that yield, the solution
  bool solve(bool warm, double deadline_s, std::int64_t& steps);

  /// Whether the mean of the normal velocities N_i'u + b_i at the minimum, weighted by the normal impulses, is above
  /// 1e-6 of the largest |N_i'v + b_i|. Contacts that press then separate, and the minimum is no solution. O(ngc nc)
  /// @pre solve() found the minimum for this v; the contacts do not yield
  bool separates(const Vector& v) const;

  /// The impulses, as long as z of the problem. The lambdas are zero.
  GrowingVector& z() { return z_; }

 private:
  void take_columns();
  void take_rows_of_soft();
  void take_impulses();

  std::unique_ptr<active_set::Engine> engine_;
  const ContactProblem* contact_ = nullptr;
  bool has_last_ = false;  ///< multipliers_ are of a solve since load()
  bool has_velocity_ = false;  ///< velocity_ is that of the last solve; else separates() is false
  GrowingVector compliance_, mu_;  ///< of soft contacts
  GrowingVector columns_, offsets_, inertia_, dense_normals_, dense_directions_;
  GrowingVector multipliers_, velocity_, farkas_, z_;
};

}  // namespace lcpbench
