// What a user relies on: a study that is killed at any moment, again and again, loses nothing that was done and ends
// with the rows of an unbroken run; no worker process outlives it; Ctrl-C ends it in good order.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <exception>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "study/store/store.h"
#include "tests/support/study_support.h"

namespace lcpbench::kill_test {
namespace {

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
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      wait();
    }
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  void send(int signal) const { kill(pid_, signal); }
  /// Exit code; -1 when a signal ended it.
  int wait() {
    int status = 0;
    wait4(pid_, &status, 0, &usage_);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  /// Largest resident memory in MB. @pre wait() has returned
  long peak_mb() const { return usage_.ru_maxrss / 1024; }
  /// Processor time. @pre wait() has returned
  double cpu_s() const {
    const timeval &user = usage_.ru_utime, &system = usage_.ru_stime;
    return static_cast<double>(user.tv_sec + system.tv_sec) + 1e-6 * static_cast<double>(user.tv_usec + system.tv_usec);
  }

 private:
  pid_t pid_ = -1;
  struct rusage usage_ {};
};

/// A process is its number and its start time: numbers come again.
struct Identity {
  pid_t pid = 0;
  std::string start;
};

std::vector<std::string> stat_fields(const std::filesystem::path& process) {
  std::ifstream file(process / "stat");
  std::string text;
  std::getline(file, text);
  const auto name_end = text.rfind(')');
  std::istringstream rest(name_end == std::string::npos ? "" : text.substr(name_end + 1));
  std::vector<std::string> fields;
  for (std::string field; rest >> field;) fields.push_back(field);
  return fields;
}

constexpr std::size_t kParentField = 1;
constexpr std::size_t kUserField = 11;
constexpr std::size_t kSystemField = 12;
constexpr std::size_t kStartField = 19;

std::vector<Identity> children_of(pid_t parent) {
  std::vector<Identity> children;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::vector<std::string> fields = stat_fields(entry.path());
    if (fields.size() > kStartField && fields[kParentField] == std::to_string(parent)) {
      children.push_back({std::stoi(name), fields[kStartField]});
    }
  }
  return children;
}

bool is_running(const Identity& process) {
  const std::vector<std::string> fields = stat_fields("/proc/" + std::to_string(process.pid));
  return fields.size() > kStartField && fields[kStartField] == process.start && fields[0] != "Z";
}

/// Processor time so far.
double cpu_s(pid_t process) {
  const std::vector<std::string> fields = stat_fields("/proc/" + std::to_string(process));
  const double ticks = std::stod(fields.at(kUserField)) + std::stod(fields.at(kSystemField));
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

bool ends_soon(const Identity& process) {
  for (int i = 0; i < 6000; ++i) {
    if (!is_running(process)) return true;
    std::this_thread::sleep_for(milliseconds(10));
  }
  return false;
}

/// Returns as soon as the process has used so much more processor time; false when it has not after ten minutes.
bool works_for(double seconds, pid_t process) {
  const double until_s = cpu_s(process) + seconds;
  for (int i = 0; i < 60000; ++i) {
    if (cpu_s(process) >= until_s) return true;
    std::this_thread::sleep_for(milliseconds(10));
  }
  return false;
}

/// Returns as soon as the store holds the first answer; false when there is none after ten minutes.
bool gets_answers(const std::filesystem::path& store) {
  for (int i = 0; i < 6000; ++i) {
    try {
      if (Store::open_for_reading(store).cell_count() > 0) return true;
    } catch (const std::exception&) {  // the store is still being made
    }
    std::this_thread::sleep_for(milliseconds(100));
  }
  return false;
}

/// Children of the process, as soon as it has some, or none after a minute.
std::vector<Identity> await_children_of(pid_t parent) {
  for (int i = 0; i < 6000; ++i) {
    if (std::vector<Identity> children = children_of(parent); !children.empty()) return children;
    std::this_thread::sleep_for(milliseconds(10));
  }
  return {};
}

/// Deterministic solvers far from the time limit, native and (where they are) foreign.
std::filesystem::path write_plan(const std::filesystem::path& file) {
  std::ofstream(file) << R"({
    "format": "lcpbench-plan", "version": 1, "name": "killed", "trials": 400, "time_limit_s": 60, "repeat_until_s": 0.0002,
    "sets": ["paper/monotone/exp1", "paper/monotone/exp2", {"set": "paper/copositive/exp1{nc_max=6}", "trials": 100}],
    "solvers": ["lemke", "lemke{engine=dense}", "regularized", {"solver": "lemke{cap=3n}", "sweep": "paper"},
                {"solver": "primal_dual", "sweep": "paper", "sets": ["paper/monotone/*"], "every": 3},
                {"solver": "bullet_dantzig", "optional": true}, {"solver": "bullet_lemke", "optional": true, "every": 4}]})";
  return file;
}

class KillTest : public ::testing::Test {
 protected:
  std::vector<std::string> command(const std::string& store) const {
    return {"run", plan_.string(), "--jobs", "2", "--store", (folder_ / store).string()};
  }
  ScratchFolder folder_;
  std::filesystem::path plan_ = write_plan(folder_ / "plan.json");
};

TEST_F(KillTest, KillsLoseNothing) {
  ASSERT_EQ(Process(command("whole.db")).wait(), 0);
  const std::string whole = dump(folder_ / "whole.db");
  const bool has_workers = whole.find("Bullet") != std::string::npos;

  constexpr int kKills = 12;
  std::minstd_rand random(20121007);
  std::int64_t cells = 0;
  int killed = 0;
  int with_workers = 0;
  while (killed < kKills) {
    Process process(command("killed.db"));
    std::this_thread::sleep_for(milliseconds(20 + random() % 300));
    // A busy machine may take longer to start the workers: the first kills wait for them.
    const bool awaits = has_workers && killed < 3;
    const std::vector<Identity> workers = awaits ? await_children_of(process.pid()) : children_of(process.pid());
    with_workers += workers.empty() ? 0 : 1;
    process.send(SIGKILL);
    const int code = process.wait();
    if (code == 0) {
      // Done before the kill: begin a new one, the kills must hit a running study.
      EXPECT_EQ(dump(folder_ / "killed.db"), whole);
      Store::remove(folder_ / "killed.db");
      cells = 0;
      continue;
    }
    ASSERT_EQ(code, -1) << "not killed, but ended by itself";
    ++killed;
    for (const Identity& worker : workers) EXPECT_TRUE(ends_soon(worker)) << "worker " << worker.pid << " lives on";
    if (!std::filesystem::exists(folder_ / "killed.db")) continue;
    const std::int64_t now = Store::open_for_writing(folder_ / "killed.db").cell_count();
    EXPECT_GE(now, cells) << "kill " << killed;
    cells = now;
  }
  ASSERT_EQ(Process(command("killed.db")).wait(), 0);
  EXPECT_EQ(dump(folder_ / "killed.db"), whole);
  EXPECT_TRUE(!has_workers || with_workers > 0);
}

TEST_F(KillTest, InterruptEndsInGoodOrderAndResumes) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Store::remove(folder_ / "s.db");
    Process process(command("s.db"));
    ASSERT_TRUE(gets_answers(folder_ / "s.db"));
    const std::vector<Identity> workers = children_of(process.pid());
    process.send(signal);
    EXPECT_EQ(process.wait(), 3);
    for (const Identity& worker : workers) EXPECT_TRUE(ends_soon(worker));
    EXPECT_GT(Store::open_for_reading(folder_ / "s.db").cell_count(), 0);
  }
}

/// As Slurm's scancel: a signal to each process of a job, here to the workers first.
TEST_F(KillTest, WorkersThatAreEndedWithTheRunDidNotCrash) {
  const std::filesystem::path plan = folder_ / "workers.json";
  std::ofstream(plan) << R"({
    "format": "lcpbench-plan", "version": 1, "name": "ended", "trials": 100000, "time_limit_s": 60, "repeat_until_s": 0,
    "sets": ["paper/monotone/exp2"], "solvers": [{"solver": "bullet_dantzig", "optional": true}, {"solver": "lemke", "every": 100}]})";
  Process process({"run", plan.string(), "--jobs", "1", "--store", (folder_ / "s.db").string()});
  ASSERT_TRUE(gets_answers(folder_ / "s.db"));
  const std::vector<Identity> workers = children_of(process.pid());
  if (workers.empty()) GTEST_SKIP() << "Bullet's worker is not built";
  for (const Identity& worker : workers) kill(worker.pid, SIGTERM);
  std::this_thread::sleep_for(milliseconds(20));
  process.send(SIGTERM);
  EXPECT_EQ(process.wait(), 3);
  Store store = Store::open_for_reading(folder_ / "s.db");
  EXPECT_EQ(store.database().integer("SELECT COUNT(*) FROM answers WHERE claim = 'crashed'"), 0);
}

/// What listing the work before the first cell would cost: 4 GB and half a minute, deaf to signals.
TEST_F(KillTest, TenToTheEightTrialsBeginAtOnceAndEndInGoodOrder) {
  const std::string store = (folder_ / "s.db").string();
  Process process({"run", "--set", "paper/monotone/exp1", "--trials", "100000000", "--solver", "lemke", "--jobs", "1",
                   "--store", store});
  EXPECT_TRUE(gets_answers(store));
  const double sent_s = cpu_s(process.pid());
  EXPECT_LT(sent_s, 10);
  process.send(SIGTERM);
  EXPECT_EQ(process.wait(), 3);
  EXPECT_LT(process.cpu_s() - sent_s, 10);
  EXPECT_LT(process.peak_mb(), 1000) << "sanitizers take some hundreds";
}

TEST_F(KillTest, SecondInterruptEndsAtOnce) {
  // A solve that ends at the time limit only, long after this test.
  const std::filesystem::path plan = folder_ / "long.json";
  std::ofstream(plan) << R"({
    "format": "lcpbench-plan", "version": 1, "name": "long", "trials": 1, "time_limit_s": 100000, "repeat_until_s": 0,
    "sets": ["paper/copositive/exp1"], "solvers": ["psor{max_iterations=1000000000000,tolerance=0}"]})";
  Process process({"run", plan.string(), "--store", (folder_ / "s.db").string()});
  while (!std::filesystem::exists(folder_ / "s.db-wal")) std::this_thread::sleep_for(milliseconds(10));
  ASSERT_TRUE(works_for(0.5, process.pid()));
  const Identity program{process.pid(), stat_fields("/proc/" + std::to_string(process.pid())).at(kStartField)};
  process.send(SIGINT);
  ASSERT_TRUE(works_for(0.5, process.pid())) << "the first one lets the solve in flight end";
  process.send(SIGINT);
  ASSERT_TRUE(ends_soon(program));
  EXPECT_EQ(process.wait(), 3);
}

TEST_F(KillTest, SecondProgramIsRefusedWhileTheFirstRuns) {
  const std::vector<std::string> endless{"run", "--set", "paper/monotone/exp1", "--trials", "100000000", "--solver",
                                         "lemke", "--jobs", "1", "--store", (folder_ / "s.db").string()};
  Process first(endless);
  while (!std::filesystem::exists(folder_ / "s.db-wal")) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_EQ(Process(endless).wait(), 2);
}

}  // namespace
}  // namespace lcpbench::kill_test
