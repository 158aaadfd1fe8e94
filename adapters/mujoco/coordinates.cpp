#include "adapters/mujoco/coordinates.h"

#include <Eigen/Cholesky>
#include <utility>

namespace lcpbench::capture {
namespace {

/// The topmost moving body above a degree of freedom.
int tree_of(const mjModel& model, int dof) {
  int body = model.dof_bodyid[dof];
  while (model.body_weldid[model.body_parentid[body]] != 0) body = model.body_parentid[body];
  return body;
}

}  // namespace

Coordinates::Coordinates(const mjModel& model, const mjData& data, bool soft) {
  Eigen::MatrixXd M(model.nv, model.nv);
  mj_fullM(&model, M.data(), data.qM);  // symmetric
  for (int dof = 0; dof < model.nv && !soft; ++dof) M(dof, dof) += model.opt.timestep * model.dof_damping[dof];
  for (int first = 0, end = 0; first < model.nv; first = end) {
    const int tree = tree_of(model, first);
    while (end < model.nv && tree_of(model, end) == tree) ++end;
    blocks_.push_back({first, M.block(first, first, end - first, end - first)});
  }
}

Eigen::VectorXd Coordinates::accelerations(const Eigen::VectorXd& forces) const {
  Eigen::VectorXd result(forces.size());
  for (const auto& [first, mass] : blocks_) {
    result.segment(first, mass.rows()) = mass.llt().solve(forces.segment(first, mass.rows()));
  }
  return result;
}

std::vector<BlockState> Coordinates::states(const Eigen::VectorXd& velocity) const {
  std::vector<BlockState> result;
  for (const auto& [first, mass] : blocks_) result.push_back({mass, velocity.segment(first, mass.rows())});
  return result;
}

Rows Coordinates::rows(const Eigen::MatrixXd& directions) const {
  Rows result;
  for (const auto& [first, mass] : blocks_) {
    if (directions.middleCols(first, mass.rows()).isZero(0)) continue;
    for (Eigen::Index k = first; k < first + mass.rows(); ++k) result.coordinates.push_back(static_cast<int>(k));
  }
  result.normal = directions.row(0)(result.coordinates);
  if (directions.rows() == 1) return result;
  result.tangent = directions.row(1)(result.coordinates);
  result.second_tangent = directions.row(2)(result.coordinates);
  return result;
}

}  // namespace lcpbench::capture
