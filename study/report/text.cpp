#include "study/report/text.h"

#include <cmath>
#include <map>

#include <fmt/format.h>

#include "core/utf8.h"
#include "study/output/explanation.h"
#include "study/output/text_table.h"
#include "study/report/sets.h"

namespace lcpbench::report {

namespace {

constexpr const char* kAbsent = "–";

std::string percent_number(double share) {
  const double value = 100 * share;
  if (value <= 0) return "0";
  if (value >= 100) return "100";
  if (value < 0.01) return "<0.01";
  if (value > 99.99) return ">99.99";
  if (value < 1 || value > 99.9) return fmt::format("{:.2f}", value);
  return fmt::format("{:.1f}", value);
}

bool allowed_in_xml(unsigned char c) { return (c >= 0x20 && c != 0x7f) || c == '\n' || c == '\t'; }

}  // namespace

std::string percent(double share) { return std::isfinite(share) ? percent_number(share) + " %" : kAbsent; }

std::string percent_range(const Interval& interval) {
  if (!std::isfinite(interval.low) || !std::isfinite(interval.high)) return kAbsent;
  return percent_number(interval.low) + "–" + percent_number(interval.high) + " %";
}

std::string duration(double seconds) { return std::isfinite(seconds) ? format_seconds(seconds) : kAbsent; }

std::string factor(double value) {
  if (!std::isfinite(value)) return kAbsent;
  if (value < 1) return fmt::format("{:.2g}", value);
  if (value < 999.5) return three_digits(value);
  const double step = std::pow(10, std::floor(std::log10(value)) - 2);
  return fmt::format("{:.0f}", std::round(value / step) * step);
}

std::string scientific(double value) {
  if (std::isnan(value)) return kAbsent;
  if (std::isinf(value)) return "no number";
  return value == 0 ? "0" : fmt::format("{:.1e}", value);
}

std::string counted(std::int64_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string mended(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    const bool kept = length > 1 || (length == 1 && allowed_in_xml(static_cast<unsigned char>(text[at])));
    out += kept ? text.substr(at, length) : "\uFFFD";
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

std::string truth_text(const Summary& summary) {
  std::int64_t nearly = 0;
  double least = kInfinity;
  for (const SetSummary& set : summary.sets) {
    nearly += set.nearly;
    least = std::fmin(least, set.least_violation_m_per_s);
  }
  std::string text;
  if (nearly > 0) {
    text = fmt::format("{} nearly solvable: {}.", counted(nearly, "problem") + (nearly == 1 ? " is" : " are"),
                       nearly_words(least > 0 ? least : kNoNumber));
  }
  std::map<std::string, std::int64_t> denied;
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    if (cell.false_unsolvable > 0 && solver.sweep.empty()) denied[solver.text()] += cell.false_unsolvable;
  }
  std::string names;
  for (const auto& [solver, count] : denied) {
    names += fmt::format("{} {} on {}", names.empty() ? "" : ";", solver, counted(count, "problem"));
  }
  if (names.empty()) return text;
  return text + (text.empty() ? "" : " ") + "Said unsolvable, and there is a solution:" + names + ".";
}

std::vector<std::string> notes(const Summary& summary) {
  std::vector<std::string> notes{soft_engine_note(summary), truth_text(summary)};
  std::erase(notes, "");
  return notes;
}

std::string file_stem(std::string_view name) {
  std::string stem;
  for (const char c : name) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-';
    if (plain) stem += c;
    if (!plain && !stem.empty() && stem.back() != '_') stem += '_';
  }
  while (!stem.empty() && (stem.front() == '.' || stem.front() == '-')) stem.erase(0, 1);
  while (!stem.empty() && stem.back() == '_') stem.pop_back();
  return stem.empty() ? "set" : stem.substr(0, 100);
}

}  // namespace lcpbench::report
