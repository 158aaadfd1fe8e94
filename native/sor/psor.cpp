#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/sor/impulse_solver.h"

namespace lcpbench {
namespace {

enum class Order { kForward, kSymmetric };

struct PsorSettings {
  std::int64_t max_iterations = 10000;
  double relaxation = 1.3;
  double tolerance = 1e-8;
  Order order = Order::kForward;

  void visit(auto&& field) {
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "sweeps over all contacts (rows of a bare LCP)");
    field("relaxation", relaxation, RealRange{.min = 0x1p-10, .max = 2 - 0x1p-10},
          "factor on each step: 1 is Gauss-Seidel, more is over-relaxation");
    field("tolerance", tolerance, RealRange{.min = 0},
          "an answer is tested, and then claimed, when the velocity residual of every island, evaluated in double, is "
          "at most this times max|q| of the island");
    field("order", order, Choices<Order>{{{"forward", Order::kForward}, {"symmetric", Order::kSymmetric}}},
          "every sweep in the order given, or every second one backwards");
  }
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Euclidean projection of y onto {sum |y_i| <= radius}, radius >= 0: shrinks all |y_i| by one threshold, found by
/// dropping entries that it brings to zero. O(size^2), of which O(size) is usual. [Michelot 1986; Duchi et al. 2008]
void project_on_cross_polytope(Eigen::Ref<Vector> y, double radius) {
  if (y.lpNorm<1>() <= radius) return;
  double threshold = 0;
  for (Index step = 0; step < y.size(); ++step) {
    double sum = 0;
    Index kept = 0;
    for (const double entry : y) {
      if (!(std::abs(entry) > threshold)) continue;
      sum += std::abs(entry);
      ++kept;
    }
    if (kept == 0) break;
    const double next = (sum - radius) / static_cast<double>(kept);
    if (!(next > threshold)) break;
    threshold = next;
  }
  for (double& entry : y) entry = std::copysign(std::max(std::abs(entry) - threshold, 0.0), entry);
}

/// Projected successive over-relaxation, one row of M at a time, M not formed for contact problems.
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
class Psor final : public ImpulseSolver {
 public:
  explicit Psor(const PsorSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override;

 private:
  void prepare(const Problem& problem) override;
  void iterate(const SolveRequest& request, double deadline_s, Answer& answer) override;

  double largest_eigenvalue(const SignedFriction& friction) const;

  void set_start(const Vector* start);
  void sweep_until_solved(double deadline_s, Answer& answer);
  bool settle(double deadline_s, Answer& answer);
  double sweep(bool backwards);
  double update_contact(Index contact);
  double update_row(Index row);
  double update_friction(std::size_t index);

  PsorSettings settings_;
  std::vector<double> curvature_;  // per friction: largest eigenvalue of its own block of M; 0: it moves nothing
  Vector step_;                    // the most directions that a contact has
};

void Psor::prepare(const Problem&) {
  curvature_.clear();
  Index most_directions = 0;
  for (const SignedFriction& friction : state_.frictions) {
    curvature_.push_back(largest_eigenvalue(friction));
    most_directions = std::max(most_directions, friction.directions);
  }
  step_.resize(most_directions);
}

double Psor::largest_eigenvalue(const SignedFriction& friction) const {
  const ContactColumns& columns = state_.columns;
  Matrix block(friction.directions, friction.directions);
  Vector response(state_.u0.size());
  for (Index j = 0; j < friction.directions; ++j) {
    response.setZero();
    columns.response.add_to(response, friction.first_column + j, 1.0);
    for (Index i = 0; i < friction.directions; ++i) block(i, j) = columns.J.dot(friction.first_column + i, response);
  }
  if (columns.diagonal.segment(friction.first_column, friction.directions).isZero(0)) return 0;
  return Eigen::SelfAdjointEigenSolver<Matrix>(block, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
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
      project_on_cross_polytope(g, state_.mu(friction.contact) * impulse(friction.contact));
    }
    state_.scale_impulses();
  }
  state_.recompute_velocity();
  if (impulse.allFinite() && state_.u.allFinite()) return;
  impulse.setZero();  // beyond double, in the units of the islands: no start
  state_.recompute_velocity();
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

/// @returns the largest step before relaxation, in the units of w.
double Psor::update_friction(std::size_t index) {
  const SignedFriction& friction = state_.frictions[index];
  const ContactColumns& columns = state_.columns;
  if (!(curvature_[index] > 0)) return 0;
  auto g = state_.impulse.segment(friction.first_column, friction.directions);
  auto step = step_.head(friction.directions);
  const double length = settings_.relaxation / curvature_[index];
  for (Index t = 0; t < friction.directions; ++t) {
    step(t) = g(t) - length * columns.J.dot(friction.first_column + t, state_.u);
  }
  project_on_cross_polytope(step, state_.mu(friction.contact) * state_.impulse(friction.contact));
  step -= g;
  g += step;
  double largest = 0;
  for (Index t = 0; t < friction.directions; ++t) {
    if (step(t) != 0) columns.response.add_to(state_.u, friction.first_column + t, step(t));
    largest = max_or_infinity(largest, std::abs(step(t)) / length);
  }
  return largest;
}

double Psor::update_contact(Index contact) {
  const double off = update_row(contact);
  const Index friction = state_.friction_of[static_cast<std::size_t>(contact)];
  return friction < 0 ? off : max_or_infinity(off, update_friction(static_cast<std::size_t>(friction)));
}

double Psor::sweep(bool backwards) {
  double off = 0;
  for (Index i = 0; i < state_.contacts; ++i) {
    off = max_or_infinity(off, update_contact(backwards ? state_.contacts - 1 - i : i));
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
  std::int64_t& iterations = answer.counters.iterations;
  for (iterations = 0;; ++iterations) {
    answer.claim = Claim::kTimeLimit;
    if (!(wall_clock_s() < deadline_s)) return;
    answer.claim = Claim::kIterationLimit;
    if (iterations >= settings_.max_iterations) return;
    const double off = sweep(settings_.order == Order::kSymmetric && iterations % 2 == 1);
    answer.claim = Claim::kNumericalFailure;
    if (!(off < kInfinity)) return;
    if (!(off <= allowed)) continue;
    state_.recompute_velocity();
    const double residual = state_.residual();
    if (!(residual <= allowed)) continue;
    if (settle(deadline_s, answer)) {
      ++iterations;
      return;
    }
    answer.detail.clear();
    allowed = residual / 2;  // a test costs more than a sweep
  }
}

void Psor::iterate(const SolveRequest& request, double deadline_s, Answer& answer) {
  set_start(request.start);
  sweep_until_solved(deadline_s, answer);
  if (answer.claim == Claim::kSolved) return;
  state_.recompute_velocity();
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

SolverDefinition lcpbench_solver_psor() {
  return define_solver<Psor, PsorSettings>(
      {.name = "psor",
       .summary = "projected SOR in velocity space; friction by a projected splitting that has no proof of convergence",
       .source = "Cottle, Pang, Stone: The Linear Complementarity Problem, 1992, section 5.2",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
