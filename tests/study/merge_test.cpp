// What a user relies on: a merge adds every row once, or says why it adds none, and leaves its inputs as they are.

#include "study/store/merge.h"

#include <filesystem>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "tests/study/filled_store.h"

namespace lcpbench {
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
  EXPECT_EQ(merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"}).conflicts.size(),
            20U);  // as many as are shown
  EXPECT_EQ(dump(folder / "b.db"), before);
  for (const char* name : {"out.db", "out.db.merging", "out.db.merging-wal"}) EXPECT_FALSE(fs::exists(folder / name));
}

/// A store whose ids are not those of its rows would give two rows of one name.
TEST(MergeTest, RowUnderTheIdOfAnotherIsRefusedWithItsStoreAndTable) {
  const ScratchFolder folder;
  fill(folder / "a.db");
  for (const std::string table : {"runs", "sets", "solvers", "problems"}) {
    fs::copy_file(folder / "a.db", folder / "b.db", fs::copy_options::overwrite_existing);
    change_rows(folder / "b.db", "UPDATE " + table + " SET id = id - 1");
    const std::string error = input_error([&] { merge_stores(folder / "out.db", {folder / "a.db", folder / "b.db"}); });
    EXPECT_TRUE(error.starts_with((folder / "b.db").string() + ": the store is damaged: table " + table + ", row id="))
        << error;
    EXPECT_FALSE(fs::exists(folder / "out.db"));
  }
}

TEST(MergeTest, InputThatWentAwayIsNamedAndNotMadeAnew) {
  const ScratchFolder folder;
  sqlite::Database database(folder / "s.db", sqlite::Mode::kReadWriteCreate);
  database.execute("CREATE TABLE t (x)");
  EXPECT_EQ(input_error([&] { database.attach(folder / "gone.db", "input"); }),
            (folder / "gone.db").string() + ": can no longer be opened: it is gone, or was replaced");
  EXPECT_FALSE(fs::exists(folder / "gone.db"));
}

TEST(MergeTest, InputsAreAttachedUnderAnyNameAndNotWritten) {
  const ScratchFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder / "");
  sqlite::Database database("s.db", sqlite::Mode::kReadWriteCreate);
  for (const char* name : {"a?mode=memory.db", "100%41.db", "#.db", "file:x.db", ":memory:", "two words.db"}) {
    sqlite::Database(name, sqlite::Mode::kReadWriteCreate).execute("CREATE TABLE t (x); INSERT INTO t VALUES (7)");
    database.attach(name, "input");
    EXPECT_EQ(database.integer("SELECT x FROM input.t"), 7) << name;
    EXPECT_NE(input_error([&] { database.execute("DELETE FROM input.t"); }), "no InputError") << name;
    database.execute("DETACH DATABASE input");
  }
  fs::current_path(before);
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
}  // namespace lcpbench
