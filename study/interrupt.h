#pragma once

#include <csignal>

namespace lcpbench {

/// Catches SIGINT and SIGTERM from now to the end of the process: the first raises the flag, the second ends the
/// process with `exit_code` at once (worker processes end with it).
/// @returns the flag
const volatile std::sig_atomic_t* catch_interrupts(int exit_code);

}  // namespace lcpbench
