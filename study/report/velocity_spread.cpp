#include "study/report/velocity_spread.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "generators/sets.h"
#include "study/evaluation/fastest_contact.h"
#include "study/report/sets.h"

namespace lcpbench::report {
namespace {

using Json = nlohmann::ordered_json;

/// The velocities of the contacts at u: along each normal, then along each direction of friction.
Vector contact_velocities(const ContactProblem& problem, const Vector& u) {
  const auto along = [&](const Jacobian& J) {
    return std::visit([&](const auto& matrix) { return Vector(matrix.transpose() * u); }, J);
  };
  Vector velocities(problem.nc() + cols(problem.D));
  velocities << along(problem.N), along(problem.D);
  return velocities;
}

Index contact_of(const ContactProblem& problem, Index row) {
  if (row < problem.nc()) return row;
  const ContactLayout layout = contact_layout(problem);
  const auto next = std::upper_bound(layout.friction_begin.begin(), layout.friction_begin.end(), row - problem.nc());
  return next - layout.friction_begin.begin() - 1;
}

/// Names of the solvers at single settings with the pyramid, by their id.
std::map<std::int64_t, std::string> comparable_solvers(Store& store) {
  std::map<std::int64_t, std::string> names;
  for (const StoredSolver& solver : store.solvers()) {
    const bool comparable =
        solver.row.sweep.empty() && solver.row.friction == FrictionModel::kPyramid;
    if (comparable) names[solver.id] = solver.row.text();
  }
  return names;
}

std::unique_ptr<ProblemSet> opened(const std::string& name) {
  try {
    return open_set(name);
  } catch (const InputError&) {
    return nullptr;
  }
}

/// @param answers  to one problem, verified. @returns null where two of them cannot be compared
Json spread_of(Store& store, const ProblemSet& steps, const std::vector<StoredAnswer>& answers,
               const std::map<std::int64_t, std::string>& names) {
  if (answers.size() < 2) return nullptr;
  const StoredAnswer& first = answers.front();
  Problem problem;
  try {
    problem = steps.generate(first.seed, first.trial);
  } catch (const InputError&) {
    return nullptr;
  }
  const ContactProblem* contact = problem.contact();
  const bool is_step = contact != nullptr && contact->ngc() > 0 && contact->frictional();
  if (!is_step || problem_hash(problem) != first.hash) return nullptr;
  std::vector<std::string> solvers;
  Matrix velocities(contact->nc() + cols(contact->D), std::ssize(answers));  // by row of contacts, by answer
  for (const StoredAnswer& stored : answers) {
    const std::optional<Answer> answer = store.answer(stored.problem_id, stored.solver_id);
    if (!answer || answer->z.size() != problem.size()) continue;
    const bool moved = answer->velocity.size() == contact->ngc();
    const Vector own = contact_velocities(
        *contact, moved ? Vector(answer->velocity) : post_impact_velocity(*contact, answer->z));
    if (!own.allFinite()) continue;
    velocities.col(std::ssize(solvers)) = own;
    solvers.push_back(names.at(stored.solver_id));
  }
  if (solvers.size() < 2) return nullptr;
  const auto known = velocities.leftCols(std::ssize(solvers));
  Index row = 0;
  Index least = 0;
  Index largest = 0;
  const double spread = (known.rowwise().maxCoeff() - known.rowwise().minCoeff()).maxCoeff(&row);
  known.row(row).minCoeff(&least);
  known.row(row).maxCoeff(&largest);
  const bool any = spread > 0;
  const auto name = [&](Index answer) { return any ? solvers[static_cast<std::size_t>(answer)] : ""; };
  return {{"trial", first.trial},
          {"answers", solvers.size()},
          {"before_m_per_s", fastest_contact(*contact, contact->v).m_per_s},
          {"spread_m_per_s", spread},
          {"differs", spread > least_difference(*contact)},
          {"contact", any ? Json(contact_of(*contact, row)) : Json()},
          {"solver", name(std::min(least, largest))},
          {"other", name(std::max(least, largest))}};
}

}  // namespace

Json velocity_spread_example() {
  Json example = Json::object();
  for (const char* name : {"set", "trial", "answers", "before_m_per_s", "spread_m_per_s", "differs", "contact", "solver",
                           "other"}) {
    example[name] = nullptr;
  }
  return example;
}

Json velocity_spreads(Store& store, const Summary& summary) {
  Json records = Json::array();
  const std::map<std::int64_t, std::string> names = comparable_solvers(store);
  for (const SetSummary& set : summary.sets) {
    const std::unique_ptr<ProblemSet> steps = scene_name(set.name) ? opened(set.name) : nullptr;
    if (steps == nullptr) continue;
    std::map<std::int64_t, std::vector<StoredAnswer>> verified;  // by trial: one seed for all captured steps
    store.for_each_answer(
        [&](const StoredAnswer& answer) {
          if (answer.verdict == Verdict::kSolved && names.contains(answer.solver_id)) {
            verified[answer.trial].push_back(answer);
          }
        },
        set_id(set.name));
    for (const auto& [trial, answers] : verified) {
      const Json spread = spread_of(store, *steps, answers, names);
      if (spread.is_null()) continue;
      records.push_back({{"set", set.name}});
      records.back().update(spread);
    }
  }
  return records;
}

}  // namespace lcpbench::report
