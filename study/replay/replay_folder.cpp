#include "study/replay/replay_folder.h"

#include <cmath>
#include <fstream>
#include <limits>

#include <fmt/format.h>

#include "core/error.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReplaysFormat = "lcpbench-replays";
constexpr const char* kEngineReplay = "engine";

Json listed(const ReplayedFiles& files) {
  Json replays = Json::array();
  for (std::size_t i = 0; i < files.names.size(); ++i) {
    const Replay& replay = files.scene.replays[i];
    replays.push_back({{"solver", replay.solver}, {"stepper", replay.stepper}, {"file", files.names[i]}});
    if (replay.may_drift) replays.back()["may_drift"] = true;
    if (!std::isnan(replay.parts_s)) replays.back()["parts_s"] = json_number(replay.parts_s);  // null: infinity
  }
  return {{"scene", files.scene.scene},   {"engine", files.scene.engine},
          {"steps", files.scene.steps},   {"step_length_s", files.scene.step_length_s},
          {"pushed", files.scene.pushed}, {"replays", replays}};
}

ReplayedFiles read_listed(const fs::path& folder, const Json& json) {
  ReplayedFiles files;
  json.at("scene").get_to(files.scene.scene);
  json.at("engine").get_to(files.scene.engine);
  json.at("steps").get_to(files.scene.steps);
  json.at("step_length_s").get_to(files.scene.step_length_s);
  json.at("pushed").get_to(files.scene.pushed);
  for (const Json& replay : json.at("replays")) {
    files.names.push_back(fs::path(replay.at("file").get<std::string>()).filename().string());
    const std::string frames = (folder / "steps" / files.names.back()).string();
    Replay& track = files.scene.replays.emplace_back(
        read_track(frames + ".csv", replay.at("solver").get<std::string>()));
    track.stepper = replay.value("stepper", track.solver);
    track.may_drift = replay.value("may_drift", false);
    if (const auto parts = replay.find("parts_s"); parts != replay.end()) {
      track.parts_s = parts->is_null() ? std::numeric_limits<double>::infinity() : parts->get<double>();
    }
    files.frames.push_back(std::make_unique<ScenesFile>(frames));
  }
  return files;
}

}  // namespace

Json replay_json(const ReplayedScene& scene) {
  Json rows = Json::array();
  for (const Replay& replay : scene.replays) {
    rows.push_back({{"solver", replay.solver},
                    {"survived", replay.refused() ? Json() : Json(replay.survived())},
                    {"end", replay.end},
                    {"steps_with_contacts", replay.with_contacts()},
                    {"claimed_solved", replay.solver == kEngineReplay ? Json() : Json(replay.claimed())},
                    {"drift_m", json_number(replay.largest(&ReplayStep::drift_m))},
                    {"slip_m", json_number(replay.largest(&ReplayStep::slip_m))},
                    {"deepest_m", json_number(replay.largest(&ReplayStep::deepest_m))},
                    {"energy_rise_j", scene.pushed ? Json() : json_number(replay.energy_rise())},
                    {"stepper", replay.stepper},
                    {"parts_s", json_number(replay.parts_s)},
                    {"impulses", replay.impulses()},
                    {"cpu_s_per_s", json_number(replay.cpu_s_per_s())}});
  }
  return {{"scene", scene.scene},
          {"engine", scene.engine},
          {"steps", scene.steps},
          {"step_length_s", scene.step_length_s},
          {"conclusion", replay_title(scene)},
          {"replays", rows}};
}

std::string replay_list(const std::vector<ReplayedFiles>& scenes) {
  Json list = {{"format", kReplaysFormat}, {"version", 1}, {"scenes", Json::array()}};
  for (const ReplayedFiles& each : scenes) list["scenes"].push_back(listed(each));
  return list.dump(1) + "\n";
}

std::vector<ReplayedFiles> read_replays(const fs::path& folder) {
  const fs::path file = folder / "replays.json";
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw InputError(
        fmt::format("{}: cannot be read; `lcpbench replay ... --out {}` writes it, and steps nothing anew "
                    "that the folder has",
                    file.string(), folder.string()));
  }
  try {
    const Json list = Json::parse(stream);
    if (list.at("format") != kReplaysFormat || list.at("version") != 1) {
      throw InputError(fmt::format("{}: is no list of replays of version 1", file.string()));
    }
    std::vector<ReplayedFiles> scenes;
    for (const Json& scene : list.at("scenes")) scenes.push_back(read_listed(folder, scene));
    return scenes;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{}: is no list of replays: {}", file.string(), error.what()));
  }
}

}  // namespace lcpbench
