#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "generators/scenes/scenes.h"
#include "study/view/view.h"

namespace lcpbench {
namespace {

constexpr std::size_t kMostAnswers = 12;  // to a step

/// The answers of single settings to one step.
struct StoredStep {
  std::string set;
  std::int64_t engine = 0;  ///< id of the solver `engine`
  std::vector<StoredAnswer> answers;

  /// The fastest verified one; nullptr for none.
  const StoredAnswer* verified() const {
    return best([](const StoredAnswer& a) { return a.verdict == Verdict::kSolved; },
                [](const StoredAnswer& a, const StoredAnswer& b) { return time(a) < time(b); });
  }
  /// The false claim that is most wrong; without one, the other failure that is. The engine that captured the step
  /// solved what it met, which may be another problem.
  const StoredAnswer* failed() const {
    return best([this](const StoredAnswer& a) {
      return a.solver_id != engine && !a.errors.solved && a.errors.velocity_residual_m_per_s > 0; },
                [](const StoredAnswer& a, const StoredAnswer& b) { return gravity(a) > gravity(b); });
  }

  static double time(const StoredAnswer& answer) { return answer.times.setup_cpu_s + answer.times.solve_cpu_s; }
  static std::pair<bool, double> gravity(const StoredAnswer& answer) {
    return {answer.verdict == Verdict::kWrong, answer.errors.velocity_residual_m_per_s};
  }

 private:
  template <class Counts, class Before>
  const StoredAnswer* best(Counts counts, Before before) const {
    const StoredAnswer* found = nullptr;
    for (const StoredAnswer& answer : answers) {
      if (counts(answer) && (found == nullptr || before(answer, *found))) found = &answer;
    }
    return found;
  }
};

struct OpenedSet {
  std::shared_ptr<const ScenesFile> file;
  std::string name;                        ///< "scene/stack/ode" or "F.scenes": before '#'
  std::string family;                      ///< the scene, whatever engine captured it
  std::optional<std::int64_t> only = {};  ///< of a set that is one step: its number

  std::size_t index(std::int64_t trial) const {
    return only ? file->index_of(*only) : static_cast<std::size_t>(trial);
  }
};

/// nullopt for a set without captured steps. @throws InputError where its file cannot be read
std::optional<OpenedSet> open_steps(const std::string& set) {
  for (const CollectedScene& scene : collected_scenes()) {
    if (scene.name == set) return OpenedSet{open_collected(scene), set, set.substr(0, set.rfind('/'))};
  }
  constexpr std::string_view kFile = "file:";
  if (!set.starts_with(kFile)) return std::nullopt;
  const std::string path = set.substr(kFile.size());
  const auto step = scenes_step(path);
  if (!step && !is_scenes_file(path)) return std::nullopt;
  const std::string file = step ? step->first : path;
  return OpenedSet{std::make_shared<ScenesFile>(file), file, file,
                   step ? std::optional(step->second) : std::nullopt};
}

/// Of every step that has a verified answer and one that failed.
std::vector<StoredStep> telling_steps(Store& store, const std::map<std::int64_t, SolverRow>& solvers) {
  std::vector<StoredStep> steps;
  for (const auto& [id, name] : store.sets()) {
    if (!name.starts_with("scene/") && !name.starts_with("file:")) continue;
    std::map<std::int64_t, StoredStep> of_problem;
    store.for_each_answer(
        [&](const StoredAnswer& answer) {
          if (!solvers.contains(answer.solver_id) || !answer.errors.usable) return;
          StoredStep& step = of_problem[answer.problem_id];
          step.set = name;
          if (solvers.at(answer.solver_id).name == "engine") step.engine = answer.solver_id;
          step.answers.push_back(answer);
        },
        id);
    for (auto& [problem, step] : of_problem) {
      if (step.verified() != nullptr && step.failed() != nullptr) steps.push_back(std::move(step));
    }
  }
  std::stable_sort(steps.begin(), steps.end(), [](const StoredStep& a, const StoredStep& b) {
    return StoredStep::gravity(*a.failed()) > StoredStep::gravity(*b.failed());
  });
  return steps;
}

/// The verified answer, the failed one, then the others: solved ones first.
std::vector<ViewedAnswer> answers_of(Store& store, const StoredStep& step, const Problem& problem,
                                     const std::map<std::int64_t, SolverRow>& solvers) {
  std::vector<const StoredAnswer*> order{step.verified(), step.failed()};
  for (const bool solved : {true, false}) {
    for (const StoredAnswer& answer : step.answers) {
      const bool there = &answer == order[0] || &answer == order[1];
      if (!there && answer.errors.solved == solved) order.push_back(&answer);
    }
  }
  order.resize(std::min(order.size(), kMostAnswers));
  std::vector<ViewedAnswer> answers;
  for (const StoredAnswer* stored : order) {
    const std::optional<Answer> answer = store.answer(stored->problem_id, stored->solver_id);
    const SolverRow& solver = solvers.at(stored->solver_id);
    answers.push_back({.solver = solver.text(),
                       .model = friction_model(solver.friction, problem),
                       .claim = stored->claim,
                       .verdict = stored->verdict,
                       .errors = stored->errors,
                       .time_s = StoredStep::time(*stored),
                       .z = answer ? Vector(answer->z) : Vector()});
  }
  return answers;
}

}  // namespace

std::vector<nlohmann::ordered_json> stored_step_views(Store& store, std::size_t most, std::size_t bytes) {
  std::map<std::int64_t, SolverRow> solvers;
  for (const StoredSolver& solver : store.solvers()) {
    if (solver.row.sweep.empty()) solvers[solver.id] = solver.row;
  }
  std::vector<nlohmann::ordered_json> views;
  std::set<std::string> shown;  // scenes, whatever engine captured them
  for (const StoredStep& stored : telling_steps(store, solvers)) {
    if (views.size() == most) break;
    try {
      const std::optional<OpenedSet> set = open_steps(stored.set);
      if (!set || shown.contains(set->family)) continue;
      const SceneStep step = set->file->read(set->index(stored.answers.front().trial));
      if (problem_hash(step.problem) != stored.answers.front().hash) continue;
      nlohmann::ordered_json view = step_view(set->file->header(), step, fmt::format("{}#{}", set->name, step.step),
                                              answers_of(store, stored, step.problem, solvers));
      while (view["answers"].size() > 2 && view.dump().size() > bytes) view["answers"].erase(view["answers"].size() - 1);
      if (view.dump().size() > bytes) continue;
      views.push_back(std::move(view));
      shown.insert(set->family);
    } catch (const InputError&) {  // the file has changed, or is gone
    }
  }
  return views;
}

}  // namespace lcpbench
