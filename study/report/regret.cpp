#include "study/report/regret.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <tuple>

#include "study/report/sets.h"

namespace lcpbench::report {

namespace {

/// The error that an `auto` with at most this one setting was asked for; nullopt for another solver.
std::optional<double> stated_error(const SolverRow& solver) {
  constexpr std::string_view kKey = "error=";
  const std::string& settings = solver.settings;
  if (solver.name != "auto" || !solver.sweep.empty()) return std::nullopt;
  if (settings.empty()) return 0;
  if (!settings.starts_with(kKey) || settings.find(',') != std::string::npos) return std::nullopt;
  return std::strtod(settings.c_str() + kKey.size(), nullptr);
}

/// The `auto` with the largest stated error up to the target; nullptr for none.
const SolverRow* auto_for(const Summary& summary, double target) {
  const auto rank = [](const SolverRow& solver) { return std::tuple(*stated_error(solver), -solver.id()); };
  const SolverRow* chosen = nullptr;
  for (const SolverRow& solver : summary.solvers) {
    const std::optional<double> error = stated_error(solver);
    if (error && *error <= target && (chosen == nullptr || rank(solver) > rank(*chosen))) chosen = &solver;
  }
  return chosen;
}

}  // namespace

void Regrets::add(const Summary& summary, std::size_t problems, std::span<const Cell> cells) {
  for (std::size_t i = 0; i < kTargets.size(); ++i) {
    const SolverRow* own = auto_for(summary, kTargets[i]);
    const auto is_own = [&](const Cell& cell) { return &summary.solvers[cell.solver] == own; };
    const auto of_auto = std::find_if(cells.begin(), cells.end(), is_own);
    if (of_auto == cells.end()) continue;
    // Rivals are solvers at single settings, `auto` among them, that solve the friction model of the set: libraries,
    // and native ones of the version and the instruction-set level of `auto`. Problems without a timed answer within
    // the target do not count.
    std::vector<double> fastest(problems, kInfinity);
    const auto within = [&](const Outcome& outcome) {
      return outcome.claimed() && outcome.error <= kTargets[i] && outcome.truth != Truth::kUnsolvable;
    };
    for (const Cell& cell : cells) {
      const SolverRow& solver = summary.solvers[cell.solver];
      const bool rival = solver.isa.empty() || (solver.isa == own->isa && solver.version == own->version);
      if (!rival || !solver.sweep.empty() || solves_other_model(summary.sets[cell.set], solver)) continue;
      for (const Outcome& outcome : cell.outcomes) {
        double& least = fastest[outcome.problem];
        if (within(outcome)) least = std::fmin(least, outcome.time_s);  // NaN: not timed
      }
    }
    for (const Outcome& outcome : of_auto->outcomes) {
      const double least = fastest[outcome.problem];
      if (std::isinf(least)) continue;
      const bool reached = within(outcome) && !std::isnan(outcome.time_s);
      ratios_[i].push_back(reached ? outcome.time_s / least : kNoNumber);
    }
  }
}

void Regrets::fill_table(sqlite::Database& database) const {
  database.execute("CREATE TEMP TABLE regrets (target REAL, place INTEGER, ratio REAL, PRIMARY KEY (target, place)) "
                   "WITHOUT ROWID");  // in order of the view's groups
  sqlite::Statement add(database, "INSERT INTO regrets VALUES (?, ?, ?)");
  for (std::size_t i = 0; i < kTargets.size(); ++i) {
    std::int64_t place = 0;
    for (const double ratio : ratios_[i]) add.run(kTargets[i], place++, ratio);
  }
}

}  // namespace lcpbench::report
