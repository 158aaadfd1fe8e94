#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "study/evaluation/evaluation.h"
#include "study/report/worst.h"

namespace lcpbench {

/// What each solver did on all the problems of one `lcpbench solve`: the table that ends its output.
class SolveTotal {
 public:
  void add_problem() { ++problems_; }
  /// Counts an answer to the problem that was added last.
  /// @param solver  its spec
  /// @param label  what it is called
  /// @param error  rho for a contact problem, the backward error for a bare LCP; NaN: there is none
  /// @param time_s  CPU time of set-up and solve [s]
  void add(const std::string& solver, const std::string& label, const std::string& file, Claim claim, Verdict verdict,
           double error, double time_s);
  /// One row for each solver, the most solved first, and the command that repeats its worst problem: false claims come
  /// before other failures, then the larger error. "" for fewer than two problems.
  std::string text(int width) const;

 private:
  struct Row {
    std::string solver;
    std::string label;
    std::int64_t solved = 0, wrong = 0, unsolvable = 0;
    std::int64_t missed = 0;    ///< verdict `missed` or `open`
    std::int64_t taken = 0;     ///< problems that it did not refuse
    std::vector<double> times;  ///< [s] of the problems taken
    report::Failure worst;
    std::string worst_file;  ///< "" where nothing failed
  };
  std::int64_t problems_ = 0;
  std::vector<Row> rows_;  ///< in the order in which they were met
};

}  // namespace lcpbench
