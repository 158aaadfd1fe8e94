#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "study/stability/stability.h"

namespace lcpbench {

/// For people: the most serious cases of solvers that break or whose answers move too far, then their number.
/// kAnswerLines at most, unless names are very long.
std::string stability_answer(const StabilityResult& result, int width);

/// For people, in full: problems still solved, changes of answers, spread of pivots, and the solvers that break.
std::string stability_text(const StabilityResult& result, int width);

/// For programs: an array with an object for each transformation and solver that was asked; fields in
/// docs/howto/stability.md.
nlohmann::ordered_json stability_json(const StabilityResult& result);

}  // namespace lcpbench
