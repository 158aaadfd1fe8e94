#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "study/report/reliability.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// One solver on all problems of a situation.
struct Contender {
  std::size_t solver = 0;   ///< index into Summary::solvers
  std::int64_t trials = 0;  ///< problems it took, refused ones not counted
  Share solved;             ///< of those not proven unsolvable
  Share solved_of_met;      ///< the same, the refused ones counted as not solved
  Share false_claims;       ///< of the trials
  Share refused;            ///< of the problems that it met
  double median_error = 0;  ///< rho of the answers said to be solved; infinity: no number; NaN: there are none
  double p99_error = 0;     ///< the same, 99th percentile
  Estimate time;            ///< median [s]
  TimeFactor speedup;       ///< reference's time / this one's
  Reliability reliability;
  TimeFactor recommended_factor;  ///< time of the recommended solver over this one's
  bool sampled = false;  ///< took fewer problems than another solver
  bool tie = false;      ///< reliable, and its time is not to be told from the recommended one's
  std::string verdict;   ///< one clause on why not this one; "" for the recommended one
};

/// One row of the decision table.
struct Situation {
  std::string title;
  std::string scope;                       ///< which problems, one clause; "" without any
  std::vector<std::size_t> sets;           ///< indices into Summary::sets; empty: no such problems in this store
  std::vector<Contender> contenders;       ///< the recommended one first, then by share solved, then by time
  std::optional<std::size_t> recommended;  ///< index into `contenders` (0)
  std::string withheld;                    ///< why none is recommended, one clause of HTML; "" where one is
};

/// The kinds of captured scenes (scenes.h) that the store has, then three of random problems, always: frictionless,
/// frictional, ill-conditioned. Which solver to use, and why not the others.
///
/// Recommended is the fastest by median time among the reliable solvers (reliability.h) that refused none of the
/// problems; without such a solver none is, and `withheld` says why. A situation's sets are all of a kind of scenes; of
/// random problems those whose problems are all proven solvable, where there are any: there every failure is the
/// solver's. Left out are sets that few solvers met (less than half of the number that met the most popular one), the
/// hard cases, and the steps along a dial of conditioning.
std::vector<Situation> decide(const Summary& summary);

/// One situation: its solvers on the sets, judged and compared.
Situation judge_situation(const Summary& summary, std::string title, std::vector<std::size_t> sets);

/// Time of `a` over time of `b`.
TimeFactor time_ratio(const Record& a, const Record& b);

/// The solvers that took all problems of a situation and solved all that are not proven unsolvable, without a false
/// claim; the fastest first. A description of these problems, no endorsement.
std::vector<const Contender*> without_fault(const Situation& situation);

/// What problems say that are too few to call a solver reliable: "all 30 problems are solved by 4 of 24 solvers, ...".
std::string few_problems_text(const Summary& summary, const Situation& situation);

/// The solver recommended for each set (index into Summary::sets) of the situations.
std::map<std::size_t, std::size_t> recommended_by_set(const std::vector<Situation>& situations);

/// The set of the one picture: frictional contacts at inertia condition number 1e8 where the store has them, else the
/// frictional set that its solvers solve least of, else the same among all sets. nullopt for a store without answers.
std::optional<std::size_t> headline_set(const Summary& summary);

/// Does the store hold answers, but none on a set that a situation takes: hard cases alone, say, or bare LCPs?
bool only_special_sets(const Summary& summary, const std::vector<Situation>& situations);

/// The recommended solver's speed beside the reference's: "40.1× faster than the dense reference"; "" where there is
/// none to compare with.
std::string speed_beside_reference(const Summary& summary, const Contender& best);

/// Every solver at single settings that said solved and was wrong, on whatever set, with the share of the problems that
/// it took; those of whom it is surest first.
std::vector<std::pair<std::size_t, Share>> caught_solvers(const Summary& summary);

/// Where the page's script finds the factor of the solver that a situation recommends: the value of data-speed.
std::string situation_key(std::size_t situation, std::size_t solver);

/// The answer to the report's question, in a sentence of HTML.
std::string one_line_answer(const Summary& summary, const std::vector<Situation>& situations);

}  // namespace lcpbench::report
