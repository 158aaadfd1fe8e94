#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/contact_columns.h"

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
          "claim solved when the velocity residual, evaluated in double, is at most this times max|q|");
    field("order", order, Choices<Order>{{{"forward", Order::kForward}, {"symmetric", Order::kSymmetric}}},
          "every sweep in the order given, or every second one backwards");
  }
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// max(worst, value), infinity where value is NaN.
double max_or_infinity(double worst, double value) {
  if (value <= worst) return worst;
  return value > worst ? value : kInfinity;
}

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

/// A contact's friction: `directions` signed impulses g_t along its first directions, f_D = (max(g, 0), max(-g, 0)).
struct Friction {
  Index contact = 0;
  Index first_column = 0;  ///< in [N D]; the opposite of column t is t + directions
  Index directions = 0;
  Index lambda = 0;      ///< index in z
  double curvature = 0;  ///< largest eigenvalue of the directions' block of M; 0: friction moves nothing
};

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
/// The claim is the method's own: solved only when the residual, recomputed from z, is within the tolerance.
class Psor final : public Solver {
 public:
  explicit Psor(const PsorSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override;

 protected:
  void on_load(const Problem& problem) override;
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  void load_lcp(const Problem& problem);
  void load_contacts(const ContactProblem& problem);
  void add_friction(const ContactProblem& problem, const ContactLayout& layout, Index contact);
  double largest_eigenvalue(const Friction& friction) const;
  void measure_q();

  void set_start(const Vector* start);
  Claim iterate(double deadline_s, std::int64_t& iterations);
  double sweep(bool backwards);
  double update_contact(Index contact);
  double update_row(Index row);
  double update_friction(const Friction& friction);
  void recompute_velocity();
  double residual() const;
  double friction_residual(const Friction& friction) const;
  double slip_bound(const Friction& friction) const;
  double impulse_sum(const Friction& friction) const;
  void write_answer(Vector& z) const;

  PsorSettings settings_;
  ContactColumns columns_;  // of a bare LCP: J = I, response = M
  Vector mu_;               // nc
  std::vector<Friction> frictions_;
  std::vector<Index> friction_of_;  // nc: index in frictions_, -1 without
  Index contacts_ = 0;              // n of a bare LCP
  Vector u0_;                       // velocity before; q of a bare LCP
  double q_max_ = 0;

  Vector u_;        // velocity; w of a bare LCP
  Vector impulse_;  // per column of [N D]: f_N, then g at the first directions of each contact (the rest is not used)
  Vector step_;     // the most directions that a contact has
};

void Psor::on_load(const Problem& problem) {
  columns_ = {};
  frictions_.clear();
  if (problem.contact() != nullptr) {
    load_contacts(*problem.contact());
  } else {
    load_lcp(problem);
  }
  measure_q();
  u_.resize(u0_.size());
  impulse_.resize(columns_.diagonal.size());
}

void Psor::load_lcp(const Problem& problem) {
  const Lcp lcp = make_lcp(problem);
  contacts_ = lcp.size();
  u0_ = lcp.q;
  for (Index i = 0; i < contacts_; ++i) {
    columns_.J.add_column();
    columns_.J.add_run(i, Vector::Ones(1));
    columns_.response.add_column();
    columns_.response.add_run(0, lcp.M.col(i));
  }
  columns_.diagonal = lcp.M.diagonal();
  mu_.setZero(contacts_);
  friction_of_.assign(static_cast<std::size_t>(contacts_), -1);
}

void Psor::load_contacts(const ContactProblem& problem) {
  const ContactLayout layout = contact_layout(problem);
  contacts_ = layout.nc;
  u0_ = problem.v;
  columns_ = contact_columns(problem);
  mu_ = problem.mu;
  friction_of_.assign(static_cast<std::size_t>(contacts_), -1);
  Index most_directions = 0;
  for (Index contact = 0; contact < contacts_; ++contact) {
    if (layout.lambda[static_cast<std::size_t>(contact)] < 0) continue;
    add_friction(problem, layout, contact);
    most_directions = std::max(most_directions, frictions_.back().directions);
  }
  step_.resize(most_directions);
}

void Psor::add_friction(const ContactProblem& problem, const ContactLayout& layout, Index contact) {
  const auto c = static_cast<std::size_t>(contact);
  Friction friction;
  friction.contact = contact;
  friction.first_column = layout.friction_offset() + layout.friction_begin[c];
  friction.directions = problem.edges[c] / 2;
  friction.lambda = layout.lambda_offset() + layout.lambda[c];
  friction.curvature = largest_eigenvalue(friction);
  friction_of_[c] = static_cast<Index>(frictions_.size());
  frictions_.push_back(friction);
}

double Psor::largest_eigenvalue(const Friction& friction) const {
  Matrix block(friction.directions, friction.directions);
  Vector response(u0_.size());
  for (Index j = 0; j < friction.directions; ++j) {
    response.setZero();
    columns_.response.add_to(response, friction.first_column + j, 1.0);
    for (Index i = 0; i < friction.directions; ++i) block(i, j) = columns_.J.dot(friction.first_column + i, response);
  }
  if (columns_.diagonal.segment(friction.first_column, friction.directions).isZero(0)) return 0;
  return Eigen::SelfAdjointEigenSolver<Matrix>(block, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

/// max|q|: the q of cone rows is 0.
void Psor::measure_q() {
  q_max_ = 0;
  for (Index i = 0; i < columns_.diagonal.size(); ++i) q_max_ = std::max(q_max_, std::abs(columns_.J.dot(i, u0_)));
}

void Psor::on_update(const Vector& v) {
  if (!v.allFinite()) return Solver::on_update(v);  // refuses it, as load does
  u0_ = v;
  measure_q();
}

void Psor::set_start(const Vector* start) {
  impulse_.setZero();
  if (start != nullptr && start->size() == problem().size() && start->allFinite()) {
    for (Index i = 0; i < contacts_; ++i) {
      if (columns_.diagonal(i) > 0) impulse_(i) = std::max((*start)(i), 0.0);
    }
    for (const Friction& friction : frictions_) {
      const Index first = friction.first_column;
      auto g = impulse_.segment(first, friction.directions);
      g = start->segment(first, friction.directions) - start->segment(first + friction.directions, friction.directions);
      project_on_cross_polytope(g, mu_(friction.contact) * impulse_(friction.contact));
    }
  }
  recompute_velocity();
}

void Psor::recompute_velocity() {
  u_ = u0_;
  for (Index i = 0; i < contacts_; ++i) {
    if (impulse_(i) != 0) columns_.response.add_to(u_, i, impulse_(i));
  }
  for (const Friction& friction : frictions_) {
    for (Index t = friction.first_column; t < friction.first_column + friction.directions; ++t) {
      if (impulse_(t) != 0) columns_.response.add_to(u_, t, impulse_(t));
    }
  }
}

/// @returns how much the row was off, in the units of w: |min(M_ii z_i, w_i)|.
double Psor::update_row(Index row) {
  const double diagonal = columns_.diagonal(row);
  const double w = columns_.J.dot(row, u_);
  if (!(diagonal > 0)) return w >= 0 ? 0.0 : max_or_infinity(0, -w);
  const double before = impulse_(row);
  const double off = std::abs(std::min(diagonal * before, w));
  impulse_(row) = std::max(before - settings_.relaxation * w / diagonal, 0.0);
  columns_.response.add_to(u_, row, impulse_(row) - before);
  return off;
}

/// @returns the largest step before relaxation, in the units of w.
double Psor::update_friction(const Friction& friction) {
  if (!(friction.curvature > 0)) return 0;
  auto g = impulse_.segment(friction.first_column, friction.directions);
  auto step = step_.head(friction.directions);
  const double length = settings_.relaxation / friction.curvature;
  for (Index t = 0; t < friction.directions; ++t) {
    step(t) = g(t) - length * columns_.J.dot(friction.first_column + t, u_);
  }
  project_on_cross_polytope(step, mu_(friction.contact) * impulse_(friction.contact));
  step -= g;
  g += step;
  double largest = 0;
  for (Index t = 0; t < friction.directions; ++t) {
    if (step(t) != 0) columns_.response.add_to(u_, friction.first_column + t, step(t));
    largest = max_or_infinity(largest, std::abs(step(t)) / length);
  }
  return largest;
}

double Psor::update_contact(Index contact) {
  const double off = update_row(contact);
  const Index friction = friction_of_[static_cast<std::size_t>(contact)];
  return friction < 0 ? off : max_or_infinity(off, update_friction(frictions_[static_cast<std::size_t>(friction)]));
}

double Psor::sweep(bool backwards) {
  double off = 0;
  for (Index i = 0; i < contacts_; ++i) {
    off = max_or_infinity(off, update_contact(backwards ? contacts_ - 1 - i : i));
  }
  return off;
}

/// Largest |d_t'u|: the slip that lambda has to bound.
double Psor::slip_bound(const Friction& friction) const {
  double bound = 0;
  for (Index t = 0; t < friction.directions; ++t) {
    bound = max_or_infinity(bound, std::abs(columns_.J.dot(friction.first_column + t, u_)));
  }
  return bound;
}

double Psor::impulse_sum(const Friction& friction) const {
  return impulse_.segment(friction.first_column, friction.directions).lpNorm<1>();
}

/// Of the contact's friction rows and its cone row, at lambda = max |d_t'u|.
double Psor::friction_residual(const Friction& friction) const {
  const double lambda = slip_bound(friction);
  const double slack = mu_(friction.contact) * impulse_(friction.contact) - impulse_sum(friction);
  double worst = std::abs(std::min(lambda, columns_.diagonal(friction.contact) * slack));
  for (Index t = friction.first_column; t < friction.first_column + friction.directions; ++t) {
    const double slip = columns_.J.dot(t, u_);
    const double impulse = columns_.diagonal(t) * impulse_(t);
    worst = max_or_infinity(worst, std::abs(std::min(std::max(impulse, 0.0), lambda + slip)));
    worst = max_or_infinity(worst, std::abs(std::min(std::max(-impulse, 0.0), lambda - slip)));
  }
  return worst;
}

/// The velocity residual of the evaluation [m/s], in double: max |min(M_ii z_i, w_i)|, of cone rows
/// |min(lambda_i, M_nn w_i)|. Infinity where it is not a number. Expects u_ to be recomputed.
double Psor::residual() const {
  double worst = 0;
  for (Index i = 0; i < contacts_; ++i) {
    const double w = columns_.J.dot(i, u_);
    worst = max_or_infinity(worst, std::abs(std::min(std::max(columns_.diagonal(i), 0.0) * impulse_(i), w)));
  }
  for (const Friction& friction : frictions_) worst = max_or_infinity(worst, friction_residual(friction));
  return worst;
}

Claim Psor::iterate(double deadline_s, std::int64_t& iterations) {
  const double allowed = settings_.tolerance * q_max_;
  for (iterations = 0;; ++iterations) {
    if (!(wall_clock_s() < deadline_s)) return Claim::kTimeLimit;
    if (iterations >= settings_.max_iterations) return Claim::kIterationLimit;
    const double off = sweep(settings_.order == Order::kSymmetric && iterations % 2 == 1);
    if (!(off < kInfinity)) return Claim::kNumericalFailure;
    if (!(off <= allowed)) continue;
    recompute_velocity();
    if (residual() <= allowed) {
      ++iterations;
      return Claim::kSolved;
    }
  }
}

void Psor::write_answer(Vector& z) const {
  z.head(contacts_) = impulse_.head(contacts_);
  for (const Friction& friction : frictions_) {
    const auto g = impulse_.segment(friction.first_column, friction.directions);
    z.segment(friction.first_column, friction.directions) = g.cwiseMax(0.0);
    z.segment(friction.first_column + friction.directions, friction.directions) =
        (0.0 - g.array()).max(0.0);  // not -g: no negative zeros
    z(friction.lambda) = slip_bound(friction);
  }
}

void Psor::on_solve(const SolveRequest& request, Answer& answer) {
  if (q_max_ == 0) {  // z = 0 solves it, and max|q| gives no scale to judge another answer by
    answer.claim = Claim::kSolved;
    answer.counters.iterations = 0;
    return;
  }
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  set_start(request.start);
  answer.claim = iterate(deadline_s, answer.counters.iterations);
  recompute_velocity();
  write_answer(answer.z);
  if (answer.claim == Claim::kNumericalFailure) answer.detail = "the iterates grew out of the range of double";
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
