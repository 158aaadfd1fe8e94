#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/scenes_file.h"
#include "study/output/text_table.h"
#include "study/report/hard.h"
#include "study/report/report.h"
#include "study/report/sets.h"
#include "study/report/text.h"

namespace lcpbench {
namespace {

using Align = TextTable::Align;

// ---------------------------------------------------------------------------------------------------- the answer

constexpr std::size_t kMostDetail = 3;      ///< of a situation: see parts_of
constexpr std::size_t kHardSolvers = 8;     ///< that are right on the most hard cases
constexpr std::size_t kCaughtByName = 4;    ///< solvers with false claims
constexpr const char* kBullet = "bullet_";  ///< how the names of a library's solvers begin
constexpr const char* kOde = "ode_";

using report::Contender;
using report::Report;
using report::Situation;

/// "3.10x (2.70–3.50) n=240", or without enough problems "- (4 of 25)".
std::string factor_text(const report::Factor& factor) {
  if (!factor.shown()) return fmt::format("- ({} of {})", factor.problems, factor.of);
  return fmt::format("{}x ({}–{}) n={}", report::factor(factor.ratio.value), report::factor(factor.ratio.low),
                     report::factor(factor.ratio.high), factor.problems);
}

/// Of a library's solvers the one that most surely solves a large share of what it took; nullptr where none took these problems.
const Contender* best_of_library(const Summary& summary, const Situation& situation, const char* library) {
  const Contender* best = nullptr;
  for (const Contender& contender : situation.choice.contenders) {
    if (!summary.solvers[contender.solver].name.starts_with(library)) continue;
    const auto low = [](const Contender& each) { return each.solved.interval().low; };
    if (best == nullptr || low(contender) > low(*best)) best = &contender;
  }
  return best;
}

/// The reliable ones that are more accurate than every faster one, the recommended one aside; the fastest first.
std::vector<const Contender*> more_accurate(const Summary& summary, const Situation& situation) {
  const auto p99 = [&](const Contender& contender) {
    return report::pooled_errors(summary, situation.sets, contender.solver).p99;
  };
  std::vector<const Contender*> reliable;
  for (const Contender& contender : situation.choice.contenders) {
    if (contender.reliable() && contender.refused.part == 0) reliable.push_back(&contender);
  }
  std::stable_sort(reliable.begin(), reliable.end(),
                   [](const Contender* a, const Contender* b) { return a->time.value < b->time.value; });
  std::vector<const Contender*> chosen;
  double least = p99(situation.choice.contenders.front());
  for (const Contender* contender : reliable) {
    const double error = p99(*contender);
    if (!(error < least)) continue;
    least = error;
    chosen.push_back(contender);
  }
  return chosen;
}

/// What is shown of one situation: a word for the part that a solver plays in it, and the solver.
/// Detail 0: the solver to use; 1: beside it the best of each library; above: so many more accurate ones too, less one.
using Parts = std::vector<std::pair<std::string, const Contender*>>;

Parts parts_of(const Summary& summary, const Situation& situation, std::size_t detail) {
  Parts parts;
  const auto add = [&parts](const char* word, const Contender* contender) {
    const bool known = std::any_of(parts.begin(), parts.end(), [&](const auto& part) {
      return contender == nullptr || part.second->solver == contender->solver;
    });
    if (contender != nullptr && !known) parts.emplace_back(word, contender);
  };
  if (situation.choice.contenders.empty()) return parts;
  add(situation.choice.recommended ? "use" : "(leads)",
      situation.choice.recommended ? situation.recommended() : report::surest(situation));
  if (situation.choice.recommended && detail > 1) {
    const std::vector<const Contender*> accurate = more_accurate(summary, situation);
    for (std::size_t i = 0; i < std::min(accurate.size(), detail - 1); ++i) add("accurate", accurate[i]);
  }
  if (detail == 0) return parts;
  add("Bullet", best_of_library(summary, situation, kBullet));
  add("ODE", best_of_library(summary, situation, kOde));
  return parts;
}

std::string situations_table(const Report& report, std::size_t detail, int width) {
  TextTable table({{"contacts", Align::kLeft, 0, 12},
                   {"", Align::kLeft, 0, 8},
                   {"solver", Align::kLeft, 0, 14},
                   {"solved"},
                   {"95 %"},
                   {"wrong", Align::kRight, 2},
                   {"time", Align::kRight, 1},
                   {"times as long", Align::kLeft, 0, 12},
                   {"error 99 %", Align::kRight, 3}});
  for (const Situation& situation : report.situations) {
    std::string title = situation.title;
    const Parts parts = parts_of(report.summary, situation, detail);
    for (const auto& part : parts) {
      const Contender& contender = *part.second;
      const report::Share& refused = contender.refused;
      const std::size_t first = parts.front().second->solver;
      table.add_row({std::exchange(title, ""), part.first,
                     report.summary.solvers[contender.solver].text() +
                         (refused.part > 0 ? fmt::format(" (refused {} of {})", refused.part, refused.whole) : ""),
                     report::percent(contender.solved.value()), report::percent_range(contender.solved.interval()),
                     report::percent(contender.false_claims.value()), report::duration(contender.time.value),
                     &part == &parts.front() ? "1"
                                             : factor_text(report::time_factor(report.statistics, situation.sets, 0,
                                                                               first, contender.solver)),
                     report::scientific(
                         report::pooled_errors(report.summary, situation.sets, contender.solver).p99)});
    }
  }
  if (table.empty()) return "";
  const std::string words = fmt::format(
      "solved: of what it took. wrong: said solved, and was not. time: geometric mean. times as long: as the first "
      "solver, on the n problems that both solved (95 %); below {} a dash and how many of how many.\n",
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
std::string reservations_text(const Report& report, int width) {
  std::string text;
  for (const Situation& situation : report.situations) {
    const report::Choice& choice = situation.choice;
    if (choice.recommended || choice.contenders.empty()) continue;
    if (!report::too_few(choice.most_solvable, choice.plan_share)) {
      text += situation.title + ": no solver is shown to be reliable\n";
      continue;
    }
    const std::int64_t most = choice.most_solvable;
    const std::string few = most >= report::least_problems()
                                ? report::too_few_text(most, choice.plan_share) + " to call a solver reliable"
                                : fmt::format("{} too few to call a solver reliable, which takes {}{}",
                                              most == 1 ? "1 problem is" : fmt::format("{} problems are", most),
                                              report::least_problems(),
                                              more_problems_hint(report.summary.sets[situation.sets.front()].name));
    text += fmt::format("{}: {}; {}\n", situation.title, report::few_problems_text(report.summary, situation), few);
  }
  return folded(text, width);
}

std::string caught_text(const Summary& summary, int width) {
  const auto caught = report::caught_solvers(summary);
  const std::string truths = report::truth_text(summary);
  const std::string last = truths.empty() ? "" : folded(truths + "\n", width);
  if (caught.empty()) return "said solved, and was wrong: nobody\n" + last;
  std::string text = "said solved, and was wrong:";
  for (std::size_t i = 0; i < std::min(caught.size(), kCaughtByName); ++i) {
    const auto& [solver, share] = caught[i];
    text += fmt::format("{} {} on {} of {}", i > 0 ? ";" : "", report::solver_label(summary, solver), format_count(share.part),
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
                                      : factor_text({cell.time_ratio, cell.paired,
                                                     cell.trials - cell.count(Claim::kUnsupported)}),
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

std::string answer_text(const Report& report, int width, std::size_t lines) {
  const Summary& summary = report.summary;
  if (summary.cells.empty()) return "no answers yet\n";
  const std::string end = reservations_text(report, width) + caught_text(summary, width);
  if (situations_table(report, 0, width).empty()) {
    const std::string none = folded("no solver is recommended: that takes random contact problems\n", width);
    return fitting_text(kHardSolvers, lines,
                        [&](std::size_t rows) { return report::hard_text(summary, width, rows) + none + end; });
  }
  return fitting_text(kMostDetail, lines,
                      [&](std::size_t detail) { return situations_table(report, detail, width) + end; });
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
  const std::string hard = report::hard_text(summary, width) + report::hard_words(summary, width);
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
