#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "study/paper/claims.h"

// The claims themselves: for each its words, and the comparisons of a store's grids that test it.

namespace lcpbench::paper {
namespace {

/// What all claims read.
struct Study {
  const Summary& summary;
  const std::vector<Grid>& grids;
};

// --- words ---

/// "combination, criterion"
std::string scope_of(const std::string& reading, Measure measure) { return reading + ", " + name_of(measure); }

/// "copositive exp5-1e8"
std::string place(Kind kind, const Experiment& where) {
  return std::string(name_of(kind)) + " " + std::string(where.name);
}

/// "paper/copositive/exp2{redundancy=combination}"
std::string set_name(Kind kind, const Experiment& where, const std::string& reading) {
  std::string name = std::string("paper/") + name_of(kind) + "/" + std::string(where.name);
  if (where.redundant && reading != kReadings.front()) name += "{redundancy=" + reading + "}";
  return name;
}

// --- comparisons ---

template <class Quantity>
Comparison compare(std::string what, std::string scope, const Quantity& quantity, double bound, bool above) {
  return {.what = std::move(what),
          .scope = std::move(scope),
          .value = quantity.value(),
          .bound = bound,
          .above = above,
          .share = !std::is_same_v<Quantity, RatioOfMeans>,
          .interval = [quantity](double z) { return quantity.interval(z); }};
}

Comparison compare(std::string what, std::string scope, const PairedShares& pairs) {
  Comparison comparison = compare<PairedShares>(std::move(what), std::move(scope), pairs, 0, true);
  comparison.p_value = pairs.p_value();
  comparison.detail = fmt::format("{} problems in pairs, {} only the first, {} only the second; McNemar p = {:.2g}",
                                  pairs.problems(), pairs.only_first, pairs.only_second, pairs.p_value());
  return comparison;
}

/// The quantity is claimed to lie above `low` and below `high`: it supports the claim only as a whole.
template <class Quantity>
Comparison compare_between(std::string what, std::string scope, const Quantity& quantity, double low, double high) {
  Comparison comparison = compare(std::move(what), std::move(scope), quantity, low, true);
  comparison.within = high;
  return comparison;
}

// --- what a store has ---

/// Labels of the solvers of a kind whose family `wanted` takes.
template <class Wanted>
std::vector<std::string> labels_where(const Study& study, Kind kind, Wanted wanted) {
  std::set<std::string> found;
  for (const Grid& grid : study.grids) {
    if (compared_with_paper(grid, kind) && wanted(family_of(grid.solver))) found.insert(grid.label);
  }
  return {found.begin(), found.end()};
}

/// Labels of the paper's own solvers, or of all others.
std::vector<std::string> labels(const Study& study, Kind kind, bool of_the_paper) {
  return labels_where(study, kind, [=](std::optional<Family> family) { return family.has_value() == of_the_paper; });
}

std::vector<std::string> labels_of(const Study& study, Kind kind, Family wanted) {
  return labels_where(study, kind, [=](std::optional<Family> family) { return family == wanted; });
}

/// One of the paper's own solvers on the problems of a kind, by one reading of the redundant ones.
struct Subject {
  const Study& study;
  Kind kind;
  std::string label;
  std::string reading;

  /// nullptr where the store has no such sweep.
  const Grid* on(std::string_view where) const {
    return find_grid(study.grids, kind, *find_experiment(where), reading, label);
  }
  bool is_first_reading() const { return reading == kReadings.front(); }
  std::string words() const { return std::string(name_of(kind)) + ", " + code(label); }
};

template <class Visit>
void for_each_subject(const Study& study, Visit visit) {
  for (const Kind kind : kKinds) {
    for (const std::string& label : labels(study, kind, true)) {
      for (const char* reading : kReadings) visit(Subject{study, kind, label, reading});
    }
  }
}

/// Calls visit(where, reading) for all experiments in all their readings.
template <class Visit>
void for_each_set(Visit visit) {
  for (const Experiment& where : experiments()) {
    for (const std::string& reading : readings_of(where)) visit(where, reading);
  }
}

/// A single parameterisation, not one of a sweep, of a set; nullptr where the store has none.
/// @param partner  the row that it is compared with: what is compared are solvers, not instruction-set levels, which
/// libraries do not have
const Cell* single_cell(const Study& study, const std::string& set, const std::string& solver,
                        const SolverRow& partner) {
  for (const Cell& cell : study.summary.cells) {
    const SolverRow& row = study.summary.solvers[cell.solver];
    const bool same_level = row.isa.empty() || partner.isa.empty() || row.isa == partner.isa;
    const bool fits = row.sweep.empty() && row.text() == solver && same_level;
    if (fits && study.summary.sets[cell.set].name == set && !cell.refused()) return &cell;
  }
  return nullptr;
}

/// The trials that both met and took, by seed and number: on one set, or on two sets that have the same problems.
PairedShares pair_by_trial(const Cell& first, const Cell& second) {
  std::map<std::pair<std::int64_t, std::int64_t>, const Outcome*> others;
  for (const Outcome& outcome : second.outcomes) others.emplace(std::pair{outcome.seed, outcome.trial}, &outcome);
  const auto counts = [](const Outcome& outcome) { return !outcome.unsolvable && !outcome.refused; };
  PairedShares pairs;
  for (const Outcome& outcome : first.outcomes) {
    const auto other = others.find({outcome.seed, outcome.trial});
    if (other == others.end() || !counts(outcome) || !counts(*other->second)) continue;
    pairs.add(outcome.solved, other->second->solved);
  }
  return pairs;
}

// --- kinds and experiments ---

Claim monotone_is_easier(const Study& study) {
  Claim claim{.id = "monotone-easier",
              .statement = "Monotone (frictionless) problems are easier to solve than copositive (frictional) ones.",
              .rule =
                  "Average share solved over a solver's parameters: monotone less copositive is above 0, for every "
                  "experiment, reading and measure.",
              .needs = "one sweep on both kinds of the same experiment",
              .on_every_set = true};
  for (const bool of_the_paper : {true, false}) {
    auto& into = of_the_paper ? claim.comparisons : claim.beyond;
    for (const std::string& label : labels(study, Kind::kMonotone, of_the_paper)) {
      for_each_set([&](const Experiment& where, const std::string& reading) {
        const Grid* monotone = find_grid(study.grids, Kind::kMonotone, where, reading, label);
        const Grid* copositive = find_grid(study.grids, Kind::kCopositive, where, reading, label);
        if (where.name == "extra100" || monotone == nullptr || copositive == nullptr) return;
        for (const Measure measure : kMeasures) {
          into.push_back(compare(
              std::string(where.name) + ", " + code(label) + ": average on monotone − copositive",
              scope_of(reading, measure),
              difference(range_of(*monotone, measure).average, range_of(*copositive, measure).average), 0, true));
        }
      });
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
  for_each_subject(study, [&](const Subject& subject) {
    const Grid* plain = subject.on("exp1");
    const Grid* redundant = subject.on("exp2");
    if (plain == nullptr || redundant == nullptr) return;
    for (const Measure measure : kMeasures) {
      claim.comparisons.push_back(compare_between(
          subject.words() + ": Experiment 1 − 2", scope_of(subject.reading, measure),
          difference(range_of(*plain, measure).average, range_of(*redundant, measure).average), 0, kLittle));
    }
  });
  return claim;
}

/// The share solved of the odd trials, those proven unsolvable among them, at the parameterisation that the even ones
/// choose, against what theory says can be solved: within 2 points on either side. Of monotone Lemke alone.
void add_ceiling(const Subject& subject, const Grid& grid, const char* name, double ceiling,
                 std::vector<Comparison>& into) {
  constexpr double kMargin = 0.02;
  const bool has_theory = subject.kind == Kind::kMonotone && subject.is_first_reading();
  if (!has_theory || family_of(grid.solver) != Family::kLemke) return;
  Proportion solved;
  if (const Cell* chosen = range_of(grid, Measure::kVerdict).chosen) {
    const Cell::Half& odd = chosen->halves[1];
    solved = {static_cast<double>(odd.solved), static_cast<double>(odd.trials)};
  }
  into.push_back(compare_between(fmt::format("{}, {}: share solved at the best parameters (theory: {} % can be solved)",
                                             name, code(grid.label), points(ceiling)),
                                 scope_of(grid.problems.redundancy(), Measure::kVerdict),
                                 LinearCombination{{{1, solved}}}, ceiling - kMargin, ceiling + kMargin));
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
  for_each_subject(study, [&](const Subject& subject) {
    const Grid* plain = subject.on("exp1");
    const Grid* redundant = subject.on("exp2");
    const Grid* reduced = subject.on("exp3");
    if (reduced == nullptr) return;
    add_ceiling(subject, *reduced, "monotone Experiment 3", solvable_share_of_exp3(), claim.explanation);
    if (plain == nullptr || redundant == nullptr) return;
    const auto average = [](const Grid* grid) { return range_of(*grid, Measure::kCriterion).average; };
    const LinearCombination excess{{{-1, average(plain)}, {-1, average(reduced)}, {2, average(redundant)}}};
    claim.comparisons.push_back(compare(subject.words() + ": drop from Experiment 1 to 3 − twice that from 1 to 2",
                                        scope_of(subject.reading, Measure::kCriterion), excess, 0, true));
  });
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
  for_each_subject(study, [&](const Subject& subject) {
    const Grid* three = subject.on("exp3");
    const Grid* four = subject.on("exp4");
    if (three == nullptr || four == nullptr) return;
    for (const Measure measure : kMeasures) {
      const GridRange low = range_of(*three, measure);
      const GridRange high = range_of(*four, measure);
      const std::string scope = scope_of(subject.reading, measure);
      auto& into = measure == Measure::kCriterion ? claim.comparisons : claim.beyond;
      into.push_back(compare(subject.words() + ": average, Experiment 4 − 3", scope,
                             difference(high.average, low.average), 0, true));
      into.push_back(compare(subject.words() + ": best held out, Experiment 4 − 3", scope,
                             difference(high.held_out, low.held_out), 0, true));
    }
    const auto unsolvable = [](const Grid* grid) -> Proportion {
      const Cell* some = grid->cells.front();
      return {static_cast<double>(some->unsolvable_problems), static_cast<double>(some->trials)};
    };
    claim.beyond.push_back(
        compare(std::string(name_of(subject.kind)) + ": share proven unsolvable in this store, Experiment 3 − 4",
                subject.reading, difference(unsolvable(three), unsolvable(four)), 0, true));
    add_ceiling(subject, *three, "monotone Experiment 3", solvable_share_of_exp3(), claim.explanation);
    add_ceiling(subject, *four, "monotone Experiment 4", solvable_share_of_exp4(), claim.explanation);
  });
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
  for_each_subject(study, [&](const Subject& subject) {
    const Grid* small = subject.on("exp5-1e10");
    const Grid* large = subject.on("extra100");
    if (small == nullptr || large == nullptr) return;
    for (const Measure measure : kMeasures) {
      claim.comparisons.push_back(
          compare(subject.words() + ": exp5-1e10 − extra100", scope_of(subject.reading, measure),
                  difference(range_of(*small, measure).held_out, range_of(*large, measure).held_out), kLimited, false));
    }
  });
  return claim;
}

// --- regularisation ---

/// A regularised solver on Experiment 6 with what it wraps on Experiment 5: the same problems.
struct Regularization {
  Kind kind;
  std::string reading;
  const Grid* with = nullptr;
  const Grid* without = nullptr;
  std::string condition;

  std::string words() const {
    return code(with->label) + " against " + code(without->label) + ", condition " + condition;
  }
  std::string words_with_kind() const { return std::string(name_of(kind)) + ": " + words(); }
};

std::vector<Regularization> regularizations(const Study& study, Kind kind, const std::string& reading) {
  std::vector<Regularization> found;
  for (const Experiment& where : experiments()) {
    if (!where.regularized) continue;
    const Experiment& plain = *find_experiment("exp5-" + std::string(where.condition));
    for (const std::string& label : labels(study, kind, true)) {
      const Grid* with = find_grid(study.grids, kind, where, reading, label);
      if (with == nullptr) continue;
      for (const Grid* without : wrapped_grids(study.grids, *with, plain, reading)) {
        found.push_back({kind, reading, with, without, std::string(where.condition)});
      }
    }
  }
  return found;
}

template <class Visit>
void for_each_regularization(const Study& study, Visit visit) {
  for (const Kind kind : kKinds) {
    for (const char* reading : kReadings) {
      for (const Regularization& pair : regularizations(study, kind, reading)) visit(pair);
    }
  }
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
    const Experiment& plain = *find_experiment("exp5-" + std::string(problems->experiment->condition));
    const Cell* without = single_cell(study, set_name(kind, plain, reading), wrapped, row);
    if (without == nullptr) continue;
    const PairedShares pairs = pair_by_trial(with, *without);
    if (pairs.problems() == 0) continue;
    into.push_back(compare(fmt::format("{}, single settings: {} against {}, condition {}", name_of(kind),
                                       code(row.text()), code(wrapped), problems->experiment->condition),
                           scope_of(reading, Measure::kVerdict), pairs));
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
              pair.words_with_kind(), scope_of(reading, measure),
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
  for_each_regularization(study, [&](const Regularization& monotone) {
    if (monotone.kind != Kind::kMonotone) return;
    for (const Regularization& copositive : regularizations(study, Kind::kCopositive, monotone.reading)) {
      if (monotone.words() != copositive.words()) continue;
      for (const Measure measure : kMeasures) {
        const auto average = [measure](const Grid* grid) { return range_of(*grid, measure).average; };
        const LinearCombination change{{{kKept, average(monotone.without)},
                                        {-kKept, average(copositive.without)},
                                        {-1, average(monotone.with)},
                                        {1, average(copositive.with)}}};
        claim.comparisons.push_back(compare("2/3 of the advantage without − the advantage with: " + monotone.words(),
                                            scope_of(monotone.reading, measure), change, 0, true));
      }
    }
  });
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
  for_each_regularization(study, [&](const Regularization& pair) {
    const RatioOfMeans ratio{over_all(*pair.with, Quantity::kTimeAll, Measure::kCriterion),
                             over_all(*pair.without, Quantity::kTimeAll, Measure::kCriterion)};
    claim.comparisons.push_back(compare(pair.words_with_kind(), pair.reading, ratio, kTie, true));
  });
  return claim;
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
  for_each_regularization(study, [&](const Regularization& pair) {
    claim.comparisons.push_back(compare(pair.words_with_kind(), scope_of(pair.reading, Measure::kVerdict),
                                        difference(false_claim_share(*pair.with), false_claim_share(*pair.without)),
                                        kMargin, false));
  });
  return claim;
}

// --- solvers against Lemke ---

/// Adds held-out best of `first` less that of each of `others`, on every set and by both measures.
void add_best_differences(const Study& study, Kind kind, const std::string& first,
                          const std::vector<std::string>& others, std::vector<Comparison>& into) {
  for_each_set([&](const Experiment& where, const std::string& reading) {
    const Grid* ours = find_grid(study.grids, kind, where, reading, first);
    if (ours == nullptr) return;
    for (const std::string& other : others) {
      const Grid* theirs = find_grid(study.grids, kind, where, reading, other);
      if (theirs == nullptr) continue;
      for (const Measure measure : kMeasures) {
        into.push_back(compare(
            place(kind, where) + ": best held out, " + code(first) + " − " + code(other), scope_of(reading, measure),
            difference(range_of(*ours, measure).held_out, range_of(*theirs, measure).held_out), 0, true));
      }
    }
  });
}

/// Adds paired differences on each set of the solvers that were run at single settings.
void add_paired_differences(const Study& study, Kind kind, const std::string& first, Family other,
                            std::vector<Comparison>& into) {
  for_each_set([&](const Experiment& where, const std::string& reading) {
    const std::string set = set_name(kind, where, reading);
    for (const Cell& cell : study.summary.cells) {
      const SolverRow& row = study.summary.solvers[cell.solver];
      const bool rival = row.sweep.empty() && family_of(row.text()) == other && !cell.refused();
      if (!rival || study.summary.sets[cell.set].name != set) continue;
      const Cell* ours = single_cell(study, set, first, row);
      if (ours == nullptr) continue;
      const PairedShares pairs = pair_by_trial(*ours, cell);
      if (pairs.problems() == 0) continue;
      into.push_back(compare(place(kind, where) + ": single settings, " + code(first) + " − " + code(row.text()),
                             scope_of(reading, Measure::kVerdict), pairs));
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

/// A solver and Lemke on the same set, by the same reading.
struct Rivals {
  Kind kind;
  const Experiment& where;
  const std::string& reading;
  const Grid& rival;
  const Grid& lemke;

  std::string words(const char* between) const {
    return place(kind, where) + ", " + code(rival.label) + between + code(lemke.label);
  }
  RatioOfMeans ratio(Quantity quantity) const {
    return {over_all(rival, quantity, Measure::kCriterion), over_all(lemke, quantity, Measure::kCriterion)};
  }
};

/// Calls visit(rivals) wherever the store has both.
template <class Visit>
void for_each_rival(const Study& study, Family family, Visit visit) {
  for (const Kind kind : kKinds) {
    for_each_set([&](const Experiment& where, const std::string& reading) {
      for (const std::string& label : labels_of(study, kind, family)) {
        for (const std::string& lemke : labels_of(study, kind, Family::kLemke)) {
          const Grid* first = find_grid(study.grids, kind, where, reading, label);
          const Grid* second = find_grid(study.grids, kind, where, reading, lemke);
          if (first != nullptr && second != nullptr) visit(Rivals{kind, where, reading, *first, *second});
        }
      }
    });
  }
}

constexpr const char* kNeedsPath = "sweeps of path and of lemke on the same set; PATH is installed by its users";
constexpr const char* kNeedsInteriorPoint = "sweeps of primal_dual and of lemke on the same set";

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
  for_each_rival(study, Family::kPath, [&](const Rivals& pair) {
    const std::string who = pair.words(" against ");
    for (const Measure measure : kMeasures) {
      const GridRange ours = range_of(pair.rival, measure);
      const GridRange theirs = range_of(pair.lemke, measure);
      const std::string scope = scope_of(pair.reading, measure);
      claim.comparisons.push_back(compare(who + ": average", scope, difference(ours.average, theirs.average), 0, true));
      claim.comparisons.push_back(
          compare(who + ": worst held out", scope, difference(ours.worst_held_out, theirs.worst_held_out), 0, true));
    }
    const std::string scope = scope_of(pair.reading, Measure::kCriterion);
    claim.comparisons.push_back(compare(who + ": mean time", scope, pair.ratio(Quantity::kTimeSolved), 1, false));
    claim.comparisons.push_back(compare(who + ": mean violation", scope, pair.ratio(Quantity::kViolation), 1, false));
  });
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
  for_each_rival(study, Family::kPath, [&](const Rivals& pair) {
    const bool monotone = pair.kind == Kind::kMonotone;
    claim.comparisons.push_back(
        compare(place(pair.kind, pair.where) + ": " + code(pair.rival.label) + " / " + code(pair.lemke.label),
                scope_of(pair.reading, Measure::kCriterion), pair.ratio(Quantity::kTimeSolved),
                monotone ? kMuch : 1 / kMuch, monotone));
  });
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
  for_each_rival(study, Family::kPath, [&](const Rivals& pair) {
    const std::string scope = scope_of(pair.reading, Measure::kCriterion);
    const RatioOfMeans ratio = pair.ratio(Quantity::kViolation);
    claim.comparisons.push_back(
        compare_between(pair.words(" / ") + ": mean", scope, ratio, 1 / kComparable, kComparable));
    claim.beyond.push_back({.what = pair.words(" / ") + ": largest",
                            .scope = scope,
                            .value = ratio.numerator.values.max / ratio.denominator.values.max,
                            .bound = 1,
                            .above = pair.kind == Kind::kMonotone,
                            .share = false,
                            .detail = "no estimate: it has no interval, and is not tested"});
  });
  return claim;
}

Claim interior_point_is_robust(const Study& study) {
  Claim claim{.id = "ip-robust",
              .statement = "The interior point method is extremely robust to its parameters.",
              .rule =
                  "“Extremely”: its range over the parameters (share at the best less that at the worst) is less than "
                  "a quarter of Lemke's on the same set: a quarter of Lemke's, less its own, is above 0. Best and "
                  "worst are chosen on the even trials and compared on the odd ones, because plain ranges grow with "
                  "the number of parameterisations by chance.",
              .needs = kNeedsInteriorPoint};
  for_each_rival(study, Family::kInteriorPoint, [&](const Rivals& pair) {
    for (const Measure measure : kMeasures) {
      const GridRange ours = range_of(pair.rival, measure);
      const GridRange theirs = range_of(pair.lemke, measure);
      const LinearCombination quarter{
          {{0.25, theirs.held_out}, {-0.25, theirs.worst_held_out}, {-1, ours.held_out}, {1, ours.worst_held_out}}};
      Comparison comparison = compare(place(pair.kind, pair.where) + ": range of " + code(pair.lemke.label) +
                                          " / 4 − range of " + code(pair.rival.label),
                                      scope_of(pair.reading, measure), quarter, 0, true);
      comparison.detail = fmt::format("held-out ranges {} and {} points; standard deviations {} and {}",
                                      points(theirs.held_out.value() - theirs.worst_held_out.value()),
                                      points(ours.held_out.value() - ours.worst_held_out.value()), points(theirs.sigma),
                                      points(ours.sigma));
      claim.comparisons.push_back(std::move(comparison));
    }
  });
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
  for_each_rival(study, Family::kInteriorPoint, [&](const Rivals& pair) {
    const std::string who =
        place(pair.kind, pair.where) + ", " + code(pair.lemke.label) + " and " + code(pair.rival.label);
    for (const Measure measure : kMeasures) {
      claim.comparisons.push_back(
          compare(who + ": share solved", scope_of(pair.reading, measure),
                  difference(range_of(pair.lemke, measure).held_out, range_of(pair.rival, measure).held_out), 0, true));
    }
    claim.comparisons.push_back(compare(who + ": time", scope_of(pair.reading, Measure::kCriterion),
                                        pair.ratio(Quantity::kTimeSolved), 1, true));
  });
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

}  // namespace

std::vector<Claim> paper_claims(const Summary& summary, const std::vector<Grid>& grids) {
  const Study study{summary, grids};
  std::vector<Claim> claims;
  for (const auto& claim :
       {monotone_is_easier, regularization_gains, regularization_closes_the_gap, regularization_costs_time,
        regularization_stays_honest, redundancy_lowers_a_little, rank_lowers_far_more, four_above_three, lemke_is_best,
        path_is_wider, lemke_speed_depends_on_kind, interior_point_is_robust, interior_point_is_not_recommended,
        violations_are_comparable, ceilings_matter_little, splitting_methods_fail}) {
    claims.push_back(claim(study));
  }
  return claims;
}

}  // namespace lcpbench::paper
