#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "study/report/choice.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

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
/// A situation's sets are all of a kind of scenes; of random problems those whose problems are all proven solvable, where
/// there are any: there every failure is the solver's. Left out are sets that few solvers met (less than half of the
/// number that met the most popular one), the hard cases, and the steps along a dial of conditioning.
std::vector<Situation> decide(const Summary& summary, const Statistics& statistics);

/// The solvers at single settings, those that may be chosen.
std::vector<std::size_t> single_solvers(const Summary& summary);

/// Median and 99th percentile of the errors of a solver's answers said to be solved on some sets. Infinity: no number;
/// NaN: there are none.
struct PooledErrors {
  double median = kNoNumber;
  double p99 = kNoNumber;
};
PooledErrors pooled_errors(const Summary& summary, const std::vector<std::size_t>& sets, std::size_t solver);

/// The solver whose share solved is the surest to be high (the lower end of its interval), those that take a part of the
/// problems last; nullptr for a situation that nobody met.
const Contender* surest(const Situation& situation);

/// The solvers that took all problems of a situation and solved all that are not proven unsolvable, without a false
/// claim; the fastest first. A description of these problems, no endorsement.
std::vector<const Contender*> without_fault(const Situation& situation);

/// What problems say that are too few to call a solver reliable: "all 30 problems are solved by 4 of 24 solvers, ...".
std::string few_problems_text(const Summary& summary, const Situation& situation);

/// "too few to say: 12 problems; the report needs 35", "too few to say: 88 problems, 11 % of the plan; the report needs
/// 50 % of it, or 381 problems". @pre too_few(problems, plan_share)
std::string too_few_text(std::int64_t problems, double plan_share);

/// Every solver at single settings that said solved and was wrong, on whatever set, with the share of the problems that
/// it took; those of whom it is surest first.
std::vector<std::pair<std::size_t, Share>> caught_solvers(const Summary& summary);

/// The numbers of the rule, for summary.json and report.json.
nlohmann::ordered_json reliability_rule_json();

}  // namespace lcpbench::report
