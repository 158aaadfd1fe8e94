#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace lcpbench {

/// What one step of a replay measured: see adapters/capture/track.h. NaN: the scene has nothing that stands, or slips;
/// the energy: it has joints.
struct ReplayStep {
  std::int64_t step = 0;
  double time_s = 0;
  std::int64_t contacts = 0;
  std::string claim;
  double energy_j = 0;
  double deepest_m = 0;
  double drift_m = 0;
  double slip_m = 0;
  double cpu_s = 0;  ///< NaN: the engine does not tell it
};

/// How the reason begins why a replay ended, where the stepper, or its solver, does not take the scene.
inline constexpr const char* kRefusal = "refused: ";

/// A scene stepped on in one way.
struct Replay {
  std::string solver;  ///< the stepper as the user spelled it; "engine": the engine's own
  std::vector<ReplayStep> steps;
  std::string end;        ///< why it did not come to the last step; "" when it did
  std::string stepper{};  ///< its spec; "engine": the engine's own
  /// Until when the motion means anything: the time at which it and that of a scene whose first body begins 1e-12 m
  /// aside are kApart from each other; NaN: not asked for, infinity: they stay together.
  double parts_s = std::numeric_limits<double>::quiet_NaN();
  bool may_drift = false;  ///< nobody said what stands: a drift loses no scene, as of a model of which nothing was named

  double largest(double ReplayStep::*measure) const;
  /// The largest rise of the energy above an earlier step; NaN where none is known.
  double energy_rise() const;
  /// Steps until something drifted, slipped or sank by more than kLost, or the replay ended.
  std::int64_t survived() const;
  /// Whether the stepper, or its solver, does not take such scenes.
  bool refused() const { return end.starts_with(kRefusal); }
  /// Steps with contacts that the solver claims to have solved, and all steps with contacts.
  std::int64_t claimed() const;
  std::int64_t with_contacts() const;
  /// "any" or "even": those of `auto` (Answer::impulses), where the stepper is `exact` with it; "" for others.
  const char* impulses() const;
  /// CPU time of the stepper, or of the engine's solver, for a second of the scene.
  double cpu_s_per_s() const;
};

/// A scene in which something moved by more than this, that should not move, counts as lost [m].
inline constexpr double kLost = 0.1;

/// The stepper that stands in every comparison, last and without a film: no contact at all.
inline constexpr const char* kBaseline = "nothing";

/// Whether a track file has its end; false for one that is not there.
bool is_complete_track(const std::string& file);
/// @throws InputError naming file and line
Replay read_track(const std::string& file, const std::string& solver);

/// All replays of one scene.
struct ReplayedScene {
  std::string scene;
  std::string engine;
  double step_length_s = 0;
  std::int64_t steps = 0;
  bool pushed = false;  ///< forces other than gravity do work in it, so that its energy may rise
  std::vector<Replay> replays;
};

/// "stack, 300 steps of 0.005 s in ODE".
std::string replay_title(const ReplayedScene& scene);

/// One row for each scene and solver.
std::string replay_summary_csv(const std::vector<ReplayedScene>& scenes);

/// "1.75 m", "13.9 cm", "0.25 mm".
std::string length_text(double metres);

}  // namespace lcpbench
