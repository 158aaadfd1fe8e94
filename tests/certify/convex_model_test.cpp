// The convex model of friction in the plane, where its cone has two edges and its optimum is that of contacts without
// friction, which certificates have exactly.
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "study/certify/certificate.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench::convex_model_test {
namespace {

/// Contacts of one tangent each: the other one moves nothing. With mu = 1/2 and r_t = 4 r_n the compliance of the two
/// edges N +- mu T is 2 r_n for each and no more.
struct Planar {
  ContactProblem friction;
  ContactProblem edges;
};

Planar planar(int contacts, bool soft, std::mt19937_64& random) {
  const auto draw = [&] { return static_cast<double>(static_cast<int>(random() % 2001) - 1000) / 1024; };
  const Index size = 4;
  Planar result;
  ContactProblem& friction = result.friction;
  Matrix root = Matrix::NullaryExpr(size, size, draw);
  friction.inertia = DenseInertia{Matrix::Identity(size, size) + root * root.transpose()};
  friction.v = Vector::NullaryExpr(size, draw);
  friction.mu = Vector::Constant(contacts, 0.5);
  friction.edges.assign(static_cast<std::size_t>(contacts), 4);
  const Matrix N = Matrix::NullaryExpr(size, contacts, draw), T = Matrix::NullaryExpr(size, contacts, draw);
  Matrix D = Matrix::Zero(size, 4 * contacts), E(size, 2 * contacts);
  Vector b(2 * contacts), r(2 * contacts);
  friction.b = Vector::NullaryExpr(contacts, draw);
  const auto compliance = [&] { return soft ? std::ldexp(1.0, -static_cast<int>(random() % 20)) : 0.0; };
  friction.compliance_n = Vector::NullaryExpr(contacts, compliance);
  friction.compliance_t = 4 * friction.compliance_n;
  friction.offset_t = Vector::Zero(2 * contacts);
  for (Index c = 0; c < contacts; ++c) {
    friction.offset_t(2 * c) = draw();
    D.col(4 * c) = T.col(c);
    D.col(4 * c + 2) = -T.col(c);
    for (const Index k : {0, 1}) {
      const double sign = k == 0 ? 1 : -1;
      E.col(2 * c + k) = N.col(c) + sign * 0.5 * T.col(c);
      b(2 * c + k) = friction.b(c) + sign * 0.5 * friction.offset_t(2 * c);
      r(2 * c + k) = 2 * friction.compliance_n(c);
    }
  }
  friction.N = N;
  friction.D = D;
  result.edges = friction;
  result.edges.N = E;
  result.edges.D = Matrix(size, 0);
  result.edges.edges.assign(static_cast<std::size_t>(2 * contacts), 0);
  result.edges.mu = Vector::Zero(2 * contacts);
  result.edges.b = b;
  result.edges.compliance_n = r;
  result.edges.compliance_t = result.edges.offset_t = Vector();
  return result;
}

double energy(const Matrix& G, const Vector& x) { return std::sqrt(x.dot(G * x)); }

TEST(ConvexModelTest, ItsOptimumIsWithinTheCertifiedDistanceOfEveryAnswer) {
  std::mt19937_64 random(37);
  const std::unique_ptr<Solver> solver = make_solver(parse_spec("cone_ipm{cone=true,slip=none}"));
  int optima = 0, bounded = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto [friction, edges] = planar(1 + trial % 4, true, random);
    const Certificate truth = Certifier({}).certify(Problem("edges", edges));
    ASSERT_EQ(truth.kind, CertificateKind::kSolution) << trial;
    ASSERT_TRUE(truth.velocity_unique) << trial;
    const Problem problem("friction", friction);
    solver->load(problem);
    Answer answer;
    solver->solve({}, answer);
    ASSERT_EQ(answer.claim, Claim::kSolved) << trial << ": " << answer.detail;
    const Matrix& G = std::get<DenseInertia>(friction.inertia).G;
    for (const double noise : {0.0, 1e-9, 1e-4, 0.3}) {
      Answer moved = answer;
      moved.velocity.resize(0);
      for (double& z : moved.z) z *= 1 + noise * (static_cast<double>(random() % 2001) - 1000) / 1000;
      Errors errors = Evaluator(problem).errors(moved);
      measure_friction(FrictionModel::kConvex, problem, moved, errors);
      const Vector u = post_impact_velocity(friction, moved.z);
      const double distance = energy(G, u - truth.velocity), change = energy(G, u - friction.v);
      ASSERT_FALSE(std::isnan(errors.optimum_distance)) << trial;
      EXPECT_LE(distance, errors.optimum_distance * change + 1e-14 * (change + energy(G, friction.v)))
          << trial << " " << noise;
      if (noise == 0) {
        EXPECT_TRUE(errors.solved) << trial;
        EXPECT_LE(distance, 1e-6 * (change + 1)) << trial;
        ++optima;
        if (change == 0 || errors.optimum_distance < 1e-3) ++bounded;
      }
    }
  }
  EXPECT_EQ(optima, 300);
  EXPECT_GE(bounded, 290);
}

// Without compliance a velocity that enters the ground by a rounding has no bound, and never a wrong one.
TEST(ConvexModelTest, HardContactsHaveABoundOrNone) {
  std::mt19937_64 random(38);
  const std::unique_ptr<Solver> solver = make_solver(parse_spec("cone_ipm{cone=true,slip=none}"));
  for (int trial = 0; trial < 100; ++trial) {
    const auto [friction, edges] = planar(1 + trial % 2, false, random);
    const Certificate truth = Certifier({}).certify(Problem("edges", edges));
    if (truth.kind != CertificateKind::kSolution) continue;
    const Problem problem("friction", friction);
    solver->load(problem);
    Answer answer;
    solver->solve({}, answer);
    if (answer.claim != Claim::kSolved) continue;
    Errors errors = Evaluator(problem).errors(answer);
    measure_friction(FrictionModel::kConvex, problem, answer, errors);
    const Matrix& G = std::get<DenseInertia>(friction.inertia).G;
    const Vector u = post_impact_velocity(friction, answer.z);
    EXPECT_TRUE(errors.solved) << trial;
    EXPECT_LE(energy(G, u - truth.velocity), errors.optimum_distance * energy(G, u - friction.v) + 1e-13) << trial;
  }
}

}  // namespace
}  // namespace lcpbench::convex_model_test
