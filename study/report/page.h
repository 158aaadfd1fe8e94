#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace lcpbench::report {

/// The page of study/report/page with a document in it, of docs/schema/report.schema.json: one file of HTML that needs
/// nothing else. No text of the document ends the element that holds it.
std::string page_html(const nlohmann::ordered_json& document);

}  // namespace lcpbench::report
