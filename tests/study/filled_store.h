#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/checks.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

/// A store with known rows, and what commands say of it.
namespace lcpbench {

/// Some sets and solvers with all kinds of answers.
inline void fill(const std::filesystem::path& file, std::int64_t first_trial = 0) {
  SyntheticStore made(file, R"({"cells": 60, "seed": 1, "sets": [], "solvers": []})");
  const std::int64_t lemke = made.solver("lemke");
  const std::int64_t other = made.solver("primal_dual", "step=0.5");
  for (std::int64_t trial = first_trial; trial < first_trial + 15; ++trial) {
    const bool fails = trial % 3 == 0;
    made.problem("paper/monotone/exp1", trial,
                 {{lemke, {.error = 0.0}},
                  {other, {.claim = fails ? Claim::kIterationLimit : Claim::kSolved, .error = fails ? 1.0 : -0.0}}});
    made.problem("paper/monotone/exp2", trial, {{lemke, {.error = 0.5}}, {other, {.time_s = 4}}}, 8, "");
  }
}

/// All rows of all tables.
inline std::string rows(const std::filesystem::path& file) {
  Store store = Store::open_for_reading(file);
  return dump(file) + dump_table(store, "runs") + dump_table(store, "timings");
}

/// As `rows`, where the store is checked as every command checks it.
inline std::string checked_rows(const std::filesystem::path& file) {
  Store::open_for_reading(file).check();
  return rows(file);
}

class FilledStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    fill(file_);
    before_ = rows(file_);
  }
  /// Runs SQL as other programs would, which know nothing of checksums.
  void execute(const std::string& sql) const { sqlite::Database(file_, sqlite::Mode::kReadWrite).execute(sql); }

  ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "s.db";
  std::string before_;
};

}  // namespace lcpbench
