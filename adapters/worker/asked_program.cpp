#include "adapters/worker/asked_program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include "adapters/worker/start_program.h"
#include "core/timed_solve.h"
#include "core/utf8.h"

namespace lcpbench::worker {
namespace {

/// Time between two checks whether the program died although another process still holds its output open.
constexpr double kDeathCheckPeriod_s = 0.05;
/// A program that dies within this time after its output closed ended by itself: the error then tells how.
constexpr double kLastWords_s = 0.2;
/// Time for a scheduler to signal all processes of a job: milliseconds, on a busy machine more.
constexpr useconds_t kSignalsToAll_us = 300'000;
/// How long a worker that is asked to end is given to end its program's processes, before it is killed.
constexpr double kFarewell_s = 0.5;
constexpr std::size_t kReadBytes = 1 << 16;
constexpr std::size_t kMessageTailBytes = 4096;
constexpr std::size_t kShownMessageBytes = 300;

struct Ends {
  UniqueFd ours;
  UniqueFd its;
};

enum class Direction { kFromProgram, kToProgram, kBoth };

/// A pipe, or a socket for both directions.
Ends connection(Direction direction) {
  std::array<int, 2> ends{};
  const int error = direction == Direction::kBoth ? socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data())
                                                  : pipe2(ends.data(), O_CLOEXEC);
  if (error != 0) throw std::system_error(errno, std::generic_category(), "no connection to a program");
  if (direction == Direction::kToProgram) std::swap(ends[0], ends[1]);  // a pipe's first end reads
  return {UniqueFd(ends[0]), UniqueFd(ends[1])};
}

int poll_timeout_ms(double seconds) {
  return static_cast<int>(std::ceil(std::clamp(seconds, 0.0, kDeathCheckPeriod_s) * 1e3));
}

bool would_block() { return errno == EAGAIN || errno == EINTR; }

/// Appends what can be read at once, up to kReadBytes. True when nothing more will come.
bool read_some(const UniqueFd& from, std::string& text) {
  std::array<char, kReadBytes> buffer;
  const ssize_t count = read(from.get(), buffer.data(), buffer.size());
  if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
  return count == 0 || (count < 0 && !would_block());
}

}  // namespace

AskedProgram::AskedProgram(const std::vector<std::string>& words, Channel channel, const std::filesystem::path& folder)
    : channel_(channel) {
  Ends messages = connection(Direction::kFromProgram);
  ProgramStart start{.words = words, .folder = folder, .leads_session = is_worker()};
  Ends input;
  Ends output;
  UniqueFd nothing;
  if (is_worker()) {
    output = connection(Direction::kBoth);
    nothing = UniqueFd(open("/dev/null", O_RDWR | O_CLOEXEC));
    start.descriptors = {nothing.get(), nothing.get(), messages.its.get(), output.its.get()};
  } else {
    input = connection(Direction::kToProgram);
    output = connection(Direction::kFromProgram);
    start.descriptors = {input.its.get(), output.its.get(), messages.its.get()};
  }
  pid_ = start_program(start);
  input_ = std::move(input.ours);
  output_ = std::move(output.ours);
  messages_ = std::move(messages.ours);
  for (const UniqueFd* fd : {&input_, &output_, &messages_}) fcntl(fd->get(), F_SETFL, O_NONBLOCK);
}

std::string AskedProgram::ask(std::string_view question, SizeOfMessage size_of, std::size_t max_bytes,
                              double deadline_s) {
  const double begin_s = wall_clock_s();
  std::string_view unsent = question;
  if (!question.empty()) read_some(output_, received_);
  if (!received_.empty()) fail(Claim::kCrashed, more_than_asked(0));
  if (!unsent.empty()) write_some(unsent);
  for (bool ended = false;;) {
    const double left = deadline_s - wall_clock_s();
    std::array<pollfd, 3> polled{
        {{unsent.empty() ? -1 : input(), POLLOUT, 0}, {output_.get(), POLLIN, 0}, {messages_.get(), POLLIN, 0}}};
    const int ready = poll(polled.data(), polled.size(), ended ? 0 : poll_timeout_ms(left));
    if (polled[0].revents != 0) write_some(unsent);
    if (polled[2].revents != 0) read_messages();
    if (polled[1].revents != 0) {
      const bool closed = read_some(output_, received_);
      const std::size_t size = size_of(received_);
      if (std::max(size, received_.size()) > max_bytes) {
        fail(Claim::kCrashed, "gave an answer of more than " + std::to_string(max_bytes) + " bytes");
      }
      if (size > 0 && received_.size() >= size) {
        if (!unsent.empty()) fail(Claim::kCrashed, "answered before the question was out");
        if (received_.size() > size) fail(Claim::kCrashed, more_than_asked(size));
        return std::exchange(received_, {});
      }
      if (closed) fail_ended();
    } else if (ended && ready >= 0) {
      fail_ended();
    } else if (dead()) {
      ended = true;  // it may have answered after poll() looked: once more
      continue;
    }
    if (!(left > 0)) {
      const auto waited_ms = std::lround((wall_clock_s() - begin_s) * 1e3);
      fail(Claim::kTimeLimit, "gave no answer within " + std::to_string(waited_ms) + " ms");
    }
  }
}

std::string AskedProgram::more_than_asked(std::size_t begin) const {
  constexpr std::size_t kShown = 60;  // bytes
  const std::string said = "said more than was asked";
  if (is_worker()) return said;
  if (received_.front() != '{') begin = 0;  // it said something before its answer
  const std::string line = received_.substr(begin, received_.find('\n', begin) - begin);
  return said + ": '" + printable(line.substr(0, kShown)) + (line.size() > kShown ? "..." : "") +
         "'; what is no answer belongs on stderr";
}

void AskedProgram::write_some(std::string_view& unsent) {
  const ssize_t written = is_worker() ? send(input(), unsent.data(), unsent.size(), MSG_NOSIGNAL)
                                      : write(input(), unsent.data(), unsent.size());
  if (written > 0) unsent.remove_prefix(static_cast<std::size_t>(written));
  if (written < 0 && !would_block()) unsent = {};  // it reads no more; it may still answer, or be found dead
}

void AskedProgram::read_messages() {
  if (read_some(messages_, message_tail_)) messages_.reset();
  if (message_tail_.size() > kMessageTailBytes) message_tail_.erase(0, message_tail_.size() - kMessageTailBytes);
}

void AskedProgram::forget_messages() {
  read_messages();
  message_tail_.clear();
}

std::string AskedProgram::messages() {
  read_messages();
  const auto last = message_tail_.find_last_not_of(" \t\r\n");
  if (last == std::string::npos) return {};
  std::string_view text = std::string_view(message_tail_).substr(0, last + 1);
  if (is_worker()) {
    text.remove_prefix(text.size() - std::min(text.size(), kShownMessageBytes));
  } else {
    text = text.substr(text.find_last_of('\n') + 1).substr(0, kShownMessageBytes);
  }
  return "; stderr: " + std::string(text);
}

bool AskedProgram::dead() const { return pid_ < 0 || has_ended(pid_); }

bool AskedProgram::idle() const {
  char byte = 0;
  return !dead() && recv(output_.get(), &byte, 1, MSG_PEEK) < 0 && would_block();
}

double AskedProgram::cpu_s() const {
  clockid_t clock{};
  timespec time{};
  if (pid_ < 0 || clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &time) != 0) return cpu_s_;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string AskedProgram::end() {
  if (pid_ < 0) return "is not running";
  cpu_s_ = cpu_s();
  if (is_worker()) {
    kill(pid_, SIGTERM);
    kill(pid_, SIGCONT);
    const double deadline_s = wall_clock_s() + kFarewell_s;
    while (!dead() && wall_clock_s() < deadline_s) usleep(200);
    kill(-pid_, SIGKILL);
  }
  kill(pid_, SIGKILL);
  return reap(std::exchange(pid_, -1));
}

void AskedProgram::fail(Claim claim, const std::string& cause) {
  end();
  throw NoAnswer(claim, cause + messages());
}

void AskedProgram::fail_ended() {
  const double deadline_s = wall_clock_s() + kLastWords_s;
  while (!dead() && wall_clock_s() < deadline_s) usleep(1000);
  const bool by_itself = dead();
  // A scheduler ends a job by a signal to each of its processes. Wait for that of this process, so that the caller
  // does not take the end of the job for a crash.
  if (by_itself && was_told_to_end(pid_)) usleep(kSignalsToAll_us);
  const std::string ending = end();
  fail(Claim::kCrashed, (by_itself ? ending : "closed its output") + " without an answer");
}

}  // namespace lcpbench::worker
