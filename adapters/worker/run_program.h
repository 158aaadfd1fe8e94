#pragma once

#include <csignal>
#include <string>
#include <vector>

namespace lcpbench::worker {

/// Runs a program of lcpbench's own and waits for its end. The program leads a process group of its own, which Ctrl-C
/// at the terminal does not reach. The whole group is killed when `*stop` is not 0, and when the program has ended. The
/// program is killed when this process ends, in whatever way.
///
/// @param words     the program's file and its arguments
/// @param output    descriptor that becomes its standard output
/// @param messages  descriptor that becomes its standard error
/// @returns how it ended: "exited with code 0", "killed by signal 11 (SIGSEGV)". @throws InputError when it cannot run
/// @pre the calling thread lives as long as the process
std::string run_program(std::vector<std::string> words, int output, int messages,
                        const volatile std::sig_atomic_t* stop);

}  // namespace lcpbench::worker
