#include <fmt/format.h>

#include "study/paper/claim_tests.h"
#include "study/paper/solvability.h"

namespace lcpbench::paper::claim_tests {
namespace {

bool numbered(const Experiment& where) { return where.name != "extra100"; }

/// The solved share of all trials, those proven unsolvable among them, at the parameterisation that the even trials
/// choose, on the odd ones.
Proportion solved_of_all_trials(const Grid& grid) {
  const Cell* chosen = range_of(grid, Measure::kVerdict).chosen;
  if (chosen == nullptr) return {};
  const Cell::Half& odd = chosen->halves[1];
  return {static_cast<double>(odd.solved), static_cast<double>(odd.trials)};
}

/// The odd trials' share solved, of all, against what theory says can be solved: within 2 points on either side.
void add_ceiling(const Grid& grid, const char* name, double ceiling, std::vector<Comparison>& into) {
  constexpr double kMargin = 0.02;
  const LinearCombination gap{{{1, solved_of_all_trials(grid)}}};
  const std::string what = fmt::format("{}, {}: share solved at the best parameters (theory: {} % can be solved)", name,
                                       code(grid.label), points(ceiling));
  const std::string scope = scope_of(grid.problems.redundancy(), Measure::kVerdict);
  into.push_back(compare_between(what, scope, gap, ceiling - kMargin, ceiling + kMargin));
}

}  // namespace

Claim monotone_is_easier(const Study& study) {
  Claim claim{.id = "monotone-easier",
              .statement = "Monotone (frictionless) problems are easier to solve than copositive (frictional) ones.",
              .rule =
                  "Average share solved over a solver's parameters: monotone less copositive is above 0, for every "
                  "experiment, reading and measure.",
              .needs = "one sweep on both kinds of the same experiment",
              .on_every_set = true};
  const auto add = [&study](const std::vector<std::string>& solvers, std::vector<Comparison>& into) {
    for (const std::string& label : solvers) {
      for_each_set(numbered, [&](const Experiment& where, const std::string& reading) {
        const Grid* monotone = find_grid(study.grids, Kind::kMonotone, where, reading, label);
        const Grid* copositive = find_grid(study.grids, Kind::kCopositive, where, reading, label);
        if (monotone == nullptr || copositive == nullptr) return;
        for (const Measure measure : kMeasures) {
          into.push_back(compare(
              std::string(where.name) + ", " + code(label) + ": average on monotone − copositive",
              scope_of(reading, measure),
              difference(range_of(*monotone, measure).average, range_of(*copositive, measure).average), 0, true));
        }
      });
    }
  };
  add(labels(study, Kind::kMonotone, true), claim.comparisons);
  add(labels(study, Kind::kMonotone, false), claim.beyond);
  return claim;
}

Claim redundancy_lowers_a_little(const Study& study) {
  constexpr double kLittle = 0.1;
  Claim claim{.id = "redundancy-a-little",
              .statement = "Redundant contacts (Experiment 2) lower solubility a little.",
              .rule =
                  "Average over the parameters, Experiment 1 less Experiment 2, lies between 0 and 10 points (the "
                  "paper's own averages fall by 3 to 9): the whole interval has to.",
              .needs = "one sweep on exp1 and exp2"};
  for (const Kind kind : kKinds) {
    for (const std::string& label : labels(study, kind, true)) {
      for (const char* reading : kReadings) {
        const Grid* plain = grid_of(study, kind, "exp1", reading, label);
        const Grid* redundant = grid_of(study, kind, "exp2", reading, label);
        if (plain == nullptr || redundant == nullptr) continue;
        for (const Measure measure : kMeasures) {
          const LinearCombination drop =
              difference(range_of(*plain, measure).average, range_of(*redundant, measure).average);
          const std::string what = std::string(name_of(kind)) + ", " + code(label) + ": Experiment 1 − 2";
          claim.comparisons.push_back(compare_between(what, scope_of(reading, measure), drop, 0, kLittle));
        }
      }
    }
  }
  return claim;
}

Claim rank_lowers_far_more(const Study& study) {
  Claim claim{
      .id = "rank-far-more",
      .statement = "An inertia of reduced rank (Experiment 3) lowers solubility far more than redundant contacts do.",
      .rule =
          "“Far more”: at least twice as much. Average by the paper's criterion: the drop from Experiment 1 to "
          "3, less twice the drop from 1 to 2, is above 0. Explained when, monotone, Lemke at its best solves "
          "within 2 points of the share that has a solution at all.",
      .cause =
          "With an inertia of reduced rank many problems have no solution, and of the others the criterion "
          "rejects right answers: its work test presupposes a regular inertia.",
      .needs = "one sweep on exp1, exp2 and exp3"};
  for (const Kind kind : kKinds) {
    for (const std::string& label : labels(study, kind, true)) {
      const Grid* reduced = grid_of(study, kind, "exp3", kReadings.front(), label);
      for (const char* reading : kReadings) {
        const Grid* plain = grid_of(study, kind, "exp1", reading, label);
        const Grid* redundant = grid_of(study, kind, "exp2", reading, label);
        if (plain == nullptr || redundant == nullptr || reduced == nullptr) continue;
        const auto average = [](const Grid* grid) { return range_of(*grid, Measure::kCriterion).average; };
        const LinearCombination excess{{{-1, average(plain)}, {-1, average(reduced)}, {2, average(redundant)}}};
        claim.comparisons.push_back(compare(
            std::string(name_of(kind)) + ", " + code(label) + ": drop from Experiment 1 to 3 − twice that from 1 to 2",
            scope_of(reading, Measure::kCriterion), excess, 0, true));
      }
      if (reduced != nullptr && kind == Kind::kMonotone && family_of(reduced->solver) == Family::kLemke) {
        add_ceiling(*reduced, "monotone Experiment 3", solvable_share_of_exp3(), claim.explanation);
      }
    }
  }
  return claim;
}

Claim four_above_three(const Study& study) {
  Claim claim{.id = "exp4-above-exp3",
              .statement =
                  "Experiment 4 (reduced inertia and redundant contacts) is solved more often than Experiment 3, "
                  "counterintuitively.",
              .rule =
                  "By the paper's criterion: average and held-out best over the parameters of Experiment 4, less "
                  "Experiment 3, are above 0. Explained when, monotone with contacts that are multiples, Lemke at its "
                  "best solves within 2 points of the share that has a solution, in both experiments.",
              .cause =
                  "A problem without solution needs, generically, rank(N) > rank(G). Redundancy lowers rank(N), so "
                  "fewer problems of Experiment 4 are unsolvable.",
              .needs = "one sweep on exp3 and exp4"};
  for (const Kind kind : kKinds) {
    for (const std::string& label : labels(study, kind, true)) {
      for (const char* reading : kReadings) {
        const Grid* three = grid_of(study, kind, "exp3", reading, label);
        const Grid* four = grid_of(study, kind, "exp4", reading, label);
        if (three == nullptr || four == nullptr) continue;
        const std::string who = std::string(name_of(kind)) + ", " + code(label);
        for (const Measure measure : kMeasures) {
          const GridRange low = range_of(*three, measure);
          const GridRange high = range_of(*four, measure);
          auto& into = measure == Measure::kCriterion ? claim.comparisons : claim.beyond;
          into.push_back(compare(who + ": average, Experiment 4 − 3", scope_of(reading, measure),
                                 difference(high.average, low.average), 0, true));
          into.push_back(compare(who + ": best held out, Experiment 4 − 3", scope_of(reading, measure),
                                 difference(high.held_out, low.held_out), 0, true));
        }
        const Cell* some_three = three->cells.front();
        const Cell* some_four = four->cells.front();
        claim.beyond.push_back(compare(
            std::string(name_of(kind)) + ": share proven unsolvable in this store, Experiment 3 − 4", reading,
            difference({static_cast<double>(some_three->unsolvable_problems), static_cast<double>(some_three->trials)},
                       {static_cast<double>(some_four->unsolvable_problems), static_cast<double>(some_four->trials)}),
            0, true));
        const bool has_theory = kind == Kind::kMonotone && reading == std::string(kReadings.front());
        if (!has_theory || family_of(three->solver) != Family::kLemke) continue;
        add_ceiling(*three, "monotone Experiment 3", solvable_share_of_exp3(), claim.explanation);
        add_ceiling(*four, "monotone Experiment 4", solvable_share_of_exp4(), claim.explanation);
      }
    }
  }
  return claim;
}

Claim ceilings_matter_little(const Study& study) {
  constexpr double kLimited = 0.1;
  Claim claim{
      .id = "ceilings",
      .statement = "Raising the ceilings of coordinates and contacts from 15 and 20 to 100 has a limited effect.",
      .rule =
          "Held-out best of exp5-1e10 less that of extra100, both of condition 1e10, is below 10 points (the "
          "paper's, copositive Lemke, is 8).",
      .needs = "one sweep on exp5-1e10 and extra100"};
  for (const Kind kind : kKinds) {
    for (const std::string& label : labels(study, kind, true)) {
      for (const char* reading : kReadings) {
        const Grid* small = grid_of(study, kind, "exp5-1e10", reading, label);
        const Grid* large = grid_of(study, kind, "extra100", reading, label);
        if (small == nullptr || large == nullptr) continue;
        for (const Measure measure : kMeasures) {
          claim.comparisons.push_back(compare(
              std::string(name_of(kind)) + ", " + code(label) + ": exp5-1e10 − extra100", scope_of(reading, measure),
              difference(range_of(*small, measure).held_out, range_of(*large, measure).held_out), kLimited, false));
        }
      }
    }
  }
  return claim;
}

}  // namespace lcpbench::paper::claim_tests
