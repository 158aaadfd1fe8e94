#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "core/problem.h"

namespace lcpbench {

/// {"name", "kind", "n", "ngc", "nc", "edges"}, as every document about single problems has it: the last three null for
/// a bare LCP. A problem without a name is called after its file.
nlohmann::ordered_json problem_summary_json(const Problem& problem, const std::string& file);

/// "box.json: contact, n 5, 6 coordinates, 5 contacts, 0 friction edges".
std::string problem_summary_text(const Problem& problem, const std::string& file);

}  // namespace lcpbench
