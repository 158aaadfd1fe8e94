#include "study/report/comparison_tables.h"

#include <limits>

#include <fmt/format.h>

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;

Json estimate_json(const Estimate& estimate) {
  return {{"value", estimate.value}, {"low", estimate.low}, {"high", estimate.high}};
}

double share_of(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : std::numeric_limits<double>::quiet_NaN();
}

/// Writes records that name sets and solvers.
class Records {
 public:
  explicit Records(const Summary& summary) : summary_(summary) {}

  Json pairs(const SetComparison& comparison) const {
    Json records = Json::array();
    for (const PairedCounts& pair : comparison.pairs) {
      Json record{{"set", set(comparison)},
                  {"first", label(pair.first)},
                  {"second", label(pair.second)},
                  {"problems", pair.problems},
                  {"both", pair.both},
                  {"only_first", pair.only_first},
                  {"only_second", pair.only_second},
                  {"neither", pair.neither},
                  {"p", pair.p},
                  {"p_holm", pair.p_holm}};
      record["better"] = pair.better() ? Json(label(*pair.better())) : Json();
      records.push_back(std::move(record));
    }
    return records;
  }

  Json times(const SetComparison& comparison) const {
    Json records = Json::array();
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
    return records;
  }

  Json distributions(const SetComparison& comparison) const {
    Json records = Json::array();
    for (const Distribution& distribution : comparison.distributions) {
      const std::vector<double> times = decade_grid(-6, 1, 5);
      const std::vector<double> errors = decade_grid(-16, 0, 2);
      add(comparison, distribution, "solved within a time [s]", times, distribution.solved_within(times), records);
      add(comparison, distribution, "answered within an error", errors, distribution.answered_within(errors), records);
    }
    return records;
  }

  Json profiles(const SetComparison& comparison) const {
    Json records = Json::array();
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
    return records;
  }

  Json portfolios(const SetComparison& comparison) const {
    Json records = Json::array();
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
    return records;
  }

  Json chains(const SetComparison& comparison) const {
    Json records = Json::array();
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
    return records;
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

Json comparison_tables(const Summary& summary, const std::vector<SetComparison>& comparisons) {
  const Records records(summary);
  Json tables;
  for (const char* name : {"mcnemar", "solver_times", "ecdf", "profiles", "vbs", "chains"})
    tables[name] = Json::array();
  const auto append = [&tables](const char* name, Json rows) {
    for (Json& row : rows) tables[name].push_back(std::move(row));
  };
  for (const SetComparison& comparison : comparisons) {
    append("mcnemar", records.pairs(comparison));
    append("solver_times", records.times(comparison));
    append("ecdf", records.distributions(comparison));
    append("profiles", records.profiles(comparison));
    append("vbs", records.portfolios(comparison));
    append("chains", records.chains(comparison));
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
      "AND s.name || iif(s.settings = '', '', '{{' || s.settings || '}}') IN ({});",
      sql_quoted(summary.sets[set].name), solvers);
}

}  // namespace lcpbench::report
