#include "adapters/external/external_program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "adapters/worker/child_processes.h"
#include "adapters/worker/exit_status.h"
#include "adapters/worker/start_directory.h"
#include "core/error.h"
#include "core/timed_solve.h"

namespace lcpbench::external {
namespace {

using worker::UniqueFd;

/// How often a waiting worker looks whether the program died although something still holds its output open.
constexpr double kDeathCheckPeriod_s = 0.05;
/// How long a program that closed its output is given to be seen as dead of its own cause.
constexpr double kLastWords_s = 0.2;
constexpr std::size_t kReadBytes = 1 << 16;
constexpr std::size_t kMessageTailBytes = 4096;
constexpr std::size_t kShownMessageBytes = 300;

struct Pipe {
  UniqueFd read;
  UniqueFd write;

  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
    read = UniqueFd(ends[0]);
    write = UniqueFd(ends[1]);
  }
};

void make_nonblocking(const UniqueFd& fd) { fcntl(fd.get(), F_SETFL, O_NONBLOCK); }

void restore_signals() {
  for (int signal_number = 1; signal_number < NSIG; ++signal_number) {
    // A file over its size limit stays a failed write; the program need not die of it.
    if (signal_number != SIGXFSZ) signal(signal_number, SIG_DFL);
  }
}

/// The steps by which a child becomes the program. Each of them can fail.
enum class StartStep { kEnterFolder, kRun };

/// The message of a child that failed to its parent.
struct StartFailure {
  StartStep step = StartStep::kRun;
  int cause = 0;  ///< errno
};

/// Runs in the child. Returns only on failure, with errno.
StartStep become(std::vector<char*>& words, pid_t parent, const Pipe& input, const Pipe& output, const Pipe& messages) {
  worker::end_with_parent(parent);
  restore_signals();
  if (!start_directory().empty() && chdir(start_directory().c_str()) != 0) return StartStep::kEnterFolder;
  dup2(input.read.get(), STDIN_FILENO);
  dup2(output.write.get(), STDOUT_FILENO);
  dup2(messages.write.get(), STDERR_FILENO);
  close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
  execvp(words[0], words.data());
  return StartStep::kRun;
}

std::string describe(const StartFailure& failure, const std::string& program) {
  const std::string cause = std::strerror(failure.cause);
  if (failure.step == StartStep::kEnterFolder) {
    return "cannot run " + program + " in " + start_directory().string() + ": " + cause;
  }
  return "cannot run " + program + ": " + cause + "; docs/reference/external.md says how to name a program";
}

int poll_timeout_ms(double seconds) {
  return static_cast<int>(std::ceil(std::clamp(seconds, 0.0, kDeathCheckPeriod_s) * 1e3));
}

bool would_block() { return errno == EAGAIN || errno == EINTR; }

std::string seconds_text(double seconds) { return std::to_string(std::lround(seconds * 1e3)) + " ms"; }

}  // namespace

std::vector<std::string> command_words(std::string_view command) {
  std::vector<std::string> words;
  bool in_word = false;
  char quote = 0;
  for (const char c : command) {
    if (quote == 0 && c == ' ') {
      in_word = false;
      continue;
    }
    if (!in_word) words.emplace_back();
    in_word = true;
    if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
    } else if (c == quote) {
      quote = 0;
    } else {
      words.back() += c;
    }
  }
  if (quote != 0) throw InputError("external: command: an open quote in " + std::string(command));
  if (words.empty() || words.front().empty()) {
    throw InputError("external: command names no program: external{command=./mine.py}");
  }
  return words;
}

ExternalProgram::ExternalProgram(const std::vector<std::string>& words) { start(words); }

ExternalProgram::~ExternalProgram() { end(); }

void ExternalProgram::start(const std::vector<std::string>& words) {
  Pipe input;
  Pipe output;
  Pipe messages;
  Pipe error;
  std::vector<std::string> copies = words;
  std::vector<char*> pointers;
  for (std::string& word : copies) pointers.push_back(word.data());
  pointers.push_back(nullptr);

  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (pid_ == 0) {
    const StartStep step = become(pointers, parent, input, output, messages);
    const StartFailure failure{step, errno};
    const ssize_t told = write(error.write.get(), &failure, sizeof failure);
    _exit(told == sizeof failure ? 127 : 126);
  }
  error.write.reset();
  StartFailure failure;
  if (read(error.read.get(), &failure, sizeof failure) == sizeof failure) {
    end();
    throw InputError("external: " + describe(failure, words.front()));
  }
  input_ = std::move(input.write);
  output_ = std::move(output.read);
  messages_ = std::move(messages.read);
  for (const UniqueFd* fd : {&input_, &output_, &messages_}) make_nonblocking(*fd);
}

std::string ExternalProgram::ask(const std::string& line, std::size_t max_bytes, double deadline_s) {
  const double begin_s = wall_clock_s();
  const std::string message = line + "\n";
  std::string_view unsent = message;
  read_output(max_bytes);
  if (!received_.empty()) fail(Claim::kCrashed, "said more than was asked");
  for (bool ended = false;;) {
    const double left = deadline_s - wall_clock_s();
    std::array<pollfd, 3> polled{
        {{unsent.empty() ? -1 : input_.get(), POLLOUT, 0}, {output_.get(), POLLIN, 0}, {messages_.get(), POLLIN, 0}}};
    const int ready = poll(polled.data(), polled.size(), ended ? 0 : poll_timeout_ms(left));
    if (polled[0].revents != 0) write_some(unsent);
    if (polled[2].revents != 0) read_messages();
    if (polled[1].revents != 0) {
      const bool closed = read_output(max_bytes);
      const auto line_end = received_.find('\n');
      if (line_end != std::string::npos) {
        if (!unsent.empty()) fail(Claim::kCrashed, "answered before the question was out");
        if (line_end + 1 != received_.size()) fail(Claim::kCrashed, "said more than was asked");
        received_.pop_back();
        return std::exchange(received_, {});
      }
      if (closed) fail_ended();
    } else if (ended && ready >= 0) {
      fail_ended();
    } else if (dead()) {
      ended = true;  // it may have answered after poll() looked: once more
      continue;
    }
    if (!(left > 0)) fail(Claim::kTimeLimit, "gave no answer within " + seconds_text(wall_clock_s() - begin_s));
  }
}

void ExternalProgram::write_some(std::string_view& unsent) {
  const ssize_t written = write(input_.get(), unsent.data(), unsent.size());
  if (written > 0) unsent.remove_prefix(static_cast<std::size_t>(written));
  if (written < 0 && !would_block()) unsent = {};  // it reads no more; it may still answer, or be found dead
}

bool ExternalProgram::read_output(std::size_t max_bytes) {
  std::array<char, kReadBytes> buffer;
  const ssize_t count = read(output_.get(), buffer.data(), buffer.size());
  if (count < 0) return !would_block();
  received_.append(buffer.data(), static_cast<std::size_t>(count));
  if (received_.size() > max_bytes) {
    received_.clear();
    fail(Claim::kCrashed, "gave an answer of more than " + std::to_string(max_bytes) + " bytes");
  }
  return count == 0;
}

void ExternalProgram::read_messages() {
  std::array<char, kReadBytes> buffer;
  const ssize_t count = read(messages_.get(), buffer.data(), buffer.size());
  if (count > 0) message_tail_.append(buffer.data(), static_cast<std::size_t>(count));
  if (count == 0 || (count < 0 && !would_block())) messages_.reset();
  if (message_tail_.size() > kMessageTailBytes) message_tail_.erase(0, message_tail_.size() - kMessageTailBytes);
}

bool ExternalProgram::dead() const {
  if (pid_ < 0) return true;
  siginfo_t info{};
  if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0) return errno == ECHILD;
  return info.si_pid == pid_;
}

std::string ExternalProgram::end() {
  if (pid_ < 0) return "is not running";
  kill(pid_, SIGKILL);
  return worker::reap(std::exchange(pid_, -1));
}

/// The last line on its standard error that is not empty, as "; stderr: ..."; "" for none.
std::string ExternalProgram::last_message() const {
  const auto line_end = message_tail_.find_last_not_of(" \t\r\n");
  if (line_end == std::string::npos) return {};
  const std::string_view text = std::string_view(message_tail_).substr(0, line_end + 1);
  const auto before = text.find_last_of('\n');
  const std::string_view line = before == std::string_view::npos ? text : text.substr(before + 1);
  return "; stderr: " + std::string(line.substr(0, kShownMessageBytes));
}

void ExternalProgram::fail(Claim claim, const std::string& cause) {
  end();
  read_messages();
  throw ProgramFailure(claim, cause + last_message());
}

void ExternalProgram::fail_ended() {
  const double deadline_s = wall_clock_s() + kLastWords_s;
  while (!dead() && wall_clock_s() < deadline_s) poll(nullptr, 0, 1);
  const bool by_itself = dead();
  const std::string ending = end();
  fail(Claim::kCrashed, (by_itself ? ending : "closed its output") + " without an answer");
}

}  // namespace lcpbench::external
