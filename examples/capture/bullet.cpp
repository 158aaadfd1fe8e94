// Captures a sphere of 1 kg that lands on a box of 0.5 kg, from Bullet.
// g++ bullet.cpp -o bullet_capture $(pkg-config --cflags --libs bullet) && ./bullet_capture drop.scenes

#include <btBulletDynamicsCommon.h>

#include "capture.h"

// Bullet calls it between collision detection and its own solver: the velocities do not have the forces yet.
struct CapturingSolver : btSequentialImpulseConstraintSolver {
  lcpbench_capture* capture = nullptr;
  int step = 0;

  btScalar solveGroup(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds, int manifoldCount,
                      btTypedConstraint** constraints, int constraintCount, const btContactSolverInfo& info,
                      btIDebugDraw* drawer, btDispatcher* dispatcher) override {
    lcpbench_capture_step(capture, step, step * info.m_timeStep);
    ++step;
    for (int i = 0; i < bodyCount; ++i) {
      btRigidBody* body = btRigidBody::upcast(bodies[i]);
      bodies[i]->setUserIndex(-1);
      if (body == nullptr || body->getInvMass() == 0) continue;
      const btMatrix3x3 I = body->getInvInertiaTensorWorld().inverse();
      const btVector3 x = body->getCenterOfMassPosition(), w = body->getAngularVelocity();
      const btVector3 v = body->getLinearVelocity() + body->getTotalForce() * (body->getInvMass() * info.m_timeStep);
      const double inertia[9] = {I[0][0], I[0][1], I[0][2], I[1][0], I[1][1], I[1][2], I[2][0], I[2][1], I[2][2]};
      const double position[3] = {x[0], x[1], x[2]}, linear[3] = {v[0], v[1], v[2]}, angular[3] = {w[0], w[1], w[2]};
      body->setUserIndex(lcpbench_capture_body(capture, 1.0 / body->getInvMass(), inertia, position, linear, angular));
    }
    for (int m = 0; m < manifoldCount; ++m) add_contacts(*manifolds[m], info.m_timeStep);
    lcpbench_capture_end_step(capture);
    return btSequentialImpulseConstraintSolver::solveGroup(bodies, bodyCount, manifolds, manifoldCount, constraints,
                                                           constraintCount, info, drawer, dispatcher);
  }

  void add_contacts(const btPersistentManifold& manifold, double h) {
    const int a = manifold.getBody0()->getUserIndex(), b = manifold.getBody1()->getUserIndex();
    for (int i = 0; i < manifold.getNumContacts() && (a >= 0 || b >= 0); ++i) {
      const btManifoldPoint& p = manifold.getContactPoint(i);
      const btVector3 n = p.m_normalWorldOnB.normalized(), x = p.getPositionWorldOnB();
      btVector3 t, other;
      btPlaneSpace1(n, t, other);
      const double point[3] = {x[0], x[1], x[2]}, normal[3] = {n[0], n[1], n[2]}, tangent[3] = {t[0], t[1], t[2]};
      // A gap may close within the step: w = normal velocity + gap / h >= 0.
      const double offset = p.getDistance() > 0 ? p.getDistance() / h : 0.0;
      const int contact =
          lcpbench_capture_contact(capture, a, b, point, normal, tangent, p.m_combinedFriction, 4, offset, nullptr);
      lcpbench_capture_gap(capture, contact, p.getDistance());
    }
  }
};

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  CapturingSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(btVector3(0, 0, -9.81));
  world.getSolverInfo().m_minimumSolverBatchSize = 1 << 20;  // all islands in one call: one step is one problem

  btStaticPlaneShape plane(btVector3(0, 0, 1), 0);
  btBoxShape box(btVector3(0.25, 0.25, 0.125));
  btSphereShape sphere(0.125);
  btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
  world.addRigidBody(&ground);
  const auto add = [&](btCollisionShape& shape, double mass, double height) {
    btVector3 inertia;
    shape.calculateLocalInertia(btScalar(mass), inertia);
    auto* body = new btRigidBody(btRigidBody::btRigidBodyConstructionInfo(btScalar(mass), nullptr, &shape, inertia));
    body->setCenterOfMassTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(height))));
    body->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(body);
    return body;
  };
  btRigidBody* bodies[] = {add(box, 0.5, 0.15), add(sphere, 1.0, 0.5)};

  solver.capture = lcpbench_capture_open(argv[1], "sphere landing on a box", "Bullet", "3", 0.01);
  if (solver.capture == nullptr) return 1;
  lcpbench_capture_loop(solver.capture, "engine");
  for (int step = 0; step < 60; ++step) world.stepSimulation(btScalar(0.01), 0);
  for (btRigidBody* body : bodies) {
    world.removeRigidBody(body);
    delete body;
  }
  return lcpbench_capture_close(solver.capture) == 0 ? 0 : 1;
}
