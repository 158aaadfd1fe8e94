#include "study/replay/replay.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "core/error.h"
#include "core/spec.h"
#include "study/output/csv.h"
#include "study/output/text_table.h"

namespace lcpbench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::string_view kTrackHeading = "step,time_s,contacts,claim,energy_j,deepest_m,drift_m,slip_m,cpu_s";
constexpr std::string_view kEnd = "end,";

/// Reads a cell. Nothing is NaN. @returns whether the rest of it is a number
bool read_number(const std::string& text, double& value) {
  value = kNone;
  if (text.empty()) return true;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && stop == text.data() + text.size();
}

/// @returns whether the line is a step
bool read_step(const std::string& line, ReplayStep& step) {
  std::istringstream stream(line + ",");
  std::vector<std::string> cells;
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  if (cells.size() != 9) return false;
  double number = 0;
  double contacts = 0;
  const std::array<double*, 9> numbers{&number,         &step.time_s,  &contacts,    nullptr,    &step.energy_j,
                                       &step.deepest_m, &step.drift_m, &step.slip_m, &step.cpu_s};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] != nullptr && !read_number(cells[i], *numbers[i])) return false;
  }
  if (!(number >= 0) || !(contacts >= 0)) return false;
  step.step = static_cast<std::int64_t>(number);
  step.contacts = static_cast<std::int64_t>(contacts);
  step.claim = cells[3];
  return true;
}

/// Three significant digits; nothing for NaN.
std::string cell(double value) { return std::isnan(value) ? "" : fmt::format("{:.3g}", value); }

}  // namespace

double Replay::largest(double ReplayStep::*measure) const {
  double largest = kNone;
  if (steps.size() == 1 && !end.empty()) return largest;  // no step was taken
  for (const ReplayStep& step : steps) {
    if (!(step.*measure <= largest)) largest = std::isnan(step.*measure) ? largest : step.*measure;
  }
  return largest;
}

double Replay::energy_rise() const {
  double rise = kNone;
  double lowest = std::numeric_limits<double>::infinity();
  for (const ReplayStep& step : steps) {
    if (std::isnan(step.energy_j)) continue;
    lowest = std::min(lowest, step.energy_j);
    rise = std::isnan(rise) ? 0 : std::max(rise, step.energy_j - lowest);
  }
  return rise;
}

std::int64_t Replay::survived() const {
  for (const ReplayStep& step : steps) {
    if ((step.drift_m > kLost && !may_drift) || step.slip_m > kLost || step.deepest_m > kLost) return step.step;
  }
  return steps.empty() ? 0 : steps.back().step + (end.empty() ? 1 : 0);
}

std::int64_t Replay::claimed() const {
  return std::count_if(steps.begin(), steps.end(),
                       [](const ReplayStep& step) { return step.contacts > 0 && step.claim == "solved"; });
}

std::int64_t Replay::with_contacts() const {
  return std::count_if(steps.begin(), steps.end(), [](const ReplayStep& step) { return step.contacts > 0; });
}

const char* Replay::impulses() const try {
  const Spec spec = stepper.empty() ? Spec{} : parse_spec(stepper);
  Spec solves{spec.name == "exact" ? "auto" : "", {}};
  for (const auto& [key, value] : spec.options) {
    if (key == "solver") solves = parse_spec(value);
  }
  if (solves.name != "auto") return "";
  const Options& options = solves.options;
  return std::ranges::find(options, Options::value_type("impulses", "even")) == options.end() ? "any" : "even";
} catch (const InputError&) {  // a list of replays may have any text there
  return "";
}

double Replay::cpu_s_per_s() const {
  if (steps.size() < 2) return kNone;
  double sum = 0;
  for (const ReplayStep& step : steps) sum += step.cpu_s;
  const double h = steps[1].time_s - steps[0].time_s;
  return sum / (h * static_cast<double>(steps.size()));
}

bool is_complete_track(const std::string& file) {
  std::ifstream stream(file);
  std::string last;
  for (std::string line; std::getline(stream, line);) last = line;
  return last.starts_with(kEnd);
}

Replay read_track(const std::string& file, const std::string& solver) {
  Replay replay;
  replay.solver = solver;
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line) || line != kTrackHeading)
    throw InputError(file + ": line 1: is no heading of a replay");
  for (int number = 2; std::getline(stream, line); ++number) {
    if (line.starts_with(kEnd)) {
      replay.end = line.substr(kEnd.size());
      return replay;
    }
    if (!read_step(line, replay.steps.emplace_back())) {
      throw InputError(fmt::format("{}: line {}: is no step of a replay", file, number));
    }
  }
  throw InputError(file + ": has no end; --fresh replays it again");
}

std::string length_text(double metres) {
  if (std::isnan(metres)) return "–";
  if (metres >= 1) return fmt::format("{:.3g} m", metres);
  if (metres >= 0.01) return fmt::format("{:.3g} cm", 100 * metres);
  if (metres < 1e-6) return metres > 0 ? "< 1 µm" : "0 mm";
  return fmt::format("{:.2g} mm", 1000 * metres);
}

std::string replay_title(const ReplayedScene& scene) {
  return fmt::format("{}, {} of {:g} s in {}", scene.scene, counted_noun(static_cast<std::size_t>(scene.steps), "step"),
                     scene.step_length_s, scene.engine);
}

std::string replay_summary_csv(const std::vector<ReplayedScene>& scenes) {
  std::string text =
      "scene,engine,solver,steps,survived,end,steps_with_contacts,claimed_solved,drift_m,slip_m,deepest_m,"
      "energy_rise_j,stepper,parts_s,impulses,cpu_s_per_s\n";
  for (const ReplayedScene& scene : scenes) {
    for (const Replay& replay : scene.replays) {
      const bool claims = replay.solver != "engine";
      text += fmt::format(
          "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_text(scene.scene), csv_text(scene.engine),
          csv_text(replay.solver), scene.steps, replay.refused() ? "" : std::to_string(replay.survived()),
          csv_text(replay.end), replay.with_contacts(), claims ? std::to_string(replay.claimed()) : "",
          cell(replay.largest(&ReplayStep::drift_m)), cell(replay.largest(&ReplayStep::slip_m)),
          cell(replay.largest(&ReplayStep::deepest_m)), cell(scene.pushed ? kNone : replay.energy_rise()),
          csv_text(replay.stepper), cell(replay.parts_s), replay.impulses(), cell(replay.cpu_s_per_s()));
    }
  }
  return text;
}

}  // namespace lcpbench
