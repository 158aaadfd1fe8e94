#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/scenes_file.h"

namespace lcpbench {

/// Captured scenes whose names begin so are held out: nothing may be fitted to them.
constexpr std::string_view kHeldOutScenes = "scene/robot/";

/// A file of generators/scenes/FAMILY/ENGINE.scenes, whose bytes are part of the program.
struct CollectedScene {
  std::string name;  ///< "scene/FAMILY/ENGINE"
  std::string_view bytes;
};

/// In the order of their names.
const std::vector<CollectedScene>& collected_scenes();

/// The file, opened once and shared. Thread-safe.
std::shared_ptr<const ScenesFile> open_collected(const CollectedScene& scene);

}  // namespace lcpbench
