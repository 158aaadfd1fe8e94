#include "native/auto/race.h"

#include <algorithm>
#include <cmath>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of weighted work, about. It decides only that a load is not begun which would outlast the deadline.
constexpr double kSecondsPerWork = 1e-9;

}  // namespace

double Race::work() const {
  double sum = 0;
  for (const Run& run : runs_) sum += run.work;
  return sum;
}

/// The entrant's best iterate, if it is better than those of the others.
void Race::note_best(std::size_t entrant, Index size) {
  iterate_.resize(size);
  const double residual = runs_[entrant].solver->best(iterate_);
  if (!(residual < best_residual_)) return;
  best_residual_ = residual;
  best_.swap(iterate_);
  winner_ = entrant;
}

/// @returns whether the entrant claims an answer, or that there is none.
bool Race::turn(std::size_t entrant, Stable& stable, const Entrant& now, double budget, const Terms& terms,
                Answer& answer) {
  Run& run = runs_[entrant];
  if (run.solver == nullptr) {
    run.solver = &stable.loaded(entrant);
    const Vector* start = terms.start;
    if (start == nullptr && now.learns && best_residual_ < 1) {  // less than that of z = 0
      start_ = best_;
      start = &start_;
    }
    run.solver->begin(start, terms.error);
  }
  run.has_ended = run.solver->go_on((budget - run.work) / now.weight, terms.deadline_s, answer);
  run.work = now.load_cost + now.weight * run.solver->work();
  if (run.has_ended && (answer.claim == Claim::kSolved || answer.claim == Claim::kUnsolvable)) {
    winner_ = entrant;
    return true;
  }
  note_best(entrant, terms.size);
  return false;
}

Race::End Race::run(std::span<const Entrant> entrants, Stable& stable, const Terms& terms, Answer& answer) {
  std::array<std::size_t, kMostEntrants> order{};
  double least = kInfinity;
  for (std::size_t k = 0; k < entrants.size(); ++k) {
    runs_[k] = {.work = entrants[k].load_cost};
    least = std::min(least, entrants[k].cost);
    std::size_t place = k;
    for (; place > 0 && entrants[order[place - 1]].cost > entrants[k].cost; --place) order[place] = order[place - 1];
    order[place] = k;
  }
  best_residual_ = accepted_at_ = kInfinity;
  bool is_out_of_time = false;
  for (double share = kFirstShare;; share *= 2) {
    bool has_runner = false;
    for (std::size_t place = 0; place < entrants.size(); ++place) {
      const std::size_t k = order[place];
      if (runs_[k].has_ended) continue;
      has_runner = true;
      const double budget = std::max(share * std::min(entrants[k].cost, kLargestBudget * least), kLeastTurn);
      if (!(runs_[k].work < budget)) continue;
      const double left_s = terms.deadline_s == kInfinity ? kInfinity : terms.deadline_s - wall_clock_s();
      if (!(left_s > 0)) return End::kTimeLimit;
      if (runs_[k].solver == nullptr && kSecondsPerWork * entrants[k].load_cost > left_s) {
        is_out_of_time = runs_[k].has_ended = true;
        continue;
      }
      if (turn(k, stable, entrants[k], budget, terms, answer)) return End::kClaimed;
      if (!terms.ends_early || !(best_residual_ <= terms.accepted)) continue;
      const double done = work();
      accepted_at_ = std::min(accepted_at_, done);
      if (done > kPatience * accepted_at_) return End::kGoodEnough;
    }
    if (!has_runner) return is_out_of_time ? End::kTimeLimit : End::kAllGaveUp;
  }
}

}  // namespace lcpbench
