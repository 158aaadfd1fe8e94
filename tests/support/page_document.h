#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace lcpbench {

/// The document in a page of `report`, `compare`, `view` or `replay`. @throws nlohmann::json::exception for none
inline nlohmann::json document_of(const std::string& page) {
  constexpr std::string_view kBegin = "id=\"report\">";
  const std::size_t at = page.find(kBegin) + kBegin.size();
  return nlohmann::json::parse(page.substr(at, page.find("</script>", at) - at));
}

}  // namespace lcpbench
