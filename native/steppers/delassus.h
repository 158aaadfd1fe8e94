#pragma once

#include "native/steppers/world.h"

namespace lcpbench::steppers {

/// How the velocities at the contacts depend on the impulses f, three numbers a contact in its frame: W f + g, with the
/// offsets of the normals in g.
struct Delassus {
  SparseMatrix W;
  Vector g;
};

/// @param world  with the forces of the step in its velocities
Delassus delassus(const World& world, double h);

Vector impulses(const World& world);
/// Gives the contacts these impulses and the bodies what they do.
void take_impulses(World& world, const Vector& f);

/// Each contact's three numbers to the nearest point of its cone |f_T| <= mu f_N.
void project_on_cones(const World& world, Vector& f);

}  // namespace lcpbench::steppers
