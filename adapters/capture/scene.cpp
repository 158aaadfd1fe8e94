#include "adapters/capture/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "core/settings.h"
#include "core/suggestion.h"

namespace lcpbench::capture {
namespace {

double volume(const Part& part) {
  if (part.kind == Part::Kind::kBox) return 8 * part.size.x() * part.size.y() * part.size.z();
  return 4.0 / 3 * std::numbers::pi * part.size.x() * part.size.x() * part.size.x();
}

/// Moments of a part of this mass about its own centre.
Eigen::Vector3d moments(const Part& part, double mass) {
  const Eigen::Vector3d s = part.size.cwiseAbs2();
  if (part.kind == Part::Kind::kSphere) return Eigen::Vector3d::Constant(0.4 * mass * s.x());
  return mass / 3 * Eigen::Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
}

/// What the options of a scene's spec change.
struct SceneChanges {
  std::int64_t divide = 1;
  double nudge = 0;
  bool elliptic = false;
  double cfm = -1;
  double erp = -1;
  std::int64_t sweeps = 0;

  void visit(auto&& field) {
    field("divide", divide, IntegerRange{.min = 1, .max = 1000}, "parts of each step, which become the steps");
    field("nudge", nudge, RealRange{}, "[m] how far the first body that moves is put aside, along x and y");
    field("elliptic", elliptic, "with MuJoCo's elliptic friction cones in place of its pyramids");
    field("cfm", cfm, RealRange{.min = -1},
          "constraint force mixing of contacts, in the units of ODE, Bullet or DART; negative: the engine's default");
    field("erp", erp, RealRange{.min = -1, .max = 1}, "share of penetration taken out in a step; negative: default");
    field("sweeps", sweeps, IntegerRange{.min = 0, .max = 1'000'000},
          "of the engine's own solver; DART's then is its projected Gauss-Seidel method; 0: as by default");
  }
};

}  // namespace

bool Scene::articulated() const {
  return !model.empty() ||
         std::any_of(bodies.begin(), bodies.end(), [](const Body& body) { return body.joint.has_value(); });
}

bool Scene::driven() const {
  return std::any_of(bodies.begin(), bodies.end(),
                     [](const Body& body) { return body.joint && body.joint->speed != 0; });
}

std::size_t Scene::root(std::size_t body) const {
  while (bodies[body].joint) body = static_cast<std::size_t>(bodies[body].joint->parent);
  return body;
}

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all = [] {
    std::vector<Scene> result = free_body_scenes();
    for (Scene& scene : articulated_scenes()) result.push_back(std::move(scene));
    return result;
  }();
  return all;
}

Scene find_scene(const std::string& text) {
  const Spec spec = parse_spec(text);
  std::vector<std::string> names;
  for (const Scene& known : scenes()) {
    names.push_back(known.name);
    if (known.name != spec.name) continue;
    const auto changes = parse_settings<SceneChanges>(spec.name, spec.options);
    Scene scene = known;
    if ((changes.divide != 1 || changes.nudge != 0) && !scene.model.empty()) {
      throw InputError("scene '" + spec.name + "' is a model of MuJoCo's, whose steps and bodies stay as they are");
    }
    scene.name = Spec{spec.name, changed_settings(changes)}.text();
    scene.elliptic = changes.elliptic;
    scene.cfm = changes.cfm;
    scene.erp = changes.erp;
    scene.sweeps = static_cast<int>(changes.sweeps);
    scene.step /= static_cast<double>(changes.divide);
    scene.steps *= changes.divide;
    for (Body& body : scene.bodies) {
      body.push.first *= changes.divide;
      body.push.last = (body.push.last + 1) * changes.divide - 1;
    }
    const auto moves = std::find_if(scene.bodies.begin(), scene.bodies.end(), [](const Body& b) { return b.mass > 0; });
    if (moves != scene.bodies.end()) moves->position += Eigen::Vector3d(changes.nudge, changes.nudge, 0);
    return scene;
  }
  throw InputError("unknown scene '" + spec.name + "'" + did_you_mean(spec.name, names) +
                   "; `lcpbench capture --help` lists them");
}

Part box(double x, double y, double z, const Eigen::Vector3d& offset) { return {Part::Kind::kBox, {x, y, z}, offset}; }

Part sphere(double radius, const Eigen::Vector3d& offset) {
  return {Part::Kind::kSphere, {radius, radius, radius}, offset};
}

Body solid(std::vector<Part> parts, double mass, const Eigen::Vector3d& origin) {
  double total = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Part& part : parts) {
    total += volume(part);
    centre += volume(part) * part.offset;
  }
  centre /= total;
  Body body;
  body.mass = mass;
  body.inertia.setZero();
  for (Part& part : parts) {
    part.offset -= centre;
    const double share = mass * volume(part) / total;
    const Eigen::Vector3d r = part.offset.cwiseAbs2();
    body.inertia += moments(part, share) + share * Eigen::Vector3d(r.y() + r.z(), r.x() + r.z(), r.x() + r.y());
  }
  body.parts = std::move(parts);
  body.position = origin + centre;
  return body;
}

Body fixed(Part part, const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation) {
  return {.parts = {std::move(part)}, .mass = 0, .position = position, .orientation = orientation};
}

Body ground() { return fixed(box(15, 15, 1), {0, 0, -1}); }

Scene scene(std::string name, std::string summary, double mu) {
  return {.name = std::move(name), .summary = std::move(summary), .bodies = {ground()}, .mu = mu};
}

Eigen::Quaterniond turned_about_y(double cosine, double sine) {
  const double half_cosine = std::sqrt((1 + cosine) / 2);
  return {half_cosine, 0, sine / (2 * half_cosine), 0};
}

}  // namespace lcpbench::capture
