#include "study/stability/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "study/evaluation/evaluation.h"
#include "study/stability/physical_answer.h"

namespace lcpbench {
namespace {

/// One answer, judged.
struct Judged {
  Claim claim = Claim::kUnsupported;
  bool solved = false;
  bool false_claim = false;
  double residual = 0;
  std::int64_t pivots = -1;
  Vector physical;  ///< of solved answers, in the coordinates of the original
};

bool stopped(const StabilityOptions& options) { return options.stop != nullptr && *options.stop != 0; }

Judged judged(PhysicalAnswers& physical, const Answer& answer, const Errors& errors, Truth truth) {
  Judged row;
  const Verdict given = verdict(answer.claim, errors, truth);
  row.claim = answer.claim;
  row.solved = given == Verdict::kSolved;
  row.false_claim = given == Verdict::kWrong;
  row.residual =
      std::isnan(errors.velocity_residual_relative) ? errors.backward_row_norm : errors.velocity_residual_relative;
  row.pivots = answer.counters.pivots;
  if (row.solved) row.physical = physical.of(answer);
  return row;
}

/// The outcome of one solver's answers over all draws of one kind.
struct Fate {
  bool refused = false;
  bool kept = true;
  bool turned_false = false;
  double change = 0;
  double relative_change = 0;  ///< to what conditioning allows
  double residual = 0;
  std::int64_t fewest_pivots = -1;
  std::int64_t most_pivots = -1;

  void add_pivots(std::int64_t pivots) {
    if (pivots < 0) return;
    fewest_pivots = fewest_pivots < 0 ? pivots : std::min(fewest_pivots, pivots);
    most_pivots = std::max(most_pivots, pivots);
  }
};

double larger(double a, double b) { return std::isnan(a) || a > b ? a : b; }  // NaN stays

class Experiment {
 public:
  Experiment(const std::vector<StudySolver>& solvers, const StabilityOptions& options) : options_(options) {
    for (const StudySolver& solver : solvers) {
      result_.solvers.push_back(solver.row.text());
      solvers_.push_back(solver.open());
    }
    for (const TransformationKind kind : kAllTransformations) {
      for (std::size_t s = 0; s < solvers.size(); ++s) {
        result_.cells.push_back({});
        result_.cells.back().kind = kind;
        result_.cells.back().solver = s;
      }
    }
  }

  void run(const StudySet& set) {
    result_.sets.push_back(set.set->name());
    if (options_.on_set) options_.on_set(set.set->name());
    for (std::int64_t trial = 0; trial < set.trials && !stopped(options_); ++trial) {
      const Problem problem = set.set->generate(options_.seed, trial);
      ++result_.problems;
      if (problem.size() > kLargestStabilityOrder) {
        ++result_.left_out;
        continue;
      }
      run(problem, set.set->name(), static_cast<std::uint64_t>(trial));
      if (stopped(options_)) --result_.problems;  // it is not done, at most in part
    }
  }

  StabilityResult result() && { return std::move(result_); }

 private:
  StabilityCell& cell(TransformationKind kind, std::size_t solver) {
    const auto k = static_cast<std::size_t>(std::find(kAllTransformations.begin(), kAllTransformations.end(), kind) -
                                            kAllTransformations.begin());
    return result_.cells[k * solvers_.size() + solver];
  }

  /// Asks all solvers for a problem, or one of its copies.
  /// @param known  of the problem already
  /// @returns a row for each solver; none where `stop` was raised
  std::vector<Judged> answers_to(const Problem& problem, Findings known) {
    Evaluator evaluator(problem);
    std::vector<Answer> answers;
    std::vector<Errors> errors;
    for (const std::unique_ptr<TimedSolver>& solver : solvers_) {
      if (stopped(options_)) return {};
      TimedRequest request;
      request.time_limit_s = options_.time_limit_s;
      TimedAnswer timed;
      solver->run(problem, request, timed);
      const Judgement judgement = evaluator.judge(timed.answer);
      known.add(judgement);
      errors.push_back(judgement.errors);
      answers.push_back(std::move(timed.answer));
    }
    PhysicalAnswers physical(problem);
    std::vector<Judged> rows;
    for (std::size_t s = 0; s < answers.size(); ++s) {
      rows.push_back(judged(physical, answers[s], errors[s], known.truth()));
    }
    return rows;
  }

  void run(const Problem& problem, const std::string& set, std::uint64_t trial) {
    problem_ = set + " trial " + std::to_string(trial);
    const bool solvable_nearby = Evaluator(problem).truth() == Truth::kSolvable;
    Findings known;
    if (solvable_nearby) known.add(Evidence::kTheory);
    const bool frictional = problem.contact() != nullptr && problem.contact()->frictional();
    const Distance distance(problem, solvable_nearby && !frictional);
    const std::vector<Judged> before = answers_to(problem, known);
    if (before.empty()) return;
    const auto any_solved = std::any_of(before.begin(), before.end(), [](const Judged& row) { return row.solved; });
    if (any_solved) known.add(Evidence::kSolvedAnswer);
    for (const TransformationKind kind : kAllTransformations) {
      if (perturbs(kind) && !solvable_nearby) continue;
      const TrialKey key{stream_id(std::string("stability/") + to_string(kind) + "/" + set), options_.seed, trial};
      run(problem, kind, key, known, distance, before);
    }
  }

  void run(const Problem& problem, TransformationKind kind, const TrialKey& key, const Findings& known,
           const Distance& distance, const std::vector<Judged>& before) {
    std::vector<Fate> fates(before.size());
    for (std::size_t s = 0; s < before.size(); ++s) fates[s].add_pivots(before[s].pivots);
    const int draws = kind == TransformationKind::kPermutation ? options_.permutations : 1;
    for (int draw = 0; draw < draws; ++draw) {
      const std::optional<Transformation> transformation =
          draw_transformation(kind, problem, key, static_cast<std::uint64_t>(draw));
      if (!transformation) return;
      const std::vector<Judged> after = answers_to(transformation->apply(problem), known);
      if (after.empty()) return;
      for (std::size_t s = 0; s < before.size(); ++s) {
        compare(before[s], after[s], *transformation, problem.contact() == nullptr, distance, fates[s]);
      }
    }
    for (std::size_t s = 0; s < before.size(); ++s) enter(before[s], fates[s], distance.unique(), cell(kind, s));
  }

  static void compare(const Judged& before, const Judged& after, const Transformation& transformation, bool bare,
                      const Distance& distance, Fate& fate) {
    fate.refused = fate.refused || after.claim == Claim::kUnsupported;
    fate.kept = fate.kept && after.solved;
    fate.turned_false = fate.turned_false || after.false_claim;
    fate.add_pivots(after.pivots);
    if (!before.solved || !after.solved) return;
    fate.residual = larger(after.residual, fate.residual);
    const Vector answer =
        bare ? transformation.unknowns_back(after.physical) : transformation.velocity_back(after.physical);
    const double change = distance(before.physical, answer);
    const double data = std::max(transformation.data_change, std::numeric_limits<double>::epsilon());
    fate.change = larger(change, fate.change);
    const double allowed = std::min(1.0, data * distance.condition());
    fate.relative_change = larger(change / allowed, fate.relative_change);
  }

  void enter(const Judged& before, const Fate& fate, bool unique, StabilityCell& cell) const {
    if (before.claim == Claim::kUnsupported || fate.refused) return;
    ++cell.asked;
    const bool turned_false = !before.false_claim && fate.turned_false;
    if (!before.false_claim) ++cell.honest;
    if (turned_false) ++cell.turned_false;
    const bool broken = turned_false || (before.solved && !fate.kept);
    if (broken && cell.examples.size() < StabilityCell::kExamples) cell.examples.push_back(problem_);
    if (!before.solved) return;
    ++cell.solved;
    if (!fate.kept) return;
    ++cell.kept;
    cell.residuals.push_back(fate.residual);
    if (unique) {
      if (!(fate.relative_change <= cell.largest_amplification())) cell.farthest = problem_;
      cell.changes.push_back(fate.change);
      cell.amplifications.push_back(fate.relative_change);
    } else {
      cell.distances.push_back(fate.change);
    }
    if (fate.fewest_pivots > 0) {
      cell.pivot_spreads.push_back(static_cast<double>(fate.most_pivots) / static_cast<double>(fate.fewest_pivots));
    }
  }

  const StabilityOptions& options_;
  std::vector<std::unique_ptr<TimedSolver>> solvers_;
  StabilityResult result_;
  std::string problem_;  ///< the one at hand, for examples
};

}  // namespace

double StabilityCell::largest_amplification() const {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const double amplification : amplifications) {
    if (!(largest >= amplification)) largest = amplification;
  }
  return largest;
}

StabilityResult stability(const std::vector<StudySet>& sets, const std::vector<StudySolver>& solvers,
                          const StabilityOptions& options) {
  Experiment experiment(solvers, options);
  for (const StudySet& set : sets) {
    if (!stopped(options)) experiment.run(set);
  }
  return std::move(experiment).result();
}

}  // namespace lcpbench
