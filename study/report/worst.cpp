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
#include "study/report/report.h"
#include "study/report/text.h"

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
  if (solver.settings.ends_with("start=last")) return "";  // `solve` knows no step before
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

std::string worst_text(const Report& report, std::size_t rows, int width) {
  struct Worst {
    const Cell* cell = nullptr;
    const Outcome* outcome = nullptr;
  };
  std::map<std::size_t, Worst> by_solver;
  for (std::size_t i = 0; i < report.worst.size(); ++i) {
    if (report.worst[i].empty()) continue;
    const Outcome& outcome = report.worst[i].front();
    Worst& worst = by_solver[report.summary.cells[i].solver];
    if (worst.outcome == nullptr || failure_of(outcome).worse_than(failure_of(*worst.outcome))) {
      worst = {&report.summary.cells[i], &outcome};
    }
  }
  if (by_solver.empty() || rows == 0) return "";
  std::vector<Worst> worst;
  for (const auto& [solver, each] : by_solver) worst.push_back(each);
  std::stable_sort(worst.begin(), worst.end(), [](const Worst& a, const Worst& b) {
    return failure_of(*a.outcome).worse_than(failure_of(*b.outcome));
  });
  ReplayCommands replay(report.summary);
  std::string commands;
  std::size_t shown = 0;
  for (const Worst& each : worst) {
    const std::string command = replay.command(*each.cell, *each.outcome);
    if (shown == rows) break;
    if (command.empty()) continue;
    commands += command_text(command, failure_of(*each.outcome).text(), width);
    ++shown;
  }
  std::string text = shown > 0 ? "each solver's worst problem:\n" + commands : "";
  if (shown < worst.size()) {
    text += folded(fmt::format("and {} more: see the report\n", worst.size() - shown),
                   width);
  }
  return text;
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
