#include "study/report/solver_comparison.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>


namespace lcpbench {

namespace {

/// The outcomes of a set's solvers side by side: null where a solver did not meet a problem.
struct OutcomeTable {
  std::vector<const Cell*> cells;  ///< one column each
  std::vector<std::int64_t> problems;
  std::vector<std::vector<const Outcome*>> columns;  ///< [cell][problem]
};

OutcomeTable outcome_table(const Summary& summary, std::size_t set) {
  OutcomeTable table;
  std::set<std::int64_t> problems;
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    if (cell.set != set || !solver.sweep.empty() || cell.refused()) continue;
    if (solves_other_model(summary.sets[set], solver)) continue;  // its problems are others
    if (std::isnan(cell.median_time.value)) continue;             // nobody measured its times
    table.cells.push_back(&cell);
    for (const Outcome& outcome : cell.outcomes) problems.insert(outcome.problem);
  }
  table.problems.assign(problems.begin(), problems.end());
  for (const Cell* cell : table.cells) {
    std::vector<const Outcome*>& column = table.columns.emplace_back(table.problems.size(), nullptr);
    std::size_t row = 0;
    for (const Outcome& outcome : cell->outcomes) {
      while (table.problems[row] < outcome.problem) ++row;
      column[row] = &outcome;
    }
  }
  return table;
}

bool took(const Outcome* outcome) { return outcome != nullptr && !outcome->refused; }

ComparedPair count_pair(const OutcomeTable& table, std::size_t a, std::size_t b) {
  ComparedPair pair{.first = table.cells[a]->solver, .second = table.cells[b]->solver};
  for (std::size_t row = 0; row < table.problems.size(); ++row) {
    const Outcome* first = table.columns[a][row];
    const Outcome* second = table.columns[b][row];
    if (!took(first) || !took(second) || first->unsolvable != second->unsolvable) continue;  // both are right
    pair.solved.add(first->solved, second->solved);
  }
  pair.p = pair.solved.p_value();
  return pair;
}

std::vector<ComparedPair> count_pairs(const OutcomeTable& table) {
  std::vector<ComparedPair> pairs;
  std::vector<double> p_values;
  for (std::size_t a = 0; a < table.cells.size(); ++a) {
    for (std::size_t b = a + 1; b < table.cells.size(); ++b) {
      const ComparedPair pair = count_pair(table, a, b);
      if (pair.solved.problems() == 0) continue;
      pairs.push_back(pair);
      p_values.push_back(pair.p);
    }
  }
  const std::vector<double> corrected = holm(p_values);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].p_holm = corrected[i];
  return pairs;
}

SolverTimes times_of(const Cell& cell, double time_limit_s) {
  std::vector<double> all_times;
  std::vector<double> solved_times;
  for (const Outcome& outcome : cell.outcomes) {
    if (!std::isnan(outcome.time_s)) all_times.push_back(outcome.time_s);
    if (outcome.solved) solved_times.push_back(outcome.time_s);
  }
  SolverTimes times{.solver = cell.solver, .problems = cell.solvable(), .solved = cell.count(Verdict::kSolved)};
  times.timed = static_cast<std::int64_t>(all_times.size());
  times.median = cell.median_time;
  times.geometric_mean = shifted_geometric_mean(all_times, kTimeShift);
  times.par10 = par10(solved_times, times.problems - times.solved, time_limit_s);
  return times;
}

Distribution distribution_of(const Cell& cell) {
  Distribution distribution{.solver = cell.solver, .problems = 0, .times_s = {}, .errors = {}};
  for (const Outcome& outcome : cell.outcomes) {
    if (outcome.unsolvable) continue;
    ++distribution.problems;
    distribution.errors.push_back(outcome.error);
    if (outcome.solved) distribution.times_s.push_back(outcome.time_s);
  }
  return distribution;
}

/// Ratios of times to the faster of two on one problem; infinite for who did not solve it.
struct PairRatios {
  std::vector<double> first;
  std::vector<double> second;
};

PairRatios pair_ratios(const OutcomeTable& table, std::size_t a, std::size_t b) {
  PairRatios ratios;
  for (std::size_t row = 0; row < table.problems.size(); ++row) {
    const Outcome* first = table.columns[a][row];
    const Outcome* second = table.columns[b][row];
    if (!took(first) || !took(second) || first->unsolvable || second->unsolvable) continue;
    const double time_a = first->solved ? first->time_s : kInfinity;
    const double time_b = second->solved ? second->time_s : kInfinity;
    if (std::isnan(time_a) || std::isnan(time_b)) continue;
    const double least = std::min(time_a, time_b);
    ratios.first.push_back(first->solved ? time_a / least : kInfinity);
    ratios.second.push_back(second->solved ? time_b / least : kInfinity);
  }
  return ratios;
}

PairProfile profile_of(const OutcomeTable& table, std::size_t column, std::size_t against) {
  const PairRatios ratios = pair_ratios(table, column, against);
  PairProfile profile{.solver = table.cells[column]->solver, .against = table.cells[against]->solver};
  profile.problems = static_cast<std::int64_t>(ratios.first.size());
  const std::vector<double> first = ecdf(ratios.first, profile.problems, kProfileFactors);
  const std::vector<double> second = ecdf(ratios.second, profile.problems, kProfileFactors);
  std::copy(first.begin(), first.end(), profile.solver_shares.begin());
  std::copy(second.begin(), second.end(), profile.against_shares.begin());
  return profile;
}

std::vector<PairProfile> profiles_against(const OutcomeTable& table, std::size_t solver) {
  std::vector<PairProfile> profiles;
  const auto base = std::find_if(table.cells.begin(), table.cells.end(),
                                 [solver](const Cell* cell) { return cell->solver == solver; });
  if (base == table.cells.end()) return profiles;
  const auto against = static_cast<std::size_t>(base - table.cells.begin());
  for (std::size_t column = 0; column < table.cells.size(); ++column) {
    if (column != against) profiles.push_back(profile_of(table, column, against));
  }
  return profiles;
}

std::vector<PairProfile> make_profiles(const Summary& summary, const OutcomeTable& table,
                                       std::optional<std::size_t> recommended) {
  std::vector<PairProfile> profiles;
  bool reference_is_recommended = false;
  for (const Cell* cell : table.cells) {
    if (summary.reference.empty() || summary.solvers[cell->solver].text() != summary.reference) continue;
    profiles = profiles_against(table, cell->solver);
    reference_is_recommended = cell->solver == recommended;
    break;
  }
  if (recommended && !reference_is_recommended) {
    const std::vector<PairProfile> more = profiles_against(table, *recommended);
    profiles.insert(profiles.end(), more.begin(), more.end());
  }
  return profiles;
}

// --- the virtual best solver and the chains ---

/// Bit i: the i-th solver of the scope.
using SolverSet = std::uint64_t;

constexpr std::int64_t kSubsetLimit = std::int64_t{1} << 20;

/// Solvers and problems that a portfolio is judged on: each of the solvers met each of the problems.
struct Scope {
  std::vector<std::size_t> columns;  ///< of the table
  std::vector<std::size_t> rows;     ///< solvable ones only
};

Scope scope_of(const OutcomeTable& table, bool common_only, std::int64_t problems_of_set) {
  Scope scope;
  for (std::size_t column = 0; column < table.cells.size(); ++column) {
    const bool met_all = table.cells[column]->trials == problems_of_set;
    if (common_only || met_all) scope.columns.push_back(column);
  }
  for (std::size_t row = 0; row < table.problems.size(); ++row) {
    const bool usable = std::all_of(scope.columns.begin(), scope.columns.end(), [&](std::size_t column) {
      return table.columns[column][row] != nullptr;
    }) && std::none_of(table.columns.begin(), table.columns.end(), [&](const auto& column) {
      return column[row] != nullptr && column[row]->unsolvable;
    });
    if (usable && !scope.columns.empty()) scope.rows.push_back(row);
  }
  return scope;
}

/// The problems that the same solvers solved.
struct Group {
  SolverSet solvers = 0;
  std::int64_t problems = 0;
  std::int64_t timed = 0;
  std::vector<double> times_s;         ///< sums over the timed problems, by solver
  std::vector<double> verification_s;  ///< as `times_s`
};

/// What trying one solver on one problem costs; nothing when it refuses.
double time_of(const Outcome& outcome) { return outcome.refused ? 0.0 : outcome.time_s; }
double verification_of(const Cell& cell, const Outcome& outcome) {
  return outcome.refused ? 0.0 : cell.time_parts.verify;
}

std::vector<Group> group_problems(const OutcomeTable& table, const Scope& scope) {
  std::map<SolverSet, Group> groups;
  const std::size_t solvers = scope.columns.size();
  for (const std::size_t row : scope.rows) {
    SolverSet solved = 0;
    std::vector<double> times(solvers);
    std::vector<double> verification(solvers);
    double total = 0;
    for (std::size_t i = 0; i < solvers; ++i) {
      const Outcome& outcome = *table.columns[scope.columns[i]][row];
      if (outcome.solved) solved |= SolverSet{1} << i;
      times[i] = time_of(outcome);
      verification[i] = verification_of(*table.cells[scope.columns[i]], outcome);
      total += times[i] + verification[i];
    }
    Group& group = groups[solved];
    group.solvers = solved;
    group.times_s.resize(solvers);
    group.verification_s.resize(solvers);
    ++group.problems;
    if (std::isnan(total)) continue;
    ++group.timed;
    for (std::size_t i = 0; i < solvers; ++i) {
      group.times_s[i] += times[i];
      group.verification_s[i] += verification[i];
    }
  }
  std::vector<Group> list;
  for (auto& [solved, group] : groups) list.push_back(std::move(group));
  return list;
}

/// The solver sets that a cover must meet: those of the groups without the ones that contain another.
std::vector<SolverSet> demands_of(const std::vector<Group>& groups) {
  std::vector<SolverSet> demands;
  for (const Group& group : groups) {
    const bool implied = std::any_of(groups.begin(), groups.end(), [&group](const Group& other) {
      return other.solvers != 0 && other.solvers != group.solvers && (other.solvers & group.solvers) == other.solvers;
    });
    if (group.solvers != 0 && !implied) demands.push_back(group.solvers);
  }
  return demands;
}

/// The next larger number with as many bits set (Gosper).
SolverSet next_of_same_size(SolverSet set) {
  const SolverSet lowest = set & (0 - set);
  const SolverSet ripple = set + lowest;
  return ripple | (((set ^ ripple) >> 2) / lowest);
}

/// Every smallest set of solvers that meets all demands; empty when none was found within the limit on subsets.
std::vector<SolverSet> smallest_covers(const std::vector<SolverSet>& demands, std::size_t solvers) {
  std::vector<SolverSet> covers;
  std::int64_t tried = 0;
  const SolverSet end = SolverSet{1} << solvers;
  for (std::size_t size = 1; size <= solvers && covers.empty(); ++size) {
    for (SolverSet set = (SolverSet{1} << size) - 1; set < end; set = next_of_same_size(set)) {
      if (++tried > kSubsetLimit) return {};
      const bool covers_all =
          std::all_of(demands.begin(), demands.end(), [set](SolverSet demand) { return (demand & set) != 0; });
      if (covers_all) covers.push_back(set);
    }
  }
  return covers;
}

/// What trying `solver` costs in all on the problems that `tried` left unsolved.
double cost_after(const std::vector<Group>& groups, std::size_t solver, SolverSet tried) {
  double cost = 0;
  for (const Group& group : groups) {
    if ((group.solvers & tried) == 0) cost += group.times_s[solver] + group.verification_s[solver];
  }
  return cost;
}

std::vector<std::size_t> members_of(SolverSet set) {
  std::vector<std::size_t> members;
  for (; set != 0; set &= set - 1) members.push_back(static_cast<std::size_t>(std::countr_zero(set)));
  return members;
}

struct OrderedCover {
  double cost = kInfinity;
  std::vector<std::size_t> order;  ///< of the scope's solvers
};

/// The cheapest order of a cover, exactly: dynamic programming over its subsets, as the cost of a step depends on who
/// was tried before and not on their order.
OrderedCover cheapest_order(const std::vector<Group>& groups, SolverSet cover) {
  const std::vector<std::size_t> members = members_of(cover);
  const std::size_t subsets = std::size_t{1} << members.size();
  std::vector<OrderedCover> best(subsets);
  best[0].cost = 0;
  for (std::size_t subset = 0; subset + 1 < subsets; ++subset) {
    SolverSet tried = 0;
    for (const std::size_t solver : best[subset].order) tried |= SolverSet{1} << solver;
    for (std::size_t i = 0; i < members.size(); ++i) {
      if ((subset >> i & 1) != 0) continue;
      OrderedCover& longer = best[subset | std::size_t{1} << i];
      const double cost = best[subset].cost + cost_after(groups, members[i], tried);
      if (!(cost < longer.cost)) continue;
      longer.cost = cost;
      longer.order = best[subset].order;
      longer.order.push_back(members[i]);
    }
  }
  return best.back();
}

FallbackChain chain_of(const OutcomeTable& table, const Scope& scope, const std::vector<Group>& groups,
                       const std::vector<std::size_t>& order) {
  FallbackChain chain;
  SolverSet tried = 0;
  for (const std::size_t solver : order) {
    ChainStep step{.solver = table.cells[scope.columns[solver]]->solver};
    for (const Group& group : groups) {
      if ((group.solvers & tried) != 0) continue;
      step.reached += group.problems;
      if ((group.solvers >> solver & 1) != 0) step.solved += group.problems;
      chain.mean_time_s += group.times_s[solver];
      chain.mean_verification_s += group.verification_s[solver];
    }
    tried |= SolverSet{1} << solver;
    chain.steps.push_back(step);
  }
  for (const Group& group : groups) chain.timed += group.timed;
  const auto timed = chain.timed > 0 ? static_cast<double>(chain.timed) : kNoNumber;
  chain.mean_time_s /= timed;
  chain.mean_verification_s /= timed;
  return chain;
}

std::optional<FallbackChain> shortest_chain(const OutcomeTable& table, const Scope& scope) {
  if (scope.columns.size() > 62) return std::nullopt;
  const std::vector<Group> groups = group_problems(table, scope);
  const std::vector<SolverSet> demands = demands_of(groups);
  if (demands.empty()) return std::nullopt;
  OrderedCover cheapest;
  for (const SolverSet cover : smallest_covers(demands, scope.columns.size())) {
    OrderedCover ordered = cheapest_order(groups, cover);
    if (cheapest.order.empty() || ordered.cost < cheapest.cost) cheapest = std::move(ordered);
  }
  if (cheapest.order.empty()) return std::nullopt;
  return chain_of(table, scope, groups, cheapest.order);
}

VirtualBest virtual_best(const OutcomeTable& table, const Scope& scope) {
  VirtualBest best;
  best.problems = static_cast<std::int64_t>(scope.rows.size());
  best.contributions.resize(scope.columns.size());
  std::vector<double> times;
  for (const std::size_t row : scope.rows) {
    Contribution* fastest = nullptr;
    Contribution* last_solver = nullptr;
    std::int64_t solvers = 0;
    double least = kInfinity;
    for (std::size_t i = 0; i < scope.columns.size(); ++i) {
      const Outcome& outcome = *table.columns[scope.columns[i]][row];
      if (!outcome.solved) continue;
      ++solvers;
      last_solver = &best.contributions[i];
      ++last_solver->solved;
      if (!(outcome.time_s < least)) continue;
      least = outcome.time_s;
      fastest = last_solver;
    }
    if (solvers > 0) ++best.solved;
    if (solvers == 1) ++last_solver->alone;
    if (fastest == nullptr) continue;
    ++fastest->fastest;
    times.push_back(least);
  }
  for (std::size_t i = 0; i < scope.columns.size(); ++i) {
    best.contributions[i].solver = table.cells[scope.columns[i]]->solver;
  }
  best.median_time = median_estimate(times);
  best.mean_time_s = spread(times).mean;
  best.chain = shortest_chain(table, scope);
  return best;
}

std::vector<std::size_t> left_out_of(const OutcomeTable& table, const Scope& scope) {
  std::vector<std::size_t> left_out;
  for (std::size_t column = 0; column < table.cells.size(); ++column) {
    const bool inside = std::find(scope.columns.begin(), scope.columns.end(), column) != scope.columns.end();
    if (!inside) left_out.push_back(table.cells[column]->solver);
  }
  return left_out;
}

std::vector<VirtualBest> virtual_bests(const OutcomeTable& table, std::int64_t problems_of_set) {
  std::vector<VirtualBest> bests;
  for (const bool common_only : {false, true}) {
    const Scope scope = scope_of(table, common_only, problems_of_set);
    const bool repeats = common_only && !bests.empty() && bests.front().left_out.empty();
    if (scope.rows.empty() || repeats) continue;
    VirtualBest best = virtual_best(table, scope);
    best.common_only = common_only;
    best.left_out = left_out_of(table, scope);
    bests.push_back(std::move(best));
  }
  return bests;
}

}  // namespace

std::optional<std::size_t> ComparedPair::better() const {
  if (!(p_holm < kSignificance)) return std::nullopt;
  return solved.only_first > solved.only_second ? first : second;
}

std::vector<double> Distribution::solved_within(std::span<const double> targets_s) const {
  return ecdf(times_s, problems, targets_s);
}

std::vector<double> Distribution::answered_within(std::span<const double> targets) const {
  return ecdf(errors, problems, targets);
}

std::vector<SetComparison> compare_solvers(const Summary& summary, const Recommendations& recommended) {
  const double time_limit_s = recorded_time_limit(summary);
  std::vector<SetComparison> comparisons;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    const OutcomeTable table = outcome_table(summary, set);
    if (table.cells.empty()) continue;
    SetComparison comparison;
    comparison.set = set;
    comparison.pairs = count_pairs(table);
    for (const Cell* cell : table.cells) {
      comparison.times.push_back(times_of(*cell, time_limit_s));
      comparison.distributions.push_back(distribution_of(*cell));
    }
    const auto choice = recommended.find(set);
    comparison.profiles = make_profiles(
        summary, table, choice == recommended.end() ? std::nullopt : std::optional<std::size_t>(choice->second));
    comparison.virtual_bests = virtual_bests(table, summary.sets[set].problems);
    comparisons.push_back(std::move(comparison));
  }
  return comparisons;
}

double recorded_time_limit(const Summary& summary) {
  double longest = kNoNumber;
  for (const RunSummary& run : summary.runs) {
    const nlohmann::ordered_json::json_pointer path("/plan/time_limit_s");
    if (!run.provenance.contains(path) || !run.provenance.at(path).is_number()) continue;
    longest = std::fmax(longest, run.provenance.at(path).get<double>());
  }
  return longest;
}

bool solves_other_model(const SetSummary& set, const SolverRow& solver) {
  return set.frictional && solver.friction != FrictionModel::kPyramid;
}

std::string solver_label(const Summary& summary, std::size_t solver) {
  const SolverRow& row = summary.solvers[solver];
  const auto namesakes = std::count_if(summary.solvers.begin(), summary.solvers.end(), [&row](const SolverRow& other) {
    return other.sweep.empty() && other.text() == row.text();
  });
  if (namesakes < 2) return row.text();
  return row.text() + " (" + (row.isa.empty() ? "" : row.isa + ", ") + row.library + " " + row.version + ")";
}

}  // namespace lcpbench
