#include "native/sor/psor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test/impulse_solver.h"
#include "native/sor/conjugate_steps.h"
#include "native/sor/contact_blocks.h"
#include "native/sor/exact_parts.h"

namespace lcpbench {
namespace {

using Parts = PsorSettings::Parts;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The residual costs as much as a few sweeps. If it is too large, it is evaluated again when the rows are off by less
/// in the same proportion, at the latest after 1 / kTestEvery of the sweeps that were made.
constexpr std::int64_t kTestEvery = 8;

/// The sweeps wander if the rows have not halved what they are off by in so many iterations.
constexpr std::int64_t kPatience = 200;
/// Exact parts are extended this often. If the sweeps still wander, they go on without parts from the present impulses.
constexpr int kMostExtensions = 3;
/// The largest relaxation from when the sweeps wander for the first time.
constexpr double kWanderingRelaxation = 1;

/// Of a conjugate step, for each impulse and each velocity, see BudgetedSolver::work(). Measured.
constexpr double kWorkOfDirection = 6;

Capabilities capabilities_of(const PsorSettings& settings) {
  Capabilities capabilities{.compliance = true,
                            .guarantees = "none: convergence is not proven",
                            .warm_start = true,
                            .obeys_time_limit = true,
                            .allocation_free = settings.parts == Parts::kNone};
  if (settings.parts == Parts::kNone) {
    capabilities.guarantees =
        "converges for solvable LCPs with symmetric positive semidefinite M (no friction); with friction none";
  }
  return capabilities;
}

/// Projected successive over-relaxation, M not formed for contact problems.
///
/// Frictionless contacts and bare LCPs: z_i := max(0, z_i - relaxation * w_i / M_ii), w kept up to date; rows with
/// M_ii <= 0 keep z_i = 0. For symmetric positive semidefinite M and 0 < relaxation < 2 the objective 1/2 z'Mz + q'z
/// never increases, and a solvable LCP is reached in the limit. [Cottle, Pang, Stone 1992, 5.2-5.3; Luo, Tseng 1991]
/// Unless parts=none no convergence is proven.
///
/// Friction: the Anitescu-Potra M has zero diagonal entries, so that the method above does not exist for it. As physics
/// engines do, each contact's normal impulse is updated like a frictionless row, then its friction impulses take a
/// gradient step of length relaxation / (largest eigenvalue of their own block) and are projected onto
/// sum f_D <= mu f_N; lambda = max(0, -min D'v+) is read off at the end. Fixed points are exactly the solutions; that
/// the splitting converges is not proven. Opposite directions are carried as one signed impulse.
///
/// Contact problems keep v+ = v + G* J f: O(ngc) per row, less for sparse contacts. Bare LCPs: O(n) per row.
/// Solved is claimed only when the residual of every island, recomputed from z, is within the tolerance and AnswerTest
/// passes.
class Psor final : public BudgetedImpulseSolver<PsorSolver> {
 public:
  explicit Psor(const PsorSettings& settings) : settings_(settings), capabilities_(capabilities_of(settings)) {}
  const Capabilities& capabilities() const override { return capabilities_; }
  void respond(const Vector& z, Vector& u) override;

  double work() const override { return now_.work; }
  double residual(const Answer& /*answer*/) override {
    return state_.scale > 0 ? now_.least_residual / state_.scale : 0;
  }

 private:
  /// Of one solve.
  struct Progress {
    double allowed = 0;                ///< residual from which on an answer is tested
    double promising = 0;              ///< how much the rows may be off where the residual is next evaluated
    std::int64_t next = 0;             ///< the sweep from which it is evaluated anyhow
    std::int64_t iterations = 0;
    ContactBlocks::Step step;          ///< of the last sweep
    bool had_parts = false;            ///< the last sweep
    double least_residual = kInfinity; ///< of best_
    double work = 0;
  };

  void on_load(const Problem& problem) override;
  void begin(const Vector* start, double error) override;
  bool run(double work, double deadline_s) override;

  void set_start(const Vector* start);
  bool sweep_and_test(double deadline_s);
  void accelerate();
  bool is_last() const { return now_.iterations + 1 >= limit(); }
  bool accelerates() const { return settings_.parts != Parts::kNone; }
  double measure();
  ContactBlocks::Step sweep();
  std::int64_t limit() const { return settings_.max_iterations - static_cast<std::int64_t>(sweeps_of_parts_); }
  void begin_watch();
  bool wanders();
  void change_parts();
  void update_row(Index row, ContactBlocks::Step& sum);
  void recompute_velocity();
  bool is_bare() const { return problem().contact() == nullptr; }
  Vector& impulses() { return is_bare() ? state_.impulse : blocks_.impulses; }
  Vector& velocity() { return is_bare() ? state_.u : blocks_.velocity; }

  PsorSettings settings_;
  Capabilities capabilities_;
  Progress now_;
  double work_of_sweep_ = 0;
  Vector best_;                           // impulses of the state
  ContactBlocks blocks_;  // of contact problems
  ConjugateSteps steps_;
  bool may_take_parts_ = false;
  bool has_loaded_parts_ = false;  // when the sweeps wander for the first time
  ExactParts parts_;
  double sweeps_of_parts_ = 0;  // that the parts of this solve are worth, beyond one for each iteration
  int extensions_ = 0;          // of parts_ since they were none
  double relaxation_ = 1;       // now
  double best_off_ = 0;         // the least that the rows were off by, to a factor of two
  double least_off_ = 0;        // what the rows were off by at halved_at_
  std::int64_t halved_at_ = 0;  // the iteration that last halved it
};

void Psor::on_load(const Problem& problem) {
  state_.load(problem);
  load_test(problem);
  if (!is_bare()) blocks_.load(problem.contact()->inertia, state_);
  result_.reserve(problem);
  best_.resize(state_.impulse.size());
  work_of_sweep_ = is_bare() ? static_cast<double>(problem.size() * problem.size()) : blocks_.work();
  if (settings_.parts == Parts::kNone) return;
  steps_.load(impulses().size(), velocity().size());
  may_take_parts_ = !is_bare() && blocks_.has_bodies() && !state_.frictions.empty();
  parts_.clear();
  has_loaded_parts_ = false;
}

void Psor::set_start(const Vector* start) {
  Vector& impulse = state_.impulse;
  impulse.setZero();
  if (start != nullptr && start->size() == problem().size() && start->allFinite()) {
    for (Index i = 0; i < state_.contacts; ++i) {
      if (state_.columns.diagonal(i) > 0) impulse(i) = std::max((*start)(i), 0.0);
    }
    for (const SignedFriction& friction : state_.frictions) {
      const Index first = friction.first_column;
      auto g = impulse.segment(first, friction.directions);
      g = start->segment(first, friction.directions) - start->segment(first + friction.directions, friction.directions);
      project_on_cross_polytope(g.data(), g.size(), state_.mu(friction.contact) * impulse(friction.contact));
    }
    state_.scale_impulses();
  }
  state_.recompute_velocity();
  if (impulse.allFinite() && state_.u.allFinite()) return;
  impulse.setZero();  // beyond double, in the units of the islands: no start
  state_.recompute_velocity();
}

void Psor::respond(const Vector& z, Vector& u) {
  state_.set_impulses(z);
  u = state_.u;
  state_.units.restore(u);
}

void Psor::update_row(Index row, ContactBlocks::Step& sum) {
  const double diagonal = state_.columns.diagonal(row);
  const double w = state_.normal_velocity(row);
  if (!(diagonal > 0)) {
    sum.off = max_or_infinity(sum.off, w >= 0 ? 0.0 : -w);
    return;
  }
  const double before = state_.impulse(row);
  sum.off = max_or_infinity(sum.off, std::abs(std::min(diagonal * before, w)));
  state_.impulse(row) = std::max(before - settings_.relaxation * w / diagonal, 0.0);
  const double step = state_.impulse(row) - before;
  sum.size += diagonal * step * step;
  state_.columns.response.add_to(state_.u, row, step);
}

ContactBlocks::Step Psor::sweep() {
  if (!is_bare()) return blocks_.sweep(relaxation_);
  ContactBlocks::Step sum;
  for (Index i = 0; i < state_.contacts; ++i) update_row(i, sum);
  return sum;
}

/// Of the impulses that the sweeps have reached, in the state: the velocity and the residual.
double Psor::measure() {
  recompute_velocity();
  const double residual = state_.residual();
  now_.work += state_.work_of_residual();
  if (residual < now_.least_residual) {
    now_.least_residual = residual;
    best_ = state_.impulse;
  }
  return residual;
}

void Psor::begin(const Vector* start, double error) {
  test_.allow(error);
  // Beyond kClaimedResidual the test needs 113 bits, which takes longer than the few sweeps to reach it.
  const double tolerance = error > 0 ? error : std::min(settings_.tolerance, kClaimedResidual);
  begin_result({});
  now_ = {};
  now_.allowed = now_.promising = tolerance * state_.scale;
  set_start(start);
  if (!is_bare()) blocks_.take(state_);
  if (accelerates()) steps_.begin(impulses(), velocity());
  begin_watch();
}

/// One sweep, and the test of what it reached where that is promising.
/// @returns whether that is the end; the claim says which
bool Psor::sweep_and_test(double deadline_s) {
  result_.claim = Claim::kIterationLimit;
  if (now_.iterations >= limit()) return true;
  now_.had_parts = !parts_.empty();
  if (now_.had_parts) {
    now_.step = parts_.sweep(blocks_, relaxation_, deadline_s);
    now_.work += parts_.work();
  } else {
    now_.step = sweep();
    now_.work += work_of_sweep_;
  }
  result_.claim = Claim::kNumericalFailure;
  const double off = now_.step.off;
  if (!(off < kInfinity)) return true;
  const bool is_due = now_.iterations >= now_.next || is_last();
  if (!(off <= now_.promising || (off <= now_.allowed && is_due))) return false;
  const double residual = measure();
  if (residual <= now_.allowed) {
    state_.write_answer(result_.z);
    if (settle(deadline_s, now_.work)) {
      ++now_.iterations;
      return true;
    }
    result_.detail.clear();
    now_.allowed = residual / 2;  // a test costs more than a sweep
  }
  now_.promising = std::min(off * (now_.allowed / residual), now_.allowed);
  now_.next = now_.iterations + std::max<std::int64_t>(now_.iterations / kTestEvery, 1);
  if (!is_bare()) blocks_.take(state_);
  return false;
}

/// What comes between two sweeps.
void Psor::accelerate() {
  const bool is_end = is_last();
  ++now_.iterations;
  if (!accelerates() || is_end) return;
  now_.work += kWorkOfDirection * static_cast<double>(impulses().size() + velocity().size());
  if (may_take_parts_ && wanders()) {
    change_parts();
    steps_.begin(impulses(), velocity());
  } else {
    steps_.after_sweep(now_.step.size, impulses(), velocity());
  }
  if (now_.had_parts) sweeps_of_parts_ += parts_.sweeps_made() - 1;
}

bool Psor::run(double work, double deadline_s) {
  bool is_in_budget = true;
  for (bool is_first = true;; is_first = false) {
    is_in_budget = now_.work < work;
    if (!is_in_budget || !(wall_clock_s() < deadline_s)) {
      result_.claim = is_in_budget ? Claim::kTimeLimit : Claim::kIterationLimit;
      break;
    }
    if (!is_first) accelerate();
    if (sweep_and_test(deadline_s)) break;
  }
  result_.counters.iterations = now_.iterations + static_cast<std::int64_t>(sweeps_of_parts_);
  if (result_.claim == Claim::kSolved) return true;
  // A conjugate step may leave the pyramids. A sweep goes back there, an exact part only half of the way.
  if (now_.had_parts) blocks_.project();
  measure();
  if (now_.least_residual < kInfinity) {
    state_.impulse = best_;
    state_.recompute_velocity();
  }
  state_.write_answer(result_.z);
  if (result_.claim == Claim::kNumericalFailure) result_.detail = kGrewOutOfRange;
  return is_in_budget;
}

void Psor::begin_watch() {
  relaxation_ = settings_.relaxation;
  parts_.clear();
  sweeps_of_parts_ = 0;
  extensions_ = 0;
  least_off_ = best_off_ = kInfinity;
  halved_at_ = 0;
}

bool Psor::wanders() {
  const double off = now_.step.off;
  const std::int64_t iterations = now_.iterations - 1;  // before the last sweep
  const bool halved = off < least_off_ / 2;
  const bool waited = iterations - halved_at_ >= kPatience;
  if (off < best_off_ / 2) {  // the parts are worth keeping
    best_off_ = off;
    extensions_ = 0;
  }
  if (!halved && !waited) return false;
  least_off_ = off;
  halved_at_ = iterations;
  return !halved;
}

void Psor::change_parts() {
  relaxation_ = std::min(settings_.relaxation, kWanderingRelaxation);
  if (extensions_ == kMostExtensions) {
    parts_.clear();
    extensions_ = 0;
    return;
  }
  if (!has_loaded_parts_) parts_.load(blocks_);
  has_loaded_parts_ = true;
  parts_.extend(blocks_);
  ++extensions_;
}

/// Of the state, from the impulses that the sweeps have reached.
void Psor::recompute_velocity() {
  if (!is_bare()) blocks_.write(state_);
  state_.recompute_velocity();
}

}  // namespace

std::unique_ptr<PsorSolver> make_psor(const PsorSettings& settings) { return std::make_unique<Psor>(settings); }

SolverDefinition lcpbench_solver_psor() {
  return define_solver<Psor, PsorSettings>(
      {.name = "psor",
       .summary = "projected SOR in velocity space; friction by a projected splitting that has no proof of convergence",
       .source = "Cottle, Pang, Stone: The Linear Complementarity Problem, 1992, section 5.2",
       .capabilities = capabilities_of({})});
}

}  // namespace lcpbench
