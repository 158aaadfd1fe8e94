#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "adapters/mujoco/bounded_rows.h"
#include "core/io/problem_checks.h"
#include "core/problem.h"
#include "python/src/arrays.h"

// The contacts and bounded rows of a step of MuJoCo as a problem, for lcpbench/mujoco.py, which hands in the engine's own
// arrays: a simulator's loop has no time for dozens of calls of numpy.

namespace lcpbench::python {

using Numbers = nb::ndarray<const double, nb::device::cpu, nb::c_contig>;
using Integers = nb::ndarray<const int, nb::device::cpu, nb::c_contig>;
using capture::MujocoRowNames;
using capture::RowMatrix;

/// @param model  names, name_jntadr, name_tendonadr, name_eqadr, jnt_type, jnt_dofadr, dof_jntid, tendon_adr, tendon_num,
///     wrap_type, wrap_objid, eq_type, eq_obj1id of mjModel
inline MujocoRowNames mujoco_row_names(const nb::bytes& names, const nb::tuple& model) {
  std::vector<Integers> arrays;
  for (const nb::handle each : model) arrays.push_back(nb::cast<Integers>(each));
  const auto at = [&](std::size_t i) { return arrays.at(i).data(); };
  const auto size = [&](std::size_t i) { return static_cast<int>(arrays.at(i).size()); };
  return MujocoRowNames({.njnt = size(3),
                         .nv = size(5),
                         .ntendon = size(6),
                         .neq = size(10),
                         .names = names.c_str(),
                         .name_jntadr = at(0),
                         .name_tendonadr = at(1),
                         .name_eqadr = at(2),
                         .jnt_type = at(3),
                         .jnt_dofadr = at(4),
                         .dof_jntid = at(5),
                         .tendon_adr = at(6),
                         .tendon_num = at(7),
                         .wrap_type = at(8),
                         .wrap_objid = at(9),
                         .eq_type = at(10),
                         .eq_obj1id = at(11)});
}

/// The arrays of mjData that rows beside contacts are made of, held while they are read.
class MujocoRows {
 public:
  /// @param of  ne, nf, nl @param arrays  efc_type, efc_id, efc_force, efc_pos, efc_frictionloss, efc_R
  MujocoRows(const Numbers& efc_J, Index nv, const nb::tuple& of, const nb::tuple& arrays)
      : J_(efc_J), type_(nb::cast<Integers>(arrays[0])), id_(nb::cast<Integers>(arrays[1])),
        numbers_{nb::cast<Numbers>(arrays[2]), nb::cast<Numbers>(arrays[3]), nb::cast<Numbers>(arrays[4]),
                 nb::cast<Numbers>(arrays[5])},
        all({.J = Eigen::Map<const RowMatrix>(J_.data(), static_cast<Index>(J_.shape(0)), nv),
             .ne = nb::cast<int>(of[0]),
             .nf = nb::cast<int>(of[1]),
             .nl = nb::cast<int>(of[2]),
             .type = type_.data(),
             .id = id_.data(),
             .force = numbers_[0].data(),
             .pos = numbers_[1].data(),
             .frictionloss = numbers_[2].data(),
             .R = numbers_[3].data()}) {}

 private:
  Numbers J_;
  Integers type_, id_;
  Numbers numbers_[4];

 public:
  const capture::MujocoRowArrays all;
};

/// Contacts as rows over qvel.
struct MujocoContacts {
  Matrix N, T;  ///< a column, and two, for each; zero without friction
  Vector mu, gap;
  Eigen::Matrix<double, 3, Eigen::Dynamic> forces, frames[3];  ///< frames: point, normal, tangent
  std::vector<int> first;                                      ///< row in efc_J
};

/// @param contact  efc_address, dim, friction, dist, pos, frame of mjData's contacts
inline MujocoContacts mujoco_contacts(const Eigen::Map<const RowMatrix>& J, const double* f, const nb::tuple& contact,
                                      bool pyramidal) {
  const auto address = nb::cast<Integers>(contact[0]), dim = nb::cast<Integers>(contact[1]);
  const auto friction = nb::cast<Numbers>(contact[2]), dist = nb::cast<Numbers>(contact[3]);
  const auto point = nb::cast<Numbers>(contact[4]), frame = nb::cast<Numbers>(contact[5]);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < address.size(); ++i) {
    if (address.data()[i] >= 0) kept.push_back(i);
  }
  const auto count = static_cast<Index>(kept.size());
  MujocoContacts rows{.N = Matrix(J.cols(), count),
                      .T = Matrix::Zero(J.cols(), 2 * count),
                      .mu = Vector::Zero(count),
                      .gap = Vector(count),
                      .forces = Matrix::Zero(3, count),
                      .frames = {},
                      .first = {}};
  for (auto& each : rows.frames) each.resize(3, count);
  for (Index c = 0; c < count; ++c) {
    const std::size_t i = kept[static_cast<std::size_t>(c)];
    const int at = address.data()[i];
    rows.first.push_back(at);
    rows.N.col(c) = J.row(at);
    rows.forces(0, c) = f[at];
    rows.gap(c) = dist.data()[i];
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

/// @param rows  ne, nf, nl @param efc  as MujocoRows has it @param G  blocks of the inertia of the step
/// @param qvel  after the step
/// @returns the problem; impulses and frames of its contacts, their gaps and first rows in efc_J; impulses of its bounded
///     rows, and how many rows of equality constraints are left out
inline nb::tuple mujoco_step(const Numbers& efc_J, const nb::tuple& rows_of, const nb::tuple& efc,
                             const nb::tuple& contact, bool pyramidal, const std::vector<Matrix>& G, const Vector& qvel,
                             double h, const MujocoRowNames& names, const std::string& name) {
  const MujocoRows step(efc_J, qvel.size(), rows_of, efc);
  const MujocoContacts rows = mujoco_contacts(step.all.J, step.all.force, contact, pyramidal);
  capture::MujocoBoundedRows bounded = capture::hard_rows(step.all, names, h);
  const Index count = rows.N.cols();
  const Matrix pushed = h * rows.forces.bottomRows(2);
  const Vector own = h * rows.N * rows.forces.row(0).transpose() +
                     rows.T * Eigen::Map<const Vector>(pushed.data(), 2 * count) +
                     std::get<Matrix>(bounded.rows.R) * bounded.impulses;
  ContactProblem problem;
  problem.v = qvel;
  BlockInertia inertia{G};
  Index at = 0;
  for (Matrix& block : inertia.blocks) {  // the velocity without these impulses
    problem.v.segment(at, block.rows()) -= block.llt().solve(own.segment(at, block.rows()));
    at += block.rows();
    block = (0.5 * block + 0.5 * block.transpose()).eval();
  }
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
  const auto stored = [](const Matrix& J) {
    return J.size() > kDense ? Jacobian(SparseMatrix(J.sparseView())) : Jacobian(J);
  };
  problem.N = stored(rows.N);
  problem.D = stored(D);
  problem.rows = std::move(bounded.rows);
  problem.rows.R = stored(std::get<Matrix>(problem.rows.R));
  check_usable(problem);
  Matrix frames(9, count);
  for (Index k = 0; k < 3; ++k) frames.middleRows(3 * k, 3) = rows.frames[k];
  const auto flat = [](const Matrix& matrix) { return array(Eigen::Map<const Vector>(matrix.data(), matrix.size())); };
  return nb::make_tuple(Problem(name, std::move(problem)), flat(h * rows.forces), flat(frames), array(rows.gap),
                        rows.first, array(bounded.impulses), bounded.repeated_rows);
}

}  // namespace lcpbench::python
