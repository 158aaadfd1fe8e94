// Inertia whose rank rounding could mistake: what solvers claim, what velocities they return, and what the evaluation
// says, against exact arithmetic.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/exact_inertia.h"
#include "core/registry.h"
#include "core/spec.h"
#include "native/lcpbench.h"
#include "study/certify/certificate.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/friction_model.h"
#include "tests/attack/judge.h"
#include "tests/attack/problems.h"

namespace lcpbench::inertia_claims_test {
namespace {

Matrix matrix(std::initializer_list<std::initializer_list<double>> rows) {
  Matrix A(static_cast<Index>(rows.size()), static_cast<Index>(rows.begin()->size()));
  Index i = 0;
  for (const auto& row : rows) std::copy(row.begin(), row.end(), A.row(i++).begin());
  return A;
}

Problem frictionless(const Vector& v, const Matrix& N, const Inertia& inertia) {
  return Problem("x", ContactProblem{.v = v,
                                     .N = N,
                                     .D = Matrix(N.rows(), 0),
                                     .edges = std::vector<int>(static_cast<std::size_t>(N.cols()), 0),
                                     .mu = Vector::Zero(N.cols()),
                                     .inertia = inertia});
}

Problem light_direction() {
  return frictionless(Vector::Constant(2, -1), matrix({{1}, {1}}),
                      FactoredInertia{matrix({{1, 1}, {0, 1e-14}}), Vector::Ones(2)});
}

Problem nearly_deficient() {
  return frictionless(Eigen::Vector2d(-1, 1), matrix({{1}, {-1}}),
                      FactoredInertia{matrix({{1, 1}, {1, 1 + 0x1p-52}}), Vector::Ones(2)});
}

Problem dependent_integers() {
  return Problem("x", ContactProblem{
                          .v = Eigen::Vector3d(-1, 0, 0),
                          .N = matrix({{1}, {0}, {0}}),
                          .D = Matrix(Matrix::Zero(3, 4)),
                          .edges = {4},
                          .mu = Vector::Zero(1),
                          .inertia = FactoredInertia{matrix({{-1, 1, 0}, {2, -1, 1}, {1, 0, 1}}), Vector::Ones(3)}});
}

Answer solve(const std::string& solver, const Problem& problem) {
  const auto made = make_solver(parse_spec(solver));
  Answer answer;
  made->load(problem);
  made->solve({.time_limit_s = 5}, answer);
  return answer;
}

std::vector<std::string> native_solvers() {
  std::vector<std::string> names{"cone_ipm{cone=true}", "velocity_ipm{finish=false}",
                                 "contact_lemke{precision=quad}"};
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (solver.library == "native") names.push_back(solver.definition.name);
  }
  return names;
}

bool takes(const std::string& solver, const Problem& problem) {
  const auto made = make_solver(parse_spec(solver));
  return why_not(made->capabilities(), problem).empty();
}

/// In each coordinate, relative to |v| + |G*| |J| |f|, v + G* J f without rounding.
double velocity_error(const ContactProblem& contact, const Vector& z, const Vector& returned) {
  const auto response = ExactResponse::of(contact.inertia);
  const ContactLayout layout = contact_layout(contact);
  Matrix J(contact.ngc(), layout.lambda_offset());
  J << to_dense(contact.N), to_dense(contact.D);
  const Vector f = z.head(layout.lambda_offset());
  std::vector<Quad> impulse(static_cast<std::size_t>(contact.ngc()), 0);
  for (Index j = 0; j < J.cols(); ++j) {
    for (Index i = 0; i < J.rows(); ++i) impulse[static_cast<std::size_t>(i)] += Quad{J(i, j)} * f(j);
  }
  for (const auto& block : response->blocks()) block.multiply(impulse.data() + block.first);
  const Matrix Gstar = inverse_inertia(contact.inertia).cwiseAbs();
  const Vector scale = contact.v.cwiseAbs() + Gstar * (J.cwiseAbs() * f.cwiseAbs());
  double worst = 0;
  for (Index i = 0; i < contact.ngc(); ++i) {
    const double error = std::abs(to_double(returned(i) - contact.v(i) - impulse[static_cast<std::size_t>(i)]));
    if (error > 0) worst = std::max(worst, error / scale(i));
  }
  return worst;
}

void expect_truth(const std::string& solver, const Problem& problem, const attack::Judge& judge, Evaluator& evaluator,
                  bool resolvable) {
  if (!takes(solver, problem)) return;
  const Answer answer = solve(solver, problem);
  if (answer.z.size() != problem.size() || !answer.z.allFinite()) return;
  SCOPED_TRACE(solver);
  Errors errors = evaluator.errors(answer);
  if (errors.unresolved && !resolvable) return;
  EXPECT_FALSE(errors.unresolved);
  const bool solves = judge.solves(answer.z);
  EXPECT_EQ(errors.solved, solves) << errors.velocity_residual_relative << " " << judge.measure();
  if (answer.claim != Claim::kSolved) return;
  if (solver.find("cone=true") != std::string::npos) {
    measure_friction(FrictionModel::kCone, problem, answer, errors);
    EXPECT_TRUE(errors.solved || !errors.usable) << errors.velocity_residual_relative;
  } else {
    EXPECT_TRUE(solves) << judge.measure();
  }
  if (answer.velocity.size() > 0) {
    EXPECT_LE(velocity_error(*problem.contact(), answer.z, answer.velocity), 1e-4);
  }
  EXPECT_LE(velocity_error(*problem.contact(), answer.z, post_impact_velocity(*problem.contact(), answer.z)), 1e-4);
}

/// @param resolvable  113 bits have to tell what G* is
void expect_truth_of_all(const Problem& problem, bool resolvable = true) {
  const attack::Judge judge(problem);
  Evaluator evaluator(problem);
  for (const std::string& solver : native_solvers()) expect_truth(solver, problem, judge, evaluator, resolvable);
}

TEST(InertiaClaimsTest, AnswersToInertiaThatRoundingMistakes) {
  for (const Problem& problem : {light_direction(), nearly_deficient(), dependent_integers()}) {
    expect_truth_of_all(problem);
  }
}

// The first contact presses by rounding alone, which moves the slow coordinate by less than the rounding of the fast
// one, where velocity_ipm ends in active_set.
TEST(InertiaClaimsTest, TheReturnedVelocityOfASlowCoordinateTakesNoRoundingOfAFastOne) {
  const Problem problem = frictionless(
      Eigen::Vector2d(0, 0.8714370727539062),
      matrix({{-0.2622098922729492, 0.5557308197021484}, {-6.776263578034403e-21, 0.21611881256103516}}),
      DenseInertia{matrix({{0.9982959530121305, 0.04120455065838426}, {0.04120455065838426, 0.003657171987869405}})});
  const auto solver = make_solver(parse_spec("velocity_ipm"));
  solver->load(problem);
  Answer answer;
  solver->solve({}, answer);
  ASSERT_EQ(answer.claim, Claim::kSolved);
  ASSERT_EQ(answer.velocity.size(), 2);
  const double slow = post_impact_velocity(*problem.contact(), answer.z)(0);
  EXPECT_NEAR(answer.velocity(0), slow, 1e-4 * std::abs(slow));  // what the verdict allows
}

// A caller's mistake, which a problem file is refused for. contact_lemke takes these blocks in two ranges.
TEST(InertiaClaimsTest, NothingIsClaimedOfNegativeBlocks) {
  BlockInertia inertia;
  for (int body = 0; body < 24; ++body) inertia.blocks.emplace_back(Eigen::Vector3d(-10, -20, -30).asDiagonal());
  const Problem problem = frictionless(Vector::Constant(72, -1), Matrix::Identity(72, 72), inertia);
  for (const char* name : {"contact_lemke", "contact_lemke{precision=quad}"}) {
    const Answer answer = solve(name, problem);
    EXPECT_EQ(answer.claim, Claim::kNumericalFailure) << name << ": " << answer.detail;
  }
}

TEST(InertiaClaimsTest, DependentIntegersAreSolvedWithTheirVelocity) {
  const Answer answer = solve("contact_lemke", dependent_integers());
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_LE(post_impact_velocity(*dependent_integers().contact(), answer.z).cwiseAbs().maxCoeff(), 1);
}

/// Of the attack's contacts: most have a G whose condition, scaled to unit diagonal, is 1e11 and more; others a
/// coordinate that nothing moves, or a G* near or beyond the range of double, or impulses that are clipped.
constexpr std::pair<std::uint64_t, std::uint64_t> kDoubtfulVelocities[] = {
    {1, 152}, {1, 377}, {1, 497}, {1, 917}, {1, 948}, {1, 1232}, {1, 1784}, {1, 2987}, {15, 332}, {15, 392}, {1, 418},
    {77, 908}, {77, 1638}, {77, 1796}, {77, 1863}, {77001, 3854}, {31, 395}, {31, 1087}, {31, 1621}, {31, 11967},
    {990123, 69}};

TEST(InertiaClaimsTest, ReturnedVelocitiesAreThoseOfTheImpulses) {
  for (const auto& [seed, index] : kDoubtfulVelocities) {
    SCOPED_TRACE(index);
    const Problem problem = attack::generate(attack::Family::kContact, seed, index);
    expect_truth_of_all(problem);
    const attack::Judge judge(problem);
    for (const char* name : {"active_set", "auto", "contact_lemke", "cone_ipm", "friction_ipm", "proximal_newton",
                             "velocity_ipm"}) {
      if (!takes(name, problem)) continue;
      ContactSolver solver(name);
      solver.load(*problem.contact());
      if (solver.solve(5) != Claim::kSolved) continue;
      EXPECT_TRUE(judge.velocity_holds(solver.answer().z, solver.velocity())) << name;
    }
  }
}

/// Three coordinates, of which no contact moves the last one. Negative: the contacts separate.
Problem slow(double speed, double mass, double offset, const char* form) {
  const Matrix G = mass * matrix({{1, 0.25, 0}, {0.25, 2, 0}, {0, 0, 1}});
  Inertia inertia = DenseInertia{G};
  if (form == std::string_view("inverse")) inertia = InverseInertia{matrix({{1, 0, 0}, {0, 2, 0}, {0, 0, 1}}) / mass};
  if (form == std::string_view("factors")) inertia = FactoredInertia{Matrix::Identity(3, 3), Vector::Constant(3, mass)};
  const Matrix N = matrix({{1.2327268178758686, 3, 1}, {-0.9725421472827654, 3, 0}, {0, 0, 0}});
  const Vector v = speed * (speed < 0 ? Eigen::Vector3d(-1, -0.5, -1) : Eigen::Vector3d(-1, 2, 1));
  Problem problem = frictionless(v, N, inertia);
  ContactProblem contact = *problem.contact();
  if (offset != 0) contact.b = Vector::Constant(3, offset);
  return Problem("slow", std::move(contact));
}

/// Where velocities underflow in the metric of the inertia, impulses vanish before the velocities that they make.
TEST(InertiaClaimsTest, ReturnedVelocitiesNearTheLeastDoubleAreThoseOfTheImpulses) {
  std::vector<std::string> solvers = native_solvers();
  solvers.insert(solvers.end(), {"active_set{precision=double}", "active_set{precision=quad}"});
  int returned = 0;
  for (const double speed : {0.0, 1e-322, 6e-320, -6e-320, 1e-310, 1e-300, 1e-200, 1e-60, -1e-60, 1.0}) {
    for (const double mass : {1e-55, 1e-4, 1.0, 1e20}) {
      for (const double offset : {0.0, -1e-320, -1e-305, -1e-45}) {
        for (const char* form : {"dense", "inverse", "factors"}) {
          const Problem problem = slow(speed, mass, offset, form);
          const attack::Judge judge(problem);
          for (const std::string& name : solvers) {
            const auto solver = make_solver(parse_spec(name));
            if (!why_not(solver->capabilities(), problem).empty()) continue;
            solver->load(problem);
            const Vector start = Eigen::Vector3d(1e6, 0, 1);
            for (const Vector* from : {static_cast<const Vector*>(nullptr), &start}) {
              Answer answer;
              solver->solve({.start = from, .time_limit_s = 5}, answer);
              if (answer.claim != Claim::kSolved || answer.velocity.size() == 0) continue;
              EXPECT_TRUE(judge.velocity_holds(answer.z, answer.velocity))
                  << name << ", " << speed << " m/s, " << mass << " kg, b = " << offset << ", " << form
                  << (from != nullptr ? ", start" : "") << ": z " << answer.z.transpose() << ", velocity "
                  << answer.velocity.transpose();
              ++returned;
            }
          }
        }
      }
    }
  }
  EXPECT_GT(returned, 1000);
}

// The contact stops a body of 2^-26 kg by three times the least impulse that is a double. Three quarters of that are
// none, so that the velocity that an engine moves on with may not be made of them.
TEST(InertiaClaimsTest, AVelocityThatTheSolverLeavesOutLosesNothingToUnderflow) {
  const Problem problem =
      frictionless(Vector::Constant(1, -9 * 0x1p-1050), matrix({{0.75}}), DenseInertia{matrix({{0x1p-26}})});
  const attack::Judge judge(problem);
  int solved = 0;
  for (const std::string& name : native_solvers()) {
    ContactSolver solver(name);
    solver.load(*problem.contact());
    if (solver.solve(5) != Claim::kSolved) continue;
    ++solved;
    EXPECT_TRUE(judge.velocity_holds(solver.answer().z, solver.velocity())) << name << ": " << solver.velocity();
  }
  EXPECT_GE(solved, 3);
}

TEST(InertiaClaimsTest, WellConditionedInertiaGetsItsVelocity) {
  const Matrix G = matrix({{2, 1, 0}, {1, 3, 1}, {0, 1, 4}});
  const Problem problem = frictionless(Vector::Constant(3, -1), matrix({{1, 0}, {0, 1}, {1, 1}}), DenseInertia{G});
  for (const char* name : {"active_set", "auto", "velocity_ipm"}) {
    EXPECT_EQ(solve(name, problem).velocity.size(), 3) << name;
  }
}

TEST(InertiaClaimsTest, TheJudgeAgreesWithTheCertificate) {
  const Problem problem = nearly_deficient();
  const Certificate certificate = Certifier({}).certify(problem);
  ASSERT_EQ(certificate.kind, CertificateKind::kSolution);
  Evaluator evaluator(problem);
  Answer answer;
  answer.z = certificate.z;
  EXPECT_TRUE(evaluator.errors(answer).solved);
  answer.z = Vector::Constant(1, 3.2e32);
  EXPECT_EQ(evaluator.errors(answer).solved, attack::Judge(problem).solves(answer.z));
}

TEST(InertiaClaimsTest, AcceptSettingsDoNotReplaceTheTest) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> entry(-1, 1);
  const auto draw = [&](Index rows, Index cols) {
    return Matrix(Matrix::NullaryExpr(rows, cols, [&] { return entry(random); }));
  };
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix X = draw(6, 8);
    const Problem problem = frictionless(draw(6, 1).col(0), draw(6, 5), DenseInertia{Matrix(X * X.transpose())});
    Evaluator evaluator(problem);
    for (const char* solver :
         {"active_set{accept_residual=1e9}", "velocity_ipm{accept_residual=1e9,finish=false,tolerance=1e9}",
          "cone_ipm{accept_residual=1e9,tolerance=1e9}",
          "friction_ipm{accept_residual=1e9,tolerance=1e9}",
          "proximal_newton{accept_residual=1e9,tolerance=1e9}", "primal_dual{accept_residual=1e9}"}) {
      const Answer answer = solve(solver, problem);
      if (answer.claim != Claim::kSolved) continue;
      EXPECT_TRUE(evaluator.errors(answer).solved)
          << solver << " " << evaluator.errors(answer).velocity_residual_relative << " z " << answer.z.transpose();
    }
  }
}

/// Contacts on inertia of every kind that was mistaken.
class DoubtfulProblems {
 public:
  explicit DoubtfulProblems(std::uint64_t seed) : random_(seed) {}

  Problem next() {
    const Index ngc = integer(1, 5);
    const Index nc = integer(1, 4);
    const int edges = chance(2) ? 0 : 4;
    ContactProblem contact;
    contact.v = numbers(ngc, 1);
    contact.N = numbers(ngc, nc);
    contact.edges.assign(static_cast<std::size_t>(nc), edges);
    contact.mu = edges == 0 ? Vector(Vector::Zero(nc)) : Vector(numbers(nc, 1).cwiseAbs());
    Matrix D(ngc, nc * edges);
    for (Index c = 0; c < nc && edges > 0; ++c) {
      D.middleCols(edges * c, 2) = numbers(ngc, 2);
      D.middleCols(edges * c + 2, 2) = -D.middleCols(edges * c, 2);
    }
    contact.D = D;
    contact.inertia = inertia(ngc);
    return Problem("x", std::move(contact));
  }
  std::int64_t kind() const { return kind_; }

 private:
  std::int64_t integer(std::int64_t low, std::int64_t high) {
    return std::uniform_int_distribution<std::int64_t>(low, high)(random_);
  }
  bool chance(int of) { return integer(1, of) == 1; }
  Matrix numbers(Index rows, Index cols) {
    const bool integers = chance(3);
    return Matrix::NullaryExpr(rows, cols, [&] {
      return integers ? static_cast<double>(integer(-2, 2)) : std::uniform_real_distribution<double>(-1, 1)(random_);
    });
  }

  Inertia inertia(Index ngc) {
    FactoredInertia factors{numbers(ngc, integer(1, ngc + 2)), {}};
    const Index count = factors.X.cols();
    factors.alpha = Vector::NullaryExpr(count, [&] { return std::ldexp(1.0, static_cast<int>(integer(-3, 3))); });
    const auto row = [&] { return factors.X.row(integer(0, ngc - 1)); };
    switch (kind_ = integer(0, 6)) {
      case 0: row() *= std::pow(10.0, static_cast<double>(-integer(10, 20))); break;
      case 1:
        factors.X.col(count - 1) = factors.X.col(0) * (1 + static_cast<double>(integer(-3, 3)) * 0x1p-52);
        if (chance(2)) factors.X(integer(0, ngc - 1), 0) *= 1 + 0x1p-52;
        break;
      case 2: row() = row().eval(); break;
      case 3: row() *= std::ldexp(1.0, chance(2) ? 140 : -140); break;
      case 4: factors.alpha(0) *= std::ldexp(1.0, chance(2) ? 140 : -140); break;
      case 5: {
        Matrix Ginv = factors.X * factors.X.transpose();
        const Index i = integer(0, ngc - 1);
        const double unit = std::ldexp(1.0, chance(2) ? 140 : chance(2) ? -140 : 0);
        Ginv.row(i) *= unit;
        Ginv.col(i) *= unit;
        return InverseInertia{Matrix(Ginv.selfadjointView<Eigen::Lower>())};
      }
      default: {
        const Matrix G = factors.X * factors.X.transpose();
        return DenseInertia{Matrix(G.selfadjointView<Eigen::Lower>()) +
                            std::pow(10.0, static_cast<double>(-integer(8, 15))) * Matrix::Identity(ngc, ngc)};
      }
    }
    return factors;
  }

  std::mt19937_64 random_;
  std::int64_t kind_ = 0;
};

TEST(InertiaClaimsTest, RandomInertiaOfDoubtfulRank) {
  const char* const count = std::getenv("LCPBENCH_INERTIA_PROBLEMS");
  const char* const seed = std::getenv("LCPBENCH_INERTIA_SEED");
  DoubtfulProblems problems(seed != nullptr ? std::strtoull(seed, nullptr, 10) : 1);
  const int most = count != nullptr ? std::atoi(count) : 60;
  for (int trial = 0; trial < most; ++trial) {
    const Problem problem = problems.next();
    SCOPED_TRACE(::testing::Message() << "problem " << trial << " of kind " << problems.kind());
    if (!ExactResponse::of(problem.contact()->inertia)) continue;  // indefinite by rounding
    const bool is_of_far_scales = problems.kind() == 3 || problems.kind() == 4;  // 2^140 apart
    expect_truth_of_all(problem, !is_of_far_scales);
  }
}

}  // namespace
}  // namespace lcpbench::inertia_claims_test
