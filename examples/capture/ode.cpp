// Captures a box of 1 kg that falls onto a plane and slides, from the Open Dynamics Engine.
// g++ ode.cpp -o ode_capture $(pkg-config --cflags --libs ode) && ./ode_capture box.scenes

#include <ode/ode.h>

#include "capture.h"

struct Contacts {
  dWorldID world;
  dJointGroupID joints;
  lcpbench_capture* capture;
};

// ODE's near callback: its contact's normal points into the first geometry, as that of a capture does.
static void collide(void* data, dGeomID first, dGeomID second) {
  auto& contacts = *static_cast<Contacts*>(data);
  dContact found[8];
  const int count = dCollide(first, second, 8, &found[0].geom, sizeof(dContact));
  for (int i = 0; i < count; ++i) {
    dContact& contact = found[i];
    contact.surface.mode = 0;
    contact.surface.mu = 0.5;
    dJointAttach(dJointCreateContact(contacts.world, contacts.joints, &contact), dGeomGetBody(contact.geom.g1),
                 dGeomGetBody(contact.geom.g2));
    const int a = dGeomGetBody(contact.geom.g1) ? 0 : -1;  // this world has one body; -1 is the world
    const int b = dGeomGetBody(contact.geom.g2) ? 0 : -1;
    dVector3 tangent, other;
    dPlaneSpace(contact.geom.normal, tangent, other);
    const int index = lcpbench_capture_contact(contacts.capture, a, b, contact.geom.pos, contact.geom.normal, tangent,
                                               0.5, 4, 0.0, nullptr);
    lcpbench_capture_gap(contacts.capture, index, -contact.geom.depth);
  }
}

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const double h = 0.01, gravity[3] = {0, 0, -9.81}, half[3] = {0.2, 0.2, 0.1}, plane[4] = {0, 0, 1, 0};
  dInitODE();
  const dWorldID world = dWorldCreate();
  const dSpaceID space = dSimpleSpaceCreate(nullptr);
  const dJointGroupID joints = dJointGroupCreate(0);
  dWorldSetGravity(world, gravity[0], gravity[1], gravity[2]);
  dCreatePlane(space, 0, 0, 1, 0);
  const dBodyID box = dBodyCreate(world);
  dMass mass;
  dMassSetBoxTotal(&mass, 1.0, 0.4, 0.4, 0.2);
  dBodySetMass(box, &mass);
  dGeomSetBody(dCreateBox(space, 0.4, 0.4, 0.2), box);
  dBodySetPosition(box, 0, 0, 0.11);
  dBodySetLinearVel(box, 1, 0.25, 0);

  lcpbench_capture* capture = lcpbench_capture_open(argv[1], "box sliding on a plane", "ODE", "0.16", h);
  if (capture == nullptr) return 1;
  lcpbench_capture_loop(capture, "engine");
  lcpbench_capture_gravity(capture, gravity);
  lcpbench_capture_shape(capture, 0, "box", half, 3);
  lcpbench_capture_shape(capture, -1, "plane", plane, 4);
  for (int step = 0; step < 40; ++step) {
    // The velocity that enters the impact: gravity has acted. A rotating body adds its gyroscopic torque here.
    const dReal* velocity = dBodyGetLinearVel(box);
    const double entering[3] = {velocity[0], velocity[1], velocity[2] + h * gravity[2]};
    const dReal* R = dBodyGetRotation(box);  // 3 x 4
    double inertia[9] = {};
    for (int i = 0; i < 9; ++i) {
      for (int k = 0; k < 3; ++k) inertia[i] += R[4 * (i / 3) + k] * mass.I[5 * k] * R[4 * (i % 3) + k];
    }
    lcpbench_capture_step(capture, step, step * h);
    lcpbench_capture_body(capture, mass.mass, inertia, dBodyGetPosition(box), entering, dBodyGetAngularVel(box));
    lcpbench_capture_pose(capture, 0, dBodyGetPosition(box), dBodyGetQuaternion(box));
    Contacts contacts{world, joints, capture};
    dSpaceCollide(space, &contacts, &collide);
    lcpbench_capture_end_step(capture);
    dWorldStep(world, h);
    dJointGroupEmpty(joints);
  }
  const bool is_written = lcpbench_capture_close(capture) == 0;
  dJointGroupDestroy(joints);
  dSpaceDestroy(space);
  dWorldDestroy(world);
  dCloseODE();
  return is_written ? 0 : 1;
}
