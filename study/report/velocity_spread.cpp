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

/// Largest and least velocity of every row over the answers so far, and whose they are.
class Range {
 public:
  explicit Range(const ContactProblem& problem) : problem_(problem) {}

  void add(const std::string& solver, const Vector& velocity) {
    const Vector now = contact_velocities(problem_, velocity);
    if (!now.allFinite()) return;
    solvers_.push_back(solver);
    if (solvers_.size() == 1) {
      least_ = largest_ = now;
      least_of_.assign(static_cast<std::size_t>(now.size()), 0);
      largest_of_ = least_of_;
    }
    for (Index row = 0; row < now.size(); ++row) {
      const auto r = static_cast<std::size_t>(row);
      if (now(row) < least_(row)) least_of_[r] = solvers_.size() - 1;
      if (now(row) > largest_(row)) largest_of_[r] = solvers_.size() - 1;
    }
    least_ = least_.cwiseMin(now);
    largest_ = largest_.cwiseMax(now);
  }

  std::size_t answers() const { return solvers_.size(); }

  /// @pre there is an answer
  void write(VelocitySpread& spread) const {
    Index row = 0;
    spread.answers = static_cast<std::int64_t>(solvers_.size());
    spread.spread_m_per_s = (largest_ - least_).maxCoeff(&row);
    if (!(spread.spread_m_per_s > 0)) return;
    spread.contact = contact_of(problem_, row);
    const auto [first, second] =
        std::minmax(least_of_[static_cast<std::size_t>(row)], largest_of_[static_cast<std::size_t>(row)]);
    spread.solver = solvers_[first];
    spread.other = solvers_[second];
  }

 private:
  const ContactProblem& problem_;
  std::vector<std::string> solvers_;
  Vector least_, largest_;
  std::vector<std::size_t> least_of_, largest_of_;  // indices into solvers_
};

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

/// @param answers to one problem, verified
std::optional<VelocitySpread> spread_of(Store& store, const ProblemSet& steps, const std::vector<StoredAnswer>& answers,
                                        const std::map<std::int64_t, std::string>& names) {
  if (answers.size() < 2) return std::nullopt;
  const StoredAnswer& first = answers.front();
  Problem problem;
  try {
    problem = steps.generate(first.seed, first.trial);
  } catch (const InputError&) {
    return std::nullopt;
  }
  const ContactProblem* contact = problem.contact();
  const bool is_step = contact != nullptr && contact->ngc() > 0 && contact->frictional();
  if (!is_step || problem_hash(problem) != first.hash) return std::nullopt;
  Range range(*contact);
  for (const StoredAnswer& stored : answers) {
    const std::optional<Answer> answer = store.answer(stored.problem_id, stored.solver_id);
    if (!answer || answer->z.size() != problem.size()) continue;
    range.add(names.at(stored.solver_id), answer->velocity.size() == contact->ngc()
                                              ? Vector(answer->velocity)
                                              : post_impact_velocity(*contact, answer->z));
  }
  if (range.answers() < 2) return std::nullopt;
  VelocitySpread spread{.trial = first.trial, .before_m_per_s = fastest_contact(*contact, contact->v).m_per_s};
  range.write(spread);
  spread.differs = spread.spread_m_per_s > least_difference(*contact);
  return spread;
}

}  // namespace

std::vector<VelocitySpread> velocity_spreads(Store& store, const Summary& summary) {
  std::vector<VelocitySpread> spreads;
  const std::map<std::int64_t, std::string> names = comparable_solvers(store);
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    const std::string& name = summary.sets[set].name;
    const std::unique_ptr<ProblemSet> steps = scene_name(name) ? opened(name) : nullptr;
    if (steps == nullptr) continue;
    std::map<std::int64_t, std::vector<StoredAnswer>> verified;  // by trial: one seed for all captured steps
    store.for_each_answer(
        [&](const StoredAnswer& answer) {
          if (answer.verdict == Verdict::kSolved && names.contains(answer.solver_id)) {
            verified[answer.trial].push_back(answer);
          }
        },
        set_id(name));
    for (const auto& [trial, answers] : verified) {
      std::optional<VelocitySpread> spread = spread_of(store, *steps, answers, names);
      if (!spread) continue;
      spread->set = set;
      spreads.push_back(std::move(*spread));
    }
  }
  return spreads;
}

Json velocity_spread_json(const Summary& summary, const std::vector<VelocitySpread>& spreads) {
  Json records = Json::array();
  for (const VelocitySpread& spread : spreads) {
    records.push_back({{"set", summary.sets[spread.set].name},
                       {"trial", spread.trial},
                       {"answers", spread.answers},
                       {"before_m_per_s", spread.before_m_per_s},
                       {"spread_m_per_s", spread.spread_m_per_s},
                       {"differs", spread.differs},
                       {"contact", spread.contact < 0 ? Json() : Json(spread.contact)},
                       {"solver", spread.solver},
                       {"other", spread.other}});
  }
  return records;
}

}  // namespace lcpbench::report
