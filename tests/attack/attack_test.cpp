// What the attack takes for the truth. That its judge is right, the attack itself compares with the evaluation.
#include <gtest/gtest.h>

#include "core/answer/lcp_error.h"
#include "core/io/problem_io.h"
#include "tests/attack/judge.h"
#include "tests/attack/problems.h"
#include "tests/attack/truth.h"

namespace lcpbench::attack::attack_test {
namespace {

struct Known {
  const char* data;
  Truth truth;
};

ExactTruth truth_of(const std::string& kind, const Known& known) {
  return exact_truth(parse_problem_json(
      R"({"format":"lcpbench-problem","version":1,"name":"x","kind":")" + kind + "\"," + known.data + "}", "test"));
}

TEST(AttackTest, KnowsTheTruthOfBareLcps) {
  for (const Known& known : {
           Known{R"("M":[[1]],"q":[-1])", Truth::kSolvable},
           Known{R"("M":[[-1]],"q":[-1])", Truth::kUnsolvable},
           Known{R"("M":[[0]],"q":[0])", Truth::kSolvable},
           Known{R"("M":[[0]],"q":[-4.9e-324])", Truth::kUnsolvable},
           // The solutions z_2 = 1, z_1 >= 0 of w = 0 have a singular complementary basis among them.
           Known{R"("M":[[0,1],[0,0]],"q":[-1,0])", Truth::kSolvable},
           // Feasible (z = (1, 1)), but both cones with z_1 > 0 and z_2 > 0 contradict complementarity.
           Known{R"("M":[[-1,2],[0,1]],"q":[-1,-0.75])", Truth::kSolvable},
           Known{R"("M":[[0,3],[0,1]],"q":[-3,-0.9999999999])", Truth::kUnsolvable},
           Known{R"("M":[[1,1e20],[1,0]],"q":[0,-1])", Truth::kUnsolvable},
           Known{R"("M":[[0,-1,2],[1,0,0],[-2,0,0]],"q":[0,-2.0000000000000004,4])", Truth::kUnsolvable},
       }) {
    const ExactTruth truth = truth_of("lcp", known);
    EXPECT_EQ(truth.truth, known.truth) << known.data;
  }
}

TEST(AttackTest, KnowsTheTruthOfMixedLcps) {
  for (const Known& known : {
           Known{R"("M":[[-1]],"q":[-1],"lower":[0],"upper":[2])", Truth::kSolvable},  // at the upper bound
           Known{R"("M":[[-1]],"q":[-1],"lower":[0],"upper":[null])", Truth::kUnsolvable},
           Known{R"("M":[[0]],"q":[-4.9e-324],"lower":[null],"upper":[null])", Truth::kUnsolvable},
           Known{R"("M":[[0]],"q":[-1],"lower":[null],"upper":[-3])", Truth::kSolvable},
           Known{R"("M":[[0]],"q":[1],"lower":[null],"upper":[-3])", Truth::kUnsolvable},
           Known{R"("M":[[0,1],[1,0]],"q":[0,-5],"lower":[2,1],"upper":[2,null])", Truth::kUnsolvable},
           Known{R"("M":[[0,1],[1,0]],"q":[0,-2],"lower":[2,1],"upper":[2,null])", Truth::kSolvable},
           // Friction of 0.5 times two, and a row that it does not move: it slides.
           Known{R"("M":[[1,0],[0,0]],"q":[-2,1.25],"lower":[0,null],"upper":[null,null],"friction_of":[null,0],)"
                 R"("mu":[null,0.5])",
                 Truth::kSolvable},
           // z_1 = -2, where w_1 would vanish, is beyond the limit; the other sign is at it.
           Known{R"("M":[[1,0],[0,-1]],"q":[-2,-2],"lower":[0,null],"upper":[2,null],"friction_of":[null,0],)"
                 R"("mu":[null,0.5])",
                 Truth::kSolvable},
           Known{R"("M":[[1,4],[0,0]],"q":[-2,1],"lower":[0,null],"upper":[null,null],"friction_of":[null,0],)"
                 R"("mu":[null,0.5])",
                 Truth::kUnsolvable},
       }) {
    EXPECT_EQ(truth_of("lcp", known).truth, known.truth) << known.data;
  }
}

TEST(AttackTest, KnowsTheTruthOfContacts) {
  for (const Known& known : {
           Known{R"("v":[-1],"N":[[1]],"G":[[1]])", Truth::kSolvable},
           // The contact acts where the inertia's factors do not reach.
           Known{R"("v":[0,-1],"N":[[0],[1]],"G_factors":{"X":[[1],[0]],"alpha":[1]})", Truth::kUnsolvable},
           Known{R"("v":[0,1],"N":[[0],[1]],"G_factors":{"X":[[1],[0]],"alpha":[1]})", Truth::kSolvable},
           // Two walls that close in, or do not.
           Known{R"("v":[0],"N":[[1,-1]],"G":[[1]],"b":[-1,0.9999999999999998])", Truth::kUnsolvable},
           Known{R"("v":[0],"N":[[1,-1]],"G":[[1]],"b":[-1,1])", Truth::kSolvable},
           // The factors are dependent, or nearly.
           Known{R"("v":[-1,1],"N":[[1],[-1]],"G_factors":{"X":[[1,1],[1,1]],"alpha":[1,1]})", Truth::kUnsolvable},
           Known{R"("v":[-1,1],"N":[[1],[-1]],"G_factors":{"X":[[1,1],[1,1.0000000000000002]],"alpha":[1,1]})",
                 Truth::kSolvable},
           Known{R"("v":[-1,0,0],"N":[[1],[-1],[0]],"Ginv":[[1,0,0],[0,0,0],[0,0,4]])", Truth::kSolvable},
       }) {
    EXPECT_EQ(truth_of("contact", known).truth, known.truth) << known.data;
  }
}

// Small integers leave no doubt: an exact solution, rounded, passes in exact arithmetic and as a mixed LCP in double.
TEST(AttackTest, ExactSolutionsWithBoundedRowsPass) {
  int solvable = 0, unsolvable = 0, unknown = 0;
  for (std::uint64_t index = 0; index < 450; ++index) {
    const Problem problem = generate(Family::kRows, 15, index);
    const ExactTruth truth = exact_truth(problem);
    ++(truth.truth == Truth::kSolvable ? solvable : truth.truth == Truth::kUnsolvable ? unsolvable : unknown);
    if (truth.truth != Truth::kSolvable) continue;
    const Judge judge(problem);
    EXPECT_TRUE(judge.solves(truth.z)) << problem.name() << ": " << judge.measure();
    EXPECT_LE(judge.measure(), 1e-7) << problem.name();  // roundings of 1e-16 m/s over a scale of 1e-8 m/s
    const std::vector<double> z(truth.z.begin(), truth.z.end());
    EXPECT_LE(lcp_error(form_lcp(*problem.contact()), z).backward, 1e-12) << problem.name();
  }
  EXPECT_GE(solvable, 300);
  EXPECT_GE(unsolvable, 50);
  EXPECT_LE(unknown, 4);
}

std::string hash_of_first(Family family, std::uint64_t count) {
  std::string all;
  for (std::uint64_t index = 0; index < count; ++index) all += problem_hash(generate(family, 15, index));
  return std::to_string(stream_id(all));
}

TEST(AttackTest, ProblemsAreTheSameOnEveryMachine) {
  EXPECT_EQ(hash_of_first(Family::kLcp, 510), "7529421033780266178");
  EXPECT_EQ(hash_of_first(Family::kMixed, 510), "14826116895335564766");
  EXPECT_EQ(hash_of_first(Family::kContact, 450), "7306394478572106017");
  EXPECT_EQ(hash_of_first(Family::kDoubtful, 400), "16329457992780977348");
  EXPECT_EQ(hash_of_first(Family::kRank, 200), "293119894001033079");
  EXPECT_EQ(hash_of_first(Family::kLimits, 250), "4377977759936502775");
}

}  // namespace
}  // namespace lcpbench::attack::attack_test
