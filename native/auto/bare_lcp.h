#pragma once

#include <cstdint>
#include <string>

#include "core/problem.h"
#include "core/solver.h"
#include "native/answer_test/answer_test.h"
#include "native/lemke/lemke.h"
#include "native/lemke/lemke_howson.h"

namespace lcpbench {

/// Solves a bare LCP by one method after the other, until one solves it or proves that it has no solution: the paths of
/// Lemke and Howson if it is that of a bimatrix game, `lemke`, `principal_pivoting`, `regularized`, and SupportSearch
/// if it is small enough. All answers are tested. The pivots of each path are limited; a method may take all the time
/// that is left.
class BareLcp {
 public:
  /// @param problem must be a bare LCP
  void load(const Problem& problem);

  /// `detail` is the method that solved it, or says why there is no answer; then z is zero. Methods after `lemke`
  /// allocate.
  /// @param answer  cleared by the caller
  void solve(const SolveRequest& request, Answer& answer);

 private:
  std::int64_t max_pivots() const;
  void play_game(double deadline_s);
  void search_supports(double deadline_s);
  bool is_settled(const std::string& method, Answer& answer) const;

  Problem problem_;
  LemkeHowson game_;
  bool is_game_ = false;
  Lemke lemke_{{}};
  AnswerTest test_;  ///< of methods that have none; loaded for games
  Answer attempt_;   ///< of the last method
};

}  // namespace lcpbench
