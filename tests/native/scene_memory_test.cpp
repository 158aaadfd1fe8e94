#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "core/io/problem_io.h"
#include "core/registry.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/brick_wall.h"

namespace lcpbench {
namespace {

/// The most memory that this process has held so far [kB]; -1 where the system does not tell.
long most_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    long kilobytes = -1;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes;
  }
  return -1;
}

// From a file to a verified answer. One dense matrix over the 7,800 coordinates alone would take 490 MB, one of the
// 60,000 rows 29 GB.
TEST(SceneMemoryTest, TenThousandFrictionalContactsTakeLessThanHalfAGigabyte) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "lcpbench_scene_memory_test.json";
  write_problem(Problem("wall", testing::frictional_brick_wall(33, 40, 0.5)), file);
  const Problem problem = read_problem(file);
  std::filesystem::remove(file);
  ASSERT_GE(problem.contact()->nc(), 10'000);
  const auto solver = find_solver("auto").definition.make({});
  solver->load(problem);
  Answer answer;
  solver->solve({}, answer);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_TRUE(Evaluator(problem).errors(answer).solved);
  const Vector impulses = answer.z.head(contact_layout(*problem.contact()).lambda_offset());
  EXPECT_EQ(complete_impulses(*problem.contact(), impulses).size(), problem.size());  // as the solver `engine` does
  const long kilobytes = most_memory();
  if (kilobytes < 0) GTEST_SKIP() << "no /proc/self/status";
  EXPECT_LE(kilobytes, 500'000);  // twice what it takes
}

}  // namespace
}  // namespace lcpbench
