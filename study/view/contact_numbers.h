#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench {

/// Numbers of each contact, along its normal and its two tangents.
struct ContactNumbers {
  std::vector<Eigen::Vector3d> impulses;    ///< on the contact [N s]
  std::vector<Eigen::Vector3d> velocities;  ///< [m/s], without the offset b
  std::vector<double> residuals;            ///< the largest of its rows, as in Errors::velocity_residual_m_per_s [m/s]
  Vector velocity;                          ///< of the bodies: ngc
};

/// Of the answer z to a contact problem, in double. Friction directions are taken as those of a regular polygon, which
/// begins at the first tangent.
/// @param inverse  inverse_inertia(problem.inertia)
ContactNumbers contact_numbers(const ContactProblem& problem, const Matrix& inverse, const Vector& z,
                               FrictionModel model);

/// Velocities of the contacts at u (ngc), as above.
std::vector<Eigen::Vector3d> contact_velocities(const ContactProblem& problem, const Vector& u);

}  // namespace lcpbench
