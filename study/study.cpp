#include "study/study.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "core/error.h"
#include "core/isa.h"
#include "core/registry.h"
#include "study/open_solver.h"

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

std::vector<StudySet> open_sets(const Plan& plan) {
  std::vector<StudySet> opened;
  std::map<std::string, std::int64_t> trials_of;
  for (const PlannedSet& planned : plan.sets) {
    const std::int64_t trials = planned.trials.value_or(plan.trials);
    for (const std::string& name : expand_sets(planned.pattern)) {
      const auto [known, is_new] = trials_of.emplace(name, trials);
      if (is_new) opened.push_back(open_study_set(name, trials));
      if (known->second != trials) {
        throw InputError(fmt::format("plan {}: set '{}' is asked for with {} and with {} trials", plan.name, name,
                                     known->second, trials));
      }
    }
  }
  return opened;
}

class SolverList {
 public:
  void add(const Spec& spec, std::int64_t every, const std::string& sweep) {
    StudySolver solver{solver_row(spec, sweep), every, [spec] { return open_solver(spec); }};
    if (known_.insert(solver.row.id()).second) solvers_.push_back(std::move(solver));
  }
  std::vector<StudySolver> take() { return std::move(solvers_); }

 private:
  std::set<std::int64_t> known_;
  std::vector<StudySolver> solvers_;
};

}  // namespace

SolverRow solver_row(const Spec& solver, const std::string& sweep) {
  const RegisteredSolver& registered = find_solver(solver.name);
  SolverRow row;
  row.name = solver.name;
  row.settings = settings_text(registered.definition.changed_settings(solver.options));
  row.all_settings = settings_text(registered.definition.all_settings(solver.options));
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
  study.sets = open_sets(plan);
  SolverList solvers;
  for (const PlannedSolver& planned : plan.solvers) {
    const std::string reason = why_unavailable(find_solver(planned.spec.name));
    if (!reason.empty()) {
      if (!planned.optional)
        throw InputError(fmt::format("solver '{}' is not available: {}", planned.spec.name, reason));
      study.skipped.push_back(fmt::format("{}: {}", planned.spec.name, reason));
      continue;
    }
    if (!planned.sweep) {
      solvers.add(planned.spec, planned.every, {});
      continue;
    }
    const std::string label = sweep_label(planned.sweep->name, planned.spec);
    for (const Spec& cell : sweep_cells(*planned.sweep, planned.spec)) solvers.add(cell, planned.every, label);
  }
  study.solvers = solvers.take();
  return study;
}

}  // namespace lcpbench
