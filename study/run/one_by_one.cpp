#include "study/run/one_by_one.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/same_bits.h"

namespace lcpbench {
namespace {

constexpr Index kLargeProblem = 100;  // order of M

constexpr std::array kTimes{&SolveTimes::setup_wall_s, &SolveTimes::setup_cpu_s, &SolveTimes::solve_wall_s,
                            &SolveTimes::solve_cpu_s, &SolveTimes::transport_s};

bool same_counters(const Counters& a, const Counters& b) {
  return a.iterations == b.iterations && a.pivots == b.pivots && a.factorizations == b.factorizations;
}

bool same_answer(const Answer& a, const Answer& b) {
  return a.claim == b.claim && same_counters(a.counters, b.counters) && same_bits(a.z, b.z) &&
         same_bits(a.velocity, b.velocity) && same_bits(a.farkas, b.farkas) && a.detail == b.detail;
}

class OneByOne final : public SweptSolver {
 public:
  OneByOne(std::vector<OpenCell> cells, bool keep) : open_(std::move(cells)), keep_(keep), solvers_(open_.size()) {}

  void run(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers) override {
    answers.clear();
    TimedRequest once = request;
    once.repeat_until_s = 0;
    for (std::size_t cell = 0; cell < open_.size(); ++cell) {
      if (solvers_[cell] == nullptr) solvers_[cell] = open_[cell]();
      TimedAnswer timed;
      solvers_[cell]->run(problem, once, timed);
      if (!keep_ || problem.size() > kLargeProblem) solvers_[cell].reset();
      add(static_cast<std::uint32_t>(cell), std::move(timed), answers);
    }
    for (SweptAnswer& answer : answers) {
      for (const auto time : kTimes) answer.timed.times.*time /= static_cast<double>(answer.cells.size());
    }
  }

 private:
  /// Times are summed here.
  static void add(std::uint32_t cell, TimedAnswer timed, std::vector<SweptAnswer>& answers) {
    const auto known = std::find_if(answers.begin(), answers.end(), [&](const SweptAnswer& answer) {
      return same_answer(answer.timed.answer, timed.answer);
    });
    if (known == answers.end()) {
      answers.push_back({{cell}, std::move(timed)});
      return;
    }
    known->cells.push_back(cell);
    for (const auto time : kTimes) known->timed.times.*time += timed.times.*time;
  }

  std::vector<OpenCell> open_;
  bool keep_;
  std::vector<std::unique_ptr<TimedSolver>> solvers_;
};

}  // namespace

std::unique_ptr<SweptSolver> one_by_one(std::vector<OpenCell> cells, bool keep) {
  return std::make_unique<OneByOne>(std::move(cells), keep);
}

}  // namespace lcpbench
