#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench {

/// Velocity, impulse and residual of each contact, for pictures and tables, in double. A vector has the parts along the
/// normal and along two tangents. The friction directions of a contact are taken as those of a regular polygon, whose
/// first direction is the first tangent. If `edges` is no multiple of 4, no direction is the second tangent.
class ContactNumbers {
 public:
  /// @param problem  must outlive this object
  explicit ContactNumbers(const ContactProblem& problem);

  /// N'u and D'u, without the offset b [m/s]. The part along the second tangent is 0 where no direction is that
  /// tangent.
  /// @param u  ngc
  std::vector<Eigen::Vector3d> velocities(const Vector& u) const;
  /// f_N, and the sum of the friction impulses along the tangents [N s]. @param z  n
  std::vector<Eigen::Vector3d> impulses(const Vector& z) const;
  /// The largest residual of each contact's rows [m/s]: those of the round cone for `kCone`, see measure_cone(), and
  /// those of the pyramid for all other models, as in Errors::velocity_residual_m_per_s.
  /// They leave out compliance and tangential offsets: of soft contacts they are not those of the verdict.
  /// @param u  the velocity that z implies
  std::vector<double> residuals(const Vector& z, const Vector& u, FrictionModel model) const;

 private:
  const ContactProblem& problem_;
  ContactLayout layout_;
  SparseMatrix N_, D_;
  Vector normal_mass_, friction_mass_;  ///< M_ii
};

}  // namespace lcpbench
