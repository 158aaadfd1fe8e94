#include "study/commands/problem_files.h"

#include <fmt/format.h>

#include "study/output/json_output.h"
#include "study/output/text_table.h"

namespace lcpbench {

nlohmann::ordered_json problem_summary_json(const Problem& problem, const std::string& file) {
  const ContactProblem* contact = problem.contact();
  nlohmann::ordered_json json = {{"name", problem.name().empty() ? file : problem.name()},
                                 {"kind", to_string(problem.kind())},
                                 {"n", problem.size()},
                                 {"ngc", nullptr},
                                 {"nc", nullptr},
                                 {"edges", nullptr}};
  if (contact != nullptr) {
    json["ngc"] = contact->ngc();
    json["nc"] = contact->nc();
    json["edges"] = contact->edges;
  }
  return json;
}

nlohmann::ordered_json errors_json(const Errors& errors) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Metric& metric : kMetrics) json[metric.name] = json_number(errors.*metric.value);
  json["worst_row"] = errors.worst.row < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(errors.worst.row);
  return json;
}

std::string problem_summary_text(const Problem& problem, const std::string& file) {
  std::string text = fmt::format("{}: {}, n {}", printable(file), to_string(problem.kind()), problem.size());
  if (const ContactProblem* contact = problem.contact()) {
    text += fmt::format(", {}, {}, {}", counted_noun(static_cast<std::size_t>(contact->ngc()), "coordinate"),
                        counted_noun(static_cast<std::size_t>(contact->nc()), "contact"),
                        counted_noun(static_cast<std::size_t>(cols(contact->D)), "friction edge"));
  }
  return text;
}

}  // namespace lcpbench
