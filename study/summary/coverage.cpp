#include "study/summary/coverage.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "study/output/text_table.h"
#include "study/run/shards.h"

namespace lcpbench {

namespace {

using Json = nlohmann::ordered_json;

/// The trials of a set that one run planned for a solver: those below `trials` that a step in `every` divides.
struct Trials {
  std::int64_t trials = 0;
  std::vector<std::int64_t> every;

  auto operator<=>(const Trials&) const = default;
};

/// What all runs together plan: by work and seed, each with its cells per problem.
struct PlannedWork {
  std::int64_t cells = 1;
  std::map<std::uint64_t, std::set<Trials>> trials;
};

using Planned = std::map<Work, PlannedWork>;

/// The number of trials that at least one of the rules contains. The rules come by ascending `trials`, so a trial from
/// one rule's `trials` up to the next one's can only be in that next rule or in a later one.
std::int64_t count(const std::set<Trials>& rules) {
  std::int64_t planned = 0;
  std::int64_t from = 0;
  for (auto rule = rules.begin(); rule != rules.end(); ++rule) {
    if (rule->trials <= from) continue;
    std::vector<std::int64_t> steps;
    for (auto longer = rule; longer != rules.end(); ++longer) {
      steps.insert(steps.end(), longer->every.begin(), longer->every.end());
    }
    planned += count_trials(rule->trials, steps) - count_trials(from, steps);
    from = rule->trials;
  }
  return planned;
}

/// Adds what one run planned. @throws Json::exception for anything but what planned_cells() writes.
void add_plan(const Json& plan, Planned& planned) {
  const auto seed = plan.at("seed").get<std::uint64_t>();
  const Json& sets = plan.at("sets");
  for (const Json& solver : plan.at("solvers")) {
    for (const Json& part : solver.at("on")) {
      for (const Json& index : part.at("sets")) {
        const Json& set = sets.at(index.get<std::size_t>());
        Trials trials{std::min(set.at("trials").get<std::int64_t>(), kMaxTrials),
                      part.at("every").get<std::vector<std::int64_t>>()};
        if (std::any_of(trials.every.begin(), trials.every.end(), [](std::int64_t step) { return step < 1; })) continue;
        PlannedWork& work = planned[{set.at("set").get<std::string>(), solver.at("solver").get<std::string>(),
                                     solver.at("sweep").get<std::string>()}];
        work.cells = solver.at("cells").get<std::int64_t>();
        work.trials[seed].insert(std::move(trials));
      }
    }
  }
}

/// nullopt where there is no run, or one that recorded no plan.
std::optional<Planned> read_plans(const std::vector<RunSummary>& runs, std::map<std::string, std::int64_t>& left_out) {
  Planned planned;
  std::map<std::string, Json> skipped;  // by shard; a later run may have what one before it lacked
  for (const auto& [started, provenance] : runs) {
    if (!provenance.is_object() || !provenance.contains("planned")) return std::nullopt;
    try {
      skipped[provenance.value("shard", Json()).dump()] = provenance.value("skipped", Json());
      add_plan(provenance["planned"], planned);
    } catch (const Json::exception&) {
      return std::nullopt;
    }
  }
  for (const auto& [shard, solvers] : skipped) {
    for (const Json& solver : solvers) {
      if (solver.is_string()) left_out[solver.get<std::string>()] = 0;
    }
  }
  return runs.empty() ? std::nullopt : std::optional(std::move(planned));
}

}  // namespace

double share_of(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : std::numeric_limits<double>::quiet_NaN();
}

double Coverage::Set::share() const { return share_of(done, planned); }
bool Coverage::Set::thin() const { return share() < kThinBelow; }
double Coverage::share() const { return share_of(done, planned); }

std::vector<Coverage::Set> Coverage::thin_sets() const {
  std::vector<Set> thin;
  std::copy_if(sets.begin(), sets.end(), std::back_inserter(thin), [](const Set& set) { return set.thin(); });
  std::stable_sort(thin.begin(), thin.end(), [](const Set& a, const Set& b) { return a.share() < b.share(); });
  return thin;
}

Json planned_cells(const Study& study) {
  Json sets = Json::array();
  for (const StudySet& set : study.sets) sets.push_back({{"set", set.set->name()}, {"trials", set.trials}});
  Json solvers = Json::array();
  std::int64_t cells = 0;
  for (const StudySolver& solver : study.solvers) {
    std::map<std::vector<std::int64_t>, Json> parts;  // sets by the steps of their trials
    for (std::size_t set = 0; set < solver.every.size(); ++set) {
      if (solver.every[set].empty()) continue;
      parts[solver.every[set]].push_back(set);
      cells += solver.cell_count() * count_trials(study.sets[set].trials, solver.every[set]);
    }
    Json on = Json::array();
    for (const auto& [every, indices] : parts) on.push_back({{"every", every}, {"sets", indices}});
    solvers.push_back({{"solver", solver.row.text()},
                       {"sweep", solver.row.sweep},
                       {"cells", solver.cell_count()},
                       {"on", std::move(on)}});
  }
  return {{"cells", cells}, {"seed", study.seed}, {"sets", std::move(sets)}, {"solvers", std::move(solvers)}};
}

Coverage coverage_of(const std::vector<RunSummary>& runs, const std::map<Work, Done>& done) {
  Coverage coverage;
  const std::optional<Planned> planned = read_plans(runs, coverage.left_out);
  if (!planned) return {};
  coverage.known = true;
  std::map<std::string, Coverage::Set, decltype(&natural_less)> sets(&natural_less);
  for (const auto& [work, plan] : *planned) {
    Coverage::Set& set = sets[work.set];
    set.name = work.set;
    std::int64_t cells = 0;
    for (const auto& [seed, rules] : plan.trials) cells += plan.cells * count(rules);
    const auto answered = done.find(work);
    const std::int64_t answers = answered == done.end() ? 0 : plan.cells * answered->second.problems;
    set.planned += cells;
    set.done += answers;
    for (auto& [line, missing] : coverage.left_out) {
      if (line.starts_with(work.solver.substr(0, work.solver.find('{')) + ": ")) missing += cells - answers;
    }
  }
  std::erase_if(coverage.left_out, [](const auto& solver) { return solver.second == 0; });
  for (auto& [name, set] : sets) {
    coverage.planned += set.planned;
    coverage.done += set.done;
    coverage.sets.push_back(std::move(set));
  }
  return coverage;
}

nlohmann::ordered_json coverage_json(const Coverage& coverage) {
  nlohmann::ordered_json sets = nlohmann::ordered_json::array();
  for (const Coverage::Set& set : coverage.sets) {
    sets.push_back({{"set", set.name},
                    {"planned", set.planned},
                    {"done", set.done},
                    {"share", set.share()},
                    {"thin", set.thin()}});
  }
  const auto known = [&coverage](std::int64_t count) { return coverage.known ? Json(count) : Json(); };
  return {{"planned", known(coverage.planned)},
          {"done", known(coverage.done)},
          {"share", coverage.known ? Json(coverage.share()) : Json()},
          {"left_out", coverage.left_out},
          {"thin_below", kThinBelow},
          {"sets", std::move(sets)}};
}

}  // namespace lcpbench
