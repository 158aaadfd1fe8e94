#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/scene.h"
#include "core/solver.h"
#include "core/warm_start.h"

// The one header to solve contacts in a simulator: installed as <lcpbench/lcpbench.h>, with all that it includes in one
// file; the package's target is lcpbench::native. docs/howto/embedding.md shows its use.

namespace lcpbench {

/// A solver of this library, which ContactSolver makes by name.
struct NativeSolver {
  std::string name;      ///< what ContactSolver takes
  std::string summary;   ///< one line
  std::string source;    ///< where the method comes from
  bool friction = true;  ///< false: takes frictionless contacts only, at its default settings
};

/// Every solver that ContactSolver knows, in a fixed order.
std::vector<NativeSolver> native_solvers();

/// How Eigen lays out and allocates matrices in the code that includes this header. Code that was compiled with another
/// layout must not exchange matrices with it: it would read wrong entries, or free memory by the wrong function.
struct EigenLayout {
  int version = 100 * EIGEN_WORLD_VERSION + EIGEN_MAJOR_VERSION;
  int alignment = EIGEN_DEFAULT_ALIGN_BYTES;              ///< -mavx, -march=native and the like change it
  bool plain_malloc = EIGEN_MALLOC_ALREADY_ALIGNED != 0;  ///< -fsanitize=address changes it
  int index_bytes = sizeof(Eigen::Index);                 ///< EIGEN_DEFAULT_DENSE_INDEX_TYPE
  bool row_major = Eigen::MatrixXd::IsRowMajor;           ///< EIGEN_DEFAULT_TO_ROW_MAJOR

  bool operator==(const EigenLayout&) const = default;
};

/// Turns contacts into impulses, once per time step.
///
/// Given the velocity v that the bodies would have without contacts, finds impulses under which no contact approaches,
/// none pulls, separating contacts do not push, and friction stays in its pyramid and opposes slip [Anitescu, Potra
/// 1997]: the problem of ContactProblem. The contacts' offset b expresses restitution, gaps and the correction of
/// penetration; with b = 0 impacts are inelastic.
///
///     ContactSolver solver("auto");
///     solver.load(scene, ids);               // the first step
///     if (solver.solve() == Claim::kSolved) v = solver.velocity();
///     solver.update(scene, ids);             // each step: the contacts of now, with the names that they keep
///     if (solver.solve() == Claim::kSolved) v = solver.velocity();
///     solver.set_velocity(v);                // instead, where only the velocity is new
///
/// Units are SI: v in m/s and rad/s, impulses in N s. One object per thread; objects share nothing. Deterministic: the
/// same calls give the same bits on the same instruction-set level.
///
/// Errors of the caller throw and leave the object as it was; numerical failure is a claim. An object that was moved
/// from can only be destroyed or assigned to.
class ContactSolver {
 public:
  /// @param spec name and settings: "auto", "contact_lemke{precision=double}", "active_set"; see
  ///     native_solvers() and the page of each solver in docs/
  /// @param layout keep the default: it tells how the caller's code was compiled
  /// @throws InputError for an unknown name or setting, a solver that is not native, a value out of range, and a layout
  ///     other than the library's; the message names what differs
  explicit ContactSolver(std::string_view spec, EigenLayout layout = {});
  ~ContactSolver();
  ContactSolver(ContactSolver&& other) noexcept;
  ContactSolver& operator=(ContactSolver&& other) noexcept;

  /// Takes bodies and contacts; the bodies' velocities are the first v. O(bodies + contacts) and the solver's own work
  /// on the matrices, which its page tells. Allocates.
  /// @param ids one for each contact, by which the next update() finds it again; none: update() keeps no impulses
  /// @throws InputError naming body or contact and field: an index out of range, a mass that is not positive or whose
  ///     inverse overflows, an inertia that is not symmetric (to 1e-6 of its largest entry) and positive definite,
  ///     edges other than 0 and 4, a normal or a tangent that is no unit vector, or a tangent that is not orthogonal to
  ///     the normal (to 1e-6), mu < 0, compliance < 0, mu, compliance_t or offset_t other than 0 without edges, one
  ///     body on both sides, NaN or infinity, or a problem outside what the solver takes (friction given to a
  ///     frictionless solver, n over its limit), or ids in another number than contacts
  void load(const RigidScene& scene, std::span<const ContactId> ids = {});

  /// The same for generalized coordinates, in any form that ContactProblem has, with bounded rows for joints. Copied.
  /// @throws InputError when sizes do not fit together, edges are odd or negative, mu < 0, compliance < 0, mu,
  ///     compliance_t or offset_t is not 0 without edges, bounds of a row are not lower <= 0 <= upper or both 0, or its
  ///     load has another lower bound than 0, a number is NaN or infinite, or the solver does not take it.
  ///     That G is symmetric and positive definite and that D comes in +- pairs is the caller's promise: testing it
  ///     would cost more than a solve (`lcpbench solve` tests it).
  void load(const ContactProblem& contacts, std::span<const ContactId> ids = {});

  /// The bodies and contacts of the next time step: another number of contacts, other points, normals, inertia. The
  /// next solve starts from the impulses of the last one, contact by contact as the ids match, where the solver can use
  /// them, and from zero for contacts that are new. Bounded rows keep theirs where there are as many as before. An
  /// answer passes the same tests from any start. The start decides how much work a solve takes, and so whether it ends
  /// within a limit, and which of several solutions it finds. Before load() it is load(). Costs and errors are those of
  /// load().
  void update(const RigidScene& scene, std::span<const ContactId> ids);
  void update(const ContactProblem& contacts, std::span<const ContactId> ids);

  /// Another velocity for the same contacts, offsets and inertia. There is no answer until the next solve.
  /// ngc entries: for scenes six per body, linear then angular. A solver that keeps what depends on contacts and
  /// inertia alone only replaces v; others load again, which allocates. docs/howto/embedding.md lists the former.
  /// @throws InputError for another number of entries, NaN or infinity; std::logic_error before load()
  void set_velocity(const Vector& v);

  /// Solves what is loaded, from the impulses of the last solve, finished or cut short, where the solver can use them.
  ///
  /// Allocates nothing with solvers that are `allocation_free` (see capabilities()), except in the first call after
  /// load() or update(), in exact arithmetic, and, if the solver takes soft contacts by their rigid equivalent, with
  /// contacts that have offset_t and no compliance_t. Only where the inertia may be singular or a b is negative, exact
  /// arithmetic may test an answer, or try to prove that there is none.
  /// @param time_limit_s wall clock; solvers that say `obeys_time_limit` exceed it by a few pivots at most
  /// @returns kSolved: every condition holds to the solver's tolerance; kUnsolvable: no impulses satisfy the normal
  ///     rows (only with singular inertia or a negative b); kIterationLimit, kTimeLimit, kNumericalFailure,
  ///     kUnsupported: no answer. A claim is the solver's own: docs/ tells for each how it is tested.
  /// @throws std::logic_error before load()
  Claim solve(double time_limit_s = std::numeric_limits<double>::infinity());

  /// The velocity (ngc entries) under the impulses found, v + G* J f; v itself unless the last claim is kSolved. It is
  /// the solver's where that returns one. Else the first call after a solve computes it, by products with N, D and G*;
  /// with solvers that are not `allocation_free` the first of these after load() or update() also inverts G.
  /// The vector changes in load(), in update(), and in the first call of velocity() after solve() or set_velocity().
  /// Not to be called by two threads at once.
  /// @throws std::logic_error before load(), as do the next four
  const Vector& velocity() const;

  /// Impulse along the contact's normal [N s], >= 0; 0 unless the last claim is kSolved. The last iterate of a solver
  /// that was cut short is answer().z.
  /// @throws std::out_of_range, as do the next three, for a contact, direction or row that does not exist
  double normal_impulse(Index contact) const;

  /// Net friction impulse [N s] along direction t of the contact, t < edges / 2. Of a scene: 0 is the contact's
  /// tangent, 1 is normal x tangent.
  double friction_impulse(Index contact, Index t) const;

  /// Impulse of a bounded row [N s, N m s]; 0 unless the last claim is kSolved.
  double row_impulse(Index row) const;

  /// Total impulse on body_a at the contact's point, in world axes [N s]; body_b gets its negative.
  /// @throws std::logic_error unless the contacts were loaded as a scene
  Eigen::Vector3d impulse(Index contact) const;

  /// The whole answer: claim, z in the order of ContactProblem, work done, the stage or reason in words.
  const Answer& answer() const;

  /// What the solver promises with these settings, for what is loaded.
  const Capabilities& capabilities() const;

 private:
  struct State;
  State& loaded() const;
  std::unique_ptr<State> state_;
};

}  // namespace lcpbench
