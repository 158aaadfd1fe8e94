#include "study/report/regret.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>

#include "study/report/solver_comparison.h"
#include "study/report/tables.h"

namespace lcpbench::report {
namespace {

using Json = nlohmann::ordered_json;

/// The error that an `auto` states; nullopt for any other solver or setting.
std::optional<double> stated_error(const SolverRow& solver) {
  static constexpr std::string_view kError = "error=";
  if (solver.name != "auto" || !solver.sweep.empty()) return std::nullopt;
  if (solver.settings.empty()) return 0;
  if (!solver.settings.starts_with(kError)) return std::nullopt;
  char* end = nullptr;
  const double error = std::strtod(solver.settings.c_str() + kError.size(), &end);
  return *end == '\0' ? std::optional(error) : std::nullopt;
}

/// Index into Summary::solvers.
std::optional<std::size_t> auto_for(const Summary& summary, double target) {
  std::optional<std::size_t> best;
  double most = -1;
  for (std::size_t i = 0; i < summary.solvers.size(); ++i) {
    const std::optional<double> error = stated_error(summary.solvers[i]);
    if (!error || !(*error <= target) || !(*error > most)) continue;
    best = i;
    most = *error;
  }
  return best;
}

bool is_comparable(const Summary& summary, const Cell& cell, const SolverRow& reference) {
  const SolverRow& solver = summary.solvers[cell.solver];
  const bool same_model =
      !summary.sets[cell.set].frictional || solver.friction == FrictionModel::kPyramid;
  return solver.sweep.empty() && same_model && (solver.isa.empty() || solver.isa == reference.isa);
}

bool reaches(const Outcome& outcome, double target) {
  return outcome.claimed && !outcome.unsolvable && outcome.error <= target && outcome.time_s > 0;
}

struct Fastest {
  const Outcome* outcome = nullptr;
  std::size_t solver = 0;
};

/// Reads the details of answers.
class Details {
 public:
  explicit Details(Store& store)
      : query_(store.database(), "SELECT detail FROM answers WHERE problem_id = ? AND solver_id = ? AND part = 0") {}

  std::string of(std::int64_t problem, std::int64_t solver) {
    query_.bind_all(problem, solver);
    std::string detail = query_.step() ? std::string(query_.text(0)) : std::string();
    query_.reset();
    return detail;
  }

 private:
  sqlite::Statement query_;
};

void add_regrets(const Summary& summary, std::size_t set, std::size_t solver, double target, Details& details,
                 std::vector<Regret>& regrets) {
  std::map<std::int64_t, Fastest> fastest;  // by problem
  const Cell* own = nullptr;
  const SolverRow& reference = summary.solvers[solver];
  for (const Cell& cell : summary.cells) {
    if (cell.set != set || !is_comparable(summary, cell, reference)) continue;
    if (cell.solver == solver) own = &cell;
    for (const Outcome& outcome : cell.outcomes) {
      if (!reaches(outcome, target)) continue;
      Fastest& best = fastest[outcome.problem];
      if (best.outcome == nullptr || outcome.time_s < best.outcome->time_s) best = {&outcome, cell.solver};
    }
  }
  if (own == nullptr) return;
  for (const Outcome& outcome : own->outcomes) {
    const auto best = fastest.find(outcome.problem);
    if (best == fastest.end()) continue;
    regrets.push_back({.set = set,
                       .seed = static_cast<std::uint64_t>(outcome.seed),
                       .trial = outcome.trial,
                       .target = target,
                       .solver = solver,
                       .fastest = best->second.solver,
                       .time_s = reaches(outcome, target) ? outcome.time_s : kNoNumber,
                       .fastest_s = best->second.outcome->time_s,
                       .methods = methods_of(details.of(outcome.problem, reference.id()))});
  }
}

std::vector<MethodRegret> by_methods(double target, const std::vector<const Regret*>& regrets) {
  std::map<std::string, std::vector<const Regret*>> groups;
  double loss = 0;
  for (const Regret* regret : regrets) {
    groups[regret->methods].push_back(regret);
    if (regret->reached()) loss += std::log(regret->value());
  }
  std::vector<MethodRegret> result;
  for (const auto& [methods, group] : groups) {
    double own = 0;
    for (const Regret* regret : group) own += regret->reached() ? std::log(regret->value()) : 0;
    result.push_back({methods, regret_statistics(target, group), loss > 0 ? own / loss : kNoNumber});
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const auto& a, const auto& b) { return a.share_of_loss > b.share_of_loss; });
  return result;
}

Json statistics_json(const RegretStatistics& statistics) {
  return {{"target", statistics.target},
          {"problems", statistics.problems},
          {"geometric_mean", estimate_json(statistics.geometric_mean)},
          {"p99", statistics.p99},
          {"max", statistics.max},
          {"above_3", share_json(statistics.large)},
          {"missed", share_json(statistics.missed)}};
}

}  // namespace

std::string methods_of(std::string_view detail) {
  const bool counts = detail.find(" island") != std::string_view::npos;
  std::string_view list = detail;
  if (counts) {
    const std::size_t begin = detail.find("; ");
    if (begin == std::string_view::npos) return "at rest";
    list = detail.substr(begin + 2);
  }
  // What follows the methods is their precision.
  const std::size_t end = list.rfind(counts ? "; " : ", ");
  if (end == std::string_view::npos) return detail.empty() ? "no method" : std::string(detail);
  list = list.substr(0, end);
  std::string methods = counts && !detail.starts_with("1 island") ? "several islands: " : "";
  for (bool first = true; !list.empty(); first = false) {
    const std::size_t comma = std::min(list.find(", "), list.size());
    const std::string_view method = list.substr(0, comma);
    methods += (first ? "" : " + ") + std::string(method.substr(0, method.find(' ')));
    list.remove_prefix(std::min(comma + 2, list.size()));
  }
  return methods;
}

RegretStatistics regret_statistics(double target, const std::vector<const Regret*>& regrets) {
  RegretStatistics result{.target = target, .problems = std::ssize(regrets)};
  std::vector<double> values;
  for (const Regret* regret : regrets) {
    if (regret->reached()) values.push_back(regret->value());
  }
  std::sort(values.begin(), values.end());
  std::vector<double> logarithms;
  for (const double value : values) logarithms.push_back(std::log(value));
  const Spread logs = spread(logarithms);
  const double half = kNormal975 * logs.sigma / std::sqrt(static_cast<double>(logs.count));
  result.geometric_mean = {std::exp(logs.mean), std::exp(logs.mean - half), std::exp(logs.mean + half)};
  result.p99 = quantile(values, 0.99);
  result.max = values.empty() ? kNoNumber : values.back();
  const auto above = values.end() - std::upper_bound(values.begin(), values.end(), kLargeRegret);
  result.large = {above, std::ssize(values)};
  result.missed = {result.problems - std::ssize(values), result.problems};
  return result;
}

RegretStudy regret_study(Store& store, const Summary& summary) {
  RegretStudy study;
  Details details(store);
  for (const double target : kRegretTargets) {
    const std::optional<std::size_t> solver = auto_for(summary, target);
    if (!solver) return {};
    for (std::size_t set = 0; set < summary.sets.size(); ++set) {
      add_regrets(summary, set, *solver, target, details, study.regrets);
    }
  }
  if (study.regrets.empty()) return {};
  for (const double target : kRegretTargets) {
    std::vector<const Regret*> regrets;
    for (const Regret& regret : study.regrets) {
      if (regret.target == target) regrets.push_back(&regret);
    }
    study.targets.push_back(regret_statistics(target, regrets));
    study.methods.push_back(by_methods(target, regrets));
  }
  return study;
}

Json regret_json(const Summary& summary, const std::vector<Regret>& regrets) {
  Json records = Json::array();
  for (const Regret& regret : regrets) {
    records.push_back({{"set", summary.sets[regret.set].name},
                       {"seed", regret.seed},
                       {"trial", regret.trial},
                       {"target", regret.target},
                       {"auto", solver_label(summary, regret.solver)},
                       {"methods", regret.methods},
                       {"time_s", regret.time_s},
                       {"fastest", solver_label(summary, regret.fastest)},
                       {"fastest_s", regret.fastest_s},
                       {"regret", regret.value()}});
  }
  return records;
}

Json regret_summary_json(const RegretStudy& study) {
  Json targets = Json::array();
  Json methods = Json::array();
  for (const RegretStatistics& target : study.targets) targets.push_back(statistics_json(target));
  for (const std::vector<MethodRegret>& of_target : study.methods) {
    for (const MethodRegret& cost : of_target) {
      Json record{{"methods", cost.methods}};
      record.update(statistics_json(cost.statistics));
      record["share_of_loss"] = cost.share_of_loss;
      methods.push_back(std::move(record));
    }
  }
  return {{"targets", std::move(targets)}, {"methods", std::move(methods)}};
}

}  // namespace lcpbench::report
