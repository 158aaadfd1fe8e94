#pragma once

#include <cstdint>

#include "study/store/store.h"

namespace lcpbench {

/// Writes problems and the answers to them into a store, with statements that are prepared once.
class ProblemWriter {
 public:
  explicit ProblemWriter(sqlite::Database& database);

  /// Store::add. @param run_id  the run that the timings belong to
  void add(const ProblemResult& result, std::int64_t run_id);

 private:
  void add_answer(std::int64_t problem_id, std::int64_t run_id, const AnswerRow& row);

  sqlite::Database& database_;
  sqlite::Statement problem_;
  sqlite::Statement stored_problem_;
  sqlite::Statement vector_;
  sqlite::Statement group_;
  sqlite::Statement stored_group_;
  sqlite::Statement stored_answers_;  ///< asks for part 0, which every solver that ran has
  sqlite::Statement answer_;
  sqlite::Statement verdict_;
  sqlite::Statement timing_;
};

}  // namespace lcpbench
