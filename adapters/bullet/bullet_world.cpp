// Bullet's solvers of worlds on a rigid scene: sequential impulses, and nonsmooth nonlinear conjugate gradients.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include "core/round_cone.h"
static_assert(sizeof(btScalar) == sizeof(double), "needs Bullet's float64 build");
#endif

class btNNCGConstraintSolver;
class btSequentialImpulseConstraintSolver;

namespace lcpbench {
namespace {

struct BulletWorldSettings {
  static constexpr Capabilities capabilities{.needs = Needs::kScene,
                                             .guarantees = "none; without friction, sweeps converge for 0 < sor < 2",
                                             .warm_start = true};

  std::int64_t iterations = 10;
  double sor = 1.0;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 0, .max = 1000000000},
          "sweeps over the rows (m_numIterations); 10 is Bullet's default");
    field("sor", sor, RealRange{.min = 1e-6, .max = 2.0}, "over-relaxation (m_sor); 1 is Bullet's default");
  }
};

template <class SolverType>
class BulletWorldSolver;

#ifndef LCPBENCH_DESCRIBE_ONLY

constexpr double kHalfSqrt2 = std::numbers::sqrt2 / 2;

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v(0), v(1), v(2)}; }

/// Bullet keeps three principal moments and the axes' directions.
std::unique_ptr<btRigidBody> make_body(const RigidBody& body) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(body.inertia);
  Eigen::Matrix3d axes = eigen.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  btRigidBody::btRigidBodyConstructionInfo info(body.mass, nullptr, nullptr, to_bullet(eigen.eigenvalues()));
  info.m_startWorldTransform =
      btTransform(btMatrix3x3(axes(0, 0), axes(0, 1), axes(0, 2), axes(1, 0), axes(1, 1), axes(1, 2), axes(2, 0),
                              axes(2, 1), axes(2, 2)),
                  to_bullet(body.position));
  auto result = std::make_unique<btRigidBody>(info);
  result->setFlags(0);  // no gyroscopic force
  return result;
}

Eigen::Vector3d second_tangent(const RigidContact& contact) { return contact.normal.cross(contact.tangent); }

btContactSolverInfo solver_info(const BulletWorldSettings& settings) {
  btContactSolverInfo info;
  info.m_numIterations = static_cast<int>(settings.iterations);
  info.m_sor = settings.sor;
  info.m_timeStep = 1;
  info.m_erp = info.m_erp2 = 1;  // so that a negative distance counts in full, as a positive one does
  info.m_splitImpulse = 0;
  // Friction acts along the directions given with the points. Without warm starts Bullet does not write impulses back.
  info.m_solverMode =
      SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS | SOLVER_ENABLE_FRICTION_DIRECTION_CACHING;
  return info;
}

/// A scene as rigid bodies and contact manifolds, without a world: all that btConstraintSolver::solveGroup takes.
///
/// The offset b of a contact is the distance of its point, in a step of one second. Restitution, gyroscopic terms and
/// split impulses are off, so that the rows are those of the scene's LCP. Bullet limits friction along each of two
/// directions by itself: the pyramid of 4 edges is that square turned by 45 degrees, with mu / sqrt(2).
class BulletWorld {
 public:
  explicit BulletWorld(const Problem& problem)
      : scene_(*problem.scene()),
        layout_(contact_layout(*problem.contact())),
        ground_(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, nullptr)) {
    for (const RigidBody& body : scene_.bodies) bodies_.push_back(make_body(body));
    for (const RigidContact& contact : scene_.contacts) add(contact);
  }

  /// From the scene's velocities, and from the impulses of `start`, or zero without one. Bullet takes them for those
  /// that a manifold has kept, and starts from 0.85 of them (m_warmstartingFactor). Writes z.
  void solve(btConstraintSolver& solver, const BulletWorldSettings& settings, const Vector* start, Vector& z) {
    reset(start);
    std::vector<btCollisionObject*> bodies;
    std::vector<btPersistentManifold*> manifolds;
    for (const auto& body : bodies_) bodies.push_back(body.get());
    for (const auto& manifold : manifolds_) manifolds.push_back(manifold.get());
    bodies.push_back(&ground_);
    solver.solveGroup(bodies.data(), static_cast<int>(bodies.size()), manifolds.data(),
                      static_cast<int>(manifolds.size()), nullptr, 0, solver_info(settings), nullptr, nullptr);
    read(z);
  }

 private:
  void add(const RigidContact& contact) {
    const btRigidBody* second =
        contact.body_b == RigidContact::kWorld ? &ground_ : bodies_[static_cast<std::size_t>(contact.body_b)].get();
    constexpr double kNoThreshold = 1e30;
    manifolds_.push_back(std::make_unique<btPersistentManifold>(
        bodies_[static_cast<std::size_t>(contact.body_a)].get(), second, 0, kNoThreshold, kNoThreshold));
    btManifoldPoint point(btVector3(0, 0, 0), btVector3(0, 0, 0), to_bullet(contact.normal), contact.b);
    point.m_positionWorldOnA = point.m_positionWorldOnB = to_bullet(contact.point);
    point.m_combinedFriction = contact.edges > 0 ? contact.mu * kHalfSqrt2 : 0;
    point.m_lateralFrictionDir1 = to_bullet(kHalfSqrt2 * (contact.tangent + second_tangent(contact)));
    point.m_lateralFrictionDir2 = to_bullet(kHalfSqrt2 * (contact.tangent - second_tangent(contact)));
    point.m_contactPointFlags = BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED;
    manifolds_.back()->addManifoldPoint(point);
  }

  void reset(const Vector* start) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      bodies_[i]->setLinearVelocity(to_bullet(scene_.bodies[i].linear_velocity));
      bodies_[i]->setAngularVelocity(to_bullet(scene_.bodies[i].angular_velocity));
    }
    for (std::size_t i = 0; i < manifolds_.size(); ++i) {
      btManifoldPoint& point = manifolds_[i]->getContactPoint(0);
      point.m_appliedImpulse = start != nullptr ? (*start)(static_cast<Index>(i)) : 0;
      point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0;
      if (start == nullptr || layout_.lambda[i] < 0) continue;
      const auto directions = start->segment<4>(layout_.friction_offset() + layout_.friction_begin[i]);
      const Eigen::Vector2d along = directions.head<2>() - directions.tail<2>();
      point.m_appliedImpulseLateral1 = kHalfSqrt2 * (along(0) + along(1));
      point.m_appliedImpulseLateral2 = kHalfSqrt2 * (along(0) - along(1));
    }
  }

  void read(Vector& z) const {
    for (std::size_t i = 0; i < manifolds_.size(); ++i) {
      const btManifoldPoint& point = manifolds_[i]->getContactPoint(0);
      z(static_cast<Index>(i)) = point.m_appliedImpulse;
      if (layout_.lambda[i] < 0) continue;
      share_among_directions(kHalfSqrt2 * (point.m_appliedImpulseLateral1 + point.m_appliedImpulseLateral2),
                             kHalfSqrt2 * (point.m_appliedImpulseLateral1 - point.m_appliedImpulseLateral2),
                             z.segment<4>(layout_.friction_offset() + layout_.friction_begin[i]));
      z(layout_.lambda_offset() + layout_.lambda[i]) = largest_slip(scene_.contacts[i]);
    }
  }

  double largest_slip(const RigidContact& contact) const {
    const btVector3 slip = velocity(contact.body_a, contact.point) - velocity(contact.body_b, contact.point);
    return std::max(std::abs(slip.dot(to_bullet(contact.tangent))),
                    std::abs(slip.dot(to_bullet(second_tangent(contact)))));
  }

  btVector3 velocity(int body, const Eigen::Vector3d& point) const {
    if (body == RigidContact::kWorld) return {0, 0, 0};
    const btRigidBody& b = *bodies_[static_cast<std::size_t>(body)];
    return b.getVelocityInLocalPoint(to_bullet(point) - b.getWorldTransform().getOrigin());
  }

  RigidScene scene_;
  ContactLayout layout_;
  btRigidBody ground_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btPersistentManifold>> manifolds_;  ///< for each contact one, of one point
};

/// SolverType: one of Bullet's constraint solvers of rigid bodies.
template <class SolverType>
class BulletWorldSolver final : public Adapter<BulletWorldSettings> {
 public:
  using Adapter::Adapter;

 private:
  std::string take(const Problem& problem) override {
    world_ = std::make_unique<BulletWorld>(problem);
    solver_.reset();
    return {};
  }

  void call(const SolveRequest& request, Answer& answer) override {
    world_->solve(solver_, settings_, request.start, answer.z);
    answer.counters.iterations = settings_.iterations;
    answer.claim = Claim::kSolved;  // it has no failure: a finished step is its claim
  }

  SolverType solver_;
  std::unique_ptr<BulletWorld> world_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_bullet_si() {
  return define_adapter<BulletWorldSolver<btSequentialImpulseConstraintSolver>, BulletWorldSettings>(
      {.name = "bullet_si",
       .summary = "Bullet's default solver of worlds (float64) on the rigid scene: sequential impulses",
       .source =
           "Bullet Physics, BulletDynamics/ConstraintSolver; a finished step counts as a claim, it has no failure"});
}

SolverDefinition lcpbench_solver_bullet_nncg() {
  return define_adapter<BulletWorldSolver<btNNCGConstraintSolver>, BulletWorldSettings>(
      {.name = "bullet_nncg",
       .summary =
           "Bullet's btNNCGConstraintSolver (float64) on the rigid scene: nonsmooth nonlinear conjugate gradients",
       .source =
           "Bullet Physics, BulletDynamics/ConstraintSolver; Silcowitz-Hansen, Niebe, Erleben 2010, Vis. Comput. 26"});
}

}  // namespace lcpbench
