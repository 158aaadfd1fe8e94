// The search for the smallest problem that still fails: the search itself, and the command as users run it.
#include "study/shrink/shrink.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/problem_io.h"
#include "core/selection.h"
#include "generators/sets.h"
#include "study/shrink/ddmin.h"
#include "study/shrink/numbers.h"
#include "study/shrink/pieces.h"
#include "tests/support/program_test.h"

namespace lcpbench::shrink_test {
namespace {

using nlohmann::json;

bool has(const std::vector<Index>& list, Index value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

TEST(MinimalSubset, KeepsExactlyTheUnitsThatFailTogether) {
  int calls = 0;
  const auto fails = [&calls](const std::vector<Index>& kept) {
    ++calls;
    return has(kept, 3) && has(kept, 40) && has(kept, 41);
  };
  EXPECT_EQ(minimal_subset(all_indices(64), fails), (std::vector<Index>{3, 40, 41}));
  EXPECT_LT(calls, 100);  // of 2^64 subsets
  EXPECT_EQ(minimal_subset(all_indices(7), [](const auto&) { return true; }), std::vector<Index>());
  EXPECT_EQ(minimal_subset(all_indices(7), [](const auto& kept) { return kept.size() == 7; }), all_indices(7));
}

Problem read_again(const Problem& problem) { return parse_problem_json(problem_json(problem), "again"); }

/// Fails while some contact has friction and pushes on a coordinate that moves.
bool pushes(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  const Matrix N = to_dense(contact.N);
  for (const Index i : frictional_contacts(problem)) {
    if (!N.col(i).isZero(0) && !contact.v.isZero(0)) return true;
  }
  return false;
}

TEST(Shrink, ABodyThatStaysIsPushedAsBeforeThoughTheOtherBelongsToTheWorld) {
  RigidScene scene;
  scene.bodies.resize(2);
  for (RigidBody& body : scene.bodies) body.mass = 1;
  scene.bodies[1].position = {0, 0.6, 0.8};
  RigidContact contact;
  contact.body_a = 0;
  contact.body_b = 1;
  contact.point = {0, 0.3, 0.4};
  contact.normal = {0, -0.6, -0.8};
  contact.tangent = {1, 0, 0};
  scene.contacts = {contact};
  const Problem both("both", std::move(scene));
  for (const Index kept : {0, 1}) {
    EXPECT_EQ(to_dense(with_bodies(both, {kept}).contact()->N), to_dense(both.contact()->N).middleRows(6 * kept, 6));
  }
}

Problem problem_of_set(const std::string& set) { return read_again(open_set(set)->generate(1, 3)); }

TEST(Shrink, FindsOneContactAndRoundNumbersInEveryKindOfInertia) {
  const Problem dense = problem_of_set("paper/copositive/exp1");
  ContactProblem factored = *dense.contact();
  factored.inertia = FactoredInertia{Matrix::Identity(factored.ngc(), factored.ngc()) * 1.37, factored.v.cwiseAbs()};
  ContactProblem inverse = *dense.contact();
  inverse.inertia = InverseInertia{dense_inertia(dense.contact()->inertia)};
  const std::vector<std::pair<const char*, Problem>> kinds{
      {"dense", dense},
      {"factors", read_again({"factors", factored})},
      {"inverse", read_again({"inverse", inverse})},
      {"scene", problem_of_set("scene/wedge/ode")},
      {"blocks", problem_of_set("scene/quadruped-standing/mujoco")}};
  for (const auto& [kind, problem] : kinds) {
    ASSERT_TRUE(pushes(problem)) << kind;
    const Shrunk shrunk = shrink(problem, pushes, {});
    EXPECT_TRUE(shrunk.complete) << kind;
    EXPECT_TRUE(pushes(shrunk.problem)) << kind;
    const ProblemSize size = problem_size(shrunk.problem);
    EXPECT_EQ(size.contacts, 1) << kind;
    EXPECT_EQ(size.friction_edges, problem.kind() == ProblemKind::kScene ? 4 : 2) << kind;
    EXPECT_LE(size.bodies, 1) << kind;
    EXPECT_LE(size.digits, 8) << kind << problem_json(shrunk.problem);
    EXPECT_EQ(problem_hash(read_again(shrunk.problem)), problem_hash(shrunk.problem)) << kind;
    EXPECT_EQ(problem_json(shrink(problem, pushes, {}).problem), problem_json(shrunk.problem)) << kind;
  }
}

/// What `inspect` doubts is no smaller case: a contact that pushes nothing, or friction that does nothing.
TEST(Shrink, NoContactLosesItsNormalOrItsFriction) {
  const auto has_contact = [](const Problem& problem) { return problem.contact()->nc() >= 1; };
  const auto has_friction = [](const Problem& problem) { return problem.contact()->frictional(); };
  for (const auto& fails : {std::function<bool(const Problem&)>(has_contact), std::function(has_friction)}) {
    const Problem problem = shrink(problem_of_set("paper/copositive/exp1"), fails, {}).problem;
    const Matrix N = to_dense(problem.contact()->N), D = to_dense(problem.contact()->D);
    EXPECT_GT(N.colwise().lpNorm<1>().minCoeff(), 0) << problem_json(problem);
    EXPECT_TRUE(D.cols() == 0 || D.colwise().lpNorm<1>().minCoeff() > 0) << problem_json(problem);
  }
}

TEST(Shrink, FindsTheRowsOfABareLcp) {
  Lcp lcp{Matrix::Identity(30, 30) * 1.25, Vector::LinSpaced(30, 0.1, 0.9)};
  lcp.q(7) = lcp.q(21) = -1.0 / 3;
  const auto fails = [](const Problem& problem) { return (problem.lcp().q.array() < 0).count() >= 2; };
  const Shrunk shrunk = shrink(read_again({"rows", lcp}), fails, {});
  EXPECT_EQ(shrunk.problem.size(), 2);
  EXPECT_EQ(shrunk.problem.lcp().q, Vector::Constant(2, -1));
  EXPECT_EQ(shrunk.problem.lcp().M, Matrix::Zero(2, 2));
}

/// A solver that fails, as its argument says, on problems with two entries of q below -2.5; it solves others whose M is
/// diagonal, and takes the last of two solutions of a pair of rows.
constexpr const char* kFailing = R"(import json, os, sys, time
def solution(M, q):
    z = [max(0.0, -q[i] / M[i][i]) if M[i][i] else 0.0 for i in range(len(q))]
    for i in range(len(q)):
        if any(M[i][j] for j in range(i + 1, len(q))):
            z[i] = 0.0
    return z
problem = {}
for line in sys.stdin:
    request = json.loads(line)
    problem = request.get("problem", problem)
    reply = {"sequence": request["sequence"]}
    if request["verb"] == "solve":
        reply.update(claim="solved", z=solution(problem["M"], problem["q"]))
        if sum(q < -2.5 for q in problem["q"]) >= 2:
            if sys.argv[1] == "lies": reply["z"] = [0.0] * len(problem["q"])
            if sys.argv[1] == "denies": reply = {"sequence": request["sequence"], "claim": "unsolvable"}
            if sys.argv[1] == "gives-up": reply = {"sequence": request["sequence"], "claim": "numerical_failure"}
            if sys.argv[1] == "crashes": os._exit(3)
            if sys.argv[1] == "hangs":
                print("hangs", file=open("hangs.txt", "a"), flush=True)
                time.sleep(1000)
    print(json.dumps(reply), flush=True)
)";

class ShrinkCommand : public ProgramTest {
 protected:
  ShrinkCommand() {
    write("failing.py", kFailing);
    Lcp lcp{Matrix::Identity(9, 9) * 1.1, Vector::LinSpaced(9, -0.9, 0.7)};
    lcp.q(2) = -3.14159;
    lcp.q(7) = -5.25;
    write_problem({"diagonal", lcp}, folder_ / "diagonal.json");
    lcp.q.setConstant(-1.01);
    lcp.M(4, 5) = lcp.M(5, 4) = 2.17;
    write_problem({"pair", lcp}, folder_ / "pair.json");
  }
  static std::string program(const std::string& way) { return "'external{command=python3 failing.py " + way + "}'"; }

  /// Shrinks, and solves the result by the command that replays it: what `solve` says of the first solver.
  void expect_two_rows(const std::string& arguments, const std::string& until, const std::string& verdict) {
    const json outcome = run_json("shrink " + arguments + " --out small.json");
    EXPECT_EQ(outcome["until"], until);
    EXPECT_EQ(outcome["before"]["contacts"], 9);
    EXPECT_EQ(outcome["after"]["contacts"], 2) << outcome.dump();
    EXPECT_LE(outcome["after"]["digits"], 5) << outcome.dump();
    EXPECT_EQ(outcome["certificate"], "solution");
    const auto replay = outcome["replay"].get<std::string>();
    ASSERT_EQ(replay.rfind("lcpbench solve small.json --solver ", 0), 0U) << replay;
    EXPECT_EQ(replay.ends_with(" --solver auto"), until != "differs" || outcome["against"] == "auto") << replay;
    const ProgramRun solved = run(replay.substr(std::string("lcpbench ").size()) + " --format json");
    const json attempts = json::parse(solved.out);
    const auto failing = std::find_if(attempts.begin(), attempts.end(),
                                      [](const json& attempt) { return attempt["solver"] == "external"; });
    ASSERT_NE(failing, attempts.end());
    EXPECT_EQ(solved.exit_code, (*failing)["claim"] == "crashed" ? 1 : 0) << replay << ": " << solved.err;
    EXPECT_EQ((*failing)["verdict"], verdict);
  }
};

TEST_F(ShrinkCommand, FindsTheSmallestFalseClaim) {
  expect_two_rows("diagonal.json --solver " + program("lies") + " --until wrong", "wrong", "wrong");
  expect_two_rows("diagonal.json --solver " + program("denies"), "wrong", "missed");
}

TEST_F(ShrinkCommand, FindsTheSmallestProblemMissed) {
  expect_two_rows("diagonal.json --solver " + program("gives-up"), "missed", "missed");
  expect_two_rows("diagonal.json --solver " + program("denies") + " --until missed", "missed", "missed");
  expect_two_rows("diagonal.json --solver " + program("crashes") + " --until missed", "missed", "missed");
}

TEST_F(ShrinkCommand, FindsTheSmallestProblemWithTwoMotions) {
  expect_two_rows("pair.json --until differs --solver " + program("solves"), "differs", "solved");
  expect_two_rows("pair.json --until differs --against auto --solver " + program("solves"), "differs", "solved");
}

TEST_F(ShrinkCommand, ASolverToCompareWithIsNeverIgnored) {
  expect_two_rows("pair.json --against auto --solver " + program("solves"), "differs", "solved");
  const ProgramRun lies = run("shrink diagonal.json --against auto --out other.json --solver " + program("lies"));
  EXPECT_EQ(lies.exit_code, 1) << lies.out << lies.err;  // it is wrong, and does not solve what auto solves
  EXPECT_NE(lies.err.find("nothing to shrink until differs: "), std::string::npos) << lies.err;
}

TEST_F(ShrinkCommand, ShrinksACapturedSceneToAThird) {
  done("generate scene/wedge/ode --seed 1 --first 3 --count 1 --out steps");
  const json outcome =
      run_json("shrink steps/000003.json --solver 'psor{max_iterations=3}' --until missed --out small.json");
  EXPECT_LE(3 * outcome["after"]["contacts"].get<int>(), outcome["before"]["contacts"].get<int>());
  EXPECT_EQ(outcome["problem"]["kind"], "scene");
  EXPECT_EQ(run_json("solve small.json --solver 'psor{max_iterations=3}'")[0]["verdict"], "missed");
}

TEST_F(ShrinkCommand, WritesNothingWhereTheSolverDoesNotFail) {
  const ProgramRun output = run("shrink pair.json --solver auto --until missed --out small.json");
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_EQ(output.out, "");
  EXPECT_NE(output.err.find("pair.json: nothing to shrink"), std::string::npos) << output.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "small.json"));
}

// A hang counts as missed. The first is on the whole problem. When the third begins, the second has left a smaller one.
TEST_F(ShrinkCommand, AnInterruptKeepsTheSmallestUntilThen) {
  const std::string hangs = folder_ / "hangs.txt";
  write("hangs.txt", "");
  const ProgramRun output = run("shrink diagonal.json --time-limit 0.5 --solver " + program("hangs") +
                                " --out small.json & for i in $(seq 600); do"
                                " test $(wc -l < " +
                                hangs + ") -ge 3 && break; sleep 0.1; done; kill -TERM $!; wait $!");
  EXPECT_EQ(output.exit_code, 3) << output.err;
  EXPECT_LT(read_problem(folder_ / "small.json").size(), 9);
  EXPECT_GE(read_problem(folder_ / "small.json").size(), 2);
  EXPECT_NE(output.out.find("repeat: lcpbench solve small.json"), std::string::npos) << output.out;
}

}  // namespace
}  // namespace lcpbench::shrink_test
