#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/solvability.h"
#include "tests/report/paper_support.h"

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

TEST(ClaimsTest, NothingIsTestedWithoutData) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 1);
  const Json claims = rows_of(made.summary, "paper-claims");
  EXPECT_EQ(claims.size(), 16U);
  for (const Json& claim : claims) {
    EXPECT_EQ(claim["word"], kNotTested) << claim;
    EXPECT_NE(claim["needs"], "") << claim;
    EXPECT_NE(claim["test"], "") << claim;
  }
}

TEST(ClaimsTest, MonotoneAgainstCopositive) {
  const auto made = [](double monotone, double copositive) {
    MadeSummary summary;
    summary.flat("paper/monotone/exp1", "lemke", monotone);
    summary.flat("paper/copositive/exp1", "lemke", copositive);
    return summary;
  };
  EXPECT_EQ(word(made(0.95, 0.90), "monotone-easier"), kConfirmed);
  EXPECT_EQ(word(made(0.90, 0.95), "monotone-easier"), kContradicted);
  EXPECT_EQ(word(made(0.95, 0.95), "monotone-easier"), kUndecided);
}

TEST(ClaimsTest, OneOpposingExperimentLeavesAClaimConfirmedInPart) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 0.9);
  made.flat("paper/copositive/exp1", "lemke", 0.8);
  made.flat("paper/monotone/exp3", "lemke", 0.5);
  made.flat("paper/copositive/exp3", "lemke", 0.6);
  EXPECT_EQ(word(made, "monotone-easier"), kInPart);
}

/// Many comparisons of one claim: the share that decides a lone one is undecided among fifty.
TEST(ClaimsTest, WordsAllowForTheNumberOfComparisons) {
  const auto made = [](int solvers) {
    MadeSummary summary;
    summary.flat("paper/monotone/exp1", "lemke", 1);
    std::vector<bool> pattern(200, true);
    std::fill_n(pattern.begin(), 117, false);  // 41.5 %, 2.4 standard errors below a half
    for (int i = 0; i < solvers; ++i) {
      summary.single("paper/monotone/exp1", "psor", "sweeps=" + std::to_string(i), pattern);
    }
    return summary;
  };
  EXPECT_EQ(word(made(1), "splitting"), kConfirmed);
  EXPECT_EQ(word(made(25), "splitting"), kUndecided);
}

/// A solver that ran on even trials only has no share on the odd ones: no comparison, rather than one never decided.
TEST(ClaimsTest, SharesThatDoNotExistAreNotCompared) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 1);
  made.flat("paper/monotone/exp1", "primal_dual", 0.5);
  for (Cell& cell : made.summary.cells) cell.halves[1] = {};
  EXPECT_EQ(word(made, "lemke-best"), kNotTested);
}

MadeSummary regularized(double mono5, double cop5, double mono6, double cop6, double time_ratio = 3,
                        std::int64_t wrong = 0) {
  MadeSummary made;
  made.flat("paper/monotone/exp5-1e8", "lemke", mono5, "paper{cap=3n}");
  made.flat("paper/copositive/exp5-1e8", "lemke", cop5, "paper{cap=3n}");
  const std::string sweep = "paper{solver=lemke{cap=3n}}";
  for (const auto& [set, share] : {std::pair{"paper/monotone/exp6-1e8", mono6}, {"paper/copositive/exp6-1e8", cop6}}) {
    MadeCell cell;
    cell.solved = cell.criterion = static_cast<std::int64_t>(2000 * share);
    cell.wrong = std::min(wrong, cell.trials - cell.solved);
    cell.time_s = 1e-3 * time_ratio;
    made.grid(set, "regularized", cell, cell, sweep);
  }
  return made;
}

TEST(ClaimsTest, RegularisationsGain) {
  EXPECT_EQ(word(regularized(0.90, 0.80, 0.98, 0.95), "regularisation-gain"), kConfirmed);
  EXPECT_EQ(word(regularized(0.90, 0.80, 0.85, 0.70), "regularisation-gain"), kContradicted);
}

TEST(ClaimsTest, RegularisationsGainInPairs) {
  const auto made = [](const std::vector<bool>& plain, const std::vector<bool>& regularized) {
    MadeSummary summary;
    summary.flat("paper/monotone/exp1", "lemke", 1);
    summary.single("paper/monotone/exp5-1e8", "lemke", "", plain);
    summary.single("paper/monotone/exp6-1e8", "regularized", "", regularized);
    return summary;
  };
  EXPECT_EQ(word(made({true, false}, {true, true}), "regularisation-gain"), kConfirmed);
  EXPECT_EQ(word(made({true, true}, {true, false}), "regularisation-gain"), kContradicted);
}

TEST(ClaimsTest, RegularisationAndTheAdvantageOfMonotoneProblems) {
  EXPECT_EQ(word(regularized(0.90, 0.70, 0.99, 0.96), "regularisation-closes-gap"), kConfirmed);
  EXPECT_EQ(word(regularized(0.90, 0.80, 0.95, 0.80), "regularisation-closes-gap"), kContradicted);
}

TEST(ClaimsTest, RegularisationsCost) {
  EXPECT_EQ(word(regularized(0.9, 0.8, 0.9, 0.8, 3), "regularisation-cost"), kConfirmed);
  EXPECT_EQ(word(regularized(0.9, 0.8, 0.9, 0.8, 0.9), "regularisation-cost"), kContradicted);
}

TEST(ClaimsTest, RegularisationsFalseClaims) {
  EXPECT_EQ(word(regularized(0.9, 0.8, 0.9, 0.8), "regularisation-false-claims"), kConfirmed);
  EXPECT_EQ(word(regularized(0.9, 0.8, 0.9, 0.8, 3, 150), "regularisation-false-claims"), kContradicted);
}

MadeSummary experiments_one_to_three(double one, double two, double three) {
  MadeSummary made;
  made.flat("paper/copositive/exp1", "lemke", one);
  made.flat("paper/copositive/exp2", "lemke", two);
  made.flat("paper/copositive/exp3", "lemke", three);
  return made;
}

TEST(ClaimsTest, RedundancyLowersALittle) {
  EXPECT_EQ(word(experiments_one_to_three(0.97, 0.92, 0.6), "redundancy-a-little"), kConfirmed);
  EXPECT_EQ(word(experiments_one_to_three(0.97, 0.60, 0.6), "redundancy-a-little"), kContradicted);  // a lot
  EXPECT_EQ(word(experiments_one_to_three(0.60, 0.97, 0.6), "redundancy-a-little"), kContradicted);  // raises
  // Surely below 10 points, but not surely above 0: half of a claim is no claim.
  EXPECT_EQ(word(experiments_one_to_three(0.97, 0.97, 0.6), "redundancy-a-little"), kUndecided);
  EXPECT_EQ(word(experiments_one_to_three(0.97, 0.87, 0.6), "redundancy-a-little"), kUndecided);
}

TEST(ClaimsTest, RankLowersFarMore) {
  EXPECT_EQ(word(experiments_one_to_three(0.97, 0.92, 0.60), "rank-far-more"), kConfirmed);
  EXPECT_EQ(word(experiments_one_to_three(0.97, 0.70, 0.75), "rank-far-more"), kContradicted);
}

/// A cell that solves `verdict` of the problems by our verdict and `criterion` by the paper's.
MadeCell cell_with(double criterion, double verdict) {
  MadeCell cell{.trials = 20000};
  cell.criterion = static_cast<std::int64_t>(20000 * criterion);
  cell.solved = static_cast<std::int64_t>(20000 * verdict);
  return cell;
}

void add(MadeSummary& made, const std::string& set, double criterion, double verdict) {
  made.grid(set, "lemke", cell_with(criterion, verdict), cell_with(criterion, verdict));
}

TEST(ClaimsTest, RankIsExplainedWhenAllThatIsSolvableIsSolved) {
  const auto made = [](double solved_of_three) {
    MadeSummary summary;
    add(summary, "paper/monotone/exp1", 1, 1);
    add(summary, "paper/monotone/exp2", 0.95, 1);
    add(summary, "paper/monotone/exp3", 0.64, solved_of_three);
    return summary;
  };
  EXPECT_EQ(word(made(paper::solvable_share_of_exp3()), "rank-far-more"), kExplained);
  EXPECT_EQ(word(made(0.64), "rank-far-more"), kConfirmed);  // the solver fails on what can be solved
}

TEST(ClaimsTest, FourAboveThree) {
  const auto made = [](double three, double four, double solved_of_three, double solved_of_four) {
    MadeSummary summary;
    add(summary, "paper/monotone/exp3", three, solved_of_three);
    add(summary, "paper/monotone/exp4", four, solved_of_four);
    return summary;
  };
  const double can_three = paper::solvable_share_of_exp3();
  const double can_four = paper::solvable_share_of_exp4();
  EXPECT_EQ(word(made(0.64, 0.73, can_three, can_four), "exp4-above-exp3"), kExplained);
  EXPECT_EQ(word(made(0.64, 0.73, 0.64, 0.73), "exp4-above-exp3"), kConfirmed);
  EXPECT_EQ(word(made(0.73, 0.64, can_three, can_four), "exp4-above-exp3"), kContradicted);
}

/// One test of several that supports the cause does not explain; a sweep on a small part of the problems tests none.
TEST(ClaimsTest, ACauseNeedsEveryTestOfIt) {
  const double can_three = paper::solvable_share_of_exp3();
  const auto made = [&](const MadeCell& second) {
    MadeSummary summary;
    add(summary, "paper/monotone/exp1", 1, 1);
    add(summary, "paper/monotone/exp2", 0.95, 1);
    add(summary, "paper/monotone/exp3", 0.64, can_three);
    summary.grid("paper/monotone/exp3", "lemke", second, second, "paper{engine=kernel}");
    return summary;
  };
  EXPECT_EQ(word(made({.trials = 12000, .criterion = 7680, .solved = 10000}), "rank-far-more"), kConfirmed);
  EXPECT_EQ(word(made({.trials = 2000, .criterion = 1280, .solved = 1700}), "rank-far-more"), kExplained);
}

/// What a sweep of a small part of the problems says against a claim is left to the sweeps of all of them.
TEST(ClaimsTest, ASubsampleTakesNoPart) {
  const auto made = [](std::int64_t trials) {
    MadeSummary summary;
    add(summary, "paper/monotone/exp3", 0.64, 0.8);
    add(summary, "paper/monotone/exp4", 0.73, 0.9);
    const MadeCell more{.trials = trials, .criterion = trials * 9 / 10, .solved = trials * 9 / 10};
    const MadeCell less{.trials = trials, .criterion = trials * 3 / 10, .solved = trials * 3 / 10};
    summary.grid("paper/monotone/exp3", "lemke", more, more, "paper{engine=kernel}");
    summary.grid("paper/monotone/exp4", "lemke", less, less, "paper{engine=kernel}");
    return summary;
  };
  EXPECT_EQ(word(made(12000), "exp4-above-exp3"), kInPart);
  EXPECT_EQ(word(made(4000), "exp4-above-exp3"), kConfirmed);

  // Problems that no sweep met make none of them a subsample.
  MadeSummary beside = made(4000);
  for (SetSummary& set : beside.summary.sets) set.problems = 100000;
  EXPECT_EQ(word(beside, "exp4-above-exp3"), kConfirmed);
}

/// A claim on every set is not confirmed by one of them.
TEST(ClaimsTest, EverySetMeansEverySet) {
  const auto made = [](const std::vector<std::pair<double, double>>& shares) {
    MadeSummary summary;
    const std::vector<std::string> names{"exp1", "exp3", "exp5-1e5", "exp5-1e8"};
    for (std::size_t i = 0; i < shares.size(); ++i) {
      summary.flat("paper/monotone/" + names[i], "lemke", shares[i].first);
      summary.flat("paper/monotone/" + names[i], "primal_dual", shares[i].second);
    }
    return summary;
  };
  EXPECT_EQ(word(made({{1, 0.8}, {1, 0.8}}), "lemke-best"), kConfirmed);
  EXPECT_EQ(word(made({{1, 0.8}, {1, 1}}), "lemke-best"), kInPart);
  EXPECT_EQ(word(made({{1, 0.8}, {1, 1}, {1, 1}}), "lemke-best"), kUndecided);
}

/// What a licence does not allow is no failure to solve.
TEST(ClaimsTest, RefusalsTakeNoPart) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 1);
  const MadeCell path{.criterion = 1500, .solved = 1500, .refused = 500};
  made.grid("paper/monotone/exp1", "path", path, path);
  EXPECT_EQ(word(made, "lemke-best"), kNotTested);
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
  EXPECT_EQ(word(made, "lemke-best"), kConfirmed);
  EXPECT_EQ(word(made, "regularisation-gain"), kConfirmed);
  for (const char* claim : {"regularisation-gain", "lemke-best"}) {
    EXPECT_EQ(rows_of_claim(made, claim).size(), 4U) << claim << ": two measures, each level with itself";
  }
}

/// More parameterisations on the same problems are no more problems.
TEST(ClaimsTest, CopiesOfACellDecideNothing) {
  const auto made = [](int cells) {
    MadeSummary summary;
    const MadeCell cell{.trials = 40, .criterion = 40, .solved = 40};
    MadeCell slower = cell;
    slower.time_s = 1.2e-3;
    summary.grid("paper/monotone/exp5-1e8", "lemke", cell, cell, "paper{cap=3n}", cells);
    summary.grid("paper/monotone/exp6-1e8", "regularized", slower, slower, "paper{solver=lemke{cap=3n}}", cells);
    return summary;
  };
  const Json few = rows_of_claim(made(2), "regularisation-cost");
  const Json many = rows_of_claim(made(81), "regularisation-cost");
  ASSERT_EQ(many.size(), 1U);
  EXPECT_EQ(few[0]["word"], kUndecided);
  EXPECT_EQ(many[0]["word"], kUndecided);
  EXPECT_NEAR(many[0]["low"].get<double>(), few[0]["low"].get<double>(), 0.01);
}

/// Refused problems are in no pair, and trial 3 of one seed is not trial 3 of another.
TEST(ClaimsTest, PairsAreOfProblemsThatBothTook) {
  MadeSummary made;
  made.flat("paper/monotone/exp3", "lemke", 1);
  made.single("paper/monotone/exp1", "lemke", "", {true});
  made.single("paper/monotone/exp1", "path", "", {false});
  std::vector<Outcome>& path = made.summary.cells.back().outcomes;
  for (std::size_t i = 0; i < 150; ++i) path[i].claim = Claim::kUnsupported;
  for (std::size_t i = 150; i < 190; ++i) path[i].problem += 7 * kTrialsOfASeed;
  const Json rows = rows_of_claim(made, "lemke-best");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0]["detail"].get<std::string>().substr(0, 11), "10 problems");
}

/// Five against none: the interval excludes 0 at 5 %, the printed p of 0.06 does not.
TEST(ClaimsTest, NoStanceAgainstTheExactTest) {
  MadeSummary made;
  made.flat("paper/monotone/exp3", "lemke", 1);
  std::vector<bool> fails_five(200, true);
  std::fill_n(fails_five.begin(), 5, false);
  made.single("paper/monotone/exp1", "lemke", "", {true});
  made.single("paper/monotone/exp1", "path", "", fails_five);
  const Json rows = rows_of_claim(made, "lemke-best");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_GT(rows[0]["low"].get<double>(), 0);
  EXPECT_EQ(rows[0]["stance"], "undecided");
}

MadeSummary two_solvers(const std::string& other, double lemke, double others, const char* kind = "monotone") {
  MadeSummary made;
  made.flat(std::string("paper/") + kind + "/exp1", "lemke", lemke);
  made.flat(std::string("paper/") + kind + "/exp1", other, others);
  return made;
}

TEST(ClaimsTest, LemkeIsBest) {
  EXPECT_EQ(word(two_solvers("primal_dual", 1, 0.9), "lemke-best"), kConfirmed);
  EXPECT_EQ(word(two_solvers("path", 0.9, 1), "lemke-best"), kContradicted);
  EXPECT_EQ(word(two_solvers("path", 1, 1), "lemke-best"), kUndecided);
  EXPECT_EQ(word(two_solvers("bullet_lemke", 0.5, 1), "lemke-best"), kNotTested);  // not one of the three
}

TEST(ClaimsTest, LemkeIsBestInPairs) {
  const auto made = [](const std::vector<bool>& lemke, const std::vector<bool>& other) {
    MadeSummary summary;
    summary.flat("paper/monotone/exp3", "lemke", 1);
    summary.single("paper/monotone/exp1", "lemke", "", lemke);
    summary.single("paper/monotone/exp1", "primal_dual", "", other);
    return summary;
  };
  const Json confirmed = rows_of_claim(made({true}, {true, true, false}), "lemke-best");
  ASSERT_EQ(confirmed.size(), 1U);
  EXPECT_EQ(confirmed[0]["word"], kConfirmed);
  EXPECT_NE(confirmed[0]["detail"].get<std::string>().find("66 only the first, 0 only the second"), std::string::npos);
  EXPECT_EQ(word(made({true, true, false}, {true}), "lemke-best"), kContradicted);
}

TEST(ClaimsTest, PathIsBetterOverItsParameters) {
  const auto made = [](std::int64_t lemke_worst, std::int64_t path_worst, double path_time, double path_violation) {
    MadeSummary summary;
    MadeCell lemke{.criterion = lemke_worst, .solved = lemke_worst};
    MadeCell path{.criterion = path_worst, .solved = path_worst, .time_s = path_time, .violation = path_violation};
    summary.grid("paper/monotone/exp2", "lemke", lemke, {.criterion = 2000, .solved = 2000});
    summary.grid("paper/monotone/exp2", "path", path, {.criterion = 1980, .solved = 1980});
    return summary;
  };
  EXPECT_EQ(word(made(1500, 1900, 5e-4, 1e-10), "path-wider"), kConfirmed);
  EXPECT_EQ(word(made(1500, 1900, 5e-3, 1e-10), "path-wider"), kInPart);  // not on time
  EXPECT_EQ(word(made(1950, 1500, 5e-3, 1e-8), "path-wider"), kContradicted);
}

MadeSummary path_against_lemke(double monotone_time, double copositive_time, double monotone_violation,
                               double copositive_violation) {
  MadeSummary made;
  for (const char* kind : {"monotone", "copositive"}) {
    const bool monotone = std::string(kind) == "monotone";
    const std::string set = std::string("paper/") + kind + "/exp6-1e5";
    MadeCell path;
    path.time_s = monotone ? monotone_time : copositive_time;
    path.violation = monotone ? monotone_violation : copositive_violation;
    made.grid(set, "lemke", {}, {});
    made.grid(set, "path", path, path);
  }
  return made;
}

TEST(ClaimsTest, LemkesAndPathsTimes) {
  EXPECT_EQ(word(path_against_lemke(5e-3, 1e-4, 1e-9, 1e-9), "lemke-path-speed"), kConfirmed);
  EXPECT_EQ(word(path_against_lemke(1e-3, 1e-3, 1e-9, 1e-9), "lemke-path-speed"), kContradicted);
}

TEST(ClaimsTest, Violations) {
  EXPECT_EQ(word(path_against_lemke(1e-3, 1e-3, 3e-9, 3e-10), "violation"), kConfirmed);
  EXPECT_EQ(word(path_against_lemke(1e-3, 1e-3, 3e-7, 3e-7), "violation"), kContradicted);
  // Largest violations are numbers without an interval: beside the claim, whatever they are.
  const Json reversed = rows_of_claim(path_against_lemke(1e-3, 1e-3, 3e-10, 3e-9), "violation", "beyond");
  ASSERT_FALSE(reversed.empty());
  EXPECT_EQ(reversed[0]["word"], kConfirmed);
  EXPECT_EQ(reversed[0]["stance"], "not tested");
}

TEST(ClaimsTest, InteriorPointsRobustness) {
  const auto made = [](std::int64_t lemke_worst, std::int64_t other_worst) {
    MadeSummary summary;
    summary.grid("paper/monotone/exp5-1e8", "lemke", {.criterion = lemke_worst, .solved = lemke_worst}, {});
    summary.grid("paper/monotone/exp5-1e8", "primal_dual", {.criterion = other_worst, .solved = other_worst}, {});
    return summary;
  };
  EXPECT_EQ(word(made(1000, 1995), "ip-robust"), kConfirmed);
  EXPECT_EQ(word(made(1990, 1000), "ip-robust"), kContradicted);
}

/// The worst of many equal parameterisations lies low by chance on the trials it is chosen on, not on the others.
TEST(ClaimsTest, RangesAreHeldOut) {
  MadeSummary made;
  made.flat("paper/monotone/exp5-1e8", "primal_dual", 0.9);
  made.grid("paper/monotone/exp5-1e8", "lemke", {.criterion = 1800, .solved = 1800},
            {.criterion = 1800, .solved = 1800});
  Cell& unlucky = made.summary.cells.back();
  unlucky.halves[0].criterion = unlucky.halves[0].solved = 700;
  unlucky.criterion = 1600;
  unlucky.counts[static_cast<std::size_t>(Claim::kSolved)][static_cast<std::size_t>(Verdict::kSolved)] = 1600;
  EXPECT_EQ(word(made, "ip-robust"), kUndecided);
}

TEST(ClaimsTest, InteriorPointIsNotRecommended) {
  const auto made = [](double lemke, double other, double other_time) {
    MadeSummary summary;
    summary.flat("paper/monotone/exp1", "lemke", lemke);
    summary.flat("paper/monotone/exp1", "primal_dual", other, "paper", other_time);
    return summary;
  };
  EXPECT_EQ(word(made(1, 0.7, 1e-1), "ip-not-recommended"), kConfirmed);
  EXPECT_EQ(word(made(0.7, 1, 1e-4), "ip-not-recommended"), kContradicted);
  EXPECT_EQ(word(made(1, 0.7, 1e-4), "ip-not-recommended"), kInPart);
}

TEST(ClaimsTest, Ceilings) {
  const auto made = [](double small, double large) {
    MadeSummary summary;
    summary.flat("paper/copositive/exp5-1e10", "lemke", small);
    summary.flat("paper/copositive/extra100", "lemke", large);
    return summary;
  };
  EXPECT_EQ(word(made(0.99, 0.95), "ceilings"), kConfirmed);
  EXPECT_EQ(word(made(0.99, 0.70), "ceilings"), kContradicted);
}

TEST(ClaimsTest, SplittingMethods) {
  const auto made = [](const char* solver, const std::vector<bool>& pattern) {
    MadeSummary summary;
    summary.flat("paper/monotone/exp1", "lemke", 1);
    summary.single("paper/copositive/exp1", solver, "", pattern);
    return summary;
  };
  EXPECT_EQ(word(made("psor", {true, false, false, false}), "splitting"), kConfirmed);
  EXPECT_EQ(word(made("bullet_pgs", {true, true, true, false}), "splitting"), kContradicted);
  EXPECT_EQ(word(made("bullet_dantzig", {true}), "splitting"), kNotTested);
}

/// Every comparison is on file with its interval, and a claim without data says what it needs.
TEST(ClaimsTest, RecordsHoldTheEvidence) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 0.95);
  made.flat("paper/copositive/exp1", "lemke", 0.90);
  const Json records = rows_of(made.summary, "claims-paper");
  ASSERT_EQ(records[0]["claim"], "monotone-easier");
  EXPECT_NEAR(records[0]["value"].get<double>(), 0.05, 1e-12);
  EXPECT_LT(records[0]["low"].get<double>(), 0.05);
  EXPECT_EQ(records[0]["stance"], "supports");
  EXPECT_NE(rows_of_claim(made, "splitting")[0]["quantity"].get<std::string>().find("psor"), std::string::npos);
}

}  // namespace
}  // namespace lcpbench::paper_claims_test
