#include "core/swept_answers.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/same_bits.h"

namespace lcpbench {
namespace {

/// The mean of two means, of `kept` and of `added` cells.
void blend(double& mean, std::size_t kept, double other, std::size_t added) {
  mean += (other - mean) * static_cast<double>(added) / static_cast<double>(kept + added);
}

}  // namespace

bool same_answer(const Answer& a, const Answer& b) {
  return a.claim == b.claim && a.counters == b.counters && a.detail == b.detail && same_bits(a.z, b.z) &&
         same_bits(a.velocity, b.velocity) && same_bits(a.farkas, b.farkas);
}

void SweptAnswers::add(const std::vector<std::uint32_t>& cells, TimedAnswer timed) {
  const auto known = std::find_if(answers_.begin(), answers_.end(), [&](const SweptAnswer& other) {
    return same_answer(other.timed.answer, timed.answer);
  });
  if (known == answers_.end()) {
    answers_.push_back({cells, std::move(timed)});
    return;
  }
  SolveTimes& mean = known->timed.times;
  for (double SolveTimes::*time : {&SolveTimes::setup_wall_s, &SolveTimes::setup_cpu_s, &SolveTimes::solve_wall_s,
                                   &SolveTimes::solve_cpu_s, &SolveTimes::transport_s}) {
    blend(mean.*time, known->cells.size(), timed.times.*time, cells.size());
  }
  known->cells.insert(known->cells.end(), cells.begin(), cells.end());
}

void SweptAnswers::finish() {
  for (SweptAnswer& answer : answers_) std::sort(answer.cells.begin(), answer.cells.end());
  std::sort(answers_.begin(), answers_.end(),
            [](const SweptAnswer& a, const SweptAnswer& b) { return a.cells.front() < b.cells.front(); });
}

void answer_all_with_failure(std::size_t cells, const char* what, std::vector<SweptAnswer>& answers) {
  SweptAnswer failure;
  failure.cells.resize(cells);
  std::iota(failure.cells.begin(), failure.cells.end(), 0U);
  failure.timed.answer.detail = what;
  answers.assign(1, failure);
}

}  // namespace lcpbench
