// Claims on contacts where the inertia is nearly singular, or where several islands differ in scale: what is said to be
// solved is solved, island by island, and who can solves it.
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "core/spec.h"
#include "generators/sets.h"
#include "native/proofs/doubtful_inertia.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/two_chains.h"

namespace lcpbench::contact_claims_test {
namespace {

constexpr double kTimeLimit_s = 600;
const std::vector<std::string> kOnContacts{"auto", "active_set", "contact_lemke", "velocity_ipm", "friction_ipm",
                                           "proximal_newton", "psor", "quickstep_sor", "primal_dual"};

Answer solve(const std::string& solver, const Problem& problem) {
  const auto made = make_solver(parse_spec(solver));
  Answer answer;
  made->load(problem);
  made->solve({.time_limit_s = kTimeLimit_s}, answer);
  return answer;
}

Problem contacts(const Vector& v, const Matrix& N, Inertia inertia) {
  ContactProblem contact;
  contact.v = v;
  contact.N = N;
  contact.D = Matrix(v.size(), 0);
  contact.edges.assign(static_cast<std::size_t>(N.cols()), 0);
  contact.mu = Vector::Zero(N.cols());
  contact.inertia = std::move(inertia);
  return {"contacts", std::move(contact)};
}

Problem with_friction(const Problem& problem, const Vector& direction, double mu) {
  ContactProblem contact = *problem.contact();
  Matrix D(direction.size(), 2);
  D << direction, -direction;
  contact.D = D;
  contact.edges = {2};
  contact.mu = Vector::Constant(1, mu);
  return {"friction", std::move(contact)};
}

void expect_honest(const std::string& solver, const Problem& problem) {
  const Answer answer = solve(solver, problem);
  EXPECT_NE(answer.claim, Claim::kUnsolvable) << solver;
  if (answer.claim != Claim::kSolved) return;
  EXPECT_LE(Evaluator(problem).errors(answer).velocity_residual_relative, kSolvedVelocityResidual) << solver;
}

void expect_solved(const std::string& solver, const Problem& problem) {
  const Answer answer = solve(solver, problem);
  EXPECT_EQ(answer.claim, Claim::kSolved) << solver << ": " << answer.detail;
  EXPECT_LE(Evaluator(problem).errors(answer).velocity_residual_relative, kSolvedVelocityResidual) << solver;
}

/// G = [81 54; 54 36] but for 1e-13 on the diagonal: condition 1e15.
Matrix nearly_singular() { return Matrix{{81.0000000000001, 54}, {54, 36.0000000000001}}; }

TEST(ContactClaimsTest, HoldWhereTheInertiaIsNearlySingular) {
  const Problem problem = contacts(Vector{{-0.6, 0.5}}, Matrix{{-1, -4}}.transpose(), DenseInertia{nearly_singular()});
  for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
  for (const char* solver : {"auto", "active_set", "velocity_ipm", "contact_lemke"}) expect_solved(solver, problem);
}

TEST(ContactClaimsTest, HoldWithFrictionWhereTheInertiaIsNearlySingular) {
  const Matrix G{{81.00000000000001, 81}, {81, 81.00000000000001}};
  const Problem normal = contacts(Vector{{-0.6, -0.6}}, Matrix{{3, 3}}.transpose(), DenseInertia{G});
  const Problem problem = with_friction(normal, Vector{{1, -2}}, 0.5);
  for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
}

/// Beside a nearly singular block, a mass too small for its inverse to be a double.
TEST(ContactClaimsTest, HoldWhereALightCoordinateIsNoneToDouble) {
  const Matrix G{{5e-324, 0, 0}, {0, 36.00000000001092, 30}, {0, 30, 25}};
  const Vector v{{0.14597034454345703, 0.37563133239746094, -3}};
  const Problem problem = contacts(v, Matrix{{4, 3, 4}}.transpose(), DenseInertia{G});
  for (const char* solver : {"auto", "active_set", "velocity_ipm", "contact_lemke"}) {
    EXPECT_NE(solve(solver, problem).claim, Claim::kSolved) << solver;
  }
}

TEST(ContactClaimsTest, HoldOnTheTrialAt1e12WhereTheyDidNot) {
  const Problem problem = open_set("paper/monotone/exp2{condition=1e12,redundancy=combination}")->generate(881, 7637);
  for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
  for (const char* solver : {"auto", "active_set", "velocity_ipm", "contact_lemke"}) expect_solved(solver, problem);
}

/// C'C with the upper triangle C of Kahan: its pivots hide how near to singular it is.
Matrix kahan(Index n, double cosine) {
  Matrix C = Matrix::Zero(n, n);
  double size = 1;
  for (Index i = 0; i < n; ++i, size *= std::sqrt(1 - cosine * cosine)) {
    C(i, i) = size;
    for (Index j = i + 1; j < n; ++j) C(i, j) = -cosine * size;
  }
  return C.transpose() * C;
}

TEST(ContactClaimsTest, AreNotMisledByPivotsThatHideTheCondition) {
  for (const double cosine : {0.2, 0.4, 0.6}) {
    for (const Index n : {8, 16, 24}) {
      Matrix N(n, 3);
      Vector v(n);
      for (Index i = 0; i < n; ++i) {
        const auto k = static_cast<double>(i);
        N.row(i) << std::sin(1.0 + k), std::cos(2.0 * k), std::sin(3.0 + k * k);
        v(i) = std::cos(5.0 + 3 * k);
      }
      const Problem problem = contacts(v, N, DenseInertia{kahan(n, cosine)});
      for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
    }
  }
}

TEST(ContactClaimsTest, HoldWhereOneBodyIsNearlySingular) {
  const BlockInertia bodies{{nearly_singular(), Matrix::Identity(2, 2)}};
  const Matrix N = Matrix{{-1, -4, 0, 0}, {0, -1, 1, 0}}.transpose();
  for (const bool sparse : {false, true}) {
    Problem problem = contacts(Vector{{-0.6, 0.5, -1, 1}}, N, bodies);
    if (sparse) {
      ContactProblem contact = *problem.contact();
      contact.N = SparseMatrix(N.sparseView());
      problem = Problem("bodies", std::move(contact));
    }
    for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
    expect_solved("auto", problem);
  }
}

/// A contact at 1e10 m/s on one body beside the given ones.
Problem beside_a_fast_one(const Problem& problem, bool blocks) {
  const ContactProblem& slow = *problem.contact();
  const Index n = slow.ngc(), nc = slow.nc();
  ContactProblem contact;
  contact.v.resize(n + 1);
  contact.v << slow.v, -1e10;
  Matrix N = Matrix::Zero(n + 1, nc + 1);
  N.topLeftCorner(n, nc) = std::get<Matrix>(slow.N);
  N(n, nc) = 1;
  contact.N = N;
  contact.D = Matrix(n + 1, 0);
  contact.edges.assign(static_cast<std::size_t>(nc + 1), 0);
  contact.mu = Vector::Zero(nc + 1);
  Matrix G = Matrix::Identity(n + 1, n + 1);
  G.topLeftCorner(n, n) = std::get<DenseInertia>(slow.inertia).G;
  if (blocks) {
    contact.inertia = BlockInertia{{G.topLeftCorner(n, n), Matrix::Identity(1, 1)}};
  } else {
    contact.inertia = DenseInertia{G};
  }
  return {"islands", std::move(contact)};
}

void expect_first_island_honest(const std::string& solver, const Problem& first, const Problem& whole) {
  const Answer answer = solve(solver, whole);
  if (answer.claim != Claim::kSolved) return;
  Answer part;
  part.claim = Claim::kSolved;
  part.z = answer.z.head(first.size());
  EXPECT_LE(Evaluator(first).errors(part).velocity_residual_relative, kSolvedVelocityResidual) << solver;
}

TEST(ContactClaimsTest, AreMadeOfEveryIslandByItsOwnScale) {
  const Matrix G{{2, 1}, {1, 3}};
  const Matrix N{{1, 1, 3}, {1, 0.98, 1}};
  const Problem slow = contacts(Vector{{-1e-6, 3e-7}}, N, DenseInertia{G});
  for (const bool blocks : {false, true}) {
    const Problem whole = beside_a_fast_one(slow, blocks);
    for (const std::string& solver : kOnContacts) expect_first_island_honest(solver, slow, whole);
    for (const char* solver : {"auto", "active_set", "contact_lemke"}) {
      EXPECT_EQ(solve(solver, whole).claim, Claim::kSolved) << solver;
    }
  }
}

/// Claimed solved, solved, and at the velocity that comes with it.
void expect_solved_with_velocity(const std::string& solver, const Problem& problem) {
  const Answer answer = solve(solver, problem);
  EXPECT_EQ(answer.claim, Claim::kSolved) << solver << ": " << answer.detail;
  const Errors errors = Evaluator(problem).errors(answer);
  EXPECT_LE(errors.velocity_residual_relative, kSolvedVelocityResidual) << solver;
  if (answer.velocity.size() > 0) {
    EXPECT_LE(errors.velocity_mismatch, 1e-9) << solver;
  }
}

TEST(ContactClaimsTest, AreMadeByIterationsOnIslandsThatDifferInScaleAndInSweeps) {
  using testing::Storage;
  for (const Storage storage : {Storage::kDense, Storage::kBlocks, Storage::kSparse}) {
    for (const auto& [fast, slow] : {std::pair(1e10, 1e-4), std::pair(1e-9, 1e8), std::pair(1.0, 1.0)}) {
      const Problem problem = testing::two_chains(fast, slow, storage);
      for (const char* solver : {"psor", "quickstep_sor", "velocity_ipm", "friction_ipm", "proximal_newton"}) {
        expect_solved_with_velocity(solver, problem);
      }
    }
  }
}

TEST(ContactClaimsTest, AreMadeByIterationsOnSlidersThatDifferInScale) {
  ContactProblem contact;
  contact.v = Vector{{1e6, -1e6, 1e-3, -2e-3}};
  contact.N = Matrix{{0, 0}, {1, 0}, {0, 0}, {0, 1}};
  contact.D = Matrix{{1, -1, 0, 0}, {0, 0, 0, 0}, {0, 0, 1, -1}, {0, 0, 0, 0}};
  contact.edges = {2, 2};
  contact.mu = Vector{{0.5, 0.25}};
  contact.inertia = DenseInertia{Matrix::Identity(4, 4)};
  const Problem problem("sliders", std::move(contact));
  for (const char* solver : {"psor", "quickstep_sor", "friction_ipm", "proximal_newton"}) {
    expect_solved_with_velocity(solver, problem);
  }
}

TEST(ContactClaimsTest, AreMadeOfIslandsAtRest) {
  const Problem rest =
      contacts(Vector::Zero(2), Matrix{{1, 2}, {1, -1}}.transpose(), DenseInertia{Matrix{{2, 1}, {1, 3}}});
  for (const bool blocks : {false, true}) {
    const Problem whole = beside_a_fast_one(rest, blocks);
    for (const std::string& solver : kOnContacts) {
      const Answer answer = solve(solver, whole);
      if (answer.claim != Claim::kSolved) continue;
      EXPECT_EQ(answer.z.head(2), Vector::Zero(2)) << solver;
    }
  }
}

// The inertia couples all coordinates, but the soft contact moves none of them: it is an island of its own.
TEST(ContactClaimsTest, AreMadeBesideASoftContactThatMovesNothing) {
  const Matrix G{{2, 1}, {1, 2}};
  for (const Inertia& inertia : {Inertia(DenseInertia{G}), Inertia(BlockInertia{{G}})}) {
    const Problem rigid = contacts(Vector{{-1e-6, -2e-6}}, Matrix{{1, 1, 0}, {0.9, 1.1, 0}}, inertia);
    ContactProblem contact = *rigid.contact();
    contact.b = Vector{{0, 0, -1e8}};
    contact.compliance_n = Vector{{0, 0, 1}};
    const Problem problem("soft contact apart", std::move(contact));
    for (const std::string& solver : kOnContacts) {
      if (solver != "primal_dual") expect_solved(solver, problem);
    }
  }
}

// Diagonal inertia is benign however much its masses differ.
TEST(ContactClaimsTest, AreMadeOfMassesOfAnySize) {
  for (const double mass : {1e-9, 1e-6, 1e6, 1e9}) {
    const Problem problem = contacts(Vector{{-1, 0.5}}, Matrix{{1, 1}, {1, -2}}.transpose(),
                                     DenseInertia{Vector{{1, mass}}.asDiagonal().toDenseMatrix()});
    for (const char* solver : {"auto", "active_set", "contact_lemke"}) expect_solved(solver, problem);
  }
}

// What impulses cancel, and what velocity is but the rounding of N'v, counts by that rounding.
TEST(ContactClaimsTest, AreMadeWhereAllOfQIsRounding) {
  const Problem problem =
      contacts(Vector{{0.1, 0.7}}, Matrix{{0.7, -0.1}}.transpose(), DenseInertia{Matrix::Identity(2, 2)});
  for (const char* solver : {"auto", "active_set", "contact_lemke", "psor", "quickstep_sor"}) {
    EXPECT_EQ(solve(solver, problem).claim, Claim::kSolved) << solver;
  }
}

/// Contacts on a given G* that moves the second coordinate alone.
Problem on_a_rail(double v, const Matrix& N) {
  return contacts(Vector{{v, 0.5}}, N, InverseInertia{Matrix{{0, 0}, {0, 4}}});
}

// A miss by less than the sure residual may be claimed as solved. What has a solution is never claimed as unsolvable.
TEST(ContactClaimsTest, AreNeverUnsolvableWhereAnUlpDecides) {
  Matrix N{{1, -1}, {1, -1}};
  const Matrix solvable = N;
  N(0, 1) = -1 - 0x1p-20;  // asks for 1 + u and -(1 + 2^-20) - u, both at least 0
  const Problem missed = on_a_rail(1, N);
  N(0, 1) = -1 + 0x1p-52;
  for (const std::string& solver : kOnContacts) {
    EXPECT_NE(solve(solver, missed).claim, Claim::kSolved) << solver;
    EXPECT_NE(solve(solver, on_a_rail(1, solvable)).claim, Claim::kUnsolvable) << solver;
    EXPECT_NE(solve(solver, on_a_rail(1, N)).claim, Claim::kUnsolvable) << solver;
  }
  EXPECT_EQ(solve("auto", missed).claim, Claim::kUnsolvable);
  EXPECT_EQ(solve("auto", on_a_rail(1, solvable)).claim, Claim::kSolved);
}

/// Contacts on an inertia of one factor. No impulse moves across it.
Problem on_a_factor(const Vector& v, const Matrix& N, const Vector& X, double alpha) {
  return contacts(v, N, FactoredInertia{X, Vector::Constant(1, alpha)});
}

/// Of contacts on inertia that may be singular, which miss a solution by less than any test tells: what is claimed as
/// solved leaves no more than `most`.
void expect_right(const Problem& problem, double most = kSureResidual) {
  Evaluator evaluator(problem);
  for (const char* name : {"auto", "active_set", "contact_lemke", "velocity_ipm", "friction_ipm", "proximal_newton",
                           "psor", "quickstep_sor", "primal_dual", "lemke", "murty", "principal_pivoting", "regularized"}) {
    const Answer once = solve(name, problem);
    if (once.claim == Claim::kUnsupported) continue;
    const auto is_right = [&](const Answer& answer) {
      return answer.claim != Claim::kSolved || evaluator.errors(answer).velocity_residual_relative <= most;
    };
    EXPECT_TRUE(is_right(once)) << name;
    const auto updated = make_solver(parse_spec(name));
    updated->load(problem);
    updated->update(2 * problem.contact()->v);
    updated->update(problem.contact()->v);
    Answer answer;
    updated->solve({.time_limit_s = kTimeLimit_s}, answer);
    EXPECT_TRUE(is_right(answer)) << name << ", updated";
  }
}

// N'v is zero in double, and less than zero for a combination of the contacts that nothing moves.
TEST(ContactClaimsTest, AreRightWhereAllOfQIsRoundedToZero) {
  Matrix N(4, 4);
  N << -0.206949278270534, -0.7218730161659505, 0.3609365080829752, 0,  //
      0.48507626210458354, 1.6920255403751174, -0.8460127701875587, 0,  //
      0, -2, 2, 1,                                                      //
      -2, -2, 1, 0;
  const Vector v{{-0.5122222900390625, -0.21853065490722656, 0, 0}};
  constexpr double kOfVerdict = 1e-4;  // of a q that is rounding, for which solvers in double see zero
  expect_right(on_a_factor(v, N, Vector{{2, -3, 0, -1}}, 0x1p-18), kOfVerdict);
}

// A cone misses by an ulp at a speed of 1e-16, beside contacts that are fast or that nothing moves.
TEST(ContactClaimsTest, AreRightAmongSlowContacts) {
  Matrix N(2, 4);
  N << -0.5307928919926166, 0, 0.2653964459963083, 0, -1.8475015668481767, 1, 0.9237507834240883, 0;
  ContactProblem contact = *on_a_factor(Vector{{-0.8270587921142578, 0x1p-52}}, N, Vector{{-2, 0}}, 1).contact();
  Matrix D(2, 4);
  D << -0.6070421085685282, 0.6070421085685282, 0, 0, -2.112898012844485, 2.112898012844485, 0, 0;
  contact.D = D;
  contact.edges = {0, 0, 2, 2};
  contact.mu = Vector{{0, 0, 1, 0.875}};
  expect_right(Problem("slow", std::move(contact)));
}

// The path in 113 bits ends in impulses of 1e19 that miss a solution by 1e-13.
TEST(ContactClaimsTest, AreRightAtTheEndOfAPathThatMissesASolution) {
  Matrix N(5, 3);
  N << -0.021118469699802477, -0.05630795289441292, -0.042236939399604975,  //
      -0.0818400456941283, 0.7817907498352176, -0.16368009138825668,        //
      0, 0, 0,                                                              //
      -0.9622047759175776, 0.10077300711266628, -1.9244095518351556,        //
      -1.0284155204735224, -2.0757640023655823, -2.056831040947045;
  const Vector first{{1.1930230151426098, -1.2519811992136272, 0, -0.34544870978260256, 2.259718129041193}};
  const Vector third{{2.3860460302852196, -2.5039623984272543, 0, -0.6908974195652055, 4.519436258082387}};
  const Vector v{{0.5160913467407227, 2, 0, -0.9236364364624023, 0.6944160461425781}};
  ContactProblem contact = *on_a_factor(v, N, Vector{{-3, 0, -2, 3, -3}}, 0x1p-8).contact();
  Matrix D(5, 6);
  D << first, -first, Vector::Zero(5), Vector::Zero(5), third, -third;
  contact.D = D;
  contact.edges = {2, 2, 2};
  contact.mu = Vector{{0.375, 0x1p29, 0x1p31}};
  expect_right(Problem("path", std::move(contact)));
}

TEST(ContactClaimsTest, DoNotTakeNearlyDependentContactsForDependent) {
  Matrix Ginv(3, 3);
  Ginv << 0.00013063625986879058, 0.0001217693957426069, 0, 0.0001217693957426069, 0.00011350436513123717, 0, 0, 0,
      0.0001220703125;
  Matrix N = Matrix::Zero(3, 5);
  N.topLeftCorner(2, 3) << -4, -1, 4, 0, -3, 2;
  Vector v(3);
  v << 4.33800810183022e-19, -7.022928836697716e-20, -0.0;
  const Problem problem = contacts(v, N, InverseInertia{Ginv});
  for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
}

/// No impulse moves v along (-20, 9, 15, -21), and no normals add up to that: there is a solution.
TEST(ContactClaimsTest, DoNotTakeTheRoundingOfContactsAtRestForAProof) {
  const Matrix N = Matrix{{1, 0, 0, 0, 0, 0, 1, 0},  //
                          {1, 0, 1, -1, -2, 3, 0, 0},
                          {0, -1, 0, 0, 2, 0, 0, 0},
                          {0, 2, 0, 0, 0, 0, 1, 1}};
  const Matrix X{{-3, 3, 0}, {2, 3, -3}, {-1, -2, -1}, {3, -3, -2}};
  const Vector v{{-0.9696493148803711, -2, -0.03176307678222656, 1}};
  const Problem problem = contacts(v, N, FactoredInertia{X, Vector{{0x1p-10, 0x1p-14, 1}}});
  for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
  for (const char* solver : {"lemke", "principal_pivoting"}) expect_honest(solver, problem);
}

/// Proofs are exact, or they are not given.
void expect_no_false_proof(const std::string& solver, const Problem& problem) {
  const Answer answer = solve(solver, problem);
  if (answer.farkas.size() == 0) return;
  EXPECT_EQ(answer.claim, Claim::kUnsolvable) << solver;
  EXPECT_TRUE(Evaluator(problem).check_farkas(answer.farkas)) << solver;
}

// X'N is 2^-104 for the first normal, which an enormous impulse can move: it proves nothing, and in double it is zero.
TEST(ContactClaimsTest, DoNotTakeAProductOfTwoUlpsForNothing) {
  const double ulp = 0x1p-52;
  const Inertia inertia = FactoredInertia{Matrix{{1 + ulp}, {1}, {0}}, Vector::Ones(1)};
  const Vector v{{0, 0, -1}};
  const Vector normal{{-(1 - ulp), 1, 0.5}};
  const Problem alone = contacts(v, normal, inertia);
  for (const std::string& solver : kOnContacts) EXPECT_NE(solve(solver, alone).claim, Claim::kUnsolvable) << solver;
}

// To 113 bits the first normal is one that nothing moves, as the second is. Only the second is a proof.
TEST(ContactClaimsTest, GiveProofsThatHoldWithoutRounding) {
  const double ulp = 0x1p-52;
  const Inertia inertia = FactoredInertia{Matrix{{1 + ulp}, {1}, {0}, {1}, {1}}, Vector::Ones(1)};
  Matrix N(5, 2);
  N << Vector{{-(1 - ulp), 1, 0.5, 0x1p8, -0x1p8}}, Vector{{0, 0, 1, 0, 0}};
  const Problem problem = contacts(Vector{{0, 0, -1, 0, 0}}, N, inertia);
  for (const std::string& solver : kOnContacts) expect_no_false_proof(solver, problem);
}

/// B'B of integers, in which no digit is lost. Its determinant is one, or zero where it is singular.
Matrix inertia_of_integers(bool singular) {
  const double p = 0x1p25;
  const double last = singular ? p : p + 1;
  const Matrix B{{p, 0, last}, {1, p, p + 1}, {0, 1, 1}};
  return B.transpose() * B;
}

// In 113 bits the two look the same.
TEST(ContactClaimsTest, TellADeterminantOfOneFromZero) {
  const Matrix N = Vector{{-1, -1, 1}}.asDiagonal().toDenseMatrix();
  const Vector v{{1, 1, -1}};
  const Problem regular = contacts(v, N, DenseInertia{inertia_of_integers(false)});
  const Problem singular = contacts(v, N, DenseInertia{inertia_of_integers(true)});
  for (const std::string& solver : kOnContacts) expect_honest(solver, regular);
  const Answer answer = solve("active_set", singular);
  EXPECT_EQ(answer.claim, Claim::kUnsolvable) << answer.detail;
  EXPECT_EQ(answer.farkas, Vector::Ones(3));
  EXPECT_TRUE(Evaluator(singular).check_farkas(answer.farkas));
}

TEST(ContactClaimsTest, AreNotMadeOfInertiaWhoseReciprocalOverflows) {
  Vector v(2);
  v << -0.36268043518066406, 0;
  Matrix N(2, 1);
  N << 4, -1;
  Matrix G = Matrix::Identity(2, 2);
  G(0, 0) = 5e-324;
  for (const std::string& solver : kOnContacts) expect_honest(solver, contacts(v, N, DenseInertia{G}));
}

/// Factors of rank two: of three, or two, in a plane. Their weights' roots are no doubles.
ContactProblem on_dependent_factors(const Matrix& rows, const Vector& alpha) {
  ContactProblem contact;
  contact.v = Vector{{1, 0.08032894134521484, -0.4703550338745117, -3, -0.5800313949584961}};
  contact.N = Matrix{{-4}, {-4}, {2}, {-1}, {-2}};
  contact.D = Matrix{{-4, 1, 4, -1}, {4, 3, -4, -3}, {-4, -2, 4, 2}, {-4, 2, 4, -2}, {4, -1, -4, 1}};
  contact.edges = {4};
  contact.mu = Vector{{1}};
  Matrix X = Matrix::Zero(5, rows.cols());
  X.middleRows(1, rows.rows()) = rows;
  contact.inertia = FactoredInertia{X, alpha};
  return contact;
}

// Rounding makes such factors independent; what then was taken for G* was rounding as a whole, but not large.
// Inverse inertia of a light body beside that of a heavy one, which is nearly singular: the heavy body's small pivots
// lie below the rounding of the light one's entries, and are no rounding. active_set and velocity_ipm had rho 1.3e-3
// here.
TEST(ContactClaimsTest, HoldWhereALightBodyStandsBesideAHeavyOne) {
  Matrix Ginv = Matrix::Zero(6, 6);
  Ginv.topLeftCorner(3, 3) << 388590.03085062327, 228328.05640414017, -22925.26488201208, 228328.05640414017,
      135735.85365553998, -5950.998655990264, -22925.26488201208, -5950.998655990264, 66010.11549386985;
  Ginv.bottomRightCorner(3, 3) << 3.5703213970532496e-07, 3.8238382265826864e-07, -6.372098213293823e-07,
      3.8238382265826864e-07, 4.097982167431267e-07, -6.829231690786027e-07, -6.372098213293823e-07,
      -6.829231690786027e-07, 1.1424973368351075e-06;
  const Vector v{{-2e-10, 2e-10, -2e-10, -1, -0.48881053924560547, -0.06063556671142578}};
  Matrix N = Matrix::Zero(6, 2);
  N.col(0).tail(3) << 0.8276920318603516, -0.7354135513305664, -0.1815042495727539;
  N.col(1) = 2 * N.col(0);
  const Problem problem = contacts(v, N, InverseInertia{Ginv});
  for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
  for (const char* solver : {"auto", "active_set", "contact_lemke", "velocity_ipm"}) expect_solved(solver, problem);
}

TEST(ContactClaimsTest, HoldWhereFactorsAreDependent) {
  const Matrix in_a_plane{{-3, -2, 2}, {3, 3, 0}};
  const Matrix on_a_line{{2, 6, -4}, {1, 3, -2}};
  const Matrix in_space{{1, 2, -1, 3}, {2, 1, 0, -1}, {3, 3, -1, 2}};
  for (const Matrix& rows : {in_a_plane, on_a_line, in_space}) {
    for (int k = 0; k < 40; ++k) {
      Vector alpha(rows.cols());
      for (Index j = 0; j < alpha.size(); ++j) {
        const int step = k * (static_cast<int>(j) + 3);
        alpha(j) = std::ldexp(1.0 + step % 7, step % 5);
      }
      if (k == 0) alpha(0) = 8;
      const Problem problem("dependent", on_dependent_factors(rows, alpha));
      for (const std::string& solver : kOnContacts) expect_honest(solver, problem);
      expect_solved("auto", problem);
    }
  }
}

}  // namespace
}  // namespace lcpbench::contact_claims_test
