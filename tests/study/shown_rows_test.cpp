// What people see of bounded rows: each command on problem files that have them, and what the numbers mean.

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/problem_io.h"
#include "core/selection.h"
#include "study/shrink/pieces.h"
#include "tests/support/program_test.h"

namespace lcpbench::shown_rows_test {
namespace {

using nlohmann::json;

// Two jaws of 1 kg press 0.5 kg between them, with motors of up to 0.2 N s that aim at 5 m/s.
constexpr const char* kGripper = R"("kind": "contact", "v": [0, 0, 0, -0.1],
  "G": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.5, 0], [0, 0, 0, 0.5]], "N": [[-1, 0], [0, 1], [1, -1], [0, 0]],
  "D": [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [1, -1, 1, -1]], "edges": [2, 2], "mu": [0.5, 0.5],
  "rows": {"R": [[1, 0], [0, -1], [0, 0], [0, 0]], "lower": [-0.2, -0.2], "upper": [0.2, 0.2], "b": [-5, -5],
           "names": ["left motor", "right motor"]})";

// An arm of 2 kg m^2 turns at -1 rad/s towards its stop; its bearing has dry friction.
constexpr const char* kArm = R"("kind": "contact", "v": [-1], "N": [[]], "G": [[2]],
  "rows": {"R": [[1, 1]], "lower": [0, -0.5], "upper": [null, 0.5], "b": [0.2, 0], "unit": ["rad", "rad"],
           "names": ["stop", "dry friction"]})";

// The same equality twice, with offsets that contradict each other.
constexpr const char* kContradiction = R"("kind": "contact", "v": [1, 0], "N": [[0], [1]], "G": [[1, 0], [0, 1]],
  "rows": {"R": [[1, 1], [0, 0]], "lower": [null, null], "upper": [null, null], "b": [0, 1]})";

class ShownRowsTest : public ProgramTest {
 protected:
  void SetUp() override {
    write_problem_of("gripper.json", kGripper);
    write_problem_of("arm.json", kArm);
    write_problem_of("none.json", kContradiction);
  }
  /// Whether a text has all of these words, folded into lines or not.
  static void expect_words(std::string text, const std::vector<std::string>& words) {
    for (std::size_t at; (at = text.find("\n  ")) != std::string::npos;) {
      text.replace(at, text.find_first_not_of(" \n", at) - at, " ");
    }
    for (const std::string& each : words) EXPECT_NE(text.find(each), std::string::npos) << each << " in\n" << text;
  }
};

TEST_F(ShownRowsTest, SolvePrintsATableOfRowsInTheirUnits) {
  const std::string text = done("solve arm.json --solver auto");
  expect_words(text, {"2 bounded rows", "0 stop", "0 to any", "1.1 N m s", "1 dry friction", "-0.5 to 0.5", "-0.2 rad/s",
                      "at its upper bound"});
}

TEST_F(ShownRowsTest, SolveJsonHasEveryRow) {
  const json answer = run_json("solve arm.json --solver auto")[0];
  EXPECT_EQ(answer["verdict"], "solved") << answer;
  EXPECT_EQ(answer["problem"]["rows"], 2);
  ASSERT_EQ(answer["rows"].size(), 2U);
  const json& stop = answer["rows"][0];
  EXPECT_EQ(stop["name"], "stop");
  EXPECT_EQ(stop["unit"], "rad");
  EXPECT_EQ(stop["lower"], 0);
  EXPECT_TRUE(stop["upper"].is_null());
  EXPECT_NEAR(stop["impulse"].get<double>(), 1.1, 1e-12);
  EXPECT_EQ(stop["state"], "between");  // it presses, and w is zero
  EXPECT_NEAR(answer["rows"][1]["impulse"].get<double>(), 0.5, 1e-12);
  EXPECT_EQ(answer["rows"][1]["state"], "at its upper bound");
  EXPECT_NEAR(answer["rows"][1]["velocity"].get<double>(), -0.2, 1e-12);
}

TEST_F(ShownRowsTest, TheWorstResidualsOfContactsAndRowsAreApart) {
  const json answer = run_json("solve gripper.json --solver 'psor{max_iterations=2}'")[0];
  const json& errors = answer["errors"];
  ASSERT_TRUE(errors["worst_bounded_row"].is_object()) << errors;
  EXPECT_EQ(errors["worst_bounded_row"]["unit"], "m/s");
  const double contacts = errors["contact_residual_m_per_s"];
  const double rows = errors["worst_bounded_row"]["residual"];
  EXPECT_EQ(errors["velocity_residual_m_per_s"], std::max(contacts, rows)) << errors;
  expect_words(done("solve gripper.json --wide --solver auto"), {"contacts' m/s", "rows'"});
}

TEST_F(ShownRowsTest, TheWorstRowIsNamedWithItsUnit) {
  write_problem_of("brake.json", R"("kind": "contact", "v": [1, 0], "N": [[], []], "G": [[1, 0], [0, 1]],
    "rows": {"R": [[1, 1], [1, 0]], "lower": [null, -0.1], "upper": [null, 0.1], "unit": ["m", "rad"],
             "names": ["pin", "brake"]})");
  const std::string text = done("solve brake.json --solver 'psor{max_iterations=2}'");
  expect_words(text, {"bounded row 1 (brake) moves at w = 0.455 rad/s", "N m s is above its lower bound of -0.1",
                      "rad/s counts as 0.0127 m/s"});
}

TEST_F(ShownRowsTest, CertifyProvesContradictingEqualities) {
  const json rows = run_json("certify none.json arm.json gripper.json");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0]["certificate"], "unsolvable");
  EXPECT_EQ(rows[0]["farkas"], json::parse("[0, 1, -1]"));
  EXPECT_EQ(rows[1]["certificate"], "solution");
  EXPECT_EQ(rows[1]["velocity_unique"], true);
  EXPECT_EQ(rows[2]["certificate"], "solution");
  expect_words(done("certify none.json"), {"a contact or bounded row is violated by 0.5 m/s or rad/s"});
}

TEST_F(ShownRowsTest, InspectCountsKindsAndWarnsOfRedundantEqualities) {
  const json none = run_json("inspect none.json")[0];
  EXPECT_EQ(none["contact"]["bounded_rows"]["equalities"], 2);
  const auto has = [&](const json& problem, const char* code) {
    return std::ranges::any_of(problem["warnings"], [&](const json& warning) { return warning["code"] == code; });
  };
  EXPECT_TRUE(has(none, "redundant_equalities")) << none["warnings"];
  const json arm = run_json("inspect arm.json")[0];
  EXPECT_FALSE(has(arm, "redundant_equalities"));
  EXPECT_FALSE(has(arm, "trivial"));  // no contact approaches, and yet there are impulses
  EXPECT_EQ(arm["contact"]["bounded_rows"]["angles"], 2);
}

TEST_F(ShownRowsTest, ShrinkLeavesOutRowsThatDoNotMatter) {
  write_problem_of("more.json", R"("kind": "contact", "v": [1, 0.5, 0.2], "N": [[0], [0], [1]],
    "G": [[1, 0, 0], [0, 1, 0], [0, 0, 0.1]], "rows": {"R": [[1, 0, 0], [0, 1, 0], [1, 0, 1]],
    "lower": [null, null, -2], "upper": [null, null, 2], "names": ["pin x", "pin y", "brake"]})");
  const json found = run_json("shrink more.json --solver 'psor{max_iterations=2}' --until missed --out small.json");
  EXPECT_EQ(found["before"]["rows"], 3);
  EXPECT_EQ(found["after"]["rows"], 1);
  EXPECT_EQ(json::parse(read("small.json"))["rows"]["R"][0].size(), 1U);
}

TEST(ShownRows, FrictionGoesWithTheRowThatBearsIt) {
  ContactProblem contact;
  contact.v = Vector::Zero(1);
  contact.N = contact.D = Matrix(1, 0);
  contact.inertia = DenseInertia{Matrix::Identity(1, 1)};
  contact.rows.R = Matrix::Ones(1, 3);
  contact.rows.bounds = LcpBounds::nonnegative(3);
  contact.rows.bounds.friction_of = {-1, 0, -1};
  contact.rows.is_angle.assign(3, 0);
  const Problem problem("three", contact);
  EXPECT_EQ(row_count(with_rows(problem, {1, 2})), 1);
  EXPECT_EQ(row_count(with_rows(problem, {0, 1})), 2);
}

TEST_F(ShownRowsTest, ModelsRefusesRowsInOneLine) {
  expect_mistake("models gripper.json");
  expect_mistake("solve gripper.json --max-velocity-error 1e-3");
}

TEST_F(ShownRowsTest, ViewListsTheRowsOfEachAnswer) {
  const json step = run_json("view gripper.json")["scenes"][0];
  ASSERT_EQ(step["rows"].size(), 2U);
  EXPECT_EQ(step["rows"][0]["name"], "row 0 (left motor)");
  ASSERT_EQ(step["answers"][0]["rows"].size(), 2U) << step["answers"];
  EXPECT_EQ(step["answers"][0]["rows"][0]["state"], "at its upper bound");
}

TEST_F(ShownRowsTest, AStudyOfProblemFilesWithRowsIsKeptAndAsked) {
  done("generate file:gripper.json --seed 1 --count 1 --out folder");
  write("folder/1.json", read("arm.json"));
  write("folder/2.json", read("none.json"));
  done("run --set file:folder --solver auto --solver lemke --shard 1/2 --store a.db");
  done("run --set file:folder --solver auto --solver lemke --shard 2/2 --store b.db");
  done("merge s.db a.db b.db");
  write("solved.sql", "SELECT COUNT(*) AS n FROM judged WHERE verdict = 'solved'");
  EXPECT_EQ(run_json("query s.db solved.sql")[0]["n"], 4);
  const json certified = run_json("certify --store s.db --every 1");
  EXPECT_EQ(certified["ok"], true) << certified;
  EXPECT_EQ(certified["sets"][0]["solution"], 2);
  EXPECT_EQ(certified["sets"][0]["unsolvable"], 1);
  done("report s.db --out page");
}

}  // namespace
}  // namespace lcpbench::shown_rows_test
