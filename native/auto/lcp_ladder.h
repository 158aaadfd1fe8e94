#pragma once

#include <memory>
#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "native/auto/support_search.h"
#include "native/bare_lcp_test.h"

namespace lcpbench {

/// Solves a bare LCP by one method after the other until an answer passes BareLcpTest, whose bound is the verdict's.
///
/// Lemke's method with tolerances near rounding, the same with those of LEMKE, principal pivoting (which may prove that
/// there is no solution), Lemke's method in 113 bits, Murty's and psor where they are not too large, and up to n =
/// 12 all supports. An answer that passes, but
/// violates w >= 0 by more than rounding, is no solution where its basis proves so exactly. All are loaded with the
/// problem; nothing allocates in solve().
class LcpLadder {
 public:
  explicit LcpLadder(std::int64_t max_pivots) : max_pivots_(max_pivots) {}

  /// @param problem a bare LCP
  void load(const Problem& problem);

  /// `answer` arrives cleared. @param text what became of it, for `detail`
  void solve(const SolveRequest& request, Answer& answer, const char*& text);

 private:
  struct Rung {
    const char* name;  ///< of the solver, and what is said where it gave the answer
    Index max_size;
    std::unique_ptr<Solver> solver;
  };

  void make_rungs();
  bool is_final(const Rung& rung, Answer& answer, const char*& text);
  static void report_unsolvable(const Vector& proof, Answer& answer, const char*& text);

  Problem problem_;
  std::int64_t max_pivots_;
  std::vector<Rung> rungs_;
  BareLcpTest test_;
  SupportSearch search_;
  Answer attempt_;
};

}  // namespace lcpbench
