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

const std::vector<std::string> kEverySetAndReading = {
    "rigid/exp1",
    "rigid/exp1{normals=axis}",
    "rigid/exp1{bodies_max=8,nc_max=40}",
    "rigid/exp2",
    "rigid/exp2{redundancy=combination}",
    "rigid/exp2{redundancy=combination,normals=axis}",
    "rigid/exp5-1e5",
    "rigid/exp5-1e8{redundancy=combination}",
    "rigid/exp5-1e10",
};

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

bool on_grid(const Triple& values, double step, double bound) {
  return std::all_of(values.begin(), values.end(), [&](double value) {
    return std::fabs(value) <= bound && std::trunc(value / step) == value / step;
  });
}

ColumnMajor<double> normals_of(const RigidSample& sample) {
  const Matrix N = to_dense(contact_problem(to_scene(sample)).N);
  ColumnMajor<double> result(static_cast<std::size_t>(N.rows()), static_cast<std::size_t>(N.cols()));
  std::copy(N.data(), N.data() + N.size(), result.data.begin());
  return result;
}

TEST(RigidGeneratorTest, BodiesAndContactsAreInRange) {
  for (const std::string& name : kEverySetAndReading) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
      const RigidSample sample = set.draw(trial);
      const auto bodies = static_cast<int>(sample.bodies.size());
      ASSERT_TRUE(bodies >= 1 && bodies <= set.reading.bodies_max);
      ASSERT_TRUE(sample.contacts.size() >= 2 && static_cast<int>(sample.contacts.size()) <= set.reading.nc_max);
      for (const RigidBodySample& body : sample.bodies) {
        ASSERT_TRUE(on_grid(body.position, 0x1p-10, 1));
        ASSERT_TRUE(on_grid(body.linear_velocity, kGridStep, 1));
        ASSERT_TRUE(on_grid(body.angular_velocity, kGridStep, 1));
      }
      for (const RigidContactSample& contact : sample.contacts) {
        ASSERT_TRUE(contact.body_a >= 0 && contact.body_a < bodies);
        ASSERT_TRUE(contact.body_b >= -1 && contact.body_b < bodies && contact.body_b != contact.body_a);
        ASSERT_TRUE(on_grid(contact.point, 0x1p-10, 1.5));
        ASSERT_TRUE(on_grid(contact.normal, 0x1p-40, 1));
      }
    }
  }
}

// An inertia tensor belongs to a mass distribution exactly when trace/2 I - inertia is positive semidefinite.
TEST(RigidGeneratorTest, BodiesAreRealBodies) {
  for (const std::string& name : kEverySetAndReading) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    for (std::uint64_t trial = 0; trial < 100; ++trial) {
      for (const RigidBodySample& body : set.draw(trial).bodies) {
        ASSERT_GT(body.mass, 0);
        ASSERT_TRUE(checks::symmetric(body.inertia));
        ASSERT_TRUE(checks::positive_definite(body.inertia));
        const Quad half_trace = (static_cast<Quad>(body.inertia(0, 0)) + body.inertia(1, 1) + body.inertia(2, 2)) / 2;
        // Scaling rounds each entry, so by a few units in the last place of the trace.
        ASSERT_TRUE(checks::definite_after_shift(body.inertia, half_trace * (1 + 0x1p-50), -1));
      }
    }
  }
}

TEST(RigidGeneratorTest, NormalsHaveLengthOne) {
  for (const std::string& name : kEverySetAndReading) {
    const Opened set = open(name);
    for (std::uint64_t trial = 0; trial < 100; ++trial) {
      for (const RigidContactSample& contact : set.draw(trial).contacts) {
        Quad square = 0;
        for (const double component : contact.normal) square += static_cast<Quad>(component) * component;
        const double excess = to_double(square - 1);
        if (set.reading.normals == NormalReading::kAxis) {
          ASSERT_EQ(excess, 0);
        } else {
          ASSERT_LE(std::fabs(excess), 2e-12);
        }
      }
    }
  }
}

// The rows [n; r x n] in double are the exact ones.
TEST(RigidGeneratorTest, ContactRowsAreExact) {
  for (const std::string& name : kEverySetAndReading) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    for (std::uint64_t trial = 0; trial < 100; ++trial) {
      const RigidSample sample = set.draw(trial);
      const ColumnMajor<double> N = normals_of(sample);
      ASSERT_EQ(N.rows, 6 * sample.bodies.size());
      for (std::size_t c = 0; c < sample.contacts.size(); ++c) {
        const RigidContactSample& contact = sample.contacts[c];
        for (std::size_t b = 0; b < sample.bodies.size(); ++b) {
          const int body = static_cast<int>(b);
          const int sign = (contact.body_a == body ? 1 : 0) - (contact.body_b == body ? 1 : 0);
          std::array<Quad, 3> arm;
          for (std::size_t i = 0; i < 3; ++i) {
            arm[i] = static_cast<Quad>(contact.point[i]) - sample.bodies[b].position[i];
          }
          for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            const std::size_t k = (i + 2) % 3;
            const Quad torque = arm[j] * contact.normal[k] - arm[k] * contact.normal[j];
            ASSERT_TRUE(static_cast<Quad>(N(6 * b + i, c)) == sign * static_cast<Quad>(contact.normal[i]));
            ASSERT_TRUE(static_cast<Quad>(N(6 * b + 3 + i, c)) == sign * torque);
          }
        }
      }
    }
  }
}

TEST(RigidGeneratorTest, DependentContactsDependExactly) {
  for (const std::string& name : kEverySetAndReading) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    const bool combination = set.reading.redundancy == Redundancy::kCombination;
    for (std::uint64_t trial = 0; trial < 100; ++trial) {
      const RigidSample sample = set.draw(trial);
      const ColumnMajor<double> N = normals_of(sample);
      const std::size_t independent = sample.contacts.size() - sample.dependences.size();
      for (const RigidDependence& one : sample.dependences) {
        ASSERT_GE(one.contact, independent);
        ASSERT_TRUE(one.first < independent && one.second < independent);
        ASSERT_EQ(one.quarter != 0, combination && independent > 1);
        for (std::size_t row = 0; row < N.rows; ++row) {
          const Quad sum = (4 - one.quarter) * static_cast<Quad>(N(row, one.first)) +
                           one.quarter * static_cast<Quad>(N(row, one.second));
          ASSERT_TRUE(sum == 4 * static_cast<Quad>(N(row, one.contact)));
        }
        const bool at_source = same(sample.contacts[one.contact], sample.contacts[one.first]);
        ASSERT_EQ(at_source, one.quarter == 0);
      }
    }
  }
}

// Masses end exactly at 1 or `condition`; tensors, of condition at most 64, within their rounding.
TEST(RigidGeneratorTest, ConditionedInertiaHasTheEigenvaluesOneAndCondition) {
  const std::pair<const char*, double> conditions[] = {{"1e5", 1e5}, {"1e8", 1e8}, {"1e10", 1e10}};
  const double slack = 64 * 0x1p-50;
  for (const auto& [label, condition] : conditions) {
    const Opened set = open(std::string("rigid/exp5-") + label);
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
      bool reaches_one = false;
      bool reaches_condition = false;
      for (const RigidBodySample& body : set.draw(trial).bodies) {
        const Quad high = static_cast<Quad>(condition);
        ASSERT_TRUE(body.mass >= 1 && body.mass <= condition);
        ASSERT_TRUE(checks::definite_after_shift(body.inertia, 1 - static_cast<Quad>(slack), 1));
        ASSERT_TRUE(checks::definite_after_shift(body.inertia, high * (1 + static_cast<Quad>(slack)), -1));
        reaches_one |= body.mass == 1 || !checks::definite_after_shift(body.inertia, 1 + static_cast<Quad>(slack), 1);
        reaches_condition |= body.mass == condition ||
                             !checks::definite_after_shift(body.inertia, high * (1 - static_cast<Quad>(slack)), -1);
      }
      ASSERT_TRUE(reaches_one && reaches_condition) << label << " " << trial;
    }
  }
}

TEST(RigidGeneratorTest, ExperimentSixHasTheProblemsOfExperimentFive) {
  for (const std::string condition : {"1e5", "1e8", "1e10"}) {
    const Opened five = open("rigid/exp5-" + condition);
    const Opened six = open("rigid/exp6-" + condition);
    for (std::uint64_t trial = 0; trial < 20; ++trial) ASSERT_TRUE(same(five.draw(trial), six.draw(trial)));
  }
}

TEST(RigidGeneratorTest, ATrialIsTheSameAloneInABatchAndInTwoThreads) {
  testing::expect_order_and_threads_do_not_matter(
      open("rigid/exp5-1e8{redundancy=combination}"),
      [](const RigidSample& a, const RigidSample& b) { return same(a, b); });
}

// --- friction ---

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
