#pragma once

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "adapters/worker/worker_client.h"
#include "tests/adapters/misbehaviour.h"

/// The external program of the tests and what they ask of it, and the processes that are about.
namespace lcpbench {

inline constexpr TimedRequest kImpatient{.time_limit_s = 0.3};

inline std::unique_ptr<TimedSolver> client(const std::string& command = EXTERNAL_FAULTS,
                                           const std::string& form = "lcp", const WorkerLimits& limits = {}) {
  return worker_solver(EXTERNAL_WORKER, Spec{"external", {{"command", command}, {"form", form}}}, limits);
}

inline Answer run(TimedSolver& solver, const std::string& behaviour, const TimedRequest& request = kPatient) {
  TimedAnswer result;
  solver.run(named(behaviour), request, result);
  return result.answer;
}

inline void expect_right(TimedSolver& solver) {
  const Answer answer = run(solver, "right");
  EXPECT_STREQ(to_string(answer.claim), "solved") << answer.detail;
  EXPECT_TRUE(answer.z.size() == kSize && (answer.z.array() == 0.5).all()) << answer.z.transpose();
}

inline std::string start_error(const std::string& command) {
  try {
    run(*client(command), "right");
    return "it starts";
  } catch (const WorkerError& error) {
    return error.what();
  }
}

inline char state_of(pid_t process) { return process_state("/proc/" + std::to_string(process)).state; }

/// Reaps what this process has left of children; true when all of them ended by themselves.
inline bool all_children_end_within(double seconds) {
  const double deadline_s = wall_clock_s() + seconds;
  while (wall_clock_s() < deadline_s) {
    if (waitpid(-1, nullptr, WNOHANG) < 0) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  for (const pid_t child : children_of(getpid())) kill(child, SIGKILL);
  while (waitpid(-1, nullptr, 0) > 0) continue;
  return false;
}

/// A folder of its own, removed at the end.
class Scratch {
 public:
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "lcpbench-external-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~Scratch() { std::filesystem::remove_all(path_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string file(const char* name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace lcpbench
