// The ladder of friction models on problems whose answers are known in closed form, and on captured steps.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/error.h"
#include "generators/sets.h"
#include "study/models/ladder.h"
#include "study/models/pyramid.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::models_test {
namespace {

using testing::vector_of;

/// Points of mass 2 on the floor z = 0, each with its velocity (3 entries).
ContactProblem points(double mu, int edges, const std::vector<Vector>& velocities) {
  const auto count = static_cast<Index>(velocities.size());
  ContactProblem contact;
  contact.v.resize(3 * count);
  Matrix N = Matrix::Zero(3 * count, count);
  Matrix D = Matrix::Zero(3 * count, edges * count);
  for (Index p = 0; p < count; ++p) {
    contact.v.segment(3 * p, 3) = velocities[static_cast<std::size_t>(p)];
    N(3 * p + 2, p) = 1;
    for (Index k = 0; k < edges; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / edges;
      D(3 * p, edges * p + k) = std::cos(angle);
      D(3 * p + 1, edges * p + k) = std::sin(angle);
    }
  }
  contact.N = N;
  contact.D = D;
  contact.edges.assign(static_cast<std::size_t>(count), edges);
  contact.mu = Vector::Constant(count, mu);
  contact.inertia = BlockInertia{std::vector<Matrix>(static_cast<std::size_t>(count), 2 * Matrix::Identity(3, 3))};
  return contact;
}

Ladder ladder_of(const ContactProblem& contact) { return Ladder(with_tangents(contact), 10); }

ModelAnswer climb_one(ContactModel model, const ContactProblem& contact, double error = 1e-9) {
  return ladder_of(contact).climb(model, error);
}

// Friction 1 against a slip of (3, 4): the cone gives 0.9 (3, 4). Four edges brake the faster axis alone, (3, 3.5),
// which is 0.3 m/s off and has a cone residual of the same size; turned, they brake along the slip.
TEST(ModelsTest, FourEdgesMissASlipBetweenThemAndTurnedOnesDoNot) {
  const ContactProblem contact = points(0.5, 4, {vector_of({3, 4, -1})});
  const ModelAnswer four = climb_one(ContactModel::kEdges4, contact);
  EXPECT_LE((four.velocity - vector_of({3, 3.5, 0})).lpNorm<Eigen::Infinity>(), 1e-12);
  EXPECT_GT(four.error_m_per_s, 0.2);
  EXPECT_LT(four.error_m_per_s, 1);
  EXPECT_LE(four.solver_error_m_per_s, 1e-12);
  EXPECT_EQ(climb_one(ContactModel::kEdges4, points(0.5, 16, {vector_of({3, 4, -1})})).velocity, four.velocity)
      << "the edges of the problem do not matter";
  const double eight = climb_one(ContactModel::kEdges8, contact).error_m_per_s;
  EXPECT_LT(eight, four.error_m_per_s);
  EXPECT_GT(climb_one(ContactModel::kNormals, contact).error_m_per_s, four.error_m_per_s);
  for (const ContactModel model :
       {ContactModel::kEdges4Turned, ContactModel::kEdges8Turned, ContactModel::kEdges16Turned, ContactModel::kCone}) {
    const ModelAnswer answer = climb_one(model, contact);
    EXPECT_LE((answer.velocity - vector_of({2.7, 3.6, 0})).lpNorm<Eigen::Infinity>(), 1e-7) << to_string(model);
    EXPECT_LE(answer.error_m_per_s, 1e-7) << to_string(model);
  }
}

// Seen from the belt, a point at rest on a belt slips as above. It has the same impulses, at velocities less by (3, 4).
TEST(ModelsTest, PyramidsAreTurnedIntoTheSlipAgainstABelt) {
  ContactProblem contact = points(0.5, 4, {vector_of({0, 0, -1})});
  contact.offset_t = vector_of({3, 4});
  for (const ContactModel model :
       {ContactModel::kEdges4Turned, ContactModel::kEdges8Turned, ContactModel::kEdges16Turned}) {
    const ModelAnswer answer = climb_one(model, contact);
    EXPECT_LE((answer.velocity - vector_of({-0.3, -0.4, 0})).lpNorm<Eigen::Infinity>(), 1e-6) << to_string(model);
    EXPECT_LE(answer.error_m_per_s, 1e-6) << to_string(model);
  }
}

TEST(ModelsTest, NothingIsTheFirstRungAndLeavesTheVelocity) {
  EXPECT_EQ(kContactModels.front(), ContactModel::kNothing);
  const ModelAnswer nothing = climb_one(ContactModel::kNothing, points(0.5, 4, {vector_of({3, 4, -1})}));
  EXPECT_EQ(nothing.velocity, vector_of({3, 4, -1}));
  EXPECT_NEAR(nothing.error_m_per_s, 1, 1e-12);  // it sinks in
}

TEST(ModelsTest, RestIsExactWhereThereIsOneAndNoAnswerWhereThereIsNone) {
  const ModelAnswer rest = climb_one(ContactModel::kRest, points(6, 4, {vector_of({3, 4, -1})}));
  ASSERT_TRUE(rest.answered());
  EXPECT_LE(rest.velocity.lpNorm<Eigen::Infinity>(), 1e-8);
  EXPECT_LE(rest.error_m_per_s, 1e-7);
  EXPECT_FALSE(climb_one(ContactModel::kRest, points(0.5, 4, {vector_of({3, 4, -1})})).answered());
}

// cone_ipm breaks off on these contacts: that proves nothing about a solution at rest.
TEST(ModelsTest, AFailureIsNotCalledUnsolvableAtRest) {
  const std::vector<LadderIsland> islands =
      ladder_islands(open_set("hard/contact/massless")->generate(1, 0), "failing", 10);
  ASSERT_EQ(islands[0].ladder->climb(ContactModel::kRelaxed, 1e-3).claim, Claim::kNumericalFailure);
  EXPECT_EQ(islands[0].ladder->climb(ContactModel::kRest, 1e-3).claim, Claim::kNumericalFailure);
}

// One point slides along an edge, one between edges: each gets the model that it needs.
TEST(ModelsTest, EachIslandGetsTheModelThatItNeeds) {
  const Problem problem("two", points(0.5, 4, {vector_of({3, 0, -1}), vector_of({3, 4, -1})}));
  std::vector<LadderIsland> islands = ladder_islands(problem, "two", 10);
  ASSERT_EQ(islands.size(), 2U);
  const Climb along = climb(*islands[0].ladder, 1e-3);
  const Climb between = climb(*islands[1].ladder, 1e-3);
  EXPECT_TRUE(along.met);
  EXPECT_EQ(along.chosen.model, ContactModel::kEdges4);
  EXPECT_LE(along.change_m_per_s, 1e-8);
  EXPECT_TRUE(between.met);
  EXPECT_EQ(between.chosen.model, ContactModel::kConeRough);
  EXPECT_LE(between.chosen.error_m_per_s, 1e-3);
  ASSERT_TRUE(between.next.answered());
  EXPECT_LE(between.next.error_m_per_s, 1e-8);
  EXPECT_GT(between.spent_s, between.chosen.time_s);
}

// Two walls that close in on a point: no model has an answer, and none says so.
TEST(ModelsTest, AProblemWithoutASolutionMeetsNothing) {
  ContactProblem squeezed = points(0.5, 4, {vector_of({3, 4, -1})});
  const Matrix D = std::get<Matrix>(squeezed.D);
  squeezed.N = Matrix{{0.0, 0.0}, {0.0, 0.0}, {1.0, -1.0}};
  squeezed.D = Matrix(3, 8);
  std::get<Matrix>(squeezed.D) << D, D;
  squeezed.edges = {4, 4};
  squeezed.mu = vector_of({0.5, 0.5});
  squeezed.b = vector_of({-1, -1});
  Ladder ladder = ladder_of(squeezed);
  EXPECT_FALSE(climb(ladder, 1e-3).met);
  Ladder solvable = ladder_of(points(0.5, 4, {vector_of({3, 4, -1})}));
  EXPECT_FALSE(climb(solvable, 1e-30).met) << "an error that no model reaches";
  EXPECT_NE(ladder.climb(ContactModel::kRelaxed, 1e-3).claim, Claim::kSolved);
}

TEST(ModelsTest, RefusesWhatNamesNoCone) {
  const Problem lcp("bare", Lcp{Matrix::Identity(2, 2), Vector::Ones(2)});
  EXPECT_THROW(ladder_islands(lcp, "bare.json", 10), InputError);
  try {
    ladder_islands(Problem("hexagon", points(0.5, 6, {vector_of({3, 4, -1})})), "hexagon.json", 10);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "hexagon.json: field 'D': the friction names no round cone: a contact of 6 edges: takes multiples of 4");
  }
}

// Every island of these steps is brought below 1e-3 m/s, by the measure of the evaluation.
TEST(ModelsTest, CapturedStepsMeetAMillimetreASecond) {
  for (const char* name : {"scene/wedge/ode", "scene/dominoes/bullet", "scene/uneven-table/bullet",
                           "scene/mass-ratio-1e6/ode", "scene/humanoid-lying/mujoco"}) {
    const Problem problem = open_set(name)->generate(1, 3);
    for (const LadderIsland& island : ladder_islands(problem, name, 10)) {
      const Climb climbed = climb(*island.ladder, 1e-3);
      EXPECT_TRUE(climbed.met) << name;
      EXPECT_LE(climbed.chosen.error_m_per_s, 1e-3) << name;
    }
  }
}

}  // namespace
}  // namespace lcpbench::models_test
