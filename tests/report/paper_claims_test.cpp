#include <algorithm>

#include <gtest/gtest.h>

#include "tests/report/paper_support.h"
#include "tests/support/solvability.h"

namespace lcpbench::paper_claims_test {
namespace {

using Json = nlohmann::ordered_json;

// What the test of a claim comes to.
constexpr const char* kConfirmed = "confirmed";
constexpr const char* kInPart = "confirmed in part";
constexpr const char* kContradicted = "contradicted";
constexpr const char* kExplained = "explained";
constexpr const char* kUndecided = "undecided";
constexpr const char* kNotTested = "not tested";

/// The rows of one claim, of one part of it.
Json rows_of_claim(const MadeSummary& made, const std::string& id, const std::string& part = "claim") {
  Json rows = Json::array();
  for (const Json& row : rows_of(made.summary, "claims-paper")) {
    if (row["claim"] == id && row["part"] == part) rows.push_back(row);
  }
  return rows;
}

std::string word(const MadeSummary& made, const std::string& id) {
  for (const Json& row : rows_of(made.summary, "claims-paper")) {
    if (row["claim"] == id) return row["word"];
  }
  return "no such claim";
}

struct Flat {
  const char* set;  ///< behind paper/
  const char* solver;
  double share;
  const char* sweep = "paper";
  double time_s = 1e-3;
};

/// Solvers with one share for worst, average and best.
MadeSummary flats(std::initializer_list<Flat> all) {
  MadeSummary made;
  for (const Flat& each : all) {
    made.flat(std::string("paper/") + each.set, each.solver, each.share, each.sweep, each.time_s);
  }
  return made;
}

/// Solvers of a set at single settings, each with the pattern of what it solves, beside a sweep that makes it a study
/// of the paper's.
MadeSummary pairs(const std::string& set, const char* a, const std::vector<bool>& solved_by_a,
                  const std::string& other_set, const char* b, const std::vector<bool>& solved_by_b) {
  MadeSummary made = flats({{"monotone/exp3", "lemke", 1}});
  made.single("paper/" + set, a, "", solved_by_a);
  made.single("paper/" + other_set, b, "", solved_by_b);
  return made;
}

/// Lemke at 1e8 without regularisation on exp5 and with it on exp6.
MadeSummary regularized(double mono5, double cop5, double mono6, double cop6, double time_ratio = 3,
                        std::int64_t wrong = 0) {
  MadeSummary made = flats({{"monotone/exp5-1e8", "lemke", mono5, "paper{cap=3n}"},
                            {"copositive/exp5-1e8", "lemke", cop5, "paper{cap=3n}"}});
  for (const auto& [set, share] : {std::pair{"paper/monotone/exp6-1e8", mono6}, {"paper/copositive/exp6-1e8", cop6}}) {
    MadeCell cell;
    cell.solved = cell.criterion = static_cast<std::int64_t>(2000 * share);
    cell.wrong = std::min(wrong, cell.trials - cell.solved);
    cell.time_s = 1e-3 * time_ratio;
    made.grid(set, "regularized", cell, cell, "paper{solver=lemke{cap=3n}}");
  }
  return made;
}

MadeSummary experiments_one_to_three(double one, double two, double three) {
  return flats(
      {{"copositive/exp1", "lemke", one}, {"copositive/exp2", "lemke", two}, {"copositive/exp3", "lemke", three}});
}

/// A cell of 20,000 trials that solves `verdict` of the problems by our verdict and `criterion` by the paper's.
void add(MadeSummary& made, const std::string& set, double criterion, double verdict) {
  MadeCell cell{.trials = 20000};
  cell.criterion = static_cast<std::int64_t>(20000 * criterion);
  cell.solved = static_cast<std::int64_t>(20000 * verdict);
  made.grid("paper/monotone/" + set, "lemke", cell, cell);
}

/// The experiment with reduced rank beside two of full rank; a second sweep where one is given.
MadeSummary reduced_rank(double solved_of_three, const MadeCell& second = {.trials = 0}) {
  MadeSummary made;
  add(made, "exp1", 1, 1);
  add(made, "exp2", 0.95, 1);
  add(made, "exp3", 0.64, solved_of_three);
  if (second.trials > 0) made.grid("paper/monotone/exp3", "lemke", second, second, "paper{engine=kernel}");
  return made;
}

MadeSummary three_and_four(double three, double four, double solved_of_three, double solved_of_four) {
  MadeSummary made;
  add(made, "exp3", three, solved_of_three);
  add(made, "exp4", four, solved_of_four);
  return made;
}

MadeSummary path_against_lemke(double monotone_time, double copositive_time, double monotone_violation,
                               double copositive_violation) {
  MadeSummary made;
  for (const bool monotone : {true, false}) {
    const std::string set = monotone ? "paper/monotone/exp6-1e5" : "paper/copositive/exp6-1e5";
    MadeCell path;
    path.time_s = monotone ? monotone_time : copositive_time;
    path.violation = monotone ? monotone_violation : copositive_violation;
    made.grid(set, "lemke", {}, {});
    made.grid(set, "path", path, path);
  }
  return made;
}

/// Two solvers on one set by the worst of their parameterisations; the best solve all.
MadeSummary by_worst(const std::string& set, std::int64_t lemke, const char* other, std::int64_t others,
                     double others_time = 1e-3, double others_violation = 1e-9) {
  MadeSummary made;
  made.grid(set, "lemke", {.criterion = lemke, .solved = lemke}, {});
  made.grid(set, other, {.criterion = others, .solved = others, .time_s = others_time, .violation = others_violation},
            {.criterion = 1980, .solved = 1980});
  return made;
}

TEST(ClaimsTest, NothingIsTestedWithoutDataAndComparisonsAreOnFile) {
  const Json claims = rows_of(flats({{"monotone/exp1", "lemke", 1}}).summary, "paper-claims");
  EXPECT_EQ(claims.size(), 16U);
  for (const Json& claim : claims) {
    EXPECT_EQ(claim["word"], kNotTested) << claim;
    EXPECT_NE(claim["needs"], "") << claim;
    EXPECT_NE(claim["test"], "") << claim;
  }
  const Json record = rows_of_claim(flats({{"monotone/exp1", "lemke", 0.95}, {"copositive/exp1", "lemke", 0.90}}),
                                    "monotone-easier")[0];
  EXPECT_NEAR(record["value"].get<double>(), 0.05, 1e-12);
  EXPECT_LT(record["low"].get<double>(), 0.05);
  EXPECT_EQ(record["stance"], "supports");
}

TEST(ClaimsTest, EveryClaimCanBeConfirmedAndContradicted) {
  struct Case {
    const char* claim;
    const char* expected;
    MadeSummary made;
  };
  const auto sides = [](double monotone, double copositive) {
    return flats({{"monotone/exp1", "lemke", monotone}, {"copositive/exp1", "lemke", copositive}});
  };
  const auto both = [](const char* other, double lemke, double others, double time_s = 1e-3) {
    return flats({{"monotone/exp1", "lemke", lemke}, {"monotone/exp1", other, others, "paper", time_s}});
  };
  const auto ceilings = [](double small, double large) {
    return flats({{"copositive/exp5-1e10", "lemke", small}, {"copositive/extra100", "lemke", large}});
  };
  const auto splitting = [](const char* solver, const std::vector<bool>& pattern) {
    return pairs("monotone/exp1", "lemke", {true}, "copositive/exp1", solver, pattern);
  };
  const double can_three = paper::solvable_share_of_exp3(), can_four = paper::solvable_share_of_exp4();
  const std::string exp2 = "paper/monotone/exp2", exp5 = "paper/monotone/exp5-1e8";
  const std::vector<Case> cases{
      {"monotone-easier", kConfirmed, sides(0.95, 0.90)},
      {"monotone-easier", kContradicted, sides(0.90, 0.95)},
      {"monotone-easier", kUndecided, sides(0.95, 0.95)},
      // One opposing experiment.
      {"monotone-easier", kInPart,
       flats({{"monotone/exp1", "lemke", 0.9},
              {"copositive/exp1", "lemke", 0.8},
              {"monotone/exp3", "lemke", 0.5},
              {"copositive/exp3", "lemke", 0.6}})},
      {"regularisation-gain", kConfirmed, regularized(0.90, 0.80, 0.98, 0.95)},
      {"regularisation-gain", kContradicted, regularized(0.90, 0.80, 0.85, 0.70)},
      {"regularisation-gain", kConfirmed,
       pairs("monotone/exp5-1e8", "lemke", {true, false}, "monotone/exp6-1e8", "regularized", {true, true})},
      {"regularisation-gain", kContradicted,
       pairs("monotone/exp5-1e8", "lemke", {true, true}, "monotone/exp6-1e8", "regularized", {true, false})},
      {"regularisation-closes-gap", kConfirmed, regularized(0.90, 0.70, 0.99, 0.96)},
      {"regularisation-closes-gap", kContradicted, regularized(0.90, 0.80, 0.95, 0.80)},
      {"regularisation-cost", kConfirmed, regularized(0.9, 0.8, 0.9, 0.8, 3)},
      {"regularisation-cost", kContradicted, regularized(0.9, 0.8, 0.9, 0.8, 0.9)},
      {"regularisation-false-claims", kConfirmed, regularized(0.9, 0.8, 0.9, 0.8)},
      {"regularisation-false-claims", kContradicted, regularized(0.9, 0.8, 0.9, 0.8, 3, 150)},
      {"redundancy-a-little", kConfirmed, experiments_one_to_three(0.97, 0.92, 0.6)},
      {"redundancy-a-little", kContradicted, experiments_one_to_three(0.97, 0.60, 0.6)},  // a lot
      {"redundancy-a-little", kContradicted, experiments_one_to_three(0.60, 0.97, 0.6)},  // raises
      // Surely below 10 points, but not surely above 0: half of a claim is no claim.
      {"redundancy-a-little", kUndecided, experiments_one_to_three(0.97, 0.97, 0.6)},
      {"redundancy-a-little", kUndecided, experiments_one_to_three(0.97, 0.87, 0.6)},
      {"rank-far-more", kConfirmed, experiments_one_to_three(0.97, 0.92, 0.60)},
      {"rank-far-more", kContradicted, experiments_one_to_three(0.97, 0.70, 0.75)},
      // All that is solvable is solved, or the solver fails on what can be solved.
      {"rank-far-more", kExplained, reduced_rank(can_three)},
      {"rank-far-more", kConfirmed, reduced_rank(0.64)},
      // One test of several that supports the cause does not explain; a sweep on few of the problems tests none.
      {"rank-far-more", kConfirmed, reduced_rank(can_three, {.trials = 12000, .criterion = 7680, .solved = 10000})},
      {"rank-far-more", kExplained, reduced_rank(can_three, {.trials = 2000, .criterion = 1280, .solved = 1700})},
      {"exp4-above-exp3", kExplained, three_and_four(0.64, 0.73, can_three, can_four)},
      {"exp4-above-exp3", kConfirmed, three_and_four(0.64, 0.73, 0.64, 0.73)},
      {"exp4-above-exp3", kContradicted, three_and_four(0.73, 0.64, can_three, can_four)},
      {"lemke-best", kConfirmed, both("primal_dual", 1, 0.9)},
      {"lemke-best", kContradicted, both("path", 0.9, 1)},
      {"lemke-best", kUndecided, both("path", 1, 1)},
      {"lemke-best", kNotTested, both("bullet_lemke", 0.5, 1)},  // not one of the three
      {"lemke-best", kContradicted,
       pairs("monotone/exp1", "lemke", {true, true, false}, "monotone/exp1", "primal_dual", {true})},
      // A claim on every set is not confirmed by one of them.
      {"lemke-best", kInPart,
       flats({{"monotone/exp1", "lemke", 1},
              {"monotone/exp1", "primal_dual", 0.8},
              {"monotone/exp3", "lemke", 1},
              {"monotone/exp3", "primal_dual", 1}})},
      {"path-wider", kConfirmed, by_worst(exp2, 1500, "path", 1900, 5e-4, 1e-10)},
      {"path-wider", kInPart, by_worst(exp2, 1500, "path", 1900, 5e-3, 1e-10)},  // not on time
      {"path-wider", kContradicted, by_worst(exp2, 1950, "path", 1500, 5e-3, 1e-8)},
      {"lemke-path-speed", kConfirmed, path_against_lemke(5e-3, 1e-4, 1e-9, 1e-9)},
      {"lemke-path-speed", kContradicted, path_against_lemke(1e-3, 1e-3, 1e-9, 1e-9)},
      {"violation", kConfirmed, path_against_lemke(1e-3, 1e-3, 3e-9, 3e-10)},
      {"violation", kContradicted, path_against_lemke(1e-3, 1e-3, 3e-7, 3e-7)},
      {"ip-robust", kConfirmed, by_worst(exp5, 1000, "primal_dual", 1980)},
      {"ip-robust", kContradicted, by_worst(exp5, 1990, "primal_dual", 1000)},
      {"ip-not-recommended", kConfirmed, both("primal_dual", 1, 0.7, 1e-1)},
      {"ip-not-recommended", kContradicted, both("primal_dual", 0.7, 1, 1e-4)},
      {"ip-not-recommended", kInPart, both("primal_dual", 1, 0.7, 1e-4)},
      {"ceilings", kConfirmed, ceilings(0.99, 0.95)},
      {"ceilings", kContradicted, ceilings(0.99, 0.70)},
      {"splitting", kConfirmed, splitting("psor", {true, false, false, false})},
      {"splitting", kContradicted, splitting("bullet_pgs", {true, true, true, false})},
      {"splitting", kNotTested, splitting("bullet_dantzig", {true})}};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    EXPECT_EQ(word(cases[i].made, cases[i].claim), cases[i].expected) << cases[i].claim << ", case " << i;
  }
}

/// Many comparisons of one claim: the share that decides a lone one is undecided among fifty.
TEST(ClaimsTest, WordsAllowForTheNumberOfComparisons) {
  std::vector<bool> pattern(200, true);
  std::fill_n(pattern.begin(), 117, false);  // 41.5 %, 2.4 standard errors below a half
  for (const int solvers : {1, 25}) {
    MadeSummary made = flats({{"monotone/exp1", "lemke", 1}});
    for (int i = 0; i < solvers; ++i) {
      made.single("paper/monotone/exp1", "psor", "sweeps=" + std::to_string(i), pattern);
    }
    EXPECT_EQ(word(made, "splitting"), solvers == 1 ? kConfirmed : kUndecided);
  }
}

/// A solver that ran on even trials only has no share on the odd ones, and what a licence does not allow is no failure.
TEST(ClaimsTest, SharesThatDoNotExistAreNotCompared) {
  MadeSummary halves = flats({{"monotone/exp1", "lemke", 1}, {"monotone/exp1", "primal_dual", 0.5}});
  for (Cell& cell : halves.summary.cells) cell.halves[1] = {};
  EXPECT_EQ(word(halves, "lemke-best"), kNotTested);
  MadeSummary refuses = flats({{"monotone/exp1", "lemke", 1}});
  const MadeCell path{.criterion = 1500, .solved = 1500, .refused = 500};
  refuses.grid("paper/monotone/exp1", "path", path, path);
  EXPECT_EQ(word(refuses, "lemke-best"), kNotTested);
}

/// What a sweep of a small part of the problems says against a claim is left to the sweeps of all of them.
TEST(ClaimsTest, ASubsampleTakesNoPart) {
  for (const std::int64_t trials : {12000, 4000}) {
    MadeSummary made = three_and_four(0.64, 0.73, 0.8, 0.9);
    const MadeCell more{.trials = trials, .criterion = trials * 9 / 10, .solved = trials * 9 / 10};
    const MadeCell less{.trials = trials, .criterion = trials * 3 / 10, .solved = trials * 3 / 10};
    made.grid("paper/monotone/exp3", "lemke", more, more, "paper{engine=kernel}");
    made.grid("paper/monotone/exp4", "lemke", less, less, "paper{engine=kernel}");
    EXPECT_EQ(word(made, "exp4-above-exp3"), trials == 12000 ? kInPart : kConfirmed);
    // Problems that no sweep met make none of them a subsample.
    for (SetSummary& set : made.summary.sets) set.problems = 100000;
    EXPECT_EQ(word(made, "exp4-above-exp3"), trials == 12000 ? kInPart : kConfirmed);
  }
}

/// The level in a label hides neither the solver's family nor what a regularised one wraps.
TEST(ClaimsTest, TwoInstructionSetLevelsAreTested) {
  MadeSummary made;
  for (const char* isa : {"baseline", "avx512"}) {
    made.isa = isa;
    made.flat("paper/monotone/exp5-1e8", "lemke", 0.9, "paper{cap=3n}");
    made.flat("paper/monotone/exp6-1e8", "regularized", 0.98, "paper{solver=lemke{cap=3n}}");
    made.flat("paper/monotone/exp5-1e8", "primal_dual", 0.7);
  }
  for (const char* claim : {"regularisation-gain", "lemke-best"}) {
    EXPECT_EQ(word(made, claim), kConfirmed);
    EXPECT_EQ(rows_of_claim(made, claim).size(), 4U) << claim << ": two measures, each level with itself";
  }
}

/// More parameterisations on the same problems are no more problems.
TEST(ClaimsTest, CopiesOfACellDecideNothing) {
  std::vector<double> low;
  for (const int cells : {2, 81}) {
    MadeSummary made;
    const MadeCell cell{.trials = 40, .criterion = 40, .solved = 40};
    MadeCell slower = cell;
    slower.time_s = 1.2e-3;
    made.grid("paper/monotone/exp5-1e8", "lemke", cell, cell, "paper{cap=3n}", cells);
    made.grid("paper/monotone/exp6-1e8", "regularized", slower, slower, "paper{solver=lemke{cap=3n}}", cells);
    const Json rows = rows_of_claim(made, "regularisation-cost");
    ASSERT_EQ(rows.size(), 1U);
    EXPECT_EQ(rows[0]["word"], kUndecided);
    low.push_back(rows[0]["low"]);
  }
  EXPECT_NEAR(low[0], low[1], 0.01);
}

TEST(ClaimsTest, PairsAreCountedOverTheProblemsThatBothTook) {
  const Json confirmed = rows_of_claim(
      pairs("monotone/exp1", "lemke", {true}, "monotone/exp1", "primal_dual", {true, true, false}), "lemke-best");
  ASSERT_EQ(confirmed.size(), 1U);
  EXPECT_EQ(confirmed[0]["word"], kConfirmed);
  EXPECT_NE(confirmed[0]["detail"].get<std::string>().find("66 only the first, 0 only the second"), std::string::npos);
  // Refused problems are in no pair, and trial 3 of one seed is not trial 3 of another.
  MadeSummary made = pairs("monotone/exp1", "lemke", {true}, "monotone/exp1", "path", {false});
  std::vector<Outcome>& path = made.summary.cells.back().outcomes;
  for (std::size_t i = 0; i < 150; ++i) path[i].claim = Claim::kUnsupported;
  for (std::size_t i = 150; i < 190; ++i) path[i].problem += 7 * kTrialsOfASeed;
  const Json rows = rows_of_claim(made, "lemke-best");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0]["detail"].get<std::string>().substr(0, 11), "10 problems");
}

/// Five against none: the interval excludes 0 at 5 %, the printed p of 0.06 does not.
TEST(ClaimsTest, NoStanceAgainstTheExactTest) {
  std::vector<bool> fails_five(200, true);
  std::fill_n(fails_five.begin(), 5, false);
  const Json rows =
      rows_of_claim(pairs("monotone/exp1", "lemke", {true}, "monotone/exp1", "path", fails_five), "lemke-best");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_GT(rows[0]["low"].get<double>(), 0);
  EXPECT_EQ(rows[0]["stance"], "undecided");
}

/// Largest violations are numbers without an interval: beside the claim, whatever they are.
TEST(ClaimsTest, LargestViolationsStandBesideTheClaim) {
  const Json reversed = rows_of_claim(path_against_lemke(1e-3, 1e-3, 3e-10, 3e-9), "violation", "beyond");
  ASSERT_FALSE(reversed.empty());
  EXPECT_EQ(reversed[0]["word"], kConfirmed);
  EXPECT_EQ(reversed[0]["stance"], "not tested");
}

/// The worst of many equal parameterisations lies low by chance on the trials it is chosen on, not on the others.
TEST(ClaimsTest, RangesAreHeldOut) {
  MadeSummary made = flats({{"monotone/exp5-1e8", "primal_dual", 0.9}, {"monotone/exp5-1e8", "lemke", 0.9}});
  Cell& unlucky = made.summary.cells.back();
  unlucky.halves[0].criterion = unlucky.halves[0].solved = 700;
  unlucky.criterion = 1600;
  unlucky.counts[static_cast<std::size_t>(Claim::kSolved)][static_cast<std::size_t>(Verdict::kSolved)] = 1600;
  EXPECT_EQ(word(made, "ip-robust"), kUndecided);
}

}  // namespace
}  // namespace lcpbench::paper_claims_test
