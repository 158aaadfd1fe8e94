#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "generators/scenes/scenes.h"
#include "study/output/columns.h"
#include "study/view/view.h"

namespace lcpbench {
namespace {

using Solvers = std::map<std::int64_t, SolverRow>;

constexpr std::size_t kMostAnswers = 12;  // to a step

/// A set's file of captured steps.
struct StepsOfSet {
  std::shared_ptr<const ScenesFile> file;
  std::string name;                        ///< "scene/stack/ode" or "F.scenes": before '#'
  std::string scene;                       ///< whatever engine captured it
  std::optional<std::int64_t> only = {};  ///< of a set that is one step: its number
};

/// nullopt for a set without captured steps. @throws InputError where its file cannot be read
std::optional<StepsOfSet> open_steps(const std::string& set) {
  for (const CollectedScene& scene : collected_scenes()) {
    if (scene.name == set) return StepsOfSet{open_collected(scene), set, set.substr(0, set.rfind('/'))};
  }
  const std::string path = set.starts_with("file:") ? set.substr(5) : "";
  const auto step = scenes_step(path);
  if (!step && !is_scenes_file(path)) return std::nullopt;
  const std::string file = step ? step->first : path;
  return StepsOfSet{std::make_shared<ScenesFile>(file), file, file, step ? std::optional(step->second) : std::nullopt};
}

/// The answers to one step: the fastest verified one, the one that failed, then others.
struct StoredStep {
  std::string set;
  std::vector<StoredAnswer> answers;
};

/// Infinite where nobody timed it.
double time_of(const StoredAnswer& answer) {
  const double time = answer.times.setup_cpu_s + answer.times.solve_cpu_s;
  return std::isnan(time) ? std::numeric_limits<double>::infinity() : time;
}

/// Of a failure: false claims are graver than others, then the residual decides.
std::pair<bool, double> gravity(const StoredAnswer& answer) {
  return {answer.verdict == Verdict::kWrong, answer.errors.velocity_residual_m_per_s};
}

/// @returns whether the step has a verified answer and one that failed, which then come first. The engine that captured
/// the step solved what it met, which may be another problem.
bool put_in_order(std::vector<StoredAnswer>& answers, const Solvers& solvers) {
  const auto solved = [](const StoredAnswer& answer) { return answer.errors.solved; };
  const auto failed = [&](const StoredAnswer& answer) {
    return !solved(answer) && answer.errors.velocity_residual_m_per_s > 0 &&
           solvers.at(answer.solver_id).name != "engine";
  };
  std::stable_sort(answers.begin(), answers.end(), [&](const StoredAnswer& a, const StoredAnswer& b) {
    if (solved(a) != solved(b)) return solved(a);
    if (solved(a)) return time_of(a) < time_of(b);
    return failed(a) != failed(b) ? failed(a) : failed(a) && gravity(a) > gravity(b);
  });
  const auto worst = std::find_if(answers.begin(), answers.end(), failed);
  if (answers.empty() || answers.front().verdict != Verdict::kSolved || worst == answers.end()) return false;
  std::rotate(answers.begin() + 1, worst, worst + 1);
  answers.resize(std::min(answers.size(), kMostAnswers));
  return true;
}

/// The gravest first. Drops the others: a report shows one step of a scene, and the next where that has too many bytes.
void keep_gravest(std::vector<StoredStep>& steps, std::size_t most) {
  std::stable_sort(steps.begin(), steps.end(), [](const StoredStep& a, const StoredStep& b) {
    return gravity(a.answers[1]) > gravity(b.answers[1]);
  });
  if (steps.size() > most) steps.resize(most);
}

/// Steps with a verified answer and one that failed, of each set the gravest, the gravest of all first.
std::vector<StoredStep> telling_steps(Store& store, const Solvers& solvers) {
  constexpr std::size_t kMost = 64;  // of a set
  std::vector<StoredStep> steps;
  for (const auto& [id, name] : store.sets()) {
    if (!name.starts_with("scene/") && !name.starts_with("file:")) continue;
    std::vector<StoredStep> of_set;
    std::vector<StoredAnswer> answers;  // to one problem
    const auto finish = [&] {
      if (put_in_order(answers, solvers)) of_set.push_back({name, answers});
      if (of_set.size() > 2 * kMost) keep_gravest(of_set, kMost);
      answers.clear();
    };
    const auto collect = [&](const StoredAnswer& answer) {
      if (!answers.empty() && answers.front().problem_id != answer.problem_id) finish();
      if (solvers.contains(answer.solver_id) && answer.errors.usable) answers.push_back(answer);
    };
    store.for_each_answer(collect, id);
    finish();
    keep_gravest(of_set, kMost);
    std::move(of_set.begin(), of_set.end(), std::back_inserter(steps));
  }
  keep_gravest(steps, steps.size());
  return steps;
}

ViewedAnswer viewed(Store& store, const StoredAnswer& stored, const SolverRow& solver, const Problem& problem,
                    const std::string& engine) {
  const std::optional<Answer> answer = store.answer(stored.problem_id, stored.solver_id);
  return {.solver = solver_label(solver.text(), engine),
          .model = friction_model(solver.friction, problem),
          .claim = stored.claim,
          .verdict = stored.verdict,
          .errors = stored.errors,
          .time_s = time_of(stored),
          .z = answer ? Vector(answer->z) : Vector()};
}

}  // namespace

std::vector<Json> stored_step_views(Store& store, std::size_t most, std::size_t bytes) {
  Solvers solvers;
  for (const StoredSolver& solver : store.solvers()) {
    if (solver.row.sweep.empty()) solvers[solver.id] = solver.row;
  }
  std::vector<Json> views;
  std::set<std::string> shown;  // scenes
  for (const StoredStep& stored : telling_steps(store, solvers)) {
    if (views.size() == most) break;
    try {
      const std::optional<StepsOfSet> set = open_steps(stored.set);
      if (!set || shown.contains(set->scene)) continue;
      const StoredAnswer& first = stored.answers.front();
      const SceneStep step =
          set->file->read(set->only ? set->file->index_of(*set->only) : static_cast<std::size_t>(first.trial));
      if (problem_hash(step.problem) != first.hash) continue;
      std::vector<ViewedAnswer> answers;
      for (const StoredAnswer& each : stored.answers) {
        answers.push_back(
            viewed(store, each, solvers.at(each.solver_id), step.problem, set->file->header().engine_label()));
      }
      Json view =
          step_view(set->file->header(), step, fmt::format("{}#{}", set->name, step.step), answers);
      const auto is_too_long = [&] { return view.dump().size() > bytes + view["shapes"].dump().size(); };
      while (view["answers"].size() > 2 && is_too_long()) view["answers"].erase(view["answers"].size() - 1);
      if (is_too_long()) continue;
      views.push_back(std::move(view));
      shown.insert(set->scene);
    } catch (const InputError&) {  // the file has changed, or is gone
    }
  }
  return views;
}

}  // namespace lcpbench
