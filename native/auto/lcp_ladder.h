#pragma once

#include <memory>
#include <vector>

#include "core/problem.h"
#include "core/quad.h"
#include "core/solver.h"

namespace lcpbench {

/// Solves a bare LCP by one method after the other until an answer passes the test of bare LCPs: z >= 0 and every
/// violation |w_i| (z_i > 0) or max(0, -w_i) within 5e-10 of |q_i| + |M_i|_1 max z, half of what the verdict allows.
///
/// Lemke's method with tolerances near rounding, the same with those of LEMKE, principal pivoting (which may prove that
/// there is no solution), and regularised Lemke. An answer that passes, but violates w >= 0 by more than rounding, is
/// no solution where its basis proves so exactly. All but the last, which allocates, are loaded with the problem.
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
    std::unique_ptr<Solver> solver;
    bool loaded = false;
  };

  void make_rungs();
  bool solves(const Vector& z);
  bool proves(const Vector& farkas, Quad unit) const;
  Vector witness(const Vector& z) const;
  static void report_unsolvable(Vector& farkas, Answer& answer, const char*& text);

  Problem problem_;
  std::int64_t max_pivots_;
  std::vector<Rung> rungs_;
  Vector row_norm_, w_;
  Answer attempt_;
};

}  // namespace lcpbench
