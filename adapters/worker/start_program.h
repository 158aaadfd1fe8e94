#pragma once

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace lcpbench::worker {

/// A program that is to be started: a worker, a user's own, an engine.
struct ProgramStart {
  std::vector<std::string> words;  ///< its file, looked for in PATH where the name has no slash, and its arguments
  std::vector<int> descriptors;    ///< ours that become its descriptors 0, 1, ...; it inherits no others
  std::filesystem::path folder{};  ///< that it runs in; empty: ours
  bool leads_session = false;      ///< of its own: Ctrl-C at the terminal does not reach it
};

/// Starts a program with default signals (an ignored SIGXFSZ stays ignored) and with the numerical libraries held to
/// one thread. SIGKILL ends it as soon as this process ends, in whatever way. The memory of this process is not copied
/// for it, and the thread that calls may end before it.
/// @throws InputError when it cannot be run, std::system_error when there is no descriptor or process left for it
pid_t start_program(const ProgramStart& start);

/// Whether this child has ended. It stays a zombie, so that its id means nothing else, until reap().
bool has_ended(pid_t child);

/// Whether SIGTERM, SIGKILL or SIGINT ended this child: no fault of a library does. Not after reap().
bool was_told_to_end(pid_t child);

/// Waits until this child has ended, reaps it, and tells how it ended: "killed by signal 11 (SIGSEGV)",
/// "exited with code 0".
std::string reap(pid_t child);

/// Runs a program of lcpbench's own, in a session of its own, and waits for its end. All its processes are killed when
/// `*stop` is not 0, and when the program has ended.
/// @param output, messages  descriptors that become its standard output and its standard error
/// @returns how it ended, as reap(). @throws as start_program()
std::string run_program(const std::vector<std::string>& words, int output, int messages,
                        const volatile std::sig_atomic_t* stop);

}  // namespace lcpbench::worker
