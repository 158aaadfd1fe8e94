#pragma once

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace lcpbench::worker {

/// A program that is to be started: a worker, a user's own, an engine.
struct ProgramStart {
  /// Its file and its arguments. A name without a slash is looked for in PATH, a relative one with a slash in `folder`.
  std::vector<std::string> words;
  std::vector<int> descriptors;    ///< at most 10 of ours that become its descriptors 0, 1, ...; it inherits no others
  std::filesystem::path folder{};  ///< its working directory; empty: ours
  bool leads_session = false;      ///< it gets a session of its own: Ctrl-C at the terminal does not reach it
};

/// Starts a program with default signal handlers (an ignored SIGXFSZ stays ignored), no blocked signals, and the
/// numerical libraries held to one thread. SIGKILL ends it as soon as this process ends, in whatever way. The memory of
/// this process is not copied for it, and the calling thread may end before it.
/// @throws InputError when it cannot be run, std::system_error when there is no descriptor or process left for it
pid_t start_program(const ProgramStart& start);

/// Whether this child has ended. It then stays a zombie until reap(), so that no other process gets its id.
bool has_ended(pid_t child);

/// Whether SIGTERM, SIGKILL or SIGINT ended this child: they come from outside, not from a fault of its code as SIGSEGV
/// does. False after reap().
bool was_told_to_end(pid_t child);

/// Waits until this child has ended, reaps it, and tells how it ended: "killed by signal 11 (SIGSEGV)",
/// "exited with code 0".
std::string reap(pid_t child);

/// Runs a program of lcpbench's own, in a session of its own, and waits for its end. Its process group is killed when
/// `*stop` is not 0, and when the program has ended: also what it started and left behind.
/// @param output, messages  descriptors that become its standard output and its standard error
/// @returns how it ended, as reap(). @throws as start_program()
std::string run_program(const std::vector<std::string>& words, int output, int messages,
                        const volatile std::sig_atomic_t* stop);

}  // namespace lcpbench::worker
