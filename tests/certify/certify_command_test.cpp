// What `lcpbench certify` prints and how it ends is what the contract says.

#include <cstdint>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "study/statistics/statistics.h"
#include "tests/support/program_test.h"
#include "tests/support/solvability.h"

namespace lcpbench::certify_command_test {
namespace {

using nlohmann::json;

class CertifyCommandTest : public ProgramTest {};

TEST_F(CertifyCommandTest, ANastyProblemDoesNotEndTheBatch) {
  write_problem_of("huge.json", R"("kind": "lcp", "M": [[1, 1e20], [1, 0]], "q": [0, -1])");
  write_problem_of("one.json", kOneRow);
  const json rows = run_json("certify huge.json one.json");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0]["certificate"], "unsolvable");
  EXPECT_EQ(rows[1]["certificate"], "solution");
}

// No solver has a proof for it, and none claims that there is no solution.
TEST_F(CertifyCommandTest, SolveSettlesWhatNoSolverSolves) {
  write_problem_of("feasible.json", R"("kind": "lcp", "M": [[2, 0], [1, 0]], "q": [-2, -2])");
  const json rows = run_json("solve feasible.json --solver lemke --solver auto");
  ASSERT_EQ(rows.size(), 2U);
  for (const json& row : rows) EXPECT_EQ(row["truth"], "unsolvable") << row;
}

TEST_F(CertifyCommandTest, ContradictionInAStoreExitsWith1) {
  done("run --set paper/monotone/exp1 --solver lemke --trials 3 --store s.db");
  const json fine = run_json("certify --store s.db");
  EXPECT_EQ(fine["ok"], true);
  EXPECT_EQ(fine["sets"][0]["solution"], 3);
  change_rows(folder_ / "s.db", "UPDATE certificates SET certificate = 'unsolvable', proof = 'farkas'");
  const ProgramRun output = run("certify --store s.db --format json");
  EXPECT_EQ(output.exit_code, 1) << output.err;
  EXPECT_FALSE(json::parse(output.out)["contradictions"].empty());
}

/// Experiment 3's share of solvable problems has a closed form: the certificates have to meet it and settle each trial.
TEST_F(CertifyCommandTest, SolvableShareOfExperiment3IsTheClosedForm) {
  constexpr int kTrials = 400;
  done("run --set paper/monotone/exp3 --solver primal_dual --trials 400 --store s.db");
  const json set = run_json("certify --store s.db")["sets"].at(0);
  EXPECT_EQ(set["open"], 0);
  const std::int64_t solvable = set["solution"];
  EXPECT_EQ(solvable + set["unsolvable"].get<std::int64_t>(), kTrials);
  const Interval share = wilson(solvable, kTrials, kNormal9995);
  EXPECT_LT(share.low, paper::solvable_share_of_exp3());
  EXPECT_GT(share.high, paper::solvable_share_of_exp3());
  EXPECT_EQ(set["solution_low_999"], share.low);
}

}  // namespace
}  // namespace lcpbench::certify_command_test
