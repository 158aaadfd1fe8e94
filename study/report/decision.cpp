#include "study/report/decision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "study/report/coverage_text.h"
#include "study/report/sets.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

using Sets = std::vector<std::size_t>;

/// Without the sets that less than half as many solvers met as met the most popular one: those of a sweep or of a
/// special question, which would leave no solver that met all.
Sets widely_met(const Statistics& statistics, Sets sets) {
  std::map<std::size_t, std::size_t> met;
  for (const CellStatistics& cell : statistics.cells) ++met[cell.set];
  std::size_t most = 0;
  for (const std::size_t set : sets) most = std::max(most, met[set]);
  std::erase_if(sets, [&](std::size_t set) { return 2 * met[set] < most; });
  return sets;
}

template <class Wanted>
Sets sets_where(const Summary& summary, Wanted wanted) {
  Sets sets;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    if (wanted(summary.sets[set])) sets.push_back(set);
  }
  return sets;
}

/// Sets of random problems of a kind: those whose problems are all proven solvable, where there are any.
template <class Wanted>
Sets random_sets(const Summary& summary, const Statistics& statistics, Wanted wanted) {
  const Sets solvable = sets_where(summary, [&](const SetSummary& set) { return wanted(set) && set.all_solvable; });
  return widely_met(statistics, solvable.empty() ? sets_where(summary, wanted) : solvable);
}

/// Why no solver of the situation is recommended.
std::string withheld_words(const Summary& summary, const Situation& situation) {
  const Choice& choice = situation.choice;
  if (choice.recommended || choice.contenders.empty()) return "";
  if (too_few(choice.most_solvable, choice.plan_share)) {
    return too_few_text(choice.most_solvable, choice.plan_share) + "; " + few_problems_text(summary, situation);
  }
  const Contender& best = *surest(situation);
  return fmt::format("no solver is shown to be reliable here; the best by share solved, {}, solved {} ({}) of {}",
                     summary.solvers[best.solver].text(), percent(best.solved.value()),
                     percent_range(best.solved.interval()), counted(best.solved.whole, "problem"));
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
    Sets sets = widely_met(statistics, sets_where(summary, [kind = kind](const SetSummary& set) {
      return kind_of(set) == kind;
    }));
    if (!sets.empty()) add(title, std::move(sets));
  }
  const auto of_kind = [&](SetKind kind) {
    return random_sets(summary, statistics, [kind](const SetSummary& set) { return kind_of(set) == kind; });
  };
  add("Frictionless", of_kind(SetKind::kFrictionless));
  add("Frictional", of_kind(SetKind::kFrictional));
  const auto ill_conditioned = [&](bool frictional) {
    return random_sets(summary, statistics, [frictional](const SetSummary& set) {
      return kind_of(set) == SetKind::kIllConditioned && set.frictional == frictional;
    });
  };
  Sets frictional = ill_conditioned(true);
  Sets frictionless = ill_conditioned(false);
  if (!frictional.empty()) {
    add("Ill-conditioned, frictional", std::move(frictional));
  } else {
    add(frictionless.empty() ? "Ill-conditioned" : "Ill-conditioned, frictionless", std::move(frictionless));
  }
  return situations;
}

std::vector<std::size_t> single_solvers(const Summary& summary) {
  std::vector<std::size_t> solvers;
  for (std::size_t solver = 0; solver < summary.solvers.size(); ++solver) {
    if (summary.solvers[solver].sweep.empty()) solvers.push_back(solver);
  }
  return solvers;
}

PooledErrors pooled_errors(const Summary& summary, const std::vector<std::size_t>& sets, std::size_t solver) {
  std::vector<double> errors;
  for (const Cell& cell : summary.cells) {
    if (cell.solver != solver || std::find(sets.begin(), sets.end(), cell.set) == sets.end()) continue;
    errors.insert(errors.end(), cell.errors.begin(), cell.errors.end());
  }
  std::sort(errors.begin(), errors.end());
  return {median(errors), quantile(errors, 0.99)};
}

const Contender* surest(const Situation& situation) {
  const auto worth = [](const Contender& each) {
    const double low = each.solved.interval().low;
    return std::pair(each.ground <= Ground::kWideInterval, std::isnan(low) ? -1.0 : low);
  };
  const Contender* best = nullptr;
  for (const Contender& contender : situation.choice.contenders) {
    if (best == nullptr || worth(contender) > worth(*best)) best = &contender;
  }
  return best;
}

std::vector<const Contender*> without_fault(const Situation& situation) {
  std::int64_t most = 0;
  for (const Contender& contender : situation.choice.contenders) {
    most = std::max(most, contender.false_claims.whole);
  }
  std::vector<const Contender*> faultless;
  for (const Contender& contender : situation.choice.contenders) {
    if (contender.false_claims.whole == most && contender.solved.part == contender.solved.whole &&
        contender.false_claims.part == 0 && std::isfinite(contender.time.value)) {
      faultless.push_back(&contender);
    }
  }
  std::stable_sort(faultless.begin(), faultless.end(),
                   [](const Contender* a, const Contender* b) { return a->time.value < b->time.value; });
  return faultless;
}

std::string few_problems_text(const Summary& summary, const Situation& situation) {
  const std::vector<const Contender*> faultless = without_fault(situation);
  const std::vector<Contender>& contenders = situation.choice.contenders;
  if (faultless.empty()) {
    const Contender& most = *surest(situation);
    const Share& solved = most.solved;
    return fmt::format("no solver solved all of them; the most, {} of {} ({}), did {}", solved.part, solved.whole,
                       percent_range(solved.interval()), summary.solvers[most.solver].text());
  }
  const Contender& fastest = *faultless.front();
  return fmt::format(
      "{} solved by {} of {}, the fastest of them {} in {} on average; that shows a share of at least {} (95 %)",
      fastest.solved.whole == 1 ? "it is" : fmt::format("all {} are", fastest.solved.whole), faultless.size(),
      counted(std::ssize(contenders), "solver"), summary.solvers[fastest.solver].text(), duration(fastest.time.value),
      percent(fastest.solved.interval().low));
}

std::string too_few_text(std::int64_t problems, double plan_share) {
  if (problems < least_problems()) {
    return fmt::format("too few to say: {}; the report needs {}", counted(problems, "problem"), least_problems());
  }
  return fmt::format("too few to say: {}, {} of the plan; the report needs {:g} % of it, or {} problems",
                     counted(problems, "problem"), plan_share_text(plan_share), 100 * kPlanShare, ample_problems());
}

std::vector<std::pair<std::size_t, Share>> caught_solvers(const Summary& summary) {
  std::map<std::size_t, Share> false_claims;
  for (const Cell& cell : summary.cells) {
    if (!summary.solvers[cell.solver].sweep.empty()) continue;
    false_claims[cell.solver].part += cell.false_claims();
    false_claims[cell.solver].whole += cell.trials - cell.count(Claim::kUnsupported);
  }
  std::erase_if(false_claims, [](const auto& entry) { return entry.second.part == 0; });
  std::vector<std::pair<std::size_t, Share>> caught(false_claims.begin(), false_claims.end());
  std::stable_sort(caught.begin(), caught.end(),
                   [](const auto& a, const auto& b) { return a.second.interval().low > b.second.interval().low; });
  return caught;
}

nlohmann::ordered_json reliability_rule_json() {
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
