#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test/impulse_solver.h"
#include "native/sor/ode_order.h"

namespace lcpbench {
namespace {

struct QuickstepSorSettings {
  std::int64_t iterations = 1000;
  double w = 1.3;
  double cfm = 0.0;
  std::int64_t seed = 0;
  double tolerance = 1e-8;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 0, .max = 1000000000},
          "sweeps over the rows; ODE's default is 20");
    field("w", w, RealRange{.min = 1e-6, .max = 2.0}, "over-relaxation; 1.3 is ODE's default");
    field("cfm", cfm, RealRange{.min = 0.0}, "added to the diagonal of every row; ODE's default is 1e-10");
    field("seed", seed, IntegerRange{.min = 0, .max = 4294967295},
          "of the random numbers, made as ODE makes them, that order the rows");
    field("tolerance", tolerance, RealRange{.min = 0},
          "claim solved when the velocity residual of every island, evaluated in double, is at most this times the "
          "scale of the island; never stops early");
  }
};

constexpr std::int64_t kSweepsBetweenShuffles = 8;

/// A row of the iteration: |x| is bounded by what the contact's normal impulse allows.
struct FrictionRow {
  Index normal = 0;  ///< row of the contact's normal
  double mu = 0;
  Index first = 0;  ///< the contact's friction rows
  Index count = 0;
};

/// The iteration of ODE's QuickStep, on any contact problem: projected successive over-relaxation over the rows of
/// [N E], E the friction rows, M not formed.
///
/// A row's impulse becomes x_i - w (J_i u + b_i + cfm x_i) / (J_i G* J_i' + cfm), clamped: normals to x >= 0, friction
/// rows to |x_i| <= mu_i x_normal with the newest x_normal; u = v + G* J'x is kept up to date, b_i is the offset of a
/// normal and 0 for friction. Rows of normals come first, then those of friction; every 8 sweeps all rows are shuffled.
/// No warm start, no test of convergence. A contact with mu = 0 has no friction rows. On a scene the islands and the
/// order of their rows are ODE's (see ode_islands); any other problem is one island in its own order.
/// [ODE 0.16, dWorldQuickStep]
///
/// Friction of 4 edges: E = ((d1 + d2) / sqrt(2), (d2 - d1) / sqrt(2)) with mu / sqrt(2), which makes ODE's square the
/// pyramid. Of 2 edges: the direction itself. Of more, which no engine has, each direction is a row that is clamped to
/// what the contact's others leave of mu x_normal: ours, not ODE's, and its fixed points need not be solutions.
///
/// Without friction, for symmetric positive semidefinite M and 0 < w < 2 it converges to a solution when there is one
/// [Cottle, Pang, Stone 1992, 5.2-5.3; Luo, Tseng 1991]; with friction nothing is proven. O(ngc) per row, less for
/// sparse contacts. After the last sweep lambda is read off and the claim is that of the residual, which ODE has not.
class QuickstepSor final : public ImpulseSolver<> {
 public:
  explicit QuickstepSor(const QuickstepSorSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override;

 private:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  SparseMatrix friction_directions(Index columns_of_D);
  void add_friction_rows(const SignedFriction& friction, std::vector<Eigen::Triplet<double>>& directions);
  void order_rows(const Problem& problem);

  Claim sweep_all(double deadline_s);
  void update(Index row);
  double limit(Index row) const;
  void write_impulses();
  void settle(double deadline_s, Answer& answer);

  QuickstepSorSettings settings_;
  std::vector<FrictionRow> friction_rows_;         // row nc + k
  std::vector<Index> first_row_;                   // per friction of state_: its first row, -1 without
  ContactColumns rows_;                            // of [N E]
  Vector step_;                                    // w / (J_i G* J_i' + cfm); 0: the row moves nothing
  std::vector<std::vector<Index>> initial_order_;  // per island

  Vector x_;
  std::vector<std::vector<Index>> order_;
};

void QuickstepSor::on_load(const Problem& problem) {
  state_.load(problem);
  load_test(problem);
  ContactProblem rows = *problem.contact();
  const SparseMatrix directions = friction_directions(cols(rows.D));
  rows.D = std::visit([&](const auto& D) -> Jacobian { return std::decay_t<decltype(D)>(D * directions); }, rows.D);
  rows_ = contact_columns(rows);
  step_.resize(rows_.diagonal.size());
  for (Index row = 0; row < step_.size(); ++row) {
    const double diagonal = rows_.diagonal(row) + settings_.cfm;
    step_(row) = diagonal > 0 ? settings_.w / diagonal : 0.0;
  }
  x_.resize(step_.size());
  order_rows(problem);
}

/// E = D times this; also fills friction_rows_ and first_row_.
SparseMatrix QuickstepSor::friction_directions(Index columns_of_D) {
  friction_rows_.clear();
  first_row_.clear();
  std::vector<Eigen::Triplet<double>> directions;
  for (const SignedFriction& friction : state_.frictions) {
    const bool moves = state_.mu(friction.contact) > 0;
    first_row_.push_back(moves ? state_.contacts + static_cast<Index>(friction_rows_.size()) : -1);
    if (moves) add_friction_rows(friction, directions);
  }
  SparseMatrix result(columns_of_D, static_cast<Index>(friction_rows_.size()));
  result.setFromTriplets(directions.begin(), directions.end());
  return result;
}

void QuickstepSor::add_friction_rows(const SignedFriction& friction, std::vector<Eigen::Triplet<double>>& directions) {
  constexpr double kCosine = std::numbers::sqrt2 / 2;
  const Index column = friction.first_column - state_.contacts;  // of D
  const auto row = static_cast<Index>(friction_rows_.size());
  const double mu = state_.mu(friction.contact);
  const bool turned = friction.directions == 2;
  if (turned) {
    directions.emplace_back(column, row, kCosine);
    directions.emplace_back(column + 1, row, kCosine);
    directions.emplace_back(column, row + 1, -kCosine);
    directions.emplace_back(column + 1, row + 1, kCosine);
  }
  for (Index t = 0; t < friction.directions; ++t) {
    if (!turned) directions.emplace_back(column + t, row + t, 1.0);
    friction_rows_.push_back({.normal = friction.contact,
                              .mu = turned ? mu / std::numbers::sqrt2 : mu,
                              .first = state_.contacts + row,
                              .count = friction.directions});
  }
}

void QuickstepSor::order_rows(const Problem& problem) {
  std::vector<std::vector<Index>> islands;
  if (problem.scene() != nullptr) {
    islands = ode_islands(*problem.scene());
  } else {
    islands.emplace_back();
    for (Index contact = 0; contact < state_.contacts; ++contact) islands.back().push_back(contact);
  }
  for (std::vector<Index>& island : islands) {
    const std::size_t normals = island.size();
    for (std::size_t i = 0; i < normals; ++i) {
      const Index friction = state_.friction_of[static_cast<std::size_t>(island[i])];
      const Index first = friction < 0 ? -1 : first_row_[static_cast<std::size_t>(friction)];
      if (first < 0) continue;
      const Index count = friction_rows_[static_cast<std::size_t>(first - state_.contacts)].count;
      for (Index row = first; row < first + count; ++row) island.push_back(row);
    }
  }
  initial_order_ = std::move(islands);
  order_ = initial_order_;
}

double QuickstepSor::limit(Index row) const {
  const FrictionRow& friction = friction_rows_[static_cast<std::size_t>(row - state_.contacts)];
  const double allowed = friction.mu * x_(friction.normal);
  if (friction.count <= 2) return allowed;
  const double others = x_.segment(friction.first, friction.count).lpNorm<1>() - std::abs(x_(row));
  return std::max(allowed - others, 0.0);
}

void QuickstepSor::update(Index row) {
  if (step_(row) == 0) return;
  const double before = x_(row);
  const double w = row < state_.contacts ? state_.normal_velocity(row) : rows_.J.dot(row, state_.u);
  double next = before - step_(row) * (w + settings_.cfm * before);
  if (row < state_.contacts) {
    next = std::max(next, 0.0);
  } else {
    const double most = limit(row);
    next = std::min(std::max(next, -most), most);
  }
  if (next == before) return;
  x_(row) = next;
  rows_.response.add_to(state_.u, row, next - before);
}

/// @returns kIterationLimit after the last sweep, or kTimeLimit.
Claim QuickstepSor::sweep_all(double deadline_s) {
  OdeRandom random(static_cast<std::uint32_t>(settings_.seed));
  x_.setZero();
  state_.u = state_.u0;
  for (std::size_t island = 0; island < order_.size(); ++island) {
    std::vector<Index>& order = order_[island];
    std::copy(initial_order_[island].begin(), initial_order_[island].end(), order.begin());
    for (std::int64_t sweep = 0; sweep < settings_.iterations; ++sweep) {
      if (!(wall_clock_s() < deadline_s)) return Claim::kTimeLimit;
      if (sweep > 0 && sweep % kSweepsBetweenShuffles == 0) shuffle(order, random);
      for (const Index row : order) update(row);
    }
  }
  return Claim::kIterationLimit;
}

/// a + b, where it is more than what rounding leaves of numbers that cancel.
double sum_or_zero(double a, double b) {
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(a + b) > kRounding * (std::abs(a) + std::abs(b)) ? a + b : 0.0;
}

/// The impulses along the problem's own directions, and the velocity that they give.
void QuickstepSor::write_impulses() {
  state_.impulse.setZero();
  state_.impulse.head(state_.contacts) = x_.head(state_.contacts);
  for (std::size_t k = 0; k < state_.frictions.size(); ++k) {
    const SignedFriction& friction = state_.frictions[k];
    const Index row = first_row_[k];
    if (row < 0) continue;
    auto g = state_.impulse.segment(friction.first_column, friction.directions);
    g = x_.segment(row, friction.directions);
    if (friction.directions != 2) continue;
    g(0) = std::numbers::sqrt2 / 2 * sum_or_zero(x_(row), -x_(row + 1));
    g(1) = std::numbers::sqrt2 / 2 * sum_or_zero(x_(row), x_(row + 1));
  }
  state_.recompute_velocity();
}

/// Tests the answer as it is. If it fails, tests it again with those impulses set to zero that the residual counts as
/// zero: sweeps leave some of them near zero, and the test takes every impulse that is not zero for a basic variable.
void QuickstepSor::settle(double deadline_s, Answer& answer) {
  answer.claim = Claim::kSolved;
  if (test_.settle(answer, deadline_s) || answer.claim != Claim::kNumericalFailure) return;
  state_.drop_what_counts_as_zero();
  state_.write_answer(answer.z);
  answer.claim = Claim::kSolved;
  answer.detail.clear();
  test_.settle(answer, deadline_s);
}

void QuickstepSor::on_solve(const SolveRequest& request, Answer& answer) {
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  if (!(state_.scale > 0)) return claim_rest(deadline_s, answer);
  answer.claim = sweep_all(deadline_s);
  if (answer.claim != Claim::kTimeLimit) answer.counters.iterations = settings_.iterations;
  write_impulses();
  state_.write_answer(answer.z);
  const double residual = state_.residual();
  if (!(residual < std::numeric_limits<double>::infinity())) {
    answer.claim = Claim::kNumericalFailure;
    answer.detail = kGrewOutOfRange;
  } else if (residual <= settings_.tolerance * state_.scale) {
    settle(deadline_s, answer);
  }
}

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .guarantees =
        "converges for solvable problems with symmetric positive semidefinite M (no friction); with friction none",
    .obeys_time_limit = true,
    .allocation_free = true};

const Capabilities& QuickstepSor::capabilities() const { return kCapabilities; }

}  // namespace

SolverDefinition lcpbench_solver_quickstep_sor() {
  return define_solver<QuickstepSor, QuickstepSorSettings>(
      {.name = "quickstep_sor",
       .summary = "the iteration of ODE's QuickStep on any contact problem, same order and random numbers",
       .source = "Open Dynamics Engine 0.16, dWorldQuickStep; projected SOR after Cottle, Pang, Stone 1992, 5.2",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
