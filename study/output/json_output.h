#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/types.h"
#include "core/utf8.h"

namespace lcpbench {

/// JSON whose members keep their order.
using Json = nlohmann::ordered_json;

/// A number; null for NaN and infinities, which JSON does not have.
inline Json json_number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// The value; null where there is none.
template <class Value>
Json json_optional(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

/// An array of numbers; null for an empty vector that stands for none.
inline Json json_vector(const Vector& vector, bool is_given = false) {
  if (vector.size() == 0 && !is_given) return nullptr;
  Json array = Json::array();
  for (const double value : vector) array.push_back(json_number(value));
  return array;
}

/// A count; null for a negative one, which stands for "not known".
inline Json json_count(std::int64_t count) {
  return count >= 0 ? Json(count) : Json(nullptr);
}

/// Prints one document to stdout, indented. Bytes that are not UTF-8 (of a foreign library's message) become U+FFFD.
/// Characters that cannot be seen are escaped (see visible()), also those that JSON allows and terminals obey.
inline void print_json(const Json& document) {
  fmt::print("{}\n", visible(document.dump(2, ' ', false, Json::error_handler_t::replace)));
}

}  // namespace lcpbench
