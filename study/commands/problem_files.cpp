#include "study/commands/problem_files.h"

#include <fmt/format.h>

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

std::string problem_summary_text(const Problem& problem, const std::string& file) {
  std::string text = fmt::format("{}: {}, n {}", printable(file), to_string(problem.kind()), problem.size());
  if (const ContactProblem* contact = problem.contact()) {
    text += fmt::format(", {} coordinates, {} contacts, {} friction edges", contact->ngc(), contact->nc(),
                        cols(contact->D));
  }
  return text;
}

}  // namespace lcpbench
