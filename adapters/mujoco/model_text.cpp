#include "adapters/mujoco/model_text.h"

#include <cstdio>
#include <initializer_list>
#include <string>

#include "adapters/capture/engine.h"

namespace lcpbench::capture {
namespace {

std::string numbers(std::initializer_list<double> values) {
  std::string result = "\"";
  for (const double value : values) {
    char text[32];
    std::snprintf(text, sizeof text, " %.17g", value);
    result.append(text);
  }
  result.append("\"");
  return result;
}

std::string numbers(const Eigen::Vector3d& v) { return numbers({v.x(), v.y(), v.z()}); }
std::string numbers(const Eigen::Quaterniond& q) { return numbers({q.w(), q.x(), q.y(), q.z()}); }

class Writer {
 public:
  explicit Writer(const Scene& scene) : scene_(scene) {}

  std::string text() {
    text_ = "<mujoco><compiler angle=\"radian\"/><option timestep=" + numbers({scene_.step}) +
            " gravity=\"0 0 -9.81\"/><size njmax=\"2000\" nconmax=\"500\"/><default><geom condim=\"3\" friction=" +
            numbers({scene_.mu, 0.005, 0.0001}) + "/></default><worldbody>";
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      if (!scene_.bodies[i].hinge) add(i, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
    }
    text_ += "</worldbody>";
    if (!scene_.loops.empty()) add_loops();
    return text_ + "</mujoco>";
  }

 private:
  void add(std::size_t index, const Eigen::Vector3d& origin, const Eigen::Quaterniond& frame) {
    const Body& body = scene_.bodies[index];
    const Eigen::Quaterniond back = body.orientation.conjugate();
    text_ += numbered("<body name=\"b", static_cast<long long>(index)) +
             "\" pos=" + numbers(frame.conjugate() * (body.position - origin)) +
             " quat=" + numbers(frame.conjugate() * body.orientation) + ">";
    if (body.mass > 0) {
      text_ += "<inertial pos=\"0 0 0\" mass=" + numbers({body.mass}) + " diaginertia=" + numbers(body.inertia) + "/>";
      if (!body.hinge) text_ += "<freejoint/>";
    }
    if (body.hinge) {
      const Hinge& hinge = *body.hinge;
      text_ += numbered("<joint name=\"j", static_cast<long long>(index)) +
               "\" type=\"hinge\" pos=" + numbers(back * (hinge.anchor - body.position)) +
               " axis=" + numbers(back * hinge.axis) +
               " limited=\"true\" range=" + numbers({hinge.lower, hinge.upper}) + "/>";
    }
    for (const Part& part : body.parts) add(part, body.hinge.has_value());
    for (std::size_t i = index + 1; i < scene_.bodies.size(); ++i) {
      const Body& child = scene_.bodies[i];
      if (child.hinge && child.hinge->parent == static_cast<int>(index)) add(i, body.position, body.orientation);
    }
    text_ += "</body>";
  }

  /// Links of robots touch everything but each other.
  void add(const Part& part, bool link) {
    const bool sphere = part.kind == Part::Kind::kSphere;
    text_ += std::string("<geom type=\"") + (sphere ? "sphere" : "box") +
             "\" size=" + (sphere ? numbers({part.size.x()}) : numbers(part.size)) + " pos=" + numbers(part.offset) +
             (link ? " contype=\"2\" conaffinity=\"1\"" : " contype=\"1\" conaffinity=\"3\"") + "/>";
  }

  void add_loops() {
    text_ += "<equality>";
    for (const Loop& loop : scene_.loops) {
      const Body& first = scene_.bodies[static_cast<std::size_t>(loop.first)];
      text_ += numbered("<connect body1=\"b", loop.first) + numbered("\" body2=\"b", loop.second) +
               "\" anchor=" + numbers(first.orientation.conjugate() * (loop.anchor - first.position)) + "/>";
    }
    text_ += "</equality>";
  }

  const Scene& scene_;
  std::string text_;
};

}  // namespace

std::string model_text(const Scene& scene) { return Writer(scene).text(); }

}  // namespace lcpbench::capture
