#include "native/auto/race.h"

#include <algorithm>
#include <cmath>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of weighted work, about. It decides only that a load is not begun which would outlast the deadline.
constexpr double kSecondsPerWork = 1e-9;

/// A turn lowers the residual if it takes that part off.
constexpr double kLeastGain = 1e-3;

}  // namespace

double Race::work() const {
  double sum = 0;
  for (const Run& run : runs_) sum += run.solver != nullptr ? run.work : 0;
  return sum;
}

/// Keeps the entrant's best iterate, if it is better than those of the others. @returns its residual
double Race::note(std::size_t entrant) {
  iterate_.resize(terms_.size);
  const double residual = runs_[entrant].solver->best(iterate_);
  if (residual < best_residual_) {
    best_residual_ = residual;
    best_.swap(iterate_);
    winner_ = entrant;
  }
  return residual;
}

/// What the entrant will take in all, by what it has done.
void Race::expect(std::size_t entrant, double residual) {
  Run& run = runs_[entrant];
  const bool is_there = run.residual <= terms_.aim;  // and does not claim it: more of the same leads nowhere
  if (!is_there && residual < (1 - kLeastGain) * run.residual && run.work > run.noted_at) {
    const double left = std::log(std::max(residual / terms_.aim, 1.0));
    const double at_this_rate = kCaution * left / std::log(run.residual / residual) * (run.work - run.noted_at);
    run.expected = std::min(run.work + at_this_rate, kStalled * run.work);
    run.residual = residual;
    run.noted_at = run.work;
  } else {
    run.expected = std::max(run.expected, (entrants_[entrant].converges ? kStalled : kOvertime) * run.work);
    if (!run.has_learned || run.has_ended || run.work < kStalled * run.noted_at) return;
    run.solver->begin(nullptr, terms_.error);  // what it learned misled it
    run.has_learned = false;
    run.begun_at = run.noted_at = run.work;
    run.residual = 1;
  }
}

/// The entrant goes on until it has done so much in all.
Race::Turn Race::turn(std::size_t entrant, double work) {
  const Entrant& now = entrants_[entrant];
  Run& run = runs_[entrant];
  const double left_s = terms_.deadline_s == kInfinity ? kInfinity : terms_.deadline_s - wall_clock_s();
  if (!(left_s > 0)) return Turn::kTooLate;
  if (run.solver == nullptr) {
    if (kSecondsPerWork * now.load_cost > left_s) {
      run.has_ended = is_out_of_time_ = true;
      return Turn::kOver;
    }
    run.solver = &stable_->loaded(entrant);
    const Vector* start = terms_.start;
    if (start == nullptr && now.learns && best_residual_ < 1) {  // less than that of z = 0
      start_ = best_;
      start = &start_;
      run.has_learned = true;
    }
    run.solver->begin(start, terms_.error);
  }
  run.has_ended = run.solver->go_on((std::max(work, kLeastTurn) - run.work) / now.weight, terms_.deadline_s, *answer_);
  run.work = run.begun_at + now.weight * run.solver->work();
  if (run.has_ended && (answer_->claim == Claim::kSolved || answer_->claim == Claim::kUnsolvable)) {
    winner_ = entrant;
    return Turn::kClaimed;
  }
  expect(entrant, note(entrant));
  if (!terms_.ends_early || !(best_residual_ <= terms_.accepted)) return Turn::kOver;
  const double done = this->work();
  accepted_at_ = std::min(accepted_at_, done);
  return done > kPatience * accepted_at_ ? Turn::kGoodEnough : Turn::kOver;
}

/// An entrant that is to sprint now; kMostEntrants: none.
std::size_t Race::sprinter() const {
  double least = kInfinity;
  for (std::size_t k = 0; k < count_; ++k) {
    const Run& run = runs_[k];
    if (run.has_ended) continue;
    least = std::min(least, std::max(entrants_[k].cost, std::min(run.expected, kStalled * run.work)));
  }
  std::size_t cheapest = kMostEntrants;
  for (std::size_t k = 0; k < count_; ++k) {
    const Entrant& now = entrants_[k];
    if (!now.converges || runs_[k].solver != nullptr || runs_[k].has_ended) continue;
    const double sprint = kSprint * now.load_cost;
    if (!(sprint <= kShareOfSprint * least || (now.cost == least && now.cost <= sprint))) continue;
    if (cheapest == kMostEntrants || now.load_cost < entrants_[cheapest].load_cost) cheapest = k;
  }
  return cheapest;
}

/// Who has the least to do, or lags behind that one; kMostEntrants: all have ended.
std::size_t Race::next() const {
  std::size_t first = kMostEntrants, last = kMostEntrants;
  double least_left = kInfinity;
  for (std::size_t k = 0; k < count_; ++k) {
    const Run& run = runs_[k];
    if (run.has_ended) continue;
    const double left = run.expected - (run.solver != nullptr ? run.work : 0);
    if (first == kMostEntrants || left < least_left) {
      first = k;
      least_left = left;
    }
    if (last == kMostEntrants || run.work < runs_[last].work) last = k;
  }
  return first != kMostEntrants && runs_[first].work > kLead * runs_[last].work ? last : first;
}

/// Work, with the load, up to which the entrant may go on now.
double Race::end_of_turn(std::size_t entrant) const {
  const Run& run = runs_[entrant];
  if (entrants_[entrant].converges) return (run.solver == nullptr ? kSprint : 2) * run.work;
  double level = kInfinity;
  for (std::size_t k = 0; k < count_; ++k) {
    if (!runs_[k].has_ended) level = std::min(level, runs_[k].work);
  }
  return std::max(2 * run.work, std::min(run.expected, 2 * kLead * level));
}

void Race::enter(std::size_t entrant, const Entrant& now) {
  entrants_[entrant] = now;
  const double load = now.load_cost;
  runs_[entrant] = {.work = load, .expected = now.cost, .begun_at = load, .noted_at = load};
}

std::size_t Race::first(std::span<const Entrant> entrants) {
  count_ = entrants.size();
  for (std::size_t k = 0; k < count_; ++k) enter(k, entrants[k]);
  const std::size_t early = sprinter();
  return early != kMostEntrants ? early : next();
}

Race::End Race::run(Stable& stable, const Terms& terms, Answer& answer) {
  stable_ = &stable;
  terms_ = terms;
  answer_ = &answer;
  answer.clear();  // what no entrant overwrites is not the last step's
  best_residual_ = accepted_at_ = kInfinity;
  is_out_of_time_ = false;
  const auto end_of = [](Turn turn) {
    return turn == Turn::kClaimed ? End::kClaimed : turn == Turn::kGoodEnough ? End::kGoodEnough : End::kTimeLimit;
  };
  runs_ = {};
  count_ = 1;
  enter(0, stable.first());
  if (entrants_[0].load_cost <= kHeadStart) {
    if (const Turn ended = turn(0, kHeadStart); ended != Turn::kOver) return end_of(ended);
  }
  const std::span<const Entrant> entrants = stable.entrants();
  count_ = entrants.size();
  for (std::size_t k = 0; k < count_; ++k) {
    if (runs_[k].solver == nullptr) enter(k, entrants[k]);
  }
  entrants_[0].cost = entrants[0].cost;
  runs_[0].expected = std::max(runs_[0].expected, entrants[0].cost);
  for (;;) {
    std::size_t k = sprinter();
    if (k == kMostEntrants) k = next();
    if (k == kMostEntrants) return is_out_of_time_ ? End::kTimeLimit : End::kAllGaveUp;
    const Turn ended = turn(k, end_of_turn(k));
    if (ended != Turn::kOver) return end_of(ended);
  }
}

}  // namespace lcpbench
