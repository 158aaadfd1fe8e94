#include "study/run/study.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "core/error.h"
#include "core/isa.h"
#include "core/registry.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

std::string settings_text(const Options& options) {
  std::string text;
  for (const auto& [key, value] : options) text += fmt::format("{}{}={}", text.empty() ? "" : ",", key, value);
  return text;
}

StudySet open_study_set(const std::string& name, std::int64_t trials) {
  StudySet opened{open_set(name), trials};
  if (const std::optional<std::int64_t> count = opened.set->count()) opened.trials = std::min(trials, *count);
  return opened;
}

std::int64_t trials_of(const PlannedSet& planned, const Plan& plan) {
  if (planned.trials) return *planned.trials;
  if (!planned.share) return plan.trials;
  // 0.07 * 100 rounds above 7.
  return std::max<std::int64_t>(1, std::llround(std::ceil(*planned.share * static_cast<double>(plan.trials) - 1e-9)));
}

std::vector<StudySet> open_sets(const Plan& plan) {
  std::vector<StudySet> opened;
  std::map<std::string, std::int64_t> asked;
  for (const PlannedSet& planned : plan.sets) {
    const std::int64_t trials = trials_of(planned, plan);
    for (const std::string& name : expand_sets(planned.pattern)) {
      const auto [known, is_new] = asked.emplace(name, trials);
      if (is_new) opened.push_back(open_study_set(name, trials));
      if (known->second != trials) {
        throw InputError(fmt::format("plan {}: set '{}' is asked for with {} and with {} trials", plan.name, name,
                                     known->second, trials));
      }
    }
  }
  return opened;
}

/// Marks the sets that have consecutive steps. @throws InputError where none has
void mark_in_order(std::vector<StudySet>& sets) {
  bool any = false;
  for (StudySet& set : sets) {
    for (std::int64_t trial = 1; trial < set.trials && !set.in_order; ++trial) set.in_order = set.set->follows(trial);
    any = any || set.in_order;
  }
  if (any) return;
  throw InputError(
      "--start last: none of the sets has consecutive steps of a simulation: `lcpbench capture SCENE --every 1` keeps "
      "every step, and --set file:F.scenes runs them");
}

bool takes_start(const Spec& spec) {
  const RegisteredSolver& solver = find_solver(spec.name);
  if (solver.in_process()) return make_solver(canonical_solver_spec(spec))->capabilities().warm_start;
  if (solver.definition.capabilities.warm_start) return true;
  const Options settings = solver.definition.all_settings(spec.options);  // a program says so itself
  return std::find(settings.begin(), settings.end(), std::pair<std::string, std::string>("warm_start", "true")) !=
         settings.end();
}

/// Of each set of the study, whether a planned solver runs on it: all if it names none. @throws InputError where one of
/// its patterns matches no set (unless Plan::other_sets)
std::vector<bool> sets_of(const PlannedSolver& planned, const Plan& plan, const std::vector<StudySet>& sets) {
  std::vector<bool> chosen(sets.size(), planned.sets.empty());
  for (const std::string& pattern : planned.sets) {
    bool any = plan.other_sets;
    for (std::size_t i = 0; i < sets.size(); ++i) {
      if (!glob_matches(pattern, sets[i].set->name())) continue;
      chosen[i] = true;
      any = true;
    }
    if (!any) {
      throw InputError(fmt::format("plan {}: solver '{}': sets: '{}' matches none of the plan's sets", plan.name,
                                   planned.spec.text(), pattern));
    }
  }
  return chosen;
}

StudySolver open_study_solver(const PlannedSolver& planned) {
  const Spec spec = planned.spec;
  StudySolver solver;
  if (!planned.sweep) {
    solver.row = solver_row(spec);
    solver.open = [spec] { return open_solver(spec); };
    return solver;
  }
  solver.row = solver_row(spec, sweep_label(planned.sweep->name, spec));
  const std::vector<Spec> cells = sweep_cells(*planned.sweep, spec);
  for (const Spec& cell : cells) solver.cells.push_back(solver_row(cell, solver.row.sweep));
  solver.open_swept = [cells] { return open_swept_solver(cells); };
  return solver;
}

class SolverList {
 public:
  SolverList(const Plan& plan, const std::vector<StudySet>& sets) : plan_(plan), sets_(sets) {}

  void add(const PlannedSolver& planned, bool from_last = false) {
    std::vector<bool> chosen = sets_of(planned, plan_, sets_);
    for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = chosen[i] && (!from_last || sets_[i].in_order);
    // Each engine, and each version of it, that the user's files were captured from is a solver of its own.
    const auto engine = [&](const StudySet& set) {
      return planned.spec.name == "engine" && set.set->name().starts_with("file:") ? set.set->engine() : "";
    };
    std::set<std::string> engines;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (chosen[i]) engines.insert(engine(sets_[i]));
    }
    for (const std::string& each : engines) {
      StudySolver& solver = known(planned, from_last, each);
      for (std::size_t i = 0; i < chosen.size(); ++i) {
        if (chosen[i] && engine(sets_[i]) == each) solver.every[i].push_back(planned.every);
      }
    }
  }
  std::vector<StudySolver> take() { return std::move(solvers_); }

 private:
  StudySolver& known(const PlannedSolver& planned, bool from_last, const std::string& engine) {
    StudySolver opened = open_study_solver(planned);
    if (!engine.empty()) opened.row.version = engine;
    opened.from_last = from_last;
    if (from_last) opened.open = [spec = planned.spec] { return open_for_steps(spec); };
    for (std::string* settings : {&opened.row.settings, &opened.row.all_settings}) {
      if (from_last) *settings += std::string(settings->empty() ? "" : ",") + kStartLast;
    }
    const auto [place, is_new] = index_.emplace(opened.row.id(), solvers_.size());
    if (is_new) {
      opened.every.resize(sets_.size());
      return solvers_.emplace_back(std::move(opened));
    }
    StudySolver& solver = solvers_[place->second];
    if (solver.cells != opened.cells) {
      throw InputError(fmt::format("plan {}: solver '{}': sweep '{}' is given with two grids", plan_.name,
                                   planned.spec.text(), planned.sweep->name));
    }
    return solver;
  }

  const Plan& plan_;
  const std::vector<StudySet>& sets_;
  std::map<std::int64_t, std::size_t> index_;
  std::vector<StudySolver> solvers_;
};

}  // namespace

bool StudySolver::takes(std::size_t set, std::int64_t trial) const {
  if (set >= every.size()) return false;
  return std::any_of(every[set].begin(), every[set].end(), [trial](std::int64_t step) { return trial % step == 0; });
}

SolverRow solver_row(const Spec& solver, const std::string& sweep) {
  const RegisteredSolver& registered = find_solver(solver.name);
  SolverRow row;
  row.name = solver.name;
  row.settings = settings_text(registered.definition.changed_settings(solver.options));
  const Options all_settings = registered.definition.all_settings(solver.options);
  row.all_settings = settings_text(all_settings);
  row.friction = registered.definition.friction(all_settings);
  row.library = registered.library;
  row.version = registered.version;
  row.isa = registered.native() ? to_string(isa_level()) : "";
  row.sweep = sweep;
  return row;
}

Study resolve(const Plan& plan) {
  Study study;
  study.seed = plan.seed;
  study.time_limit_s = plan.time_limit_s;
  study.repeat_until_s = plan.repeat_until_s;
  study.budget_s = plan.budget_s;
  study.solved_at = plan.solved_at;
  study.sets = open_sets(plan);
  if (plan.start_last) mark_in_order(study.sets);
  std::string cold;
  SolverList solvers(plan, study.sets);
  SolverList left_out(plan, study.sets);
  for (const PlannedSolver& planned : plan.solvers) {
    if (are_timed_once({planned.spec})) study.repeat_until_s = 0;
    const std::string reason = why_unavailable(find_solver(planned.spec.name));
    if (reason.empty()) {
      solvers.add(planned);
      if (!plan.start_last) continue;
      const bool runs_on_all = planned.every == 1 && !planned.sweep;
      if (runs_on_all && takes_start(planned.spec)) {
        solvers.add(planned, true);
      } else {
        cold += (cold.empty() ? "" : ", ") + planned.spec.text();
      }
      continue;
    }
    if (!planned.optional) throw InputError(fmt::format("solver '{}' is not available: {}", planned.spec.name, reason));
    const std::string line = fmt::format("{}: {}", planned.spec.name, reason);
    if (std::find(study.skipped.begin(), study.skipped.end(), line) == study.skipped.end()) {
      study.skipped.push_back(line);
    }
    left_out.add(planned);
  }
  if (!cold.empty()) {
    study.skipped.push_back(fmt::format("{}: {}: take no start, or do not run on every step: from nothing alone",
                                        kStartLast, cold));
  }
  study.solvers = solvers.take();
  study.left_out = left_out.take();
  return study;
}

}  // namespace lcpbench
