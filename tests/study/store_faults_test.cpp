// What a user relies on: a store survives the death of its writer at any moment, and a store that was damaged is
// refused before it tells a wrong number.

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <new>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "study/store/merge.h"
#include "tests/study/filled_store.h"

namespace lcpbench::store_faults_test {
namespace {

namespace fs = std::filesystem;

using StoreFaultsTest = FilledStoreTest;

// ------------------------------------------------------------------------------------------------- killed writers

std::string read_bytes(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// Leaves `file` and its journal as a writer does that is killed in the middle of a transaction in this mode.
void kill_in_transaction(const fs::path& file, const fs::path& killed) {
  sqlite::Database writer(file, sqlite::Mode::kReadWrite);
  writer.execute(
      "PRAGMA cache_size = 1; BEGIN; UPDATE answers SET claim = 'crashed'; DELETE FROM timings; "
      "WITH RECURSIVE n(x) AS (VALUES (1) UNION ALL SELECT x + 1 FROM n LIMIT 500) "
      "INSERT INTO vectors SELECT x, zeroblob(3000) FROM n");  // more than the cache holds: pages reach the file
  fs::copy_file(file, killed, fs::copy_options::overwrite_existing);
  fs::copy_file(file.string() + "-journal", killed.string() + "-journal", fs::copy_options::overwrite_existing);
  writer.execute("ROLLBACK");
}

class HotJournalTest : public StoreFaultsTest {
 protected:
  void SetUp() override {
    StoreFaultsTest::SetUp();
    kill_in_transaction(file_, killed_);
    ASSERT_GT(fs::file_size(killed_), fs::file_size(file_));
  }
  fs::path killed_ = folder_ / "killed.db";
};

TEST_F(HotJournalTest, IsRolledBackForReaders) {
  EXPECT_EQ(checked_rows(killed_), before_);
  EXPECT_FALSE(fs::exists(killed_.string() + "-journal"));
}

TEST_F(HotJournalTest, IsRolledBackForWriters) {
  { const Store store = Store::open_for_writing(killed_); }
  EXPECT_EQ(checked_rows(killed_), before_);
}

TEST_F(HotJournalTest, DoesNotKeepAStoreFromBeingThrownAway) {
  Store::remove(killed_);
  EXPECT_FALSE(fs::exists(killed_));
  EXPECT_FALSE(fs::exists(killed_.string() + "-journal"));
}

TEST_F(HotJournalTest, IsRolledBackInInputsAndInTheOutputOfAMerge) {
  merge_stores(folder_ / "out.db", {killed_});
  EXPECT_EQ(checked_rows(folder_ / "out.db"), before_);
  fill(folder_ / "more.db", 15);
  kill_in_transaction(file_, killed_);
  merge_stores(killed_, {folder_ / "more.db"});
  EXPECT_EQ(Store::open_for_reading(killed_).cell_count(), 120);
}

TEST_F(HotJournalTest, OfAKilledMergeIsThrownAwayWithItsDraft) {
  fs::rename(killed_, folder_ / "out.db.merging");
  fs::rename(killed_.string() + "-journal", folder_ / "out.db.merging-journal");
  merge_stores(folder_ / "out.db", {file_});
  EXPECT_EQ(checked_rows(folder_ / "out.db"), before_);
}

/// A draft has no journal: after a kill its header may count pages that never reached the file.
TEST_F(StoreFaultsTest, DraftOfAKilledMergeIsThrownAwayWhereverItEnds) {
  const fs::path draft = folder_ / "out.db.merging";
  const std::uintmax_t size = fs::file_size(file_);
  for (const std::uintmax_t end : {std::uintmax_t{0}, std::uintmax_t{4096}, size / 2, size - 1}) {
    fs::copy_file(file_, draft, fs::copy_options::overwrite_existing);
    fs::resize_file(draft, end);
    EXPECT_EQ(input_error([&] { merge_stores(folder_ / "out.db", {file_}); }), "no InputError") << end;
    EXPECT_EQ(checked_rows(folder_ / "out.db"), before_);
    EXPECT_FALSE(fs::exists(draft));
    fs::remove(folder_ / "out.db");
  }
  std::ofstream(draft) << std::string(5000, 'x');
  EXPECT_EQ(input_error([&] { merge_stores(folder_ / "out.db", {file_}); }),
            draft.string() + ": not an lcpbench store");
  EXPECT_EQ(fs::file_size(draft), 5000U);
}

TEST_F(HotJournalTest, OfAStoreThatIsGoneIsNotTakenForTheMergedOnes) {
  fs::rename(killed_.string() + "-journal", folder_ / "out.db-journal");
  merge_stores(folder_ / "out.db", {file_});
  EXPECT_EQ(checked_rows(folder_ / "out.db"), before_);
}

TEST_F(HotJournalTest, IsNamedWhereItCannotBeRolledBack) {
  sqlite::Database reader(killed_, sqlite::Mode::kReadOnly);
  const std::string cause = input_error([&] { reader.integer("SELECT COUNT(*) FROM answers"); });
  EXPECT_TRUE(contains(cause, "killed.db-journal, which has to be rolled back first")) << cause;
}

TEST(StoreFaultTest, FileOfAWriterThatWasKilledBeforeItsFirstCommitIsCalledEmpty) {
  const ScratchFolder folder;
  std::ofstream(folder / "s.db").close();
  EXPECT_TRUE(contains(input_error([&] { Store::open_for_reading(folder / "s.db"); }), "s.db: is empty"));
}

TEST_F(StoreFaultsTest, CopyWithoutTheLogOfAKilledWriterSaysSo) {
  const fs::path copy = folder_ / "copy.db";
  {
    SyntheticStore writer(file_);
    writer.problem("paper/monotone/exp1", 99, {{writer.solver("lemke"), {}}});
    EXPECT_EQ(Store::open_for_reading(file_).notice(), "") << "the writer lives";
    fs::copy_file(file_, copy);
    fs::copy_file(file_, folder_ / "whole.db");
    fs::copy_file(file_.string() + "-wal", folder_ / "whole.db-wal");
  }
  const std::string whole = Store::open_for_reading(folder_ / "whole.db").notice();
  EXPECT_TRUE(contains(whole, "never closed it: its last rows may be missing")) << whole;
  EXPECT_EQ(Store::open_for_reading(folder_ / "whole.db").cell_count(), 61);
  for (int time = 0; time < 2; ++time) {
    const std::string notice = Store::open_for_reading(copy).notice();
    EXPECT_TRUE(contains(notice, "copy.db-wal is not beside the store: its last rows may be missing")) << notice;
  }
  EXPECT_EQ(merge_stores(folder_ / "out.db", {copy}).notices.size(), 1U);
  EXPECT_NE(Store::open_for_writing(copy).notice(), "");
  EXPECT_EQ(Store::open_for_writing(copy).notice(), "") << "its end was a good one";
  EXPECT_EQ(Store::open_for_reading(file_).notice(), "");
}

TEST_F(StoreFaultsTest, FlippedBitInTheLogOfAKilledWriterLosesWholeTransactionsAndNeverInSilence) {
  const fs::path killed = folder_ / "killed.db";
  std::string main;
  std::string log;
  {
    SyntheticStore writer(file_);
    for (std::int64_t trial = 0; trial < 4; ++trial) {
      writer.problem("paper/monotone/exp4", trial, {{writer.solver("lemke"), {}}});
    }
    main = read_bytes(file_);
    log = read_bytes(file_.string() + "-wal");
  }
  std::mt19937_64 random(16);
  std::int64_t lost = 0;
  for (int i = 0; i < 200; ++i) {
    const std::uint64_t bit = random() % (8 * log.size());
    std::string damaged = log;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    fs::remove(killed.string() + "-shm");
    std::ofstream(killed, std::ios::binary) << main;
    std::ofstream(killed.string() + "-wal", std::ios::binary) << damaged;
    Store store = Store::open_for_reading(killed);
    EXPECT_NE(store.notice(), "") << "bit " << bit;
    EXPECT_NO_THROW(store.check()) << "bit " << bit;
    lost += 64 - store.cell_count();
    EXPECT_LE(store.cell_count(), 64) << "bit " << bit;
  }
  EXPECT_GT(lost, 100);
}

/// Opens, writes, closes and merges a store again and again, until it is killed.
[[noreturn]] void write_until_killed(const fs::path& file, const fs::path& merged, std::atomic<std::int64_t>& kept) {
  try {
    while (true) {
      {
        SyntheticStore writer(file);
        const std::int64_t lemke = writer.solver("lemke");
        for (int i = 0; i < 3; ++i) {
          writer.problem("paper/monotone/exp1", kept, {{lemke, {}}});
          ++kept;
        }
      }
      merge_stores(merged, {file});
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    _exit(1);
  }
}

/// Waits until `is_done` of the processor time [s] that a process has used, and kills it then.
/// @returns that time
double kill_when(pid_t process, const std::function<bool(double)>& is_done) {
  clockid_t clock = 0;
  EXPECT_EQ(clock_getcpuclockid(process, &clock), 0);
  timespec worked{};
  double seconds = 0.0;
  while (clock_gettime(clock, &worked) == 0) {
    seconds = static_cast<double>(worked.tv_sec) + 1e-9 * static_cast<double>(worked.tv_nsec);
    siginfo_t ended{};
    waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOHANG | WNOWAIT);
    if (ended.si_pid != 0 || is_done(seconds)) break;
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  kill(process, SIGKILL);
  int status = 0;
  waitpid(process, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "it ended by itself";
  return seconds;
}

TEST(StoreFaultTest, RandomKillsLoseNothingAndBlockNobody) {
  const ScratchFolder folder;
  const fs::path file = folder / "s.db";
  using Count = std::atomic<std::int64_t>;
  void* const shared = mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  Count& kept = *new (shared) Count(0);
  const auto start_writer = [&](const fs::path& store, const fs::path& merged) {
    const pid_t child = fork();
    if (child == 0) write_until_killed(store, merged, kept);
    return child;
  };
  // How long one round takes differs a hundredfold between builds and machines.
  const fs::path timed = folder / "timed.merged.db";
  const double round_s = kill_when(start_writer(folder / "timed.db", timed), [&](double) { return fs::exists(timed); });
  kept = 0;
  std::mt19937_64 random(7);
  for (int kill_number = 0; kill_number < 60 && !HasFailure(); ++kill_number) {
    const double life_s = std::uniform_real_distribution(0.0, 3.0 * round_s)(random);
    kill_when(start_writer(file, folder / "merged.db"), [&](double worked_s) { return worked_s >= life_s; });
    if (kept == 0) continue;
    for (const char* name : {"s.db", "merged.db"}) {
      if (!fs::exists(folder / name)) continue;
      Store store = Store::open_for_reading(folder / name);
      store.check();
      const std::int64_t rows = store.cell_count();
      if (file != folder / name) continue;
      EXPECT_GE(rows, kept);
      kept = rows;  // one may have been kept and not counted
    }
  }
  EXPECT_GT(kept, 0);
  merge_stores(folder / "merged.db", {file});
  EXPECT_EQ(checked_rows(folder / "merged.db"), checked_rows(file));
  munmap(shared, sizeof(Count));
}

// --------------------------------------------------------------------------------------------------------- damage

/// Writes `bytes` as a store, and expects that it is refused with one line, or read as it was written.
/// @returns whether it was refused
bool refused_or_unchanged(const fs::path& file, const std::string& bytes, const std::string& before) {
  for (const char* suffix : {"-wal", "-shm", "-journal"}) fs::remove(file.string() + suffix);
  std::ofstream(file, std::ios::binary) << bytes;
  std::string after;
  const std::string cause = input_error([&] { after = checked_rows(file); });
  if (cause == "no InputError") {
    EXPECT_EQ(after, before);
    return false;
  }
  EXPECT_TRUE(cause.starts_with(file.string() + ": ")) << cause;
  EXPECT_EQ(cause.find('\n'), std::string::npos) << cause;
  return true;
}

TEST_F(StoreFaultsTest, OneFlippedBitIsRefusedOrChangesNothing) {
  const std::string bytes = read_bytes(file_);
  std::mt19937_64 random(20261121);
  int refused = 0;
  constexpr int kFlips = 700;
  for (int i = 0; i < kFlips; ++i) {
    // Every second one into the pages of the small tables and of the schema.
    const std::uint64_t bit = random() % (8 * (i % 2 == 0 ? bytes.size() : bytes.size() / 3));
    std::string damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    SCOPED_TRACE("bit " + std::to_string(bit));
    refused += static_cast<int>(refused_or_unchanged(folder_ / "flipped.db", damaged, before_));
  }
  EXPECT_GT(refused, kFlips / 10);
}

TEST_F(StoreFaultsTest, ChangedRowIsNamedWithItsTable) {
  const std::pair<const char*, const char*> changes[] = {
      {"UPDATE timings SET solve_cpu_s = 2 * solve_cpu_s", "table timings, row problem_id="},
      {"UPDATE answers SET claim = 'solved' WHERE claim <> 'solved'", "table answers, row problem_id="},
      {"UPDATE verdicts SET criterion = 1 - criterion", "table verdicts, row problem_id="},
      {"UPDATE problems SET n = n + 1", "table problems, row id="},
      {"UPDATE runs SET provenance = '{}'", "table runs, row id="},
      {"UPDATE cell_groups SET cell = cell + 1", "table cell_groups, row group_id="},
      {"UPDATE cell_groups SET cell = cell + 4294967296", "table cell_groups, row group_id="},
      {"INSERT INTO vectors VALUES (7, x'00')", "table vectors, row id=7"}};
  const std::string bytes = read_bytes(file_);
  std::ofstream(folder_ / "other.db", std::ios::binary) << bytes;
  for (const auto& [sql, row] : changes) {
    std::ofstream(file_, std::ios::binary) << bytes;
    execute(sql);
    const auto refusals = {input_error([&] { Store::open_for_reading(file_).check(); }),
                           input_error([&] { Store::open_for_writing(file_); }),
                           input_error([&] { merge_stores(folder_ / "out.db", {file_}); }),
                           input_error([&] { merge_stores(file_, {folder_ / "other.db"}); })};
    for (const std::string& refusal : refusals) {
      EXPECT_TRUE(contains(refusal, file_.string() + ": the store is damaged: " + row)) << refusal;
      EXPECT_TRUE(contains(refusal, "not what was written")) << refusal;
    }
  }
}

/// Writes that went astray, never arrived, or were cut: pages of the store itself, so that each row fits its checksum.
TEST_F(StoreFaultsTest, PagesInWrongPlacesAreRefusedOrChangeNothing) {
  constexpr std::size_t kPage = 4096;
  const std::string older = read_bytes(file_);
  fill(file_, 15);
  before_ = rows(file_);
  const std::string bytes = read_bytes(file_);
  std::mt19937_64 random(20261123);
  const auto some_page = [&](const std::string& from) { return kPage * (random() % (from.size() / kPage)); };
  constexpr int kFaults = 400;
  int refused = 0;
  for (int i = 0; i < kFaults; ++i) {
    SCOPED_TRACE("fault " + std::to_string(i));
    std::string damaged = bytes;
    const std::size_t page = some_page(bytes);
    const std::size_t other = some_page(bytes);
    switch (i % 5) {
      case 0: damaged.replace(page, kPage, bytes, other, kPage); break;
      case 1: damaged.replace(page, kPage, kPage, '\0'); break;
      case 2: damaged.replace(page, kPage, bytes, other, kPage).replace(other, kPage, bytes, page, kPage); break;
      case 3: damaged.resize(page); break;
      default: {
        const std::size_t lost = some_page(older);
        damaged.replace(lost, kPage, older, lost, kPage);
      }
    }
    refused += static_cast<int>(refused_or_unchanged(folder_ / "damaged.db", damaged, before_));
  }
  EXPECT_GT(refused, kFaults / 2);
}

/// What each command that opens the store says of it.
void expect_refusals(const fs::path& file, const fs::path& merged, const std::string& cause) {
  for (const std::string& refusal :
       {input_error([&] { Store::open_for_reading(file).check(); }),
        input_error([&] { Store::open_for_writing(file); }), input_error([&] { merge_stores(merged, {file}); })}) {
    EXPECT_TRUE(contains(refusal, file.string() + ": the store is damaged: table ")) << refusal;
    EXPECT_TRUE(contains(refusal, cause)) << refusal;
  }
}

TEST_F(StoreFaultsTest, MissingAndAddedRowsAreRefusedWithTheirTable) {
  const std::pair<const char*, const char*> changes[] = {
      {"DELETE FROM verdicts WHERE solver_id = (SELECT MIN(id) FROM solvers)",
       "verdicts: its 30 rows are not the 60 that"},
      {"DELETE FROM answers; DELETE FROM verdicts; DELETE FROM timings", "answers: its 0 rows are not the 60 that"},
      {"DELETE FROM timings WHERE part = 0", "timings: its 0 rows"},
      {"DELETE FROM problems WHERE trial = 3", "problems: its 28 rows are not the 30"},
      {"DELETE FROM cell_groups", "cell_groups: its 0 rows"},
      {"DELETE FROM runs", "runs: its 0 rows"},
      {"DELETE FROM sets", "sets: its 0 rows"},
      {"INSERT INTO runs SELECT 7, started, provenance, row_checksum(7, started, provenance) FROM runs",
       "runs: its 2 rows"},
      {"INSERT INTO timings SELECT problem_id, solver_id, 1, run_id, 0, 0, 0, 0, 0, 0, 1, "
       "row_checksum(problem_id, solver_id, 1, run_id, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1) FROM timings LIMIT 1",
       "timings: its 61 rows are not the 60"},
      {"DELETE FROM totals WHERE name = 'proofs'", "proofs: its 0 rows are not the rows that were written"},
      {"DELETE FROM totals", "rows are not the rows that were written"},
      {"UPDATE totals SET row_count = 61 WHERE name = 'verdicts'", "verdicts: its 60 rows are not the 61 that"},
      {"UPDATE totals SET digest = digest + 1 WHERE name = 'answers'", "answers: its 60 rows are not the 60 that"}};
  const std::string bytes = read_bytes(file_);
  for (const auto& [sql, cause] : changes) {
    SCOPED_TRACE(sql);
    std::ofstream(file_, std::ios::binary) << bytes;
    execute(sql);
    expect_refusals(file_, folder_ / "out.db", cause);
  }
}

/// These rows fit their checksums and their totals: no program wrote them one by one.
TEST_F(StoreFaultsTest, RowsThatDoNotBelongTogetherAreRefused) {
  const std::pair<const char*, const char*> changes[] = {
      {"DELETE FROM verdicts WHERE problem_id = (SELECT MIN(problem_id) FROM verdicts)",
       "table answers: a row is not matched by table verdicts"},
      {"DELETE FROM answers WHERE problem_id = (SELECT MIN(problem_id) FROM answers)",
       ": a row belongs to no row of table answers"},
      {"UPDATE timings SET part = 1", "table timings: a row belongs to no row of table answers"},
      {"DELETE FROM runs", "table timings: a row belongs to no row of table runs"},
      {"DELETE FROM cell_groups", "table answers: a row belongs to no row of table cell_groups"},
      {"UPDATE answers SET z = 5", "table answers: a row belongs to no row of table vectors"},
      {"DELETE FROM problems WHERE trial = 3", "table answers: a row belongs to no row of table problems"},
      {"INSERT INTO certificates SELECT MIN(id), 'solution', 'lp', NULL, NULL, NULL, '', 0 FROM problems; "
       "INSERT INTO certificate_timings SELECT MIN(id), 1, 1, 0 FROM problems",
       "table certificates: a row is not matched by table proofs"},
      {"INSERT INTO certificates SELECT MIN(id), 'open', 'none', NULL, NULL, NULL, '', 0 FROM problems",
       "table certificates: a row is not matched by table certificate_timings"},
      {"INSERT INTO proofs SELECT MIN(id), x'00', 0 FROM problems",
       "table proofs: a row belongs to no row of table certificates"}};
  const std::string bytes = read_bytes(file_);
  for (const auto& [sql, cause] : changes) {
    SCOPED_TRACE(sql);
    std::ofstream(file_, std::ios::binary) << bytes;
    change_rows(file_, sql);
    expect_refusals(file_, folder_ / "out.db", cause);
  }
}

/// Rows that go by the store's own means are counted, in the transaction that they go with.
TEST_F(StoreFaultsTest, TotalsFollowReplacedDeletedAndRolledBackRows) {
  {
    Store store = Store::open_for_writing(file_);
    sqlite::Database& database = store.database();
    for (const char* end : {"COMMIT", "ROLLBACK"}) {
      for (const char* claim : {"crashed", "killed"}) {
        database.execute("BEGIN");
        sqlite::Statement replace(database, sqlite::insert_row("INSERT OR REPLACE", "sets", "id, name"));
        replace.run(set_id("paper/monotone/exp9"), std::string_view("paper/monotone/exp9"));
        database.execute(std::string("UPDATE answers SET claim = '") + claim + "'");
        database.execute("UPDATE answers SET checksum = " + sqlite::row_checksum_of(database, "answers"));
        database.execute("DELETE FROM timings WHERE solver_id = (SELECT MIN(id) FROM solvers)");
        database.execute(end);
      }
    }
  }
  EXPECT_NO_THROW(Store::open_for_reading(file_).check());
}

TEST_F(StoreFaultsTest, ValuesOfAnotherTypeAreRefusedByTheTables) {
  EXPECT_THROW(execute("UPDATE answers SET pivots = 'many'"), std::exception);
  EXPECT_THROW(execute("UPDATE verdicts SET min_z = 'none'"), std::exception);
}

TEST_F(StoreFaultsTest, ForeignTriggersViewsAndTablesAreRefused) {
  const std::string bytes = read_bytes(file_);
  const std::pair<const char*, const char*> additions[] = {
      {"CREATE TRIGGER more AFTER INSERT ON answers BEGIN DELETE FROM timings; END", "has the trigger 'more'"},
      {"CREATE VIEW more AS SELECT 1", "has the view 'more'"},
      {"CREATE TABLE more (x)", "has the table 'more'"},
      {"CREATE INDEX more ON answers(claim)", "has the index 'more'"},
      {"DROP VIEW judged; CREATE VIEW judged AS SELECT * FROM answers", "view judged is missing or altered"}};
  for (const auto& [sql, cause] : additions) {
    std::ofstream(file_, std::ios::binary) << bytes;
    execute(sql);
    EXPECT_TRUE(contains(input_error([&] { Store::open_for_reading(file_); }), cause)) << sql;
    EXPECT_TRUE(contains(input_error([&] { Store::open_for_writing(file_); }), cause)) << sql;
  }
}

TEST_F(StoreFaultsTest, CommentsAndLineBreaksOfTheSchemaDoNotMatter) {
  const auto change_schema = [this](const std::string& from, const std::string& to) {
    sqlite3* handle = nullptr;  // a connection that may change the schema's text
    ASSERT_EQ(sqlite3_open(file_.c_str(), &handle), SQLITE_OK);
    const std::string sql =
        "PRAGMA writable_schema = ON; UPDATE sqlite_master SET sql = replace(sql, " + from + ", " + to + ")";
    EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    EXPECT_GT(sqlite3_changes(handle), 0);
    sqlite3_close(handle);
  };
  change_schema("'-- JSON'", "'-- a text in''JSON'");
  change_schema("'  seed INTEGER NOT NULL,'", "'  seed INTEGER' || char(10) || ' NOT NULL,'");
  EXPECT_EQ(checked_rows(file_), before_);
  change_schema("'  kind TEXT NOT NULL,'", "'  kind TEXT,--NOT NULL,'");
  EXPECT_TRUE(contains(input_error([&] { Store::open_for_reading(file_); }), "table problems is missing or altered"));
}

}  // namespace
}  // namespace lcpbench::store_faults_test
