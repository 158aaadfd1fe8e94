#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench {

/// Velocity, impulse and residual of each contact, for pictures and tables, in double. A vector has the parts along the
/// normal and along two tangents. The friction directions of a contact are taken as those of a regular polygon, whose
/// first direction is the first tangent.
class ContactNumbers {
 public:
  /// @param problem  must outlive this object
  explicit ContactNumbers(const ContactProblem& problem);

  /// The velocity at each contact, without offsets [m/s]. With two edges, that of the one line that they are on.
  /// @param u  ngc
  std::vector<Eigen::Vector3d> velocities(const Vector& u) const;
  /// f_N, and the sum of the friction impulses along the tangents [N s]. @param z  n
  std::vector<Eigen::Vector3d> impulses(const Vector& z) const;
  /// The largest residual of each contact's rows [m/s], with compliance and offsets: those of the pyramid as in
  /// Errors::velocity_residual_m_per_s, those of the other models as in measure_friction().
  /// @param u  the velocity that z implies
  std::vector<double> residuals(const Vector& z, const Vector& u, FrictionModel model) const;

 private:
  /// The sum of the directions of a contact, each times its entry. @param of_directions  one entry for each of D
  Eigen::Vector2d along_tangents(std::size_t contact, const Eigen::Ref<const Vector>& of_directions) const;

  const ContactProblem& problem_;
  ContactLayout layout_;
  SparseMatrix N_, D_;
  Vector normal_mass_, friction_mass_;  ///< M_ii less what compliance adds
};

}  // namespace lcpbench
