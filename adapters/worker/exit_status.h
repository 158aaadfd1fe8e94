#pragma once

#include <string>

#include <sys/types.h>

namespace lcpbench::worker {

/// Waits until this child has ended, reaps it, and tells how it ended: "killed by signal 11 (SIGSEGV)",
/// "exited with code 0".
std::string reap(pid_t child);

}  // namespace lcpbench::worker
