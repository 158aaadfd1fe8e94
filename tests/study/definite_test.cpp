// What a user relies on: on easy problems every solver is right, ours and foreign, and every exception is one that
// docs/reference/solvers/adapters.md names and explains.

#include <map>
#include <string>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "study/run/open_solver.h"
#include "study/run/runner.h"
#include "tests/support/study_support.h"

namespace lcpbench::definite_test {
namespace {

constexpr std::int64_t kProblems = 50;

/// Solvers that stop where their iterations are spent, whatever the answer, that guess, or whose tolerance knows the
/// largest |q| alone, where an answer is measured by the fastest approach:
/// docs/reference/solvers/adapters.md, "Easy problems".
const std::map<std::string, std::string> kCapped{
    {"bullet_pgs", "ten sweeps"},  {"bullet_si", "ten sweeps"},   {"bullet_nncg", "ten sweeps"},
    {"dart_pgs", "thirty sweeps"}, {"simbody_pgs", "100 sweeps"}, {"simbody_plus", "one order of guesses"},
    {"ipopt_mpcc", "tolerance"},   {"ipopt_qp", "tolerance"}};

struct Shares {
  int solved = 0;
  int refused = 0;
  int others = 0;
};

/// Every solver that runs unasked, on the same problems.
std::map<std::string, Shares> run_all(const std::string& set) {
  Plan plan;
  plan.name = "definite";
  plan.trials = kProblems;
  plan.seed = 11;
  plan.repeat_until_s = 0;
  plan.time_limit_s = 600;
  plan.sets = {{.pattern = set}};
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (runs_unasked(solver)) plan.solvers.push_back({.spec = Spec{solver.definition.name, {}}});
  }
  const ScratchFolder folder;
  const Study study = resolve(plan);
  Store store = Store::open_for_writing(folder / "s.db");
  run_study(study, store, {.jobs = 2});
  std::map<std::int64_t, std::string> names;
  for (const StoredSolver& solver : store.solvers()) names[solver.id] = solver.row.name;
  std::map<std::string, Shares> shares;
  store.for_each_answer([&](const StoredAnswer& answer) {
    Shares& share = shares[names.at(answer.solver_id)];
    ++(answer.verdict == Verdict::kSolved    ? share.solved
       : answer.claim == Claim::kUnsupported ? share.refused
                                             : share.others);
  });
  return shares;
}

TEST(DefiniteTest, EverySolverIsRightOnEasyProblems) {
  const std::map<std::string, Shares> shares = run_all("planted/definite");
  ASSERT_GE(shares.size(), 5U);
  for (const auto& [solver, share] : shares) {
    EXPECT_EQ(share.solved + share.refused + share.others, kProblems) << solver;
    if (kCapped.count(solver) == 0) {
      EXPECT_EQ(share.others, 0) << solver;
    }
    const Capabilities& capabilities = find_solver(solver).definition.capabilities;
    if (capabilities.needs != Needs::kScene && capabilities.max_size >= 20 && solver != "velocity_ipm_cholmod") {
      EXPECT_EQ(share.refused, 0) << solver;
    }
  }
}

// Those that take no matrices, on scenes as small: bodies of their own, fewer contacts than coordinates.
TEST(DefiniteTest, EnginesAreRightOnEasyScenes) {
  const std::map<std::string, Shares> shares = run_all("rigid/exp1{nc_max=2}");
  ASSERT_GE(shares.size(), 5U);
  for (const auto& [solver, share] : shares) {
    if (kCapped.count(solver) > 0) continue;
    EXPECT_EQ(share.refused, 0) << solver;
    EXPECT_EQ(share.others, 0) << solver;
  }
}

}  // namespace
}  // namespace lcpbench::definite_test
