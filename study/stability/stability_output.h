#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "study/stability/stability.h"

namespace lcpbench {

/// For people: what stays solved, how far answers move, how pivots spread, and who breaks, by name.
std::string stability_text(const StabilityResult& result);

/// For programs: an array with an object for each transformation and solver that was asked; fields in
/// docs/howto/stability.md.
nlohmann::ordered_json stability_json(const StabilityResult& result);

}  // namespace lcpbench
