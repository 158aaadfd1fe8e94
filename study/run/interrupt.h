#pragma once

#include <csignal>

namespace lcpbench {

/// From now on SIGINT, SIGTERM and SIGHUP do not end the program without a word: they print one line and end the
/// process with `exit_code` (worker processes end with it). A signal that the parent ignores stays ignored, as `nohup`
/// asks. A file that grows beyond the limit (SIGXFSZ) is an error of the write, and no end.
void announce_interrupts(int exit_code);

/// Catches the signals from now to the end of the process: the first prints one line and raises the flag, the second
/// ends the process at once as above. Each long command looks at the flag between two pieces of its work, keeps or
/// prints what is done, and ends with `exit_code`. Where it writes into a pipe that nobody reads, or into a file in
/// place (a FIFO), the process ends as above within three seconds.
/// @returns the flag
const volatile std::sig_atomic_t* catch_interrupts(int exit_code);

/// Work on foreign input, such as the reading of a file, that looks at no flag and of which nothing is worth keeping.
/// If it lasts longer than a second after the first signal, the process ends as above. One at a time; it needs SIGALRM
/// and alarm() for itself.
class AbandonedAfterInterrupt {
 public:
  AbandonedAfterInterrupt();
  ~AbandonedAfterInterrupt();
  AbandonedAfterInterrupt(const AbandonedAfterInterrupt&) = delete;
  AbandonedAfterInterrupt& operator=(const AbandonedAfterInterrupt&) = delete;
};

}  // namespace lcpbench
