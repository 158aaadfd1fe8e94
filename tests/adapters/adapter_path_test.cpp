// The adapter for PATH against stand-ins for its library: the order of the calls, the callbacks, the two layouts of its
// structures, its licence, its options, and what is said when it is not there.

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "adapters/worker/worker_client.h"

namespace lcpbench {
std::string lcpbench_unavailable_path();
std::string lcpbench_version_path();
}

namespace lcpbench::adapter_path_test {
namespace {

class PathTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    setenv("PATH_LIBRARY", GetParam(), 1);
    unsetenv("PATH_LICENSE_STRING");
  }
  void TearDown() override {
    unsetenv("PATH_LIBRARY");
    unsetenv("PATH_LICENSE_STRING");
  }

  static Answer solve(const Lcp& lcp, const Options& options = {}) {
    TimedAnswer result;
    worker_solver(PATH_WORKER, Spec{"path", options})->run(Problem("a problem", lcp), {}, result);
    return result.answer;
  }
};

INSTANTIATE_TEST_SUITE_P(Versions, PathTest, ::testing::Values(STAND_IN_5, STAND_IN_4), [](const auto& test) {
  return std::filesystem::path(test.param).filename().string().find("4") == std::string::npos ? "Five" : "Four";
});

// z = (1, 0, 2), w = (0, 3, 0) by construction; M is not symmetric, no two of its entries are alike, one is zero.
Lcp nonsymmetric() {
  Lcp lcp;
  lcp.M = Matrix{{5.0, 4.0, -2.0}, {0.0, 6.0, 1.0}, {2.5, -3.0, 7.0}};
  lcp.q = Vector{{0.0, 3.0, 0.0}} - lcp.M * Vector{{1.0, 0.0, 2.0}};
  return lcp;
}

TEST_P(PathTest, SolvesThroughTheCallbacks) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const Answer answer = solve(nonsymmetric(), {{"tolerance", "1e-14"}});
  const std::string printed = ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(printed, "");
  EXPECT_STREQ(to_string(answer.claim), "solved") << answer.detail;
  ASSERT_EQ(answer.z.size(), 3);
  EXPECT_LE((answer.z - Vector{{1.0, 0.0, 2.0}}).lpNorm<Eigen::Infinity>(), 1e-13) << answer.z.transpose();
}

TEST_P(PathTest, CountersAreReadFromTheRightPlace) {
  const Answer answer = solve(nonsymmetric());
  EXPECT_EQ(answer.counters.iterations, 7) << answer.detail;
  EXPECT_EQ(answer.counters.pivots, 42);
}

TEST_P(PathTest, OneProcessSolvesManyProblems) {
  const auto solver = worker_solver(PATH_WORKER, Spec{"path", {}});
  for (const double q : {-1.0, 2.0, -3.0}) {
    TimedAnswer result;
    solver->run(Problem("one unknown", Lcp{Matrix{{2.0}}, Vector{{q}}}), {}, result);
    EXPECT_STREQ(to_string(result.answer.claim), "solved") << result.answer.detail;
    ASSERT_EQ(result.answer.z.size(), 1);
    EXPECT_EQ(result.answer.z(0), std::max(0.0, -q / 2));
  }
}

TEST_P(PathTest, ToleranceReachesTheLibrary) {
  const Lcp lcp{Matrix{{1.0}}, Vector{{-1e-4}}};
  EXPECT_EQ(solve(lcp).z, Vector{{1e-4}});
  EXPECT_EQ(solve(lcp, {{"tolerance", "1e-3"}}).z, Vector{{0.0}});
}

TEST_P(PathTest, IterationLimitReachesTheLibraryAndIsClaimed) {
  EXPECT_STREQ(to_string(solve(nonsymmetric(), {{"major_iterations", "1"}}).claim), "iteration_limit");
}

TEST_P(PathTest, FailureIsClaimed) {
  const Answer answer = solve(Lcp{Matrix{{0.0}}, Vector{{-1.0}}});  // has no solution; and no nonzero
  EXPECT_STREQ(to_string(answer.claim), "numerical_failure");
  EXPECT_NE(answer.detail.find("no progress"), std::string::npos) << answer.detail;
}

// Without a licence PATH solves up to 2000 nonzeros: 45 are fewer, 45^2 are more.
TEST_P(PathTest, LicenceIsNeededForLargeProblems) {
  EXPECT_STREQ(to_string(solve(Lcp{Matrix::Identity(45, 45), Vector::Ones(45)}).claim), "solved");
  const Lcp large{Matrix::Ones(45, 45), Vector::Ones(45)};
  const Answer refused = solve(large);
  EXPECT_STREQ(to_string(refused.claim), "unsupported") << refused.detail;
  EXPECT_NE(refused.detail.find("PATH_LICENSE_STRING"), std::string::npos) << refused.detail;
  setenv("PATH_LICENSE_STRING", "no licence", 1);
  EXPECT_STREQ(to_string(solve(large).claim), "unsupported");
  setenv("PATH_LICENSE_STRING", "a licence for everything", 1);
  EXPECT_STREQ(to_string(solve(large).claim), "solved");
}

std::string start_error() {
  try {
    TimedAnswer result;
    worker_solver(PATH_WORKER, Spec{"path", {}})->run(Problem("empty", Lcp{}), {}, result);
    return "it starts";
  } catch (const WorkerError& error) {
    return error.what();
  }
}

TEST(PathAvailabilityTest, TellsWhatToSet) {
  unsetenv("PATH_LIBRARY");
  EXPECT_NE(lcpbench_unavailable_path().find("set PATH_LIBRARY"), std::string::npos);
  setenv("PATH_LIBRARY", "/nowhere/libpath50.so", 1);
  EXPECT_NE(lcpbench_unavailable_path().find("libpath50.so"), std::string::npos);
  EXPECT_EQ(lcpbench_unavailable_path().find("nowhere"), std::string::npos) << "stands in reports";
  setenv("PATH_LIBRARY", std::filesystem::path(STAND_IN_5).parent_path().c_str(), 1);
  EXPECT_NE(lcpbench_unavailable_path(), "") << "a folder is no library";
  setenv("PATH_LIBRARY", STAND_IN_5, 1);
  EXPECT_EQ(lcpbench_unavailable_path(), "");
  unsetenv("PATH_LIBRARY");
}

std::string version_of(const std::filesystem::path& library) {
  setenv("PATH_LIBRARY", library.c_str(), 1);
  const std::string version = lcpbench_version_path();
  unsetenv("PATH_LIBRARY");
  return version;
}

TEST(PathVersionTest, IsTheFilesNameAndContent) {
  const std::string five = version_of(STAND_IN_5);
  EXPECT_TRUE(five.starts_with("libpath_stand_in_5.so ")) << five;
  EXPECT_EQ(version_of(STAND_IN_5), five);
  EXPECT_EQ(version_of("libpath50.so"), "libpath50.so");  // only the dynamic linker knows which
  EXPECT_EQ(version_of(""), "");
}

TEST(PathAvailabilityTest, LibraryThatDoesNotOpenIsNamed) {
  setenv("PATH_LIBRARY", "libpath_that_is_nowhere.so", 1);
  EXPECT_EQ(lcpbench_unavailable_path(), "");  // only the dynamic linker knows
  EXPECT_NE(start_error().find("libpath_that_is_nowhere.so"), std::string::npos) << start_error();
  setenv("PATH_LIBRARY", "/bin/sh", 1);
  EXPECT_NE(start_error().find("PATH_LIBRARY"), std::string::npos) << start_error();
  setenv("PATH_LIBRARY", "libm.so.6", 1);
  EXPECT_NE(start_error().find("has no Path_Version"), std::string::npos) << start_error();
  unsetenv("PATH_LIBRARY");
}

TEST(PathAvailabilityTest, RelativeNamesAreRelativeToWhereTheProgramStarted) {
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(std::filesystem::path(STAND_IN_5).parent_path());
  setenv("PATH_LIBRARY", "./libpath_stand_in_5.so", 1);
  EXPECT_EQ(start_error(), "it starts");
  std::filesystem::current_path(before);
  unsetenv("PATH_LIBRARY");
}

}  // namespace
}  // namespace lcpbench::adapter_path_test
