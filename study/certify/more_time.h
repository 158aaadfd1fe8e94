#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "study/certify/branching.h"
#include "study/certify/candidates.h"
#include "study/certify/reduction.h"

namespace lcpbench::exact {

// The search while there is time left. It repeats its steps in rounds, and each round does more work than the last.

/// A step of a round takes at most 1/kTurns of the time left.
constexpr double kTurns = 4;

/// Four times as much work as the round before.
BranchingLimits longer_branching(Index round, const Deadline& deadline);

/// The complementary cones that the answers of several float solvers point to, whatever they claim.
class GuessedCones {
 public:
  struct Found {
    ExactPoint point;
    std::string solver;
  };

  /// @param solvers  specs; solvers that do not take the problem are skipped. All arguments outlive this object.
  GuessedCones(const Problem& problem, Candidates& candidates, const std::vector<std::string>& solvers)
      : problem_(problem), candidates_(candidates), solvers_(solvers) {}

  /// Tries every answer with its unclear rows settled exactly: more of them the later the round.
  std::optional<Found> next_point(const ExactSystem& system, Index round, const Deadline& deadline,
                                  const std::function<bool(const ExactPoint&)>& accepts);

 private:
  struct Answered {
    std::string solver;
    Vector z;
  };

  void ask(const Deadline& deadline);

  const Problem& problem_;
  Candidates& candidates_;
  const std::vector<std::string>& solvers_;
  std::vector<Answered> answers_;
};

}  // namespace lcpbench::exact
