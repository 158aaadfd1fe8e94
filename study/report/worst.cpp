#include "study/report/worst.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/report/text.h"
#include "study/run/study.h"

namespace lcpbench::report {
namespace {

constexpr std::string_view kFilePrefix = "file:";

bool fails(const Outcome& outcome) {
  return outcome.false_claim || !(outcome.solved || outcome.unsolvable || outcome.refused);
}

}  // namespace

Failure failure_of(const Outcome& outcome) { return {outcome.false_claim, outcome.error}; }

bool Failure::worse_than(const Failure& other) const {
  const auto key = [](const Failure& failure) {
    return std::pair(failure.false_claim, std::isnan(failure.error) ? kInfinity : failure.error);
  };
  return key(*this) > key(other);
}

std::string Failure::text() const {
  if (!false_claim) return "not solved";
  return std::isfinite(error) ? "wrong by " + scientific(error) : "wrong, no number";
}

std::vector<Outcome> worst_outcomes(const Cell& cell, std::size_t most) {
  std::vector<const Outcome*> failed;
  for (const Outcome& outcome : cell.outcomes) {
    if (fails(outcome)) failed.push_back(&outcome);
  }
  const auto worse = [](const Outcome* a, const Outcome* b) { return failure_of(*a).worse_than(failure_of(*b)); };
  std::stable_sort(failed.begin(), failed.end(), worse);
  std::vector<Outcome> worst;
  for (std::size_t i = 0; i < std::min(most, failed.size()); ++i) worst.push_back(*failed[i]);
  return worst;
}

std::string ReplayCommands::command(const Cell& cell, const Outcome& outcome) {
  const std::string& set = summary_.sets[cell.set].name;
  const SolverRow& solver = summary_.solvers[cell.solver];
  if (solver.settings.ends_with(
          kStartLast)) {  // its start is its own answer to the step before: all steps up to this one
    SolverRow cold = solver;
    cold.settings.resize(cold.settings.size() - std::string_view(kStartLast).size());
    if (cold.settings.ends_with(',')) cold.settings.pop_back();
    return fmt::format("lcpbench run --set {} --solver {} --start last --seed {} --trials {} --store again.db",
                       shell_word(set), shell_word(cold.text()), outcome.seed,
                       std::max<std::int64_t>(outcome.trial, 1) + 1);
  }
  const std::string with_solver = " --solver " + shell_word(solver.text());
  if (!set.starts_with(kFilePrefix) || !is_scenes_file(set)) {
    if (solver.name == "engine") return "";
    return fmt::format("lcpbench generate {} --seed {} --first {} --count 1 --out . && lcpbench solve {:06}.json{}",
                       shell_word(set), outcome.seed, outcome.trial, outcome.trial, with_solver);
  }
  const std::string file = set.substr(kFilePrefix.size());
  const auto [opened, first] = files_.try_emplace(file);
  try {
    if (first) opened->second = std::make_unique<ScenesFile>(file);
  } catch (const InputError&) {  // gone, or changed since
  }
  const auto index = static_cast<std::size_t>(outcome.trial);
  if (opened->second == nullptr || index >= opened->second->count()) return "";
  return "lcpbench solve " + shell_word(fmt::format("{}#{}", file, opened->second->step_number(index))) + with_solver;
}

std::string command_text(const std::string& command, const std::string& words, int width) {
  const std::string line = "  " + command + (words.empty() ? "" : "  # " + words);
  if (width == kUnlimited || character_count(line) <= static_cast<std::size_t>(width)) return line + "\n";
  constexpr std::size_t kContinued = 2;  // " \"
  std::string text;
  std::string rest = "  " + command;
  while (character_count(rest) > static_cast<std::size_t>(width)) {
    std::size_t blank = rest.rfind(' ', static_cast<std::size_t>(width) - kContinued);
    if (blank == std::string::npos || blank < 5) blank = rest.find(' ', 5);  // the word alone is longer than the line
    if (blank == std::string::npos) break;
    text += rest.substr(0, blank) + " \\\n";
    rest = "    " + rest.substr(blank + 1);
  }
  return text + rest + "\n";
}

}  // namespace lcpbench::report
