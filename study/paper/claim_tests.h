#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "study/paper/claims.h"
#include "study/paper/tables.h"

/// The claims and what their tests are made of: quantities of a store, turned into comparisons.
namespace lcpbench::paper::claim_tests {

/// What all claims read.
struct Study {
  const Summary& summary;
  const std::vector<Grid>& grids;
};

// --- words ---

const Experiment& experiment(std::string_view name);

/// "combination, criterion"
std::string scope_of(const std::string& reading, Measure measure);

/// "copositive exp5-1e8"
std::string place(Kind kind, const Experiment& where);

/// "paper/copositive/exp2{redundancy=combination}"
std::string set_name(Kind kind, const Experiment& where, const std::string& reading);

// --- comparisons ---

Comparison compare(std::string what, std::string scope, const LinearCombination& quantity, double bound, bool above);
Comparison compare(std::string what, std::string scope, const RatioOfMeans& ratio, double bound, bool above);
Comparison compare(std::string what, std::string scope, const PairedCounts& pairs, double bound, bool above);

/// The quantity is claimed to lie above `low` and below `high`: it supports the claim only as a whole.
template <class Quantity>
Comparison compare_between(std::string what, std::string scope, const Quantity& quantity, double low, double high) {
  Comparison comparison = compare(std::move(what), std::move(scope), quantity, low, true);
  comparison.within = high;
  return comparison;
}

/// A ratio that is no estimate, such as that of two maxima.
Comparison shown(std::string what, std::string scope, double value, double bound, bool above);

// --- what a store has ---

/// Labels of the paper's own solvers, or of all others, that the store has of a kind.
std::vector<std::string> labels(const Study& study, Kind kind, bool of_the_paper);
std::vector<std::string> labels_of(const Study& study, Kind kind, Family family);

/// nullptr where the store has no such sweep.
const Grid* grid_of(const Study& study, Kind kind, std::string_view where, const std::string& reading,
                    const std::string& label);

/// A single parameterisation, not one of a sweep, of a set; nullptr where the store has none.
/// @param partner  the row that it is compared with
const Cell* single_cell(const Study& study, const std::string& set, const std::string& solver,
                        const SolverRow& partner);

/// The trials that both met and took, by seed and number: on one set, or on two sets that have the same problems.
PairedCounts pair_by_trial(const Cell& first, const Cell& second);

/// Calls visit(where, reading) for the experiments that `picks` takes.
template <class Picks, class Visit>
void for_each_set(Picks picks, Visit visit) {
  for (const Experiment& where : experiments()) {
    if (!picks(where)) continue;
    for (const std::string& reading : readings_of(where)) visit(where, reading);
  }
}

// --- the claims ---

Claim monotone_is_easier(const Study& study);
Claim regularization_gains(const Study& study);
Claim regularization_closes_the_gap(const Study& study);
Claim regularization_costs_time(const Study& study);
Claim regularization_stays_honest(const Study& study);
Claim redundancy_lowers_a_little(const Study& study);
Claim rank_lowers_far_more(const Study& study);
Claim four_above_three(const Study& study);
Claim lemke_is_best(const Study& study);
Claim path_is_wider(const Study& study);
Claim lemke_speed_depends_on_kind(const Study& study);
Claim interior_point_is_robust(const Study& study);
Claim interior_point_is_not_recommended(const Study& study);
Claim violations_are_comparable(const Study& study);
Claim ceilings_matter_little(const Study& study);
Claim splitting_methods_fail(const Study& study);

}  // namespace lcpbench::paper::claim_tests
