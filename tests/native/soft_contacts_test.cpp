// Solvers that take compliance as it is, and the same solvers on the rigid equivalent: the same answers.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "core/compliance.h"
#include "generators/sets.h"
#include "tests/support/contacts.h"
#include "tests/support/solving.h"

namespace lcpbench::soft_contacts_test {
namespace {

using testing::Draw;
using testing::expect_honest;
using testing::expect_solved;
using testing::frictionless;
using testing::solve;

constexpr SolveRequest kPatient{.time_limit_s = 60};

/// With friction, too.
const char* const kTakeSoftFriction[] = {"contact_lemke", "psor", "auto", "friction_ipm", "proximal_newton", "contact_ipm"};

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
  const Answer own = solve(solver, soft, kPatient);
  const Answer equivalent = solve(solver, {"rigid", rigid_equivalent(contact)}, kPatient);
  EXPECT_EQ(own.claim, equivalent.claim) << own.detail << " | " << equivalent.detail;
  if (own.claim != Claim::kSolved || equivalent.claim != Claim::kSolved) return false;
  expect_solved(soft, own);
  const Vector off = (own.z - equivalent.z).head(contact.nc() + cols(contact.D));
  EXPECT_LE(off.cwiseAbs().maxCoeff(), tolerance * equivalent.z.cwiseAbs().maxCoeff());
  return own.counters.iterations == equivalent.counters.iterations;
}

// Without ties both take the same path, as exact arithmetic has it. What is left is the rounding of either: 1e-16 times
// a condition of 1e7 at most in these problems. Sweeps are the same numbers in another order, and stop after the same
// sweep, where each is off by its tolerance of 1e-8 at most, times the condition.
TEST(SoftContactsTest, EndWhereTheRigidEquivalentEnds) {
  int by_pivots = 0, by_sweeps = 0;
  for_each_softened(10, [&](const ContactProblem& contact) {
    by_pivots += expect_same("contact_lemke", contact, 1e-9) ? 1 : 0;
    by_sweeps += expect_same("psor{parts=none}", contact, 1e-5) ? 1 : 0;
  });
  EXPECT_GE(by_pivots, 160);
  EXPECT_GE(by_sweeps, 150);
}

ContactProblem softened_scene(const std::string& set, std::int64_t trial, double stiffness) {
  ContactProblem contact = *open_set(set)->generate(11, trial).contact();
  const Matrix N = to_dense(contact.N);
  contact.compliance_n = (N.transpose() * inverse_inertia(contact.inertia) * N).diagonal() / stiffness;
  return contact;
}

// More contacts than coordinates and fewer. The impulses of soft contacts are unique, and those of active_set as exact
// as its velocities.
TEST(SoftContactsTest, ActiveSetEndsWhereItEndsOnTheRigidEquivalent) {
  for (const char* set : {"rigid/exp1{nc_max=6}", "paper/monotone/exp1", "scene/stack/ode", "scene/box-pile/ode"}) {
    for (std::int64_t trial = 0; trial < 5; ++trial) {
      SCOPED_TRACE(std::string(set) + " #" + std::to_string(trial));
      const ContactProblem given = softened_scene(set, trial, std::pow(10.0, trial % 4));
      ContactProblem contact = frictionless(given.v, to_dense(given.N), given.inertia);
      contact.compliance_n = given.compliance_n;
      expect_same("active_set", contact, 1e-9);
      const Answer own = solve("active_set", {"soft", contact});
      const auto pressing = (own.z.array() > 0).count();
      EXPECT_LE(own.counters.pivots, std::max<std::int64_t>(pressing / 2, 12)) << "one step for many contacts";
    }
  }
}

// A stack of boxes whose contacts all press and of which some slip: the velocity has fewer coordinates than the
// contacts have impulses, and auto finds it by a few steps in those, not by a pivot for each impulse.
TEST(SoftContactsTest, AutoSolvesManyContactsInTheirCoordinates) {
  for (std::int64_t trial = 0; trial < 8; ++trial) {
    ContactProblem contact = softened_scene("scene/stack/ode", trial, 10);
    contact.compliance_t = contact.compliance_n;
    const Problem soft("soft " + std::to_string(trial), contact);
    const Answer own = solve("auto", soft);
    expect_solved(soft, own, 1e-8);
    EXPECT_GE((own.z.head(contact.nc()).array() > 0).count(), 40);
    EXPECT_LE(own.counters.pivots, 30) << own.detail;
  }
}

TEST(SoftContactsTest, EveryKindOfInertiaAndSparseJacobiansAreTaken) {
  Draw draw(6);
  for (std::int64_t trial = 0; trial < 10; ++trial) {
    ContactProblem contact = softened("paper/copositive/exp1{nc_max=6}", trial, 4, Which::kSome, draw);
    const Matrix G = dense_inertia(contact.inertia);
    contact.N = SparseMatrix(to_dense(contact.N).sparseView());
    contact.D = SparseMatrix(to_dense(contact.D).sparseView());
    const Inertia kinds[] = {DenseInertia{G}, BlockInertia{{G}}, InverseInertia{inverse_inertia(DenseInertia{G})}};
    for (const Inertia& inertia : kinds) {
      contact.inertia = inertia;
      const Problem soft("soft " + std::to_string(trial), contact);
      for (const char* solver : kTakeSoftFriction) expect_honest(soft, solve(solver, soft, kPatient), solver);
      expect_solved(soft, solve("auto", soft));
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
    const Problem soft("soft " + std::to_string(trial), contact);
    for (const char* solver : {"contact_lemke", "active_set", "auto"}) {
      const Answer own = solve(solver, soft);
      EXPECT_NE(own.claim, Claim::kUnsolvable) << solver;
      expect_honest(soft, own, solver);
      solved += own.claim == Claim::kSolved;
    }
  }
  EXPECT_GE(solved, 5);
}

TEST(SoftContactsTest, NextStepsGoOnFromTheLastAnswer) {
  Draw draw(7);
  for (const char* solver : kTakeSoftFriction) {
    int solved = 0;
    for (std::int64_t trial = 0; trial < 10; ++trial) {
      ContactProblem contact = softened(kSets[0], trial, 4, Which::kAll, draw);
      const std::unique_ptr<Solver> object = make_solver(parse_spec(solver));
      object->load({"step", contact});
      Vector last;
      for (int step = 0; step < 4; ++step) {
        contact.v += 0.05 * draw.vector(contact.ngc());
        object->update(contact.v);
        const Answer own = solve(*object, {.start = step > 0 ? &last : nullptr});
        if (own.claim == Claim::kIterationLimit) break;  // the sweeps of psor need not converge
        expect_solved({"step", contact}, own, kSolvedVelocityResidual, solver);
        last = own.z;
        ++solved;
      }
    }
    EXPECT_GE(solved, 36) << solver;
  }
}

}  // namespace
}  // namespace lcpbench::soft_contacts_test
