#include "adapters/capture/track.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "core/utf8.h"

namespace lcpbench::capture {
namespace {

constexpr double kTooFast = 1e3;  // m/s, rad/s: the simulation has blown up

}  // namespace

Track::Track(const std::string& file, const Engine& engine)
    : name_(file), scene_(engine.scene()), h_(engine.step_length()), gravity_(engine.gravity()), file_(file) {
  std::size_t parts = 0;
  for (const Body& body : scene_.bodies) {
    part_.push_back(parts);
    parts += body.parts.size();
  }
  file_ << "step,time_s,contacts,claim,energy_j,deepest_m,drift_m,slip_m,cpu_s\n";
  check();
}

void Track::check() const {
  if (!file_) throw InputError("cannot write '" + name_ + "'");
}

const Eigen::Vector3d& Track::place(const Snapshot& snapshot, int body) const {
  const auto at = static_cast<std::size_t>(body);
  return snapshot.marks.empty() ? snapshot.poses[part_[at]].position : snapshot.marks[at];
}

std::string Track::add(long step, const Snapshot& snapshot, const Eigen::VectorXd& velocity, const std::string& claim,
                       std::optional<double> cpu_s) {
  if (start_.poses.empty()) start_ = snapshot;
  double deepest = 0;
  for (const ContactState& contact : snapshot.contacts) deepest = std::max(deepest, -contact.gap);
  const auto cell = [](bool is_known, double value) { return is_known ? fmt::format("{:.6g}", value) : ""; };
  file_ << fmt::format("{},{:.9g},{},{},", step, h_ * static_cast<double>(step), snapshot.contacts.size(), claim);
  if (snapshot.blocks.empty()) file_ << fmt::format("{:.9g}", energy(snapshot, velocity));
  file_ << fmt::format(",{:.6g},{},{},{}\n", deepest, cell(!scene_.stands.empty(), drift(snapshot)),
                       cell(!scene_.grips.empty(), slip(snapshot)), cell(cpu_s.has_value(), cpu_s.value_or(0)));
  return velocity.size() > 0 && !(velocity.allFinite() && velocity.lpNorm<Eigen::Infinity>() < kTooFast) ? "it blew up"
                                                                                                         : "";
}

void Track::close() {
  file_ << "end," << printable(why_) << '\n';
  file_.close();
  check();
}

double Track::energy(const Snapshot& snapshot, const Eigen::VectorXd& velocity) const {
  double sum = 0;
  for (std::size_t i = 0; i < snapshot.bodies.size(); ++i) {
    const BodyState& body = snapshot.bodies[i];
    const auto at = static_cast<Eigen::Index>(6 * i);
    const Eigen::Vector<double, 6> v = velocity.segment<6>(at);
    Eigen::Vector3d position = body.position + (h_ - h_ / 2 / snapshot.substeps) * v.head<3>();
    if (snapshot.correction.size() > 0) position += snapshot.correction.segment<3>(at);
    sum += body.mass * (v.head<3>().squaredNorm() / 2 - gravity_.dot(position)) +
           v.tail<3>().dot(body.inertia * v.tail<3>()) / 2;
  }
  return sum;
}

double Track::drift(const Snapshot& snapshot) const {
  double farthest = 0;
  for (const int body : scene_.stands) {
    farthest = std::max(farthest, (place(snapshot, body) - place(start_, body)).norm());
  }
  return farthest;
}

double Track::slip(const Snapshot& snapshot) const {
  double farthest = 0;
  for (const Grip& grip : scene_.grips) {
    const Eigen::Vector3d start = place(start_, grip.held) - place(start_, grip.by);
    const Eigen::Vector3d moved = place(snapshot, grip.held) - place(snapshot, grip.by) - start;
    farthest = std::max(farthest, (moved - moved.dot(start) / start.squaredNorm() * start).norm());
  }
  return farthest;
}

}  // namespace lcpbench::capture
