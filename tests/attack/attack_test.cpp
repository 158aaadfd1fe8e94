// What the attack takes for the truth, and how it counts.
#include <chrono>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>

#include "core/io/problem_io.h"
#include "tests/attack/campaign.h"

namespace lcpbench::attack {
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

TEST(AttackTest, AgreesWithAnEnumerationOfAllBases) {
  // Where every principal minor is nonzero, each complementary cone has one point at most.
  int solvable = 0;
  for (std::uint64_t index = 0; index < 170; ++index) {
    const Problem problem = generate(Family::kLcp, 3, index);
    const auto n = static_cast<int>(problem.size());
    if (n > 5) continue;
    const DyadicMatrix rows = Judge(problem).rows();
    bool regular = true;
    bool found = false;
    for (int basis = 0; basis < 1 << n; ++basis) {
      std::vector<Index> in;
      for (int i = 0; i < n; ++i) {
        if ((basis >> i & 1) != 0) in.push_back(i);
      }
      const auto size = static_cast<Index>(in.size());
      DyadicMatrix block(size, size);
      for (Index i = 0; i < size; ++i) {
        for (Index j = 0; j < size; ++j) {
          block(i, j) = rows(in[static_cast<std::size_t>(i)], in[static_cast<std::size_t>(j)] + 1);
        }
      }
      const auto inverted = inverse(block);
      regular = regular && inverted.has_value();
      if (!inverted) continue;
      DyadicVector z(static_cast<std::size_t>(n));  // times the denominator
      for (Index i = 0; i < size; ++i) {
        for (Index j = 0; j < size; ++j) {
          Dyadic& z_i = z[static_cast<std::size_t>(in[static_cast<std::size_t>(i)])];
          z_i = z_i - inverted->numerator(i, j) * rows(in[static_cast<std::size_t>(j)], 0);
        }
      }
      bool complementary = true;
      for (Index i = 0; i < n; ++i) {
        Dyadic w = rows(i, 0) * inverted->denominator;
        for (Index j = 0; j < n; ++j) w = w + rows(i, j + 1) * z[static_cast<std::size_t>(j)];
        complementary = complementary && w.sign() >= 0 && z[static_cast<std::size_t>(i)].sign() >= 0;
      }
      found = found || complementary;
    }
    const Truth truth = exact_truth(problem).truth;
    if (found || regular) {
      EXPECT_EQ(truth, found ? Truth::kSolvable : Truth::kUnsolvable) << problem.name();
    }
    solvable += found ? 1 : 0;
  }
  EXPECT_GT(solvable, 40);
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

TEST(AttackTest, CountsWhatIsLostInTheRoundingOfQAsSolved) {
  // N'v = 2^-53, where (k + 1) 2^-53 |N|'|v| is more than four times that.
  const Problem rounding = contact(R"("v":[1,-1],"N":[[0.9999999999999999],[1]],"G":[[1,0],[0,1]])");
  EXPECT_TRUE(Judge(rounding).solves(vector({0})));
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

std::string hash_of_first(Family family, std::uint64_t count) {
  std::string all;
  for (std::uint64_t index = 0; index < count; ++index) all += problem_hash(generate(family, 15, index));
  return std::to_string(stream_id(all));
}

TEST(AttackTest, ProblemsAreTheSameOnEveryMachine) {
  EXPECT_EQ(hash_of_first(Family::kLcp, 510), "7529421033780266178");
  EXPECT_EQ(hash_of_first(Family::kContact, 450), "7306394478572106017");
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
  options.hard_limit_s = 3;
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
}  // namespace lcpbench::attack
