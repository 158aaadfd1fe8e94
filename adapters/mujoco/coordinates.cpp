#include "adapters/mujoco/coordinates.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace lcpbench::capture {
namespace {

using DenseRows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

/// The topmost moving body above a degree of freedom.
int tree_of(const mjModel& model, int dof) {
  int body = model.dof_bodyid[dof];
  while (model.body_weldid[model.body_parentid[body]] != 0) body = model.body_parentid[body];
  return body;
}

}  // namespace

Eigen::VectorXd Coordinates::Block::reduced(const Eigen::VectorXd& velocity) const {
  const Eigen::VectorXd v = velocity(dofs);
  if (Z.size() == 0) return v;
  return (Z.transpose() * mass * Z).llt().solve(Z.transpose() * (mass * v));
}

Coordinates::Coordinates(const mjModel& model, const mjData& data, bool soft) {
  const DenseRows J(data.efc_J, data.nefc, model.nv);
  std::vector<int> group(static_cast<std::size_t>(model.nv));
  for (int dof = 0; dof < model.nv; ++dof) group[static_cast<std::size_t>(dof)] = tree_of(model, dof);
  std::map<int, std::vector<int>> ties;  // group -> its equality rows
  for (int row = 0; row < data.ne; ++row) {
    std::set<int> touched;
    for (int dof = 0; dof < model.nv; ++dof) {
      if (J(row, dof) != 0) touched.insert(group[static_cast<std::size_t>(dof)]);
    }
    if (touched.empty()) continue;
    const int one = *touched.begin();
    std::vector<int> merged{row};
    for (const int each : touched) {
      merged.insert(merged.end(), ties[each].begin(), ties[each].end());
      ties.erase(each);
      std::replace(group.begin(), group.end(), each, one);
    }
    ties[one] = std::move(merged);
  }
  Eigen::MatrixXd M(model.nv, model.nv);
  mj_fullM(&model, M.data(), data.qM);  // symmetric
  for (int dof = 0; dof < model.nv && !soft; ++dof) M(dof, dof) += model.opt.timestep * model.dof_damping[dof];
  std::map<int, Block> blocks;
  for (int dof = 0; dof < model.nv; ++dof) blocks[group[static_cast<std::size_t>(dof)]].dofs.push_back(dof);
  int first = 0;
  for (auto& [name, block] : blocks) {
    block.mass = M(block.dofs, block.dofs);
    block.first = first;
    auto size = static_cast<Eigen::Index>(block.dofs.size());
    if (const auto rows = ties.find(name); rows != ties.end()) {
      const Eigen::MatrixXd E = J(rows->second, block.dofs);
      if (soft) {
        const Eigen::VectorXd R = Eigen::Map<const Eigen::VectorXd>(data.efc_R, data.nefc)(rows->second);
        block.mass += E.transpose() * R.cwiseInverse().asDiagonal() * E;
      } else {
        const auto decomposed = [](const Eigen::MatrixXd& constraints) {
          Eigen::ColPivHouseholderQR<Eigen::MatrixXd> result(constraints.transpose());
          result.setThreshold(1e-2);  // MuJoCo lets a chain come apart a little: rows that say the same differ a little
          return result;
        };
        const Eigen::VectorXi ids = Eigen::Map<const Eigen::VectorXi>(data.efc_id, data.ne)(rows->second);
        std::map<int, double> longest;  // row of each constraint
        for (Eigen::Index i = 0; i < E.rows(); ++i) longest[ids(i)] = std::max(longest[ids(i)], E.row(i).norm());
        const double least = 1e-8 * E.rowwise().norm().maxCoeff();  // the rows of one that holds anyway are rounding
        Eigen::MatrixXd scaled = E;
        for (Eigen::Index i = 0; i < E.rows(); ++i) scaled.row(i) /= std::max(longest[ids(i)], least);
        auto qr = decomposed(E);
        // A constraint of small coefficients is no copy of another one.
        if (auto other = decomposed(scaled); other.rank() > qr.rank()) qr = std::move(other);
        const Eigen::MatrixXd Q = qr.householderQ();
        block.Z = Q.rightCols(size - qr.rank());
        size = block.Z.cols();
      }
    }
    first += static_cast<int>(size);
    if (size > 0) blocks_.push_back(std::move(block));
  }
}

Eigen::VectorXd Coordinates::accelerations(const Eigen::VectorXd& forces) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(forces.size());
  for (const Block& block : blocks_) {
    const Eigen::VectorXd part = forces(block.dofs);
    const Eigen::VectorXd solved = block.mass.llt().solve(part);
    result(block.dofs) = solved;
  }
  return result;
}

std::vector<BlockState> Coordinates::states(const Eigen::VectorXd& velocity) const {
  std::vector<BlockState> result;
  for (const Block& block : blocks_) {
    const Eigen::MatrixXd mass = block.Z.size() == 0 ? block.mass : block.Z.transpose() * block.mass * block.Z;
    result.push_back({mass, block.reduced(velocity)});
  }
  return result;
}

Eigen::VectorXd Coordinates::reduced(const Eigen::VectorXd& velocity) const {
  std::vector<double> all;
  for (const Block& block : blocks_) {
    const Eigen::VectorXd y = block.reduced(velocity);
    all.insert(all.end(), y.begin(), y.end());
  }
  return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

Eigen::VectorXd Coordinates::full(const Eigen::VectorXd& y, int dofs) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(dofs);
  for (const Block& block : blocks_) {
    const Eigen::Index size = block.Z.size() == 0 ? static_cast<Eigen::Index>(block.dofs.size()) : block.Z.cols();
    const Eigen::VectorXd part = y.segment(block.first, size);
    if (block.Z.size() == 0)
      result(block.dofs) = part;
    else
      result(block.dofs) = block.Z * part;
  }
  return result;
}

Rows Coordinates::rows(const Eigen::MatrixXd& directions) const {
  std::vector<int> coordinates;
  std::vector<Eigen::VectorXd> columns;
  for (const Block& block : blocks_) {
    Eigen::MatrixXd part = directions(Eigen::all, block.dofs);
    if (part.isZero(0)) continue;
    if (block.Z.size() > 0) part = part * block.Z;
    for (Eigen::Index k = 0; k < part.cols(); ++k) {
      coordinates.push_back(block.first + static_cast<int>(k));
      columns.emplace_back(part.col(k));
    }
  }
  Eigen::MatrixXd dense(directions.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) dense.col(static_cast<Eigen::Index>(k)) = columns[k];
  Rows result;
  result.coordinates = std::move(coordinates);
  result.normal = dense.row(0);
  if (dense.rows() > 1) {
    result.tangent = dense.row(1);
    result.second_tangent = dense.row(2);
  }
  return result;
}

}  // namespace lcpbench::capture
