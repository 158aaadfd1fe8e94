#include "study/stability/stability.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "study/evaluation/friction_model.h"
#include "study/statistics/statistics.h"
#include "study/stability/physical_answer.h"

namespace lcpbench {
namespace {

constexpr int kOrders = 5;  // drawn for each problem; of every other change one is drawn

/// One answer, judged.
struct Judged {
  Answer answer;
  FrictionModel model;
  Errors errors;  ///< by the model
  Verdict verdict = Verdict::kOpen;

  bool solved() const { return verdict == Verdict::kSolved; }
  bool false_claim() const { return verdict == Verdict::kWrong; }
  bool refused() const { return answer.claim == Claim::kUnsupported; }
  bool is_evidence() const { return model == FrictionModel::kPyramid; }  ///< of what the problem's truth is about
};

/// What becomes of one solver's answer over all draws of one change.
struct Fate {
  bool refused = false;
  bool kept = true;
  bool turned_false = false;
  double amplification = 0;
};

bool stopped(const StabilityOptions& options) { return options.stop != nullptr && *options.stop != 0; }

class Experiment {
 public:
  Experiment(const std::vector<StudySolver>& solvers, const StabilityOptions& options) : options_(options) {
    for (const StudySolver& solver : solvers) {
      result_.solvers.push_back(solver.row.text());
      solvers_.push_back(solver.open());
      models_.push_back(solver.row.friction);
    }
    for (const auto& [name, change] : all_changes().values) {
      if (change == Change::kHard) continue;  // it may change the physical answer as much as it likes
      for (std::size_t s = 0; s < solvers.size(); ++s) {
        StabilityCell& cell = result_.cells.emplace_back();
        cell.change = change;
        cell.solver = s;
      }
    }
  }

  void run(const StudySet& set) {
    result_.sets.push_back(set.set->name());
    if (options_.on_set) options_.on_set(set.set->name());
    for (std::int64_t trial = 0; trial < set.trials && !stopped(options_); ++trial) {
      const Problem problem = set.set->generate(options_.seed, trial);
      const bool too_large = problem.size() > kLargestStabilityOrder;
      if (!too_large && !run(problem, set.set->name(), trial)) return;
      ++result_.problems;
      result_.left_out += too_large ? 1 : 0;
    }
  }

  StabilityResult result() && { return std::move(result_); }

 private:
  /// Asks all solvers for a problem. @param known  of the problem already
  /// @returns a row for each solver; none where `stop` was raised before the last answer: it may have ended a worker
  std::vector<Judged> answers_to(const Problem& problem, Findings known) {
    Evaluator evaluator(problem);
    std::vector<Judged> rows;
    for (std::size_t s = 0; s < solvers_.size(); ++s) {
      TimedRequest request;
      request.time_limit_s = options_.time_limit_s;
      TimedAnswer timed;
      solvers_[s]->run(problem, request, timed);
      if (stopped(options_)) return {};
      Judgement judgement = evaluator.judge(timed.answer);
      const FrictionModel model = friction_model(models_[s], problem);
      measure_friction(model, problem, timed.answer, judgement.errors);
      rows.push_back({std::move(timed.answer), model, judgement.errors});
      if (rows.back().is_evidence()) known.add(judgement);
    }
    for (Judged& row : rows) {
      row.verdict = verdict(row.answer.claim, row.errors, row.is_evidence() ? known.truth() : Truth::kUnknown);
    }
    return rows;
  }

  /// Enters what becomes of the answers. @returns false, with nothing entered, where `stop` was raised before the last
  bool run(const Problem& problem, const std::string& set, std::int64_t trial) {
    const bool solvable_nearby = Evaluator(problem).truth() == Truth::kSolvable;
    Findings known;
    if (solvable_nearby) known.add(Evidence::kTheory);
    const std::vector<Judged> before = answers_to(problem, known);
    if (before.empty()) return false;
    const auto proves_solvable = [](const Judged& row) { return row.solved() && row.is_evidence(); };
    if (std::any_of(before.begin(), before.end(), proves_solvable)) known.add(Evidence::kSolvedAnswer);
    const ContactProblem* const contact = problem.contact();
    const bool may_differ = contact != nullptr && (contact->frictional() || contact->has_rows());
    const bool unique = solvable_nearby && !may_differ;
    const PhysicalAnswers physical(problem);
    const double condition = unique ? physical.condition() : 0;
    std::vector<std::pair<StabilityCell*, Fate>> entries;
    for (auto cell = result_.cells.begin(); cell != result_.cells.end(); cell += std::ssize(before)) {
      const Change by = cell->change;
      if (!applies(by, problem) || (data_change(by) > 0 && !solvable_nearby)) continue;
      const double allowed = std::min(1.0, condition * std::max(data_change(by), 0x1p-52));
      std::vector<Fate> fates(before.size());
      for (int draw = 0; draw < (by == Change::kOrder ? kOrders : 1); ++draw) {
        const DrawnChange change(by, set, options_.seed, trial, draw);
        const Problem changed = change.apply(problem, problem.name());
        const std::vector<Judged> after = answers_to(changed, known);
        if (after.empty()) return false;
        const PhysicalAnswers changed_physical(changed);
        for (std::size_t s = 0; s < before.size(); ++s) {
          Fate& fate = fates[s];
          fate.refused = fate.refused || after[s].refused();
          fate.kept = fate.kept && after[s].solved();
          fate.turned_false = fate.turned_false || after[s].false_claim();
          if (!unique || !before[s].solved() || !after[s].solved()) continue;
          const Vector answer = change.take_back(problem, changed_physical.of(after[s].answer));
          const double moved = physical.change(physical.of(before[s].answer), answer) / allowed;
          fate.amplification = std::isnan(moved) ? kInfinity : std::max(moved, fate.amplification);
        }
      }
      for (std::size_t s = 0; s < before.size(); ++s) {
        entries.emplace_back(&cell[static_cast<std::ptrdiff_t>(s)], fates[s]);
      }
    }
    const std::string name = set + " trial " + std::to_string(trial);
    for (const auto& [cell, fate] : entries) enter(name, before[cell->solver], fate, unique, *cell);
    return true;
  }

  static void enter(const std::string& name, const Judged& before, const Fate& fate, bool unique,
                    StabilityCell& cell) {
    if (before.refused() || fate.refused) return;
    ++cell.asked;
    cell.honest += before.false_claim() ? 0 : 1;
    const bool turned_false = !before.false_claim() && fate.turned_false;
    cell.turned_false += turned_false ? 1 : 0;
    const bool broken = turned_false || (before.solved() && !fate.kept);
    if (broken && cell.examples.size() < StabilityCell::kExamples) cell.examples.push_back(name);
    cell.solved += before.solved() ? 1 : 0;
    if (!before.solved() || !fate.kept) return;
    ++cell.kept;
    if (!unique) return;
    if (!(fate.amplification <= cell.largest_amplification())) cell.farthest = name;
    cell.amplifications.push_back(fate.amplification);
  }

  const StabilityOptions& options_;
  std::vector<std::unique_ptr<TimedSolver>> solvers_;
  std::vector<FrictionModel> models_;  ///< that the solvers solve
  StabilityResult result_;
};

}  // namespace

double StabilityCell::largest_amplification() const { return spread(amplifications).max; }

StabilityResult stability(const std::vector<StudySet>& sets, const std::vector<StudySolver>& solvers,
                          const StabilityOptions& options) {
  Experiment experiment(solvers, options);
  for (const StudySet& set : sets) {
    if (!stopped(options)) experiment.run(set);
  }
  return std::move(experiment).result();
}

}  // namespace lcpbench
