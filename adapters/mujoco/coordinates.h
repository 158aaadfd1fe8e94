#pragma once

#include <Eigen/Core>
#include <vector>

#include <mujoco/mujoco.h>

#include "adapters/capture/engine.h"

namespace lcpbench::capture {

/// The coordinates that a step of a model is captured in: a block for each tree of joints. Trees that equality
/// constraints tie together are one block, in coordinates of the null space of these constraints: velocity = Z y. A
/// captured step then has no equality constraints any more. The inertia is the one of MuJoCo's Euler step, which is
/// implicit in the damping of joints: M + h diag(damping).
class Coordinates {
 public:
  /// @pre mj_forward was called and the constraint Jacobian is dense
  /// @param soft  as MuJoCo itself solves: its mass matrix M, and soft equality constraints in the inertia, which is
  ///     M + J'R^-1 J
  Coordinates(const mjModel& model, const mjData& data, bool soft = false);

  /// The inverse of the inertia times forces, where no constraint acts.
  Eigen::VectorXd accelerations(const Eigen::VectorXd& forces) const;
  /// The blocks of the mass matrix, with the velocity that is nearest to this one in kinetic energy.
  std::vector<BlockState> states(const Eigen::VectorXd& velocity) const;
  /// y of a velocity, of all blocks.
  Eigen::VectorXd reduced(const Eigen::VectorXd& velocity) const;
  /// The velocity of all degrees of freedom that y stands for.
  Eigen::VectorXd full(const Eigen::VectorXd& y, int dofs) const;
  /// A contact's rows in these coordinates. @param directions  rows over the model's velocities: normal, tangents
  Rows rows(const Eigen::MatrixXd& directions) const;

 private:
  struct Block {
    std::vector<int> dofs;
    int first = 0;      ///< first coordinate
    Eigen::MatrixXd Z;  ///< empty: the coordinates are the degrees of freedom
    Eigen::MatrixXd mass;
    Eigen::VectorXd reduced(const Eigen::VectorXd& velocity) const;
  };
  std::vector<Block> blocks_;
};

}  // namespace lcpbench::capture
