#pragma once

#include <Eigen/QR>
#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "core/contact_problem.h"

// The rows of a step of MuJoCo that belong to no contact, from the engine's own arrays: for the program, which has
// Debian's MuJoCo, and for the Python package, which has PyPI's.

namespace lcpbench::capture {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Arrays of an mjModel.
struct MujocoModelArrays {
  int njnt, nv, ntendon, neq;
  const char* names;
  const int *name_jntadr, *name_tendonadr, *name_eqadr, *jnt_type, *jnt_dofadr, *dof_jntid, *tendon_adr, *tendon_num,
      *wrap_type, *wrap_objid, *eq_type, *eq_obj1id;
};

/// Arrays of an mjData. Rows come in the order of equality constraints, friction, limits, contacts.
struct MujocoRowArrays {
  Eigen::Map<const RowMatrix> J;
  int ne, nf, nl;
  const int *type, *id;
  const double *force, *pos, *frictionloss, *R;

  int count() const { return ne + nf + nl; }
};

/// Names of rows, each with the kind of constraint ("hinge friction knee"), and whether they are about angles. The
/// length of a tendon that only hinges make is an angle times numbers of any unit.
class MujocoRowNames {
 public:
  explicit MujocoRowNames(const MujocoModelArrays& model) {
    static constexpr const char* kJoints[] = {"free joint", "ball joint", "slide", "hinge"};
    static constexpr const char* kEqualities[] = {"connect", "weld", "joint", "tendon"};
    const auto name = [&](const int* address, int i) {
      const std::string own = model.names + address[i];
      return own.empty() ? std::to_string(i) : own;
    };
    const auto turns = [&](int joint) { return model.jnt_type[joint] == kBall || model.jnt_type[joint] == kHinge; };
    for (int i = 0; i < model.njnt; ++i) {
      joints_.push_back({kJoints[model.jnt_type[i]], name(model.name_jntadr, i), turns(i)});
    }
    for (int dof = 0; dof < model.nv; ++dof) {
      const int joint = model.dof_jntid[dof];
      dofs_.push_back(joints_[static_cast<std::size_t>(joint)]);
      dofs_.back().is_angle = turns(joint) || (model.jnt_type[joint] == kFree && dof - model.jnt_dofadr[joint] >= 3);
    }
    for (int i = 0; i < model.ntendon; ++i) {
      bool hinges = true;
      for (int k = model.tendon_adr[i]; k < model.tendon_adr[i] + model.tendon_num[i]; ++k) {
        hinges = hinges && model.wrap_type[k] == kWrapsJoint && model.jnt_type[model.wrap_objid[k]] == kHinge;
      }
      tendons_.push_back({"tendon", name(model.name_tendonadr, i), hinges});
    }
    for (int i = 0; i < model.neq; ++i) {
      const int type = model.eq_type[i], first = model.eq_obj1id[i];
      const bool is_angle = type == kJointEquality    ? turns(first)
                            : type == kTendonEquality ? tendons_[static_cast<std::size_t>(first)].is_angle
                                                      : false;
      equalities_.push_back({type <= kTendonEquality ? kEqualities[type] : "flex", name(model.name_eqadr, i), is_angle,
                             type == kWeldEquality});
    }
  }

  /// Sets names and units. @param of  which rows of the step they are, ascending
  void describe(const MujocoRowArrays& step, const std::vector<int>& of, BoundedRows& rows) const {
    std::map<std::string, int> seen;
    for (const int row : of) {
      const auto id = static_cast<std::size_t>(step.id[row]);
      const bool equal = row < step.ne, limit = row >= step.ne + step.nf;
      const bool of_tendon = step.type[row] == kFrictionOfTendon || step.type[row] == kLimitOfTendon;
      const Object& object = equal ? equalities_[id] : of_tendon ? tendons_[id] : limit ? joints_[id] : dofs_[id];
      int place = 0;  // in its constraint
      while (row > place && step.id[row - place - 1] == step.id[row]) ++place;
      const std::string name =
          object.kind + (equal ? " equality " : limit ? " limit " : " friction ") + object.name;
      const int count = equal ? place + 1 : ++seen[name];  // others of its constraint may be left out
      rows.names.push_back(count == 1 ? name : name + " #" + std::to_string(count));
      rows.is_angle.push_back((equal && object.is_weld ? place >= 3 : object.is_angle) ? 1 : 0);
    }
  }

 private:
  // Of MuJoCo's mjtJoint, mjtWrap, mjtEq and mjtConstraint, which are the same in 2.2.2 and 4.0.
  static constexpr int kFree = 0, kBall = 1, kHinge = 3, kWrapsJoint = 1;
  static constexpr int kWeldEquality = 1, kJointEquality = 2, kTendonEquality = 3;
  static constexpr int kFrictionOfTendon = 2, kLimitOfTendon = 4;

  struct Object {
    std::string kind, name;
    bool is_angle;
    bool is_weld = false;
  };
  std::vector<Object> dofs_, joints_, tendons_, equalities_;
};

struct MujocoBoundedRows {
  BoundedRows rows;         ///< over qvel
  Vector impulses;          ///< MuJoCo's
  Vector other;             ///< force on qvel of equality rows that are left out, without what the others take of it
  Index repeated_rows = 0;  ///< how many are left out
};

/// Equality rows that do not repeat others. MuJoCo lets a chain come apart a little: rows that say the same then differ
/// a little. Each constraint is measured in units of its longest row: one of small coefficients is no copy of another.
inline std::vector<int> distinct_equalities(const MujocoRowArrays& step) {
  if (step.ne == 0) return {};
  RowMatrix rows = step.J.topRows(step.ne);
  const Vector lengths = rows.rowwise().norm();
  std::map<int, double> longest;  // of each constraint
  for (int i = 0; i < step.ne; ++i) longest[step.id[i]] = std::max(longest[step.id[i]], lengths(i));
  // The rows of one that holds anyway are rounding.
  const double least = std::max(1e-8 * lengths.maxCoeff(), std::numeric_limits<double>::min());
  for (int i = 0; i < step.ne; ++i) rows.row(i) /= std::max(longest[step.id[i]], least);
  Eigen::ColPivHouseholderQR<Matrix> qr(rows.transpose());
  qr.setThreshold(1e-2);
  std::vector<int> kept(qr.colsPermutation().indices().data(), qr.colsPermutation().indices().data() + qr.rank());
  std::sort(kept.begin(), kept.end());
  return kept;
}

/// What hard and soft rows share. @param of  which rows of the step they are, ascending
inline MujocoBoundedRows bounded_rows(const MujocoRowArrays& step, const std::vector<int>& of,
                                      const MujocoRowNames& names, double h) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto count = static_cast<Index>(of.size());
  MujocoBoundedRows result{.rows = {.R = Matrix(step.J(of, Eigen::all).transpose())},
                           .impulses = h * Eigen::Map<const Vector>(step.force, step.count())(of),
                           .other = Vector::Zero(step.J.cols())};
  LcpBounds& bounds = result.rows.bounds;
  bounds = {Vector::Zero(count), Vector::Constant(count, kNone), std::vector<int>(of.size(), -1), Vector::Zero(count)};
  bounds.lower.head(count - step.nf - step.nl).setConstant(-kNone);
  bounds.upper.segment(count - step.nf - step.nl, step.nf) =
      h * Eigen::Map<const Vector>(step.frictionloss + step.ne, step.nf);
  bounds.lower.segment(count - step.nf - step.nl, step.nf) = -bounds.upper.segment(count - step.nf - step.nl, step.nf);
  names.describe(step, of, result.rows);
  return result;
}

/// Hard rows: equality constraints hold, limits leave their gap, and friction is dry.
inline MujocoBoundedRows hard_rows(const MujocoRowArrays& step, const MujocoRowNames& names, double h) {
  std::vector<int> of = distinct_equalities(step);
  const auto equalities = static_cast<Index>(of.size());
  for (int row = step.ne; row < step.count(); ++row) of.push_back(row);
  MujocoBoundedRows result = bounded_rows(step, of, names, h);
  Vector b = Vector::Zero(result.rows.size());
  b.tail(step.nl) = Eigen::Map<const Vector>(step.pos + step.ne + step.nf, step.nl).cwiseMax(0) / h;
  if (!b.isZero(0)) result.rows.b = b;
  result.repeated_rows = step.ne - equalities;
  if (result.repeated_rows == 0) return result;
  const Matrix kept = std::get<Matrix>(result.rows.R).leftCols(equalities);
  result.other = step.J.topRows(step.ne).transpose() * Eigen::Map<const Vector>(step.force, step.ne) -
                 kept * result.impulses.head(equalities) / h;
  const Vector taken = kept.colPivHouseholderQr().solve(result.other);
  result.impulses.head(equalities) += h * taken;
  result.other -= kept * taken;
  return result;
}

/// Rows as MuJoCo itself has them: J a - a_ref + R f is zero within the bounds of the force f. Times h, with
/// a = (v+ - v) / h. @param target  J v + h a_ref of the step's rows
inline MujocoBoundedRows soft_rows(const MujocoRowArrays& step, const MujocoRowNames& names, const Vector& target,
                                   double h) {
  std::vector<int> all(static_cast<std::size_t>(step.count()));
  std::iota(all.begin(), all.end(), 0);
  MujocoBoundedRows result = bounded_rows(step, all, names, h);
  result.rows.b = -target.head(step.count());
  result.rows.compliance = Eigen::Map<const Vector>(step.R, step.count());
  return result;
}

}  // namespace lcpbench::capture
