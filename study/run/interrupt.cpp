#include "study/run/interrupt.h"

#include <cerrno>
#include <initializer_list>
#include <string_view>

#include <poll.h>
#include <unistd.h>

#include "core/io/whole_file.h"

namespace lcpbench {
namespace {

volatile std::sig_atomic_t interrupts = 0;
volatile std::sig_atomic_t exit_code_of_end = 0;
/// Someone looks at the flag and ends the program in good order.
volatile std::sig_atomic_t is_watched = 0;
volatile std::sig_atomic_t is_on_terminal = 0;
volatile std::sig_atomic_t is_abandoned = 0;  ///< the present work, where an interrupt comes
constexpr unsigned kPatienceS = 1;

/// Prints to stderr, after erasing the progress line that may stand there. Safe in a signal handler.
void print(std::string_view words) {
  constexpr std::string_view kEmptyLine = "\r\033[K";
  [[maybe_unused]] ssize_t written = 0;
  if (is_on_terminal != 0) written = write(STDERR_FILENO, kEmptyLine.data(), kEmptyLine.size());
  written = write(STDERR_FILENO, words.data(), words.size());
}

void on_interrupt(int) {
  if (is_watched != 0 && interrupts == 0) {
    const int error = errno;  // of what the signal interrupts
    print("lcpbench: interrupted; the command keeps what is done and ends (a second signal ends it at once)\n");
    interrupts = 1;
    alarm(kPatienceS);
    errno = error;
    return;
  }
  print("lcpbench: interrupted\n");
  _exit(exit_code_of_end);
}

/// Whether who reads standard output has left it full for two calls. Safe in a signal handler.
bool waits_for_reader() {
  static volatile std::sig_atomic_t full = 0;
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  full = poll(&output, 1, 0) == 0 ? full + 1 : 0;
  return full >= 2;
}

/// Each second after an interrupt.
void on_alarm(int) {
  if (is_abandoned != 0 || files_in_place != 0 || waits_for_reader()) {
    print("lcpbench: interrupted\n");
    _exit(exit_code_of_end);
  }
  alarm(kPatienceS);
}

/// A handler, and not SIG_IGN, which the programs that this one starts would inherit: the write fails with EFBIG.
void on_file_too_large(int) {}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  sigaction(signal, nullptr, &action);
  if (action.sa_handler == SIG_IGN) return;
  action = {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigaction(signal, &action, nullptr);
}

}  // namespace

void announce_interrupts(int exit_code) {
  exit_code_of_end = exit_code;
  is_on_terminal = isatty(STDERR_FILENO);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) handle(signal, on_interrupt);
  handle(SIGXFSZ, on_file_too_large);
}

const volatile std::sig_atomic_t* catch_interrupts(int exit_code) {
  announce_interrupts(exit_code);
  handle(SIGALRM, on_alarm);
  is_watched = 1;
  return &interrupts;
}

AbandonedAfterInterrupt::AbandonedAfterInterrupt() { is_abandoned = 1; }
AbandonedAfterInterrupt::~AbandonedAfterInterrupt() { is_abandoned = 0; }

}  // namespace lcpbench
