// Solvers that take compliance as it is, and the same solvers on the rigid equivalent: the same answers.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/compliance.h"
#include "core/exact_inertia.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "native/active_set/active_set.h"
#include "native/active_set/least_energy.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::soft_contacts_test {
namespace {

enum class Which { kAll, kSome };

/// The same contacts with pyramids of so many edges, along the first direction and the one at right angles to it.
void set_edges(ContactProblem& contact, int edges) {
  const Matrix given = to_dense(contact.D);
  const auto has_friction = [](int own) { return own > 0; };
  Matrix D(contact.ngc(), edges * std::count_if(contact.edges.begin(), contact.edges.end(), has_friction));
  Index from = 0, to = 0;
  for (int& own : contact.edges) {
    for (Index k = 0; own > 0 && k < edges; ++k) {
      const auto [x, y] = edge_direction(k, edges);
      D.col(to++) = x * given.col(from) + y * given.col(from + own / 4);
    }
    from += own;
    own = own > 0 ? edges : 0;
  }
  contact.D = std::move(D);
}

/// A problem of a random set with compliance of the size of M's entries, tangential offsets and normal ones.
ContactProblem softened(const std::string& set, std::int64_t trial, int edges, Which which, Draw& draw) {
  ContactProblem contact = *open_set(set)->generate(11, trial).contact();
  set_edges(contact, edges);
  const auto size = [&] {
    const double r = std::abs(draw.uniform());
    return which == Which::kSome && r < 0.4 ? 0.0 : 0.1 + r;
  };
  contact.compliance_n = contact.compliance_t = contact.b = Vector::Zero(contact.nc());
  contact.offset_t = Vector::Zero(2 * contact.nc());
  for (Index i = 0; i < contact.nc(); ++i) {
    contact.compliance_n(i) = size();
    contact.b(i) = 0.1 * std::abs(draw.uniform());
    if (contact.edges[static_cast<std::size_t>(i)] == 0) continue;
    contact.compliance_t(i) = size();
    if (contact.compliance_t(i) > 0) contact.offset_t.segment<2>(2 * i) = 0.1 * draw.vector(2);
  }
  return contact;
}

const char* const kSets[] = {"rigid/frictional/exp1{bodies_max=3,nc_max=6}", "rigid/exp1{nc_max=8}",
                             "paper/copositive/exp1{nc_max=6}"};

Answer solve(const std::string& solver, const Problem& problem, const Vector* start = nullptr) {
  Answer answer;
  const std::unique_ptr<Solver> object = make_solver(parse_spec(solver));
  object->load(problem);
  object->solve({.start = start, .time_limit_s = 60}, answer);
  return answer;
}

/// visit(problem) for random ones of all sets with 2, 4 and 8 edges.
template <class Visit>
void for_each_softened(std::int64_t trials, Visit&& visit) {
  Draw draw(5);
  for (const char* set : kSets) {
    for (std::int64_t trial = 0; trial < trials; ++trial) {
      for (const int edges : {2, 4, 8}) {
        for (const Which which : {Which::kAll, Which::kSome}) {
          SCOPED_TRACE(std::string(set) + " #" + std::to_string(trial) + ", edges " + std::to_string(edges));
          visit(softened(set, trial, edges, which, draw));
        }
      }
    }
  }
}

/// Solves `contact` and its rigid equivalent. Both claim the same, what is claimed passes the evaluation, and the
/// impulses are the same to `tolerance` of the largest. @returns whether it is solved, with as much work in either
bool expect_same(const std::string& solver, const ContactProblem& contact, double tolerance) {
  const Problem soft("soft", contact);
  const Answer own = solve(solver, soft);
  const Answer equivalent = solve(solver, {"rigid", rigid_equivalent(contact)});
  EXPECT_EQ(own.claim, equivalent.claim) << own.detail << " | " << equivalent.detail;
  if (own.claim != Claim::kSolved || equivalent.claim != Claim::kSolved) return false;
  EXPECT_TRUE(Evaluator(soft).errors(own).solved) << own.detail;
  const Index impulses = contact.nc() + cols(contact.D);
  const Vector off = (own.z - equivalent.z).head(impulses);
  EXPECT_LE(off.cwiseAbs().maxCoeff(), tolerance * equivalent.z.cwiseAbs().maxCoeff());
  return own.counters.iterations == equivalent.counters.iterations;
}

// Without ties both take the same path, as exact arithmetic has it. What is left is the rounding of either: 1e-16 times
// a condition of 1e7 at most in these problems.
TEST(SoftContactsTest, ContactLemkeEndsWhereItEndsOnTheRigidEquivalent) {
  int solved = 0;
  for_each_softened(
      30, [&](const ContactProblem& contact) { solved += expect_same("contact_lemke", contact, 1e-9) ? 1 : 0; });
  EXPECT_GE(solved, 500);
}

TEST(SoftContactsTest, SoDoTheClassicCoveringVectorAnd113Bits) {
  int solved = 0;
  for_each_softened(3, [&](const ContactProblem& contact) {
    solved += expect_same("contact_lemke{covering=classic}", contact, 1e-9) ? 1 : 0;
    solved += expect_same("contact_lemke{precision=quad}", contact, 1e-12) ? 1 : 0;
  });
  EXPECT_GE(solved, 100);
}

// More contacts than coordinates and fewer, alone and from a start that is wrong. The impulses of soft contacts are
// unique, and those of active_set as exact as its velocities.
TEST(SoftContactsTest, ActiveSetEndsWhereItEndsOnTheRigidEquivalent) {
  for (const char* set : {"rigid/exp1{nc_max=6}", "paper/monotone/exp1", "scene/stack/ode", "scene/box-pile/ode"}) {
    for (std::int64_t trial = 0; trial < 5; ++trial) {
      SCOPED_TRACE(std::string(set) + " #" + std::to_string(trial));
      const ContactProblem given = *open_set(set)->generate(11, trial).contact();
      ContactProblem contact = frictionless(given.v, to_dense(given.N), given.inertia);
      const Matrix& N = std::get<Matrix>(contact.N);
      contact.compliance_n =
          (N.transpose() * inverse_inertia(contact.inertia) * N).diagonal() / std::pow(10.0, trial % 4);
      expect_same("active_set", contact, 1e-9);
      const Answer own = solve("active_set", {"soft", contact});
      ASSERT_EQ(own.claim, Claim::kSolved) << own.detail;
      const auto pressing = (own.z.array() > 0).count();
      EXPECT_LE(own.counters.pivots, std::max<std::int64_t>(pressing / 2, 12)) << "one step for many contacts";
    }
  }
}

// The elimination of SymmetricSystem has n^3 / 3 multiplications, the product before it n^3 / 2.
TEST(SoftContactsTest, ActiveSetCountsAllMultiplicationsOfASystem) {
  constexpr Index n = 100;
  const Matrix identity = Matrix::Identity(n, n);
  ContactProblem contact = frictionless(Vector::Constant(n, -1), identity, DenseInertia{identity});
  contact.compliance_n = Vector::Constant(n, 0.5);
  const Problem problem("all press", contact);
  ActiveSet solver(ActiveSetSettings{});
  Answer answer;
  solver.load(problem);
  solver.begin(nullptr, 0);
  answer.reserve(problem);
  ASSERT_TRUE(solver.go_on(1e12, std::numeric_limits<double>::infinity(), answer));
  ASSERT_EQ(answer.counters.factorizations, 1);
  EXPECT_GE(solver.work(), n * n * n * (1 / 3.0 + 1 / 2.0));
}

// A stack of boxes whose contacts all press and of which some slip: the velocity has fewer coordinates than the
// contacts have impulses, and auto finds it by a few steps in those, not by a pivot for each impulse.
TEST(SoftContactsTest, AutoSolvesManyContactsInTheirCoordinates) {
  for (std::int64_t trial = 0; trial < 8; ++trial) {
    SCOPED_TRACE(trial);
    ContactProblem contact = *open_set("scene/stack/ode")->generate(11, trial).contact();
    const Matrix N = to_dense(contact.N);
    contact.compliance_n = (N.transpose() * inverse_inertia(contact.inertia) * N).diagonal() / 10;
    contact.compliance_t = contact.compliance_n;
    const Problem soft("soft", contact);
    const Answer own = solve("auto", soft);
    ASSERT_EQ(own.claim, Claim::kSolved) << own.detail;
    const Errors errors = Evaluator(soft).errors(own);
    EXPECT_LE(errors.velocity_residual_relative, 1e-8);
    EXPECT_GE((own.z.head(contact.nc()).array() > 0).count(), 40);
    EXPECT_LE(own.counters.pivots, 30) << own.detail;
  }
}

// The updates are the same numbers in another order, and both stop after the same sweep, where each is off by its
// tolerance of 1e-8 at most; an impulse may be off by that times the condition.
TEST(SoftContactsTest, PsorMakesTheSameSweepsAsOnTheRigidEquivalent) {
  int solved = 0;
  for_each_softened(10, [&](const ContactProblem& contact) { solved += expect_same("psor", contact, 1e-5) ? 1 : 0; });
  EXPECT_GE(solved, 150);
}

TEST(SoftContactsTest, EveryKindOfInertiaAndSparseJacobiansAreTaken) {
  Draw draw(6);
  for (std::int64_t trial = 0; trial < 10; ++trial) {
    ContactProblem contact = softened("paper/copositive/exp1{nc_max=6}", trial, 4, Which::kSome, draw);
    const Matrix G = dense_inertia(contact.inertia);
    const Matrix N = to_dense(contact.N), D = to_dense(contact.D);
    contact.N = SparseMatrix(N.sparseView());
    contact.D = SparseMatrix(D.sparseView());
    const Inertia kinds[] = {DenseInertia{G}, BlockInertia{{G}}, InverseInertia{inverse_inertia(DenseInertia{G})}};
    for (const Inertia& inertia : kinds) {
      contact.inertia = inertia;
      for (const char* solver : {"contact_lemke", "psor", "auto", "friction_ipm", "proximal_newton"}) {
        SCOPED_TRACE(std::string(solver) + " #" + std::to_string(trial));
        const Problem soft("soft", contact);
        const Answer own = solve(solver, soft);
        const bool is_solved = own.claim == Claim::kSolved;
        EXPECT_TRUE(is_solved || std::string(solver) != "auto") << own.detail;
        EXPECT_TRUE(!is_solved || Evaluator(soft).errors(own).solved) << own.detail;
      }
    }
  }
}

/// With friction, too.
const char* const kTakeSoftFriction[] = {"contact_lemke", "psor", "auto", "friction_ipm", "proximal_newton"};

TEST(SoftContactsTest, AContactThatNothingMovesCreepsAsItsOffsetSays) {
  ContactProblem contact = frictionless(vec({-1, 0}), Matrix(2, 2), BlockInertia{{Matrix::Identity(2, 2)}});
  contact.N = Matrix{{1.0, 0.0}, {0.0, 0.0}};
  contact.D = Matrix::Zero(2, 4);
  contact.edges = {0, 4};
  contact.mu = vec({0, 0.5});
  contact.compliance_t = vec({0, 0.25});
  contact.offset_t = vec({0, 0, 0.5, -2});
  for (const char* solver : kTakeSoftFriction) {
    const Problem soft("soft", contact);
    const Answer own = solve(solver, soft);
    ASSERT_EQ(own.claim, Claim::kSolved) << solver << ": " << own.detail;
    EXPECT_TRUE(Evaluator(soft).errors(own).solved) << solver;
    EXPECT_GE(own.z(6), 2) << solver;
  }
}

/// What is said to be solved is solved, loaded and after an update.
void expect_honest(const std::string& solver, const ContactProblem& contact, bool solves) {
  SCOPED_TRACE(solver);
  const Problem soft("soft", contact);
  const std::unique_ptr<Solver> object = make_solver(parse_spec(solver));
  object->load(soft);
  for (int step = 0; step < 2; ++step) {
    Answer own;
    object->solve({.time_limit_s = 60}, own);
    const bool is_claimed = own.claim == Claim::kSolved;
    EXPECT_TRUE(is_claimed || !solves) << own.detail;
    EXPECT_TRUE(!is_claimed || Evaluator(soft).errors(own).solved) << own.detail;
    object->update(contact.v);
  }
}

// Its offset of 1 m/s would let the other one approach, at 1e-20 m/s, although the inertia couples all coordinates.
TEST(SoftContactsTest, AContactThatNothingMovesIsNoScaleOfTheOthers) {
  ContactProblem contact =
      frictionless(vec({-1e-20, 1e-20}), Matrix{{0.0, 1.0}, {0.0, 0.0}}, DenseInertia{Matrix{{2.0, 1.0}, {1.0, 2.0}}});
  contact.D = Matrix::Zero(2, 4);
  contact.edges = {2, 2};
  contact.mu = vec({1, 1});
  ContactProblem creeps = contact, rigid_creeps = contact, yields = contact, offset = contact;
  creeps.compliance_n = vec({0.5, 0.25});
  rigid_creeps.offset_t = creeps.offset_t = vec({1, -1, 0, 0.5});
  yields.compliance_n = vec({0.5, 0.25});
  yields.b = vec({-1, 0});
  offset.b = vec({1, 0});
  for (const char* solver : kTakeSoftFriction) {
    for (const ContactProblem& each : {creeps, rigid_creeps, yields, offset}) {
      expect_honest(solver, each, std::string(solver) == "auto");
    }
  }
}

// No lambda in double is as large as this speed along 8 edges.
TEST(SoftContactsTest, OffsetsBeyondDoubleAreNoAnswer) {
  ContactProblem contact =
      frictionless(vec({-1, 0}), Matrix{{1.0, 0.0}, {0.0, 0.0}}, DenseInertia{Matrix::Identity(2, 2)});
  contact.D = Matrix::Zero(2, 8);
  contact.edges = {0, 8};
  contact.mu = vec({0, 0.5});
  contact.offset_t = vec({0, 0, 1.7e308, 1.7e308});
  ContactProblem bodies = contact;
  bodies.inertia = BlockInertia{{Matrix::Identity(1, 1), Matrix::Identity(1, 1)}};
  for (const char* solver : kTakeSoftFriction) {
    for (const ContactProblem& each : {contact, bodies}) expect_honest(solver, each, false);
  }
}

// The velocity that came back was that of an impulse of -1e171 N s, which counted as rounding and was returned as zero.
TEST(SoftContactsTest, WhatIsAllowedForRoundingIsFinite) {
  const Matrix N{{-0.948844748254284, 6.838867615441838e-165}};
  ContactProblem contact = frictionless(vec({0}), N, DenseInertia{Matrix::Identity(1, 1)});
  contact.b = vec({17.895515355967245, -2.8489443839085014e+142});
  contact.compliance_n = vec({7.477499243198999e-203, 6.674965300299753e+92});
  expect_honest("velocity_ipm", contact, true);
}

// The impulse, 1e310 N s, is beyond double, and times a zero of the normal it is no number.
TEST(SoftContactsTest, ImpulsesBeyondDoubleAreNotOfLeastEnergy) {
  ContactProblem contact;
  contact.v = Vector::Constant(2, -1e300);
  contact.N = Matrix{{1.0}, {0.0}};
  contact.D = Matrix{{0.0, 0.0}, {1.0, -1.0}};
  contact.edges = {2};
  contact.mu = Vector::Constant(1, 0.5);
  contact.compliance_n = contact.compliance_t = Vector::Constant(1, 1e-10);
  contact.inertia = DenseInertia{1e6 * Matrix::Identity(2, 2)};
  ASSERT_TRUE(LeastEnergy::takes(contact));
  LeastEnergy method;
  method.reserve(contact);
  method.load(contact, contact.v);
  std::int64_t steps = 0;
  EXPECT_FALSE(method.solve(false, HUGE_VAL, steps));
}

// The second of these contacts yields along its tangents alone: with an impulse there, its friction has a speed.
TEST(SoftContactsTest, ContactsWithoutCoordinatesAreTaken) {
  ContactProblem contact = frictionless(Vector(0), Matrix(0, 3), DenseInertia{Matrix(0, 0)});
  contact.D = Matrix(0, 6);
  contact.edges = {2, 2, 2};
  contact.mu = vec({1, 0.75, 0.125});
  contact.b = vec({-0.29236507415771484, 0, 0.3102703094482422});
  contact.compliance_n = vec({0.7102564128577364, 0, 0});
  contact.compliance_t = vec({128, 5.323649300306486, 0});
  ContactProblem rigid = contact;
  rigid.compliance_n = rigid.compliance_t = Vector();
  rigid.b(0) = 0;
  ContactProblem without_offsets = rigid;
  without_offsets.b = Vector();
  ContactProblem without_bodies = contact;
  without_bodies.inertia = BlockInertia{};
  for (const char* solver : kTakeSoftFriction) {
    for (const ContactProblem& each : {contact, rigid, without_offsets, without_bodies}) {
      expect_honest(solver, each, true);
    }
  }
}

// Contacts that all yield have a solution, and an inertia that may be singular is then looked at all the same.
TEST(SoftContactsTest, AnInertiaOfDoubtfulRankIsTaken) {
  Draw draw(8);
  int solved = 0;
  for (std::int64_t trial = 0; trial < 5; ++trial) {
    ContactProblem contact = softened(kSets[1], trial, 4, Which::kAll, draw);
    Matrix X = Matrix::Identity(contact.ngc(), contact.ngc());
    X(0, 0) = 1e-13;
    contact.inertia = FactoredInertia{X, Vector::Ones(contact.ngc())};
    for (const char* solver : {"contact_lemke", "active_set", "auto"}) {
      SCOPED_TRACE(std::string(solver) + " #" + std::to_string(trial));
      const Problem soft("soft", contact);
      const Answer own = solve(solver, soft);
      EXPECT_NE(own.claim, Claim::kUnsolvable);
      if (own.claim != Claim::kSolved) continue;
      ++solved;
      EXPECT_TRUE(Evaluator(soft).errors(own).solved) << own.detail;
    }
  }
  EXPECT_GE(solved, 5);
}

// A singular inertia lets the second contact move the bodies by no more than the rounding of its normal. It gives way
// so little that its impulse is 1e11 N s, and its share in the velocity of the first contact is 0.003 of all.
TEST(SoftContactsTest, AHugeImpulseThatMovesLittleIsNotTakenForRounding) {
  ContactProblem contact = frictionless(vec({-1, 0}), Matrix{{1.0, 8 - 0x1p-50}, {-2.0, -4.0}},
                                        InverseInertia{Matrix{{32.0, 64.0}, {64.0, 128.0}}});
  contact.compliance_n = vec({0x1p-7, 0x1p-35});
  const Problem soft("soft", contact);
  const Vector start = vec({1, 1});
  for (const char* solver : {"active_set", "active_set{precision=double}", "velocity_ipm", "auto"}) {
    for (const Vector* from : {static_cast<const Vector*>(nullptr), &start}) {
      const Answer own = solve(solver, soft, from);
      const bool must_solve = std::string(solver) != "active_set{precision=double}";
      EXPECT_EQ(own.claim == Claim::kSolved, must_solve) << solver << ": " << own.detail;
      EXPECT_TRUE(own.claim != Claim::kSolved || Evaluator(soft).errors(own).solved) << solver;
    }
  }
}

// The whitened velocity C v cancels. What is lost of it is far more than the contact, which gives way, moves the body:
// v as given has to come back, not C^-1 of it.
TEST(SoftContactsTest, AVelocityThatIsHardlyMovedComesBackUnrounded) {
  ContactProblem contact = frictionless(vec({0, 2.7689, 1.361}), Matrix{{0.0}, {0.0}, {-1.0}},
                                        DenseInertia{Matrix{{2.0, 2.0, -4.0}, {2.0, 4.0, -8.0}, {-4.0, -8.0, 18.0}}});
  contact.compliance_n = vec({0x1p80});
  for (const char* solver : {"active_set", "active_set{precision=quad}", "velocity_ipm", "auto"}) {
    const Answer own = solve(solver, {"soft", contact});
    ASSERT_EQ(own.claim, Claim::kSolved) << solver << ": " << own.detail;
    ASSERT_EQ(own.velocity.size(), 3) << solver;
    EXPECT_LE((own.velocity - contact.v).cwiseAbs().maxCoeff(), 1e-23) << solver;
  }
}

TEST(SoftContactsTest, NextStepsGoOnFromTheLastAnswer) {
  Draw draw(7);
  for (const char* solver : kTakeSoftFriction) {
    int solved = 0;
    for (std::int64_t trial = 0; trial < 10; ++trial) {
      SCOPED_TRACE(std::string(solver) + " #" + std::to_string(trial));
      ContactProblem contact = softened(kSets[0], trial, 4, Which::kAll, draw);
      const std::unique_ptr<Solver> object = make_solver(parse_spec(solver));
      object->load({"step", contact});
      Vector last;
      for (int step = 0; step < 4; ++step) {
        contact.v += 0.05 * draw.vector(contact.ngc());
        object->update(contact.v);
        Answer own;
        object->solve({.start = step > 0 ? &last : nullptr}, own);
        if (own.claim == Claim::kIterationLimit) break;  // the sweeps of psor need not converge
        ASSERT_EQ(own.claim, Claim::kSolved) << own.detail;
        EXPECT_TRUE(Evaluator({"step", contact}).errors(own).solved);
        last = own.z;
        ++solved;
      }
    }
    EXPECT_GE(solved, 36) << solver;
  }
}

}  // namespace
}  // namespace lcpbench::soft_contacts_test
