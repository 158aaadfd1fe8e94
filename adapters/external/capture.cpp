// An engine that is a program of its own, in any language: it is told the scene, and then each step's forces, as lines
// of JSON. docs/reference/external.md describes them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <signal.h>

#include "adapters/capture/engine.h"
#include "adapters/external/asked_engine.h"
#include "adapters/external/model_engine.h"
#include "core/error.h"
#include "core/io/json_document.h"

namespace lcpbench::capture {
namespace {

constexpr double kUnexplained = 0.05;      ///< part of the largest change of velocity that may stay unexplained
constexpr double kSinglePrecision = 1e-6;  ///< part of the largest speed that counts as its rounding
constexpr double kUnitLength = 1e-3;       ///< a normal or a quaternion may differ from length 1 by less than this

/// A pose and velocities, as the program tells and is told them: position, quaternion (w first), linear and angular
/// velocity.
struct Motion {
  Pose pose;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
};
constexpr Index kNumbersOfMotion = 13;

Json list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json row_of(const Motion& motion) {
  const auto& [position, rotation] = motion.pose;
  return {position.x(),       position.y(),       position.z(),       rotation.w(),       rotation.x(),
          rotation.y(),       rotation.z(),       motion.linear.x(),  motion.linear.y(),  motion.linear.z(),
          motion.angular.x(), motion.angular.y(), motion.angular.z()};
}

Motion motion_of(const Vector& row) {
  return {{row.head<3>(), Eigen::Quaterniond(row(3), row(4), row(5), row(6)).normalized()},
          row.segment<3>(7),
          row.tail<3>()};
}

Json body_json(const Body& body) {
  Json parts = Json::array();
  for (const Part& part : body.parts) {
    Json shape{{"offset", list(part.offset)}};
    if (part.kind == Part::Kind::kSphere) {
      shape["sphere"] = part.size.x();
    } else {
      shape["box"] = list(part.size);
    }
    parts.push_back(shape);
  }
  const Eigen::Quaterniond& q = body.orientation;
  return {{"mass", body.mass},
          {"inertia", list(body.inertia)},
          {"motion", row_of({{body.position, q}, body.linear_velocity, body.angular_velocity})},
          {"parts", parts}};
}

class ExternalEngine final : public AskedEngine {
 public:
  explicit ExternalEngine(const Scene& scene)
      : AskedEngine(scene, "scene") {
    Json bodies = Json::array();
    for (const Body& body : scene_.bodies) {
      bodies.push_back(body_json(body));
      motions_.push_back({{body.position, body.orientation}, body.linear_velocity, body.angular_velocity});
      moving_.push_back(body.mass > 0 ? count_++ : kWorld);
    }
    try {
      const Json answer = ask({{"verb", "scene"},
                               {"step", scene_.step},
                               {"mu", scene_.mu},
                               {"restitution", scene_.restitution},
                               {"bodies", bodies}});
      const JsonObject told(answer, origin());
      told.only({"engine", "version"});
      name_ = told.text("engine");
      version_ = told.text("version");
    } catch (const std::runtime_error& error) {
      throw InputError("engine '" + scene_.program + "': " + error.what() + " (docs/reference/external.md)");
    }
  }

 private:
  void take(long index, Snapshot& snapshot, const VelocitySolver& loop) override {
    Json forces = Json::array();
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      poses.push_back(motions_[i].pose);
      forces.push_back(add_body(i, index, snapshot));
    }
    snapshot.poses = part_poses(scene_, poses);
    const Json answer = ask({{"verb", "step"}, {"forces", forces}});
    const JsonObject told(answer, origin());
    told.only({"contacts", "motions", "solve_s"});
    pushes_.assign(static_cast<std::size_t>(count_), Eigen::Vector3d::Zero());
    for (const JsonObject& contact : told.objects("contacts")) add_contact(contact, snapshot);
    if (loop) {
      const Eigen::VectorXd velocity = loop(snapshot);
      move_on(velocity, moving_velocity(velocity, snapshot, scene_.step));
      return;
    }
    const std::vector<Vector> rows = told.rows("motions");
    if (rows.size() != motions_.size()) told.fail("motions", ": expected one for each body");
    snapshot.velocity_after.resize(6 * count_);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].size() != kNumbersOfMotion) told.fail("motions", ": expected 13 numbers for each body");
      if (moving_[i] == kWorld) continue;
      const bool turns = std::abs(rows[i].segment<4>(3).norm() - 1) < kUnitLength;
      if (!turns) told.fail("motions[" + std::to_string(i) + "]", ": its quaternion is not of length 1");
      motions_[i] = motion_of(rows[i]);
      snapshot.velocity_after.segment<6>(6 * moving_[i]) << motions_[i].linear, motions_[i].angular;
    }
    take_solve_time(told, snapshot);
    if (snapshot.has_impulses && !told_of_impulses_) compare_impulses(snapshot);
  }

  /// Says once that the impulses do not give the bodies the velocities that they have: a sign, force or mass differs.
  void compare_impulses(const Snapshot& snapshot) {
    double unexplained = 0, change = 0, speed = 0;
    for (std::size_t k = 0; k < snapshot.bodies.size(); ++k) {
      const Eigen::Vector3d after = snapshot.velocity_after.segment<3>(static_cast<Index>(6 * k));
      const Eigen::Vector3d gained = after - snapshot.bodies[k].linear_velocity;
      const Eigen::Vector3d given = pushes_[k] / snapshot.bodies[k].mass;
      unexplained = std::max(unexplained, (gained - given).norm());
      change = std::max({change, gained.norm(), given.norm()});
      speed = std::max(speed, after.norm());
    }
    if (!(unexplained > kUnexplained * change + kSinglePrecision * speed)) return;
    told_of_impulses_ = true;
    std::fprintf(stderr,
                 "%s: the impulses do not explain %.3g m/s of a body's velocity; compare their signs, and the forces\n",
                 origin().c_str(), unexplained);
  }

  /// @returns the force and torque of this step
  Json add_body(std::size_t i, long index, Snapshot& snapshot) const {
    if (moving_[i] == kWorld) return Json(std::vector<double>(6, 0.0));
    const Body& body = scene_.bodies[i];
    const Motion& motion = motions_[i];
    BodyState state;
    state.mass = body.mass;
    state.inertia = world_inertia(motion.pose.rotation.toRotationMatrix(), body.inertia);
    state.position = motion.pose.position;
    state.linear_velocity = motion.linear;
    state.angular_velocity = motion.angular;
    const Eigen::Vector3d force = force_on(body, index);
    const Eigen::Vector3d torque = gyroscopic_torque(state.inertia, motion.angular, scene_.step);
    state.accelerate(force, torque, scene_.step);
    snapshot.bodies.push_back(state);
    return {force.x(), force.y(), force.z(), torque.x(), torque.y(), torque.z()};
  }

  void add_contact(const JsonObject& told, Snapshot& snapshot) {
    told.only({"bodies", "point", "normal", "gap", "impulse"});
    const std::vector<int> pair = told.integers("bodies");
    for (const int body : pair) {
      if (body < 0 || body >= static_cast<int>(motions_.size())) told.fail("bodies", ": no such body");
    }
    if (pair.size() != 2 || pair[0] == pair[1]) told.fail("bodies", ": expected two");
    // However the engine orders the two, the pair has one order: by it contacts keep their names and tangents.
    const bool turned = pair[0] < pair[1];
    const auto a = static_cast<std::size_t>(pair[turned ? 1 : 0]), b = static_cast<std::size_t>(pair[turned ? 0 : 1]);
    const double sign = turned ? -1 : 1;
    if (moving_[a] == kWorld && moving_[b] == kWorld) return;
    const Eigen::Vector3d point = told.vector("point", 3);
    const Eigen::Vector3d normal = sign * told.vector("normal", 3);
    if (!(std::abs(normal.norm() - 1) < kUnitLength)) told.fail("normal", ": not of length 1");
    const auto at_point = [&](std::size_t body) {
      const Motion& motion = motions_[body];
      return Eigen::Vector3d(motion.linear + motion.angular.cross(point - motion.pose.position));
    };
    ContactState contact = touch(scene_, a, b, point, normal, told.number("gap"), at_point(a) - at_point(b));
    contact.body_a = moving_[a];
    contact.body_b = moving_[b];
    const Pose& pose = motions_[contact.body_a == kWorld ? b : a].pose;
    contact.local = pose.rotation.conjugate() * (contact.point - pose.position);
    if (told.given("impulse")) {
      const Eigen::Vector3d impulse = sign * told.vector("impulse", 3);
      contact.impulse = in_axes_of(contact, impulse);
      if (contact.body_a != kWorld) pushes_[static_cast<std::size_t>(contact.body_a)] += impulse;
      if (contact.body_b != kWorld) pushes_[static_cast<std::size_t>(contact.body_b)] -= impulse;
    }
    snapshot.has_impulses = told.given("impulse") && (snapshot.contacts.empty() || snapshot.has_impulses);
    snapshot.contacts.push_back(contact);
  }

  /// The bodies are put where a stepper's velocity takes them, whatever the engine made of the step.
  void move_on(const Eigen::VectorXd& velocity, const Eigen::VectorXd& moving) {
    Json rows = Json::array();
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      Motion& motion = motions_[i];
      if (moving_[i] != kWorld) {
        const Index at = 6 * moving_[i];
        const Eigen::Vector3d turn = scene_.step * moving.segment<3>(at + 3);
        motion.pose.position += scene_.step * moving.segment<3>(at);
        if (const double angle = turn.norm(); angle > 0) {
          motion.pose.rotation =
              (Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * motion.pose.rotation).normalized();
        }
        motion.linear = velocity.segment<3>(at);
        motion.angular = velocity.segment<3>(at + 3);
      }
      rows.push_back(row_of(motion));
    }
    const Json answer = ask({{"verb", "place"}, {"motions", rows}});
    JsonObject(answer, origin()).only({});
  }

  std::vector<Motion> motions_;  ///< as the step begins
  std::vector<int> moving_;      ///< of each body its index in a snapshot, or kWorld
  int count_ = 0;
  std::vector<Eigen::Vector3d> pushes_;  ///< the step's impulses on each moving body
  bool told_of_impulses_ = false;
};

}  // namespace

std::unique_ptr<Engine> make_engine(const Scene& scene, const std::string& model) {
  signal(SIGPIPE, SIG_IGN);
  if (!model.empty()) return make_model_engine(scene, model);
  if (scene.articulated()) {
    throw InputError("scene '" + scene.name + "' has joints, which no external engine is told");
  }
  if (!scene.soft.empty() || scene.cfm >= 0 || scene.erp >= 0 || scene.sweeps > 0) {
    throw InputError("an external engine takes none of --soft, cfm, erp and sweeps");
  }
  return std::make_unique<ExternalEngine>(scene);
}

}  // namespace lcpbench::capture
