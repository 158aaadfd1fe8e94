#include "adapters/bullet/bullet_world.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace lcpbench {
namespace {

constexpr double kHalfRoot = std::numbers::sqrt2 / 2;

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v(0), v(1), v(2)}; }

/// Bullet keeps three principal moments and the axes' directions.
struct PrincipalInertia {
  btVector3 moments;
  btMatrix3x3 axes;
};

PrincipalInertia principal_inertia(const Eigen::Matrix3d& inertia) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(inertia);
  Eigen::Matrix3d axes = eigen.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  return {to_bullet(eigen.eigenvalues()), btMatrix3x3(axes(0, 0), axes(0, 1), axes(0, 2), axes(1, 0), axes(1, 1),
                                                      axes(1, 2), axes(2, 0), axes(2, 1), axes(2, 2))};
}

std::unique_ptr<btRigidBody> make_body(const RigidBody& body) {
  const PrincipalInertia inertia = principal_inertia(body.inertia);
  btRigidBody::btRigidBodyConstructionInfo info(body.mass, nullptr, nullptr, inertia.moments);
  info.m_startWorldTransform = btTransform(inertia.axes, to_bullet(body.position));
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
  // The directions are those given with the points. Impulses are written back only if they may start the next step.
  info.m_solverMode =
      SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS | SOLVER_ENABLE_FRICTION_DIRECTION_CACHING;
  return info;
}

}  // namespace

BulletWorld::BulletWorld(const RigidScene& scene)
    : scene_(scene), ground_(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, nullptr)) {
  for (const RigidBody& body : scene_.bodies) bodies_.push_back(make_body(body));
  for (const RigidContact& contact : scene_.contacts) add(contact);
}

void BulletWorld::add(const RigidContact& contact) {
  const btRigidBody* second =
      contact.body_b == RigidContact::kWorld ? &ground_ : bodies_[static_cast<std::size_t>(contact.body_b)].get();
  constexpr double kNoThreshold = 1e30;
  manifolds_.push_back(std::make_unique<btPersistentManifold>(bodies_[static_cast<std::size_t>(contact.body_a)].get(),
                                                              second, 0, kNoThreshold, kNoThreshold));
  // In a step of one second a distance is the offset b of the row.
  btManifoldPoint point(btVector3(0, 0, 0), btVector3(0, 0, 0), to_bullet(contact.normal), contact.b);
  point.m_positionWorldOnA = point.m_positionWorldOnB = to_bullet(contact.point);
  point.m_combinedFriction = contact.edges > 0 ? contact.mu * kHalfRoot : 0;
  point.m_lateralFrictionDir1 = to_bullet(kHalfRoot * (contact.tangent + second_tangent(contact)));
  point.m_lateralFrictionDir2 = to_bullet(kHalfRoot * (contact.tangent - second_tangent(contact)));
  point.m_contactPointFlags = BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED;
  manifolds_.back()->addManifoldPoint(point);
}

void BulletWorld::reset(const Vector* start) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    bodies_[i]->setLinearVelocity(to_bullet(scene_.bodies[i].linear_velocity));
    bodies_[i]->setAngularVelocity(to_bullet(scene_.bodies[i].angular_velocity));
  }
  auto friction = static_cast<Index>(scene_.contacts.size());
  for (std::size_t i = 0; i < scene_.contacts.size(); ++i) {
    btManifoldPoint& point = manifolds_[i]->getContactPoint(0);
    point.m_appliedImpulse = start != nullptr ? (*start)(static_cast<Index>(i)) : 0;
    point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0;
    if (start != nullptr && scene_.contacts[i].edges > 0) {
      const double along[2] = {(*start)(friction) - (*start)(friction + 2), (*start)(friction + 1) - (*start)(friction + 3)};
      point.m_appliedImpulseLateral1 = kHalfRoot * (along[0] + along[1]);
      point.m_appliedImpulseLateral2 = kHalfRoot * (along[0] - along[1]);
    }
    friction += scene_.contacts[i].edges;
  }
}

void BulletWorld::solve(btConstraintSolver& solver, const BulletWorldSettings& settings, const Vector* start,
                        Vector& z) {
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

void BulletWorld::read(Vector& z) const {
  auto friction = static_cast<Index>(scene_.contacts.size());
  Index lambda = friction;
  for (const RigidContact& contact : scene_.contacts) lambda += contact.edges;
  for (std::size_t i = 0; i < scene_.contacts.size(); ++i) {
    const btManifoldPoint& point = manifolds_[i]->getContactPoint(0);
    z(static_cast<Index>(i)) = point.m_appliedImpulse;
    if (scene_.contacts[i].edges == 0) continue;
    const double along[2] = {kHalfRoot * (point.m_appliedImpulseLateral1 + point.m_appliedImpulseLateral2),
                             kHalfRoot * (point.m_appliedImpulseLateral1 - point.m_appliedImpulseLateral2)};
    for (Index k = 0; k < 2; ++k) {
      z(friction + k) = std::max(along[k], 0.0);
      z(friction + 2 + k) = std::max(-along[k], 0.0);
    }
    friction += scene_.contacts[i].edges;
    z(lambda++) = largest_slip(scene_.contacts[i]);
  }
}

double BulletWorld::largest_slip(const RigidContact& contact) const {
  const btVector3 slip = velocity(contact.body_a, contact.point) - velocity(contact.body_b, contact.point);
  return std::max(std::abs(slip.dot(to_bullet(contact.tangent))),
                  std::abs(slip.dot(to_bullet(second_tangent(contact)))));
}

btVector3 BulletWorld::velocity(int body, const Eigen::Vector3d& point) const {
  if (body == RigidContact::kWorld) return {0, 0, 0};
  const btRigidBody& b = *bodies_[static_cast<std::size_t>(body)];
  return b.getVelocityInLocalPoint(to_bullet(point) - b.getWorldTransform().getOrigin());
}

}  // namespace lcpbench
