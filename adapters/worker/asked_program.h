#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

#include "adapters/worker/unique_fd.h"
#include "core/solver.h"

namespace lcpbench::worker {

/// A program did not answer, or not with one whole message: it has been ended.
class NoAnswer : public std::runtime_error {
 public:
  NoAnswer(Claim claim, const std::string& detail) : std::runtime_error(detail), claim_(claim) {}
  /// kTimeLimit or kCrashed.
  Claim claim() const { return claim_; }

 private:
  Claim claim_;
};

/// A running program that answers each question with one message: a worker of ours, or a user's own solver or engine.
/// Its standard error is drained while an answer is awaited, and the end of it kept. The destructor kills and reaps it.
/// @pre SIGPIPE is ignored
class AskedProgram {
 public:
  enum class Channel {
    /// Questions and answers go through a socket at descriptor kSocketFd; standard input and output lead nowhere. The
    /// program leads a session of its own. It is asked by SIGTERM to end, before it and its group are killed: a worker
    /// that runs another program then ends that program's daemons too, which have left the group.
    kSocket,
    /// Questions go to its standard input, answers come from its standard output. It stays in our process group.
    kStandard,
  };
  /// Descriptor of the program's end of the socket.
  static constexpr int kSocketFd = 3;

  /// @param folder  that the program runs in; empty: ours. @throws as start_program()
  AskedProgram(const std::vector<std::string>& words, Channel channel, const std::filesystem::path& folder = {});
  ~AskedProgram() { end(); }
  AskedProgram(const AskedProgram&) = delete;
  AskedProgram& operator=(const AskedProgram&) = delete;

  /// The size of the message that `received` begins with; 0 while it is not known. May throw.
  using SizeOfMessage = std::size_t (*)(std::string_view received);

  /// Sends the question (nothing, where it is empty) and waits for the answer.
  /// @throws NoAnswer: kTimeLimit when no whole answer has come by `deadline_s` on the wall clock; kCrashed when the
  /// program ends or closes its output before that, answers with more than `max_bytes` or before the question is out,
  /// or says more than was asked. What size_of throws passes through; the program can then not be asked again.
  std::string ask(std::string_view question, SizeOfMessage size_of, std::size_t max_bytes, double deadline_s);

  /// -1 once it has been ended.
  pid_t id() const { return pid_; }
  /// True once it has ended, by itself or after a failure.
  bool dead() const;
  /// Between two questions: true when it lives, its socket is open, and it has said nothing. @pre Channel::kSocket
  bool idle() const;

  /// CPU time of the process so far [s]; 0 where the system does not tell.
  double cpu_s() const;

  /// Ends what still lives of it, and tells how it ended: "exited with code 0".
  std::string end();

  /// The end of what it wrote to its standard error, as "; stderr: ..."; "" for nothing. Of a program with
  /// Channel::kStandard it is the last line.
  std::string messages();
  /// Forgets what it wrote to its standard error so far.
  void forget_messages();

 private:
  bool is_worker() const { return channel_ == Channel::kSocket; }
  int input() const { return is_worker() ? output_.get() : input_.get(); }
  void write_some(std::string_view& unsent);
  void read_messages();
  [[noreturn]] void fail(Claim claim, const std::string& cause);
  /// @param begin  of what is too much in received_
  std::string more_than_asked(std::size_t begin) const;
  [[noreturn]] void fail_ended();

  Channel channel_;
  pid_t pid_ = -1;
  UniqueFd input_;
  UniqueFd output_;
  UniqueFd messages_;
  std::string received_;
  std::string message_tail_;
  double cpu_s_ = 0;  ///< when it was ended
};

}  // namespace lcpbench::worker
