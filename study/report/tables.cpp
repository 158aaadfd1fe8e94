#include "study/report/tables.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;

double share_of(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : std::numeric_limits<double>::quiet_NaN();
}

/// Writes records that name sets and solvers.
class Records {
 public:
  explicit Records(const Summary& summary) : summary_(summary) {}

  void pairs(const SetComparison& comparison, Json& records) const {
    for (const ComparedPair& pair : comparison.pairs) {
      Json record{{"set", set(comparison)},
                  {"first", label(pair.first)},
                  {"second", label(pair.second)},
                  {"problems", pair.solved.problems()},
                  {"both", pair.solved.both},
                  {"only_first", pair.solved.only_first},
                  {"only_second", pair.solved.only_second},
                  {"neither", pair.solved.neither},
                  {"p", pair.p},
                  {"p_holm", pair.p_holm}};
      record["better"] = pair.better() ? Json(label(*pair.better())) : Json();
      records.push_back(std::move(record));
    }
  }

  void times(const SetComparison& comparison, Json& records) const {
    for (const SolverTimes& times : comparison.times) {
      records.push_back({{"set", set(comparison)},
                         {"solver", label(times.solver)},
                         {"problems", times.problems},
                         {"solved", times.solved},
                         {"share_solved", share_of(times.solved, times.problems)},
                         {"timed", times.timed},
                         {"median_s", estimate_json(times.median)},
                         {"shifted_geometric_mean_s", estimate_json(times.geometric_mean)},
                         {"par10_s", times.par10}});
    }
  }

  void distributions(const SetComparison& comparison, Json& records) const {
    for (const Distribution& distribution : comparison.distributions) {
      const std::vector<double> times = decade_grid(-6, 1, 5);
      const std::vector<double> errors = decade_grid(-16, 0, 2);
      add(comparison, distribution, "solved within a time [s]", times, distribution.solved_within(times), records);
      add(comparison, distribution, "answered within an error", errors, distribution.answered_within(errors), records);
    }
  }

  void profiles(const SetComparison& comparison, Json& records) const {
    for (const PairProfile& profile : comparison.profiles) {
      for (std::size_t i = 0; i < kProfileFactors.size(); ++i) {
        records.push_back({{"set", set(comparison)},
                           {"solver", label(profile.solver)},
                           {"against", label(profile.against)},
                           {"problems", profile.problems},
                           {"factor", kProfileFactors[i]},
                           {"solver_share", profile.solver_shares[i]},
                           {"against_share", profile.against_shares[i]}});
      }
    }
  }

  void portfolios(const SetComparison& comparison, Json& records) const {
    for (const VirtualBest& best : comparison.virtual_bests) {
      for (const Contribution& part : best.contributions) {
        records.push_back({{"set", set(comparison)},
                           {"scope", scope(best)},
                           {"solver", label(part.solver)},
                           {"problems", best.problems},
                           {"virtual_best", best.solved},
                           {"virtual_best_mean_s", best.mean_time_s},
                           {"virtual_best_median_s", estimate_json(best.median_time)},
                           {"solved", part.solved},
                           {"alone", part.alone},
                           {"fastest", part.fastest}});
      }
    }
  }

  void chains(const SetComparison& comparison, Json& records) const {
    for (const VirtualBest& best : comparison.virtual_bests) {
      if (!best.chain) continue;
      for (std::size_t i = 0; i < best.chain->steps.size(); ++i) {
        const ChainStep& step = best.chain->steps[i];
        records.push_back({{"set", set(comparison)},
                           {"scope", scope(best)},
                           {"step", i + 1},
                           {"of", best.chain->steps.size()},
                           {"solver", label(step.solver)},
                           {"reached", step.reached},
                           {"solved", step.solved},
                           {"chain_timed", best.chain->timed},
                           {"chain_mean_s", best.chain->mean_time_s},
                           {"chain_mean_verification_s", best.chain->mean_verification_s}});
      }
    }
  }

 private:
  const std::string& set(const SetComparison& comparison) const { return summary_.sets[comparison.set].name; }
  std::string label(std::size_t solver) const { return solver_label(summary_, solver); }
  static const char* scope(const VirtualBest& best) {
    return best.common_only ? "problems that all solvers met" : "all problems";
  }

  void add(const SetComparison& comparison, const Distribution& distribution, const char* what,
           const std::vector<double>& targets, const std::vector<double>& shares, Json& records) const {
    for (std::size_t i = 0; i < targets.size(); ++i) {
      records.push_back({{"set", set(comparison)},
                         {"solver", label(distribution.solver)},
                         {"problems", distribution.problems},
                         {"what", what},
                         {"target", targets[i]},
                         {"share", shares[i]}});
    }
  }

  const Summary& summary_;
};

std::string sql_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

}  // namespace

Json estimate_json(const Estimate& estimate) {
  return {{"value", estimate.value}, {"low", estimate.low}, {"high", estimate.high}};
}

Json share_json(const Share& share) {
  return {{"count", share.part},
          {"of", share.whole},
          {"share", share.value()},
          {"low", share.interval().low},
          {"high", share.interval().high}};
}

Json comparison_tables(const Summary& summary, const std::vector<SetComparison>& comparisons) {
  const Records records(summary);
  Json tables;
  for (const char* name : {"mcnemar", "solver_times", "ecdf", "profiles", "vbs", "chains"}) {
    tables[name] = Json::array();
  }
  for (const SetComparison& comparison : comparisons) {
    records.pairs(comparison, tables["mcnemar"]);
    records.times(comparison, tables["solver_times"]);
    records.distributions(comparison, tables["ecdf"]);
    records.profiles(comparison, tables["profiles"]);
    records.portfolios(comparison, tables["vbs"]);
    records.chains(comparison, tables["chains"]);
  }
  return tables;
}

SetComparison example_comparison() {
  SetComparison example;
  example.pairs.resize(1);
  example.times.resize(1);
  example.distributions.resize(1);
  example.profiles.resize(1);
  example.virtual_bests.resize(1);
  example.virtual_bests[0].contributions.resize(1);
  example.virtual_bests[0].chain.emplace().steps.resize(1);
  return example;
}

Json comparison_json(const Summary& summary, const std::vector<SetComparison>& comparisons) {
  Json json{{"shift_s", kTimeShift}, {"time_limit_s", recorded_time_limit(summary)}, {"significance", kSignificance}};
  const Json tables = comparison_tables(summary, comparisons);
  for (const auto& [name, records] : tables.items()) {
    if (name != "ecdf") json[name] = records;
  }
  return json;
}

std::string chain_query(const Summary& summary, std::size_t set, const FallbackChain& chain) {
  std::string solvers;
  for (const ChainStep& step : chain.steps) {
    solvers += (solvers.empty() ? "" : ", ") + sql_quoted(summary.solvers[step.solver].text());
  }
  return fmt::format(
      "SELECT COUNT(DISTINCT j.problem_id) FROM judged j JOIN solvers s ON s.id = j.solver_id\n"
      "JOIN sets ON sets.id = j.set_id WHERE sets.name = {} AND s.sweep = '' AND j.verdict = 'solved'\n"
      "AND j.problem_id NOT IN (SELECT problem_id FROM judged WHERE verdict = 'unsolvable')\n"
      "AND s.name || iif(s.settings = '', '', '{{' || s.settings || '}}') IN ({});",
      sql_quoted(summary.sets[set].name), solvers);
}

}  // namespace lcpbench::report
