#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/output/json_output.h"
#include "study/report/choice.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// Adds the statistics of one set's solvers at single settings. Hard cases have no pairs: each is one problem, chosen
/// to break solvers. O(pairs x problems).
/// @param problems  of the set
/// @param cells     of the set, with their outcomes
void add_statistics(const Summary& summary, std::size_t problems, std::span<const Cell> cells, Statistics& statistics);

/// Takes the plans from the summary's coverage.
void complete_statistics(const Summary& summary, Statistics& statistics);

/// One row of the decision table: its contenders stand in the order of choose().
struct Situation {
  std::string title;
  std::vector<std::size_t> sets;  ///< indices into Summary::sets; empty: no such problems in this store
  Choice choice;
  std::string withheld;  ///< why no solver is recommended, one clause; "" where one is, or nobody met these problems

  const Contender* recommended() const { return choice.recommended ? &choice.contenders.front() : nullptr; }
};

/// The kinds of captured scenes that the store has, then three of random problems, always: frictionless, frictional,
/// ill-conditioned. Which solver to use, by the verdict's own threshold of error.
///
/// A situation's sets are all of a kind of scenes; of random problems those whose problems are all proven solvable,
/// where there are any: there every failure is the solver's. Left out are sets that few solvers met (less than half of
/// the number that met the most popular one), the hard cases, and the steps along a dial of conditioning.
std::vector<Situation> decide(const Summary& summary, const Statistics& statistics);

/// The solvers at single settings, those that may be chosen.
std::vector<std::size_t> single_solvers(const Summary& summary);

/// The numbers of the rule, for summary.json and report.json.
Json reliability_rule_json();

}  // namespace lcpbench::report
