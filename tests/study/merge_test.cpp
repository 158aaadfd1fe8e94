// What a user relies on: a merge adds every row once, or says why it adds none, and leaves its inputs as they are.

#include "study/store/merge.h"

#include <filesystem>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "tests/study/filled_store.h"

namespace lcpbench::merge_test {
namespace {

namespace fs = std::filesystem;

/// Notes on how a time was taken stand in the detail, and depend on the clock.
TEST(MergeTest, DetailsThatDifferAreNoConflictAndTheFirstStays) {
  const ScratchFolder folder;
  fill(folder / "a.db");
  fs::copy_file(folder / "a.db", folder / "b.db");
  change_rows(folder / "b.db", "UPDATE answers SET detail = 'the time is that of one solve'");
  const MergeOutcome outcome = merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"});
  EXPECT_TRUE(outcome.conflicts.empty());
  EXPECT_EQ(dump(folder / "out.db"), dump(folder / "a.db"));
  EXPECT_NO_THROW(Store::open_for_reading(folder / "out.db").check());
}

TEST(MergeTest, DraftOfAConflictLeavesNothing) {
  const ScratchFolder folder;
  fill(folder / "a.db");
  fs::copy_file(folder / "a.db", folder / "b.db");
  change_rows(folder / "b.db", "UPDATE answers SET pivots = pivots + 1");
  const std::string before = dump(folder / "b.db");
  const std::vector<std::string> conflicts =
      merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"}).conflicts;
  ASSERT_EQ(conflicts.size(), 21U);  // as many as are shown, and a line for the others
  EXPECT_EQ(conflicts.back(), (folder / "b.db").string() + ": answers: 40 more");
  EXPECT_EQ(dump(folder / "b.db"), before);
  for (const char* name : {"out.db", "out.db.merging", "out.db.merging-wal"}) EXPECT_FALSE(fs::exists(folder / name));
}

/// A store whose ids are not those of its rows would give two rows of one name.
TEST(MergeTest, InputsHaveAnyNameAndAreNotWritten) {
  const ScratchFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder / "");
  std::int64_t cells = 0;
  for (const char* name : {"a?mode=memory.db", "100%41.db", "#.db", "file:x.db", ":memory:", "two words.db"}) {
    fill(name, cells / 4);
    const std::string content = rows(name);
    EXPECT_EQ(merge_stores("out.db", {name}).cells, cells += 60) << name;
    EXPECT_EQ(rows(name), content);
    EXPECT_FALSE(fs::exists(name + std::string("-wal"))) << name;
  }
  fs::current_path(before);
}

/// Only so many inputs are read at once.
TEST(MergeTest, ManyInputsAreMergedLikeFew) {
  const ScratchFolder folder;
  fill(folder / "a.db");
  fill(folder / "b.db", 15);
  fs::copy_file(folder / "a.db", folder / "c.db");
  change_rows(folder / "c.db", "UPDATE answers SET pivots = pivots + 1");
  std::vector<fs::path> inputs(251, folder / "a.db");
  inputs.push_back(folder / "b.db");
  EXPECT_EQ(merge_stores(folder / "out.db", inputs).cells, 120);
  merge_stores(folder / "few.db", {folder / "a.db", folder / "b.db"});
  EXPECT_EQ(checked_rows(folder / "out.db"), checked_rows(folder / "few.db"));
  inputs.push_back(folder / "c.db");
  const std::vector<std::string> conflicts = merge_stores(folder / "other.db", inputs).conflicts;
  ASSERT_EQ(conflicts.size(), 21U);
  EXPECT_TRUE(conflicts[0].starts_with((folder / "c.db").string() + ": answers: paper/monotone/exp")) << conflicts[0];
}

void fill_with_run(const fs::path& file, const std::string& commit, int trials, int jobs, std::int64_t first_trial) {
  fill(file, first_trial);
  Store store = Store::open_for_writing(file);
  store.begin();
  store.add_run("2026-02-01T12:00:00Z", R"({"lcpbench": "0.1.0", "commit": ")" + commit +
                                            R"(", "plan": {"name": "p", "seed": 1, "trials": )" +
                                            std::to_string(trials) + R"(, "jobs": )" + std::to_string(jobs) + "}}");
  store.commit();
}

/// Shards that other versions made, or of another plan, look like parts of one study: their problems are disjoint.
TEST(MergeTest, StoresOfOtherVersionsOrPlansAreRefusedWithOneLine) {
  const ScratchFolder folder;
  fill_with_run(folder / "a.db", "abc", 30, 1, 0);
  fill_with_run(folder / "jobs.db", "abc", 30, 4, 15);
  fill_with_run(folder / "commit.db", "def", 30, 1, 15);
  fill_with_run(folder / "plan.db", "abc", 40, 1, 15);
  const auto error_with = [&](const char* other) {
    return input_error([&] { merge_stores(folder / "out.db", {folder / "a.db", folder / other}); });
  };
  const std::string middle =
      " and " + (folder / "a.db").string() + " are not parts of one study, their runs differ in ";
  const std::string end = ": nothing was merged; --mixed joins them";
  EXPECT_EQ(error_with("commit.db"), (folder / "commit.db").string() + middle + "commit" + end);
  EXPECT_EQ(error_with("plan.db"), (folder / "plan.db").string() + middle + "plan/trials" + end);
  EXPECT_FALSE(fs::exists(folder / "out.db"));
  EXPECT_EQ(error_with("jobs.db"), "no InputError");
  EXPECT_EQ(
      input_error([&] { merge_stores(folder / "out.db", {folder / "plan.db"}); }).find((folder / "plan.db").string()),
      0U)
      << "a store that is there counts as the first";
  EXPECT_TRUE(merge_stores(folder / "mixed.db", {folder / "a.db", folder / "plan.db"}, {}, true).conflicts.empty());
}

TEST(MergeTest, ProblemsWithOtherDataAreOneLine) {
  const ScratchFolder folder;
  fill(folder / "a.db");
  fs::copy_file(folder / "a.db", folder / "b.db");
  change_rows(folder / "b.db", "UPDATE problems SET hash = '11'");
  const std::vector<std::string> conflicts =
      merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"}).conflicts;
  ASSERT_EQ(conflicts.size(), 1U);
  EXPECT_TRUE(conflicts[0].starts_with((folder / "b.db").string() + ": problems: paper/monotone/exp")) << conflicts[0];
  EXPECT_TRUE(conflicts[0].ends_with("has other data than in the stores before it")) << conflicts[0];
  EXPECT_FALSE(fs::exists(folder / "out.db"));
}

TEST(MergeTest, ConflictNamesTheLargestSeed) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "a.db");
  ProblemResult result = made.result("paper/monotone/exp1", 0, {{made.solver("lemke"), {}}}, 0, "", "contact");
  result.problem.seed = std::numeric_limits<std::uint64_t>::max();
  made.store().begin();
  made.store().add(result);
  made.store().commit();
  made.store().database().execute("PRAGMA wal_checkpoint(TRUNCATE)");
  fs::copy_file(folder / "a.db", folder / "b.db");
  change_rows(folder / "b.db", "UPDATE answers SET pivots = pivots + 1");
  const MergeOutcome outcome = merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"});
  EXPECT_EQ(outcome.conflicts.at(0), (folder / "b.db").string() +
                                         ": answers: paper/monotone/exp1 seed 18446744073709551615 trial 0, lemke");
}

TEST(MergeTest, AnswerWithoutATimeStaysWithoutOne) {
  const ScratchFolder folder;
  {
    SyntheticStore writer(folder / "s.db");
    const std::int64_t engine = writer.solver("engine");
    const std::int64_t lemke = writer.solver("lemke");
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    writer.problem("paper/monotone/exp1", 0, {{engine, {.time_s = kNan}}, {lemke, {}}});
  }
  merge_stores(folder / "merged.db", {folder / "s.db"});
  sqlite::Database merged(folder / "merged.db", sqlite::Mode::kReadOnly);
  EXPECT_EQ(merged.integer("SELECT COUNT(*) FROM answers"), 2);
  EXPECT_EQ(merged.integer("SELECT COUNT(*) FROM timings"), 1);
}

}  // namespace
}  // namespace lcpbench::merge_test
