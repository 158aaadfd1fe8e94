#pragma once

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "adapters/worker/worker_client.h"

/// The external program of the tests and what they ask of it, and the processes that are about.
namespace lcpbench {

inline constexpr Index kSize = 5;
inline constexpr TimedRequest kPatient{.time_limit_s = 20.0};
inline constexpr TimedRequest kImpatient{.time_limit_s = 0.3};

inline Problem named(const std::string& behaviour, double q = -1.0) {
  return {behaviour, Lcp{2.0 * Matrix::Identity(kSize, kSize), Vector::Constant(kSize, q)}};
}

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

struct ProcessState {
  char state = '?';
  pid_t parent = 0;
};

inline ProcessState process_state(const std::filesystem::path& folder) {
  std::ifstream file(folder / "stat");
  std::string text;
  ProcessState result;
  if (std::getline(file, text)) std::istringstream(text.substr(text.rfind(')') + 1)) >> result.state >> result.parent;
  return result;
}

inline char state_of(pid_t process) { return process_state("/proc/" + std::to_string(process)).state; }

/// Processes whose parent is `parent`, zombies included.
inline std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> children;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    if (process_state(entry.path()).parent == parent) children.push_back(std::stoi(entry.path().filename()));
  }
  return children;
}

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
