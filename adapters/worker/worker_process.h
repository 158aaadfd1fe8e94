#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include <sys/types.h>

#include "adapters/worker/worker_channel.h"
#include "adapters/worker/worker_client.h"
#include "adapters/worker/worker_protocol.h"

namespace lcpbench::worker {

/// A worker could not make its solver; the text is the worker's reason.
class SolverNotMade : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A running worker process and this side of its socket. The destructor kills and reaps it.
///
/// The process leads a session of its own: Ctrl-C at the terminal does not reach it. It is started by one thread that
/// lives as long as this program, because the kernel ends a worker with the thread that started it, not with the
/// program; so a worker outlives the thread that used it first, and never the program, whatever ends that.
class WorkerProcess {
 public:
  /// Starts the executable, which makes the solver of this spec, and waits for its greeting. @throws std::runtime_error
  /// with the reason when it does not come, SolverNotMade when it says that there is no solver.
  WorkerProcess(const std::filesystem::path& executable, const std::string& solver, const WorkerLimits& limits);
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  const Greeting& greeting() const { return greeting_; }

  bool send(std::span<const std::byte> packet, int attached) { return send_packet(socket_.get(), packet, attached); }

  enum class Event { kPacket, kEnded, kTimeout };
  struct Wait {
    Event event = Event::kTimeout;
    std::size_t packet_bytes = 0;  ///< more than the buffer holds when the packet was cut
  };
  /// Waits for one packet until the wall clock reaches `deadline_s` (infinity: for ever). kEnded: the process is dead,
  /// or has closed its end.
  Wait wait(std::span<std::byte> packet, double deadline_s);

  /// True once the process is dead. It stays a zombie, so that its id means nothing else, until end().
  bool dead() const;

  /// After kEnded: true when the process is dead or dies within a moment, false when it lives on without its socket.
  bool dies_by_itself() const;

  /// CPU time of the process so far [s]; 0 where the system does not tell.
  double cpu_s() const;

  /// Ends what still lives of the process and its group, reaps it, and tells how it ended: "killed by signal 11
  /// (SIGSEGV)", "exited with code 0". The process is asked first, by SIGTERM, for a moment: a worker that runs another
  /// program then ends that program's daemons too, which have left the group.
  std::string end();

  /// The end of what the worker wrote to its standard error since clear_messages(), as "; stderr: ..."; "" for nothing.
  std::string messages() const;

  /// Forgets what the worker wrote to its standard error so far.
  void clear_messages();

 private:
  void start(const std::filesystem::path& executable, const std::string& solver, const WorkerLimits& limits);
  void expect_greeting(double timeout_s);

  pid_t pid_ = -1;
  UniqueFd socket_;
  UniqueFd stderr_file_;
  Greeting greeting_;
};

}  // namespace lcpbench::worker
