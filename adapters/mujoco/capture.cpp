#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "adapters/capture/engine.h"
#include "adapters/mujoco/bounded_rows.h"
#include "adapters/mujoco/coordinates.h"
#include "adapters/mujoco/model_text.h"
#include "core/error.h"
#include "core/timed_solve.h"

namespace lcpbench::capture {
namespace {

using Eigen::Vector3d;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Vector3d vector(const mjtNum* values) { return Eigen::Map<const Vector3d>(values); }

[[noreturn]] void fail(const char* message) {
  std::fprintf(stderr, "MuJoCo: %s\n", message);
  std::exit(1);
}

void warn(const char* message) { std::fprintf(stderr, "MuJoCo: %s\n", message); }

struct Free {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using Model = std::unique_ptr<mjModel, Free>;

Model read_model(const std::string& file, const mjVFS* memory, const std::string& name) {
  char error[500] = "";
  Model model(mj_loadXML(file.c_str(), memory, error, sizeof error));
  if (model == nullptr) {
    for (char* each = error; *each != '\0'; ++each) *each = std::iscntrl(static_cast<unsigned char>(*each)) ? ' ' : *each;
    throw InputError("model '" + name + "': MuJoCo " + mj_versionString() + " does not read it: " + error);
  }
  return model;
}

Model model_of(const Scene& scene, const std::string& file) {
  if (!file.empty()) return read_model(file, nullptr, file);
  if (!scene.model.empty()) {
    const std::filesystem::path path = std::filesystem::path(LCPBENCH_MUJOCO_MODELS) / scene.model;
    if (!std::filesystem::exists(path)) {
      throw InputError("scene '" + scene.name + "' needs MuJoCo's model " + scene.model +
                       ": install libmujoco-samples, or hand in a file by --model");
    }
    return read_model(path.string(), nullptr, path.string());
  }
  const std::string text = model_text(scene);
  const auto memory = std::make_unique<mjVFS>();
  mj_defaultVFS(memory.get());
  const char* name = "scene.xml";
  mj_makeEmptyFileVFS(memory.get(), name, static_cast<int>(text.size()));
  text.copy(static_cast<char*>(memory->filedata[mj_findFileVFS(memory.get(), name)]), text.size());
  Model model = read_model(name, memory.get(), scene.name);
  mj_deleteVFS(memory.get());
  return model;
}

/// Unit vectors that are spread evenly, as lcpbench/mujoco.py has them.
Eigen::Matrix3Xd sphere() {
  constexpr int kCount = 64;
  const double turn = M_PI * (3 - std::sqrt(5.0));
  Eigen::Matrix3Xd points(3, kCount);
  for (int i = 0; i < kCount; ++i) {
    const double z = 1 - (2 * i + 1.0) / kCount, r = std::sqrt(1 - z * z);
    points.col(i) << r * std::cos(turn * i), r * std::sin(turn * i), z;
  }
  return points;
}

/// Of many points those that lie farthest in the directions of sphere(), in units of the box around them.
Eigen::Matrix3Xd farthest(const Eigen::Matrix3Xd& points) {
  Eigen::Matrix3Xd directions = sphere();
  if (points.cols() <= directions.cols()) return points;
  const Vector3d extent = points.rowwise().maxCoeff() - points.rowwise().minCoeff();
  directions = extent.cwiseMax(1e-9 * extent.maxCoeff()).cwiseInverse().asDiagonal() * directions;
  std::set<Eigen::Index> found;
  for (const auto& direction : directions.colwise()) {
    Eigen::Index index = 0;
    (direction.transpose() * points).maxCoeff(&index);
    found.insert(index);
  }
  Eigen::Matrix3Xd result(3, std::max<std::size_t>(4, found.size()));  // of flat ones some stand twice
  auto next = found.begin();
  for (auto column : result.colwise()) {
    if (next == found.end()) next = found.begin();
    column = points.col(*next++);
  }
  return result;
}

/// The convex hull of these corners, with four digits: files stay small.
Drawn hull(const Eigen::Matrix3Xd& corners) {
  Drawn drawn{.type = "hull", .size = {}};
  for (const double each : corners.reshaped()) {
    drawn.size.push_back(std::strtod(fmt::format("{:.4g}", each).c_str(), nullptr));
  }
  return drawn;
}

MujocoRowNames row_names(const mjModel& model) {
  return MujocoRowNames({.njnt = model.njnt,
                         .nv = model.nv,
                         .ntendon = model.ntendon,
                         .neq = model.neq,
                         .names = model.names,
                         .name_jntadr = model.name_jntadr,
                         .name_tendonadr = model.name_tendonadr,
                         .name_eqadr = model.name_eqadr,
                         .jnt_type = model.jnt_type,
                         .jnt_dofadr = model.jnt_dofadr,
                         .dof_jntid = model.dof_jntid,
                         .tendon_adr = model.tendon_adr,
                         .tendon_num = model.tendon_num,
                         .wrap_type = model.wrap_type,
                         .wrap_objid = model.wrap_objid,
                         .eq_type = model.eq_type,
                         .eq_obj1id = model.eq_obj1id});
}

/// Runs a scene, or a model file of MuJoCo's, and captures each step as a contact problem, in SI units. Ordinarily
/// contacts and limits are hard and equality constraints hold exactly, so that MuJoCo's own velocity solves another,
/// softer problem. With Scene::soft it is the convex problem that MuJoCo solves. The integrator is Euler's. What else
/// differs is in Snapshot::notes, in the words of lcpbench/mujoco.py.
class MujocoEngine final : public Engine {
 public:
  MujocoEngine(const Scene& scene, const std::string& file) : Engine(scene, "MuJoCo", mj_versionString()) {
    mju_user_error = fail;
    mju_user_warning = warn;
    mjcb_time = [] { return thread_cpu_clock_s(); };
    model_ = model_of(scene, file);
    model_->opt.jacobian = mjJAC_DENSE;
    const char* const integrators[] = {"", "RK4", "implicit"};
    integrator_ = integrators[std::clamp(model_->opt.integrator, 0, 2)];
    model_->opt.integrator = mjINT_EULER;
    data_.reset(mj_makeData(model_.get()));
    row_names_ = row_names(*model_);
    if (scene.elliptic) model_->opt.cone = mjCONE_ELLIPTIC;
    choose_solver();
    moving_of_.assign(static_cast<std::size_t>(model_->nbody), kWorld);
    if (scene_.bodies.empty())
      place_model();
    else
      name_bodies();
    if (!file.empty()) {
      if (model_->nkey > 0) mj_resetDataKeyframe(model_.get(), data_.get(), 0);
      if (has_only_free_bodies()) find_moving();
      name_marks();
    }
    free_bodies_ = !moving_.empty() && !scene.articulated();
  }

  double step_length() const override { return model_->opt.timestep; }
  Vector3d gravity() const override { return vector(model_->opt.gravity); }

  std::vector<Drawn> drawn() const override {
    std::vector<Drawn> result;
    std::set<int> solid;  // bodies with geometries that can touch others, which alone are drawn then
    const auto touches = [&](int geom) { return model_->geom_contype[geom] != 0 || model_->geom_conaffinity[geom] != 0; };
    for (int geom = 0; geom < model_->ngeom; ++geom) {
      if (touches(geom)) solid.insert(model_->geom_bodyid[geom]);
    }
    for (int geom = 0; geom < model_->ngeom; ++geom) {
      if (!touches(geom) && solid.contains(model_->geom_bodyid[geom])) {
        result.emplace_back();
        continue;
      }
      const mjtNum* size = model_->geom_size + 3 * geom;
      switch (model_->geom_type[geom]) {
        case mjGEOM_PLANE: result.push_back({"plane", {0, 0, 1, 0}}); break;
        case mjGEOM_BOX: result.push_back({"box", {size[0], size[1], size[2]}}); break;
        case mjGEOM_CAPSULE: result.push_back({"capsule", {size[0], size[1]}}); break;
        case mjGEOM_CYLINDER: result.push_back({"cylinder", {size[0], size[1]}}); break;
        case mjGEOM_ELLIPSOID: result.push_back(hull(vector(size).asDiagonal() * sphere())); break;
        case mjGEOM_MESH: result.push_back(hull(farthest(mesh_of(geom)))); break;
        case mjGEOM_HFIELD: result.push_back(hull(box_around_field(geom))); break;
        default: result.push_back({"sphere", {size[0]}});
      }
    }
    return result;
  }

  void step(long index, Snapshot& snapshot, const VelocitySolver& loop) override {
    if (loop && model_->na > 0) {
      throw InputError("the model's actuators have activations, which MuJoCo's own solver moves on: use --loop engine");
    }
    snapshot = {};
    if (loop) keep_contacts_within_margin();
    apply_forces(index);
    const double time_before = solver_time_s();
    mj_forward(model_.get(), data_.get());
    if (!loop) snapshot.solve_s = solver_time_s() - time_before;
    note(snapshot);
    if (!scene_.soft.empty()) return step_softly(snapshot);
    const Coordinates coordinates(*model_, *data_);
    const MujocoBoundedRows bounded = hard_rows(row_arrays(), *row_names_, step_length());
    if (bounded.repeated_rows > 0) {
      snapshot.notes.push_back(
          fmt::format("rows of equality constraints that repeat others, left out: {}", bounded.repeated_rows));
    }
    const Eigen::VectorXd forces = numbers(data_->qfrc_smooth, model_->nv) + found_friction() + bounded.other;
    const Eigen::VectorXd velocity =
        numbers(data_->qvel, model_->nv) + step_length() * coordinates.accelerations(forces);
    look_at_poses(snapshot);
    for (const mjtNum* place : places_) snapshot.marks.push_back(vector(place));
    if (free_bodies_) {
      look_at_bodies(velocity, snapshot);
      look_at_contacts(nullptr, static_cast<bool>(loop), snapshot);
    } else {
      snapshot.blocks = coordinates.states(velocity);
      look_at_contacts(&coordinates, static_cast<bool>(loop), snapshot);
      keep(bounded, snapshot);
    }
    if (loop) {
      const Eigen::VectorXd after = loop(snapshot);
      const Eigen::VectorXd moving = moving_velocity(after, snapshot, step_length());
      if (free_bodies_) return move_on(velocities_of_bodies(after), velocities_of_bodies(moving));
      return move_on(after, moving);
    }
    mj_Euler(model_.get(), data_.get());
    if (free_bodies_) {
      keep_body_velocities(snapshot);
    } else {
      snapshot.velocity_after = numbers(data_->qvel, model_->nv);
    }
    snapshot.has_impulses = true;
  }

 private:
  Eigen::Matrix3Xd mesh_of(int geom) const {
    const int mesh = model_->geom_dataid[geom];
    return Eigen::Map<const Eigen::Matrix3Xf>(model_->mesh_vert + 3 * model_->mesh_vertadr[mesh], 3,
                                              model_->mesh_vertnum[mesh])
        .cast<double>();
  }

  Eigen::Matrix3Xd box_around_field(int geom) const {
    const mjtNum* const size = model_->hfield_size + 4 * model_->geom_dataid[geom];  // half lengths, top, depth
    Eigen::Matrix3Xd corners(3, 8);
    for (int i = 0; i < 8; ++i) {
      corners.col(i) << ((i & 1) != 0 ? size[0] : -size[0]), ((i & 2) != 0 ? size[1] : -size[1]),
          ((i & 4) != 0 ? size[2] : -size[3]);
    }
    return corners;
  }

  MujocoRowArrays row_arrays() const {
    const auto limits = [](int type) { return type == mjCNSTR_LIMIT_JOINT || type == mjCNSTR_LIMIT_TENDON; };
    return {.J = Eigen::Map<const RowMatrix>(data_->efc_J, data_->nefc, model_->nv),
            .ne = data_->ne,
            .nf = data_->nf,
            .nl = static_cast<int>(std::count_if(data_->efc_type, data_->efc_type + data_->nefc, limits)),
            .type = data_->efc_type,
            .id = data_->efc_id,
            .force = data_->efc_force,
            .pos = data_->efc_pos,
            .frictionloss = data_->efc_frictionloss,
            .R = data_->efc_R};
  }

  static void keep(const MujocoBoundedRows& found, Snapshot& snapshot) {
    const BoundedRows& rows = found.rows;
    const auto& R = std::get<Matrix>(rows.R);
    for (Index i = 0; i < rows.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      RowState row{.coordinates = {},
                   .direction = {},
                   .lower = rows.bounds.lower(i),
                   .upper = rows.bounds.upper(i),
                   .offset = rows.offset(i),
                   .compliance = rows.yields(i),
                   .is_angle = rows.is_angle[at] != 0,
                   .name = rows.names[at],
                   .impulse = found.impulses(i)};
      for (int k = 0; k < R.rows(); ++k) {
        if (R(k, i) != 0) row.coordinates.push_back(k);
      }
      row.direction = R.col(i)(row.coordinates);
      snapshot.rows.push_back(std::move(row));
    }
  }

  /// Of hard contacts the friction that is no part of the problem, as MuJoCo found it: torsional and rolling friction.
  Eigen::VectorXd found_friction() const {
    const Eigen::Map<const RowMatrix> J(data_->efc_J, data_->nefc, model_->nv);
    const mjtNum* const force = data_->efc_force;
    Eigen::VectorXd found = Eigen::VectorXd::Zero(model_->nv);
    for (int i = 0; i < data_->ncon; ++i) {
      const mjContact& contact = data_->contact[i];
      if (contact.efc_address < 0) continue;
      for (int k = 2; k + 1 < contact.dim; ++k) {
        if (model_->opt.cone == mjCONE_ELLIPTIC) {
          const int row = contact.efc_address + 1 + k;
          found += force[row] * J.row(row).transpose();
        } else {  // edges n + mu_k t_k and n - mu_k t_k
          const int row = contact.efc_address + 2 * k;
          found += (force[row] - force[row + 1]) / 2 * (J.row(row) - J.row(row + 1)).transpose();
        }
      }
    }
    return found;
  }

  /// The convex problem of a step that MuJoCo itself solves [Todorov 2014]: each edge of a friction pyramid is a
  /// frictionless contact with the compliance R of its row. Its force f asks that J a - a_ref + R f >= 0. With
  /// a = (v+ - v) / h, times h, this is J v+ + b + R (h f) >= 0 with the offset b = -(J v + h a_ref). Equality constraints,
  /// friction loss and limits are bounded rows alike. An elliptic cone is one contact with friction in the convex model:
  /// the same expression of its normal and its two tangential rows is in the dual cone. Its torsional and rolling friction
  /// acts as the forces that MuJoCo found; a pyramid has edges for these frictions.
  void step_softly(Snapshot& snapshot) {
    const double h = step_length();
    const int nv = model_->nv;
    const Coordinates coordinates(*model_, *data_, true);
    const Eigen::VectorXd before = numbers(data_->qvel, nv);
    const Eigen::Map<const RowMatrix> J(data_->efc_J, data_->nefc, nv);
    const Eigen::VectorXd target = J * before + h * numbers(data_->efc_aref, data_->nefc);
    Eigen::VectorXd momentum(nv);
    mj_mulM(model_.get(), data_.get(), momentum.data(), before.data());
    momentum += h * numbers(data_->qfrc_smooth, nv);
    const MujocoRowArrays arrays = row_arrays();
    for (int row = arrays.count(); row < data_->nefc; ++row) {
      if (is_given_force(row)) momentum += J.row(row).transpose() * (h * data_->efc_force[row]);
    }
    snapshot.blocks = coordinates.states(coordinates.accelerations(momentum));
    look_at_poses(snapshot);
    keep(soft_rows(arrays, *row_names_, target, h), snapshot);
    for (int row = arrays.count(); row < data_->nefc; ++row) {
      if (is_given_force(row)) continue;
      const int type = data_->efc_type[row], id = data_->efc_id[row];
      const int count = type == mjCNSTR_CONTACT_ELLIPTIC ? std::min(data_->contact[id].dim, 3) : 1;
      ContactState edge;
      edge.edges = 0;
      edge.gap = data_->efc_pos[row];
      edge.offset = -target(row);
      edge.compliance_n = data_->efc_R[row];
      tell_pair(data_->contact[id], edge);
      edge.impulse(0) = h * data_->efc_force[row];
      RowMatrix rows = J.middleRows(row, count);
      if (count > 1) {
        rows.row(2) *= add_elliptic_friction(row, J, target, edge);
        row += 2;
      }
      edge.rows = coordinates.rows(rows);
      snapshot.contacts.push_back(std::move(edge));
    }
    snapshot.velocity_after = before + h * numbers(data_->qacc, nv);
    snapshot.has_impulses = true;
    mj_Euler(model_.get(), data_.get());
  }

  void note(Snapshot& snapshot) const {
    const auto add = [&](const std::string& what, long count) {
      if (count > 0) snapshot.notes.push_back(fmt::format("{}: {}", what, count));
    };
    const auto contacts = [&](auto&& is) {
      return std::count_if(data_->contact, data_->contact + data_->ncon,
                           [&](const mjContact& each) { return each.efc_address >= 0 && is(each); });
    };
    const bool soft = !scene_.soft.empty();
    add("steps of the integrator " + integrator_ + ", which Euler's rule took", integrator_.empty() ? 0 : 1);
    if (!soft || model_->opt.cone == mjCONE_ELLIPTIC) {  // a pyramid has edges for them
      add("contacts with torsional friction (condim 4 or 6), as the force that MuJoCo found",
          contacts([](const mjContact& each) { return each.dim > 3; }));
      add("contacts with rolling friction (condim 6), as the force that MuJoCo found",
          contacts([](const mjContact& each) { return each.dim > 4; }));
      add("contacts with two coefficients of sliding friction: the second tangent is scaled",
          contacts([](const mjContact& each) { return each.dim > 1 && each.friction[0] != each.friction[1]; }));
    }
    add("contacts that MuJoCo found and did not solve, left out",
        std::count_if(data_->contact, data_->contact + data_->ncon,
                      [](const mjContact& each) { return each.efc_address < 0 && each.exclude < 3; }));  // 3: a tie
  }

  /// Of a soft problem: torsional and rolling friction of elliptic cones.
  bool is_given_force(int row) const {
    return data_->efc_type[row] == mjCNSTR_CONTACT_ELLIPTIC && row - data_->contact[data_->efc_id[row]].efc_address > 2;
  }

  /// The problem has one coefficient of friction mu along both tangents: the second one is scaled by what is returned.
  /// Torsional and rolling friction leave |(f_1, f_2)| <= mu sqrt(1 - share) f_0 of the cone |(f_i / mu_i)| <= f_0. A
  /// contact that slides in it has u_0 = |(mu_i u_i)| in the whole cone, and (1 - share) of that in what is left.
  double add_elliptic_friction(int row, const Eigen::Map<const RowMatrix>& J, const Eigen::VectorXd& target,
                               ContactState& to) const {
    const mjContact& found = data_->contact[data_->efc_id[row]];
    const mjtNum* const force = data_->efc_force + row;
    const double h = step_length(), ratio = found.friction[1] / found.friction[0];
    double taken = 0, slip = 0;
    for (int k = 1; k < found.dim; ++k) {
      const double mu = found.friction[k - 1];
      const double u = J.row(row + k).dot(numbers(data_->qacc, model_->nv)) - data_->efc_aref[row + k] +
                       data_->efc_R[row + k] * force[k];
      if (k > 2) taken += std::pow(force[k] / mu, 2);
      slip += std::pow(mu * u, 2);
    }
    const double share = std::min(1.0, taken / std::max(force[0] * force[0], std::numeric_limits<double>::min()));
    to.edges = 4;
    to.mu = found.friction[0] * std::sqrt(1 - share);
    to.offset -= h * share * std::sqrt(slip);
    to.compliance_t = data_->efc_R[row + 1];
    to.offset_t = {-target(row + 1), -ratio * target(row + 2)};
    to.impulse.tail<2>() = h * Eigen::Vector2d(force[1], force[2] / ratio);
    to.point = vector(found.pos);
    to.normal = vector(found.frame);
    to.tangent = vector(found.frame + 3);
    return ratio;
  }

  void choose_solver() {
    mjOption& option = model_->opt;
    if (!scene_.soft.empty() && option.noslip_iterations > 0) {
      throw InputError("--soft: the model's noslip_iterations change the answer of MuJoCo's solver to one of no convex "
                       "problem; set them to 0");
    }
    if (scene_.soft == "pgs") option.solver = mjSOL_PGS;
    if (scene_.soft == "cg") option.solver = mjSOL_CG;
    if (scene_.soft == "newton" || scene_.soft == "exact") option.solver = mjSOL_NEWTON;
    if (scene_.sweeps > 0) option.iterations = scene_.sweeps;
    if (scene_.soft == "exact") option.tolerance = 0;
  }

  /// Thread CPU time of MuJoCo's solver in all steps so far [s], with that of forming J M^-1 J', which only PGS needs.
  /// Forming the rows J is not counted: other solvers are given theirs, too.
  double solver_time_s() const {
    return data_->timer[mjTIMER_CONSTRAINT].duration + data_->timer[mjTIMER_POS_PROJECT].duration;
  }

  static Eigen::VectorXd numbers(const mjtNum* values, int count) {
    return Eigen::Map<const Eigen::VectorXd>(values, count);
  }
  /// The rotation from a body's own axes to the world's.
  Eigen::Matrix3d axes(int id) const { return Eigen::Map<const RowMatrix3>(data_->xmat + 9 * id); }

  void look_at_poses(Snapshot& snapshot) const {
    for (int geom = 0; geom < model_->ngeom; ++geom) {
      const Eigen::Map<const RowMatrix3> turn(data_->geom_xmat + 9 * geom);
      snapshot.poses.push_back({vector(data_->geom_xpos + 3 * geom), Eigen::Quaterniond(turn)});
    }
  }

  /// A body with a free joint, and what is welded to it.
  struct Moving {
    int id = 0;            ///< MuJoCo's
    Eigen::Index dof = 0;  ///< the first of six
    double mass = 0;
    Vector3d centre = Vector3d::Zero();                       ///< of mass, in the body's axes
    Eigen::Matrix3d principal = Eigen::Matrix3d::Identity();  ///< the principal axes, in the body's
    Vector3d moments = Vector3d::Zero();
  };

  /// Whether nothing but contacts acts on a body beside forces.
  bool has_only_free_bodies() const {
    const auto none = [](const mjtNum* values, int count) {
      return std::all_of(values, values + count, [](mjtNum each) { return each == 0; });
    };
    return model_->neq == 0 && model_->ntendon == 0 &&
           std::all_of(model_->jnt_type, model_->jnt_type + model_->njnt,
                       [](int type) { return type == mjJNT_FREE; }) &&
           none(model_->dof_damping, model_->nv) && none(model_->dof_armature, model_->nv) &&
           none(model_->dof_frictionloss, model_->nv) && has_one_friction_along_both_tangents();
  }

  /// A contact of free bodies has one coefficient; in rows the second tangent is scaled.
  bool has_one_friction_along_both_tangents() const {
    for (int pair = 0; pair < model_->npair; ++pair) {
      if (model_->pair_friction[5 * pair] != model_->pair_friction[5 * pair + 1]) return false;
    }
    return true;
  }

  /// Of a model: the bodies as rigid bodies of their own. @pre has_only_free_bodies()
  void find_moving() {
    mj_kinematics(model_.get(), data_.get());
    for (int joint = 0; joint < model_->njnt; ++joint) {
      Moving body{.id = model_->jnt_bodyid[joint], .dof = model_->jnt_dofadr[joint]};
      const Eigen::Matrix3d R = axes(body.id);
      const auto each_part = [&](auto&& visit) {
        for (int part = body.id; part < model_->nbody; ++part) {
          if (model_->body_weldid[part] != body.id) continue;
          visit(part, Vector3d(R.transpose() * (vector(data_->xipos + 3 * part) - vector(data_->xpos + 3 * body.id))));
        }
      };
      each_part([&](int part, const Vector3d& at) {
        moving_of_[static_cast<std::size_t>(part)] = static_cast<int>(moving_.size());
        body.mass += model_->body_mass[part];
        body.centre += model_->body_mass[part] * at;
      });
      body.centre /= body.mass;
      Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
      each_part([&](int part, const Vector3d& at) {
        const Eigen::Matrix3d turn = R.transpose() * Eigen::Map<const RowMatrix3>(data_->ximat + 9 * part);
        const Vector3d arm = at - body.centre;
        inertia += turn * vector(model_->body_inertia + 3 * part).asDiagonal() * turn.transpose() +
                   model_->body_mass[part] * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
      });
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
      body.principal = solver.eigenvectors();
      body.moments = solver.eigenvalues();
      moving_.push_back(body);
    }
  }

  /// Finds Scene::marks. @throws InputError for a name that the model does not have
  void name_marks() {
    if (scene_.marks.empty()) {  // then the free bodies
      for (int joint = 0; joint < model_->njnt; ++joint) {
        if (model_->jnt_type[joint] != mjJNT_FREE) continue;
        scene_.stands.push_back(static_cast<int>(places_.size()));
        places_.push_back(data_->xpos + 3 * model_->jnt_bodyid[joint]);
      }
      return;
    }
    const std::pair<int, const mjtNum*> kinds[] = {
        {mjOBJ_BODY, data_->xpos}, {mjOBJ_GEOM, data_->geom_xpos}, {mjOBJ_SITE, data_->site_xpos}};
    for (const std::string& name : scene_.marks) {
      const auto known = std::ranges::find_if(
          kinds, [&](const auto& kind) { return mj_name2id(model_.get(), kind.first, name.c_str()) >= 0; });
      if (known == std::end(kinds)) throw InputError("the model has no body, geometry or site '" + name + "'");
      places_.push_back(known->second + 3 * mj_name2id(model_.get(), known->first, name.c_str()));
    }
  }

  void name_bodies() {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const Body& body = scene_.bodies[i];
      ids_.push_back(mj_name2id(model_.get(), mjOBJ_BODY, fmt::format("b{}", i).c_str()));
      if (body.mass == 0 || body.joint) continue;
      moving_of_[static_cast<std::size_t>(ids_.back())] = static_cast<int>(moving_.size());
      moving_.push_back(
          {.id = ids_.back(), .dof = model_->body_dofadr[ids_.back()], .mass = body.mass, .moments = body.inertia});
      Eigen::Map<Eigen::Vector<double, 6>> velocity(data_->qvel + moving_.back().dof);
      velocity << body.linear_velocity, body.orientation.conjugate() * body.angular_velocity;
    }
  }

  /// The model's root and its joints' damping as the scene wants them.
  void place_model() {
    constexpr double kDampingShare = 0.05;  // s: the controller's damping per stiffness
    for (int dof = 0; dof < model_->nv; ++dof) {
      if (model_->jnt_type[model_->dof_jntid[dof]] != mjJNT_HINGE) continue;
      model_->dof_damping[dof] += kDampingShare * scene_.model_stiffness;
    }
    if (model_->njnt == 0 || model_->jnt_type[0] != mjJNT_FREE) return;
    data_->qpos[2] += scene_.model_height;
    const mjtNum turn[] = {std::cos(scene_.model_tilt / 2), 0, std::sin(scene_.model_tilt / 2), 0};
    mjtNum turned[4];
    mju_mulQuat(turned, turn, data_->qpos + 3);
    mju_copy4(data_->qpos + 3, turned);
  }

  void apply_forces(long index) {
    if (scene_.bodies.empty()) {
      hold_model(index);
      return;
    }
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const Body& body = scene_.bodies[i];
      // MuJoCo applies gravity, which force_on() has, by itself.
      Eigen::Map<Vector3d>(data_->xfrc_applied + 6 * ids_[i]) =
          force_on(body, index) + Vector3d(0, 0, kGravity * body.mass);
      if (!body.joint) continue;
      const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, fmt::format("j{}", i).c_str());
      const int dof = model_->jnt_dofadr[joint];
      data_->qfrc_applied[dof] = controller_torque(*body.joint, data_->qpos[model_->jnt_qposadr[joint]],
                                                   data_->qvel[dof], static_cast<double>(index) * step_length());
    }
  }

  void hold_model(long index) {
    for (int joint = 0; joint < model_->njnt; ++joint) {
      if (model_->jnt_type[joint] != mjJNT_HINGE) continue;
      const int dof = model_->jnt_dofadr[joint];
      const int position = model_->jnt_qposadr[joint];
      data_->qfrc_applied[dof] = scene_.model_stiffness * (model_->qpos0[position] - data_->qpos[position]);
    }
    const bool pushed = index >= scene_.model_push.first && index <= scene_.model_push.last;
    if (model_->nbody > 1) {
      Eigen::Map<Vector3d>(data_->xfrc_applied + 6) = pushed ? scene_.model_push.force : Vector3d(Vector3d::Zero());
    }
  }

  void look_at_bodies(const Eigen::VectorXd& velocity, Snapshot& snapshot) {
    const Eigen::Map<const Eigen::VectorXd> before(data_->qvel, model_->nv);
    for (const Moving& body : moving_) {
      const Eigen::Matrix3d R = axes(body.id);
      BodyState state;
      state.mass = body.mass;
      state.inertia = world_inertia(R * body.principal, body.moments);
      state.position = vector(data_->xpos + 3 * body.id) + R * body.centre;
      const Eigen::Vector<double, 6> now = velocity_of(body, velocity), was = velocity_of(body, before);
      state.linear_velocity = now.head<3>();
      state.angular_velocity = now.tail<3>();
      state.linear_change = now.head<3>() - was.head<3>();
      state.angular_change = now.tail<3>() - was.tail<3>();
      snapshot.bodies.push_back(state);
    }
  }

  /// Of the centre of mass, linear and angular in the axes of the world. MuJoCo has the linear velocity of the body's
  /// origin, and the angular one in the axes of the body. @param qvel  of all degrees of freedom
  Eigen::Vector<double, 6> velocity_of(const Moving& body, const Eigen::VectorXd& qvel) const {
    const Eigen::Matrix3d R = axes(body.id);
    Eigen::Vector<double, 6> result;
    result.tail<3>() = R * qvel.segment<3>(body.dof + 3);
    result.head<3>() = qvel.segment<3>(body.dof) + result.tail<3>().cross(R * body.centre);
    return result;
  }

  /// MuJoCo's qvel for a velocity of the problem, which has six entries for each moving body as velocity_of() has them.
  /// @pre bodies are free, and their axes() those of the problem
  Eigen::VectorXd velocities_of_bodies(const Eigen::VectorXd& velocity) const {
    Eigen::VectorXd result = Eigen::VectorXd::Zero(model_->nv);
    for (std::size_t k = 0; k < moving_.size(); ++k) {
      const Moving& body = moving_[k];
      const Eigen::Matrix3d R = axes(body.id);
      const auto at = static_cast<Eigen::Index>(6 * k);
      const Vector3d turning = velocity.segment<3>(at + 3);
      result.segment<3>(body.dof) = velocity.segment<3>(at) - turning.cross(R * body.centre);
      result.segment<3>(body.dof + 3) = R.transpose() * turning;
    }
    return result;
  }

  void move_on(const Eigen::VectorXd& velocity, const Eigen::VectorXd& moving) {
    Eigen::Map<Eigen::VectorXd>(data_->qvel, model_->nv) = velocity;
    mj_integratePos(model_.get(), data_->qpos, moving.data(), step_length());
    data_->time += step_length();
  }

  /// In the axes that the bodies had before the step, as the problem has them.
  void keep_body_velocities(Snapshot& snapshot) {
    snapshot.velocity_after.resize(static_cast<Eigen::Index>(6 * moving_.size()));
    for (std::size_t k = 0; k < moving_.size(); ++k) {
      snapshot.velocity_after.segment<6>(static_cast<Eigen::Index>(6 * k)) =
          velocity_of(moving_[k], numbers(data_->qvel, model_->nv));
    }
  }

  /// The 3 x nv matrix that takes qvel to the velocity of body_a relative to body_b at the contact point, along the
  /// normal and both tangents. Bodies by their numbers in MuJoCo.
  Eigen::MatrixXd directions(const mjContact& found, int body_a, int body_b) const {
    RowMatrix a(3, model_->nv);
    RowMatrix b(3, model_->nv);
    mj_jac(model_.get(), data_.get(), a.data(), nullptr, found.pos, body_a);
    mj_jac(model_.get(), data_.get(), b.data(), nullptr, found.pos, body_b);
    return Eigen::Map<const RowMatrix3>(found.frame) * (a - b);
  }

  /// What a contact keeps its name by. All edges of a pyramid have the same, and keep their order.
  void tell_pair(const mjContact& found, ContactState& contact) const {
    contact.pair = geometry_name(found.geom2) + " on " + geometry_name(found.geom1);
    if (found.geom1 < 0 || found.geom2 < 0) return;  // of a flex, which has no geometry
    const int a = model_->geom_bodyid[found.geom2];
    const int frame = model_->body_weldid[a] == 0 ? model_->geom_bodyid[found.geom1] : a;
    contact.local = axes(frame).transpose() * (vector(found.pos) - vector(data_->xpos + 3 * frame));
  }

  std::string name(int kind, int id) const {
    const char* const found = mj_id2name(model_.get(), kind, id);
    return found == nullptr ? "" : found;
  }

  /// As Python's capture names it: without a name that of its body, with its index where the body has others.
  std::string geometry_name(int geom) const {
    if (geom < 0) return "flex";
    if (std::string own = name(mjOBJ_GEOM, geom); !own.empty()) return own;
    const int body = model_->geom_bodyid[geom];
    const std::string of = body == 0 ? "" : name(mjOBJ_BODY, body);
    if (of.empty()) return fmt::format("geom {}", geom);
    return model_->body_geomnum[body] == 1 ? of : fmt::format("{} (geom {})", of, geom);
  }

  void keep_contacts_within_margin() {
    for (int geom = 0; geom < model_->ngeom; ++geom) {
      mjtNum& margin = model_->geom_margin[geom];
      margin = std::max(margin, kContactMargin + model_->geom_gap[geom]);
    }
  }

  void look_at_contacts(const Coordinates* coordinates, bool in_loop, Snapshot& snapshot) {
    for (int i = 0; i < data_->ncon; ++i) {
      const mjContact& found = data_->contact[i];
      if (found.efc_address < 0) continue;
      // The normal of MuJoCo points from the first geometry to the second.
      const int a = model_->geom_bodyid[found.geom2];
      const int b = model_->geom_bodyid[found.geom1];
      ContactState contact;
      contact.point = vector(found.pos);
      contact.normal = vector(found.frame);
      contact.tangent = vector(found.frame + 3);
      contact.mu = found.friction[0];
      contact.edges = found.dim == 1 ? 0 : 4;
      contact.gap = found.dist;
      Eigen::MatrixXd rows = directions(found, a, b);
      const double approach = rows.row(0).dot(numbers(data_->qvel, model_->nv));
      if (in_loop && waits_to_bounce(scene_, contact.gap, approach)) continue;
      contact.offset = contact_offset(contact.gap, step_length(), scene_.restitution, approach);
      tell_pair(found, contact);
      mjtNum force[6];
      mj_contactForce(model_.get(), data_.get(), i, force);
      contact.impulse = step_length() * vector(force);
      if (coordinates != nullptr) {
        if (contact.edges > 0) {  // one coefficient along both tangents: the second one is scaled
          const double ratio = found.friction[1] / found.friction[0];
          rows.row(2) *= ratio;
          contact.impulse(2) /= ratio;
        }
        contact.rows = coordinates->rows(rows);
      } else {
        contact.body_a = moving_of_[static_cast<std::size_t>(a)];
        contact.body_b = moving_of_[static_cast<std::size_t>(b)];
      }
      snapshot.contacts.push_back(std::move(contact));
    }
  }

  Model model_;
  std::unique_ptr<mjData, Free> data_;
  std::optional<MujocoRowNames> row_names_;
  bool free_bodies_ = false;
  std::string integrator_;             ///< the model's, where it is not Euler's
  std::vector<int> ids_;               ///< MuJoCo's, of the scene's bodies
  std::vector<Moving> moving_;         ///< bodies that move freely; of a model only where it has no others
  std::vector<const mjtNum*> places_;  ///< of Scene::marks, in data_
  std::vector<int> moving_of_;         ///< of MuJoCo's bodies: their index in moving_
};

}  // namespace

std::unique_ptr<Engine> make_engine(const Scene& scene, const std::string& model) {
  if (scene.driven()) {
    throw InputError("scene '" + scene.name +
                     "' has a motor in the engine's solve, which is captured from ODE, Bullet and DART, not from MuJoCo");
  }
  return std::make_unique<MujocoEngine>(scene, model);
}

}  // namespace lcpbench::capture
