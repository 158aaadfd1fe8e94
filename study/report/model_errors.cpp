#include "study/report/model_errors.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/spec.h"
#include "generators/sets.h"
#include "study/evaluation/fastest_contact.h"

namespace lcpbench::report {
namespace {

using Trial = std::pair<std::uint64_t, std::int64_t>;  // seed and number
using Verified = std::map<Trial, std::map<FrictionModel, StoredAnswer>>;

/// Of solvers at single settings; the most accurate of each friction.
Verified verified_answers(Store& store, const std::string& set) {
  std::map<std::int64_t, FrictionModel> friction;
  for (const StoredSolver& solver : store.solvers()) {
    if (solver.row.sweep.empty()) friction[solver.id] = solver.row.friction;
  }
  Verified verified;
  const auto visit = [&](const StoredAnswer& answer) {
    if (answer.verdict != Verdict::kSolved || !friction.contains(answer.solver_id)) return;
    auto& of_trial = verified[{answer.seed, answer.trial}];
    StoredAnswer& best = of_trial.try_emplace(friction[answer.solver_id], answer).first->second;
    if (answer.errors.velocity_residual_m_per_s < best.errors.velocity_residual_m_per_s) best = answer;
  };
  store.for_each_answer(visit, set_id(set));
  return verified;
}

/// The velocity after the impact of the trial's verified answer with this model; nullopt where there is none, or the
/// problem is no longer that of the store.
std::optional<Vector> velocity(Store& store, const Verified& verified, const Trial& trial, const Problem& problem,
                               FrictionModel model) {
  const auto answers = verified.find(trial);
  if (answers == verified.end() || !answers->second.contains(model)) return std::nullopt;
  const StoredAnswer& stored = answers->second.at(model);
  const std::optional<Answer> answer = store.answer(stored.problem_id, stored.solver_id);
  if (!answer || answer->z.size() != problem.size() || problem_hash(problem) != stored.hash) return std::nullopt;
  return post_impact_velocity(*problem.contact(), answer->z);
}

void add_records(Store& store, const std::string& set, const std::string& hard_set, Json& records) {
  const std::unique_ptr<ProblemSet> steps = open_set(set);
  const std::unique_ptr<ProblemSet> hard_steps = open_set(hard_set);
  const Verified hard = verified_answers(store, hard_set);
  const Verified soft = verified_answers(store, set);
  for (const auto& [trial, answers] : soft) {
    const Problem problem = steps->generate(trial.first, trial.second);
    if (problem.contact() == nullptr || problem.contact()->ngc() == 0) continue;
    const auto difference = [&](const std::optional<Vector>& a, const std::optional<Vector>& b) {
      return a && b ? Json(fastest_contact(*problem.contact(), *a - *b).m_per_s) : Json();
    };
    const auto own = [&](FrictionModel model) { return velocity(store, soft, trial, problem, model); };
    const FrictionModel coulomb =
        answers.contains(FrictionModel::kCone) ? FrictionModel::kCone : FrictionModel::kPyramid;
    const auto of_hard = velocity(store, hard, trial, hard_steps->generate(trial.first, trial.second), coulomb);
    records.push_back({{"set", set},
                       {"trial", trial.second},
                       {"relaxation_m_per_s", difference(own(FrictionModel::kConvex), own(FrictionModel::kCone))},
                       {"softness_m_per_s", difference(own(coulomb), of_hard)}});
  }
}

}  // namespace

Json model_errors(Store& store, const Summary& summary) {
  Json records = Json::array();
  for (const SetSummary& set : summary.sets) {
    const std::string hard = Spec{"changed", {{"of", set.name}, {"by", "hard"}}}.text();
    if (std::ranges::find(summary.sets, hard, &SetSummary::name) == summary.sets.end()) continue;
    try {
      add_records(store, set.name, hard, records);
    } catch (const InputError&) {  // a set's file is gone
    }
  }
  return records;
}

}  // namespace lcpbench::report
