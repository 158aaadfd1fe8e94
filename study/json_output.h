#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/types.h"

namespace lcpbench {

/// JSON has no NaN and no infinity: both become null.
inline nlohmann::ordered_json json_number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

/// An array of numbers; null for an empty vector.
inline nlohmann::ordered_json json_vector(const Vector& vector) {
  if (vector.size() == 0) return nullptr;
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (const double value : vector) array.push_back(json_number(value));
  return array;
}

/// A count; null for -1, which stands for one that is not known.
inline nlohmann::ordered_json json_count(std::int64_t count) {
  return count >= 0 ? nlohmann::ordered_json(count) : nlohmann::ordered_json(nullptr);
}

/// Prints one document to stdout. Text that is not UTF-8 (a foreign library's message) is replaced, not refused.
inline void print_json(const nlohmann::ordered_json& document) {
  fmt::print("{}\n", document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

}  // namespace lcpbench
