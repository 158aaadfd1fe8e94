#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/scenes_file.h"
#include "study/report/figures.h"
#include "study/summary/summary.h"

// Sets of captured steps: scene/FAMILY/ENGINE of the collection, and the user's own file:F.scenes.

namespace lcpbench::report {

/// What the decision table has a row for.
enum class SceneKind {
  kRobots,  ///< inertias that couple joints, by whomever they were captured
  kStacks,
  kPiles,
  kOther,
};
inline constexpr std::array kSceneKinds{SceneKind::kRobots, SceneKind::kStacks, SceneKind::kPiles, SceneKind::kOther};

/// "A robot's step", "Stacks and walls", "Piles", "Other scenes".
const char* title(SceneKind kind);

struct SceneName {
  std::string family;  ///< "stack"; of a file its name as a set
  std::string engine;  ///< "ode"; "" for a file
};

/// nullopt for a set that holds no captured steps.
std::optional<SceneName> scene_name(const std::string& set);

/// Who captured the steps of a set, or of "file:F.scenes#120": "mujoco", "Bullet"; "" where nobody
/// knows, as where the set's file is gone.
std::string engine_of(const std::string& set);

/// What to say of false claims of `engine` on steps of an engine that softens contacts; "" where there are none.
std::string soft_engine_note(const Summary& summary);

/// nullopt for a set that holds no captured steps.
std::optional<SceneKind> scene_kind(const SetSummary& set);

/// The sets of one scene, one for each engine.
struct SceneFamily {
  std::string name;
  std::vector<std::size_t> sets;  ///< indices into Summary::sets
};

/// In the order of the summary's sets.
std::vector<SceneFamily> scene_families(const Summary& summary);

/// The scene in the middle of a set's steps from the side, drawn from the shapes and poses of its file. Shapes of a
/// type that the reference does not define are left out.
/// @returns nullopt where the file cannot be read, or has no shapes or no poses.
std::optional<Figure> scene_picture(const std::string& set);

/// Every step of a file from the side, all seen as the first step of `view_of` is. Empty where that cannot be drawn.
std::vector<Figure> filmstrip(const ScenesFile& file, const ScenesFile& view_of);

}  // namespace lcpbench::report
