// The samples of the generators as problems: every number in its place. tests/golden has hashes of the samples.

#include "generators/to_problem.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "generators/rest/rest.h"
#include "tests/generators/opened_set.h"

namespace lcpbench::to_problem_test {
namespace {

void expect_equal(const Matrix& found, const ColumnMajor<double>& sample) {
  ASSERT_EQ(found.rows(), static_cast<Index>(sample.rows));
  ASSERT_EQ(found.cols(), static_cast<Index>(sample.cols));
  EXPECT_EQ(std::vector<double>(found.data(), found.data() + found.size()), sample.data);
}

std::vector<double> numbers(const Vector& x) { return {x.begin(), x.end()}; }

void expect_equal(const ContactProblem& found, const PaperSample& sample) {
  EXPECT_EQ(numbers(found.v), sample.v);
  EXPECT_EQ(numbers(found.mu), sample.mu);
  EXPECT_EQ(found.edges, sample.edges);
  expect_equal(to_dense(found.N), sample.N);
  expect_equal(to_dense(found.D), sample.D);
  if (sample.form == InertiaForm::kFactored) {
    expect_equal(std::get<FactoredInertia>(found.inertia).X, sample.X);
    EXPECT_EQ(numbers(std::get<FactoredInertia>(found.inertia).alpha), sample.alpha);
  } else if (sample.form == InertiaForm::kInverse) {
    expect_equal(std::get<InverseInertia>(found.inertia).Ginv, sample.G);
  } else {
    expect_equal(std::get<DenseInertia>(found.inertia).G, sample.G);
  }
}

TEST(ToProblemTest, OfThePaper) {
  for (const char* name : {"paper/copositive/exp2{redundancy=combination}", "paper/monotone/exp3",
                           "paper/monotone/exp3{matrix=literal}"}) {
    const auto set = testing::opened_set<draw_paper>(paper_sets(), name);
    for (std::uint64_t trial = 0; trial < 5; ++trial) {
      expect_equal(to_contact_problem(set.draw(trial)), set.draw(trial));
    }
  }
}

TEST(ToProblemTest, OfRigidBodies) {
  const auto set = testing::opened_set<draw_rigid>(rigid_sets(), "rigid/frictional/exp1");
  for (std::uint64_t trial = 0; trial < 5; ++trial) {
    const RigidSample sample = set.draw(trial);
    const RigidScene scene = to_scene(sample);
    ASSERT_EQ(scene.bodies.size(), sample.bodies.size());
    for (std::size_t k = 0; k < sample.bodies.size(); ++k) {
      EXPECT_EQ(scene.bodies[k].mass, sample.bodies[k].mass);
      expect_equal(scene.bodies[k].inertia, sample.bodies[k].inertia);
      EXPECT_EQ(numbers(scene.bodies[k].position), numbers(Eigen::Vector3d(sample.bodies[k].position.data())));
      EXPECT_EQ(scene.bodies[k].linear_velocity, Eigen::Vector3d(sample.bodies[k].linear_velocity.data()));
      EXPECT_EQ(scene.bodies[k].angular_velocity, Eigen::Vector3d(sample.bodies[k].angular_velocity.data()));
    }
    ASSERT_EQ(scene.contacts.size(), sample.contacts.size());
    for (std::size_t k = 0; k < sample.contacts.size(); ++k) {
      const RigidContact& found = scene.contacts[k];
      const RigidContactSample& drawn = sample.contacts[k];
      EXPECT_TRUE(found.body_a == drawn.body_a && found.body_b == drawn.body_b && found.mu == drawn.mu) << k;
      EXPECT_EQ(found.edges, 4);
      EXPECT_EQ(found.point, Eigen::Vector3d(drawn.point.data()));
      EXPECT_EQ(found.normal, Eigen::Vector3d(drawn.normal.data()));
      EXPECT_EQ(found.tangent, Eigen::Vector3d(drawn.tangent.data()));
    }
  }
}

void expect_equal(const Jacobian& found, const std::vector<MadeSample::Column>& columns) {
  Matrix expected = Matrix::Zero(to_dense(found).rows(), static_cast<Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (const auto& [row, entry] : columns[j]) expected(static_cast<Index>(row), static_cast<Index>(j)) = entry;
  }
  EXPECT_EQ(to_dense(found), expected);
}

TEST(ToProblemTest, OfMadeAndRestingBodies) {
  std::vector<MadeSample> samples;
  for (const char* name : {"made/hand{nc_max=40}", "made/tower{nc_max=40}"}) {
    samples.push_back(testing::opened_set<draw_made>(made_sets(), name).draw(0));
  }
  for (const RestSet& set : rest_sets()) {
    for (std::uint64_t trial = 0; trial < 4; ++trial) {
      samples.push_back(testing::opened_set<draw_rest>(rest_sets(), set.name).draw(trial));
    }
  }
  bool dense = false;
  for (const MadeSample& sample : samples) {
    const ContactProblem found = to_contact_problem(sample);
    EXPECT_EQ(numbers(found.v), sample.v);
    EXPECT_EQ(numbers(found.mu), sample.mu);
    EXPECT_EQ(found.edges, sample.edges);
    expect_equal(found.N, sample.N);
    expect_equal(found.D, sample.D);
    for (Index c = 0; c < found.nc(); ++c) EXPECT_EQ(found.offset(c), sample.b[static_cast<std::size_t>(c)]) << c;
    const Matrix G = dense_inertia(found.inertia);
    Index row = 0;
    for (const ColumnMajor<double>& block : sample.blocks) {
      const auto size = static_cast<Index>(block.rows);
      expect_equal(G.block(row, row, size, size), block);
      row += size;
    }
    EXPECT_EQ(row, found.ngc());
    dense = dense || std::holds_alternative<DenseInertia>(found.inertia);
  }
  EXPECT_TRUE(dense);
}

TEST(ToProblemTest, OfPlantedAndHardCases) {
  const PlantedSample planted = testing::opened_set<draw_planted>(planted_sets(), "planted/definite").draw(3);
  expect_equal(to_lcp(planted).M, planted.M);
  EXPECT_EQ(numbers(to_lcp(planted).q), planted.q);
  const Lcp formed = form_lcp(to_contact_problem(planted));
  EXPECT_EQ(formed.M, to_lcp(planted).M);
  EXPECT_EQ(formed.q, to_lcp(planted).q);
  for (const HardSet& set : hard_sets()) {
    const HardCase hard = set.make(set.name, {});
    if (hard.contact) {
      expect_equal(to_contact_problem(*hard.contact), *hard.contact);
    } else {
      expect_equal(to_lcp(hard).M, hard.M);
      EXPECT_EQ(numbers(to_lcp(hard).q), hard.q);
    }
  }
}

}  // namespace
}  // namespace lcpbench::to_problem_test
