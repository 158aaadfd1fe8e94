#include "study/interrupt.h"

#include <unistd.h>

namespace lcpbench {
namespace {

volatile std::sig_atomic_t interrupts = 0;
volatile std::sig_atomic_t exit_code_of_second = 0;

void on_interrupt(int) {
  if (interrupts != 0) _exit(exit_code_of_second);
  interrupts = 1;
}

}  // namespace

const volatile std::sig_atomic_t* catch_interrupts(int exit_code) {
  exit_code_of_second = exit_code;
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return &interrupts;
}

}  // namespace lcpbench
