#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "study/evaluation/evaluation.h"
#include "study/report/worst.h"

namespace lcpbench {

/// What each solver did on all the problems of one `solve`.
class SolveTotal {
 public:
  void add_problem() { ++problems_; }
  /// The answer to the problem that was added last. @param error  what the verdict was taken on
  void add(const std::string& solver, const std::string& file, Claim claim, Verdict verdict, double error,
           double time_s);
  /// One row for each solver, and the command that repeats its worst problem. "" for a single problem.
  std::string text(int width) const;

 private:
  struct Row {
    std::string solver;
    std::int64_t solved = 0, wrong = 0, unsolvable = 0, missed = 0, taken = 0;
    std::vector<double> times;
    report::Failure worst;
    std::string worst_file;  ///< "" where nothing failed
  };
  std::int64_t problems_ = 0;
  std::vector<Row> rows_;  ///< in the order in which they were met
};

}  // namespace lcpbench
