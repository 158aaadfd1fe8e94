#pragma once

#include <cstdint>
#include <memory>

#include "study/store/store.h"

namespace lcpbench {

/// Writes problems and the answers to them into a store, with statements that are prepared once.
class ProblemWriter {
 public:
  explicit ProblemWriter(sqlite::Database& database);
  ~ProblemWriter();
  ProblemWriter(const ProblemWriter&) = delete;
  ProblemWriter& operator=(const ProblemWriter&) = delete;

  /// Store::add. @param run_id  the run that the timings belong to
  void add(const ProblemResult& result, std::int64_t run_id);

 private:
  struct Statements;
  sqlite::Database& database_;
  std::unique_ptr<Statements> statements_;
};

}  // namespace lcpbench
