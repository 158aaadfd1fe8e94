#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench {

// Numbers of each contact, for pictures and tables. A vector has the parts along the normal and along two tangents. The
// friction directions of a contact are taken as those of a regular polygon, whose first direction is the first tangent.

/// The velocity at each contact, without offsets [m/s]. With two edges, that of the one line that they are on.
/// @param u  ngc
std::vector<Eigen::Vector3d> contact_velocities(const ContactProblem& problem, const Vector& u);

/// f_N, and the sum of the friction impulses along the tangents [N s]. @param z  n
std::vector<Eigen::Vector3d> contact_impulses(const ContactProblem& problem, const Vector& z);

/// The largest residual of each contact's rows [m/s], as the evaluation has it, whose largest is
/// Errors::velocity_residual_m_per_s. NaN where it has none. @param z  n
std::vector<double> contact_residuals(const ContactProblem& problem, const Vector& z, FrictionModel model);

}  // namespace lcpbench
