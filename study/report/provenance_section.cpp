#include "study/report/provenance_section.h"

#include <algorithm>

#include <fmt/format.h>

#include "study/report/html_table.h"
#include "study/report/text.h"
#include "study/output/text_table.h"

namespace lcpbench::report {

namespace {

std::string json_text(const nlohmann::ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

bool holds_only_scalars(const nlohmann::ordered_json& value) {
  return std::none_of(value.begin(), value.end(), [](const auto& member) { return member.is_structured(); });
}

/// "library Bullet, version 3.24"
std::string members_in_line(const nlohmann::ordered_json& object) {
  std::string line;
  for (const auto& [key, member] : object.items()) line += (line.empty() ? "" : ", ") + key + " " + json_text(member);
  return line;
}

/// One row per member; objects inside are taken apart, down to those that fit in one row.
void add_provenance_rows(const std::string& name, const nlohmann::ordered_json& value, std::string& rows) {
  const bool nested = !name.empty();
  if (value.is_object() && !value.empty() && !(nested && holds_only_scalars(value))) {
    for (const auto& [key, member] : value.items()) {
      add_provenance_rows(nested ? name + "." + key : key, member, rows);
    }
    return;
  }
  const std::string text = value.is_object() ? members_in_line(value) : json_text(value);
  rows += "<tr><th scope=\"row\" class=\"line\">" + escape(name) + "</th><td>" + code(text) + "</td></tr>\n";
}

std::string full_record(const RunSummary& run) {
  std::string rows;
  nlohmann::ordered_json provenance = run.provenance;
  if (provenance.is_object()) provenance.erase("planned");  // the plan says the same to people
  add_provenance_rows("", provenance, rows);
  return "<details><summary>The full record of the run of " + escape(run.started) +
         "</summary><div class=\"scroll\" tabindex=\"0\"><table><tbody>\n" + rows + kTableEnd + "</details>\n";
}

std::string joined(const std::vector<std::string>& values) {
  std::string text;
  for (const std::string& value : values) text += (text.empty() ? "" : "; ") + escape(value);
  return text;
}

/// "2026-01-31 12:00 UTC" of "2026-01-31T12:00:00Z"; other texts as they are.
std::string minute_of(const std::string& started) {
  const bool known = started.size() == 20 && started[10] == 'T' && started.back() == 'Z';
  return known ? started.substr(0, 10) + " " + started.substr(11, 5) + " UTC" : started;
}

std::string when(const Summary& summary) {
  const std::string first = minute_of(summary.runs.front().started);
  const std::string last = minute_of(summary.runs.back().started);
  if (summary.runs.size() == 1) return escape(first);
  return fmt::format("{} runs, begun from {} to {}", summary.runs.size(), escape(first), escape(last));
}

std::string size_words(const Summary& summary) {
  std::int64_t problems = 0;
  std::int64_t answers = 0;
  for (const SetSummary& set : summary.sets) problems += set.problems;
  for (const Cell& cell : summary.cells) answers += cell.trials;
  return fmt::format("{} problems of {}, {} solvers and settings, {} answers", format_count(problems),
                     counted(std::ssize(summary.sets), "set"), format_count(std::ssize(summary.solvers)),
                     format_count(answers));
}

std::string fact(const char* name, const std::string& value) {
  return std::string("<tr><th scope=\"row\" class=\"line\">") + name + "</th><td>" + value + "</td></tr>\n";
}

std::string facts(const Summary& summary) {
  const auto recorded = [&summary](const char* name) { return joined(recorded_values(summary, name)); };
  return "<div class=\"scroll\" tabindex=\"0\"><table class=\"facts\"><tbody>\n" + fact("When", when(summary)) +
         fact("How much", size_words(summary)) +
         fact("Machine", recorded("processor") + ", cores: " + recorded("cores") + ", " + recorded("os")) +
         fact("Instruction-set level", recorded("isa")) +
         fact("Compiler", recorded("compiler") + ", " + recorded("build_type")) +
         fact("lcpbench", recorded("lcpbench") + ", commit " + recorded("commit")) + fact("Seed", recorded("seed")) +
         fact("To repeat it", code(recorded_values(summary, "command").back())) + kTableEnd;
}

/// Solvers that a run left out, "name: reason", each once.
std::vector<std::string> skipped_solvers(const Summary& summary) {
  std::vector<std::string> skipped;
  for (const RunSummary& run : summary.runs) {
    if (!run.provenance.is_object()) continue;
    const auto list = run.provenance.find("skipped");
    if (list == run.provenance.end() || !list->is_array()) continue;
    for (const auto& entry : *list) {
      const std::string text = json_text(entry);
      if (std::find(skipped.begin(), skipped.end(), text) == skipped.end()) skipped.push_back(text);
    }
  }
  return skipped;
}

std::string skipped_list(const Summary& summary) {
  std::string items;
  for (const std::string& entry : skipped_solvers(summary)) {
    const std::size_t colon = entry.find(": ");
    items += "<li>" + code(entry.substr(0, colon));
    if (colon != std::string::npos) items += ": " + escape(entry.substr(colon + 2));
    items += "</li>\n";
  }
  return items.empty() ? "" : "<p>Solvers left out of a run:</p>\n<ul>\n" + items + "</ul>\n";
}

}  // namespace

std::string recorded_value(const RunSummary& run, const char* name) {
  const bool present = run.provenance.is_object() && run.provenance.contains(name);
  return present ? json_text(run.provenance[name]) : "not recorded";
}

std::vector<std::string> recorded_values(const Summary& summary, const char* name) {
  std::vector<std::string> values;
  for (const RunSummary& run : summary.runs) {
    const std::string value = recorded_value(run, name);
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }
  return values;
}

std::string provenance_section(const Summary& summary) {
  std::string section = "<section id=\"provenance\"><h2>Provenance</h2>\n";
  if (summary.runs.empty()) return section + "<p>The store records no run.</p>\n</section>\n";
  section += facts(summary) + skipped_list(summary) + full_record(summary.runs.back());
  if (summary.runs.size() > 1) {
    section += "<p class=\"note\">The records of all runs are in <code>summary.json</code>, "
               "<code>provenance.runs</code>.</p>\n";
  }
  return section + "</section>\n";
}

}  // namespace lcpbench::report
