#pragma once

#include <string>
#include <vector>

#include "study/replay/replay_folder.h"

namespace lcpbench {

/// The section of the report: the sentences, and for each scene, folded, what the page has. "" without scenes.
std::string replay_section(const std::vector<ReplayPictures>& scenes);

/// A page of HTML that needs nothing else: for each scene the conclusion, the measures, a filmstrip and the curves.
std::string replay_page(const std::vector<ReplayPictures>& scenes, const std::string& command_line);

}  // namespace lcpbench
