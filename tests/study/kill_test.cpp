// What a user relies on: a study that is killed at any moment, again and again, loses nothing that was done and ends
// with the rows of an unbroken run; Ctrl-C ends it in good order.

#include <chrono>
#include <csignal>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "study/store/store.h"
#include "tests/support/study_support.h"

namespace lcpbench::kill_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

class Process {
 public:
  Process(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), LCPBENCH_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // it ends with this test, however that ends
    const int nowhere = open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) dup2(nowhere, stream);
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~Process() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const { kill(pid_, signal); }
  bool runs() const {
    siginfo_t ended{};
    return waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == 0;
  }
  /// Processor time so far.
  double cpu_s() const {
    clockid_t clock = 0;
    timespec worked{};
    if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &worked) != 0) return 0;
    return static_cast<double>(worked.tv_sec) + 1e-9 * static_cast<double>(worked.tv_nsec);
  }
  /// Exit code; -1 when a signal ended it.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::vector<pid_t> children() const {
    std::vector<pid_t> found;
    for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(pid_) + "/task")) {
      std::ifstream file(thread.path() / "children");
      for (pid_t child = 0; file >> child;) found.push_back(child);
    }
    return found;
  }

 private:
  pid_t pid_ = -1;
};

/// Returns as soon as the store holds the first answer; false when there is none after ten minutes.
bool gets_answers(const fs::path& store) {
  for (int i = 0; i < 6000; ++i) {
    try {
      if (Store::open_for_reading(store).cell_count() > 0) return true;
    } catch (const std::exception&) {  // the store is still being made
    }
    std::this_thread::sleep_for(milliseconds(100));
  }
  return false;
}

class KillTest : public ::testing::Test {
 protected:
  /// Runs a plan of these members.
  std::vector<std::string> command(const std::string& store, const std::string& members) const {
    const fs::path plan = folder_ / "plan.json";
    std::ofstream(plan) << R"({"format": "lcpbench-plan", "version": 1, "name": "killed", )" << members << "}";
    return {"run", plan.string(), "--jobs", "2", "--store", (folder_ / store).string()};
  }
  ScratchFolder folder_;
};

/// Deterministic solvers far from the time limit, native and (where they are) foreign.
constexpr const char* kStudy = R"("trials": 400, "time_limit_s": 60, "repeat_until_s": 0.0002,
    "sets": ["paper/monotone/exp1", "paper/monotone/exp2", {"set": "paper/copositive/exp1{nc_max=6}", "trials": 100}],
    "solvers": ["lemke", "lemke{engine=dense}", "regularized", {"solver": "lemke{cap=3n}", "sweep": "paper"},
                {"solver": "primal_dual", "sweep": "paper", "sets": ["paper/monotone/*"], "every": 3},
                {"solver": "bullet_dantzig", "optional": true}, {"solver": "bullet_lemke", "optional": true, "every": 4}])";

TEST_F(KillTest, KillsLoseNothing) {
  ASSERT_EQ(Process(command("whole.db", kStudy)).wait(), 0);
  const std::string whole = dump(folder_ / "whole.db");
  constexpr int kKills = 12;
  std::minstd_rand random(20121007);
  std::int64_t cells = 0;
  for (int killed = 0; killed < kKills;) {
    Process process(command("killed.db", kStudy));
    std::this_thread::sleep_for(milliseconds(20 + random() % 300));
    process.send(SIGKILL);
    if (process.wait() == 0) {
      // Done before the kill: begin a new one, the kills must hit a running study.
      EXPECT_EQ(dump(folder_ / "killed.db"), whole);
      Store::remove(folder_ / "killed.db");
      cells = 0;
      continue;
    }
    ++killed;
    if (!fs::exists(folder_ / "killed.db")) continue;
    const std::int64_t now = Store::open_for_writing(folder_ / "killed.db").cell_count();
    EXPECT_GE(now, cells) << "kill " << killed;
    cells = now;
  }
  ASSERT_EQ(Process(command("killed.db", kStudy)).wait(), 0);
  EXPECT_EQ(dump(folder_ / "killed.db"), whole);
}

/// As Slurm's scancel: a signal to each process of a job, here to the workers first.
TEST_F(KillTest, InterruptEndsInGoodOrderAndNoWorkerCrashedWithIt) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Store::remove(folder_ / "s.db");
    Process process(command("s.db", R"("trials": 100000, "time_limit_s": 60, "repeat_until_s": 0,
        "sets": ["paper/monotone/exp2"], "solvers": [{"solver": "bullet_dantzig", "optional": true}, "lemke"])"));
    ASSERT_TRUE(gets_answers(folder_ / "s.db"));
    for (const pid_t worker : process.children()) kill(worker, signal);
    std::this_thread::sleep_for(milliseconds(20));
    process.send(signal);
    EXPECT_EQ(process.wait(), 3);
    Store store = Store::open_for_reading(folder_ / "s.db");
    EXPECT_GT(store.cell_count(), 0);
    EXPECT_EQ(store.database().integer("SELECT COUNT(*) FROM answers WHERE claim = 'crashed'"), 0);
  }
}

/// The solve ends at a time limit that is long after this test.
TEST_F(KillTest, SecondInterruptEndsAtOnceAndSecondProgramIsRefused) {
  const auto endless = command("s.db", R"("trials": 1, "time_limit_s": 100000, "repeat_until_s": 0,
      "sets": ["paper/copositive/exp1"], "solvers": ["psor{max_iterations=1000000000000,tolerance=0}"])");
  Process process(endless);
  while (!fs::exists(folder_ / "s.db-wal")) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_EQ(Process(endless).wait(), 2);
  const auto works_on = [&] {
    for (const double until_s = process.cpu_s() + 0.5; process.runs() && process.cpu_s() < until_s;) {
      std::this_thread::sleep_for(milliseconds(10));
    }
    return process.runs();
  };
  ASSERT_TRUE(works_on());
  process.send(SIGINT);
  EXPECT_TRUE(works_on()) << "the first one lets the solve in flight end";
  process.send(SIGINT);
  EXPECT_EQ(process.wait(), 3);
}

}  // namespace
}  // namespace lcpbench::kill_test
