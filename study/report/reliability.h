#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/summary/summary.h"
#include "study/statistics/pairs.h"

// Who may be called reliable: one rule for every section, table and picture.

namespace lcpbench::report {

/// A share of a count, with its Wilson interval.
struct Share {
  std::int64_t part = 0;
  std::int64_t whole = 0;

  double value() const;
  Interval interval() const;
};

/// A reliable solver solves at least this share of the problems that it takes: the lower end of its 95 % interval does.
inline constexpr double kReliableShare = 0.9;

/// A solver that was caught with a false claim stays reliable only where the upper end of the 95 % interval of its
/// share of false claims is at most this.
inline constexpr double kFalseClaimBound = 0.01;

/// A solver that refuses more than this share of the problems does not take these problems.
inline constexpr double kRefusedBound = 0.1;

/// The fewest problems that can show a share of kReliableShare: that many, all solved, have a lower end above it.
std::int64_t least_problems();

/// A study that ended before this share of its plan was done carries no endorsement: its plan said how many problems
/// the paired test needs. ample_problems() do without.
inline constexpr double kPlanShare = 0.5;

/// So many problems without a false claim bound their share by kFalseClaimBound.
std::int64_t ample_problems();

/// What the rule goes by.
struct Evidence {
  Share solved;                    ///< of the problems that it took and that are not proven unsolvable
  Share solved_of_met;             ///< the same, the refused ones among the whole
  Share false_claims;              ///< of the problems that it took
  Share refused;                   ///< of the problems that it met
  bool other_model = false;        ///< its friction is not the problems' pyramid
  bool no_time = false;            ///< nobody measured the time of any answer
  bool met_all_sets = true;        ///< met problems of every set in question
  double plan_share = 1;           ///< of the cells planned for these sets: those that are done; 1 where nobody knows
  std::int64_t most_taken = 0;     ///< problems taken by the solver that took the most
  bool solves_fewer = false;       ///< than the best on the problems that both took, significantly
  bool more_false_claims = false;  ///< than the best, in the same sense
};

enum class Standing {
  kReliable,
  kUnreliable,
  kTooFew,  ///< too few problems to say
  kPartly,  ///< takes, or met, a part of these problems only
};

/// Why a solver has its standing.
enum class Ground {
  kNone,           ///< reliable
  kFalseClaims,    ///< unreliable: false claims above the bound, or significantly more than the best
  kUnsolved,       ///< unreliable: the whole interval of its share solved is below kReliableShare
  kBehindTheBest,  ///< unreliable: solves significantly fewer than the best
  kFewProblems,    ///< too few: fewer than least_problems()
  kSmallSample,    ///< too few: less than half as many problems as another solver
  kShortOfPlan,    ///< too few: less than kPlanShare of the plan is done
  kWideInterval,   ///< too few: the interval of its share solved contains kReliableShare
  kOtherModel,     ///< partly: solves another friction model, and was judged by that
  kNoTime,         ///< partly: nobody measured its time
  kSomeSets,       ///< partly: did not meet every set
  kRefuses,        ///< partly: refused more than kRefusedBound, or all
};

struct Reliability {
  Standing standing = Standing::kTooFew;
  Ground ground = Ground::kFewProblems;

  bool reliable() const { return standing == Standing::kReliable; }
};

/// The rule. A false claim that was seen counts at any number of problems; all else needs least_problems().
Reliability judge_reliability(const Evidence& evidence);

/// "reliable", "false_claims", "unsolved", "behind_the_best", "few_problems", "small_sample", "short_of_plan",
/// "wide_interval", "other_model", "no_time", "some_sets", "refuses": the words of tables.
const char* to_string(Ground ground);

/// What a solver did on the problems of some sets, in the order of (set, problem).
struct Record {
  std::size_t solver = 0;  ///< index into Summary::solvers
  Evidence evidence;
  std::int64_t crashed = 0;
  std::vector<std::pair<std::size_t, const Outcome*>> outcomes;
  Reliability reliability;
};

/// Every solver that met a problem of `sets` (indices into Summary::sets) and did not refuse all of a set's, judged.
/// The best is the solver with the surest share solved - the highest lower end - among those that took at least half as
/// many problems as any other, met all sets, solve the pyramid, and have a time. Points into the summary. O(solvers x answers).
std::vector<Record> judged_records(const Summary& summary, const std::vector<std::size_t>& sets);

/// The time of one solver over that of another.
struct TimeFactor {
  Estimate ratio{kNoNumber, kNoNumber, kNoNumber};  ///< of the sums over `problems`
  std::int64_t problems = 0;                        ///< that both solved, with known times
  std::int64_t of = 0;                              ///< that both met

  /// Fewer than least_problems() carry no factor.
  bool shown() const { return problems >= least_problems(); }
  /// "3.10x (2.70–3.50) n=240", or without enough problems "- (4 of 25)".
  std::string text() const;
};

/// That of a cell over the reference of its set.
TimeFactor over_reference(const Cell& cell);

/// Calls visit(a, b) for every problem that both met.
template <class Visit>
void for_each_pair(const Record& a, const Record& b, Visit visit) {
  const auto key = [](const auto& outcome) { return std::pair(outcome.first, outcome.second->problem); };
  lcpbench::for_each_pair(a.outcomes, b.outcomes, key,
                          [&](const auto& left, const auto& right) { visit(*left.second, *right.second); });
}

/// true, false, or null where the problems are too few or the solver met a part of them.
nlohmann::ordered_json reliable_json(const Reliability& reliability);

/// The numbers of the rule, for summary.json.
nlohmann::ordered_json reliability_rule_json();

/// The rule with its numbers in sentences, HTML.
std::string reliability_rule_html();

/// The share of the cells planned for some sets that is done; 1 where nobody knows.
double plan_share(const Summary& summary, const std::vector<std::size_t>& sets);

/// Can so many problems, of such a share of the plan, show nobody to be reliable?
bool too_few(std::int64_t problems, double plan_share);

/// "too few to say: 12 problems; the report needs 35", "too few to say: 88 problems, 11 % of the plan; the report needs
/// 50 % of it, or 381 problems". @pre too_few(problems, plan_share)
std::string too_few_text(std::int64_t problems, double plan_share);

}  // namespace lcpbench::report
