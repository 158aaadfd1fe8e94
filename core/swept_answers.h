#pragma once

#include <vector>

#include "core/swept_solver.h"

namespace lcpbench {

/// Whether two answers are equal in claim, vectors (bit for bit), counters and detail.
bool same_answer(const Answer& a, const Answer& b);

/// Gathers the answers of a sweep: equal ones become one, with the mean times of all their cells.
class SweptAnswers {
 public:
  /// Empties `answers`, which outlives this object.
  explicit SweptAnswers(std::vector<SweptAnswer>& answers) : answers_(answers) { answers_.clear(); }

  void add(const std::vector<std::uint32_t>& cells, TimedAnswer timed);

  /// Call last: orders the cells of each answer, and the answers by their first cell. @pre every add() had a cell
  void finish();

 private:
  std::vector<SweptAnswer>& answers_;
};

/// The answer of the cells 0 .. `cells` - 1 when an exception has ended them all: kNumericalFailure with its text as
/// detail, as in_process() reports it.
void answer_all_with_failure(std::size_t cells, const char* what, std::vector<SweptAnswer>& answers);

}  // namespace lcpbench
