#include "generators/made/made.h"

#include <Eigen/Eigenvalues>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench::made_test {
namespace {

Problem generate(const MadeSet& set, const std::string& options, std::int64_t trial) {
  return open_set(set.name + "{" + options + "}")->generate(1, trial);
}

/// The first rows of the free bodies, and the rows of the robots' blocks apart.
std::vector<Index> free_bodies(const BlockInertia& inertia) {
  std::vector<Index> rows;
  Index row = 0;
  for (std::size_t k = 0; k < inertia.blocks.size(); ++k) {
    const Matrix& block = inertia.blocks[k];
    if (block.rows() == 3 && block.isDiagonal(0) && block(0, 0) == block(1, 1) && k + 1 < inertia.blocks.size()) {
      rows.push_back(row);
      row += block.rows() + inertia.blocks[++k].rows();
    } else {
      row += block.rows();
    }
  }
  return rows;
}

TEST(MadeTest, InertiaIsPositiveDefiniteAndNoWorseConditionedThanItsBound) {
  for (const MadeSet& set : made_sets()) {
    for (std::int64_t trial = 0; trial < 20; ++trial) {
      const Problem problem = generate(set, "nc_max=100", trial);
      for (const Matrix& block : std::get<BlockInertia>(problem.contact()->inertia).blocks) {
        EXPECT_EQ(block, block.transpose());
        const Vector values = Eigen::SelfAdjointEigenSolver<Matrix>(block).eigenvalues();
        EXPECT_GT(values(0), 0) << problem.name();
        EXPECT_LE(values(values.size() - 1), 1.001e6 * values(0)) << problem.name();
      }
    }
  }
}

TEST(MadeTest, DirectionsAreOrthonormalAndComeInPairs) {
  for (const MadeSet& set : made_sets()) {
    int seen = 0;
    for (std::int64_t trial = 0; trial < 10; ++trial) {
      const Problem problem = generate(set, "nc_max=60", trial);
      const ContactProblem& contact = *problem.contact();
      const std::vector<Index> bodies = free_bodies(std::get<BlockInertia>(contact.inertia));
      const Matrix N = to_dense(contact.N);
      const Matrix D = to_dense(contact.D);
      Index column = 0;
      for (Index i = 0; i < contact.nc(); ++i) {
        const int edges = contact.edges[static_cast<std::size_t>(i)];
        EXPECT_EQ(D.middleCols(column, edges / 2), -D.middleCols(column + edges / 2, edges / 2)) << problem.name();
        for (const Index row : bodies) {
          const Eigen::Vector3d normal = N.block<3, 1>(row, i);
          if (normal.isZero(0)) continue;
          ++seen;
          EXPECT_NEAR(normal.norm(), 1, 1e-14) << problem.name();
          for (Index t = 0; t < edges; ++t) {
            const Eigen::Vector3d direction = D.block<3, 1>(row, column + t);
            EXPECT_NEAR(direction.norm(), 1, 1e-14) << problem.name();
            EXPECT_NEAR(direction.dot(normal), 0, 1e-14) << problem.name();
          }
        }
        column += edges;
      }
    }
    EXPECT_TRUE(seen > 0 || set.name == "made/robot" || set.name == "made/ragdolls") << set.name;
  }
}

TEST(MadeTest, TheNumberOfContactsIsNearItsAim) {
  for (const MadeSet& set : made_sets()) {
    for (const std::size_t aim : {std::size_t{10}, std::size_t{100}, static_cast<std::size_t>(set.features.nc_max)}) {
      const std::string size = std::to_string(aim);
      for (std::int64_t trial = 0; trial < (aim > 100 ? 1 : 8); ++trial) {
        const MadeReading reading = set.parse(set.name, {{"nc_min", size}, {"nc_max", size}, {"edges", "0"}});
        const auto nc = draw_made(set, reading, 1, static_cast<std::uint64_t>(trial)).N.size();
        EXPECT_GE(nc, aim / 2 - 2) << set.name << " " << trial;
        EXPECT_LE(nc, aim + aim / 4 + 12) << set.name << " " << trial;
      }
    }
  }
}

TEST(MadeTest, OptionsHold) {
  for (const MadeSet& set : made_sets()) {
    for (std::int64_t trial = 0; trial < 5; ++trial) {
      const Problem rough = generate(set, "nc_max=60,mu_min=0.5,mu_max=0.75,edges=6,offsets=0", trial);
      for (const int edges : rough.contact()->edges) EXPECT_EQ(edges, 6);
      EXPECT_GE(rough.contact()->mu.minCoeff(), 0.5);
      EXPECT_LE(rough.contact()->mu.maxCoeff(), 0.75);
      EXPECT_FALSE(rough.contact()->has_offset());
      EXPECT_FALSE(generate(set, "nc_max=60,edges=0", trial).contact()->frictional());
    }
  }
}

TEST(MadeTest, RefusesARangeOfFrictionThatIsEmpty) {
  EXPECT_THROW(open_set("made/tower{mu_min=3}"), InputError);  // mu_max is 2
  EXPECT_NO_THROW(open_set("made/tower{mu_min=3,mu_max=3}"));
  EXPECT_NO_THROW(open_set("made/hand{nc_min=1000}"));
}

TEST(MadeTest, BodiesAtRestHaveASolution) {
  for (const MadeSet& set : made_sets()) {
    for (std::int64_t trial = 0; trial < 6; ++trial) {
      const Problem problem = generate(set, "nc_max=40,motion=rest", trial);
      const auto solver = make_solver(parse_spec("auto"));
      solver->load(problem);
      Answer answer;
      solver->solve({.time_limit_s = 20}, answer);
      EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << problem.name();
    }
  }
}

TEST(MadeTest, ThePageStatesTheSplit) {
  std::map<std::string, std::string> uses;
  std::ifstream page(GENERATORS_PAGE);
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| `made/")) continue;
    const std::size_t end = line.find('`', 3);
    uses[line.substr(3, end - 3)] = line.find("| held out |") != std::string::npos ? "held out" : "for fits";
  }
  ASSERT_EQ(uses.size(), made_sets().size());
  std::size_t held_out = 0;
  for (const MadeSet& set : made_sets()) {
    EXPECT_EQ(uses[set.name], set.features.held_out ? "held out" : "for fits") << set.name;
    held_out += set.features.held_out ? 1 : 0;
  }
  EXPECT_EQ(held_out, made_sets().size() / 2);
}

}  // namespace
}  // namespace lcpbench::made_test
