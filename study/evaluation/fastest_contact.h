#pragma once

#include "core/contact_problem.h"

namespace lcpbench {

struct FastestContact {
  double m_per_s = 0;  ///< largest magnitude along a normal or a direction of friction, offsets left out
  Index contact = -1;  ///< where that is; -1: nothing moves
};

/// The largest speed that a velocity u (ngc) gives to a contact. Of the difference of two velocities it is the distance
/// between them in m/s, whatever the units of the coordinates: two velocities that impulses of one problem lead to are
/// equal if and only if they are equal at all contacts.
FastestContact fastest_contact(const ContactProblem& problem, const Vector& u);

/// Verified answers move differently if their velocities differ at a contact by more than this [m/s]: 1e-3 of the
/// fastest contact before the impact, or of the largest normal or tangential offset if that is larger. That is well
/// above the residual that they may have, 1e-4 of the scale of the island.
double least_difference(const ContactProblem& problem);

}  // namespace lcpbench
