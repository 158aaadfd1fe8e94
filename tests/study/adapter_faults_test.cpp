// What a user of a long study relies on: whatever one worker does, every row of every other solver is the row that it
// would have been.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "adapters/worker/worker_client.h"
#include "adapters/worker/worker_protocol.h"
#include "core/registry.h"
#include "core/same_bits.h"
#include "study/run/open_solver.h"
#include "study/run/runner.h"
#include "tests/support/study_support.h"

namespace lcpbench::adapter_faults_test {
namespace {

struct Fault {
  std::string behaviour;  ///< of tests/adapters/fault_worker.cpp
  Claim claim;            ///< how the study reports it
};

std::vector<Fault> faults() {
  std::vector<Fault> all{{"segfault", Claim::kCrashed},
                         {"abort", Claim::kCrashed},
                         {"loop for ever", Claim::kTimeLimit},
                         {"stop", Claim::kTimeLimit},
                         {"exit(0)", Claim::kCrashed},
                         {"_exit(0)", Claim::kCrashed},
                         {"nan", Claim::kSolved},
                         {"print", Claim::kSolved},
                         {"huge z", Claim::kCrashed},
                         {"too many entries", Claim::kCrashed},
                         {"garbage", Claim::kCrashed},
                         {"fork and exit", Claim::kCrashed},
                         {"close the socket", Claim::kCrashed}};
  if (worker::kMemoryIsLimited) {
    all.push_back({"fill memory", Claim::kNumericalFailure});
    all.push_back({"fill memory noexcept", Claim::kCrashed});
  }
  return all;
}

/// Rigid scenes, which every adapter takes; the faulty worker does what their names say.
StudySet scenes() {
  const std::unique_ptr<ProblemSet> set = open_set("rigid/exp1{nc_max=6}");
  std::vector<Problem> problems;
  for (const Fault& fault : faults()) {
    const auto trial = static_cast<std::int64_t>(problems.size());
    problems.emplace_back(fault.behaviour, *set->generate(11, trial).scene());
  }
  const auto count = static_cast<std::int64_t>(problems.size());
  return {std::make_shared<GivenProblems>("scenes", std::move(problems)), count};
}

/// Every adapter that runs here, and one native solver beside them.
Study undisturbed_study() {
  Plan plan;
  plan.name = "faults";
  plan.repeat_until_s = 0;
  plan.sets = {{.pattern = "rigid/exp1"}};
  for (const RegisteredSolver& solver : registered_solvers()) {
    const bool wanted = !solver.native() || solver.definition.name == "lemke";
    if (wanted && runs_unasked(solver)) plan.solvers.push_back({.spec = Spec{solver.definition.name, {}}});
  }
  Study study = resolve(plan);
  study.time_limit_s = 60;  // no adapter comes near it: a busy machine must not change a row
  study.sets = {scenes()};
  return study;
}

/// The faulty worker. Only its hangs have a short time limit, so that they end soon.
class FaultySolver final : public TimedSolver {
 public:
  FaultySolver() : worker_(worker_solver(FAULT_WORKER, Spec{"fault", {}}, limits())) {}

  void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
    TimedRequest impatient = request;
    if (problem.name() == "loop for ever" || problem.name() == "stop") impatient.time_limit_s = 2;
    worker_->run(problem, impatient, result);
  }

 private:
  static WorkerLimits limits() {
    WorkerLimits limits;
    limits.memory_bytes = std::uint64_t{512} << 20;
    limits.grace_s = 0.3;
    return limits;
  }

  std::unique_ptr<TimedSolver> worker_;
};

/// With the faulty worker twice, so that faults also meet each other.
Study disturbed_study() {
  Study study = undisturbed_study();
  for (const char* name : {"fault a", "fault b"}) {
    study.solvers.push_back(given_solver(name, [] { return std::make_unique<FaultySolver>(); }));
  }
  return study;
}

using Rows = std::map<std::pair<std::string, std::int64_t>, Answer>;

Rows run(const Study& study, int jobs) {
  const ScratchFolder folder;
  Store store = Store::open_for_writing(folder / "s.db");
  EXPECT_EQ(run_study(study, store, {.jobs = jobs}).end, RunEnd::kComplete);
  Rows rows;
  for (const StudySolver& solver : study.solvers) {
    for (std::int64_t trial = 0; trial < study.sets[0].trials; ++trial) {
      const auto answer = store.answer(problem_id("scenes", study.seed, trial), solver.row.id());
      EXPECT_TRUE(answer.has_value()) << solver.row.text() << ", " << trial;
      if (answer) rows[{solver.row.name, trial}] = *answer;
    }
  }
  return rows;
}

TEST(AdapterFaultsTest, EveryOtherRowIsUntouched) {
  const Study calm = undisturbed_study();
  ASSERT_GE(calm.solvers.size(), 2U) << "no adapter is available here";
  const Rows expected = run(calm, 1);
  const Rows found = run(disturbed_study(), 2);
  for (const auto& [key, answer] : expected) {
    const Answer& other = found.at(key);
    const std::string where = key.first + " on " + std::to_string(key.second);
    EXPECT_STREQ(to_string(other.claim), to_string(answer.claim)) << where << ": " << other.detail;
    EXPECT_TRUE(same_bits(other.z, answer.z)) << where;
    EXPECT_TRUE(same_bits(other.velocity, answer.velocity)) << where;
    EXPECT_EQ(other.counters.iterations, answer.counters.iterations) << where;
    EXPECT_EQ(other.detail, answer.detail) << where;
  }
  for (const char* name : {"fault a", "fault b"}) {
    for (std::size_t i = 0; i < faults().size(); ++i) {
      const Answer& answer = found.at({name, static_cast<std::int64_t>(i)});
      EXPECT_STREQ(to_string(answer.claim), to_string(faults()[i].claim))
          << name << ", " << faults()[i].behaviour << ": " << answer.detail;
    }
  }
}

}  // namespace
}  // namespace lcpbench::adapter_faults_test
