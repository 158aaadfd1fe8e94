#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "study/paper/claim_tests.h"

namespace lcpbench::paper::claim_tests {
namespace {

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

/// Calls visit(where, reading, grid of the family, lemke grid) wherever the store has both.
template <class Visit>
void for_each_pair(const Study& study, Kind kind, Family family, Visit visit) {
  for_each_set([](const Experiment&) { return true; },
               [&](const Experiment& where, const std::string& reading) {
                 for (const std::string& label : labels_of(study, kind, family)) {
                   for (const std::string& lemke : labels_of(study, kind, Family::kLemke)) {
                     const Grid* first = find_grid(study.grids, kind, where, reading, label);
                     const Grid* second = find_grid(study.grids, kind, where, reading, lemke);
                     if (first != nullptr && second != nullptr) visit(where, reading, *first, *second);
                   }
                 }
               });
}

constexpr const char* kNeedsPath = "sweeps of path and of lemke on the same set; PATH is installed by its users";

constexpr const char* kNeedsInteriorPoint = "sweeps of primal_dual and of lemke on the same set";

}  // namespace

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
    for_each_pair(
        study, kind, Family::kPath, [&](const Experiment& where, const std::string& reading, const Grid& path, const Grid& lemke) {
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
    for_each_pair(
        study, kind, Family::kPath, [&](const Experiment& where, const std::string& reading, const Grid& path, const Grid& lemke) {
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
    for_each_pair(
        study, kind, Family::kPath, [&](const Experiment& where, const std::string& reading, const Grid& path, const Grid& lemke) {
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
    for_each_pair(
        study, kind, Family::kInteriorPoint, [&](const Experiment& where, const std::string& reading, const Grid& ip, const Grid& lemke) {
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
    for_each_pair(
        study, kind, Family::kInteriorPoint, [&](const Experiment& where, const std::string& reading, const Grid& ip, const Grid& lemke) {
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

}  // namespace lcpbench::paper::claim_tests
