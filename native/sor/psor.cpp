#include "native/sor/psor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/sor/contact_blocks.h"
#include "native/sor/impulse_solver.h"

namespace lcpbench {
namespace {

enum class Order { kForward, kSymmetric };
enum class Acceleration { kNone, kConjugate };

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
          Choices<Acceleration>{{{"none", Acceleration::kNone}, {"conjugate", Acceleration::kConjugate}}},
          "between sweeps: nothing, or a step along a direction conjugate to the last ones");
  }
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The residual costs as much as a few sweeps. Where it was too large it is evaluated again when the rows are off by
/// less in the same proportion, or after one part in so many of the sweeps that were made.
constexpr std::int64_t kTestEvery = 8;

/// Steps along conjugate directions between sweeps, as in the nonlinear conjugate gradient method of Fletcher and
/// Reeves with the step of a sweep in place of the gradient. A sweep that moves more than the one before forgets the
/// directions, its own step included.
/// [Silcowitz, Niebe, Erleben 2010, A nonsmooth nonlinear conjugate gradient method for interactive contact force
/// problems]
class ConjugateSteps {
 public:
  /// Sizes the memory for x and u.
  void load(Index rows, Index coordinates) {
    x_before_.resize(rows);
    x_direction_.resize(rows);
    u_before_.resize(coordinates);
    u_direction_.resize(coordinates);
  }
  /// Forgets all directions.
  void restart() {
    x_direction_.setZero();
    u_direction_.setZero();
    size_ = 0;
  }
  void before_sweep(const Vector& x, const Vector& u) {
    x_before_ = x;
    u_before_ = u;
  }
  /// @param curvature weight of each entry of x
  void after_sweep(const Vector& curvature, Vector& x, Vector& u) {
    const double size = (curvature.array() * (x - x_before_).array().square()).sum();
    const bool is_first = size_ == 0;
    const double share = size < size_ ? size / size_ : 0.0;
    size_ = size;
    if (share == 0 && !is_first) {
      x_direction_.setZero();
      u_direction_.setZero();
      return;
    }
    extrapolate(share, x_before_, x_direction_, x);
    extrapolate(share, u_before_, u_direction_, u);
  }

 private:
  /// The step along the last direction, and the next direction.
  static void extrapolate(double share, const Vector& before, Vector& direction, Vector& now) {
    for (Index i = 0; i < now.size(); ++i) {
      const double step = now(i) - before(i);
      now(i) += share * direction(i);
      direction(i) = share * direction(i) + step;
    }
  }

  Vector x_before_, x_direction_;
  Vector u_before_, u_direction_;
  double size_ = 0;  // of the last sweep's step
};

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
  void limit_sweeps(std::int64_t sweeps, double tolerance) override {
    settings_.max_iterations = sweeps;
    settings_.tolerance = tolerance;
  }
  void aim_at(double residual) override {
    settings_.tolerance = residual;
    test_.allow(residual);
  }
  void unlimit_sweeps() override {
    settings_ = given_;
    test_.allow(0);
  }
  void respond(const Vector& z, Vector& u) override;

 private:
  void prepare(const Problem& problem) override;
  void iterate(const SolveRequest& request, double deadline_s, Answer& answer) override;

  void set_start(const Vector* start);
  void sweep_until_solved(double deadline_s, Answer& answer);
  bool settle(double deadline_s, Answer& answer);
  double sweep(bool backwards);
  double update_row(Index row);
  void recompute_velocity();
  bool is_bare() const { return problem().contact() == nullptr; }
  Vector& impulses() { return is_bare() ? state_.impulse : blocks_.impulses; }
  Vector& velocity() { return is_bare() ? state_.u : blocks_.velocity; }
  const Vector& curvature() const { return is_bare() ? state_.columns.diagonal : blocks_.curvature; }

  PsorSettings given_;
  PsorSettings settings_;
  ContactBlocks blocks_;  // of contact problems
  ConjugateSteps steps_;
};

void Psor::prepare(const Problem& problem) {
  if (!is_bare()) blocks_.load(problem.contact()->inertia, state_);
  if (settings_.acceleration == Acceleration::kConjugate) steps_.load(impulses().size(), velocity().size());
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

/// @returns how much the row was off, in the units of w: |min(M_ii z_i, w_i)|.
double Psor::update_row(Index row) {
  const double diagonal = state_.columns.diagonal(row);
  const double w = state_.normal_velocity(row);
  if (!(diagonal > 0)) return w >= 0 ? 0.0 : max_or_infinity(0, -w);
  const double before = state_.impulse(row);
  const double off = std::abs(std::min(diagonal * before, w));
  state_.impulse(row) = std::max(before - settings_.relaxation * w / diagonal, 0.0);
  state_.columns.response.add_to(state_.u, row, state_.impulse(row) - before);
  return off;
}

double Psor::sweep(bool backwards) {
  if (!is_bare()) return blocks_.sweep(settings_.relaxation, backwards);
  double off = 0;
  for (Index i = 0; i < state_.contacts; ++i) {
    off = max_or_infinity(off, update_row(backwards ? state_.contacts - 1 - i : i));
  }
  return off;
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
  const bool accelerates = settings_.acceleration == Acceleration::kConjugate;
  std::int64_t& iterations = answer.counters.iterations;
  if (!is_bare()) blocks_.take(state_);
  if (accelerates) steps_.restart();
  for (iterations = 0;; ++iterations) {
    answer.claim = Claim::kTimeLimit;
    if (!(wall_clock_s() < deadline_s)) return;
    answer.claim = Claim::kIterationLimit;
    if (iterations >= settings_.max_iterations) return;
    if (accelerates) steps_.before_sweep(impulses(), velocity());
    const double off = sweep(settings_.order == Order::kSymmetric && iterations % 2 == 1);
    answer.claim = Claim::kNumericalFailure;
    if (!(off < kInfinity)) return;
    const bool is_last = iterations + 1 >= settings_.max_iterations;
    if (off <= promising || (off <= allowed && (iterations >= next || is_last))) {
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
      promising = std::min(off * (allowed / residual), allowed);
      next = iterations + std::max<std::int64_t>(iterations / kTestEvery, 1);
      if (!is_bare()) blocks_.take(state_);
    }
    if (accelerates && !is_last) {
      steps_.after_sweep(curvature(), impulses(), velocity());
    }
  }
}

/// Of the state, from the impulses that the sweeps have reached.
void Psor::recompute_velocity() {
  if (!is_bare()) blocks_.write(state_);
  state_.recompute_velocity();
}

void Psor::iterate(const SolveRequest& request, double deadline_s, Answer& answer) {
  set_start(request.start);
  sweep_until_solved(deadline_s, answer);
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

const Capabilities& Psor::capabilities() const { return kCapabilities; }

}  // namespace

std::unique_ptr<LimitedPsor> make_conjugate_psor() {
  return std::make_unique<Psor>(PsorSettings{.acceleration = Acceleration::kConjugate});
}

SolverDefinition lcpbench_solver_psor() {
  return define_solver<Psor, PsorSettings>(
      {.name = "psor",
       .summary = "projected SOR in velocity space; friction by a projected splitting that has no proof of convergence",
       .source = "Cottle, Pang, Stone: The Linear Complementarity Problem, 1992, section 5.2",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
