// What `lcpbench certify` prints and how it ends is what the contract says.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/problem_io.h"
#include "generators/sets.h"
#include "tests/support/solvability.h"
#include "study/statistics/statistics.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::certify_command_test {
namespace {

using nlohmann::ordered_json;

constexpr const char* kMonotone = "paper/monotone/exp1";

class CertifyCommandTest : public ::testing::Test {
 protected:
  ProgramRun run(const std::string& arguments) { return run_program(folder_ / "", arguments); }
  void generate(const std::string& set, int trial, const std::string& name) {
    write_problem(open_set(set)->generate(1, trial), folder_ / name);
  }
  ScratchFolder folder_;
};

std::vector<std::string> keys(const ordered_json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

TEST_F(CertifyCommandTest, JsonHasTheFieldsOfTheContract) {
  generate(kMonotone, 0, "a.json");
  generate("planted/definite{form=lcp}", 0, "b.json");
  const ProgramRun output = run("certify a.json b.json --format json");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const auto rows = ordered_json::parse(output.out);
  ASSERT_EQ(rows.size(), 2U);
  for (const ordered_json& row : rows) {
    EXPECT_EQ(keys(row), (std::vector<std::string>{"problem", "certificate", "proof", "z", "velocity",
                                                   "velocity_unique", "farkas", "seconds"}));
    EXPECT_EQ(keys(row["problem"]), (std::vector<std::string>{"name", "kind", "n", "ngc", "nc", "edges"}));
    EXPECT_EQ(row["certificate"], "solution");
    EXPECT_EQ(row["proof"], "exact_basis");
    EXPECT_EQ(row["z"].size(), row["problem"]["n"]);
    EXPECT_TRUE(row["farkas"].is_null());
    EXPECT_TRUE(row["seconds"].is_number());
  }
  EXPECT_EQ(rows[0]["velocity"].size(), rows[0]["problem"]["ngc"]);
  EXPECT_EQ(rows[0]["velocity_unique"], true);
  EXPECT_TRUE(rows[1]["velocity"].is_null());
  EXPECT_TRUE(rows[1]["velocity_unique"].is_null());
}

TEST_F(CertifyCommandTest, ExactRationalsStandBesideTheDoublesWhereAsked) {
  generate(kMonotone, 0, "a.json");
  const ProgramRun output = run("certify a.json --exact --format json");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const auto row = ordered_json::parse(output.out).at(0);
  EXPECT_EQ(keys(row).size(), 11U);
  EXPECT_EQ(row["z_exact"].size(), row["z"].size());
  EXPECT_EQ(row["velocity_exact"].size(), row["velocity"].size());
  EXPECT_TRUE(row["farkas_exact"].is_null());
  for (const ordered_json& entry : row["velocity_exact"]) EXPECT_TRUE(entry.is_string());
}

TEST_F(CertifyCommandTest, AFileThatCannotBeReadDoesNotStopTheOthers) {
  generate(kMonotone, 0, "a.json");
  const ProgramRun output = run("certify nosuch.json a.json --format json");
  EXPECT_EQ(output.exit_code, 2);
  EXPECT_EQ(ordered_json::parse(output.out).size(), 1U);
  EXPECT_EQ(output.err.rfind("lcpbench: nosuch.json", 0), 0U) << output.err;
  EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
}

TEST_F(CertifyCommandTest, ANastyProblemDoesNotEndTheBatch) {
  write_problem(Problem("huge", Lcp{Matrix{{1, 1e20}, {1, 0}}, Vector{{0, -1}}}), folder_ / "huge.json");
  generate(kMonotone, 0, "a.json");
  const ProgramRun output = run("certify huge.json a.json --format json");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const auto rows = ordered_json::parse(output.out);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0]["certificate"], "open");
  EXPECT_EQ(rows[1]["certificate"], "solution");
}

TEST_F(CertifyCommandTest, MistakesOfUseExitWith2AndOneLine) {
  generate(kMonotone, 0, "a.json");
  for (const char* name : {"b.M.mtx", "b.q.mtx"}) {
    std::ofstream(folder_ / name) << "%%MatrixMarket matrix array real general\n1 1\n1\n";
  }
  run("run --set paper/monotone/exp1 --solver lemke --trials 1 --store s.db");
  for (const char* arguments :
       {"certify", "certify a.json --store s.db", "certify a.json --every 3", "certify a.json --set paper/*",
        "certify --store nosuch.db", "certify --store s.db --exact", "certify --store s.db --set paper/monotone/exp2",
        "certify --store s.db --set nope", "certify --store s.db --every 0", "certify --store a.json",
        "certify a.json --time-limit 0", "certify a.json --proofs /nosuchfolder/p", "certify a.json --proofs a.json",
        "certify --store s.db --proofs ./s.db", "certify b.M.mtx --proofs b.q.mtx"}) {
    const ProgramRun output = run(arguments);
    EXPECT_EQ(output.exit_code, 2) << arguments;
    EXPECT_EQ(output.err.rfind("lcpbench: ", 0), 0U) << arguments << ": " << output.err;
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << arguments << ": " << output.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "nosuch.db"));
  EXPECT_GT(std::filesystem::file_size(folder_ / "a.json"), 0U);
  EXPECT_EQ(run("certify --store s.db").exit_code, 0);
}

TEST_F(CertifyCommandTest, ContradictionInAStoreExitsWith1) {
  ASSERT_EQ(run("run --set paper/monotone/exp1 --solver lemke --trials 3 --store s.db").exit_code, 0);
  const ProgramRun fine = run("certify --store s.db --format json");
  ASSERT_EQ(fine.exit_code, 0) << fine.err;
  EXPECT_EQ(ordered_json::parse(fine.out)["ok"], true);
  EXPECT_EQ(ordered_json::parse(fine.out)["sets"][0]["solution"], 3);
  change_rows(folder_ / "s.db", "UPDATE certificates SET certificate = 'unsolvable', proof = 'farkas'");
  const ProgramRun output = run("certify --store s.db --format json");
  EXPECT_EQ(output.exit_code, 1) << output.err;
  EXPECT_FALSE(ordered_json::parse(output.out)["contradictions"].empty());
}

/// Experiment 3's share of solvable problems has a closed form: the certificates have to meet it and settle each trial.
TEST_F(CertifyCommandTest, SolvableShareOfExperiment3IsTheClosedForm) {
  constexpr int kTrials = 400;
  ASSERT_EQ(run("run --set paper/monotone/exp3 --solver primal_dual --trials 400 --store s.db").exit_code, 0);
  const ProgramRun output = run("certify --store s.db --format json");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const auto set = ordered_json::parse(output.out)["sets"].at(0);
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
