#include "study/report/text.h"

#include <cmath>
#include <map>
#include <regex>

#include <fmt/format.h>

#include "study/output/columns.h"
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

constexpr std::size_t kSetsOnTheTerminal = 4;
constexpr const char* kUnknown =
    "How much of its plan this store covers is not known: a run in it recorded no plan, as runs of earlier versions "
    "did not.";

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
    if (cell.false_unsolvable > 0 && solver.sweep.empty())
      denied[lcpbench::solver_label(solver.text())] += cell.false_unsolvable;
  }
  std::string names;
  for (const auto& [solver, count] : denied) {
    names += fmt::format("{} {} on {}", names.empty() ? "" : ";", solver, counted(count, "problem"));
  }
  if (names.empty()) return text;
  return text + (text.empty() ? "" : " ") + "Said unsolvable, and there is a solution:" + names + ".";
}

std::string difference_text(const Summary& summary) {
  std::string text;
  for (const auto& [what, count] : summary.differences) {
    text += fmt::format("{} {}: {}", text.empty() ? "" : ";", printable(what), count);
  }
  if (text.empty()) return "";
  return fmt::format("{} from the steps that {} took, counted over all:{}.",
                     counted(summary.differing, "captured problem") + (summary.differing == 1 ? " differs" : " differ"),
                     summary.differing == 1 ? "its engine" : "their engines", text);
}

std::vector<std::string> notes(const Summary& summary) {
  std::vector<std::string> notes{soft_engine_note(summary), truth_text(summary), difference_text(summary)};
  std::erase(notes, "");
  return notes;
}

std::string file_stem(const std::string& name) {
  static const std::regex others("[^A-Za-z0-9.-]+");
  static const std::regex ends("^[._-]+|_+$");
  const std::string stem = std::regex_replace(std::regex_replace(name, others, "_"), ends, "");
  return stem.empty() ? "set" : stem.substr(0, 100);
}

std::string plan_share_text(double share) {
  const auto whole = static_cast<int>(std::floor(100 * share));
  return whole == 0 && share > 0 ? "<1 %" : fmt::format("{} %", whole);
}

std::string coverage_text(const Coverage& coverage) {
  if (!coverage.known) return std::string(kUnknown) + "\n";
  if (!coverage.incomplete()) return "";
  std::string text = fmt::format("INCOMPLETE: {} of the plan ({} of {} cells)", plan_share_text(coverage.share()),
                                 format_count(coverage.done), format_count(coverage.planned));
  std::string remedy;
  for (const auto& [line, missing] : coverage.left_out) {
    remedy += fmt::format("{} planned cells are missing, and not failures, since a run left out {}\n",
                          format_count(missing), line);
  }
  remedy +=
      "To complete it, repeat the lcpbench run that wrote it; where it was run in shards, merge their stores.\n";
  const std::vector<Coverage::Set> thin = coverage.thin_sets();
  if (thin.empty()) return text + "\n" + remedy;
  text += fmt::format("; {} of {} sets are thin:\n", thin.size(), coverage.sets.size());
  const std::size_t shown = thin.size() <= kSetsOnTheTerminal ? thin.size() : kSetsOnTheTerminal - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    text += fmt::format("  {:>5}  {}\n", plan_share_text(thin[i].share()), thin[i].name);
  }
  if (shown < thin.size()) text += fmt::format("  and {} more sets\n", thin.size() - shown);
  return text + remedy;
}

}  // namespace lcpbench::report
