#pragma once

#include <algorithm>
#include <cstdint>

#include "core/settings.h"
#include "core/solver.h"
#include "native/answer_test/answer_test.h"
#include "native/principal_pivoting/principal_tableau.h"

namespace lcpbench {

/// The settings of every method of principal pivots.
struct PrincipalSettings {
  std::int64_t max_pivots = 0;
  double data_error = 1e-14;

  void visit(auto&& field) {
    field("max_pivots", max_pivots, IntegerRange{.min = 0}, "0 stands for max(1000, n^2), the paper's limit");
    field("data_error", data_error, RealRange{.min = 0, .max = 1},
          "relative error of M and q: values that errors of this size could make 0 count as 0");
  }
};

/// A method that exchanges z_i and w_i in a tableau until no basic variable is negative.
class PrincipalSolver : public Solver {
 protected:
  enum class End { kNonnegative, kUnblocked, kNoPivot, kSingularBasis, kPivotLimit, kTimeLimit };

  /// @param no_pivot  static text: what the answer says at End::kNoPivot
  PrincipalSolver(const PrincipalSettings& settings, const char* no_pivot)
      : data_error_(settings.data_error), settings_(settings), no_pivot_(no_pivot) {}

  /// Ends with kUnblocked only after it wrote farkas_. Must not allocate.
  virtual End run(double deadline_s, Counters& counters) = 0;

  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) final;

  bool rebuild_tableau(Counters& counters) {
    ++counters.factorizations;
    return tableau_.rebuild();
  }

  /// Whether the diagonal entry of column k stays positive under relative errors of the data of data_error_: in the
  /// tableau, and computed anew from the data (PrincipalTableau::gains). Writes the error bounds of the column. O(n^2).
  bool has_pivot(Index k, Vector& column_errors) {
    tableau_.column_errors(k, data_error_, column_errors);
    return tableau_.matrix()(k, k) > column_errors(k) && tableau_.gains(k, data_error_);
  }

  const double data_error_;
  PrincipalTableau tableau_;
  std::int64_t pivot_limit_ = 0;
  Vector bounds_;  // n: errors of the constants; murty also writes those of a column there
  Vector farkas_;  // n

 private:
  PrincipalSettings settings_;
  const char* no_pivot_;
  AnswerTest test_;
};

}  // namespace lcpbench
