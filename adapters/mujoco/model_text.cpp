#include "adapters/mujoco/model_text.h"

#include <initializer_list>
#include <string>

#include <fmt/format.h>

namespace lcpbench::capture {
namespace {

/// As an attribute, in the shortest digits that read back to the same doubles.
std::string numbers(std::initializer_list<double> values) {
  return fmt::format("\"{}\"", fmt::join(values.begin(), values.end(), " "));
}

std::string numbers(const Eigen::Vector3d& v) { return numbers({v.x(), v.y(), v.z()}); }
std::string numbers(const Eigen::Quaterniond& q) { return numbers({q.w(), q.x(), q.y(), q.z()}); }

class Writer {
 public:
  explicit Writer(const Scene& scene) : scene_(scene) {}

  std::string text() {
    text_ = fmt::format(R"(<mujoco><compiler angle="radian"/><option timestep="{}" gravity="0 0 -9.81"/>)"
                        R"(<size njmax="3000" nconmax="700"/>)"
                        R"(<default><geom condim="3" friction="{} 0.005 0.0001"/></default><worldbody>)",
                        scene_.step, scene_.mu);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      if (!scene_.bodies[i].joint) add(i, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
    }
    text_ += "</worldbody>";
    if (!scene_.loops.empty()) add_loops();
    return text_ + "</mujoco>";
  }

 private:
  /// Adds a body and, nested in it, the bodies that hinges join to it.
  /// @param origin, frame  position and orientation of the parent in the world; of the world itself without a hinge
  void add(std::size_t index, const Eigen::Vector3d& origin, const Eigen::Quaterniond& frame) {
    const Body& body = scene_.bodies[index];
    const Eigen::Quaterniond to_body = body.orientation.conjugate();
    text_ += fmt::format(R"(<body name="b{}" pos={} quat={}>)", index,
                         numbers(frame.conjugate() * (body.position - origin)),
                         numbers(frame.conjugate() * body.orientation));
    if (body.mass > 0) {
      text_ += fmt::format(R"(<inertial pos="0 0 0" mass="{}" diaginertia={}/>)", body.mass, numbers(body.inertia));
      if (!body.joint) text_ += "<freejoint/>";
    }
    if (body.joint) {
      const Joint& joint = *body.joint;
      text_ += fmt::format(R"(<joint name="j{}" type="{}" pos={} axis={} limited="true" range="{} {}")", index,
                           joint.kind(), numbers(to_body * (joint.anchor - body.position)),
                           numbers(to_body * joint.axis), joint.lower, joint.upper);
      if (joint.effort > 0) text_ += fmt::format(R"( frictionloss="{}")", joint.effort);
      text_ += "/>";
    }
    for (const Part& part : body.parts) add(part, body.joint.has_value());
    for (std::size_t i = index + 1; i < scene_.bodies.size(); ++i) {
      const Body& child = scene_.bodies[i];
      if (child.joint && child.joint->parent == static_cast<int>(index)) add(i, body.position, body.orientation);
    }
    text_ += "</body>";
  }

  /// Bodies with a hinge to a parent do not touch each other, even those of two robots. All other pairs may touch,
  /// except those that MuJoCo leaves out: two bodies of the world, and a body and its parent, if the parent moves.
  /// @param on_hinge  whether the part's body has a hinge
  void add(const Part& part, bool on_hinge) {
    const bool sphere = part.kind == Part::Kind::kSphere;
    text_ += fmt::format(R"(<geom type="{}" size={} pos={} {}/>)", sphere ? "sphere" : "box",
                         sphere ? numbers({part.size.x()}) : numbers(part.size), numbers(part.offset),
                         on_hinge ? R"(contype="2" conaffinity="1")" : R"(contype="1" conaffinity="3")");
  }

  void add_loops() {
    text_ += "<equality>";
    for (const Loop& loop : scene_.loops) {
      const Body& first = scene_.bodies[static_cast<std::size_t>(loop.first)];
      text_ += fmt::format(R"(<connect body1="b{}" body2="b{}" anchor={}/>)", loop.first, loop.second,
                           numbers(first.orientation.conjugate() * (loop.anchor - first.position)));
    }
    text_ += "</equality>";
  }

  const Scene& scene_;
  std::string text_;
};

}  // namespace

std::string model_text(const Scene& scene) { return Writer(scene).text(); }

}  // namespace lcpbench::capture
