// The plan `hard` as a user runs it, with the solver that a user calls: no false claim anywhere, every solvable contact
// case solved. Only its time limit is longer, for slow machines.

#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "generators/hard/hard.h"
#include "study/store/store.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::hard_study_test {
namespace {

class HardStudyTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;
    const std::string limit = "\"time_limit_s\": 1,";
    std::string plan = read_file(HARD_PLAN);
    ASSERT_NE(plan.find(limit), std::string::npos);
    std::ofstream(*folder_ / "hard.json") << plan.replace(plan.find(limit), limit.size(), "\"time_limit_s\": 30,");
    ASSERT_EQ(run("run hard.json --solver auto --solver lemke --store hard.db"), 0);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static int run(const std::string& arguments) { return run_program(*folder_ / "", arguments).exit_code; }

  /// "set: claim, verdict" of each answer of a solver that `wanted` picks.
  template <class Wanted>
  static std::vector<std::string> answers(const std::string& solver, Wanted wanted) {
    Store store = Store::open_for_reading(*folder_ / "hard.db");
    std::map<std::int64_t, std::string> sets;
    for (const auto& [id, name] : store.sets()) sets[id] = name;
    std::map<std::int64_t, std::string> solvers;
    for (const StoredSolver& stored : store.solvers()) solvers[stored.id] = stored.row.text();
    std::vector<std::string> found;
    store.for_each_answer([&](const StoredAnswer& answer) {
      if (solvers[answer.solver_id] != solver || !wanted(sets[answer.set_id], answer)) return;
      found.push_back(sets[answer.set_id] + ": " + to_string(answer.claim) + ", " + to_string(answer.verdict));
    });
    return found;
  }

  static ScratchFolder* folder_;
};

ScratchFolder* HardStudyTest::folder_ = nullptr;

TEST_F(HardStudyTest, AutoMakesNoFalseClaim) {
  const auto falsely = [](const std::string& set, const StoredAnswer& answer) {
    const bool unsolvable = hard_case(set)->truth.known == HardKnown::kUnsolvable;
    if (answer.claim == Claim::kSolved) return unsolvable || answer.verdict != Verdict::kSolved;
    return answer.claim == Claim::kUnsolvable && !unsolvable;
  };
  EXPECT_EQ(answers("auto", falsely), std::vector<std::string>());
}

// But for a rod whose inertia has the condition 2^100, of which 113 bits leave 13.
TEST_F(HardStudyTest, AutoSolvesEverySolvableContactCase) {
  const auto missed = [](const std::string& set, const StoredAnswer& answer) {
    const std::optional<HardCase> problem = hard_case(set);
    const bool solvable = problem->contact && problem->truth.known == HardKnown::kSolvable;
    return solvable && (answer.claim != Claim::kSolved || answer.verdict != Verdict::kSolved);
  };
  EXPECT_EQ(answers("auto", missed),
            std::vector<std::string>{"hard/contact/thin-rod{bits=100}: iteration_limit, missed"});
}

}  // namespace
}  // namespace lcpbench::hard_study_test
