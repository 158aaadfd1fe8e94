#include "study/interrupt.h"

#include <initializer_list>
#include <string_view>

#include <unistd.h>

namespace lcpbench {
namespace {

volatile std::sig_atomic_t interrupts = 0;
volatile std::sig_atomic_t exit_code_of_end = 0;
/// Someone looks at the flag and ends the program in good order.
volatile std::sig_atomic_t is_watched = 0;

void on_interrupt(int) {
  if (is_watched != 0 && interrupts == 0) {
    interrupts = 1;
    return;
  }
  constexpr std::string_view kWords = "lcpbench: interrupted\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kWords.data(), kWords.size());
  _exit(exit_code_of_end);
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
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) handle(signal, on_interrupt);
  handle(SIGXFSZ, on_file_too_large);
}

const volatile std::sig_atomic_t* catch_interrupts(int exit_code) {
  announce_interrupts(exit_code);
  is_watched = 1;
  return &interrupts;
}

}  // namespace lcpbench
