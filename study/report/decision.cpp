#include "study/report/decision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/scenes_file.h"
#include "study/report/sets.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

using Sets = std::vector<std::size_t>;

/// Without the sets that less than half as many solvers met as met the most popular one: those of a sweep or of a
/// special question, which would leave no solver that met all.
Sets widely_met(const Statistics& statistics, Sets sets) {
  std::map<std::size_t, std::size_t> met;
  for (const CellStatistics& cell : statistics.cells) {
    if (cell.taken() > 0) ++met[cell.set];
  }
  std::size_t most = 0;
  for (const std::size_t set : sets) most = std::max(most, met[set]);
  std::erase_if(sets, [&](std::size_t set) { return 2 * met[set] < most; });
  return sets;
}

/// The sets of a kind. Of random problems those whose problems are all proven solvable, where there are any.
/// @param frictional  tells ill-conditioned sets apart
Sets sets_of(const Summary& summary, const Statistics& statistics, SetKind kind, bool frictional = false) {
  Sets sets;
  Sets solvable;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    const SetSummary& each = summary.sets[set];
    if (kind_of(each) != kind || (kind == SetKind::kIllConditioned && each.frictional != frictional)) continue;
    sets.push_back(set);
    if (each.all_solvable && !scene_name(each.name)) solvable.push_back(set);
  }
  return widely_met(statistics, solvable.empty() ? sets : solvable);
}

/// How a user gets enough problems: of random ones, or of captured steps. "" where the set has no more, or its file is
/// gone.
std::string more_problems_hint(const Summary& summary, const Situation& situation) {
  const std::string& set = summary.sets[situation.sets.front()].name;
  const auto wanted = least_problems();
  const std::optional<SceneName> scene = scene_name(set);
  if (!scene && set.starts_with("file:")) return "";
  if (!scene) {
    std::int64_t last = 0;
    for (const std::size_t each : situation.sets) last = std::max(last, summary.sets[each].last_trial);
    // Where the solvers leave out trials, or problems have no solution, fewer count than there are trials.
    const std::int64_t others = std::max<std::int64_t>(situation.choice.most_solvable - 1, 1);
    const std::int64_t as_dense = 1 + (last * (wanted - 1) + others - 1) / others;
    const std::int64_t sets = std::ssize(situation.sets);
    return fmt::format("; run with --trials {}", std::max((wanted + sets - 1) / sets, as_dense));
  }
  if (!scene->engine.empty()) return "";
  try {
    const ScenesFile file(set.substr(set.find(':') + 1));
    if (file.count() < 2) return "";
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

/// Of problems that all have no solution: who said so most often.
std::string unsolvable_words(const Summary& summary, const Situation& situation) {
  std::map<std::size_t, std::int64_t> rightly;  // by solver
  std::int64_t problems = 0;
  for (const std::size_t set : situation.sets) problems += summary.sets[set].problems;
  for (const Contender& each : situation.choice.contenders) rightly[each.solver] = 0;
  for (const Cell& cell : summary.cells) {
    if (std::ranges::find(situation.sets, cell.set) == situation.sets.end()) continue;
    const auto solver = rightly.find(cell.solver);
    if (solver != rightly.end()) solver->second += cell.count(Claim::kUnsolvable, Verdict::kUnsolvable);
  }
  const auto best = std::ranges::max_element(rightly, {}, &std::pair<const std::size_t, std::int64_t>::second);
  return fmt::format("every problem is proven to have no solution; {}",
                     best->second == 0 ? "no solver said so"
                                       : fmt::format("{} said so of {} of {}", solver_label(summary, best->first),
                                                     best->second, counted(problems, "problem")));
}

/// Why no solver of the situation is recommended, and who solved most surely.
std::string withheld_words(const Summary& summary, const Situation& situation) {
  const Choice& choice = situation.choice;
  if (choice.recommended || choice.contenders.empty()) return "";
  const std::int64_t most = choice.most_solvable;
  if (most == 0) return unsolvable_words(summary, situation);
  std::string words = "no solver is shown to be reliable here";
  if (most < least_problems()) {
    words = fmt::format("too few to say: {}; the report needs {}{}", counted(most, "problem"), least_problems(),
                        more_problems_hint(summary, situation));
  } else if (too_few(most, choice.plan_share)) {
    words =
        fmt::format("too few to say: {}, {} of the plan; the report needs {:g} % of it, or {} problems",
                    counted(most, "problem"), plan_share_text(choice.plan_share), 100 * kPlanShare, ample_problems());
  }
  const auto low = [](const Contender& each) {  // who was caught with false claims comes last
    return std::pair(each.ground != Ground::kFalseClaims, std::fmax(each.sure_share(), -1));
  };
  const Contender& best = *std::ranges::max_element(choice.contenders, {}, low);
  return words + fmt::format("; the best by share solved, {}, solved {} ({}) of {}{}", solver_label(summary, best.solver),
                             percent(best.solved.value()), percent_range(best.solved.interval()),
                             counted(best.solved.whole, "problem"),
                             best.refused.part > 0 ? fmt::format(", and refused {}", best.refused.part) : "");
}

}  // namespace

std::vector<Situation> decide(const Summary& summary, const Statistics& statistics) {
  std::vector<Situation> situations;
  const std::vector<std::size_t> solvers = single_solvers(summary);
  const auto add = [&](const char* title, Sets sets) {
    Situation situation{title, std::move(sets), {}, ""};
    situation.choice = choose(statistics, situation.sets, solvers, 0);
    situation.withheld = withheld_words(summary, situation);
    situations.push_back(std::move(situation));
  };
  constexpr std::array<std::pair<SetKind, const char*>, 4> kScenes{{{SetKind::kRobots, "A robot's step"},
                                                                    {SetKind::kStacks, "Stacks and walls"},
                                                                    {SetKind::kPiles, "Piles"},
                                                                    {SetKind::kScenes, "Other scenes"}}};
  for (const auto& [kind, title] : kScenes) {
    Sets sets = sets_of(summary, statistics, kind);
    if (!sets.empty()) add(title, std::move(sets));
  }
  add("Frictionless", sets_of(summary, statistics, SetKind::kFrictionless));
  add("Frictional", sets_of(summary, statistics, SetKind::kFrictional));
  Sets frictional = sets_of(summary, statistics, SetKind::kIllConditioned, true);
  Sets frictionless = sets_of(summary, statistics, SetKind::kIllConditioned, false);
  const bool none = frictional.empty() && frictionless.empty();
  if (!frictional.empty()) add("Ill-conditioned, frictional", std::move(frictional));
  if (!frictionless.empty()) add("Ill-conditioned, frictionless", std::move(frictionless));
  if (none) add("Ill-conditioned", {});
  return situations;
}

std::vector<std::size_t> single_solvers(const Summary& summary) {
  std::vector<std::size_t> solvers;
  for (std::size_t solver = 0; solver < summary.solvers.size(); ++solver) {
    if (summary.solvers[solver].sweep.empty()) solvers.push_back(solver);
  }
  return solvers;
}

Json reliability_rule_json() {
  return {{"least_problems", least_problems()},
          {"solved_low_at_least", kReliableShare},
          {"false_claims_high_at_most", kFalseClaimBound},
          {"refused_at_most", kRefusedBound},
          {"sample_at_least", 0.5},
          {"plan_at_least", kPlanShare},
          {"ample_problems", ample_problems()},
          {"interval", 0.95},
          {"paired_test_level", kSignificance}};
}

}  // namespace lcpbench::report
