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
/// First SparsePivoting, where M has few nonzeros. Then `lemke` as it is by itself; CoveringLemke in double; up to 40
/// rows `lemke` with tolerances near rounding; CoveringLemke in 113 bits, up to 40 rows with the other covering vector
/// too; `lemke` again, longer, where only its share of pivots ended it; and up to kLargestExact rows every support in
/// exact arithmetic. Above 40 rows it ends after two where the first ends in a ray, and goes to 113 bits, up to
/// CoveringLemke::kLargestQuad rows, only where a path in double ended in an answer that is not accurate enough and the
/// share allows the pivots that the second stage took: a path in 113 bits takes some hundred times as long as one in
/// double, and hardly ever finds an answer where all those in double end without one. The methods have a share of
/// pivots in proportion to n, which a path that does not go round seldom needs. All memory is taken by load(): in
/// solve() only SparsePivoting, where it takes the problem, and exact arithmetic allocate.
class LcpLadder {
 public:
  LcpLadder();

  /// @param problem a bare LCP
  void load(const Problem& problem);

  /// `answer` arrives cleared. @param text what became of it, for `detail`
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
  // Each leaves its tested answer in attempt_.
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
  std::int64_t pivots_ = 0;           // of all stages so far
  std::int64_t covering_pivots_ = 0;  // of kCovering
  bool ended_by_share_ = false;       // kLemke
  bool ended_in_ray_ = false;         // kLemke
  bool is_inaccurate_ = false;        // the answer of some stage so far
};

}  // namespace lcpbench
