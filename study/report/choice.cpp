#include "study/report/choice.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <ranges>
#include <tuple>
#include <utility>

namespace lcpbench::report {

namespace {

/// The entry with this key of those in order of their keys; nullptr for none.
template <class Entry, class Key, class KeyOf>
const Entry* find_entry(const std::vector<Entry>& entries, const Key& key, KeyOf key_of) {
  const auto found = std::ranges::lower_bound(entries, key, {}, key_of);
  return found == entries.end() || key_of(*found) != key ? nullptr : &*found;
}

/// The fewest problems for which `enough` holds.
template <class Enough>
std::int64_t fewest(Enough enough) {
  std::int64_t n = 1;
  while (!enough(n)) ++n;
  return n;
}

/// What two solvers did on the problems of the sets that both took, seen from `a`.
PairStatistics::AtError pooled_pair(const Statistics& statistics, const std::vector<std::size_t>& sets,
                                    std::size_t error, std::size_t a, std::size_t b) {
  PairStatistics::AtError pooled;
  for (const std::size_t set : sets) {
    const PairStatistics* pair = statistics.pair(set, std::min(a, b), std::max(a, b));
    if (pair == nullptr) continue;
    const PairStatistics::AtError& at = pair->at[error];
    pooled.only_a += a < b ? at.only_a : at.only_b;
    pooled.only_b += a < b ? at.only_b : at.only_a;
    pooled.wrong_a += a < b ? at.wrong_a : at.wrong_b;
    pooled.wrong_b += a < b ? at.wrong_b : at.wrong_a;
    LogSums ratio = at.ratio;
    if (a > b) ratio.sum = -ratio.sum;
    pooled.ratio += ratio;
  }
  return pooled;
}

bool significantly_more(std::int64_t only_first, std::int64_t only_second) {
  return only_first > only_second && mcnemar_exact(only_first, only_second) < kSignificance;
}

bool has_half_of_most(const Contender& contender, std::int64_t most_taken) {
  return 2 * contender.false_claims.whole >= most_taken;
}

/// A false claim that was seen counts at any number of problems; every other reason to call it unreliable needs
/// least_problems().
/// @param beside_best  what the best and the contender did on the problems that both took; zeros for the best itself
Ground judge(const Contender& contender, const PairStatistics::AtError& beside_best, std::int64_t most_taken,
             double plan_share) {
  const Share& solved = contender.solved;
  const Share& false_claims = contender.false_claims;
  const bool caught = false_claims.part > 0;
  const bool more = significantly_more(beside_best.wrong_b, beside_best.wrong_a);
  if (caught && (more || !(false_claims.interval().high <= kFalseClaimBound))) return Ground::kFalseClaims;
  if (contender.other_model) return Ground::kOtherModel;
  if (!contender.met_all_sets) return Ground::kSomeSets;
  if (!(contender.refused.value() <= kRefusedBound)) return Ground::kRefuses;
  if (std::isnan(contender.time.value)) return Ground::kNoTime;
  if (solved.whole < least_problems()) return Ground::kFewProblems;
  if (!(solved.interval().high >= kReliableShare)) return Ground::kUnsolved;
  if (significantly_more(beside_best.only_a, beside_best.only_b)) return Ground::kBehindTheBest;
  if (!has_half_of_most(contender, most_taken)) return Ground::kSmallSample;
  if (too_few(solved.whole, plan_share)) return Ground::kShortOfPlan;
  if (!(solved.interval().low >= kReliableShare)) return Ground::kWideInterval;
  return Ground::kNone;
}

/// One solver's numbers over the sets; nullopt where it took no problem of them.
std::optional<Contender> pool(const Statistics& statistics, const std::vector<std::size_t>& sets, std::size_t solver,
                              std::size_t error) {
  Contender contender{.solver = solver};
  LogSums time;
  std::size_t sets_met = 0;
  for (const std::size_t set : sets) {
    const CellStatistics* cell = statistics.cell(set, solver);
    if (cell == nullptr) continue;
    contender.refused.part += cell->refused;
    contender.refused.whole += cell->met;
    if (cell->taken() == 0) continue;
    ++sets_met;
    contender.solved.part += cell->solved[error];
    contender.solved.whole += cell->taken() - cell->unsolvable;
    contender.false_claims.part += cell->wrong[error];
    contender.false_claims.whole += cell->taken();
    contender.other_model |= cell->other_model;
    time += cell->time;
    contender.error_p99 = std::fmax(contender.error_p99, cell->error_p99);
  }
  if (sets_met == 0) return std::nullopt;
  contender.met_all_sets = sets_met == sets.size();
  contender.time = time.geometric_mean();
  return contender;
}

/// Of the solvers that may be compared the one whose share solved is the surest to be high; nullptr: there is none.
const Contender* best_of(const std::vector<Contender>& contenders, std::int64_t most_taken) {
  const Contender* best = nullptr;
  for (const Contender& contender : contenders) {
    if (contender.other_model || std::isnan(contender.time.value) || !contender.met_all_sets) continue;
    if (!has_half_of_most(contender, most_taken) || contender.solved.part == 0) continue;
    if (best == nullptr || contender.solved.interval().low > best->solved.interval().low) best = &contender;
  }
  return best;
}

double plan_share(const Statistics& statistics, const std::vector<std::size_t>& sets) {
  SetPlan plan;
  for (const std::size_t set : sets) {
    plan.planned += statistics.plans[set].planned;
    plan.done += statistics.plans[set].done;
  }
  return plan.planned > 0 ? Share{plan.done, plan.planned}.value() : 1;
}

bool may_be_recommended(const Contender& contender) { return contender.reliable() && contender.refused.part == 0; }

}  // namespace

const CellStatistics* Statistics::cell(std::size_t set, std::size_t solver) const {
  return find_entry(cells, std::pair(set, solver), [](const auto& each) { return std::pair(each.set, each.solver); });
}

const PairStatistics* Statistics::pair(std::size_t set, std::size_t a, std::size_t b) const {
  return find_entry(pairs, std::tuple(set, a, b),
                    [](const auto& each) { return std::tuple(each.set, each.a, each.b); });
}

double Share::value() const { return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : kNoNumber; }

std::int64_t least_problems() {
  static const std::int64_t least = fewest([](std::int64_t n) { return wilson(n, n).low >= kReliableShare; });
  return least;
}

std::int64_t ample_problems() {
  static const std::int64_t ample = fewest([](std::int64_t n) { return wilson(0, n).high <= kFalseClaimBound; });
  return ample;
}

bool too_few(std::int64_t problems, double plan_share) {
  return problems < least_problems() || (plan_share < kPlanShare && problems < ample_problems());
}

const char* to_string(Ground ground) {
  constexpr std::array kNames{"reliable",     "false_claims",  "unsolved",      "behind_the_best",
                              "few_problems", "small_sample",  "short_of_plan", "wide_interval",
                              "other_model",  "no_time",       "some_sets",     "refuses"};
  static_assert(kNames.size() == static_cast<std::size_t>(Ground::kRefuses) + 1);
  return kNames[static_cast<std::size_t>(ground)];
}

Choice choose(const Statistics& statistics, const std::vector<std::size_t>& sets,
              const std::vector<std::size_t>& solvers, std::size_t error) {
  Choice choice;
  choice.plan_share = plan_share(statistics, sets);
  std::int64_t most_taken = 0;
  std::vector<Contender>& contenders = choice.contenders;
  for (const std::size_t solver : solvers) {
    const std::optional<Contender> contender = pool(statistics, sets, solver, error);
    if (!contender) continue;
    contenders.push_back(*contender);
    most_taken = std::max(most_taken, contender->false_claims.whole);
    choice.most_solvable = std::max(choice.most_solvable, contender->solved.whole);
  }
  const Contender* best = best_of(contenders, most_taken);
  for (Contender& contender : contenders) {
    PairStatistics::AtError beside_best;
    if (best != nullptr && &contender != best) {
      beside_best = pooled_pair(statistics, sets, error, best->solver, contender.solver);
    }
    contender.ground = judge(contender, beside_best, most_taken, choice.plan_share);
  }
  const auto or_last = [](double value) { return std::isnan(value) ? kInfinity : value; };
  std::ranges::sort(contenders, {}, [&](const Contender& each) {
    return std::tuple(or_last(-each.sure_share()), or_last(each.time.value), each.solver);
  });
  const auto chosen = std::ranges::min_element(contenders, {}, [](const Contender& each) {
    return may_be_recommended(each) ? each.time.value : kInfinity;
  });
  if (chosen == contenders.end() || !may_be_recommended(*chosen)) return choice;
  choice.recommended = true;
  std::rotate(contenders.begin(), chosen, chosen + 1);
  for (Contender& contender : contenders | std::views::drop(1)) {
    const LogSums ratio = pooled_pair(statistics, sets, error, contenders.front().solver, contender.solver).ratio;
    contender.factor = {ratio.geometric_mean(), ratio.n};
    contender.tie = may_be_recommended(contender) && contender.false_claims.part == 0 && contender.factor.shown() &&
                    is_tie_in_time(contender.factor.ratio);
  }
  return choice;
}

}  // namespace lcpbench::report
