#include <fstream>
#include <random>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "study/output/csv.h"
#include "study/report/report.h"
#include "tests/study/filled_store.h"

namespace lcpbench::damaged_store_test {
namespace {

/// What a report says of a store, or why it refuses it.
std::string told(const std::filesystem::path& file) {
  Store store = Store::open_for_reading(file);
  store.check();
  const report::Report report = report::read_report(store);
  report::fill_tables(store, report);
  report::fill_slow_tables(store, report.summary);
  std::string text = report::report_summary_json(report).dump();
  for (const report::TableQuery& query : report::kTableQueries) {
    const report::QueryResult result = report::run_query(store.database(), query.name, query.sql);
    text += csv_table(result.columns, result.rows);
  }
  return text;
}

class ReportOfADamagedStoreTest : public FilledStoreTest {
 protected:
  void SetUp() override {
    FilledStoreTest::SetUp();
    std::ostringstream bytes;
    bytes << std::ifstream(file_, std::ios::binary).rdbuf();
    bytes_ = bytes.str();
    told_ = told(file_);
  }
  std::string bytes_, told_;
};

TEST_F(ReportOfADamagedStoreTest, OneFlippedBitIsRefusedOrChangesNothing) {
  std::mt19937_64 random(36);
  int refused = 0;
  constexpr int kFlips = 100;
  for (int i = 0; i < kFlips; ++i) {
    const std::uint64_t bit = random() % (8 * bytes_.size());
    std::string damaged = bytes_;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    std::ofstream(file_, std::ios::binary) << damaged;
    std::string after;
    const std::string cause = input_error([&] { after = told(file_); });
    if (cause == "no InputError") {
      EXPECT_EQ(after, told_) << "bit " << bit;
    } else {
      ++refused;
      EXPECT_TRUE(cause.starts_with(file_.string() + ": ")) << cause;
    }
  }
  EXPECT_GT(refused, kFlips / 10);
}

/// One rule, in SQL for its users and in the scan.
TEST_F(FilledStoreTest, ScanJudgesAsTheViewDoes) {
  Store store = Store::open_for_reading(file_);
  std::string scanned;
  store.for_each_answer([&](const StoredAnswer& answer) {
    scanned += fmt::format("{} {} {} {} {}\n", answer.problem_id, answer.solver_id, answer.part,
                           to_string(answer.truth), to_string(answer.verdict));
  });
  std::string viewed;
  sqlite::Statement query(
      store.database(),
      "SELECT problem_id, solver_id, part, truth, verdict FROM judged ORDER BY problem_id, solver_id, part");
  while (query.step()) {
    viewed += fmt::format("{} {} {} {} {}\n", query.integer(0), query.integer(1), query.integer(2), query.text(3),
                          query.text(4));
  }
  EXPECT_EQ(scanned, viewed);
}

}  // namespace
}  // namespace lcpbench::damaged_store_test
