// What a study relies on: whatever a foreign library does, its run gets a row that says so, and the next run works.

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "adapters/worker/worker_client.h"
#include "adapters/worker/worker_protocol.h"
#include "core/error.h"
#include "tests/adapters/misbehaviour.h"

namespace lcpbench {

const std::vector<RegisteredSolver>& registered_solvers() {
  static const std::vector<RegisteredSolver> none;
  return none;
}

namespace {

using ::testing::internal::CaptureStderr;
using ::testing::internal::CaptureStdout;
using ::testing::internal::GetCapturedStderr;
using ::testing::internal::GetCapturedStdout;

constexpr TimedRequest kImpatient{.time_limit_s = 0.1};
constexpr const char* kNoAnswerWithin = "gave no answer within ";

std::unique_ptr<TimedSolver> client(WorkerLimits limits = {}) {
  limits.grace_s = 0.2;
  return worker_solver(FAULT_WORKER, Spec{"fault", {}}, limits);
}

TimedAnswer run(TimedSolver& solver, const std::string& behaviour, const TimedRequest& request = kPatient) {
  TimedAnswer answer;
  solver.run(named(behaviour), request, answer);
  return answer;
}

/// Every entry is `value`, and there are `size` of them: Eigen's == takes equal sizes for granted.
bool all_are(double value, const Vector& z, Index size = kSize) {
  return z.size() == size && (z.array() == value).all();
}

void expect_right(TimedSolver& solver) {
  const Answer answer = run(solver, "right").answer;
  EXPECT_STREQ(to_string(answer.claim), "solved") << answer.detail;
  EXPECT_TRUE(all_are(0.5, answer.z)) << answer.z.transpose();
}

/// First entry of the answer.
double ask(TimedSolver& solver, const std::string& question) {
  const Answer answer = run(solver, question).answer;
  return answer.z.size() > 0 ? answer.z(0) : std::numeric_limits<double>::quiet_NaN();
}

bool has_children() { return waitpid(-1, nullptr, WNOHANG) != -1 || errno != ECHILD; }

std::size_t open_descriptors() {
  const std::filesystem::directory_iterator descriptors("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(descriptors), end(descriptors)));
}

class WorkerFaultTest : public ::testing::TestWithParam<Fault> {};

TEST_P(WorkerFaultTest, IsReportedAndTheNextRunWorks) {
  const Fault& fault = GetParam();
  const auto solver = client();
  expect_right(*solver);
  for (int i = 0; i < 2; ++i) {
    const TimedAnswer answer = run(*solver, fault.behaviour, fault.request);
    EXPECT_STREQ(to_string(answer.answer.claim), to_string(fault.claim)) << answer.answer.detail;
    EXPECT_NE(answer.answer.detail.find(fault.detail), std::string::npos) << answer.answer.detail;
    EXPECT_EQ(answer.answer.z.size(), 0);
    EXPECT_GT(answer.times.solve_wall_s, 0) << "what it cost until it was given up";
    if (fault.claim == Claim::kTimeLimit) {
      const double waited_s = 1e-3 * std::stod(answer.answer.detail.substr(std::strlen(kNoAnswerWithin)));
      EXPECT_GE(answer.times.solve_wall_s, 0.3) << "the time limit and the grace";
      EXPECT_GT(waited_s, 0);
      EXPECT_LE(waited_s, answer.times.solve_wall_s + 1e-3) << "in whole milliseconds";
    }
    expect_right(*solver);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Faults, WorkerFaultTest,
    ::testing::Values(Fault{"segfault", Claim::kCrashed, "killed by signal 11 (SIGSEGV)"},
                      Fault{"abort", Claim::kCrashed,
                            "killed by signal 6 (SIGABRT) without an answer; stderr: assertion 'x > 0'  failed"},
                      Fault{"exit(0)", Claim::kCrashed, "exited with code 0 without an answer"},
                      Fault{"fork and exit", Claim::kCrashed, "exited with code 0 without an answer"},
                      Fault{"sleep for ever", Claim::kTimeLimit, kNoAnswerWithin, kImpatient},
                      Fault{"stop", Claim::kTimeLimit, kNoAnswerWithin, kImpatient},
                      Fault{"garbage", Claim::kCrashed, "sent what is no answer: no message"},
                      Fault{"huge payload", Claim::kCrashed, "gave an answer of more than"},
                      Fault{"close the socket", Claim::kCrashed, "closed its output without an answer"},
                      Fault{"throw", Claim::kNumericalFailure, "exception: boom"},
                      Fault{"too many entries", Claim::kCrashed, "z has 100000 entries, expected 5 or none"}),
    fault_name);

TEST(WorkerTest, MemoryIsLimited) {
  if (!worker::kMemoryIsLimited) GTEST_SKIP() << "AddressSanitizer excludes a limit on address space";
  const auto solver = client({.memory_bytes = std::uint64_t{512} << 20});
  const Answer thrown = run(*solver, "fill memory").answer;
  EXPECT_EQ(thrown.claim, Claim::kNumericalFailure);
  EXPECT_EQ(thrown.detail, "out of memory");
  expect_right(*solver);
  const Answer fatal = run(*solver, "fill memory noexcept").answer;
  EXPECT_EQ(fatal.claim, Claim::kCrashed);
  EXPECT_NE(fatal.detail.find("SIGABRT"), std::string::npos) << fatal.detail;
  expect_right(*solver);
}

TEST(WorkerTest, OutputOfAWorkerGoesNowhere) {
  CaptureStdout();
  CaptureStderr();
  const auto solver = client();
  const Answer answer = run(*solver, "print").answer;
  const std::string printed = GetCapturedStdout() + GetCapturedStderr();
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_EQ(printed, "");
}

TEST(WorkerTest, LeavesNoFilesBehind) {
  const auto solver = client();
  EXPECT_EQ(ask(*solver, "make a file"), 0.0);
}

TEST(WorkerTest, NumericalLibrariesAreHeldToOneThread) {
  const auto solver = client();
  EXPECT_EQ(ask(*solver, "blas threads"), 1.0);
}

TEST(WorkerTest, InheritsNoDescriptors) {
  const int passed_on = dup(STDIN_FILENO);  // not close-on-exec
  const auto first = client();
  const double alone = ask(*first, "open descriptors");
  const auto second = client();
  EXPECT_EQ(ask(*second, "open descriptors"), alone);
  EXPECT_EQ(alone, 5.0);  // standard three, the socket, and the folder being listed
  close(passed_on);
}

TEST(WorkerTest, ProcessServesManyRunsAndOutlivesTheThreadThatStartedIt) {
  const auto solver = client();
  double started = 0;
  std::thread([&] { started = ask(*solver, "pid"); }).join();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_GT(started, 0);
  EXPECT_EQ(ask(*solver, "pid"), started);
}

TEST(WorkerTest, WorkerThatDiedBetweenRunsIsReplaced) {
  const auto solver = client();
  const auto process = static_cast<pid_t>(ask(*solver, "pid"));
  ASSERT_GT(process, 0);
  ASSERT_EQ(kill(process, SIGKILL), 0);
  siginfo_t info{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(process), &info, WEXITED | WNOWAIT), 0);
  expect_right(*solver);
}

TEST(WorkerTest, ProblemsMayBeLargerThanTheSocketHolds) {
  const auto solver = client();
  for (const Index n : {Index{3}, Index{400}, Index{7}, Index{700}, Index{0}}) {
    const Problem big("right", Lcp{4.0 * Matrix::Identity(n, n), Vector::Constant(n, -1.0)});
    TimedAnswer answer;
    solver->run(big, kPatient, answer);
    EXPECT_EQ(answer.answer.claim, Claim::kSolved) << answer.answer.detail;
    EXPECT_TRUE(all_are(0.25, answer.answer.z, n));
  }
}

TEST(WorkerTest, TimesAreTakenApart) {
  const auto solver = client();
  const SolveTimes times = run(*solver, "right", {.repeat_until_s = 0.02}).times;
  EXPECT_GT(times.solve_wall_s, 0);
  EXPECT_GT(times.repeats, 1);
  EXPECT_GT(times.transport_s, 0);
  EXPECT_EQ(run(*solver, "right").times.repeats, 1);
}

/// Why there is no worker to ask; "" when there is one.
std::string worker_error(TimedSolver& solver) {
  try {
    run(solver, "right");
  } catch (const WorkerError& error) {
    return error.what();
  }
  return "";
}

TEST(WorkerTest, FailureToStartIsReported) {
  const auto detail = [](const char* executable, const char* solver = "fault", const WorkerLimits& limits = {}) {
    return worker_error(*worker_solver(executable, Spec{solver, {}}, limits));
  };
  EXPECT_NE(detail("/nonexistent/worker").find("No such file"), std::string::npos);
  EXPECT_NE(detail("/bin/true").find("its worker program exited with code 0 without an answer"), std::string::npos);
  EXPECT_NE(detail("/bin/ls").find("stderr: "), std::string::npos);
  EXPECT_NE(detail("/bin/sleep", "1000", {.start_timeout_s = 0.3}).find("was not ready in time"), std::string::npos);
  EXPECT_NE(worker_error(*worker_solver(FAULT_WORKER, Spec{"other", {}})).find("unknown solver 'other'"),
            std::string::npos);
  const auto misspelt = worker_solver(FAULT_WORKER, Spec{"fault", {{"tolerence", "1"}}});
  EXPECT_NE(worker_error(*misspelt).find("tolerence"), std::string::npos);
  EXPECT_FALSE(has_children());
}

/// A machine without free descriptors is no crash of a solver, and its solvers work again once there are some.
TEST(WorkerTest, LackOfDescriptorsIsNoAnswer) {
  if (!worker::kMemoryIsLimited) GTEST_SKIP() << "the sanitizers need free descriptors for checks of their own";
  const auto solver = client();
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  rlimit none = before;
  none.rlim_cur = 3;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  const std::string error = worker_error(*solver);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_NE(error.find("Too many open files"), std::string::npos) << error;
  expect_right(*solver);
}

TEST(WorkerTest, NeitherZombiesNorDescriptorsAreLeft) {
  expect_right(*client());
  const std::size_t before = open_descriptors();
  {
    const auto solver = client();
    const auto idle = client();
    expect_right(*idle);
    for (int i = 0; i < 10; ++i) {
      run(*solver, i % 2 == 0 ? "segfault" : "garbage");
      expect_right(*solver);
    }
  }
  EXPECT_EQ(open_descriptors(), before);
  EXPECT_FALSE(has_children());
}

TEST(WorkerTest, ManyClientsInTwoThreads) {
  const auto work = [] {
    std::vector<std::unique_ptr<TimedSolver>> solvers;
    for (int i = 0; i < 4; ++i) solvers.push_back(client());
    for (int round = 0; round < 10; ++round) {
      for (const auto& solver : solvers) {
        expect_right(*solver);
        if (round % 3 != 0) continue;
        EXPECT_EQ(run(*solver, "segfault").answer.claim, Claim::kCrashed);
      }
    }
  };
  std::thread one(work);
  std::thread two(work);
  one.join();
  two.join();
  EXPECT_FALSE(has_children());
}

RegisteredSolver registered(const char* worker, const char* unavailable) {
  RegisteredSolver solver;
  solver.definition.name = "some";
  solver.worker = worker;
  solver.unavailable = unavailable;
  return solver;
}

std::string executable_error(const RegisteredSolver& solver) {
  try {
    return "found " + worker_executable(solver).string();
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(WorkerExecutableTest, IsLookedForBesideTheProgram) {
  const std::filesystem::path fault_worker = std::filesystem::canonical(FAULT_WORKER);
  const std::string name = fault_worker.filename().string();
  EXPECT_EQ(worker_executable(registered(name.c_str(), "")), fault_worker);
  EXPECT_NE(executable_error(registered("no-such-worker", "")).find("missing"), std::string::npos);
  EXPECT_NE(executable_error(registered(name.c_str(), "not installed")).find("not installed"), std::string::npos);
  EXPECT_NE(executable_error(registered("", "")).find("has no worker"), std::string::npos);
  setenv("LCPBENCH_WORKER_DIR", "/nonexistent", 1);
  EXPECT_NE(executable_error(registered(name.c_str(), "")).find("/nonexistent/"), std::string::npos);
  unsetenv("LCPBENCH_WORKER_DIR");
}

}  // namespace
}  // namespace lcpbench
