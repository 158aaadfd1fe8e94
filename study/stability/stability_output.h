#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "study/stability/stability.h"

namespace lcpbench {

/// For people: the solvers and changes under which they break or their answers move too far, the gravest first, then
/// the number of such solvers. kAnswerLines at most, unless names are very long. @param all  every solver and change
std::string stability_text(const StabilityResult& result, bool all, int width);

/// For programs: an array with an object for each change and solver that was asked.
nlohmann::ordered_json stability_json(const StabilityResult& result);

}  // namespace lcpbench
