#include "native/sor/psor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/sor/conjugate_steps.h"
#include "native/sor/contact_blocks.h"
#include "native/sor/exact_parts.h"
#include "native/sor/impulse_solver.h"
#include "native/sor/local_sweeps.h"

namespace lcpbench {
namespace {

enum class Order { kForward, kSymmetric };
enum class Acceleration { kNone, kConjugate, kLocal, kExact };

struct PsorSettings {
  std::int64_t max_iterations = 10000;
  double relaxation = 1.3;
  double tolerance = 1e-8;
  Order order = Order::kForward;
  Acceleration acceleration = Acceleration::kNone;

  void visit(auto&& field) {
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "sweeps over all contacts (rows of a bare LCP)");
    field("relaxation", relaxation, RealRange{.min = 0x1p-10, .max = 2 - 0x1p-10},
          "factor on each step: 1 is Gauss-Seidel, more is over-relaxation");
    field("tolerance", tolerance, RealRange{.min = 0},
          "an answer is tested, and then claimed, when the velocity residual of every island, evaluated in double, is "
          "at most this times max|q| of the island");
    field("order", order, Choices<Order>{{{"forward", Order::kForward}, {"symmetric", Order::kSymmetric}}},
          "every sweep in the order given, or every second one backwards");
    field("acceleration", acceleration,
          Choices<Acceleration>{{{"none", Acceleration::kNone},
                                 {"conjugate", Acceleration::kConjugate},
                                 {"local", Acceleration::kLocal},
                                 {"exact", Acceleration::kExact}}},
          "between sweeps: nothing; a step along a direction conjugate to the last ones; or that, and sweeps over the "
          "contacts that are far off where these are few; or those, and contacts about which the sweeps wander are "
          "solved by contact_lemke");
  }
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The residual costs as much as a few sweeps. Where it was too large it is evaluated again when the rows are off by
/// less in the same proportion, or after one part in so many of the sweeps that were made.
constexpr std::int64_t kTestEvery = 8;

/// The sweeps wander if the rows have not halved what they are off by in so many iterations.
constexpr std::int64_t kPatience = 200;
/// Exact parts are extended so often before the sweeps go on without them, from where they have come to.
constexpr int kMostExtensions = 3;
/// From when the sweeps wander for the first time, unless the relaxation is less.
constexpr double kWanderingRelaxation = 1;

/// Without a limit, LimitedPsor takes up to so many sweeps and exact parts.
constexpr std::int64_t kPatientSweeps = 100'000;

/// Projected successive over-relaxation, M not formed for contact problems.
///
/// Frictionless contacts and bare LCPs: z_i := max(0, z_i - relaxation * w_i / M_ii), w kept up to date; rows with
/// M_ii <= 0 keep z_i = 0. For symmetric positive semidefinite M and 0 < relaxation < 2 the objective 1/2 z'Mz + q'z
/// never increases, and a solvable LCP is reached in the limit. [Cottle, Pang, Stone 1992, 5.2-5.3; Luo, Tseng 1991]
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
class Psor final : public ImpulseSolver<LimitedPsor> {
 public:
  explicit Psor(const PsorSettings& settings) : given_(settings), settings_(settings) {}
  const Capabilities& capabilities() const override;
  void take_parts(bool exact) override { settings_.acceleration = exact ? Acceleration::kExact : Acceleration::kLocal; }
  void limit_sweeps(std::int64_t sweeps, double tolerance) override {
    settings_.relaxation = PsorSettings{}.relaxation;
    settings_.max_iterations = sweeps;
    settings_.tolerance = tolerance;
  }
  void aim_at(double residual) override {
    settings_.tolerance = residual;
    test_.allow(residual);
  }
  void unlimit_sweeps() override {
    const Acceleration acceleration = settings_.acceleration;
    settings_ = acceleration == Acceleration::kExact ? given_ : PsorSettings{};
    settings_.acceleration = acceleration;
    test_.allow(0);
  }
  void respond(const Vector& z, Vector& u) override;

 private:
  void prepare(const Problem& problem) override;
  void iterate(const SolveRequest& request, double deadline_s, Answer& answer) override;

  void set_start(const Vector* start);
  void sweep_until_solved(double deadline_s, Answer& answer);
  bool settle(double deadline_s, Answer& answer);
  ContactBlocks::Step sweep(bool backwards);
  std::int64_t sweep_locally(double allowed, double deadline_s);
  std::int64_t limit() const { return settings_.max_iterations - static_cast<std::int64_t>(sweeps_of_parts_); }
  void begin_watch();
  bool wanders(double off, std::int64_t iterations);
  void change_parts();
  void update_row(Index row, ContactBlocks::Step& sum);
  void recompute_velocity();
  bool is_bare() const { return problem().contact() == nullptr; }
  Vector& impulses() { return is_bare() ? state_.impulse : blocks_.impulses; }
  Vector& velocity() { return is_bare() ? state_.u : blocks_.velocity; }

  PsorSettings given_;
  PsorSettings settings_;
  ContactBlocks blocks_;  // of contact problems
  ConjugateSteps steps_;
  std::vector<Entries> all_impulses_, all_velocities_;  // as one range each
  bool sweeps_locally_ = false;
  LocalSweeps local_;
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

void Psor::prepare(const Problem& problem) {
  if (!is_bare()) blocks_.load(problem.contact()->inertia, state_);
  if (settings_.acceleration == Acceleration::kNone) return;
  steps_.load(impulses().size(), velocity().size());
  all_impulses_.assign(1, {0, impulses().size()});
  all_velocities_.assign(1, {0, velocity().size()});
  // By the given setting: what take_parts() said of the last problem means nothing to this one.
  const bool is_exact = given_.acceleration == Acceleration::kExact;
  sweeps_locally_ =
      (is_exact || given_.acceleration == Acceleration::kLocal) && !is_bare() && blocks_.has_bodies();
  if (sweeps_locally_) local_.load(blocks_);
  may_take_parts_ = is_exact && sweeps_locally_ && !state_.frictions.empty();
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
  state_.impulse.setZero();
  state_.impulse.head(state_.contacts) = z.head(state_.contacts);
  for (const SignedFriction& friction : state_.frictions) {
    const Index first = friction.first_column;
    state_.impulse.segment(first, friction.directions) =
        z.segment(first, friction.directions) - z.segment(first + friction.directions, friction.directions);
  }
  state_.scale_impulses();
  state_.recompute_velocity();
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

ContactBlocks::Step Psor::sweep(bool backwards) {
  if (!is_bare()) return blocks_.sweep(relaxation_, backwards);
  ContactBlocks::Step sum;
  for (Index i = 0; i < state_.contacts; ++i) update_row(backwards ? state_.contacts - 1 - i : i, sum);
  return sum;
}

/// Of an answer with a small residual: claims it, where it passes the test of all native solvers.
/// @returns whether that is the end
bool Psor::settle(double deadline_s, Answer& answer) {
  state_.write_answer(answer.z);
  answer.claim = Claim::kSolved;
  return test_.settle(answer, deadline_s) || answer.claim != Claim::kNumericalFailure;
}

void Psor::sweep_until_solved(double deadline_s, Answer& answer) {
  double allowed = settings_.tolerance * state_.q_max;
  double promising = allowed;  // how much the rows may be off where the residual is next evaluated
  std::int64_t next = 0;       // the sweep from which it is evaluated anyhow
  std::int64_t updates = 0;    // of contacts in local sweeps, beyond those that make up a sweep
  const bool accelerates = settings_.acceleration != Acceleration::kNone;
  const ConjugateSteps::Part all{.x = all_impulses_, .u = all_velocities_};
  std::int64_t& iterations = answer.counters.iterations;
  if (!is_bare()) blocks_.take(state_);
  if (accelerates) steps_.begin(all, impulses(), velocity());
  begin_watch();
  for (iterations = 0;; ++iterations) {
    answer.claim = Claim::kTimeLimit;
    if (!(wall_clock_s() < deadline_s)) return;
    answer.claim = Claim::kIterationLimit;
    if (iterations >= limit()) return;
    const bool has_parts = !parts_.empty();
    const ContactBlocks::Step step = has_parts ? parts_.sweep(blocks_, relaxation_, deadline_s)
                                               : sweep(settings_.order == Order::kSymmetric && iterations % 2 == 1);
    answer.claim = Claim::kNumericalFailure;
    if (!(step.off < kInfinity)) return;
    const bool is_last = iterations + 1 >= limit();
    if (step.off <= promising || (step.off <= allowed && (iterations >= next || is_last))) {
      recompute_velocity();
      const double residual = state_.residual();
      if (residual <= allowed) {
        if (settle(deadline_s, answer)) {
          ++iterations;
          return;
        }
        answer.detail.clear();
        allowed = residual / 2;  // a test costs more than a sweep
      }
      promising = std::min(step.off * (allowed / residual), allowed);
      next = iterations + std::max<std::int64_t>(iterations / kTestEvery, 1);
      if (!is_bare()) blocks_.take(state_);
    }
    if (!accelerates || is_last) continue;
    if (may_take_parts_ && settings_.acceleration == Acceleration::kExact && wanders(step.off, iterations)) {
      change_parts();
      steps_.begin(all, impulses(), velocity());
    } else if (has_parts) {
      steps_.after_sweep(all, step.size, impulses(), velocity());
    }
    if (has_parts) {
      sweeps_of_parts_ += parts_.sweeps_made() - 1;
      continue;
    }
    const std::int64_t made = sweeps_locally_ ? sweep_locally(promising, deadline_s) : 0;
    if (made == 0) {
      steps_.after_sweep(all, step.size, impulses(), velocity());
      continue;
    }
    steps_.begin(all, impulses(), velocity());
    updates += made;
    iterations += updates / state_.contacts;
    updates %= state_.contacts;
  }
}

std::int64_t Psor::sweep_locally(double allowed, double deadline_s) {
  return local_.run(blocks_, steps_, {.relaxation = relaxation_, .allowed = allowed, .deadline_s = deadline_s});
}

void Psor::begin_watch() {
  relaxation_ = settings_.relaxation;
  parts_.clear();
  sweeps_of_parts_ = 0;
  extensions_ = 0;
  least_off_ = best_off_ = kInfinity;
  halved_at_ = 0;
}

/// @param off of the last sweep
bool Psor::wanders(double off, std::int64_t iterations) {
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

void Psor::iterate(const SolveRequest& request, double deadline_s, Answer& answer) {
  set_start(request.start);
  sweep_until_solved(deadline_s, answer);
  answer.counters.iterations += static_cast<std::int64_t>(sweeps_of_parts_);
  if (answer.claim == Claim::kSolved) return;
  recompute_velocity();
  state_.write_answer(answer.z);
  if (answer.claim == Claim::kNumericalFailure) answer.detail = kGrewOutOfRange;
}

constexpr Capabilities kCapabilities{
    .guarantees =
        "converges for solvable LCPs with symmetric positive semidefinite M (no friction); with friction none",
    .warm_start = true,
    .obeys_time_limit = true,
    .allocation_free = true};

constexpr Capabilities kCapabilitiesWithParts = [] {
  Capabilities capabilities = kCapabilities;
  capabilities.allocation_free = false;
  return capabilities;
}();

const Capabilities& Psor::capabilities() const {
  return given_.acceleration == Acceleration::kExact ? kCapabilitiesWithParts : kCapabilities;
}

}  // namespace

std::unique_ptr<LimitedPsor> make_limited_psor() {
  return std::make_unique<Psor>(
      PsorSettings{.max_iterations = kPatientSweeps, .relaxation = 1, .acceleration = Acceleration::kExact});
}

SolverDefinition lcpbench_solver_psor() {
  return define_solver<Psor, PsorSettings>(
      {.name = "psor",
       .summary = "projected SOR in velocity space; friction by a projected splitting that has no proof of convergence",
       .source = "Cottle, Pang, Stone: The Linear Complementarity Problem, 1992, section 5.2",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
