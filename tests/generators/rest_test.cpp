#include "generators/rest/rest.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "generators/sets.h"
#include "tests/generators/opened_set.h"

namespace lcpbench::rest_test {
namespace {

constexpr std::uint64_t kSeed = 72;

using Opened = testing::OpenedSet<RestSet, draw_rest>;

Opened opened(const RestSet& set, const std::string& options) {
  return testing::opened_set<draw_rest>(rest_sets(), set.name + "{" + options + "}");
}

ContactProblem problem_of(const RestSet& set, const std::string& options, std::int64_t trial) {
  return *open_set(set.name + "{" + options + "}")->generate(kSeed, trial).contact();
}

TEST(RestTest, OptionsHold) {
  for (const RestSet& set : rest_sets()) {
    for (std::uint64_t trial = 0; trial < 20; ++trial) {
      EXPECT_LE(opened(set, "nc_max=24").draw(trial, kSeed).mu.size(), 24U) << set.name;
    }
    EXPECT_THROW(open_set(set.name + "{margin=1}"), InputError);
  }
}

/// The directions in which the contacts can push, scaled by masses and to length 1: corners of the closed contacts'
/// cones.
Matrix cone_corners(const ContactProblem& problem, const Vector& row_scale) {
  const Matrix N = to_dense(problem.N), D = to_dense(problem.D);
  Matrix corners(problem.ngc(), D.cols());
  Index count = 0, column = 0;
  for (Index i = 0; i < problem.nc(); ++i) {
    for (int k = 0; k < problem.edges[static_cast<std::size_t>(i)]; ++k, ++column) {
      if (problem.offset(i) > 0) continue;
      corners.col(count++) = (row_scale.cwiseProduct(N.col(i) + problem.mu(i) * D.col(column))).normalized();
    }
  }
  return corners.leftCols(count);
}

/// The part of p that no x >= 0 reaches by A x. [Lawson and Hanson 1974, chapter 23]
Vector unreached(const Matrix& A, const Vector& p) {
  std::vector<Index> used;
  Vector x = Vector::Zero(A.cols());
  const auto columns = [&] { return Matrix(A(Eigen::all, used)); };
  for (int round = 0; round < 2000; ++round) {
    const Vector rest = p - A * x;
    Index best = 0;
    if ((A.transpose() * rest).maxCoeff(&best) <= 1e-9 * rest.norm() || rest.norm() < 1e-13) break;
    if (std::find(used.begin(), used.end(), best) != used.end()) break;  // as good as rounding lets it be
    used.push_back(best);
    for (;;) {
      const Vector solution = columns().colPivHouseholderQr().solve(p);
      double step = 1;
      for (std::size_t k = 0; k < used.size(); ++k) {
        const double value = x(used[k]), next = solution(static_cast<Index>(k));
        if (next <= 0) step = std::min(step, value / (value - next));
      }
      for (std::size_t k = 0; k < used.size(); ++k) {
        double& value = x(used[k]);
        value += step * (solution(static_cast<Index>(k)) - value);
        if (solution(static_cast<Index>(k)) <= 0 && value < 1e-15) value = 0;
      }
      if (step == 1) break;
      std::erase_if(used, [&](Index j) { return x(j) == 0; });
    }
  }
  return p - A * x;
}

struct Reach {
  double missing = 0;  ///< share of the load that the contacts cannot carry
  double leak = 0;     ///< how far the missing part is from a proof: its largest product with a corner, per its length
};

/// @param margin  by which each mu is divided first
Reach reach(ContactProblem problem, double margin) {
  problem.mu /= margin;
  const Matrix G = dense_inertia(problem.inertia);
  const Vector row_scale = G.diagonal().cwiseSqrt().cwiseInverse();
  const Vector load = row_scale.cwiseProduct(-(G * problem.v)).normalized();
  const Matrix corners = cone_corners(problem, row_scale);
  const Vector missing = unreached(corners, load);
  return {missing.norm(), (corners.transpose() * missing).maxCoeff() / missing.norm()};
}

// By least squares over the cones: the generator's own balance is not asked for.
TEST(RestTest, TheContactsCarryTheLoadWithTheMargin) {
  for (const RestSet& set : rest_sets()) {
    for (const double margin : {1.05, 3.0, 30.0}) {
      const std::string options = "nc_max=20,margin=" + std::to_string(margin);
      for (std::int64_t trial = 0; trial < 60; ++trial) {
        const ContactProblem problem = problem_of(set, options, trial);
        // A corner of the cones is rounded as v is: some 100 products of relative error 1e-16.
        const Reach found = reach(problem, margin * (1 - 1e-12));
        EXPECT_LT(found.missing, 1e-10) << set.name << " " << options << " " << trial << " " << found.leak;
      }
    }
  }
}

// What they cannot carry is a direction against all corners: a proof.
TEST(RestTest, BelowAMarginOfOneTheyCannot) {
  for (const RestSet& set : rest_sets()) {
    for (const std::string options : {"nc_max=20,margin=0.95", "nc_max=20,margin=0.5"}) {
      for (std::int64_t trial = 0; trial < 60; ++trial) {
        const Reach found = reach(problem_of(set, options, trial), 1);
        EXPECT_GT(found.missing, 1e-5) << set.name << " " << options << " " << trial;
        EXPECT_LT(found.leak, 1e-6) << set.name << " " << options << " " << trial;
      }
    }
  }
}

}  // namespace
}  // namespace lcpbench::rest_test
