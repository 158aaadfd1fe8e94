// A program with two workers, for tests that kill it: one idle, one in an endless loop. `worker_parent WORKER`; prints
// "ready" when the idle one has answered, then waits for the other for ever.

#include <cstdio>
#include <thread>

#include "adapters/worker/worker_client.h"

namespace lcpbench {
namespace {

Problem problem(const char* name) { return {name, Lcp{Matrix::Identity(2, 2), Vector::Constant(2, -1.0)}}; }

int run(const char* worker) {
  const auto idle = worker_solver(worker, Spec{"fault", {}});
  TimedAnswer answer;
  std::thread([&] { idle->run(problem("right"), {}, answer); }).join();
  if (answer.answer.claim != Claim::kSolved) return 1;
  std::puts("ready");
  std::fflush(stdout);
  worker_solver(worker, Spec{"fault", {}})->run(problem("loop for ever"), {.time_limit_s = 1e6}, answer);
  return 1;
}

}  // namespace
}  // namespace lcpbench

const std::vector<lcpbench::RegisteredSolver>& lcpbench::registered_solvers() {
  static const std::vector<RegisteredSolver> none;
  return none;
}

int main(int, char** argv) { return lcpbench::run(argv[1]); }
