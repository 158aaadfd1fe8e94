#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

#include "adapters/worker/worker_channel.h"
#include "core/solver.h"

namespace lcpbench::external {

/// Splits a command into words at spaces; single or double quotes keep spaces inside a word. Nothing is expanded.
/// @throws InputError on an empty command or an open quote.
std::vector<std::string> command_words(std::string_view command);

/// The program did not answer, or not with one line: it is of no more use.
class ProgramFailure : public std::runtime_error {
 public:
  ProgramFailure(Claim claim, const std::string& detail) : std::runtime_error(detail), claim_(claim) {}
  Claim claim() const { return claim_; }

 private:
  Claim claim_;
};

/// A running program that reads lines on its standard input and answers each with one line on its standard output. Its
/// standard error is drained, and its last line kept. The destructor kills and reaps it.
///
/// It stays in the process group of this worker, so that it ends with the worker even when it started children.
class ExternalProgram {
 public:
  /// Starts the program in the folder that lcpbench was started in; a name without a slash is looked for in PATH.
  /// @throws InputError when it cannot be run.
  explicit ExternalProgram(const std::vector<std::string>& words);
  ~ExternalProgram();
  ExternalProgram(const ExternalProgram&) = delete;
  ExternalProgram& operator=(const ExternalProgram&) = delete;

  /// Sends `line` (without a line end) and waits for the answer, which is returned without its line end.
  /// @throws ProgramFailure when none of at most `max_bytes` has come by `deadline_s` on the wall clock (kTimeLimit),
  /// or the program ends, closes its output or says more than was asked (kCrashed). The program is then dead.
  std::string ask(const std::string& line, std::size_t max_bytes, double deadline_s);

  /// -1 after a failure.
  pid_t id() const { return pid_; }

  /// True once it has ended, by itself or after a failure.
  bool dead() const;

 private:
  void start(const std::vector<std::string>& words);
  void write_some(std::string_view& unsent);
  /// True when the output is closed.
  bool read_output(std::size_t max_bytes);
  void read_messages();
  std::string end();
  std::string last_message() const;
  [[noreturn]] void fail(Claim claim, const std::string& cause);
  [[noreturn]] void fail_ended();

  pid_t pid_ = -1;
  worker::UniqueFd input_;
  worker::UniqueFd output_;
  worker::UniqueFd messages_;
  std::string received_;
  std::string message_tail_;
};

}  // namespace lcpbench::external
