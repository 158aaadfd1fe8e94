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

Problem problem_of(const std::string& kind, const std::string& data) {
  return parse_problem_json(
      R"({"format":"lcpbench-problem","version":1,"name":"x","kind":")" + kind + "\"," + data + "}", "test");
}

ExactTruth truth_of(const std::string& kind, const Known& known) { return exact_truth(problem_of(kind, known.data)); }

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

/// A point of mass 1, and a wall that it may not approach by less than `offset`.
std::string on_a_line(const std::string& rows, const std::string& offset = "0") {
  return R"("v":[0],"N":[[1]],"G":[[1]],"b":[)" + offset + R"(],"rows":{)" + rows + "}";
}

TEST(AttackTest, KnowsTheTruthOfBoundedRows) {
  const std::string equal = R"("R":[[1,1]],"lower":[null,null],"upper":[null,null])";
  const std::string limits = R"("R":[[1,1]],"lower":[0,null],"upper":[null,0])";  // v+ >= -b_0, v+ <= -b_1
  const std::string loaded = R"("R":[[1,1]],"lower":[0,null],"upper":[null,null],"friction_of":[null,0],)";
  for (const auto& [data, truth] : {
           std::pair{on_a_line(equal + R"(,"b":[-1,-1])"), Truth::kSolvable},
           {on_a_line(equal + R"(,"b":[-1,-0.9999999999999998])"), Truth::kUnsolvable},
           {on_a_line(equal + R"(,"b":[-1,-0.9999999999999998],"compliance":[0,5e-324])"), Truth::kSolvable},
           {on_a_line(equal + R"(,"b":[1,1])"), Truth::kUnsolvable},  // against the wall
           {on_a_line(equal + R"(,"b":[1,1])", "1"), Truth::kSolvable},
           {on_a_line(limits + R"(,"b":[-2,-2])"), Truth::kSolvable},
           {on_a_line(limits + R"(,"b":[-2,-1])"), Truth::kUnsolvable},
           {on_a_line(R"("R":[[1,1]],"lower":[0,null],"upper":[null,8],"b":[-2,-1])"), Truth::kUnsolvable},
           {on_a_line(R"("R":[[1,1]],"lower":[0,-8],"upper":[null,8],"b":[-2,-1])"), Truth::kSolvable},
           // What moves nothing: an equality, a limit, and a motor.
           {on_a_line(R"("R":[[0]],"lower":[null],"upper":[null],"b":[1])"), Truth::kUnsolvable},
           {on_a_line(R"("R":[[0]],"lower":[null],"upper":[0],"b":[1])"), Truth::kUnsolvable},
           {on_a_line(R"("R":[[0]],"lower":[0],"upper":[null],"b":[1])"), Truth::kSolvable},
           {on_a_line(R"("R":[[0]],"lower":[-1],"upper":[null],"b":[-1])"), Truth::kUnsolvable},
           {on_a_line(R"("R":[[0]],"lower":[-1],"upper":[1],"b":[-1])"), Truth::kSolvable},
           // f_0 - f_1 = 2 leaves w_1 = 2: friction holds back at its limit, mu f_0, for which mu has to be below 1.
           {on_a_line(loaded + R"("mu":[null,0.5],"b":[-2,0])"), Truth::kSolvable},
           {on_a_line(loaded + R"("mu":[null,1],"b":[-2,0])"), Truth::kUnsolvable},
       }) {
    EXPECT_EQ(truth_of("contact", {data.c_str(), truth}).truth, truth) << data;
  }
}

TEST(AttackTest, KnowsWhatProvesThatBoundedRowsHaveNoSolution) {
  const auto proves = [](const std::string& rows, const Vector& u, const char* offset = "8") {
    return disproves(problem_of("contact", on_a_line(rows, offset)), u);
  };
  const std::string equal = R"("R":[[1,1]],"lower":[null,null],"upper":[null,null],"b":[0,1])";
  EXPECT_TRUE(proves(equal, Vector{{0, 1, -1}}));
  EXPECT_FALSE(proves(equal, Vector{{0, -1, 1}}));  // the wrong way
  EXPECT_FALSE(proves(equal, Vector{{0, 1, -1 + 0x1p-53}}));  // moves something
  EXPECT_FALSE(proves(equal, Vector{{1, -1}}));
  EXPECT_FALSE(proves(equal + R"(,"compliance":[1,0])", Vector{{0, 1, -1}}));
  EXPECT_TRUE(proves(equal, Vector{{1, -1, 0}}, "-1"));  // against the wall
  EXPECT_FALSE(proves(equal, Vector{{-1, 1, 0}}));
  const std::string limits = R"("R":[[1,1]],"b":[-2,-1],)";  // v+ >= 2, v+ <= 1
  EXPECT_TRUE(proves(limits + R"("lower":[0,null],"upper":[null,0])", Vector{{0, 1, -1}}));
  EXPECT_TRUE(proves(limits + R"("lower":[-3,null],"upper":[null,4])", Vector{{0, 1, -1}}));
  EXPECT_FALSE(proves(limits + R"("lower":[null,null],"upper":[0,null])", Vector{{0, 1, -1}}));
  EXPECT_FALSE(proves(limits + R"("lower":[0,-9],"upper":[null,0])", Vector{{0, 1, -1}}));
  EXPECT_FALSE(proves(limits + R"("lower":[0,null],"upper":[null,null],"friction_of":[null,0],"mu":[null,1])",
                      Vector{{0, 1, -1}}));
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
  EXPECT_EQ(hash_of_first(Family::kRows, 450), "9938121167511428879");
  EXPECT_EQ(hash_of_first(Family::kRank, 200), "293119894001033079");
  EXPECT_EQ(hash_of_first(Family::kLimits, 250), "4377977759936502775");
}

}  // namespace
}  // namespace lcpbench::attack::attack_test
