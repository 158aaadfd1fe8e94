// What a user relies on: a store survives the death of its writer at any moment, a store that was damaged is refused
// before it tells a wrong number, and two writers never meet in one store, under whatever names.

#include <chrono>
#include <cstdint>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "study/store/merge.h"
#include "tests/study/filled_store.h"

namespace lcpbench::store_faults_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

using StoreFaultsTest = FilledStoreTest;

// ------------------------------------------------------------------------------------------------- killed writers

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

TEST_F(HotJournalTest, IsRolledBackForReadersAndWritersAndThrownAwayWithItsStore) {
  EXPECT_EQ(checked_rows(killed_), before_);
  EXPECT_FALSE(fs::exists(killed_.string() + "-journal"));
  kill_in_transaction(file_, killed_);
  { const Store store = Store::open_for_writing(killed_); }
  EXPECT_EQ(checked_rows(killed_), before_);
  kill_in_transaction(file_, killed_);
  Store::remove(killed_);
  EXPECT_FALSE(fs::exists(killed_) || fs::exists(killed_.string() + "-journal"));
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
  fs::copy_file(killed_.string() + "-journal", folder_ / "out.db-journal");  // of a store that is gone
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

TEST_F(HotJournalTest, IsNamedWhereItCannotBeRolledBack) {
  sqlite::Database reader(killed_, sqlite::Mode::kReadOnly);
  const std::string cause = input_error([&] { reader.integer("SELECT COUNT(*) FROM answers"); });
  EXPECT_TRUE(contains(cause, "killed.db-journal, which has to be rolled back first")) << cause;
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
    main = read_file(file_);
    log = read_file(file_.string() + "-wal");
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
  const std::string bytes = read_file(file_);
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

/// What each command that opens the store says of it.
void expect_refusals(const fs::path& file, const fs::path& merged, const std::string& cause) {
  for (const std::string& refusal :
       {input_error([&] { Store::open_for_reading(file).check(); }),
        input_error([&] { Store::open_for_writing(file); }), input_error([&] { merge_stores(merged, {file}); })}) {
    EXPECT_TRUE(contains(refusal, file.string() + ": the store is damaged: table ")) << refusal;
    EXPECT_TRUE(contains(refusal, cause)) << refusal;
  }
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
  const std::string bytes = read_file(file_);
  std::ofstream(folder_ / "other.db", std::ios::binary) << bytes;
  for (const auto& [sql, row] : changes) {
    std::ofstream(file_, std::ios::binary) << bytes;
    execute(sql);
    expect_refusals(file_, folder_ / "out.db", row);
    EXPECT_TRUE(contains(input_error([&] { merge_stores(file_, {folder_ / "other.db"}); }), "not what was written"));
  }
}

/// Writes that went astray, never arrived, or were cut: pages of the store itself, so that each row fits its checksum.
TEST_F(StoreFaultsTest, PagesInWrongPlacesAreRefusedOrChangeNothing) {
  constexpr std::size_t kPage = 4096;
  const std::string older = read_file(file_);
  fill(file_, 15);
  before_ = rows(file_);
  const std::string bytes = read_file(file_);
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
  const std::string bytes = read_file(file_);
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
      {"INSERT INTO certificates SELECT MIN(id), 'solution', 'lp', NULL, NULL, NULL, NULL, '', 0 FROM problems; "
       "INSERT INTO certificate_timings SELECT MIN(id), 1, 1, 0 FROM problems",
       "table certificates: a row is not matched by table proofs"},
      {"INSERT INTO certificates SELECT MIN(id), 'open', 'none', NULL, NULL, NULL, NULL, '', 0 FROM problems",
       "table certificates: a row is not matched by table certificate_timings"},
      {"INSERT INTO proofs SELECT MIN(id), x'00', 0 FROM problems",
       "table proofs: a row belongs to no row of table certificates"}};
  const std::string bytes = read_file(file_);
  for (const auto& [sql, cause] : changes) {
    SCOPED_TRACE(sql);
    std::ofstream(file_, std::ios::binary) << bytes;
    change_rows(file_, sql);
    expect_refusals(file_, folder_ / "out.db", cause);
  }
}

TEST_F(StoreFaultsTest, ForeignTriggersViewsAndTablesAreRefused) {
  const std::string bytes = read_file(file_);
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

// ----------------------------------------------------------------------------------------- writers that meet

TEST_F(StoreFaultsTest, SecondWriterIsRefusedUnderEveryNameOfTheFile) {
  fs::create_symlink("s.db", folder_ / "soft.db");
  const Store first = Store::open_for_writing(file_);
  for (const char* name : {"s.db", "soft.db"}) {
    EXPECT_TRUE(contains(input_error([&] { Store::open_for_writing(folder_ / name); }),
                         std::string(name) + ": another process is writing this store"));
  }
  EXPECT_TRUE(contains(input_error([&] { Store::remove(file_); }), "another process"));
  EXPECT_NO_THROW(Store::open_for_reading(folder_ / "soft.db"));
}

/// The log of a writer is beside one name: under another its rows would be missing.
TEST_F(StoreFaultsTest, AFileWithHardLinksIsReadAndNotWritten) {
  fs::create_hard_link(file_, folder_ / "hard.db");
  for (const char* name : {"s.db", "hard.db"}) {
    EXPECT_TRUE(contains(input_error([&] { Store::open_for_writing(folder_ / name); }),
                         std::string(name) + ": the file has other names (hard links)"));
    EXPECT_EQ(checked_rows(folder_ / name), before_);
    EXPECT_FALSE(fs::exists(folder_ / (std::string(name) + ".lock")));
  }
}

/// A link that was made while the store was written lacks the log.
TEST_F(StoreFaultsTest, AHardLinkMadeDuringTheWritingSaysThatRowsMayBeMissing) {
  const Store writer = Store::open_for_writing(file_);
  fs::create_hard_link(file_, folder_ / "hard.db");
  EXPECT_TRUE(contains(Store::open_for_reading(folder_ / "hard.db").notice(), "its last rows may be missing"));
}

/// A reader of a store at rest may check it for minutes.
TEST_F(StoreFaultsTest, WriterWaitsForAReaderAndSaysSo) {
  Store reader = Store::open_for_reading(file_);
  auto snapshot = std::make_unique<sqlite::ReadSnapshot>(reader.database());
  EXPECT_EQ(reader.cell_count(), 60);
  const std::string refusal = input_error(
      [&] { Store::open_for_writing(file_, {.tell_after = milliseconds(0), .reader_patience = milliseconds(100)}); });
  EXPECT_TRUE(contains(refusal, file_.string() + ": another process has been reading this store for ")) << refusal;
  EXPECT_TRUE(contains(refusal, " s; try again when it has ended")) << refusal;
  std::vector<std::string> waits;
  const Waiting waiting{.tell =
                            [&](const std::string& line) {
                              if (!contains(line, "waiting")) return;
                              waits.push_back(line);
                              snapshot.reset();
                            },
                        .tell_after = milliseconds(0)};
  { const Store writer = Store::open_for_writing(file_, waiting); }
  EXPECT_EQ(waits, std::vector<std::string>{"waiting for another process that reads " + file_.string()});
  EXPECT_EQ(checked_rows(file_), before_);
}

TEST_F(StoreFaultsTest, SymbolicLinksAreFollowed) {
  fill(folder_ / "more.db", 15);
  fs::create_directory(folder_ / "elsewhere");
  fs::create_symlink("elsewhere/out.db", folder_ / "link.db");  // leads nowhere yet
  merge_stores(folder_ / "link.db", {file_});
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.db"));
  EXPECT_EQ(checked_rows(folder_ / "elsewhere/out.db"), before_);
  merge_stores(folder_ / "link.db", {folder_ / "more.db"});
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.db"));
  EXPECT_EQ(Store::open_for_reading(folder_ / "elsewhere/out.db").cell_count(), 120);
  Store::remove(folder_ / "link.db");
  EXPECT_FALSE(fs::exists(folder_ / "elsewhere/out.db"));
  { const Store store = Store::open_for_writing(folder_ / "link.db"); }
  EXPECT_TRUE(fs::exists(folder_ / "elsewhere/out.db"));
}

}  // namespace
}  // namespace lcpbench::store_faults_test
