#include "study/paper/claims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "study/paper/solvability.h"
#include "study/paper/tables.h"

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kFamilyWiseError = 0.05;

/// What all claims read.
struct Study {
  const Summary& summary;
  const std::vector<Grid>& grids;
};

const Experiment& experiment(std::string_view name) { return *find_experiment(name); }

std::string scope_of(const std::string& reading, Measure measure) {
  return reading + ", " + (measure == Measure::kCriterion ? "criterion" : "verdict");
}

/// "copositive exp5-1e8"
std::string place(Kind kind, const Experiment& where) {
  return std::string(name_of(kind)) + " " + std::string(where.name);
}

Comparison compare(std::string what, std::string scope, const LinearCombination& quantity, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = quantity.value(),
          .bound = bound,
          .above = above,
          .interval = [quantity](double z) { return quantity.interval(z); }};
}

Comparison compare(std::string what, std::string scope, const RatioOfMeans& ratio, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = ratio.value(),
          .bound = bound,
          .above = above,
          .share = false,
          .interval = [ratio](double z) { return ratio.interval(z); }};
}

/// The quantity is claimed to lie above `low` and below `high`: it supports the claim only as a whole.
template <class Quantity>
Comparison compare_between(std::string what, std::string scope, const Quantity& quantity, double low, double high) {
  Comparison comparison = compare(std::move(what), std::move(scope), quantity, low, true);
  comparison.within = high;
  return comparison;
}

/// A ratio that is no estimate, such as that of two maxima.
Comparison shown(std::string what, std::string scope, double value, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = value,
          .bound = bound,
          .above = above,
          .share = false,
          .detail = "no estimate: it has no interval, and is not tested"};
}

Comparison compare(std::string what, std::string scope, const PairedCounts& pairs, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = pairs.difference(),
          .bound = bound,
          .above = above,
          .interval = [pairs](double z) { return pairs.interval(z); },
          .p_value = pairs.p_value(),
          .detail = fmt::format("{} problems in pairs, {} only the first, {} only the second; McNemar p = {:.2g}",
                                pairs.problems(), pairs.first_only, pairs.second_only, pairs.p_value())};
}

bool is_tested(const Comparison& comparison) { return static_cast<bool>(comparison.interval); }

/// @param level  error of this one comparison
Stance stance_of(const Comparison& comparison, double level) {
  if (!is_tested(comparison)) return Stance::kShown;
  if (comparison.p_value && !(*comparison.p_value <= level)) return Stance::kUndecided;
  const Interval interval = comparison.interval(normal_quantile(level));
  const bool is_above = interval.low > comparison.bound;
  const bool is_below = interval.high < comparison.bound;
  if (comparison.within) {
    if (is_below || interval.low > *comparison.within) return Stance::kOpposes;
    return is_above && interval.high < *comparison.within ? Stance::kSupports : Stance::kUndecided;
  }
  if (is_above) return comparison.above ? Stance::kSupports : Stance::kOpposes;
  if (is_below) return comparison.above ? Stance::kOpposes : Stance::kSupports;
  return Stance::kUndecided;
}

void decide(std::vector<Comparison>& comparisons) {
  std::erase_if(comparisons, [](const Comparison& comparison) { return std::isnan(comparison.value); });
  const auto tested = std::count_if(comparisons.begin(), comparisons.end(), is_tested);
  for (Comparison& comparison : comparisons) {
    comparison.stance =
        stance_of(comparison, kFamilyWiseError / static_cast<double>(std::max<std::ptrdiff_t>(tested, 1)));
  }
}

std::ptrdiff_t count(const std::vector<Comparison>& comparisons, Stance stance) {
  return std::count_if(comparisons.begin(), comparisons.end(),
                       [stance](const Comparison& comparison) { return comparison.stance == stance; });
}

/// Every comparison that tests the cause supports it, and there is one.
bool is_explained(const Claim& claim) {
  return !claim.explanation.empty() &&
         count(claim.explanation, Stance::kSupports) == static_cast<std::ptrdiff_t>(claim.explanation.size());
}

Word word_of(const Claim& claim) {
  const std::ptrdiff_t supporting = count(claim.comparisons, Stance::kSupports);
  const std::ptrdiff_t opposing = count(claim.comparisons, Stance::kOpposes);
  const std::ptrdiff_t undecided = count(claim.comparisons, Stance::kUndecided);
  if (supporting + opposing + undecided == 0) return Word::kNotTested;
  if (opposing > 0) return supporting > 0 ? Word::kInPart : Word::kContradicted;
  if (supporting == 0) return Word::kUndecided;
  if (claim.on_every_set && undecided > 0) return supporting >= undecided ? Word::kInPart : Word::kUndecided;
  return is_explained(claim) ? Word::kExplained : Word::kConfirmed;
}

// --- what claims compare ---

/// Labels of the paper's own solvers, or of all others, that the store has of a kind.
std::vector<std::string> labels(const Study& study, Kind kind, bool of_the_paper) {
  std::set<std::string> found;
  for (const Grid& grid : study.grids) {
    const bool in_paper = family_of(grid.solver).has_value();
    if (grid.problems.kind == kind && grid.problems.other_readings().empty() && in_paper == of_the_paper) {
      found.insert(grid.label);
    }
  }
  return {found.begin(), found.end()};
}

std::vector<std::string> labels_of(const Study& study, Kind kind, Family family) {
  std::set<std::string> found;
  for (const Grid& grid : study.grids) {
    if (grid.problems.kind == kind && grid.problems.other_readings().empty() && family_of(grid.solver) == family) {
      found.insert(grid.label);
    }
  }
  return {found.begin(), found.end()};
}

const Grid* grid_of(const Study& study, Kind kind, std::string_view where, const std::string& reading,
                    const std::string& label) {
  return find_grid(study.grids, kind, experiment(where), reading, label);
}

/// The solved share of all trials, those proven unsolvable among them, at the parameterisation that the even trials
/// choose, on the odd ones.
Proportion solved_of_all_trials(const Grid& grid) {
  const Cell* chosen = range_of(grid, Measure::kVerdict).chosen;
  if (chosen == nullptr) return {};
  const Cell::Half& odd = chosen->halves[1];
  return {static_cast<double>(odd.solved), static_cast<double>(odd.trials)};
}

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

/// Whether what is compared are solvers rather than instruction-set levels; libraries have none.
bool same_level(const SolverRow& a, const SolverRow& b) { return a.isa.empty() || b.isa.empty() || a.isa == b.isa; }

/// Single parameterisations, not those of sweeps, of a set.
/// @param partner  the row that it is compared with
const Cell* single_cell(const Study& study, const std::string& set, const std::string& solver,
                        const SolverRow& partner) {
  for (const Cell& cell : study.summary.cells) {
    const SolverRow& row = study.summary.solvers[cell.solver];
    const bool fits = row.sweep.empty() && row.text() == solver && same_level(row, partner);
    if (fits && study.summary.sets[cell.set].name == set && !cell.refused()) return &cell;
  }
  return nullptr;
}

/// The trials that both met and took, by seed and number: on one set, or on two sets that have the same problems.
PairedCounts pair_by_trial(const Cell& first, const Cell& second) {
  std::map<std::pair<std::int64_t, std::int64_t>, const Outcome*> others;
  for (const Outcome& outcome : second.outcomes) others.emplace(std::pair{outcome.seed, outcome.trial}, &outcome);
  const auto counts = [](const Outcome& outcome) { return !outcome.unsolvable && !outcome.refused; };
  PairedCounts pairs;
  for (const Outcome& outcome : first.outcomes) {
    const auto other = others.find({outcome.seed, outcome.trial});
    if (other == others.end() || !counts(outcome) || !counts(*other->second)) continue;
    const bool also = other->second->solved;
    ++(outcome.solved ? (also ? pairs.both : pairs.first_only) : (also ? pairs.second_only : pairs.neither));
  }
  return pairs;
}

std::string set_name(Kind kind, const Experiment& where, const std::string& reading) {
  std::string name = std::string("paper/") + name_of(kind) + "/" + std::string(where.name);
  if (where.redundant && reading != kReadings.front()) name += "{redundancy=" + reading + "}";
  return name;
}

/// Calls visit(where, reading) for the experiments that `picks` takes.
template <class Picks, class Visit>
void for_each_set(Picks picks, Visit visit) {
  for (const Experiment& where : experiments()) {
    if (!picks(where)) continue;
    for (const std::string& reading : readings_of(where)) visit(where, reading);
  }
}

bool numbered(const Experiment& where) { return where.name != "extra100"; }

// --- the claims ---

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

/// The odd trials' share solved, of all, against what theory says can be solved: within 2 points on either side.
void add_ceiling(const Grid& grid, const char* name, double ceiling, std::vector<Comparison>& into) {
  constexpr double kMargin = 0.02;
  const LinearCombination gap{{{1, solved_of_all_trials(grid)}}};
  const std::string what = fmt::format("{}, {}: share solved at the best parameters (theory: {} % can be solved)", name,
                                       code(grid.label), points(ceiling));
  const std::string scope = scope_of(grid.problems.redundancy(), Measure::kVerdict);
  into.push_back(compare_between(what, scope, gap, ceiling - kMargin, ceiling + kMargin));
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

/// Adds held-out best of `first` less that of each of `others`, on every set and by both measures.
void add_best_differences(const Study& study, Kind kind, const std::string& first,
                          const std::vector<std::string>& others, std::vector<Comparison>& into) {
  for_each_set([](const Experiment&) { return true; },
               [&](const Experiment& where, const std::string& reading) {
                 const Grid* ours = find_grid(study.grids, kind, where, reading, first);
                 if (ours == nullptr) return;
                 for (const std::string& other : others) {
                   const Grid* theirs = find_grid(study.grids, kind, where, reading, other);
                   if (theirs == nullptr) continue;
                   for (const Measure measure : kMeasures) {
                     into.push_back(compare(
                         place(kind, where) + ": best held out, " + code(first) + " − " + code(other),
                         scope_of(reading, measure),
                         difference(range_of(*ours, measure).held_out, range_of(*theirs, measure).held_out), 0, true));
                   }
                 }
               });
}

/// Adds paired differences on each set of the solvers that were run at single settings.
void add_paired_differences(const Study& study, Kind kind, const std::string& first, Family other,
                            std::vector<Comparison>& into) {
  for_each_set(
      [](const Experiment&) { return true; },
      [&](const Experiment& where, const std::string& reading) {
        const std::string set = set_name(kind, where, reading);
        for (const Cell& cell : study.summary.cells) {
          const SolverRow& row = study.summary.solvers[cell.solver];
          const bool rival = row.sweep.empty() && family_of(row.text()) == other && !cell.refused();
          if (!rival || study.summary.sets[cell.set].name != set) continue;
          const Cell* ours = single_cell(study, set, first, row);
          if (ours == nullptr) continue;
          const PairedCounts pairs = pair_by_trial(*ours, cell);
          if (pairs.problems() == 0) continue;
          into.push_back(compare(place(kind, where) + ": single settings, " + code(first) + " − " + code(row.text()),
                                 scope_of(reading, Measure::kVerdict), pairs, 0, true));
        }
      });
}

Claim lemke_is_best(const Study& study) {
  Claim claim{
      .id = "lemke-best",
      .statement = "Lemke's algorithm is the best of the three solvers by the share it solves.",
      .rule =
          "Share solved on the odd trials at the parameters chosen on the even ones: Lemke less PATH, and Lemke "
          "less the interior point method, is above 0 on every set; where both were run at single settings, "
          "also in pairs (McNemar). Equal shares leave a set undecided.",
      .needs = "sweeps of lemke and of primal_dual or path on the same set",
      .on_every_set = true};
  for (const Kind kind : kKinds) {
    std::vector<std::string> rivals;
    for (const Family family : {Family::kPath, Family::kInteriorPoint}) {
      const std::vector<std::string> more = labels_of(study, kind, family);
      rivals.insert(rivals.end(), more.begin(), more.end());
      add_paired_differences(study, kind, "lemke", family, claim.comparisons);
    }
    for (const std::string& lemke : labels_of(study, kind, Family::kLemke)) {
      add_best_differences(study, kind, lemke, rivals, claim.comparisons);
      add_best_differences(study, kind, lemke, labels(study, kind, false), claim.beyond);
    }
  }
  return claim;
}

/// Calls visit(where, reading, path grid, lemke grid) wherever the store has both.
template <class Visit>
void for_each_path_and_lemke(const Study& study, Kind kind, Visit visit) {
  for_each_set([](const Experiment&) { return true; },
               [&](const Experiment& where, const std::string& reading) {
                 for (const std::string& path : labels_of(study, kind, Family::kPath)) {
                   for (const std::string& lemke : labels_of(study, kind, Family::kLemke)) {
                     const Grid* first = find_grid(study.grids, kind, where, reading, path);
                     const Grid* second = find_grid(study.grids, kind, where, reading, lemke);
                     if (first != nullptr && second != nullptr) visit(where, reading, *first, *second);
                   }
                 }
               });
}

constexpr const char* kNeedsPath = "sweeps of path and of lemke on the same set; PATH is installed by its users";

Claim path_is_wider(const Study& study) {
  Claim claim{.id = "path-wider",
              .statement = "PATH is better than Lemke over a wider range of parameters on all criteria.",
              .rule =
                  "On every set: average share of PATH less Lemke's above 0, and the share on the odd trials at the "
                  "parameters that are worst on the even ones likewise (a plain minimum would be lower for the larger "
                  "grid); mean time of the solved problems and mean violation over all parameters, PATH over Lemke, "
                  "below 1.",
              .needs = kNeedsPath,
              .on_every_set = true};
  for (const Kind kind : kKinds) {
    for_each_path_and_lemke(
        study, kind, [&](const Experiment& where, const std::string& reading, const Grid& path, const Grid& lemke) {
          const std::string who = place(kind, where) + ", " + code(path.label) + " against " + code(lemke.label);
          for (const Measure measure : kMeasures) {
            const GridRange ours = range_of(path, measure);
            const GridRange theirs = range_of(lemke, measure);
            claim.comparisons.push_back(compare(who + ": average", scope_of(reading, measure),
                                                difference(ours.average, theirs.average), 0, true));
            claim.comparisons.push_back(compare(who + ": worst held out", scope_of(reading, measure),
                                                difference(ours.worst_held_out, theirs.worst_held_out), 0, true));
          }
          const Measure criterion = Measure::kCriterion;
          for (const auto& [quantity, words] :
               {std::pair{Quantity::kTimeSolved, ": mean time"}, std::pair{Quantity::kViolation, ": mean violation"}}) {
            claim.comparisons.push_back(compare(
                who + words, scope_of(reading, criterion),
                RatioOfMeans{over_all(path, quantity, criterion), over_all(lemke, quantity, criterion)}, 1, false));
          }
        });
  }
  return claim;
}

Claim lemke_speed_depends_on_kind(const Study& study) {
  constexpr double kMuch = 2;
  Claim claim{.id = "lemke-path-speed",
              .statement = "Lemke is much faster than PATH on monotone problems and much slower on copositive ones.",
              .rule =
                  "“Much”: by a factor of 2. Mean time of the solved problems over all parameters, PATH over Lemke: "
                  "above 2 on every monotone set, below 1/2 on every copositive one.",
              .needs = kNeedsPath,
              .on_every_set = true};
  for (const Kind kind : kKinds) {
    for_each_path_and_lemke(
        study, kind, [&](const Experiment& where, const std::string& reading, const Grid& path, const Grid& lemke) {
          const bool monotone = kind == Kind::kMonotone;
          const RatioOfMeans ratio{over_all(path, Quantity::kTimeSolved, Measure::kCriterion),
                                   over_all(lemke, Quantity::kTimeSolved, Measure::kCriterion)};
          claim.comparisons.push_back(compare(place(kind, where) + ": " + code(path.label) + " / " + code(lemke.label),
                                              scope_of(reading, Measure::kCriterion), ratio,
                                              monotone ? kMuch : 1 / kMuch, monotone));
        });
  }
  return claim;
}

Claim violations_are_comparable(const Study& study) {
  constexpr double kComparable = 100;
  Claim claim{
      .id = "violation",
      .statement = "The constraint violation of PATH and Lemke is comparable on average.",
      .rule =
          "Solved by the criterion, over all parameters: mean violation of PATH over Lemke's lies between 1/100 and "
          "100 (the paper's own lie between 1/30 and 3). The paper adds that in the worst case Lemke's is better on "
          "monotone problems and worse on copositive ones: that is shown and not tested, a largest violation has no "
          "interval.",
      .needs = kNeedsPath};
  for (const Kind kind : kKinds) {
    for_each_path_and_lemke(
        study, kind, [&](const Experiment& where, const std::string& reading, const Grid& path, const Grid& lemke) {
          const std::string who = place(kind, where) + ", " + code(path.label) + " / " + code(lemke.label);
          const std::string scope = scope_of(reading, Measure::kCriterion);
          const RatioOfMeans ratio{over_all(path, Quantity::kViolation, Measure::kCriterion),
                                   over_all(lemke, Quantity::kViolation, Measure::kCriterion)};
          claim.comparisons.push_back(compare_between(who + ": mean", scope, ratio, 1 / kComparable, kComparable));
          claim.beyond.push_back(shown(who + ": largest", scope,
                                       ratio.numerator.values.max / ratio.denominator.values.max, 1,
                                       kind == Kind::kMonotone));
        });
  }
  return claim;
}

/// Calls visit(where, reading, interior point grid, lemke grid) wherever the store has both.
template <class Visit>
void for_each_ip_and_lemke(const Study& study, Kind kind, Visit visit) {
  for_each_set([](const Experiment&) { return true; },
               [&](const Experiment& where, const std::string& reading) {
                 for (const std::string& ip : labels_of(study, kind, Family::kInteriorPoint)) {
                   for (const std::string& lemke : labels_of(study, kind, Family::kLemke)) {
                     const Grid* first = find_grid(study.grids, kind, where, reading, ip);
                     const Grid* second = find_grid(study.grids, kind, where, reading, lemke);
                     if (first != nullptr && second != nullptr) visit(where, reading, *first, *second);
                   }
                 }
               });
}

constexpr const char* kNeedsInteriorPoint = "sweeps of primal_dual and of lemke on the same set";

Claim interior_point_is_robust(const Study& study) {
  Claim claim{.id = "ip-robust",
              .statement = "The interior point method is extremely robust to its parameters.",
              .rule =
                  "“Extremely”: its range over the parameters (share at the best less that at the worst) is less than "
                  "a quarter of Lemke's on the same set: a quarter of Lemke's, less its own, is above 0. Best and "
                  "worst are chosen on the even trials and compared on the odd ones, because plain ranges grow with "
                  "the number of parameterisations by chance.",
              .needs = kNeedsInteriorPoint};
  for (const Kind kind : kKinds) {
    for_each_ip_and_lemke(
        study, kind, [&](const Experiment& where, const std::string& reading, const Grid& ip, const Grid& lemke) {
          for (const Measure measure : kMeasures) {
            const GridRange ours = range_of(ip, measure);
            const GridRange theirs = range_of(lemke, measure);
            const LinearCombination quarter{{{0.25, theirs.held_out},
                                             {-0.25, theirs.worst_held_out},
                                             {-1, ours.held_out},
                                             {1, ours.worst_held_out}}};
            Comparison comparison =
                compare(place(kind, where) + ": range of " + code(lemke.label) + " / 4 − range of " + code(ip.label),
                        scope_of(reading, measure), quarter, 0, true);
            comparison.detail = fmt::format("held-out ranges {} and {} points; standard deviations {} and {}",
                                            points(theirs.held_out.value() - theirs.worst_held_out.value()),
                                            points(ours.held_out.value() - ours.worst_held_out.value()),
                                            points(theirs.sigma), points(ours.sigma));
            claim.comparisons.push_back(std::move(comparison));
          }
        });
  }
  return claim;
}

Claim interior_point_is_not_recommended(const Study& study) {
  Claim claim{.id = "ip-not-recommended",
              .statement =
                  "The interior point method is nevertheless not recommended: it solves less than Lemke and takes "
                  "longer.",
              .rule =
                  "On every set: held-out best of Lemke less that of the interior point method above 0; mean time of "
                  "the solved problems over all parameters, interior point over Lemke, above 1.",
              .needs = kNeedsInteriorPoint,
              .on_every_set = true};
  for (const Kind kind : kKinds) {
    for_each_ip_and_lemke(
        study, kind, [&](const Experiment& where, const std::string& reading, const Grid& ip, const Grid& lemke) {
          const std::string who = place(kind, where) + ", " + code(lemke.label) + " and " + code(ip.label);
          for (const Measure measure : kMeasures) {
            claim.comparisons.push_back(
                compare(who + ": share solved", scope_of(reading, measure),
                        difference(range_of(lemke, measure).held_out, range_of(ip, measure).held_out), 0, true));
          }
          claim.comparisons.push_back(compare(who + ": time", scope_of(reading, Measure::kCriterion),
                                              RatioOfMeans{over_all(ip, Quantity::kTimeSolved, Measure::kCriterion),
                                                           over_all(lemke, Quantity::kTimeSolved, Measure::kCriterion)},
                                              1, true));
        });
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

Claim splitting_methods_fail(const Study& study) {
  constexpr std::array<std::string_view, 3> kSplitting{"psor", "bullet_pgs", "siconos_pgs"};
  Claim claim{
      .id = "splitting",
      .statement = "Splitting (iterative) methods cannot be recommended: they solve less than half of the problems.",
      .rule =
          "Share solved by every parameterisation of psor, bullet_pgs and siconos_pgs, as far as they were run, "
          "below 50 % on every set.",
      .needs = "psor, bullet_pgs or siconos_pgs on a set of the paper",
      .on_every_set = true};
  for (const Cell& cell : study.summary.cells) {
    const SolverRow& row = study.summary.solvers[cell.solver];
    const std::optional<PaperSet> problems = paper_set(study.summary.sets[cell.set].name);
    const bool splitting = std::find(kSplitting.begin(), kSplitting.end(), row.name) != kSplitting.end();
    if (!splitting || !problems || !problems->other_readings().empty() || cell.count(lcpbench::Claim::kUnsupported) > 0)
      continue;
    for (const Measure measure : kMeasures) {
      const Proportion share = solved_share(cell, measure);
      if (!(share.trials > 0)) continue;
      claim.comparisons.push_back(compare(place(problems->kind, *problems->experiment) + ", " + code(row.text()),
                                          scope_of(problems->redundancy(), measure), LinearCombination{{{1, share}}},
                                          0.5, false));
    }
  }
  return claim;
}

const char* name_of(Stance stance) {
  switch (stance) {
    case Stance::kSupports: return "supports";
    case Stance::kOpposes: return "opposes";
    case Stance::kUndecided: return "undecided";
    case Stance::kShown: return "not tested";
  }
  return "";
}

Json record(const Claim& claim, const char* part, const Comparison* comparison) {
  const double none = Proportion{}.value();
  const bool tested = comparison != nullptr && is_tested(*comparison);
  const Interval interval = tested ? comparison->interval(kZ95) : Interval{none, none};
  return {{"claim", claim.id},
          {"word", name_of(claim.word)},
          {"part", part},
          {"quantity", comparison == nullptr ? "needs " + claim.needs : comparison->what},
          {"scope", comparison == nullptr ? "" : comparison->scope},
          {"value", number_json(comparison == nullptr ? none : comparison->value)},
          {"low", number_json(interval.low)},
          {"high", number_json(interval.high)},
          {"claimed", comparison == nullptr ? ""
                      : comparison->within  ? "between"
                      : comparison->above   ? "above"
                                            : "below"},
          {"bound", number_json(comparison == nullptr ? none : comparison->bound)},
          {"upper_bound", number_json(comparison == nullptr ? none : comparison->within.value_or(none))},
          {"stance", comparison == nullptr ? "" : name_of(comparison->stance)},
          {"detail", comparison == nullptr ? "" : comparison->detail}};
}

}  // namespace

const char* name_of(Word word) {
  switch (word) {
    case Word::kConfirmed: return "confirmed";
    case Word::kInPart: return "confirmed in part";
    case Word::kContradicted: return "contradicted";
    case Word::kExplained: return "explained";
    case Word::kUndecided: return "undecided";
    case Word::kNotTested: return "not tested";
  }
  return "";
}

void judge(Claim& claim) {
  decide(claim.comparisons);
  decide(claim.explanation);
  decide(claim.beyond);
  claim.word = word_of(claim);
}

std::vector<Claim> test_claims(const Summary& summary, const std::vector<Grid>& grids) {
  std::vector<Grid> whole = grids;
  std::erase_if(whole, [](const Grid& grid) { return grid.refused() > 0; });
  std::vector<std::int64_t> most(summary.sets.size(), 0);
  for (const Grid& grid : whole) most[grid.set] = std::max(most[grid.set], grid.trials());
  std::erase_if(whole, [&most](const Grid& grid) { return 2 * grid.trials() < most[grid.set]; });
  const Study study{summary, whole};
  std::vector<Claim> claims{monotone_is_easier(study),
                            regularization_gains(study),
                            regularization_closes_the_gap(study),
                            regularization_costs_time(study),
                            regularization_stays_honest(study),
                            redundancy_lowers_a_little(study),
                            rank_lowers_far_more(study),
                            four_above_three(study),
                            lemke_is_best(study),
                            path_is_wider(study),
                            lemke_speed_depends_on_kind(study),
                            interior_point_is_robust(study),
                            interior_point_is_not_recommended(study),
                            violations_are_comparable(study),
                            ceilings_matter_little(study),
                            splitting_methods_fail(study)};
  for (Claim& claim : claims) judge(claim);
  return claims;
}

Json claims_json(const std::vector<Claim>& claims) {
  Json records = Json::array();
  for (const Claim& claim : claims) {
    if (claim.comparisons.empty()) records.push_back(record(claim, "claim", nullptr));
    for (const Comparison& comparison : claim.comparisons) records.push_back(record(claim, "claim", &comparison));
    for (const Comparison& comparison : claim.explanation) records.push_back(record(claim, "explanation", &comparison));
    for (const Comparison& comparison : claim.beyond) records.push_back(record(claim, "beyond", &comparison));
  }
  return records;
}

Json claims_example() { return record({}, "", nullptr); }

}  // namespace lcpbench::paper
