// The adapters of libraries with a round friction cone: what they refuse, how their impulses come back, and that they
// solve the cone's conditions, which are checked here from v, N, D and z alone.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "tests/adapters/library_runs.h"

namespace lcpbench::adapter_cone_test {
namespace {

const char* const kCones[] = {"siconos_fc3d{cone=true}", "siconos_fc3d{cone=true,method=nsn_ac}",
                              "siconos_fc3d{cone=true,method=admm}",
                              "simbody_pgs{cone=true,tolerance=1e-12,max_iterations=100000}",
                              "simbody_plus{cone=true}"};

/// A body of 2 kg that falls with `velocity` on one contact at its centre of mass, mu = 1/4.
Problem drop(const Eigen::Vector3d& velocity) {
  RigidScene scene;
  scene.bodies = {RigidBody{.mass = 2.0, .linear_velocity = velocity}};
  scene.contacts = {RigidContact{.mu = 0.25, .edges = 4}};
  return Problem("drop", scene);
}

/// The same contact with directions at multiples of 45 degrees.
Problem drop_on_eight(const Eigen::Vector3d& velocity) {
  ContactProblem contact = *drop(velocity).contact();
  const Matrix four = to_dense(contact.D);
  const double half = std::sqrt(0.5);
  Matrix eight(6, 8);
  for (int k = 0; k < 4; ++k) {
    eight.col(2 * k) = four.col(k);
    eight.col(2 * k + 1) = half * (four.col(k) + four.col((k + 1) % 4));
  }
  contact.D = eight;
  contact.edges = {8};
  return Problem("drop on eight", contact);
}

enum class Slip { kAsItIs, kOverDiagonal };

/// The largest error of the cone's own conditions, with the impulses of z: [m/s], or N s beyond a cone. kOverDiagonal:
/// friction acts against the slip whose two parts are divided by their rows' diagonal entries of M.
double cone_error(const Problem& problem, const Vector& z, Slip which = Slip::kAsItIs) {
  const ContactProblem& contact = *problem.contact();
  const ContactLayout layout = contact_layout(contact);
  const Vector v = post_impact_velocity(contact, z);
  const Vector u_N = to_dense(contact.N).transpose() * v;
  const Vector u_D = to_dense(contact.D).transpose() * v;
  double error = 0;
  for (Index i = 0; i < layout.nc; ++i) {
    error = std::max({error, -z(i), std::abs(std::min(z(i), u_N(i)))});
    const Index begin = layout.friction_begin[static_cast<std::size_t>(i)];
    const auto f = z.segment<4>(layout.friction_offset() + begin);
    const Eigen::Vector2d friction = f.head<2>() - f.tail<2>();
    Eigen::Vector2d slip = u_D.segment<2>(begin);
    if (which == Slip::kOverDiagonal) {
      slip.array() /= problem.lcp().M.diagonal().segment<2>(layout.friction_offset() + begin).array();
    }
    const double limit = contact.mu(i) * std::max(z(i), 0.0);
    error = std::max(error, friction.norm() - limit);
    // The step of projecting friction - slip onto the disc: zero where it sticks inside or slides against the limit.
    const Eigen::Vector2d wanted = friction - slip;
    error = std::max(error, (friction - wanted * std::min(1.0, limit / std::max(wanted.norm(), 1e-300))).norm());
  }
  return error;
}

// Of (3, 4) m/s friction takes 1.5 N s / 2 kg = 0.75 against the slip. The pyramid would take all of it from y.
TEST(AdapterConeTest, FrictionActsAgainstTheSlip) {
  const Problem problem = drop({3.0, 4.0, -3.0});
  const Vector z{{6.0, 0.0, 0.0, 0.9, 1.2, 3.4}};
  for (const char* solver : kCones) {
    if (missing(solver)) continue;
    const Answer answer = run(solver, problem).answer;
    EXPECT_LE((answer.z - z).lpNorm<Eigen::Infinity>(), 1e-8) << solver << " returned " << answer.z.transpose();
    EXPECT_EQ(answer.detail.find("another problem: the round friction cone"), 0U) << answer.detail;
    EXPECT_FALSE(Evaluator(problem).errors(answer).solved) << solver;
  }
}

// Of contacts that slide the interior point solves the relaxation: the block of 2 kg lifts off at mu = 1/4 times its
// slip of 4 m/s, with 8 N s and 2 N s against the slip.
TEST(AdapterConeTest, TheGlobalInteriorPointSolvesTheRelaxation) {
  const char* solver = "siconos_fc3d{cone=true,method=ipm}";
  if (missing(solver)) GTEST_SKIP() << solver << " is not installed";
  const Problem problem = drop({3.0, 4.0, -3.0});
  const Answer answer = run(solver, problem).answer;
  EXPECT_LE((answer.z - Vector{{8.0, 0.0, 0.0, 1.2, 1.6, 3.2}}).lpNorm<Eigen::Infinity>(), 1e-8) << answer.z.transpose();
  const auto friction = find_solver("siconos_fc3d").definition.friction;
  EXPECT_EQ(friction(parse_spec(solver).options), FrictionModel::kConvex);
  ContactProblem without = *problem.contact();
  without.inertia = InverseInertia{inverse_inertia(without.inertia)};
  EXPECT_EQ(run(solver, Problem("inverse", without)).answer.detail,
            "method=ipm needs contacts with the inertia itself, not its inverse");
}

// The directions next to atan2(4, 3) are those at 45 and 90 degrees: 0.9 sqrt(2) on the first leaves 0.3 for the
// second.
TEST(AdapterConeTest, ImpulsesComeBackOnTheDirectionsBesideThem) {
  const double sqrt2 = std::sqrt(2.0);
  Vector z = Vector::Zero(10);
  z(0) = 6.0;
  z(1 + 5) = 0.9 * sqrt2;
  z(1 + 6) = 0.3;
  z(9) = 4.25 * 7 / (5 * sqrt2);
  for (const char* solver : kCones) {
    if (missing(solver)) continue;
    const Answer answer = run(solver, drop_on_eight({3.0, 4.0, -3.0})).answer;
    EXPECT_LE((answer.z - z).lpNorm<Eigen::Infinity>(), 1e-8) << solver << " returned " << answer.z.transpose();
  }
}

// What sticks inside the pyramid solves both problems.
TEST(AdapterConeTest, StickingContactsSolveThePyramidToo) {
  const Problem problem = drop({0.25, -0.25, -3.0});
  for (const char* solver : kCones) {
    if (missing(solver)) continue;
    const Answer answer = run(solver, problem).answer;
    EXPECT_LE((answer.z - Vector{{6.0, 0.0, 0.5, 0.5, 0.0, 0.0}}).lpNorm<Eigen::Infinity>(), 1e-8) << solver;
    EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << solver;
  }
}

// Simbody's Gauss-Seidel divides each row's step by its own diagonal entry before it shortens the two to the disc, so
// that where it ends friction is not against the slip.
TEST(AdapterConeTest, ClaimedAnswersSolveTheConesConditions) {
  const auto set = open_set("rigid/frictional/exp1{nc_max=4}");
  for (const char* solver : kCones) {
    if (missing(solver)) continue;
    int claimed = 0;
    for (std::int64_t trial = 0; trial < 20; ++trial) {
      const Problem problem = set->generate(20120101, trial);
      const Answer answer = run(solver, problem).answer;
      if (answer.claim != Claim::kSolved) continue;
      ++claimed;
      const Slip slip = parse_spec(solver).name == "simbody_pgs" ? Slip::kOverDiagonal : Slip::kAsItIs;
      EXPECT_LE(cone_error(problem, answer.z, slip), 1e-6) << solver << " on " << problem.name();
    }
    // PLUS returns false whatever it found.
    EXPECT_GE(claimed, parse_spec(solver).name == "simbody_plus" ? 0 : 15) << solver;
  }
}

TEST(AdapterConeTest, FrictionIsRefusedUnlessTheConeIsAskedFor) {
  for (const char* solver : {"siconos_fc3d", "simbody_pgs", "simbody_plus"}) {
    // What lcpbench says before it starts a worker, and what the worker says.
    const std::string reason =
        "has a round friction cone, which is another problem than this pyramid: cone=true solves that one";
    EXPECT_EQ(why_not(find_solver(solver).definition.capabilities, drop({3.0, 4.0, -3.0})), reason) << solver;
    if (missing(solver)) continue;
    const Answer answer = run(solver, drop({3.0, 4.0, -3.0})).answer;
    EXPECT_EQ(answer.claim, Claim::kUnsupported) << solver;
    EXPECT_EQ(answer.detail, reason) << solver;
    EXPECT_EQ(answer.z.size(), 0) << solver;
  }
}

TEST(AdapterConeTest, DirectionsThatAreNoPolygonAreRefused) {
  ContactProblem bent = *drop_on_eight({3.0, 4.0, -3.0}).contact();
  std::get<Matrix>(bent.D).col(1) *= 1.01;
  std::get<Matrix>(bent.D).col(5) *= 1.01;
  ContactProblem six = bent;
  six.D = Matrix(std::get<Matrix>(bent.D)(Eigen::all, std::vector<int>{0, 1, 2, 4, 5, 6}));
  six.edges = {6};
  for (const char* solver : kCones) {
    if (missing(solver)) continue;
    EXPECT_EQ(run(solver, Problem("bent", bent)).answer.detail, "friction directions that are no regular polygon") << solver;
    EXPECT_EQ(run(solver, Problem("six", six)).answer.detail, "a contact of 6 edges: takes multiples of 4") << solver;
  }
}

// A contact without friction beside one with it has rows of another number.
TEST(AdapterConeTest, ContactsWithoutFrictionKeepTheirPlaces) {
  RigidScene scene;
  scene.bodies = {RigidBody{.mass = 2.0, .linear_velocity = {3.0, 4.0, -3.0}},
                  RigidBody{.mass = 2.0, .linear_velocity = {3.0, 4.0, -3.0}}};
  scene.contacts = {RigidContact{.body_a = 0}, RigidContact{.body_a = 1, .mu = 0.25, .edges = 4}};
  const Vector z{{6.0, 6.0, 0.0, 0.0, 0.9, 1.2, 3.4}};
  for (const char* solver : kCones) {
    if (missing(solver)) continue;
    const Answer answer = run(solver, Problem("two", scene)).answer;
    EXPECT_LE((answer.z - z).lpNorm<Eigen::Infinity>(), 1e-8) << solver << " returned " << answer.z.transpose();
  }
}

}  // namespace
}  // namespace lcpbench::adapter_cone_test
