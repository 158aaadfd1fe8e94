#pragma once

#include "core/problem.h"
#include "core/solver.h"
#include "native/lcp_ladder/covering_lemke.h"
#include "native/lcp_ladder/sparse_pivoting.h"
#include "native/lemke/lemke.h"
#include "native/proofs/exact_search.h"

namespace lcpbench {

/// Solves a bare LCP by one method after the other until an answer passes AnswerTest, or the problem is proven to have
/// no solution.
///
/// The stages, in this order:
/// - SparsePivoting, where M has few nonzeros;
/// - `lemke` with its default tolerances;
/// - CoveringLemke in double;
/// - up to 40 rows, `lemke` with tolerances near rounding;
/// - CoveringLemke in 113 bits, up to 40 rows also with the other covering vector;
/// - `lemke` with more pivots, if only the limit on pivots ended it before;
/// - up to kLargestExact rows, every support in exact arithmetic.
/// Above 40 rows, if `lemke` ends in a ray, CoveringLemke in double is the last stage, or `lemke` itself where the ray
/// disproves the problem but for rounding. Above 40 rows 113 bits are tried only up to CoveringLemke::kLargestQuad
/// rows, where an earlier stage found an answer that is not accurate enough and the limit on pivots in 113 bits allows
/// as many as CoveringLemke took in double: such a path takes some hundred times as long as one in double, and hardly
/// ever finds an answer where those in double find none.
///
/// Limits on pivots grow with n, but in 113 bits they limit the work to about a second; paths that do not cycle seldom
/// reach them. load() takes the memory: in solve() only SparsePivoting and exact arithmetic allocate.
class LcpLadder {
 public:
  LcpLadder();

  /// @param problem a bare LCP
  void load(const Problem& problem);

  /// Where no stage has an answer or a proof, the claim stays as it was or becomes kTimeLimit.
  /// @param answer  cleared by the caller
  /// @param text  for Answer::detail: the stage that solved it, or why there is no answer
  void solve(const SolveRequest& request, Answer& answer, const char*& text);

 private:
  static constexpr Index kLargestExact = ExactSearch::kMaxSize;

  enum class Stage {
    kSparse,
    kLemke,
    kCovering,
    kLemkeTight,
    kCoveringQuad,
    kCoveringQuadNegative,
    kLemkeLong,
    kExact,
  };

  bool takes() const { return problem_.size() <= lemke_.capabilities().max_size; }
  bool has(Stage stage) const;
  // Each leaves its result, tested by AnswerTest, in attempt_.
  void run_sparse(Stage stage);
  void run_lemke(Stage stage);
  void run_covering(Stage stage);
  void run_exact(Stage stage);
  bool is_final(Stage stage, Answer& answer, const char*& text);
  std::int64_t share_of_pivots() const;
  std::int64_t quad_pivots() const;

  Problem problem_;
  SparsePivoting sparse_;
  bool is_sparse_ = false;
  Lemke lemke_;
  CoveringLemke covering_;
  ExactSearch exact_;
  Answer attempt_;
  double deadline_s_ = 0;
  std::int64_t pivots_ = 0;           // of all stages that ended
  std::int64_t covering_pivots_ = 0;  // of the stage kCovering
  bool ended_by_share_ = false;       // the stage kLemke, by share_of_pivots()
  bool ended_in_ray_ = false;         // the stage kLemke
  bool is_inaccurate_ = false;        // some stage's answer failed the test by its residual
};

}  // namespace lcpbench
