#include "study/report/scenes.h"

#include <algorithm>

#include "core/error.h"
#include "core/io/scenes_file.h"
#include "study/output/explanation.h"

namespace lcpbench::report {

const char* title(SceneKind kind) {
  switch (kind) {
    case SceneKind::kRobots: return "A robot's step";
    case SceneKind::kStacks: return "Stacks and walls";
    case SceneKind::kPiles: return "Piles";
    case SceneKind::kOther: return "Other scenes";
  }
  return "";
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
  const auto step = scenes_step(file);
  const std::optional<SceneName> name = scene_name(set);
  if (!step && (!name || !name->engine.empty())) return name ? name->engine : "";
  try {
    return ScenesFile(step ? step->first : file).header().engine;
  } catch (const InputError&) {
    return "";
  }
}

std::string soft_engine_note(const Summary& summary) {
  for (const Cell& cell : summary.cells) {
    if (summary.solvers[cell.solver].name != "engine" || cell.false_claims() == 0) continue;
    if (const std::string words = soft_engine_words(engine_of(summary.sets[cell.set].name)); !words.empty()) {
      return words + ".";
    }
  }
  return "";
}

std::optional<SceneKind> scene_kind(const SetSummary& set) {
  constexpr std::array<std::string_view, 3> kStacked{"stack", "card-house", "wall"};
  const std::optional<SceneName> name = scene_name(set.name);
  if (!name) return std::nullopt;
  if (!set.free_bodies) return SceneKind::kRobots;
  if (std::find(kStacked.begin(), kStacked.end(), name->family) != kStacked.end()) return SceneKind::kStacks;
  return name->family.ends_with("-pile") ? SceneKind::kPiles : SceneKind::kOther;
}

std::vector<SceneFamily> scene_families(const Summary& summary) {
  std::vector<SceneFamily> families;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    const std::optional<SceneName> name = scene_name(summary.sets[set].name);
    if (!name) continue;
    const auto known = std::find_if(families.begin(), families.end(),
                                    [&name](const SceneFamily& family) { return family.name == name->family; });
    if (known == families.end()) {
      families.push_back({name->family, {set}});
    } else {
      known->sets.push_back(set);
    }
  }
  return families;
}

}  // namespace lcpbench::report
