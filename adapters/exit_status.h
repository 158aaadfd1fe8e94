#pragma once

#include <string>

namespace lcpbench::worker {

/// How a process ended, from the status of waitpid: "killed by signal 11 (SIGSEGV)", "exited with code 0".
std::string describe_exit(int status);

}  // namespace lcpbench::worker
