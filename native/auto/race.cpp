#include "native/auto/race.h"

#include <algorithm>
#include <cmath>

#include "core/timed_solve.h"
#include "native/auto/powers.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of a unit of weighted work, about. Used only to skip an entrant whose load would outlast the deadline.
constexpr double kSecondsPerWork = 1e-9;

/// The residual counts as lower only if it has fallen by this part of itself.
constexpr double kLeastGain = 1e-3;

/// A prediction whose shape is above kShapeByResidual counts up to so many times the predicted work.
constexpr double kTrusted = 2;

/// If no error was stated, what a method claims with a residual above so many times the aim is an iterate as others
/// are.
constexpr double kPoor = 100;

/// Largest residual, over that of z = 0, of an iterate to begin from; a worse one misleads more often than it helps.
constexpr double kWorthLearning = 0.1;

}  // namespace

double Race::work() const {
  double sum = 0;
  for (const Run& run : runs_) sum += run.solver != nullptr ? run.work : 0;
  return sum;
}

/// Keeps the entrant's best iterate in best_, if it is better than that. @returns its residual
double Race::note(std::size_t entrant) {
  const double residual = runs_[entrant].solver->best(iterate_);
  if (residual < best_residual_) {
    best_residual_ = residual;
    best_.swap(iterate_);
    winner_ = entrant;
  }
  return residual;
}

/// What a method is expected to take until its residual is at the aim, over its work to come to this residual.
double Race::slowness(double residual) const { return power(std::max(residual / terms_.aim, 1.0), kSlowness); }

/// Predicts the entrant's whole work by its residual. If it stalls, begins it anew or lets its reserve enter.
void Race::expect(std::size_t entrant, double residual) {
  Run& run = runs_[entrant];
  // It went on from the aim, and still claims nothing: more of the same leads nowhere.
  const bool was_at_aim = run.residual <= terms_.aim;
  if (!was_at_aim && residual < (1 - kLeastGain) * run.residual) {
    run.residual = residual;
    run.noted_at = run.work;
  }
  const Entrant& predicted = entrants_[entrant];
  const double idle = run.noted_at > 0 ? run.work / run.noted_at : 1;
  const double expected = run.work * (was_at_aim ? kStalled : idle * slowness(run.residual));
  const bool is_trusted = run.work <= kTrusted * predicted.cost;
  const bool is_certain = is_trusted && !predicted.falls_late && predicted.shape > kShapeByResidual;
  const bool is_silent = !run.solver->residual_tells();
  const bool prediction_tells_more =
      is_silent || is_certain || (predicted.falls_late && predicted.cost <= expected);
  run.expected = prediction_tells_more ? predicted.cost : expected;
  const bool is_shape_known = prediction_tells_more || (is_trusted && predicted.falls_late);
  run.shape = is_shape_known ? predicted.shape : kShapeByResidual;
  if (is_silent && !is_trusted) run.shape = std::min(run.shape, kShapeByResidual);
  const bool stalls = run.work >= kStalled * run.noted_at;
  const std::size_t next = entrant + 1;
  const bool has_reserve = next < count_ && entrants_[next].is_reserve && runs_[next].solver == nullptr;
  if (has_reserve && (run.has_ended || (stalls && !run.has_learned))) runs_[next].has_ended = false;
  if (run.has_ended || !stalls || !run.has_learned) return;
  run.solver->begin(nullptr, terms_.error);  // what it learned misled it
  run.has_learned = false;
  run.begun_at = run.noted_at = run.work;
  run.residual = 1;
}

/// The entrant goes on until its work, load included, is `work`, at least kLeastTurn. @returns kNone: the race goes on
Race::End Race::turn(std::size_t entrant, double work) {
  const Entrant& now = entrants_[entrant];
  Run& run = runs_[entrant];
  const double left_s = terms_.deadline_s - wall_clock_s();
  if (!(left_s > 0)) return End::kTimeLimit;
  if (run.solver == nullptr) {
    if (kSecondsPerWork * now.load_cost > left_s) {
      run.has_ended = is_out_of_time_ = true;
      return End::kNone;
    }
    run.solver = &stable_->loaded(entrant);
    const Vector* start = terms_.start;
    if (start == nullptr && now.learns && best_residual_ <= kWorthLearning) {
      start_ = best_;
      start = &start_;
      run.has_learned = true;
    }
    run.solver->begin(start, terms_.error);
  }
  run.has_ended = run.solver->go_on((std::max(work, kLeastTurn) - run.work) / now.weight, terms_.deadline_s, *answer_);
  run.work = run.begun_at + now.weight * run.solver->work();
  if (run.has_ended && (answer_->claim == Claim::kSolved || answer_->claim == Claim::kUnsolvable)) {
    const bool may_be_poor = terms_.ends_early && now.converges && answer_->claim == Claim::kSolved;
    if (!may_be_poor || !(run.solver->best(iterate_) > kPoor * terms_.aim)) {
      winner_ = entrant;
      return End::kClaimed;
    }
  }
  const double residual = note(entrant);
  if (now.converges) expect(entrant, residual);
  if (best_residual_ <= std::min(terms_.aim, failed_residual_ / 2)) {
    if (stable_->passes(best_, *answer_)) return End::kClaimed;
    failed_residual_ = best_residual_;
  }
  if (!terms_.ends_early || !(best_residual_ <= terms_.accepted)) return End::kNone;
  const double done = this->work();
  accepted_at_ = std::min(accepted_at_, done);
  return done > kPatience * slowness(best_residual_) * accepted_at_ ? End::kGoodEnough : End::kNone;
}

/// See Race, 2.
Race::Turn Race::best_turn(std::size_t entrant) const {
  const Run& run = runs_[entrant];
  const double done = std::max(run.work, kLeastTurn);
  const auto odds_of_end = [&run](double work) { return power(work / run.expected, run.shape); };
  const double load = run.solver == nullptr ? run.work : 0;
  const double horizon = run.shape >= kCertain ? kHorizon * run.expected : 0;
  Turn best;
  for (const double end : {kStretch * done, horizon}) {
    if (!(end > done)) continue;
    const double goes_on = (1 + odds_of_end(done)) / (1 + odds_of_end(end));
    const double index = (1 - goes_on) / (load + (end - done) * (1 + goes_on) / 2);
    if (index > best.index) best = {entrant, end, index};
  }
  return best;
}

/// Of the entrants that do not wait.
Race::Turn Race::next() const {
  Turn next;
  for (std::size_t k = 0; k < count_; ++k) {
    if (runs_[k].has_ended || runs_[k].work > kLead * level()) continue;
    if (const Turn turn = best_turn(k); turn.index > next.index) next = turn;
  }
  return next;
}

double Race::level() const {
  double level = kInfinity;
  for (std::size_t k = 0; k < count_; ++k) {
    if (runs_[k].has_ended) continue;
    const double least = runs_[k].solver == nullptr ? entrants_[k].least_cost : 0;
    level = std::min(level, std::max(runs_[k].work, least));
  }
  return level;
}

void Race::enter(std::size_t entrant, const Entrant& now) {
  entrants_[entrant] = now;
  const double load = now.load_cost;
  runs_[entrant] = {.work = load, .expected = now.cost, .shape = now.shape, .begun_at = load, .noted_at = load,
                    .has_ended = now.is_reserve};
}

std::size_t Race::first(std::span<const Entrant> entrants) {
  count_ = entrants.size();
  for (std::size_t k = 0; k < count_; ++k) enter(k, entrants[k]);
  return next().entrant;
}

Race::End Race::run(Stable& stable, const Terms& terms, Answer& answer) {
  reserve(terms.size);
  stable_ = &stable;
  terms_ = terms;
  answer_ = &answer;
  answer.clear();  // what no entrant overwrites is not the last step's
  best_residual_ = failed_residual_ = accepted_at_ = kInfinity;
  is_out_of_time_ = false;
  winner_ = 0;
  runs_ = {};
  count_ = 1;
  enter(0, stable.first());
  if (entrants_[0].load_cost <= kHeadStart) {
    if (const End end = turn(0, kHeadStart); end != End::kNone) return end;
  }
  const std::span<const Entrant> entrants = stable.entrants();
  count_ = entrants.size();
  for (std::size_t k = 0; k < count_; ++k) {
    if (runs_[k].solver == nullptr) enter(k, entrants[k]);
  }
  entrants_[0] = entrants[0];
  runs_[0].expected = entrants[0].cost;
  runs_[0].shape = entrants[0].shape;
  for (;;) {
    const Turn next = this->next();
    const std::size_t k = next.entrant;
    if (std::isfinite(terms_.proof_at) && (k == kMostEntrants || work() >= terms_.proof_at)) {
      terms_.proof_at = kInfinity;
      if (stable.disproves(answer)) return End::kClaimed;
    }
    if (k == kMostEntrants) return is_out_of_time_ ? End::kTimeLimit : End::kAllGaveUp;
    const bool residual_counts = entrants_[k].converges && !entrants_[k].falls_late && runs_[k].solver != nullptr &&
                                 runs_[k].solver->residual_tells();
    const End end = turn(k, std::min(residual_counts ? kLook * runs_[k].work : next.end, 2 * kLead * level()));
    if (end != End::kNone) return end;
  }
}

}  // namespace lcpbench
