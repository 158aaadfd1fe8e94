#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/scene.h"
#include "generators/rigid/rigid.h"
#include "generators/to_problem.h"
#include "tests/generators/generator_checks.h"
#include "tests/generators/opened_set.h"

namespace lcpbench::rigid_generator_test {
namespace {

using Opened = testing::OpenedSet<RigidSet, draw_rigid>;

Opened open(const std::string& text) { return testing::opened_set<draw_rigid>(rigid_sets(), text); }

bool same(const RigidBodySample& a, const RigidBodySample& b) {
  return a.mass == b.mass && a.inertia.data == b.inertia.data && a.position == b.position &&
         a.linear_velocity == b.linear_velocity && a.angular_velocity == b.angular_velocity;
}

bool same(const RigidContactSample& a, const RigidContactSample& b) {
  return a.body_a == b.body_a && a.body_b == b.body_b && a.point == b.point && a.normal == b.normal;
}

bool same(const RigidSample& a, const RigidSample& b) {
  const auto alike = [](const auto& x, const auto& y) { return same(x, y); };
  return std::equal(a.bodies.begin(), a.bodies.end(), b.bodies.begin(), b.bodies.end(), alike) &&
         std::equal(a.contacts.begin(), a.contacts.end(), b.contacts.begin(), b.contacts.end(), alike);
}

TEST(RigidGeneratorTest, DependentContactsDependExactly) {
  for (const std::string name :
       {"rigid/exp2", "rigid/exp2{redundancy=combination}", "rigid/exp2{redundancy=combination,normals=axis}"}) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    const bool combination = set.reading.redundancy == Redundancy::kCombination;
    for (std::uint64_t trial = 0; trial < 100; ++trial) {
      const RigidSample sample = set.draw(trial);
      const Matrix N = to_dense(contact_problem(to_scene(sample)).N);
      const auto normal = [&N](std::size_t contact, Index row) {
        return static_cast<Quad>(N(row, static_cast<Index>(contact)));
      };
      const std::size_t independent = sample.contacts.size() - sample.dependences.size();
      for (const RigidDependence& one : sample.dependences) {
        ASSERT_GE(one.contact, independent);
        ASSERT_TRUE(one.first < independent && one.second < independent);
        ASSERT_EQ(one.quarter != 0, combination && independent > 1);
        for (Index row = 0; row < N.rows(); ++row) {
          const Quad sum = (4 - one.quarter) * normal(one.first, row) + one.quarter * normal(one.second, row);
          ASSERT_TRUE(sum == 4 * normal(one.contact, row));
        }
        const bool at_source = same(sample.contacts[one.contact], sample.contacts[one.first]);
        ASSERT_EQ(at_source, one.quarter == 0);
      }
    }
  }
}

TEST(RigidGeneratorTest, ATrialIsTheSameAloneInABatchAndInTwoThreads) {
  testing::expect_order_and_threads_do_not_matter(
      open("rigid/exp5-1e8{redundancy=combination}"),
      [](const RigidSample& a, const RigidSample& b) { return same(a, b); });
}

// --- friction ---

double largest_difference(const Matrix& a, const Matrix& b) { return (a - b).lpNorm<Eigen::Infinity>(); }

TEST(RigidFrictionTest, FrictionIsAddedToTheFrictionlessScene) {
  for (const std::string name : {"exp1{bodies_max=8,nc_max=40}", "exp2{redundancy=combination,normals=axis}",
                                 "exp5-1e8{redundancy=combination}"}) {
    SCOPED_TRACE(name);
    const Opened with = open("rigid/frictional/" + name);
    const Opened without = open("rigid/" + name);
    for (std::uint64_t trial = 0; trial < 50; ++trial) {
      const ContactProblem frictional = contact_problem(to_scene(with.draw(trial)));
      const ContactProblem frictionless = contact_problem(to_scene(without.draw(trial)));
      ASSERT_EQ(frictional.v, frictionless.v);
      ASSERT_EQ(to_dense(frictional.N), to_dense(frictionless.N));
      ASSERT_EQ(dense_inertia(frictional.inertia), dense_inertia(frictionless.inertia));
      ASSERT_FALSE(frictionless.frictional());
      for (const int edges : frictional.edges) ASSERT_EQ(edges, 4);
    }
  }
}

TEST(RigidFrictionTest, DirectionsHaveTheAnglesOfThePyramidAndTheirOpposites) {
  for (const int edges : {4, 8, 16}) {
    const Opened set = open("rigid/frictional/exp1{bodies_max=1,edges=" + std::to_string(edges) + "}");
    for (std::uint64_t trial = 0; trial < 50; ++trial) {
      const RigidSample sample = set.draw(trial);
      const Matrix D = to_dense(to_contact_problem(sample).D);
      for (std::size_t c = 0; c < sample.contacts.size(); ++c) {
        const Eigen::Vector3d normal(sample.contacts[c].normal.data());
        const auto directions = D.middleCols(static_cast<Index>(c) * edges, edges);
        const Eigen::Vector3d first = directions.col(0).head<3>();
        const Eigen::Vector3d second = normal.cross(first);
        ASSERT_EQ(first, Eigen::Vector3d(sample.contacts[c].tangent.data()));
        for (Index k = 0; k < edges; ++k) {
          const double angle = 2 * std::numbers::pi * static_cast<double>(k) / edges;
          const Eigen::Vector3d expected = std::cos(angle) * first + std::sin(angle) * second;
          ASSERT_LE(largest_difference(directions.col(k).head<3>(), expected), 1e-12);
          ASSERT_EQ(directions.col((k + edges / 2) % edges), -directions.col(k));
        }
      }
    }
  }
}

// The second tangent of a scene is normal x tangent, which a double cannot hold: its dependence holds to rounding.
TEST(RigidFrictionTest, DependentContactsDependInTheirFrictionToo) {
  for (const std::string name :
       {"exp2", "exp2{redundancy=combination}", "exp2{redundancy=combination,normals=axis}", "exp2{edges=8}",
        "exp2{redundancy=combination,edges=8}", "exp5-1e5{redundancy=combination,edges=16}"}) {
    SCOPED_TRACE(name);
    const Opened set = open("rigid/frictional/" + name);
    const bool second_is_rounded = set.reading.edges == PyramidEdges::k4 &&
                                   set.reading.redundancy == Redundancy::kCombination &&
                                   set.reading.normals == NormalReading::kGeneral;
    for (std::uint64_t trial = 0; trial < 50; ++trial) {
      const RigidSample sample = set.draw(trial);
      const Matrix D = to_dense(to_contact_problem(sample).D);
      for (const RigidDependence& one : sample.dependences) {
        for (Index t = 0; t < sample.edges; ++t) {
          const auto column = [&](std::size_t contact) {
            return D.col(static_cast<Index>(contact) * sample.edges + t);
          };
          const Vector combined = (4 - one.quarter) * column(one.first) + one.quarter * column(one.second);
          const double allowed = second_is_rounded && t % 2 == 1 ? 0x1p-48 : 0.0;
          ASSERT_LE(largest_difference(combined, 4 * column(one.contact)), allowed) << trial << " " << t;
        }
      }
    }
  }
}

}  // namespace
}  // namespace lcpbench::rigid_generator_test
