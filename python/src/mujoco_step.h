#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/io/problem_checks.h"
#include "core/problem.h"
#include "python/src/arrays.h"

// The contacts of a step of MuJoCo as a problem, for lcpbench/mujoco.py, which hands in the engine's own arrays: a
// simulator's loop has no time for dozens of calls of numpy.

namespace lcpbench::python {

using Numbers = nb::ndarray<const double, nb::device::cpu, nb::c_contig>;
using Integers = nb::ndarray<const int, nb::device::cpu, nb::c_contig>;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Contacts, and limits of joints and tendons, as rows over qvel.
struct MujocoRows {
  Matrix N, T;  ///< a column, and two, for each; zero without friction
  Vector mu, gap;
  Eigen::Matrix<double, 3, Eigen::Dynamic> forces, frames[3];  ///< frames: point, normal, tangent; NaN of limits
  std::vector<int> first;                                      ///< row in efc_J
};

/// @param contact  efc_address, dim, friction, dist, pos, frame of mjData's contacts @param limits  rows of efc_J
inline MujocoRows mujoco_rows(const Eigen::Map<const RowMatrix>& J, const Numbers& force, const Numbers& efc_pos,
                              const nb::tuple& contact, std::pair<int, int> limits, bool pyramidal) {
  const auto address = nb::cast<Integers>(contact[0]), dim = nb::cast<Integers>(contact[1]);
  const auto friction = nb::cast<Numbers>(contact[2]), dist = nb::cast<Numbers>(contact[3]);
  const auto point = nb::cast<Numbers>(contact[4]), frame = nb::cast<Numbers>(contact[5]);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < address.size(); ++i) {
    if (address.data()[i] >= 0) kept.push_back(i);
  }
  const auto touching = static_cast<Index>(kept.size()), count = touching + limits.second - limits.first;
  MujocoRows rows{.N = Matrix(J.cols(), count),
                  .T = Matrix::Zero(J.cols(), 2 * count),
                  .mu = Vector::Zero(count),
                  .gap = Vector(count),
                  .forces = Matrix::Zero(3, count),
                  .frames = {},
                  .first = {}};
  for (auto& each : rows.frames) each.setConstant(3, count, std::numeric_limits<double>::quiet_NaN());
  const double* const f = force.data();
  for (Index c = 0; c < count; ++c) {
    const std::size_t i = c < touching ? kept[static_cast<std::size_t>(c)] : 0;
    const int at = c < touching ? address.data()[i] : limits.first + static_cast<int>(c - touching);
    rows.first.push_back(at);
    rows.N.col(c) = J.row(at);
    rows.forces(0, c) = f[at];
    rows.gap(c) = c < touching ? dist.data()[i] : efc_pos.data()[at];
    if (c >= touching) continue;
    rows.frames[0].col(c) = Eigen::Map<const Eigen::Vector3d>(point.data() + 3 * i);
    rows.frames[1].col(c) = Eigen::Map<const Eigen::Vector3d>(frame.data() + 9 * i);
    rows.frames[2].col(c) = Eigen::Map<const Eigen::Vector3d>(frame.data() + 9 * i + 3);
    if (dim.data()[i] == 1) continue;
    const double* const along = friction.data() + 5 * i;
    rows.mu(c) = along[0];
    const int edges = 2 * (dim.data()[i] - 1);  // of a pyramid: n + mu_1 t_1, n - mu_1 t_1, n + mu_2 t_2, ...
    if (pyramidal) {
      rows.N.col(c) = 0.5 * (J.row(at) + J.row(at + 1));
      rows.forces(0, c) = Eigen::Map<const Vector>(f + at, edges).sum();
    }
    for (int k = 0; k < 2; ++k) {  // the second tangent is scaled, so that one mu is the friction along both
      if (pyramidal) {
        rows.T.col(2 * c + k) = (J.row(at + 2 * k) - J.row(at + 2 * k + 1)) / (2 * along[0]);
        rows.forces(1 + k, c) = along[0] * (f[at + 2 * k] - f[at + 2 * k + 1]);
      } else {
        rows.T.col(2 * c + k) = along[k] / along[0] * J.row(at + 1 + k);
        rows.forces(1 + k, c) = along[0] / along[k] * f[at + 1 + k];
      }
    }
  }
  return rows;
}

/// @param G  blocks of the inertia of the step @param qvel  after the step @param Z  null space of equality constraints
/// @returns the problem, the velocity after the step in its coordinates, impulses and frames of its contacts, their
///     gaps and first rows in efc_J
inline nb::tuple mujoco_step(const Numbers& efc_J, const Numbers& force, const Numbers& efc_pos,
                             const nb::tuple& contact, std::pair<int, int> limits, bool pyramidal,
                             const std::vector<Matrix>& G, const Vector& qvel, double h, const std::optional<Matrix>& Z,
                             const std::string& name) {
  const Eigen::Map<const RowMatrix> J(efc_J.data(), static_cast<Index>(efc_J.shape(0)), qvel.size());
  MujocoRows rows = mujoco_rows(J, force, efc_pos, contact, limits, pyramidal);
  const Index count = rows.N.cols();
  Vector own = rows.N * rows.forces.row(0).transpose();
  const Matrix pushed = rows.forces.bottomRows(2);
  own += rows.T * Eigen::Map<const Vector>(pushed.data(), 2 * count);
  ContactProblem problem;
  problem.v = qvel;
  Vector after = qvel;
  Index at = 0;
  for (const Matrix& block : G) {  // the velocity without the contacts' forces
    problem.v.segment(at, block.rows()) -= h * block.llt().solve(own.segment(at, block.rows()));
    at += block.rows();
  }
  BlockInertia inertia{G};
  if (Z) {
    Matrix dense = Matrix::Zero(qvel.size(), qvel.size());
    at = 0;
    for (const Matrix& block : G) {
      dense.block(at, at, block.rows(), block.rows()) = block;
      at += block.rows();
    }
    const Matrix reduced = Z->transpose() * dense * *Z;
    const Eigen::LLT<Matrix> solver(reduced);
    for (Vector* each : {&problem.v, &after}) *each = solver.solve(Z->transpose() * (dense * *each)).eval();
    rows.N = (Z->transpose() * rows.N).eval();
    rows.T = (Z->transpose() * rows.T).eval();
    inertia.blocks = {reduced};
  }
  for (Matrix& block : inertia.blocks) block = (0.5 * block + 0.5 * block.transpose()).eval();
  problem.inertia = std::move(inertia);
  problem.mu = rows.mu;
  problem.b = rows.gap.cwiseMax(0) / h;
  if (problem.b.isZero(0)) problem.b.resize(0);
  Matrix D(rows.N.rows(), 4 * (rows.mu.array() > 0).count());
  for (Index c = 0, d = 0; c < count; ++c) {
    problem.edges.push_back(rows.mu(c) > 0 ? 4 : 0);
    if (!(rows.mu(c) > 0)) continue;
    D.middleCols(d, 2) = rows.T.middleCols(2 * c, 2);
    D.middleCols(d + 2, 2) = -rows.T.middleCols(2 * c, 2);
    d += 4;
  }
  constexpr Index kDense = 1 << 14;
  problem.N = rows.N.size() > kDense ? Jacobian(SparseMatrix(rows.N.sparseView())) : Jacobian(rows.N);
  problem.D = D.size() > kDense ? Jacobian(SparseMatrix(D.sparseView())) : Jacobian(D);
  check_usable(problem);
  Matrix frames(9, count);
  for (Index k = 0; k < 3; ++k) frames.middleRows(3 * k, 3) = rows.frames[k];
  const auto flat = [](const Matrix& matrix) { return array(Eigen::Map<const Vector>(matrix.data(), matrix.size())); };
  return nb::make_tuple(Problem(name, std::move(problem)), array(after), flat(h * rows.forces), flat(frames),
                        array(rows.gap), rows.first);
}

}  // namespace lcpbench::python
