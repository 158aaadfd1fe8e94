#pragma once

#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "adapters/capture/engine.h"

namespace lcpbench::capture {

/// Writes the measures of a replay's steps as CSV: one line a step, then "end," and why the replay ended, empty where
/// it came to its last step. A file without that line is not complete.
///
/// energy_j: of all free bodies, kinetic with the velocity after the step's contacts and potential in the middle of the
/// last substep, which free fall does not change; empty for a scene with joints, whose motors do work. deepest_m: the
/// largest penetration that the step found. drift_m: the largest distance of one of Scene::stands from its first place.
/// slip_m: the largest distance of a held body (Scene::grips) from where it was beside its holder, at right angles to
/// the line between the two. claim: the stepper's. cpu_s: the CPU time of the stepper, or of the engine's solver; empty
/// where the engine does not tell it.
class Track {
 public:
  /// @param engine  outlives it @throws InputError when the file cannot be written
  Track(const std::string& file, const Engine& engine);
  /// @param velocity  after the contacts, of all bodies
  /// @returns why the scene cannot go on; "" when it can
  std::string add(long step, const Snapshot& snapshot, const Eigen::VectorXd& velocity, const std::string& claim,
                  std::optional<double> cpu_s);
  void end(const std::string& why) { why_ = why; }
  /// @throws InputError when not all of it arrived
  void close();

 private:
  void check() const;
  double energy(const Snapshot& snapshot, const Eigen::VectorXd& velocity) const;
  double drift(const Snapshot& snapshot) const;
  double slip(const Snapshot& snapshot) const;
  const Eigen::Vector3d& place(const Snapshot& snapshot, int body) const;

  std::string name_;
  const Scene& scene_;
  double h_;
  Eigen::Vector3d gravity_;
  std::vector<std::size_t> part_;  ///< of each body the first, which has a pose
  Snapshot start_;
  std::string why_;
  std::ofstream file_;
};

}  // namespace lcpbench::capture
