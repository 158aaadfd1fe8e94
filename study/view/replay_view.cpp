#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "study/output/json_output.h"
#include "study/view/shapes.h"
#include "study/view/view.h"

namespace lcpbench {
namespace {

constexpr std::size_t kCurvePoints = 150;  // of each curve; a point has the largest value of its steps

/// The largest of the steps in [begin, end); null where none is known.
Json largest(const std::vector<ReplayStep>& steps, std::size_t begin, std::size_t end, double ReplayStep::*measure) {
  double value = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = begin; i < end; ++i) value = std::fmax(value, steps[i].*measure);
  return view_number(value, 4);
}

Json curves(const std::vector<ReplayStep>& steps) {
  constexpr std::pair<const char*, double ReplayStep::*> kCurves[] = {{"time_s", &ReplayStep::time_s},
                                                                      {"drift_m", &ReplayStep::drift_m},
                                                                      {"slip_m", &ReplayStep::slip_m},
                                                                      {"deepest_m", &ReplayStep::deepest_m},
                                                                      {"energy_j", &ReplayStep::energy_j}};
  const std::size_t points = std::min(kCurvePoints, steps.size());
  Json json = Json::object();
  for (const auto& [name, measure] : kCurves) {
    json[name] = Json::array();
    for (std::size_t p = 0; p < points; ++p) {
      json[name].push_back(largest(steps, p * steps.size() / points, (p + 1) * steps.size() / points, measure));
    }
  }
  return json;
}

/// The poses of what moves in each frame, one after the other, and once of what does not.
Json film(const Replay& replay, const ScenesFile& file) {
  std::vector<SceneStep> frames;
  for (std::size_t i = 0; i < file.count(); ++i) frames.push_back(file.read(i));
  std::size_t bodies = frames.empty() ? 0 : frames.front().poses.size();
  for (const SceneStep& frame : frames) bodies = std::min(bodies, frame.poses.size());
  Json still = Json::array();
  std::vector<std::size_t> moving;
  for (std::size_t body = 0; body < bodies; ++body) {
    const std::vector<double>& first = frames.front().poses[body];
    const auto differs = [&](const SceneStep& frame) { return frame.poses[body] != first; };
    const auto unknown = [&](const SceneStep& frame) { return frame.poses[body].size() != 7; };
    const bool hidden = std::any_of(frames.begin(), frames.end(), unknown);
    const bool moves = !hidden && std::any_of(frames.begin(), frames.end(), differs);
    still.push_back(moves || hidden ? Json() : view_row(first));
    if (moves) moving.push_back(body);
  }
  Json json = {{"solver", replay.solver}, {"still", still},           {"moving", moving},
               {"steps", Json::array()},  {"times_s", Json::array()}, {"frames", Json::array()},
               {"curves", curves(replay.steps)}};
  for (const SceneStep& frame : frames) {
    std::vector<double> poses;
    for (const std::size_t body : moving) poses.insert(poses.end(), frame.poses[body].begin(), frame.poses[body].end());
    json["steps"].push_back(frame.step);
    json["times_s"].push_back(view_number(frame.time.value_or(0)));
    json["frames"].push_back(view_row(poses, 5));
  }
  return json;
}

}  // namespace

Json replay_view(const ReplayedFiles& replays) {
  Json view = {{"kind", "replay"}, {"title", replays.scene.scene}};
  view.update(replay_json(replays.scene));
  const ScenesHeader header = replays.frames.empty() ? ScenesHeader{} : replays.frames.front()->header();
  view["gravity"] = header.gravity.size() == 3 ? view_row(header.gravity) : Json();
  view["shapes"] = Json::array();
  for (const SceneShape& shape : header.shapes) {
    if (is_drawn(shape)) view["shapes"].push_back(shape_json(shape));
  }
  view["films"] = Json::array();
  for (std::size_t i = 0; i < replays.frames.size(); ++i) {
    const Replay& replay = replays.scene.replays[i];
    if (replay.stepper == kBaseline && replays.frames.size() > 1) continue;  // all fall out of the picture
    if (replay.refused()) continue;
    view["films"].push_back(film(replay, *replays.frames[i]));
  }
  return view;
}

}  // namespace lcpbench
