#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <gtest/gtest.h>

#include "core/io/problem_io.h"
#include "generators/rigid/rigid.h"
#include "generators/sets.h"
#include "generators/to_problem.h"
#include "tests/generators/generator_checks.h"
#include "tests/generators/opened_set.h"

namespace lcpbench::rigid_friction_test {
namespace {

using Opened = testing::OpenedSet<RigidSet, draw_rigid>;

Opened open(const std::string& text) { return testing::opened_set<draw_rigid>(rigid_sets(), text); }

const std::vector<std::string> kReadings = {
    "exp1",
    "exp1{normals=axis}",
    "exp1{bodies_max=8,nc_max=40}",
    "exp2",
    "exp2{redundancy=combination}",
    "exp2{redundancy=combination,normals=axis}",
    "exp5-1e8{redundancy=combination}",
    "exp6-1e10",
};

Quad dot(const Triple& a, const Triple& b) {
  Quad sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += static_cast<Quad>(a[i]) * b[i];
  return sum;
}

Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double largest_difference(const Matrix& a, const Matrix& b) { return (a - b).lpNorm<Eigen::Infinity>(); }

TEST(RigidFrictionTest, FrictionIsAddedToTheFrictionlessScene) {
  for (const std::string& name : kReadings) {
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

TEST(RigidFrictionTest, TangentsHaveLengthOneAndLieAcrossTheNormal) {
  for (const std::string& name : kReadings) {
    SCOPED_TRACE(name);
    const Opened set = open("rigid/frictional/" + name);
    const double slack = set.reading.normals == NormalReading::kAxis ? 0 : 2e-12;
    for (std::uint64_t trial = 0; trial < 100; ++trial) {
      for (const RigidContactSample& contact : set.draw(trial).contacts) {
        ASSERT_LE(std::fabs(to_double(dot(contact.tangent, contact.tangent) - 1)), slack);
        ASSERT_LE(std::fabs(to_double(dot(contact.tangent, contact.normal))), slack);
        for (const double component : contact.tangent) ASSERT_EQ(std::trunc(component * 0x1p40), component * 0x1p40);
      }
    }
  }
}

TEST(RigidFrictionTest, FrictionCoefficientsAndTangentsAreUniform) {
  std::vector<int> mu(16), angle(8);
  std::vector<int> tilt(4);  // against the plane of two axes, where the normal is halfway between them
  const Opened general = open("rigid/frictional/exp1");
  for (std::uint64_t trial = 0; trial < 3000; ++trial) {
    for (const RigidContactSample& contact : general.draw(trial).contacts) {
      ASSERT_TRUE(contact.mu >= 0 && contact.mu < 1);
      ASSERT_EQ(std::trunc(contact.mu * 0x1p20), contact.mu * 0x1p20);
      ++mu[static_cast<std::size_t>(16 * contact.mu)];
      const Triple axis = std::fabs(contact.normal[0]) < 0.5 ? Triple{1, 0, 0} : Triple{0, 1, 0};
      const Triple first = cross(contact.normal, axis);
      const double turn = std::atan2(to_double(dot(contact.tangent, cross(contact.normal, first))),
                                     to_double(dot(contact.tangent, first)));
      const std::size_t sector = std::min<std::size_t>(7, static_cast<std::size_t>((turn / std::numbers::pi + 1) * 4));
      ++angle[sector];
      const Triple& normal = contact.normal;
      const auto smaller = [&normal](std::size_t i, std::size_t j) {
        return std::fabs(normal[i]) < std::fabs(normal[j]);
      };
      const std::size_t least = std::min({std::size_t{0}, std::size_t{1}, std::size_t{2}}, smaller);
      const std::size_t next = std::min((least + 1) % 3, (least + 2) % 3, smaller);
      if (std::fabs(normal[least]) > 0.25 || std::fabs(normal[next]) < 0.5) continue;
      const double share = std::fabs(contact.tangent[least]) / std::sqrt(1 - normal[least] * normal[least]);
      ++tilt[std::min<std::size_t>(3,
                                   static_cast<std::size_t>(8 / std::numbers::pi * std::asin(std::min(share, 1.0))))];
    }
  }
  std::vector<int> side(6);
  const Opened axis = open("rigid/frictional/exp1{normals=axis}");
  for (std::uint64_t trial = 0; trial < 1000; ++trial) {
    for (const RigidContactSample& contact : axis.draw(trial).contacts) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (contact.tangent[i] != 0) ++side[2 * i + (contact.tangent[i] > 0 ? 1 : 0)];
      }
    }
  }
  checks::ChiSquare uniform;
  uniform.add_uniform(mu);
  uniform.add_uniform(angle);
  uniform.add_uniform(side);
  EXPECT_TRUE(uniform.plausible()) << uniform.statistic() << " at " << uniform.degrees() << " degrees of freedom";

  // Tangents from points of a cube instead of a ball lean that way, and only there.
  checks::ChiSquare upright;
  upright.add_uniform(tilt);
  EXPECT_TRUE(upright.plausible()) << upright.statistic() << " at " << upright.degrees() << " degrees of freedom";
}

// The largest error of a friction row [d; r x d] in double, d being the direction that the row itself has.
double largest_row_error(const RigidSample& sample, const Matrix& D, Index columns_per_contact, Index column) {
  const RigidContactSample& contact = sample.contacts[static_cast<std::size_t>(column / columns_per_contact)];
  double largest = 0;
  for (std::size_t b = 0; b < sample.bodies.size(); ++b) {
    const Index row = 6 * static_cast<Index>(b);
    for (Index i = 0; i < 3; ++i) {
      const Index j = (i + 1) % 3;
      const Index k = (i + 2) % 3;
      const auto arm = [&](Index axis) {
        return static_cast<Quad>(contact.point[static_cast<std::size_t>(axis)]) -
               sample.bodies[b].position[static_cast<std::size_t>(axis)];
      };
      const Quad torque = arm(j) * D(row + k, column) - arm(k) * D(row + j, column);
      largest = std::max(largest, std::fabs(to_double(static_cast<Quad>(D(row + 3 + i, column)) - torque)));
    }
  }
  return largest;
}

TEST(RigidFrictionTest, RowsAreExactButForTheSecondTangentOfAScene) {
  for (const int edges : {4, 8, 16}) {
    SCOPED_TRACE(edges);
    const Opened set = open("rigid/frictional/exp2{edges=" + std::to_string(edges) + "}");
    for (std::uint64_t trial = 0; trial < 50; ++trial) {
      const RigidSample sample = set.draw(trial);
      const Matrix D = to_dense(to_contact_problem(sample).D);
      ASSERT_EQ(D.cols(), edges * static_cast<Index>(sample.contacts.size()));
      for (Index column = 0; column < D.cols(); ++column) {
        const bool rounded = edges == 4 && column % 2 == 1;
        ASSERT_LE(largest_row_error(sample, D, edges, column), rounded ? 0x1p-50 : 0.0) << column;
      }
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

TEST(RigidFrictionTest, EightDirectionsAreAmongSixteen) {
  const Opened set = open("rigid/frictional/exp1");
  for (std::uint64_t trial = 0; trial < 50; ++trial) {
    for (const RigidContactSample& contact : set.draw(trial).contacts) {
      const std::vector<Triple> eight = friction_directions(contact, PyramidEdges::k8);
      const std::vector<Triple> sixteen = friction_directions(contact, PyramidEdges::k16);
      ASSERT_EQ(eight.size(), 4u);
      ASSERT_EQ(sixteen.size(), 8u);
      for (std::size_t k = 0; k < eight.size(); ++k) ASSERT_EQ(eight[k], sixteen[2 * k]);
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

TEST(RigidFrictionTest, FourEdgesAreASceneAndMoreAContactProblem) {
  const Problem scene = open_set("rigid/frictional/exp1")->generate(testing::kDrawSeed, 0);
  ASSERT_EQ(scene.kind(), ProblemKind::kScene);
  const Problem eight = open_set("rigid/frictional/exp1{edges=8}")->generate(testing::kDrawSeed, 0);
  ASSERT_EQ(eight.kind(), ProblemKind::kContact);
  EXPECT_EQ(eight.contact()->v, scene.contact()->v);
  EXPECT_EQ(eight.contact()->mu, scene.contact()->mu);
  EXPECT_EQ(to_dense(eight.contact()->N), to_dense(scene.contact()->N));
  EXPECT_EQ(eight.size(), eight.contact()->nc() * (8 + 2));
  EXPECT_EQ(scene.size(), eight.contact()->nc() * (4 + 2));
}

// Files hold what was drawn, and their readers accept every frame that is drawn.
TEST(RigidFrictionTest, ProblemsComeBackFromFiles) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "rigid_friction_test.json";
  for (const std::string name : {"exp1", "exp2{redundancy=combination}", "exp1{normals=axis}", "exp2{edges=8}"}) {
    const auto set = open_set("rigid/frictional/" + name);
    for (std::int64_t trial = 0; trial < 30; ++trial) {
      const Problem problem = set->generate(testing::kDrawSeed, trial);
      write_problem(problem, file);
      ASSERT_EQ(problem_hash(read_problem(file)), problem_hash(problem)) << name << " " << trial;
    }
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace lcpbench::rigid_friction_test
