#include "native/contact_lemke/contact_lemke.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "tests/native/allocation_checks.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/contacts.h"
#include "tests/support/cube_stack.h"
#include "tests/support/exact_velocity.h"
#include "tests/support/solving.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::contact_lemke_test {
namespace {

std::unique_ptr<Solver> contact_lemke(const Options& options = {}) { return make_solver({"contact_lemke", options}); }

Answer solve(Solver& solver, const SolveRequest& request = {}) { return testing::solve(solver, request); }

Answer solve(const Problem& problem, const Options& options = {}, const SolveRequest& request = {}) {
  return testing::solve(Spec{"contact_lemke", options}, problem, request);
}

Errors errors_of(const Problem& problem, const Answer& answer) { return Evaluator(problem).errors(answer); }

/// It meets the floor with velocity (3, 0, -1); friction along x and y.
ContactProblem point_on_floor(double mu) { return testing::point_on_floor(mu, 4, testing::vector_of({3, 0, -1})); }

// --- small problems with known answers ---

TEST(ContactLemkeTest, ASlidingPointIsBrakedByTheFullConeAndAStickingOneStops) {
  for (const char* precision : {"double", "quad", "cascade"}) {
    for (const char* covering : {"both", "normals", "classic"}) {
      const Options options{{"precision", precision}, {"covering", covering}};
      // f_N = 2, friction 0.5 * 2 = 1 against x: v+ = (2.5, 0, 0), lambda bounds the slip of 2.5.
      const Answer sliding = solve(Problem("sliding", point_on_floor(0.5)), options);
      ASSERT_EQ(sliding.claim, Claim::kSolved) << sliding.detail;
      EXPECT_LE((sliding.z - testing::vector_of({2, 0, 0, 1, 0, 2.5})).lpNorm<Eigen::Infinity>(), 1e-14);
      // Friction up to 8: the 6 that stop the point are inside the cone, nothing slips.
      const Answer sticking = solve(Problem("sticking", point_on_floor(4)), options);
      ASSERT_EQ(sticking.claim, Claim::kSolved) << sticking.detail;
      EXPECT_LE((sticking.z - testing::vector_of({2, 0, 0, 6, 0, 0})).lpNorm<Eigen::Infinity>(), 1e-14);
    }
  }
}

// Neither has friction rows in the kernel; with mu = 0 they are still rows of the problem, and lambda bounds the slip.
TEST(ContactLemkeTest, FillsInLambdaWhereThereIsNoFriction) {
  const Answer smooth = solve(Problem("smooth", point_on_floor(0)));
  ASSERT_EQ(smooth.claim, Claim::kSolved) << smooth.detail;
  EXPECT_LE((smooth.z - testing::vector_of({2, 0, 0, 0, 0, 3})).lpNorm<Eigen::Infinity>(), 1e-14);
  ContactProblem parting = point_on_floor(0.5);
  parting.v(2) = 1;
  EXPECT_EQ(solve(Problem("parting", parting)).z, testing::vector_of({0, 0, 0, 0, 0, 3}));
}

TEST(ContactLemkeTest, TakesContactsWithAndWithoutFrictionTogether) {
  const auto set = open_set("paper/copositive/exp2");
  for (std::int64_t trial = 0; trial < 30; ++trial) {
    ContactProblem contact = *set->generate(77, trial).contact();
    for (Index i = 0; i < contact.nc(); i += 2) contact.mu(i) = 0;
    const Problem smooth_rows("mu = 0", contact);
    const Answer with_rows = solve(smooth_rows);
    ASSERT_EQ(with_rows.claim, Claim::kSolved) << trial;
    EXPECT_TRUE(errors_of(smooth_rows, with_rows).solved) << trial;

    ContactProblem without = contact;
    without.edges.clear();
    Matrix D(contact.ngc(), 0);
    Index first = 0;
    for (Index i = 0; i < contact.nc(); ++i) {
      const int edges = contact.edges[static_cast<std::size_t>(i)];
      without.edges.push_back(i % 2 == 0 ? 0 : edges);
      if (i % 2 == 1) {
        D.conservativeResize(Eigen::NoChange, D.cols() + edges);
        D.rightCols(edges) = std::get<Matrix>(contact.D).middleCols(first, edges);
      }
      first += edges;
    }
    without.D = D;
    const Answer short_answer = solve(Problem("edges = 0", without));
    ASSERT_EQ(short_answer.claim, Claim::kSolved) << trial;
    EXPECT_EQ(short_answer.z.head(contact.nc()), with_rows.z.head(contact.nc())) << trial;
  }
}

// No slip at all: every direction of friction ties with every other and with sticking.
TEST(ContactLemkeTest, SolvesStacksFullOfTies) {
  for (const int bodies : {1, 2, 5, 8}) {
    for (const double slide : {0.0, 0.25, 2.0}) {
      for (const char* precision : {"double", "cascade"}) {
        const Problem problem = testing::cube_stack(bodies, 4, 1.0, slide);
        const Answer answer = solve(problem, {{"precision", precision}});
        ASSERT_EQ(answer.claim, Claim::kSolved) << bodies << " bodies, slide " << slide << ": " << answer.detail;
        EXPECT_LE(errors_of(problem, answer).velocity_residual_relative, 1e-9);
      }
    }
  }
}

// --- the study's problems ---

class ContactLemkeOnSets : public ::testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(FullRank, ContactLemkeOnSets, ::testing::ValuesIn(testing::full_rank_sets()),
                         testing::paper_set_name);

TEST_P(ContactLemkeOnSets, SolvesEveryProblem) {
  const auto set = open_set(GetParam());
  const auto solver = contact_lemke();
  for (std::int64_t trial = 0; trial < 100; ++trial) {
    const Problem problem = set->generate(4711, trial);
    solver->load(problem);
    const Answer answer = solve(*solver);
    ASSERT_EQ(answer.claim, Claim::kSolved) << "trial " << trial << ": " << answer.detail;
    EXPECT_TRUE(errors_of(problem, answer).solved) << "trial " << trial << ", " << answer.detail;
  }
}

TEST(ContactLemkeTest, QuadAloneSolvesAndIsAsExactAsDoublesCanTell) {
  const auto set = open_set("paper/copositive/exp5-1e8{redundancy=combination}");
  for (std::int64_t trial = 0; trial < 6; ++trial) {
    for (const char* covering : {"normals", "classic"}) {
      const Problem problem = set->generate(5, trial);
      const Answer answer = solve(problem, {{"precision", "quad"}, {"covering", covering}});
      ASSERT_EQ(answer.claim, Claim::kSolved) << trial << answer.detail;
      EXPECT_LE(errors_of(problem, answer).velocity_residual_relative, 1e-6) << trial;
    }
  }
}

// v* is unique without friction: that of the contacts that press, in 113 bits. What is left is the rounding of the
// impulses to double, which their response enlarges with the condition of the inertia.
TEST(ContactLemkeTest, ImpulsesInQuadGiveTheVelocityToRounding) {
  for (const auto& [name, bound] :
       {std::pair{"paper/monotone/exp1", 1e-14}, std::pair{"paper/monotone/exp5-1e5", 1e-13},
        std::pair{"paper/monotone/exp5-1e8", 1e-11}}) {
    const auto set = open_set(name);
    std::vector<double> errors;
    for (std::int64_t trial = 0; trial < 40; ++trial) {
      const Problem problem = set->generate(14, trial);
      const Answer answer = solve(problem, {{"precision", "quad"}});
      QuadVector exact;
      if (!testing::exact_velocity(*problem.contact(), answer.z, exact)) continue;
      const Vector velocity = post_impact_velocity(*problem.contact(), answer.z);
      errors.push_back(testing::velocity_error(*problem.contact(), velocity, exact));
    }
    ASSERT_GE(errors.size(), 36u) << name;
    std::sort(errors.begin(), errors.end());
    EXPECT_LE(errors[errors.size() / 2], bound) << name;
  }
}

// The reason for its speed, counted: M is of order 200 and more, its pivots are tens.
TEST(ContactLemkeTest, TakesFewPivots) {
  const auto set = open_set("paper/copositive/exp1");
  std::int64_t pivots = 0, classic_pivots = 0;
  Index n = 0;
  for (std::int64_t trial = 0; trial < 50; ++trial) {
    const Problem problem = set->generate(3, trial);
    n += problem.size();
    pivots += solve(problem).counters.pivots;
    classic_pivots += solve(problem, {{"covering", "classic"}}).counters.pivots;
  }
  EXPECT_LT(8 * pivots, n);
  EXPECT_LT(2 * pivots, classic_pivots);
}

// --- what the data may look like ---

TEST(ContactLemkeTest, TakesTheInertiaInEveryForm) {
  const auto set = open_set("paper/copositive/exp1");
  for (std::int64_t trial = 0; trial < 20; ++trial) {
    const ContactProblem contact = *set->generate(8, trial).contact();
    const Matrix G = dense_inertia(contact.inertia);
    const Eigen::LLT<Matrix> llt(G);
    const Matrix L = llt.matrixL();
    ContactProblem factored = contact, inverse = contact, sparse = contact;
    factored.inertia = FactoredInertia{L, Vector::Ones(G.rows())};
    inverse.inertia = InverseInertia{inverse_inertia(contact.inertia)};
    sparse.N = SparseMatrix(std::get<Matrix>(contact.N).sparseView());
    sparse.D = SparseMatrix(std::get<Matrix>(contact.D).sparseView());
    const Answer reference = solve(Problem("dense", contact));
    ASSERT_EQ(reference.claim, Claim::kSolved);
    for (const ContactProblem& other : {factored, inverse, sparse}) {
      const Answer answer = solve(Problem("other", other));
      ASSERT_EQ(answer.claim, Claim::kSolved) << trial << answer.detail;
      EXPECT_TRUE(errors_of(Problem("dense", contact), answer).solved) << trial;
    }
  }
}

TEST(ContactLemkeTest, TakesSeparateBodies) {
  const Problem problem = testing::cube_stack(4, 4, 1.0, 0.5);
  ContactProblem whole = *problem.contact();
  ASSERT_TRUE(std::holds_alternative<BlockInertia>(whole.inertia));
  whole.inertia = DenseInertia{dense_inertia(whole.inertia)};
  EXPECT_EQ(solve(problem).z, solve(Problem("whole", whole)).z);
}

// Powers of two change no rounding: impulses scale with the mass, velocities with the velocity.
TEST(ContactLemkeTest, DoesNotDependOnUnits) {
  const auto set = open_set("paper/copositive/exp5-1e5");
  for (std::int64_t trial = 0; trial < 10; ++trial) {
    const ContactProblem contact = *set->generate(9, trial).contact();
    const Answer answer = solve(Problem("as it is", contact));
    ContactProblem scaled = contact;
    scaled.v *= 0x1p-40;
    scaled.inertia = DenseInertia{0x1p60 * dense_inertia(contact.inertia)};
    const Answer other = solve(Problem("scaled", scaled));
    ASSERT_EQ(other.claim, Claim::kSolved) << other.detail;
    const ContactLayout layout = contact_layout(contact);
    EXPECT_EQ(other.z.head(layout.lambda_offset()), 0x1p20 * answer.z.head(layout.lambda_offset())) << trial;
    EXPECT_EQ(other.z.tail(layout.cones), 0x1p-40 * answer.z.tail(layout.cones)) << trial;
  }
}

// --- problems without a solution ---

/// Two contacts push a body that cannot move along x against each other.
ContactProblem jammed(int edges) {
  ContactProblem contact;
  contact.v = testing::vector_of({-1, 0.5});
  contact.N = Matrix{{1.0, 1.0}, {1.0, -1.0}};
  contact.edges.assign(2, edges);
  contact.mu = Vector::Constant(2, edges > 0 ? 0.5 : 0.0);
  Matrix D(2, 2 * edges);
  for (Index j = 0; j < D.cols(); ++j) D.col(j) = (j % edges < edges / 2 ? 1 : -1) * testing::vector_of({0, 1});
  contact.D = D;
  contact.inertia = FactoredInertia{Matrix{{0.0}, {1.0}}, testing::vector_of({3})};
  return contact;
}

TEST(ContactLemkeTest, SaysUnsolvableOnlyWithAProofThatHolds) {
  for (const int edges : {0, 2, 4}) {
    const Problem problem("jammed", jammed(edges));
    const Answer answer = solve(problem);
    ASSERT_EQ(answer.claim, Claim::kUnsolvable) << answer.detail;
    EXPECT_TRUE(Evaluator(problem).check_farkas(answer.farkas)) << answer.farkas.transpose();
  }
}

// The factors' range is what the smallest pivots of a rounded G = X A X' would lose: here four digits were left of it.
TEST(ContactLemkeTest, KnowsTheRangeOfAnInertiaFromItsFactors) {
  const Problem problem = open_set("paper/monotone/exp4")->generate(1, 11036);
  const Answer answer = solve(problem);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(errors_of(problem, answer).velocity_residual_relative, 1e-6);
}

TEST(ContactLemkeTest, TakesDependentFactorsAndThoseOfNoWeight) {
  ContactProblem contact;
  contact.v = testing::vector_of({1, -1, 0});
  contact.D = Matrix(3, 0);
  contact.edges = {0};
  contact.mu = Vector::Zero(1);
  Matrix X(3, 2);
  X << 0, 0, 2, 4, 0, 0;  // twice the same direction: G = diag(0, 20, 0)
  contact.N = Matrix(testing::vector_of({0, 1, 0}));
  for (const Vector& alpha : {testing::vector_of({1, 1}), testing::vector_of({1, 0})}) {
    contact.inertia = FactoredInertia{X, alpha};
    const Problem problem("dependent", contact);
    const Answer answer = solve(problem);
    ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    EXPECT_NEAR(answer.z(0), 4 * alpha(0) + 16 * alpha(1), 1e-12);  // G_22 times the approach of 1 m/s
  }
}

// Masses from 6e-10 to 6e5: impulses that are each rounded for itself do not pass the test of the answer.
TEST(ContactLemkeTest, RoundsImpulsesSoThatTheOthersMakeUpForIt) {
  ContactProblem contact;
  contact.v = testing::vector_of({0.8953988049357573, -0.92976188101738755, -0.15852534892729597, -0.8022851304373112});
  Matrix N(3, 4);
  N << -0.010453581242417576, 0.75132911862768403, -0.99820166362507001, -0.79380258023109662,  //
      0.35022653242432944, 0.96056514444125618, 0.62560871763316372, 0.80638174960455111,       //
      -0.43842584502671456, 0.68214078290860614, 0.056496385334256383, -0.19504328859792963;
  contact.N = Matrix(N.transpose());
  contact.D = Matrix(4, 0);
  contact.edges = {0, 0, 0};
  contact.mu = Vector::Zero(3);
  const Vector masses =
      testing::vector_of({6.3918759244041365e-10, 584595.46672820835, 22373.465247762011, 272.95791206900918});
  contact.inertia = DenseInertia{masses.asDiagonal().toDenseMatrix()};
  const Problem problem("masses", contact);
  const Answer answer = solve(problem);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_TRUE(errors_of(problem, answer).solved);
}

// --- the life of a solver ---

/// The stack with its second body 2^60 times as heavy: coordinates in other units for the engines.
Problem stack_in_two_units(int edges) {
  ContactProblem contact = *testing::cube_stack(2, edges, 0.25, 0.5).contact();
  std::get<BlockInertia>(contact.inertia).blocks[1] *= 0x1p60;
  return Problem("two units", contact);
}

TEST(ContactLemkeTest, LoadsWithoutAllocatingWhatWasReserved) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  std::vector<Problem> problems;
  for (const int edges : {0, 4}) {
    for (const int bodies : {3, 1}) problems.push_back(testing::cube_stack(bodies, edges, 0.25, 0.5));
    problems.push_back(stack_in_two_units(edges));
  }
  for (const char* name : {"monotone/exp2", "monotone/exp4", "copositive/exp2", "copositive/exp3"}) {
    const auto set = open_set(std::string("paper/") + name);
    for (std::int64_t trial = 0; trial < 6; ++trial) problems.push_back(set->generate(53, trial));
  }
  testing::expect_loads_without_allocating([] { return ContactLemke(ContactLemkeSettings{}); }, problems);
}

// Stacks of 14 and 20 cubes respond in two and in three ranges of whole blocks, which one solver takes after others.
TEST(ContactLemkeTest, RespondsWithTheVelocityOfItsAnswer) {
  ContactProblem lifted = *testing::cube_stack(14, 4, 0.25, 0.5).contact();
  lifted.b = Vector::Constant(lifted.nc(), 0.01);
  ContactLemke solver{ContactLemkeSettings{}};
  for (const Problem& problem :
       {testing::cube_stack(3, 4, 0.25, 0.5), testing::cube_stack(20, 4, 0.25, 0.5), stack_in_two_units(4),
        Problem("lifted", lifted), open_set("paper/copositive/exp2")->generate(54, 1)}) {
    solver.load(problem);
    const Answer answer = solve(solver);
    ASSERT_EQ(answer.claim, Claim::kSolved) << problem.name();
    EXPECT_TRUE(errors_of(problem, answer).solved) << problem.name();
    const Vector expected = post_impact_velocity(*problem.contact(), answer.z);
    Vector velocity(expected.size());
    solver.respond(answer.z, velocity);
    // Both are double arithmetic on a well-conditioned inertia, or one whose conditioning is that of its units.
    EXPECT_LE((velocity - expected).lpNorm<Eigen::Infinity>(), 1e-12 * problem.contact()->v.norm()) << problem.name();
  }
}

}  // namespace
}  // namespace lcpbench::contact_lemke_test
