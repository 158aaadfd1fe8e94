#include "adapters/capture/engine.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <utility>

#include "core/error.h"

namespace lcpbench::capture {
namespace {

bool bounces(double restitution, double approach) {
  constexpr double kThreshold = 0.2;  // m/s: slower contacts come to rest
  return restitution > 0 && approach < -kThreshold;
}

/// Of bodies of 6 coordinates each.
std::vector<int> coordinates_of(std::initializer_list<int> bodies) {
  std::vector<int> result;
  for (const int body : bodies) {
    for (int k = 0; k < 6 && body != kWorld; ++k) result.push_back(6 * body + k);
  }
  return result;
}

}  // namespace

void BodyState::accelerate(const Eigen::Vector3d& force, const Eigen::Vector3d& torque, double h) {
  linear_change = h / mass * force;
  angular_change = h * inertia.llt().solve(torque);
  linear_velocity += linear_change;
  angular_velocity += angular_change;
}

std::vector<Drawn> Engine::drawn() const {
  std::vector<Drawn> result;
  for (const Body& body : scene_.bodies) {
    for (const Part& part : body.parts) {
      const Eigen::Vector3d& s = part.size;
      if (part.kind == Part::Kind::kSphere)
        result.push_back({"sphere", {s.x()}});
      else
        result.push_back({"box", {s.x(), s.y(), s.z()}});
    }
  }
  return result;
}

Eigen::VectorXd moving_velocity(const Eigen::VectorXd& velocity, const Snapshot& snapshot, double h) {
  if (snapshot.correction.size() == 0) return velocity;
  return velocity + snapshot.correction / h;
}

Eigen::Matrix3d world_inertia(const Eigen::Matrix3d& R, const Eigen::Vector3d& moments) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += R(i, k) * moments(k) * R(j, k);
      result(i, j) = result(j, i) = sum;
    }
  }
  return result;
}

Eigen::Vector3d force_on(const Body& body, long step) {
  Eigen::Vector3d force(0, 0, -kGravity * body.mass);
  if (step >= body.push.first && step <= body.push.last) force += body.push.force;
  return force;
}

Eigen::Vector3d gyroscopic_torque(const Eigen::Matrix3d& inertia, const Eigen::Vector3d& angular_velocity, double h) {
  const auto cross = [](const Eigen::Vector3d& v) {
    Eigen::Matrix3d matrix;
    matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return matrix;
  };
  const Eigen::Vector3d momentum = inertia * angular_velocity;
  const Eigen::Vector3d rest = h * angular_velocity.cross(momentum);
  const Eigen::Matrix3d slope = inertia + h * (cross(angular_velocity) * inertia - cross(momentum));
  return inertia * slope.inverse() * -rest / h;
}

double controller_torque(const Joint& hinge, double angle, double velocity, double time) {
  const Target& target = hinge.target;
  const double wanted =
      target.centre + target.amplitude * std::sin(2 * std::numbers::pi * target.frequency * time + target.phase);
  const double torque = hinge.stiffness * (wanted - angle) - hinge.damping * velocity;
  return std::clamp(torque, -hinge.max_torque, hinge.max_torque);
}

Eigen::Vector3d tangent_to(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d axis = std::abs(normal.x()) < 0.7 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  return (axis - axis.dot(normal) * normal).normalized();
}

double contact_offset(double gap, double h, double restitution, double approach) {
  constexpr double kClosed = 1e-9;  // m: the gaps that rounding and a solver's last digits leave are below this
  if (gap > kClosed) return gap / h;
  return bounces(restitution, approach) ? restitution * approach : 0;
}

bool waits_to_bounce(const Scene& scene, double gap, double approach) {
  return gap > 0 && bounces(scene.restitution, approach);
}

ContactState touch(const Scene& scene, std::size_t a, std::size_t b, const Eigen::Vector3d& point,
                   const Eigen::Vector3d& normal, double gap, const Eigen::Vector3d& approach) {
  ContactState contact;
  contact.point = point;
  contact.normal = normal.normalized();
  contact.tangent = tangent_to(contact.normal);
  contact.mu = scene.mu;
  contact.gap = gap;
  contact.offset = contact_offset(gap, scene.step, scene.restitution, approach.dot(contact.normal));
  contact.pair = std::to_string(a) + "-" + std::to_string(b);
  return contact;
}

Eigen::Vector3d in_axes_of(const ContactState& contact, const Eigen::Vector3d& impulse) {
  return {impulse.dot(contact.normal), impulse.dot(contact.tangent),
          impulse.dot(contact.normal.cross(contact.tangent))};
}

void set_square_friction(const Eigen::Vector3d& first, ContactState& contact) {
  contact.tangent = (first + contact.normal.cross(first)).normalized();
  contact.mu *= std::numbers::sqrt2;
}

BlockState block_of(const BodyState& state) {
  BlockState block{Eigen::MatrixXd::Zero(6, 6), Eigen::VectorXd(6)};
  block.mass.topLeftCorner<3, 3>().diagonal().setConstant(state.mass);
  block.mass.bottomRightCorner<3, 3>() = state.inertia;
  block.velocity << state.linear_velocity, state.angular_velocity;
  return block;
}

RowState row_between(int a, int b, const Eigen::Vector3d& linear, const Eigen::Vector3d& angular_a,
                     const Eigen::Vector3d& angular_b, std::string name) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  RowState row{.coordinates = coordinates_of({a, b}), .direction = {}, .lower = -kNone, .upper = kNone};
  row.direction.resize(static_cast<Eigen::Index>(row.coordinates.size()));
  row.direction.head<6>() << linear, angular_a;
  if (b != kWorld) row.direction.tail<6>() << -linear, -angular_b;
  row.is_angle = linear.isZero(0);
  row.name = std::move(name);
  return row;
}

void set_impulses(const Eigen::Vector3d& force, const Eigen::Vector3d& torque, std::span<RowState> rows) {
  Eigen::MatrixXd J(6, static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) J.col(static_cast<Eigen::Index>(i)) = rows[i].direction.head<6>();
  const Eigen::VectorXd impulses =
      J.colPivHouseholderQr().solve((Eigen::VectorXd(6) << force, torque).finished());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].impulse = impulses(static_cast<Eigen::Index>(i));
}

void make_blocks(Snapshot& snapshot) {
  for (ContactState& contact : snapshot.contacts) {
    Rows rows;
    rows.coordinates = coordinates_of({contact.body_a, contact.body_b});
    const auto along = [&](const Eigen::Vector3d& direction) {
      Eigen::VectorXd row(static_cast<Eigen::Index>(rows.coordinates.size()));
      Eigen::Index at = 0;
      for (const int body : {contact.body_a, contact.body_b}) {
        if (body == kWorld) continue;
        const Eigen::Vector3d arm = contact.point - snapshot.bodies[static_cast<std::size_t>(body)].position;
        row.segment<6>(at) << direction, arm.cross(direction);
        if (body == contact.body_b) row.segment<6>(at) *= -1;
        at += 6;
      }
      return row;
    };
    rows.normal = along(contact.normal);
    rows.tangent = along(contact.tangent);
    rows.second_tangent = along(contact.normal.cross(contact.tangent));
    contact.rows = std::move(rows);
  }
  for (const BodyState& body : snapshot.bodies) snapshot.blocks.push_back(block_of(body));
  snapshot.bodies.clear();
}

std::string numbered(const std::string& name, int count) {
  return count == 1 ? name : name + " #" + std::to_string(count);
}

std::vector<Pose> part_poses(const Scene& scene, const std::vector<Pose>& poses) {
  std::vector<Pose> result;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (const Part& part : scene.bodies[i].parts) {
      result.push_back({poses[i].position + poses[i].rotation * part.offset, poses[i].rotation});
    }
  }
  return result;
}

void require_built_scene(const Scene& scene, const std::string& model, const char* engine) {
  if (!model.empty()) throw InputError(std::string("--model: ") + engine + " reads no model files; MuJoCo does");
  if (!scene.model.empty()) throw InputError("scene '" + scene.name + "' is a model of MuJoCo's and runs there only");
}

}  // namespace lcpbench::capture
