#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench {

/// Numbers of each contact, along its normal and its two tangents, in double. Friction directions are taken as those of
/// a regular polygon that begins at the first tangent.
class ContactNumbers {
 public:
  /// @param problem  must outlive this object
  explicit ContactNumbers(const ContactProblem& problem);

  /// Without the offset b [m/s]. @param u  ngc
  std::vector<Eigen::Vector3d> velocities(const Vector& u) const;
  /// [N s]
  std::vector<Eigen::Vector3d> impulses(const Vector& z) const;
  /// The largest of each contact's rows, as in Errors::velocity_residual_m_per_s, or of the cone's: see measure_cone().
  /// @param u  the velocity that z implies
  std::vector<double> residuals(const Vector& z, const Vector& u, FrictionModel model) const;

 private:
  const ContactProblem& problem_;
  ContactLayout layout_;
  SparseMatrix N_, D_;
  Vector normal_mass_, friction_mass_;  ///< M_ii
};

}  // namespace lcpbench
