#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/io/scenes_file.h"
#include "study/output/json_output.h"

namespace lcpbench {

/// A number for a picture; null for NaN and infinity.
inline Json view_number(double value, int digits = 6) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.{}g}", value, digits).c_str(), nullptr);
}

template <class Numbers>
Json view_row(const Numbers& numbers, int digits = 6) {
  Json array = Json::array();
  for (const double value : numbers) array.push_back(view_number(value, digits));
  return array;
}

/// Whether the shape is of a type that docs/reference/scenes-file.md defines.
inline bool is_drawn(const SceneShape& shape) {
  constexpr std::pair<std::string_view, std::size_t> kSizes[] = {
      {"sphere", 1}, {"capsule", 2}, {"cylinder", 2}, {"box", 3}, {"plane", 4}};
  if (shape.type == "hull") return shape.fault().empty();
  return std::any_of(std::begin(kSizes), std::end(kSizes), [&](const auto& known) {
    return known.first == shape.type && known.second == shape.size.size();
  });
}

inline Json shape_json(const SceneShape& shape) {
  return {{"body", shape.body}, {"type", shape.type}, {"size", view_row(shape.size)}};
}

}  // namespace lcpbench
