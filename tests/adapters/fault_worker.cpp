// A worker whose one solver does what the problem's name says: it answers right, lies, or misbehaves.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include "adapters/worker/asked_program.h"
#include "adapters/worker/worker_protocol.h"
#include "core/registry.h"

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{};

[[noreturn]] void sleep_for_ever() {
  for (;;) pause();
}

void say(const std::string& message) {
  if (write(worker::AskedProgram::kSocketFd, message.data(), message.size()) < 0) std::abort();
}

/// The head of a response, which tells of a payload that nothing has room for.
[[noreturn]] void say_huge_payload() {
  constexpr std::size_t kPayloadWord = 3;
  constexpr std::uint64_t kHuge = ~std::uint64_t{0};
  std::string message = worker::write_response({});
  std::memcpy(message.data() + kPayloadWord * sizeof kHuge, &kHuge, sizeof kHuge);
  say(message);
  sleep_for_ever();
}

[[noreturn]] void say_garbage() {
  say(std::string(4096, '\xa5'));
  sleep_for_ever();
}

[[noreturn]] void write_to_protected_memory() {
  signal(SIGSEGV, SIG_DFL);  // a sanitizer's handler would turn the signal into an exit code
  void* page = mmap(nullptr, 4096, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  *static_cast<volatile char*>(page) = 1;
  std::abort();
}

std::vector<char*>& kept_memory() {
  static std::vector<char*> kept;
  return kept;
}

void fill_memory() {
  for (;;) kept_memory().push_back(new char[std::size_t{1} << 20]);
}

void fill_memory_without_exceptions() noexcept { fill_memory(); }

void print_megabytes() {
  const std::string line(1000, 'x');
  for (int i = 0; i < 3000; ++i) {
    std::puts(line.c_str());
    std::fputs(line.c_str(), stderr);
  }
}

void fork_a_child_and_exit() {
  if (fork() == 0) sleep_for_ever();
  _exit(0);
}

bool can_make_a_file() {
  std::FILE* file = std::fopen("left_behind_by_a_worker", "w");
  if (file == nullptr) return false;
  std::fclose(file);
  return true;
}

double open_descriptors() {
  const std::filesystem::directory_iterator descriptors("/proc/self/fd");
  return static_cast<double>(std::distance(begin(descriptors), end(descriptors)));
}

struct NoSettings {
  void visit(auto&&) {}
};

class Fault final : public Solver {
 public:
  explicit Fault(const NoSettings&) {}
  const Capabilities& capabilities() const override { return kCapabilities; }

 protected:
  void on_load(const Problem&) override {}

  void on_solve(const SolveRequest&, Answer& answer) override {
    answer.claim = Claim::kSolved;
    answer.z = (-problem().lcp().q.array() / problem().lcp().M.diagonal().array()).max(0.0);
    const auto found = behaviours().find(problem().name());
    if (found == behaviours().end()) throw std::logic_error("no behaviour named " + problem().name());
    found->second(answer);
  }

 private:
  static const std::map<std::string, std::function<void(Answer&)>>& behaviours() {
    using A = Answer;
    static const std::map<std::string, std::function<void(A&)>> map{
        {"right", [](A&) {}},
        {"zeros", [](A& a) { a.z.setZero(); }},
        {"nan", [](A& a) { a.z.setConstant(std::numeric_limits<double>::quiet_NaN()); }},
        {"segfault", [](A&) { write_to_protected_memory(); }},
        {"abort",
         [](A&) {
           std::fputs("assertion 'x > 0'\n failed\n", stderr);
           std::abort();
         }},
        {"loop for ever",
         [](A&) {
           for (volatile bool on = true; on;) continue;
         }},
        {"sleep for ever", [](A&) { sleep_for_ever(); }},
        {"exit(0)", [](A&) { std::exit(0); }},
        {"fill memory", [](A&) { fill_memory(); }},
        {"fill memory noexcept", [](A&) { fill_memory_without_exceptions(); }},
        {"garbage", [](A&) { say_garbage(); }},
        {"huge payload", [](A&) { say_huge_payload(); }},
        {"close the socket",
         [](A&) {
           close(worker::AskedProgram::kSocketFd);
           sleep_for_ever();
         }},
        {"stop", [](A&) { raise(SIGSTOP); }},
        {"print", [](A&) { print_megabytes(); }},
        {"fork and exit", [](A&) { fork_a_child_and_exit(); }},
        {"throw", [](A&) { throw std::runtime_error("boom"); }},
        {"too many entries", [](A& a) { a.z = Vector::Zero(100000); }},
        {"pid", [](A& a) { a.z(0) = getpid(); }},
        {"make a file", [](A& a) { a.z(0) = can_make_a_file() ? 1 : 0; }},
        {"open descriptors", [](A& a) { a.z(0) = open_descriptors(); }},
        {"blas threads", [](A& a) { a.z(0) = std::atof(std::getenv("OPENBLAS_NUM_THREADS")); }},
    };
    return map;
  }
};

}  // namespace

const std::vector<RegisteredSolver>& registered_solvers() {
  static const std::vector<RegisteredSolver> solvers{
      {define_solver<Fault, NoSettings>({.name = "fault", .summary = "does what the problem's name says"}), "", "", "",
       ""}};
  return solvers;
}

}  // namespace lcpbench
