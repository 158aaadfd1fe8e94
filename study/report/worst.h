#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/io/scenes_file.h"
#include "study/summary/summary.h"

// The problems that a solver fails on most, and the commands that repeat them.

namespace lcpbench::report {

/// A failed answer, as failures are compared.
struct Failure {
  bool false_claim = false;
  double error = 0;  ///< what the verdict was taken on; NaN: no number

  /// False claims before honest failures, then by the error.
  bool worse_than(const Failure& other) const;
  /// "wrong by 8.1e-01", "wrong, no number", "not solved".
  std::string text() const;
};

/// A problem of a set that a solver failed.
struct FailedProblem {
  ProblemKey problem;
  Failure failure;
  Claim claim = Claim::kNumericalFailure;
  double time_s = 0;  ///< NaN where nothing was timed
};

/// The problems of a set that a solver fails most, the worst first; at most so many. A refused problem and one that is
/// proven unsolvable are no failures, a false claim always is.
std::vector<FailedProblem> worst_problems(const Cell& cell, std::span<const ProblemKey> problems, std::size_t most);

/// Commands for the problems of a summary.
class ReplayCommands {
 public:
  explicit ReplayCommands(const Summary& summary) : summary_(summary) {}

  /// "lcpbench solve 'F.scenes#120' --solver S", or 'SET#TRIAL', or with `lcpbench generate` before it where the seed is
  /// not 1; `lcpbench run` where the solver started from its last answer. "" where a file of captured steps is gone,
  /// unless it started from its last answer.
  /// `solve` repeats an answer that reached its time limit with the limit of the last run.
  std::string command(const Cell& cell, const FailedProblem& failed);

 private:
  std::string option(const char* name, const char* field) const;

  const Summary& summary_;
  std::map<std::string, std::unique_ptr<ScenesFile>> files_;  ///< nullptr for one that cannot be read
};

/// A shell command with `words` as a comment, if both fit on one line. Otherwise the command alone, continued with
/// backslashes where it is too long.
std::string command_text(const std::string& command, const std::string& words, int width);

}  // namespace lcpbench::report
