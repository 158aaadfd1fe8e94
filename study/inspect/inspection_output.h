#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "study/inspect/inspection.h"

namespace lcpbench {

/// For people: a line for each fact, then the warnings.
std::string inspection_text(const Inspection& inspection, int width);

/// For programs; fields in docs/reference/inspect.md. What was not computed is null.
nlohmann::ordered_json inspection_json(const Inspection& inspection);

}  // namespace lcpbench
