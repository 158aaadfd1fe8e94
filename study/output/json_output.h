#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

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

/// Prints one document to stdout. Text that is not UTF-8 (a foreign library's message) is replaced, not refused. The
/// control characters that JSON lets stand (U+007F to U+009F) are escaped as the others are.
inline void print_json(const nlohmann::ordered_json& document) {
  const std::string text = document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string shown;
  shown.reserve(text.size() + 1);
  for (std::size_t at = 0; at < text.size(); ++at) {
    const bool two_bytes = text[at] == '\xC2' && static_cast<unsigned char>(text[at + 1]) < 0xA0;
    if (two_bytes) ++at;
    if (two_bytes || text[at] == '\x7F') {
      shown += fmt::format("\\u{:04x}", static_cast<unsigned char>(text[at]));
    } else {
      shown += text[at];
    }
  }
  fmt::print("{}\n", shown);
}

}  // namespace lcpbench
