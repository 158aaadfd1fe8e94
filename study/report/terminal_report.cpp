#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "study/output/text_table.h"
#include "study/report/decision.h"
#include "study/report/hard.h"
#include "study/report/reliability.h"
#include "core/error.h"
#include "core/io/scenes_file.h"
#include "study/report/report.h"
#include "study/report/scenes.h"
#include "study/report/solver_comparison.h"
#include "study/report/text.h"
#include "study/report/worst.h"

namespace lcpbench {
namespace {

using Align = TextTable::Align;

// ---------------------------------------------------------------------------------------------------- the answer

constexpr std::size_t kMostDetail = 3;      ///< of a situation: see parts_of
constexpr std::size_t kHardSolvers = 8;     ///< that are right on the most hard cases
constexpr std::size_t kCaughtByName = 4;    ///< solvers with false claims
constexpr const char* kBullet = "bullet_";  ///< how the names of a library's solvers begin
constexpr const char* kOde = "ode_";

/// A situation with what its solvers did on each problem.
struct Compared {
  const report::Situation& situation;
  std::vector<report::Record> records;

  const report::Record& record(const report::Contender& contender) const {
    return *std::find_if(records.begin(), records.end(),
                         [&](const report::Record& each) { return each.solver == contender.solver; });
  }
};

/// Of a library's solvers the one that solves the largest share of what it met; nullptr where none took these problems.
const report::Contender* best_of_library(const Summary& summary, const report::Situation& situation,
                                         const char* library) {
  const report::Contender* best = nullptr;
  for (const report::Contender& contender : situation.contenders) {
    if (!summary.solvers[contender.solver].name.starts_with(library)) continue;
    if (best == nullptr || contender.solved_of_met.value() > best->solved_of_met.value()) best = &contender;
  }
  return best;
}

/// The reliable ones that are more accurate than every faster one, the fastest first.
std::vector<const report::Contender*> frontier(const report::Situation& situation) {
  std::vector<const report::Contender*> reliable;
  for (const report::Contender& contender : situation.contenders) {
    if (contender.reliability.reliable() && contender.refused.part == 0 && std::isfinite(contender.p99_error) &&
        std::isfinite(contender.time.value)) {
      reliable.push_back(&contender);
    }
  }
  std::stable_sort(reliable.begin(), reliable.end(), [](const report::Contender* a, const report::Contender* b) {
    return a->time.value < b->time.value;
  });
  std::vector<const report::Contender*> chosen;
  for (const report::Contender* contender : reliable) {
    if (chosen.empty() || contender->p99_error < chosen.back()->p99_error) chosen.push_back(contender);
  }
  return chosen;
}

/// What is shown of one situation: a word for the part that a solver plays in it, and the solver.
/// Detail 0: the solver to use; 1: beside it the best of each library; above: so many more accurate ones too, less one.
using Parts = std::vector<std::pair<std::string, const report::Contender*>>;

Parts parts_of(const Summary& summary, const report::Situation& situation, std::size_t detail) {
  Parts parts;
  const auto add = [&parts](const char* word, const report::Contender* contender) {
    const bool known = std::any_of(parts.begin(), parts.end(), [&](const auto& part) {
      return contender == nullptr || part.second->solver == contender->solver;
    });
    if (contender != nullptr && !known) parts.emplace_back(word, contender);
  };
  if (situation.contenders.empty()) return parts;
  const bool recommended = situation.recommended.has_value();
  add(recommended ? "use" : "(leads)", &situation.contenders[situation.recommended.value_or(0)]);
  if (recommended) {
    std::size_t shown = 0;
    for (const report::Contender* contender : frontier(situation)) {
      const bool better = contender->p99_error < parts.front().second->p99_error;
      if (better && shown++ + 1 < detail) add("accurate", contender);
    }
  }
  if (detail == 0) return parts;
  add("Bullet", best_of_library(summary, situation, kBullet));
  add("ODE", best_of_library(summary, situation, kOde));
  return parts;
}

std::string situations_table(const Summary& summary, const std::vector<Compared>& situations, std::size_t detail,
                             int width) {
  TextTable table({{"contacts", Align::kLeft, 0, 12},
                   {"", Align::kLeft, 0, 8},
                   {"solver", Align::kLeft, 0, 14},
                   {"solved"},
                   {"95 %"},
                   {"wrong", Align::kRight, 2},
                   {"time", Align::kRight, 1},
                   {"times as long", Align::kLeft, 0, 12},
                   {"error 99 %", Align::kRight, 3}});
  for (const Compared& compared : situations) {
    const report::Situation& situation = compared.situation;
    std::string title = situation.title;
    const Parts parts = parts_of(summary, situation, detail);
    const auto record = [&](const auto& part) -> const report::Record& { return compared.record(*part.second); };
    for (const auto& part : parts) {
      const report::Contender* const contender = part.second;
      const report::Share& solved = contender->solved_of_met;
      const report::Share& refused = contender->refused;
      table.add_row({std::exchange(title, ""), part.first,
                     summary.solvers[contender->solver].text() +
                         (refused.part > 0 ? fmt::format(" (refused {} of {})", refused.part, refused.whole) : ""),
                     report::percent(solved.value()), report::percent_range(solved.interval()),
                     report::percent(contender->false_claims.value()), report::duration(contender->time.value),
                     &part == &parts.front() ? "1" : report::time_ratio(record(part), record(parts.front())).text(),
                     report::scientific(contender->p99_error)});
    }
  }
  if (table.empty()) return "";
  const std::string words = fmt::format(
      "solved: of all it met, refused ones too. wrong: said solved, and was not. time: median. times as long: as the "
      "first solver, on the n problems that both solved (95 %); below {} a dash and how many of how many.\n",
      report::least_problems());
  return table.text(width) + folded(words, width);
}

/// How a user gets enough problems: of random ones, or of captured steps. "" where the set has no more, or its file is
/// gone.
std::string more_problems_hint(const std::string& set) {
  const auto wanted = report::least_problems();
  const std::optional<report::SceneName> scene = report::scene_name(set);
  if (!scene) return set.starts_with("file:") ? "" : fmt::format("; run with --trials {}", wanted);
  if (!scene->engine.empty()) return "";
  try {
    const ScenesFile file(set.substr(set.find(':') + 1));
    const auto count = static_cast<std::int64_t>(file.count());
    if (count < 2) return "";
    const std::int64_t spacing = file.step_number(1) - file.step_number(0);
    const std::int64_t range = file.step_number(file.count() - 1) - file.step_number(0) + spacing;
    std::int64_t every = spacing;
    while (every > 1 && range / every < wanted) every /= 2;
    if (range / every < wanted) return "; capture more steps";
    return fmt::format("; capture --every {} gives {} steps", every, range / every);
  } catch (const InputError&) {
    return "";
  }
}

/// What can be said of each kind of contacts that has no recommendation, and what to add.
std::string reservations_text(const Summary& summary, const std::vector<Compared>& situations, int width) {
  std::string text;
  for (const Compared& compared : situations) {
    const report::Situation& situation = compared.situation;
    if (situation.recommended || situation.contenders.empty()) continue;
    std::int64_t most = 0;
    for (const report::Contender& contender : situation.contenders) most = std::max(most, contender.solved.whole);
    const double share = report::plan_share(summary, situation.sets);
    if (!report::too_few(most, share)) {
      text += situation.title + ": no solver is shown to be reliable\n";
      continue;
    }
    const std::string few = most >= report::least_problems()
                                ? report::too_few_text(most, share) + " to call a solver reliable"
                                : fmt::format("{} too few to call a solver reliable, which takes {}{}",
                                              most == 1 ? "1 problem is" : fmt::format("{} problems are", most),
                                              report::least_problems(),
                                              more_problems_hint(summary.sets[situation.sets.front()].name));
    text += fmt::format("{}: {}; {}\n", situation.title, report::few_problems_text(summary, situation), few);
  }
  return folded(text, width);
}

/// The solvers that are right on the most hard cases.
std::string hard_table(const Summary& summary, std::size_t rows, int width) {
  const report::HardStudy study = report::hard_study(summary);
  struct Tally {
    std::size_t solver = 0;
    std::int64_t right = 0, wrong = 0, denied = 0, refused = 0, rest = 0;
  };
  std::vector<Tally> tallies;
  for (std::size_t column = 0; column < study.solvers.size(); ++column) {
    Tally tally{.solver = study.solvers[column]};
    for (const report::HardCaseRow& row : study.rows) {
      const report::HardOutcome outcome = row.cells[column].outcome;
      if (outcome == report::HardOutcome::kNotRun) continue;
      ++(report::is_right(outcome)                            ? tally.right
         : outcome == report::HardOutcome::kFalseClaim        ? tally.wrong
         : outcome == report::HardOutcome::kWronglyUnsolvable ? tally.denied
         : outcome == report::HardOutcome::kRefused           ? tally.refused
                                                              : tally.rest);
    }
    tallies.push_back(tally);
  }
  std::stable_sort(tallies.begin(), tallies.end(), [](const Tally& a, const Tally& b) { return a.right > b.right; });
  TextTable table({{report::counted(std::ssize(study.rows), "hard case"), Align::kLeft},
                   {"right"},
                   {"said solved, was wrong"},
                   {"denied a solution", Align::kRight, 1},
                   {"no answer"},
                   {"refused", Align::kRight, 2}});
  for (std::size_t i = 0; i < std::min(rows, tallies.size()); ++i) {
    const Tally& tally = tallies[i];
    table.add_row({solver_label(summary, tally.solver), format_count(tally.right), format_count(tally.wrong),
                   format_count(tally.denied), format_count(tally.rest), format_count(tally.refused)});
  }
  if (table.empty()) return "";
  const std::string more =
      tallies.size() > rows ? fmt::format("and {} more solvers: --long shows them\n", tallies.size() - rows) : "";
  return table.text(width) + more;
}

std::string caught_text(const Summary& summary, int width) {
  const auto caught = report::caught_solvers(summary);
  const std::string truths = report::truth_text(summary);
  const std::string last = truths.empty() ? "" : folded(truths + "\n", width);
  if (caught.empty()) return "said solved, and was wrong: nobody\n" + last;
  std::string text = "said solved, and was wrong:";
  for (std::size_t i = 0; i < std::min(caught.size(), kCaughtByName); ++i) {
    const auto& [solver, share] = caught[i];
    text += fmt::format("{} {} on {} of {}", i > 0 ? ";" : "", solver_label(summary, solver), format_count(share.part),
                        format_count(share.whole));
  }
  if (caught.size() > kCaughtByName) text += fmt::format("; and {} more solvers", caught.size() - kCaughtByName);
  const std::string note = report::soft_engine_note(summary);
  return folded(text + "\n" + note + (note.empty() ? "" : "\n"), width) + last;
}

// ------------------------------------------------------------------------------------------------ all the results

std::vector<std::string> result_row(const Summary& summary, const Cell& cell) {
  const SolverRow& solver = summary.solvers[cell.solver];
  std::string name = "  " + solver.text();
  if (cell.trials < summary.sets[cell.set].problems) name += fmt::format(" n={}", cell.trials);
  const auto of_trials = [&cell](std::int64_t count) {
    return report::percent(report::Share{count, cell.trials}.value());
  };
  const bool is_reference = solver.text() == summary.reference;
  return {name,
          report::percent(cell.rate()),
          report::percent_range(cell.rate_interval),
          of_trials(cell.false_claims()),
          of_trials(cell.gave_up()),
          of_trials(cell.count(Claim::kUnsupported)),
          report::duration(cell.median_time.value),
          is_reference                ? "1"
          : summary.reference.empty() ? "-"
                                      : report::over_reference(cell).text(),
          std::isinf(cell.error_p99) ? "none" : report::scientific(cell.error_p99)};
}

std::string sweep_line(const SweepSummary& sweep) {
  return fmt::format("  {} sweep {} ({} cells): worst {}, average {}, best {}; by the paper's criterion {} / {} / {}",
                     sweep.solver, sweep.sweep, sweep.parameterisations, report::percent(sweep.verdict.worst),
                     report::percent(sweep.verdict.average), report::percent(sweep.verdict.best),
                     report::percent(sweep.criterion.worst), report::percent(sweep.criterion.average),
                     report::percent(sweep.criterion.best));
}

void add_set(const Summary& summary, std::size_t set, TextTable& table) {
  table.add_line(fmt::format("{}, {}", summary.sets[set].name, report::counted(summary.sets[set].problems, "problem")));
  for (const Cell& cell : summary.cells) {
    if (cell.set != set || !summary.solvers[cell.solver].sweep.empty()) continue;
    if (cell.refused()) {
      table.add_line(fmt::format("  {} does not take these: {}", summary.solvers[cell.solver].text(), cell.refusal));
    } else {
      table.add_row(result_row(summary, cell));
    }
  }
  for (const SweepSummary& sweep : summary.sweeps) {
    if (sweep.set == set) table.add_line(sweep_line(sweep));
  }
}

}  // namespace

std::string answer_text(const Summary& summary, int width, std::size_t lines) {
  if (summary.cells.empty()) return "no answers yet\n";
  const std::vector<report::Situation> decided = report::decide(summary);
  std::vector<Compared> situations;
  for (const report::Situation& situation : decided) {
    if (!situation.contenders.empty()) {
      situations.push_back({situation, report::judged_records(summary, situation.sets)});
    }
  }
  const std::string end = reservations_text(summary, situations, width) + caught_text(summary, width);
  if (situations.empty()) {
    const std::string none = folded("no solver is recommended: that takes random contact problems\n", width);
    return fitting_text(kHardSolvers, lines,
                        [&](std::size_t rows) { return hard_table(summary, rows, width) + none + end; });
  }
  return fitting_text(kMostDetail, lines,
                      [&](std::size_t detail) { return situations_table(summary, situations, detail, width) + end; });
}

std::string table_text(const Summary& summary, int width) {
  if (summary.cells.empty()) return "no answers yet\n";
  TextTable table({{"", Align::kLeft, 0, 20},
                   {"solved"},
                   {"95 %", Align::kLeft, 3, 12},
                   {"wrong"},
                   {"gave up"},
                   {"refused", Align::kRight, 4},
                   {"median"},
                   {"ratio", Align::kLeft, 2},
                   {"err 99%", Align::kRight, 1}});
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    if (!report::is_hard_set(summary.sets[set].name)) add_set(summary, set, table);
  }
  const std::string hard = report::hard_text(summary, width);
  if (table.empty()) return hard;
  std::string words =
      "solved: verified here. wrong: said solved, was not. refused: of those given up, outside what the solver takes. "
      "median: set-up and solve, CPU. err 99%: of the answers said to be solved; none: too many of them are not "
      "finite, or not of the right length.\n";
  if (!summary.reference.empty()) {
    words += fmt::format("ratio: time over that of {}, on the n problems that both solved; a dash below {}.\n",
                         summary.reference, report::least_problems());
  }
  return table.text(width) + hard + folded(words, width);
}

}  // namespace lcpbench
