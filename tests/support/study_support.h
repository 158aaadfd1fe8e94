#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "generators/sets.h"
#include "study/store/row_checksum.h"
#include "study/store/store.h"
#include "study/store/totals.h"
#include "study/run/study.h"

namespace lcpbench {

/// A folder of this test process, deleted at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    const std::string pattern = (std::filesystem::temp_directory_path() / "lcpbench-test-XXXXXX").string();
    std::vector<char> path(pattern.begin(), pattern.end());
    path.push_back('\0');
    if (mkdtemp(path.data()) == nullptr) throw std::runtime_error("no scratch folder");
    folder_ = path.data();
  }
  ~ScratchFolder() { std::filesystem::remove_all(folder_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

 private:
  std::filesystem::path folder_;
};

/// Every row of a table, exactly: reals with all their digits, blobs in hexadecimal.
inline std::string dump_table(Store& store, const std::string& table) {
  std::string columns;
  sqlite::Statement info(store.database(), "SELECT name FROM pragma_table_info('" + table + "')");
  while (info.step()) columns += (columns.empty() ? "quote(" : " || ',' || quote(") + std::string(info.text(0)) + ")";
  sqlite::Statement rows(store.database(), "SELECT " + columns + " AS row FROM " + table + " ORDER BY row");
  std::string text;
  while (rows.step()) text += table + ": " + std::string(rows.text(0)) + "\n";
  return text;
}

/// All that a study says of problems, solvers and answers: every table but timings and runs.
inline std::string dump(const std::filesystem::path& file) {
  Store store = Store::open_for_reading(file);
  std::string text;
  for (const char* table : {"sets", "solvers", "parameterisations", "problems", "vectors", "cell_groups", "answers",
                            "verdicts", "certificates"}) {
    text += dump_table(store, table);
  }
  return text;
}

/// Changes the rows of a store as no command would, and gives them checksums and totals that fit.
inline void change_rows(const std::filesystem::path& file, const std::string& sql) {
  sqlite::Database database(file, sqlite::Mode::kReadWrite);
  database.execute(sql);
  std::vector<std::string> tables;
  {
    sqlite::Statement query(database,
                            "SELECT m.name FROM sqlite_master m JOIN pragma_table_info(m.name) c "
                            "WHERE m.type = 'table' AND c.name = 'checksum'");
    while (query.step()) tables.emplace_back(query.text(0));
  }
  for (const std::string& table : tables) {
    database.execute("UPDATE " + table + " SET checksum = " + sqlite::row_checksum_of(database, table));
  }
  count_totals(database);
}

/// A set of given problems.
class GivenProblems final : public ProblemSet {
 public:
  GivenProblems(std::string name, std::vector<Problem> problems)
      : name_(std::move(name)), problems_(std::move(problems)) {}
  std::string name() const override { return name_; }
  Problem generate(std::uint64_t, std::int64_t trial) const override {
    return problems_.at(static_cast<std::size_t>(trial));
  }
  std::optional<std::int64_t> count() const override { return static_cast<std::int64_t>(problems_.size()); }

 private:
  std::string name_;
  std::vector<Problem> problems_;
};

/// A solver as a study takes it, made by `open`, on all trials of up to `sets` sets.
template <class Open>
StudySolver given_solver(const std::string& name, Open open, std::size_t sets = 3) {
  StudySolver solver;
  solver.row.name = name;
  solver.row.library = "test";
  solver.open = open;
  solver.every.assign(sets, {1});
  return solver;
}

}  // namespace lcpbench
