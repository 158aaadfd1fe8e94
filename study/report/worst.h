#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>

#include "core/io/scenes_file.h"
#include "study/summary/summary.h"

// The problem that a solver fails on most, and the command that repeats it.

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

/// The answers of a set's cell that fail most; nullptr where none does. A refused problem and one that is proven
/// unsolvable are no failures, a false claim always is.
const Outcome* worst_outcome(const Cell& cell);

/// Commands for the problems of a summary.
class ReplayCommands {
 public:
  explicit ReplayCommands(const Summary& summary) : summary_(summary) {}

  /// "lcpbench solve 'F.scenes#120' --solver S", or with `lcpbench generate` before it. "" where there is none: the
  /// file is gone, or the answer is a recorded one that a generated problem does not carry.
  std::string command(const Cell& cell, const Outcome& outcome);

 private:
  const Summary& summary_;
  std::map<std::string, std::unique_ptr<ScenesFile>> files_;  ///< nullptr for one that cannot be read
};

/// For each solver that fails its worst problem, the gravest first: at most so many commands, with a line above them
/// and one that says how many were left out. "" where nobody fails, or without rows.
std::string worst_text(const Summary& summary, std::size_t rows, int width);

/// A command and words on it, for a shell: on one line where that fits, else on several, as a shell takes them.
std::string command_text(const std::string& command, const std::string& words, int width);

}  // namespace lcpbench::report
