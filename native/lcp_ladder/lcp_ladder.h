#pragma once

#include "core/problem.h"
#include "core/solver.h"
#include "native/lcp_ladder/covering_lemke.h"
#include "native/lcp_ladder/lemke_howson.h"
#include "native/lcp_ladder/sparse_pivoting.h"
#include "native/lemke/lemke.h"
#include "native/proofs/support_search.h"

namespace lcpbench {

/// Solves a bare LCP by one method after the other until an answer passes AnswerTest with a backward error of at most
/// 1e-9, or the problem is proven to have no solution; the best that passed where no stage is as accurate.
///
/// The stages, in this order:
/// - SparsePivoting, if its load() takes M;
/// - LemkeHowson, if M is that of a bimatrix game;
/// - `lemke` with its default tolerances and a low limit on pivots;
/// - CoveringLemke in double;
/// - if n <= 40, `lemke` with tolerances near rounding;
/// - CoveringLemke in 113 bits, if n <= 40 also with Cover::kNegative;
/// - `lemke` with its default tolerances and more pivots, if its first run ended at the limit on pivots;
/// - if n <= kLargestExact, every support, in 113 bits.
/// If n > 40, what is slow and hardly ever finds an answer is left out:
/// - After `lemke` ended in a ray, only CoveringLemke in double follows, and nothing if the ray shows that the problem
///   is unsolvable up to rounding.
/// - 113 bits take some hundred times as long as double. They are tried if n <= CoveringLemke::kLargestQuad, an earlier
///   stage found an answer that is not accurate enough, and their limit on pivots is not below the number of pivots
///   that CoveringLemke took in double.
///
/// Limits on pivots grow with n; in 113 bits they also limit the work to about a second. Paths that do not cycle seldom
/// reach them. load() takes the memory: in solve() only SparsePivoting and SupportSearch allocate.
class LcpLadder {
 public:
  LcpLadder();

  /// @param problem a bare LCP
  void load(const Problem& problem);

  /// Where no stage has an answer or a proof, the claim stays as it was or becomes kTimeLimit, and no z is set.
  /// @param answer  cleared by the caller
  /// @param text  for Answer::detail: the stage that solved it, or why there is no answer
  void solve(const SolveRequest& request, Answer& answer, const char*& text);

 private:
  static constexpr Index kLargestExact = SupportSearch::kMaxSize;

  enum class Stage {
    kSparse,
    kGame,
    kLemke,
    kCovering,
    kLemkeTight,
    kCoveringQuad,
    kCoveringQuadNegative,
    kLemkeLong,
    kExact,
  };

  /// Else no stage runs.
  bool takes() const { return problem_.size() <= lemke_.capabilities().max_size; }
  bool has(Stage stage) const;
  // Each leaves its result in attempt_. Answers have been tested by AnswerTest.
  void run_sparse(Stage stage);
  void run_game(Stage stage);
  void run_lemke(Stage stage);
  void run_covering(Stage stage);
  void run_exact(Stage stage);
  bool is_final(Stage stage, Answer& answer, const char*& text);
  std::int64_t share_of_pivots() const;
  std::int64_t quad_pivots() const;

  Problem problem_;
  SparsePivoting sparse_;
  bool is_sparse_ = false;
  LemkeHowson game_;
  bool is_game_ = false;
  Lemke lemke_;
  CoveringLemke covering_;
  SupportSearch supports_;
  Answer attempt_;
  double deadline_s_ = 0;
  std::int64_t pivots_ = 0;           // of all stages that ended
  std::int64_t covering_pivots_ = 0;  // of the stage kCovering
  bool ended_by_share_ = false;       // the stage kLemke, by share_of_pivots()
  bool ended_in_ray_ = false;         // the stage kLemke
  bool is_inaccurate_ = false;        // some stage's answer failed the test by its residual, or hardly passed
  double least_error_ = 0;            // of those that passed
};

}  // namespace lcpbench
