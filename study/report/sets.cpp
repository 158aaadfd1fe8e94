#include "study/report/sets.h"

#include <algorithm>
#include <array>
#include <regex>
#include <set>

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/scenes_file.h"
#include "core/utf8.h"
#include "generators/hard/hard.h"
#include "generators/scenes/scenes.h"
#include "study/output/columns.h"
#include "study/output/explanation.h"

namespace lcpbench::report {

namespace {

constexpr std::string_view kHardPrefix = "hard/";

/// A set of the paper's or of rigid problems that asks for a condition number of the inertia: by its experiment, as
/// "paper/monotone/exp5-1e8", or by its option `condition`. The number has another meaning in `hard/` and `planted/`.
const std::regex& conditioned() {
  static const std::regex pattern(R"(((?:paper|rigid)/.*(?:/exp[56]-|[{,](condition)=))[0-9.]+(?:e[0-9]+)?([{},].*)?)");
  return pattern;
}

}  // namespace

Spec spec_or_name(const std::string& text) {
  try {
    return parse_spec(text);
  } catch (const InputError&) {
    return {text, {}};
  }
}

const char* to_string(SetKind kind) {
  constexpr std::array kNames{"robots",     "stacks",          "piles", "scenes", "frictionless",
                              "frictional", "ill_conditioned", "dial",  "bare",   "hard"};
  return kNames[static_cast<std::size_t>(kind)];
}

SetKind kind_of(const SetSummary& set) {
  constexpr std::array<std::string_view, 3> kStacked{"stack", "card-house", "wall"};
  if (is_hard_set(set.name)) return SetKind::kHard;
  if (!set.contact) return SetKind::kBare;
  if (const std::optional<SceneName> name = scene_name(set.name)) {
    if (!set.free_bodies) return SetKind::kRobots;
    if (std::find(kStacked.begin(), kStacked.end(), name->family) != kStacked.end()) return SetKind::kStacks;
    return name->family.ends_with("-pile") ? SetKind::kPiles : SetKind::kScenes;
  }
  std::smatch match;
  if (std::regex_match(set.name, match, conditioned()) && match[2].matched) return SetKind::kDial;
  if (set.ill_conditioned) return SetKind::kIllConditioned;
  return set.frictional ? SetKind::kFrictional : SetKind::kFrictionless;
}

std::optional<SceneName> scene_name(const std::string& set) {
  constexpr std::string_view kCollection = "scene/";
  if (set.starts_with("file:") && is_scenes_file(set)) return SceneName{set, ""};
  if (!set.starts_with(kCollection)) return std::nullopt;
  const std::size_t slash = set.rfind('/');
  if (slash < kCollection.size()) return std::nullopt;
  return SceneName{set.substr(kCollection.size(), slash - kCollection.size()), set.substr(slash + 1)};
}

std::string engine_of(const std::string& set) {
  const std::string file = set.substr(set.find(':') + 1);
  const std::optional<SceneName> name = scene_name(set);
  try {
    const auto step = scenes_step(file);
    if (!step && (!name || !name->engine.empty())) return name ? name->engine : "";
    return ScenesFile(step ? step->first : file).header().engine;
  } catch (const InputError&) {
    return "";
  }
}

std::string only_engine(const Summary& summary) {
  std::set<std::string> engines;
  for (const Cell& cell : summary.cells) {
    if (summary.solvers[cell.solver].name != "engine" || cell.refused()) continue;
    const std::string& set = summary.sets[cell.set].name;
    try {
      const auto collected = std::ranges::find(collected_scenes(), set, &CollectedScene::name);
      if (collected != collected_scenes().end()) {
        engines.insert(open_collected(*collected)->header().engine_label());
      } else {
        const std::string file = set.substr(set.find(':') + 1);
        const auto step = scenes_step(file);
        engines.insert(ScenesFile(step ? step->first : file).header().engine_label());
      }
    } catch (const InputError&) {
      engines.insert("");  // a file that is gone, or of problems
    }
    if (engines.size() > 1) return "";
  }
  return engines.empty() ? "" : printable(*engines.begin());
}

std::string soft_engine_note(const Summary& summary) {
  std::set<std::string> notes;
  for (const Cell& cell : summary.cells) {
    if (summary.solvers[cell.solver].name != "engine" || cell.false_claims() == 0) continue;
    notes.insert(soft_engine_words(engine_of(summary.sets[cell.set].name)));
  }
  notes.erase("");
  return notes.empty() ? "" : fmt::format("{}.", fmt::join(notes, ". "));
}

bool is_hard_set(std::string_view name) { return name.starts_with(kHardPrefix); }

std::string hard_truth(const std::string& set) {
  if (!is_hard_set(set)) return "";
  try {
    const std::optional<HardCase> problem = hard_case(set);
    return problem ? truth_text(*problem) : "";
  } catch (const InputError&) {  // a store may come from another version, with sets and dials of its own
    return "";
  }
}

std::string family_of(const SetSummary& set) {
  if (is_hard_set(set.name)) return set.name.substr(0, set.name.find('/', kHardPrefix.size()));
  if (const auto scene = scene_name(set.name)) return scene->family;
  std::smatch match;
  return std::regex_match(set.name, match, conditioned()) ? match.format("$1*$3") : set.name;
}

bool solves_other_model(const SetSummary& set, const SolverRow& solver) {
  return set.frictional && solver.friction != FrictionModel::kPyramid;
}

std::string solver_label(const Summary& summary, std::size_t solver) {
  const SolverRow& row = summary.solvers[solver];
  if (row.name == "engine" && !row.version.empty()) return lcpbench::solver_label(row.text(), row.version);
  const std::string label = lcpbench::solver_label(row.text());
  const auto namesakes = std::count_if(summary.solvers.begin(), summary.solvers.end(), [&](const SolverRow& other) {
    return other.sweep.empty() && lcpbench::solver_label(other.text()) == label;
  });
  if (namesakes < 2) return lcpbench::solver_label(row.text(), summary.engine);
  if (label != row.text()) return row.text();  // a name that the user gave twice tells nothing apart
  return row.text() + " (" + (row.isa.empty() ? "" : row.isa + ", ") + row.library + " " + row.version + ")";
}

}  // namespace lcpbench::report
