#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/io/scenes_file.h"
#include "study/output/json_output.h"
#include "study/replay/replay.h"

namespace lcpbench {

/// A scene with the files of its replays.
struct ReplayedFiles {
  ReplayedScene scene;
  std::vector<std::unique_ptr<ScenesFile>> frames;  ///< some of the steps, one file for each replay
  std::vector<std::string> names;                   ///< of these files, in the folder's `steps`
};

/// What `replay --format json` and the report's summary.json say of a scene; NaN is null.
Json replay_json(const ReplayedScene& scene);

/// The list of a folder's replays, its file `replays.json`.
std::string replay_list(const std::vector<ReplayedFiles>& scenes);
/// Reads the list and the files that it names. @throws InputError naming the file, also where there is no list
std::vector<ReplayedFiles> read_replays(const std::filesystem::path& folder);

}  // namespace lcpbench
