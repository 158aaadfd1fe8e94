#include "study/report/worst.h"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "generators/scenes/scenes.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/report/text.h"
#include "study/run/study.h"

namespace lcpbench::report {
namespace {

constexpr std::string_view kFilePrefix = "file:";
constexpr std::size_t kContinuationIndent = 4;

bool fails(const Outcome& outcome) {
  return outcome.false_claim() || !(outcome.solved() || outcome.unsolvable() || outcome.refused());
}

/// The last gap between two words at `most` or before it, else the first one; npos where there is none. Blanks within
/// the quotes of shell_word() are no gaps.
std::size_t gap_between_words(const std::string& command, std::size_t most) {
  std::size_t gap = std::string::npos;
  bool quoted = false;
  bool escapes = true;  // a backslash takes the next character, except within '...'
  for (std::size_t i = 0; i < command.size() && (i <= most || gap == std::string::npos); ++i) {
    if (command[i] == '\\' && escapes) {
      ++i;
    } else if (command[i] == '\'') {
      quoted = !quoted;
      escapes = !quoted || (i > 0 && command[i - 1] == '$');
    } else if (command[i] == ' ' && !quoted && i > kContinuationIndent) {
      gap = i;
    }
  }
  return gap;
}

}  // namespace

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

std::vector<FailedProblem> worst_problems(const Cell& cell, std::span<const ProblemKey> problems, std::size_t most) {
  std::vector<FailedProblem> failed;
  for (const Outcome& outcome : cell.outcomes) {
    if (!fails(outcome)) continue;
    failed.push_back(
        {problems[outcome.problem], {outcome.false_claim(), outcome.error}, outcome.claim, outcome.time_s});
  }
  std::ranges::stable_sort(failed, &Failure::worse_than, &FailedProblem::failure);
  failed.resize(std::min(most, failed.size()));
  failed.shrink_to_fit();
  return failed;
}

/// " --time-limit 2"; "" where no run recorded a plan with this field.
std::string ReplayCommands::option(const char* name, const char* field) const {
  const nlohmann::json::json_pointer place(std::string("/plan/") + field);
  for (const RunSummary& run : summary_.runs | std::views::reverse) {
    if (run.provenance.contains(place)) return fmt::format(" {} {}", name, shell_word(run.provenance[place].dump()));
  }
  return "";
}

std::string ReplayCommands::command(const Cell& cell, const FailedProblem& failed) {
  const ProblemKey& problem = failed.problem;
  const std::string& set = summary_.sets[cell.set].name;
  const SolverRow& solver = summary_.solvers[cell.solver];
  if (solver.settings.ends_with(
          kStartLast)) {  // its start is its own answer to the step before: all steps up to this one
    SolverRow cold = solver;
    cold.settings.resize(cold.settings.size() - std::string_view(kStartLast).size());
    if (cold.settings.ends_with(',')) cold.settings.pop_back();
    return fmt::format("lcpbench run --set {} --solver {} --start last --seed {} --trials {} --store again.db{}",
                       shell_word(set), shell_word(cold.text()), problem.seed,
                       std::max<std::int64_t>(problem.trial, 1) + 1, option("--solved-at", "solved_at"));
  }
  const std::string with_solver = " --solver " + shell_word(solver.text()) + option("--solved-at", "solved_at") +
                                  (failed.claim == Claim::kTimeLimit ? option("--time-limit", "time_limit_s") : "");
  if (!set.starts_with(kFilePrefix) || !is_scenes_file(set)) {
    const auto captured = std::ranges::find(collected_scenes(), set, &CollectedScene::name);
    if (captured != collected_scenes().end()) {
      const std::shared_ptr<const ScenesFile> steps = open_collected(*captured);
      const auto index = static_cast<std::size_t>(problem.trial);
      if (index >= steps->count()) return "";  // of another version of the program
      return "lcpbench solve " + shell_word(fmt::format("{}#{}", set, steps->step_number(index))) + with_solver;
    }
    if (solver.name == "engine") return "";
    if (problem.seed == 1 && !set.starts_with(kFilePrefix)) {
      return "lcpbench solve " + shell_word(fmt::format("{}#{}", set, problem.trial)) + with_solver;
    }
    return fmt::format("lcpbench generate {} --seed {} --first {} --count 1 --out . && lcpbench solve {:06}.json{}",
                       shell_word(set), problem.seed, problem.trial, problem.trial, with_solver);
  }
  const std::string file = set.substr(kFilePrefix.size());
  const auto [opened, first] = files_.try_emplace(file);
  try {
    if (first) opened->second = std::make_unique<ScenesFile>(file);
  } catch (const InputError&) {  // gone, or changed since
  }
  const auto index = static_cast<std::size_t>(problem.trial);
  if (opened->second == nullptr || index >= opened->second->count()) return "";
  const std::string step = fmt::format("{}#{}", file_argument(file), opened->second->step_number(index));
  return "lcpbench solve " + shell_word(step) + with_solver;
}

std::string command_text(const std::string& command, const std::string& words, int width) {
  const std::string line = "  " + command + (words.empty() ? "" : "  # " + words);
  if (width == kUnlimited || character_count(line) <= static_cast<std::size_t>(width)) return line + "\n";
  constexpr std::size_t kContinued = 2;  // " \"
  std::string text;
  std::string rest = "  " + command;
  while (character_count(rest) > static_cast<std::size_t>(width)) {
    const std::size_t blank = gap_between_words(rest, static_cast<std::size_t>(width) - kContinued);
    if (blank == std::string::npos) break;
    text += rest.substr(0, blank) + " \\\n";
    rest = std::string(kContinuationIndent, ' ') + rest.substr(blank + 1);
  }
  return text + rest + "\n";
}

}  // namespace lcpbench::report
