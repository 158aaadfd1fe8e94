// The adapters on problems that are no friends of a library: an answer comes back, or a reason, and the next problem is
// solved as if nothing had been. What ends a library's process costs that one answer. Every library runs in its worker,
// as in a study.
#include <limits>

#include <gtest/gtest.h>

#include "tests/adapters/library_runs.h"
#include "tests/support/contacts.h"

namespace lcpbench::adapter_hostile_test {
namespace {

using testing::frictionless;

const char* const kSolvers[] = {"dart_lemke",
                                "dart_dantzig",
                                "dart_dantzig{early_termination=false}",
                                "dart_pgs",
                                "siconos_fc3d{cone=true}",
                                "siconos_fc3d{cone=true,method=nsn_ac}",
                                "siconos_fc3d{cone=true,method=admm}",
                                "simbody_pgs{cone=true}",
                                "simbody_plus{cone=true}",
                                "bullet_si",
                                "bullet_nncg"};

/// A ball of 2 kg that falls at an angle onto `contacts` times the same point.
RigidScene ball(int contacts, double mu, double speed, double mass = 2.0) {
  RigidScene scene;
  scene.bodies = {RigidBody{.mass = mass, .linear_velocity = speed * Eigen::Vector3d(0.3, 0.4, -3.0)}};
  for (int i = 0; i < contacts; ++i) scene.contacts.push_back(RigidContact{.mu = mu, .edges = 4});
  return scene;
}

Problem squeezed() {
  // Two floors close in on a ball from both sides: no velocity satisfies both, and there is no solution.
  RigidScene scene = ball(2, 0.5, 1.0);
  scene.bodies.push_back(RigidBody{.mass = 1e-300, .linear_velocity = {0, 0, 1e10}});
  scene.contacts[1].body_b = 1;
  return Problem("squeezed", scene);
}

/// (q, M) of contacts without friction.
Problem smooth(Matrix M, const Vector& q, const std::string& name) {
  return Problem(name, frictionless(q, Matrix::Identity(q.size(), q.size()), InverseInertia{std::move(M)}));
}

std::vector<Problem> hostile_problems() {
  const double tiny = std::numeric_limits<double>::denorm_min();
  std::vector<Problem> problems{Problem("one point forty times", ball(40, 0.5, 1.0)),
                                Problem("no friction after all", ball(3, 0.0, 1.0)),
                                Problem("huge friction", ball(3, 1e300, 1.0)),
                                Problem("huge speed", ball(3, 0.5, 1e300)),
                                Problem("smallest speed", ball(3, 0.5, tiny)),
                                Problem("huge mass", ball(3, 0.5, 1.0, 1e300)),
                                Problem("at rest", ball(3, 0.5, 0.0)),
                                squeezed(),
                                smooth(Matrix::Zero(3, 3), Vector{{-1.0, 0.0, 1.0}}, "zero M without a solution"),
                                smooth(Matrix::Zero(3, 3), Vector{{0.0, 0.0, 1.0}}, "zero M"),
                                smooth(-Matrix::Identity(3, 3), Vector{{-1.0, -1.0, 1.0}}, "negative M"),
                                smooth(Matrix::Constant(3, 3, tiny), Vector{{-1.0, -1.0, 1.0}}, "smallest M"),
                                smooth(Matrix::Constant(3, 3, 1e308), Vector{{-1e308, -1.0, 1.0}}, "largest M")};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  problems.push_back(smooth(Matrix::Constant(2, 2, nan), Vector{{-1.0, 1.0}}, "NaN"));
  return problems;
}

/// Debian builds these libraries with their assertions, which end the process. That of Siconos on W_NN is not met.
bool ends_itself(const std::string& solver, const Answer& answer) {
  return (solver == "siconos_fc3d" || solver == "simbody_plus") &&
         answer.detail.find("Assertion") != std::string::npos && answer.detail.find("MLocal[0") == std::string::npos;
}

TEST(AdapterHostileTest, EveryProblemGetsAnAnswerOrAReason) {
  const Problem good("good", ball(1, 0.5, 1.0));
  for (const char* name : kSolvers) {
    if (missing(name)) continue;
    const auto solver = open_solver(parse_spec(name));
    TimedAnswer before;
    solver->run(good, {}, before);
    for (const Problem& problem : hostile_problems()) {
      TimedAnswer result;
      solver->run(problem, {.time_limit_s = 1.0}, result);
      const Answer& answer = result.answer;
      if (answer.claim == Claim::kCrashed) {
        EXPECT_TRUE(ends_itself(parse_spec(name).name, answer))
            << name << " on " << problem.name() << ": " << answer.detail;
      }
      if (answer.claim == Claim::kUnsupported) {
        EXPECT_FALSE(answer.detail.empty()) << name << " on " << problem.name();
      }
      TimedAnswer after;
      solver->run(good, {}, after);
      EXPECT_EQ(after.answer.z, before.answer.z) << name << " after " << problem.name();
      EXPECT_EQ(after.answer.claim, before.answer.claim) << name << " after " << problem.name();
    }
  }
}

/// 1 / m overflows, and M with it: libraries said solved, said unsolvable, or ended by an assertion.
TEST(AdapterHostileTest, NoLibraryIsGivenAnInfinity) {
  const Problem light("light", ball(1, 0.5, 1.0, 5e-324));
  for (const char* name : {"ode_step", "ode_quickstep", "bullet_si", "bullet_lemke", "dart_lemke", "dart_dantzig",
                           "siconos_lemke", "siconos_fc3d{cone=true}", "simbody_pgs{cone=true}", "ipopt_mpcc"}) {
    if (missing(name)) continue;
    TimedAnswer result;
    open_solver(parse_spec(name))->run(light, {}, result);
    EXPECT_EQ(result.answer.claim, Claim::kUnsupported) << name << ": " << result.answer.detail;
    EXPECT_NE(result.answer.detail.find("overflows"), std::string::npos) << name << ": " << result.answer.detail;
  }
}

}  // namespace
}  // namespace lcpbench::adapter_hostile_test
