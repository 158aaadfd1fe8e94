#pragma once

// Shared by the adapters of Bullet's solvers of worlds.

#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <memory>
#include <vector>

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
static_assert(sizeof(btScalar) == sizeof(double), "needs Bullet's float64 build");
#endif

namespace lcpbench {

struct BulletWorldSettings {
  std::int64_t iterations = 10;
  double sor = 1.0;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 0, .max = 1000000000},
          "sweeps over the rows (m_numIterations); 10 is Bullet's default");
    field("sor", sor, RealRange{.min = 1e-6, .max = 2.0}, "over-relaxation (m_sor); 1 is Bullet's default");
  }
};

inline constexpr Capabilities kBulletWorldCapabilities{
    .needs = Needs::kScene,
    .guarantees = "none; without friction, sweeps converge for 0 < sor < 2",
    .warm_start = true};

template <class SolverType>
class BulletWorldSolver;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// A scene as rigid bodies and contact manifolds, without a world: all that btConstraintSolver::solveGroup takes.
///
/// The offset b of a contact is the distance of its point, in a step of one second. Restitution, gyroscopic terms and
/// split impulses are off, so that the rows are those of the scene's LCP. Bullet limits friction
/// along each of two directions by itself: the pyramid of 4 edges is that square turned by 45 degrees, with mu /
/// sqrt(2).
class BulletWorld {
 public:
  explicit BulletWorld(const RigidScene& scene);

  /// From the scene's velocities, and from the impulses of `start` if there are any, as Bullet starts from those that a
  /// manifold has kept. Writes z.
  void solve(btConstraintSolver& solver, const BulletWorldSettings& settings, const Vector* start, Vector& z);

 private:
  void add(const RigidContact& contact);
  void reset(const Vector* start);
  void read(Vector& z) const;
  double largest_slip(const RigidContact& contact) const;
  btVector3 velocity(int body, const Eigen::Vector3d& point) const;

  RigidScene scene_;
  btRigidBody ground_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btPersistentManifold>> manifolds_;  ///< one of one point for each contact
};

/// SolverType: one of Bullet's constraint solvers of rigid bodies.
template <class SolverType>
class BulletWorldSolver final : public Solver {
 public:
  explicit BulletWorldSolver(const BulletWorldSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kBulletWorldCapabilities; }

 protected:
  void on_load(const Problem& problem) override {
    world_ = std::make_unique<BulletWorld>(*problem.scene());
    solver_.reset();
  }

  void on_solve(const SolveRequest& request, Answer& answer) override {
    if (answer.z.size() > 0) world_->solve(solver_, settings_, request.start, answer.z);
    answer.counters.iterations = settings_.iterations;
    answer.claim = Claim::kSolved;  // it has no failure: a finished step is its claim
  }

 private:
  BulletWorldSettings settings_;
  SolverType solver_;
  std::unique_ptr<BulletWorld> world_;
};

#endif

}  // namespace lcpbench
