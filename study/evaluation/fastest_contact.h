#pragma once

#include "core/contact_problem.h"

namespace lcpbench {

struct FastestContact {
  double m_per_s = 0;  ///< largest magnitude along a normal or a direction of friction, offsets left out
  Index contact = -1;  ///< where that is; -1: nothing moves
};

/// Of a velocity u (ngc). Of the difference of two, how differently they move the contacts: velocities that impulses of
/// one problem leave are equal if and only if they are equal at all contacts, where all have the same unit.
FastestContact fastest_contact(const ContactProblem& problem, const Vector& u);

/// Verified answers move differently if their velocities differ at a contact by more than this [m/s]: 1e-3 of the
/// fastest contact before the impact, or of the largest offset. That is well above the residual that they may have.
double least_difference(const ContactProblem& problem);

}  // namespace lcpbench
