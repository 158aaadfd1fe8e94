#include <algorithm>

#include <fmt/format.h>

#include "study/paper/claim_tests.h"

namespace lcpbench::paper::claim_tests {
namespace {

Proportion false_claim_share(const Grid& grid) {
  double share = 0;
  double fewest = 0;
  for (const Cell* cell : grid.cells) {
    const auto trials = static_cast<double>(cell->trials);
    share += static_cast<double>(cell->false_claims()) / trials / static_cast<double>(grid.cells.size());
    fewest = fewest == 0 ? trials : std::min(fewest, trials);
  }
  return {share * fewest, fewest};
}

/// A regularised solver on Experiment 6 with what it wraps on Experiment 5: the same problems.
struct Regularization {
  const Grid* with = nullptr;
  const Grid* without = nullptr;
  std::string condition;
};

std::vector<Regularization> regularizations(const Study& study, Kind kind, const std::string& reading) {
  std::vector<Regularization> found;
  for (const Experiment& where : experiments()) {
    if (!where.regularized) continue;
    const std::string plain = "exp5-" + std::string(where.condition);
    for (const std::string& label : labels(study, kind, true)) {
      const Grid* with = find_grid(study.grids, kind, where, reading, label);
      if (with == nullptr) continue;
      for (const Grid* without : wrapped_grids(study.grids, *with, experiment(plain), reading)) {
        found.push_back({with, without, std::string(where.condition)});
      }
    }
  }
  return found;
}

std::string words_of(const Regularization& pair) {
  return code(pair.with->label) + " against " + code(pair.without->label) + ", condition " + pair.condition;
}

/// Pairs of single settings: a regularised solver on Experiment 6 with what it wraps on Experiment 5.
void add_single_regularizations(const Study& study, Kind kind, const std::string& reading,
                                std::vector<Comparison>& into) {
  for (const Cell& with : study.summary.cells) {
    const SolverRow& row = study.summary.solvers[with.solver];
    const std::optional<PaperSet> problems = paper_set(study.summary.sets[with.set].name);
    const bool fits = problems && problems->kind == kind && problems->redundancy() == reading &&
                      problems->other_readings().empty() && problems->experiment->regularized;
    const std::string wrapped = wrapped_solver(row.text());
    if (!row.sweep.empty() || wrapped.empty() || !fits || with.refused()) continue;
    const Experiment& plain = experiment("exp5-" + std::string(problems->experiment->condition));
    const Cell* without = single_cell(study, set_name(kind, plain, reading), wrapped, row);
    if (without == nullptr) continue;
    const PairedCounts pairs = pair_by_trial(with, *without);
    if (pairs.problems() == 0) continue;
    into.push_back(compare(fmt::format("{}, single settings: {} against {}, condition {}", name_of(kind),
                                       code(row.text()), code(wrapped), problems->experiment->condition),
                           scope_of(reading, Measure::kVerdict), pairs, 0, true));
  }
}

}  // namespace

Claim regularization_gains(const Study& study) {
  Claim claim{.id = "regularisation-gain",
              .statement = "Regularisation raises the share solved (Experiment 6 against 5).",
              .rule =
                  "Average over the parameters with regularisation, less that of the wrapped solver without, on the "
                  "same problems, is above 0; where both were run at single settings, also in pairs (McNemar).",
              .needs = "a sweep of regularized on exp6 and of the solver it wraps on exp5"};
  for (const Kind kind : kKinds) {
    for (const char* reading : kReadings) {
      for (const Regularization& pair : regularizations(study, kind, reading)) {
        for (const Measure measure : kMeasures) {
          claim.comparisons.push_back(compare(
              std::string(name_of(kind)) + ": " + words_of(pair), scope_of(reading, measure),
              difference(range_of(*pair.with, measure).average, range_of(*pair.without, measure).average), 0, true));
        }
      }
      add_single_regularizations(study, kind, reading, claim.comparisons);
    }
  }
  return claim;
}

Claim regularization_closes_the_gap(const Study& study) {
  constexpr double kKept = 2.0 / 3;
  Claim claim{.id = "regularisation-closes-gap",
              .statement = "Regularisation removes much of the advantage of monotone problems.",
              .rule =
                  "“Much”: at least a third of it, as in the paper's own averages at all three condition numbers. Two "
                  "thirds of the advantage (average, monotone less copositive) in Experiment 5, less the advantage in "
                  "Experiment 6, is above 0.",
              .needs = "sweeps of regularized on exp6 and of the solver it wraps on exp5, both kinds"};
  for (const char* reading : kReadings) {
    for (const Regularization& monotone : regularizations(study, Kind::kMonotone, reading)) {
      for (const Regularization& copositive : regularizations(study, Kind::kCopositive, reading)) {
        const bool same = monotone.condition == copositive.condition &&
                          monotone.with->label == copositive.with->label &&
                          monotone.without->label == copositive.without->label;
        if (!same) continue;
        for (const Measure measure : kMeasures) {
          const auto average = [measure](const Grid* grid) { return range_of(*grid, measure).average; };
          const LinearCombination change{{{kKept, average(monotone.without)},
                                          {-kKept, average(copositive.without)},
                                          {-1, average(monotone.with)},
                                          {1, average(copositive.with)}}};
          claim.comparisons.push_back(
              compare("2/3 of the advantage without − the advantage with: " + words_of(monotone),
                      scope_of(reading, measure), change, 0, true));
        }
      }
    }
  }
  return claim;
}

Claim regularization_costs_time(const Study& study) {
  constexpr double kTie = 1.05;  // smaller differences of times are ties everywhere in this project
  Claim claim{.id = "regularisation-cost",
              .statement = "Regularisation takes significant additional running time.",
              .rule =
                  "Mean time per problem over all parameters with regularisation, over that of the wrapped solver "
                  "without, on the same problems, is above 1.05.",
              .needs = "a timed sweep of regularized on exp6 and of the solver it wraps on exp5"};
  for (const Kind kind : kKinds) {
    for (const char* reading : kReadings) {
      for (const Regularization& pair : regularizations(study, kind, reading)) {
        const RatioOfMeans ratio{over_all(*pair.with, Quantity::kTimeAll, Measure::kCriterion),
                                 over_all(*pair.without, Quantity::kTimeAll, Measure::kCriterion)};
        claim.comparisons.push_back(
            compare(std::string(name_of(kind)) + ": " + words_of(pair), reading, ratio, kTie, true));
      }
    }
  }
  return claim;
}

Claim regularization_stays_honest(const Study& study) {
  constexpr double kMargin = 0.01;
  Claim claim{.id = "regularisation-false-claims",
              .statement =
                  "Not in the paper, implied by its use: regularisation makes no more false claims than the "
                  "solver it wraps.",
              .rule =
                  "Share of answers claimed solved that are wrong, average over the parameters: with regularisation "
                  "less without is below 1 point.",
              .needs = "a sweep of regularized on exp6 and of the solver it wraps on exp5"};
  for (const Kind kind : kKinds) {
    for (const char* reading : kReadings) {
      for (const Regularization& pair : regularizations(study, kind, reading)) {
        claim.comparisons.push_back(
            compare(std::string(name_of(kind)) + ": " + words_of(pair), scope_of(reading, Measure::kVerdict),
                    difference(false_claim_share(*pair.with), false_claim_share(*pair.without)), kMargin, false));
      }
    }
  }
  return claim;
}

}  // namespace lcpbench::paper::claim_tests
