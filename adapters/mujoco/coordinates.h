#pragma once

#include <Eigen/Core>
#include <vector>

#include <mujoco/mujoco.h>

#include "adapters/capture/engine.h"

namespace lcpbench::capture {

/// The inertia of a step over qvel: a block for each tree of joints. It is the one of MuJoCo's Euler step, which is
/// implicit in the damping of joints: M + h diag(damping).
class Coordinates {
 public:
  /// @pre mj_forward was called @param soft  as MuJoCo itself solves: its mass matrix M
  Coordinates(const mjModel& model, const mjData& data, bool soft = false);

  /// The inverse of the inertia times forces, where no constraint acts.
  Eigen::VectorXd accelerations(const Eigen::VectorXd& forces) const;
  /// The blocks with their parts of this velocity.
  std::vector<BlockState> states(const Eigen::VectorXd& velocity) const;
  /// A contact's rows, at the coordinates of the blocks that it moves. @param directions  over qvel: normal, tangents
  Rows rows(const Eigen::MatrixXd& directions) const;

 private:
  struct Block {
    Eigen::Index first = 0;  ///< of its coordinates
    Eigen::MatrixXd mass;
  };
  std::vector<Block> blocks_;
};

}  // namespace lcpbench::capture
