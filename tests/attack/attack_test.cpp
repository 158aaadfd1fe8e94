// What the attack takes for the truth, and how it counts.
#include <chrono>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>

#include "core/io/problem_io.h"
#include "tests/attack/campaign.h"

namespace lcpbench::attack::attack_test {
namespace {

Problem lcp(const std::string& M, const std::string& q) {
  return parse_problem_json(
      R"({"format":"lcpbench-problem","version":1,"name":"x","kind":"lcp","M":)" + M + R"(,"q":)" + q + "}", "test");
}

Problem contact(const std::string& data) {
  return parse_problem_json(R"({"format":"lcpbench-problem","version":1,"name":"x","kind":"contact",)" + data + "}",
                            "test");
}

Vector vector(std::initializer_list<double> values) {
  Vector x(static_cast<Index>(values.size()));
  std::copy(values.begin(), values.end(), x.begin());
  return x;
}

struct Known {
  const char* M;
  const char* q;
  Truth truth;
  bool shown_by_doubles;
};

TEST(AttackTest, KnowsTheTruthOfBareLcps) {
  const Known known[] = {
      {"[[1]]", "[-1]", Truth::kSolvable, false},
      {"[[-1]]", "[-1]", Truth::kUnsolvable, true},
      {"[[0]]", "[0]", Truth::kSolvable, false},
      {"[[0]]", "[-4.9e-324]", Truth::kUnsolvable, true},
      // The solutions z_2 = 1, z_1 >= 0 of w = 0 have a singular complementary basis among them.
      {"[[0,1],[0,0]]", "[-1,0]", Truth::kSolvable, false},
      // Feasible (z = (1, 1)), but both cones with z_1 > 0 and z_2 > 0 contradict complementarity.
      {"[[-1,2],[0,1]]", "[-1,-0.75]", Truth::kSolvable, false},
      {"[[0,3],[0,1]]", "[-3,-0.9999999999]", Truth::kUnsolvable, false},
      {"[[1,1e20],[1,0]]", "[0,-1]", Truth::kUnsolvable, false},
      {"[[0,-1,2],[1,0,0],[-2,0,0]]", "[0,-2.0000000000000004,4]", Truth::kUnsolvable, true},
      {"[[0,1,0,1],[-1,0,1.0000000000000002,-1.9999999999999998],[0,-1,0,1.0000000000000002],[-1,2,-1,0]]",
       "[1,-2,1,-1]", Truth::kSolvable, false},
  };
  for (const Known& k : known) {
    const ExactTruth truth = exact_truth(lcp(k.M, k.q));
    EXPECT_EQ(truth.truth, k.truth) << k.M << k.q;
    EXPECT_EQ(truth.shown_by_doubles, k.shown_by_doubles) << k.M << k.q;
  }
}

TEST(AttackTest, KnowsTheTruthOfContacts) {
  EXPECT_EQ(exact_truth(contact(R"("v":[-1],"N":[[1]],"G":[[1]])")).truth, Truth::kSolvable);
  // The contact acts where the inertia's factors do not reach.
  const Problem falls = contact(R"("v":[0,-1],"N":[[0],[1]],"G_factors":{"X":[[1],[0]],"alpha":[1]})");
  EXPECT_EQ(exact_truth(falls).truth, Truth::kUnsolvable);
  EXPECT_TRUE(disproves(falls, vector({1})));
  const Problem rises = contact(R"("v":[0,1],"N":[[0],[1]],"G_factors":{"X":[[1],[0]],"alpha":[1]})");
  EXPECT_EQ(exact_truth(rises).truth, Truth::kSolvable);
  EXPECT_FALSE(disproves(rises, vector({1})));
}

TEST(AttackTest, JudgesEachIslandByItsOwnScale) {
  const Problem two = contact(R"("v":[20000,-1],"N":[[1,0],[0,1]],"G":[[1,0],[0,1]])");
  EXPECT_FALSE(Judge(two).solves(vector({0, 0})));
  EXPECT_TRUE(Judge(two).solves(vector({0, 1})));
  const Problem blocks = lcp("[[1,0],[0,1]]", "[-1e10,-1]");
  EXPECT_FALSE(Judge(blocks).solves(vector({1e10, 0})));
  EXPECT_TRUE(Judge(blocks).solves(vector({1e10, 1})));
  EXPECT_FALSE(Judge(blocks).solves(vector({1e10})));
}

TEST(AttackTest, JudgesFrictionAsWritten) {
  // A sliding block: normal impulse 1, friction mu = 1/2 against the slip, lambda the slip left.
  const Problem slides =
      contact(R"("v":[-1,2],"N":[[1],[0]],"D":[[0,0],[1,-1]],"mu":[0.5],"edges":[2],"G":[[1,0],[0,1]])");
  EXPECT_TRUE(Judge(slides).solves(vector({1, 0, 0.5, 1.5})));
  EXPECT_FALSE(Judge(slides).solves(vector({1, 0, 0, 0})));
  EXPECT_TRUE(Judge(slides).is_exact_solution({2, 0, 1, 3}, 2));
  EXPECT_FALSE(Judge(slides).is_exact_solution({2, 0, 1, 2}, 2));
}

TEST(AttackTest, KnowsTheTruthOfContactsWithOffsets) {
  const auto walls = [](const std::string& b) {
    return contact(R"("v":[0],"N":[[1,-1]],"D":[[0,0]],"edges":[2,0],"mu":[0,0],"G":[[1]],"b":)" + b);
  };
  const Problem closing = walls("[-1,0.9999999999999998]");
  EXPECT_EQ(exact_truth(closing).truth, Truth::kUnsolvable);
  EXPECT_EQ(exact_truth(walls("[-1,1]")).truth, Truth::kSolvable);
  EXPECT_EQ(exact_truth(walls("[-1,1.0000000000000002]")).truth, Truth::kSolvable);
  EXPECT_TRUE(disproves(closing, vector({1, 1})));
  EXPECT_FALSE(disproves(walls("[-1,1]"), vector({1, 1})));
  EXPECT_TRUE(Judge(closing).solves(vector({1, 0, 0, 0, 0})));  // nearly
  EXPECT_FALSE(Judge(closing).solves(vector({0, 0, 0, 0, 0})));
  EXPECT_FALSE(Judge(walls("[-1,0.999]")).solves(vector({1, 0, 0, 0, 0})));
}

TEST(AttackTest, KnowsTheExactRankOfFactors) {
  const Problem light = contact(R"("v":[-1,-1],"N":[[1],[1]],"G_factors":{"X":[[1,1],[0,1e-14]],"alpha":[1,1]})");
  EXPECT_TRUE(Judge(light).solves(vector({1e-28})));
  EXPECT_FALSE(Judge(light).solves(vector({4})));
  const Problem nearly =
      contact(R"("v":[-1,1],"N":[[1],[-1]],"G_factors":{"X":[[1,1],[1,1.0000000000000002]],"alpha":[1,1]})");
  EXPECT_EQ(exact_truth(nearly).truth, Truth::kSolvable);
  EXPECT_FALSE(Judge(nearly).solves(vector({3.2e32})));
  const Problem equal = contact(R"("v":[-1,1],"N":[[1],[-1]],"G_factors":{"X":[[1,1],[1,1]],"alpha":[1,1]})");
  EXPECT_EQ(exact_truth(equal).truth, Truth::kUnsolvable);
  const Problem singular = contact(R"("v":[-1,0,0],"N":[[1],[-1],[0]],"Ginv":[[1,0,0],[0,0,0],[0,0,4]])");
  EXPECT_EQ(exact_truth(singular).truth, Truth::kSolvable);
  EXPECT_TRUE(Judge(singular).solves(vector({1})));
}

TEST(AttackTest, JudgesTheReturnedVelocity) {
  const Problem deficient = contact(
      R"("v":[-1,0,0],"N":[[1],[0],[0]],"G_factors":{"X":[[-1,1,0],[2,-1,1],[1,0,1]],"alpha":[1,1,1]})");
  const Judge judge(deficient);
  const Vector z = vector({27.0 / 14});
  ASSERT_TRUE(judge.solves(z));
  const Vector u = vector({0, -1.0 / 14, 13.0 / 14});
  EXPECT_TRUE(judge.velocity_holds(z, u));
  EXPECT_TRUE(judge.velocity_holds(z, (1 + 1e-5) * u));
  EXPECT_FALSE(judge.velocity_holds(z, vector({777, 888, 999})));
  EXPECT_FALSE(judge.velocity_holds(z, vector({0, 4.34e15, 0})));
  EXPECT_FALSE(judge.velocity_holds(z, vector({0})));
  for (Index k = 0; k < 3; ++k) {
    Vector off = u;
    off(k) += judge.beyond_velocity(z)(k);
    EXPECT_FALSE(judge.velocity_holds(z, off)) << k;
  }
}

std::string hash_of_first(Family family, std::uint64_t count) {
  std::string all;
  for (std::uint64_t index = 0; index < count; ++index) all += problem_hash(generate(family, 15, index));
  return std::to_string(stream_id(all));
}

TEST(AttackTest, ProblemsAreTheSameOnEveryMachine) {
  EXPECT_EQ(hash_of_first(Family::kLcp, 510), "7529421033780266178");
  EXPECT_EQ(hash_of_first(Family::kContact, 450), "7306394478572106017");
  EXPECT_EQ(hash_of_first(Family::kDoubtful, 400), "16329457992780977348");
}

class Faulty final : public Subject {
 public:
  Outcome meet(Target& target, double, std::string&) override {
    if (target.problem.name().ends_with("-7")) {
      std::signal(SIGSEGV, SIG_DFL);  // a sanitizer would write a report, which takes time
      std::raise(SIGSEGV);
    }
    if (target.problem.name().ends_with("-9")) std::this_thread::sleep_for(std::chrono::seconds(60));
    if (target.problem.name().ends_with("-11")) throw std::runtime_error("test");
    return Outcome::kSolved;
  }
};

class Good final : public Subject {
 public:
  Outcome meet(Target&, double, std::string&) override { return Outcome::kSolved; }
};

TEST(AttackTest, GoesOnBehindACrashAndAHang) {
  CampaignOptions options;
  options.problems = 100;
  options.jobs = 2;
  options.subjects = {"good", "faulty", "better"};
  options.hard_limit_s = 8;
  options.make = [](const std::string& name) -> std::unique_ptr<Subject> {
    if (name == "faulty") return std::make_unique<Faulty>();
    return std::make_unique<Good>();
  };
  const Tally tally = run_campaign(options);
  EXPECT_EQ(tally.count(0, Outcome::kSolved), 100U);
  EXPECT_EQ(tally.count(2, Outcome::kSolved), 100U);
  EXPECT_EQ(tally.count(1, Outcome::kSolved), 97U);
  EXPECT_EQ(tally.count(1, Outcome::kCrashed), 2U);
  EXPECT_EQ(tally.count(1, Outcome::kHung), 1U);
  EXPECT_EQ(tally.contradictions(), 3U);
  std::uint64_t truths = 0;
  for (std::size_t i = 0; i < tally.truths.size(); ++i) truths += i % kTruths == 2 ? 0 : tally.truths[i];
  EXPECT_EQ(truths, 100U);
}

}  // namespace
}  // namespace lcpbench::attack::attack_test
