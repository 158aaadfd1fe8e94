#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{
    .guarantees = "positive semidefinite M with a strictly feasible point (z > 0 with M z + q > 0)",
    .obeys_time_limit = true,
    .allocation_free = true};

enum class FinalTest { kNone, kResidual };

struct PrimalDualSettings {
  double gap_tolerance = 1e-14;
  double residual_tolerance = 1e-8;
  std::int64_t max_iterations = 1000;
  FinalTest test = FinalTest::kResidual;

  void visit(auto&& field) {
    field("eps", gap_tolerance, RealRange{.min = 0}, "stop when the surrogate duality gap is at most this (absolute)");
    field("eps_feas", residual_tolerance, RealRange{.min = 0},
          "... and the norms of the primal and the dual residual are at most this (absolute)");
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "Newton steps");
    field(
        "test", test, Choices<FinalTest>{{{"none", FinalTest::kNone}, {"residual", FinalTest::kResidual}}},
        "of an answer to which the method converged: none, as in the paper; residual: from the raw data, as all native "
        "solvers do, with z_i = 0 where c_i z_i < w_i, and where that does not pass with M z = -q solved on the rest");
  }
};

// Of the longest step that keeps the multipliers positive; mu, alpha and beta of the book. [BV04, p. 569, 612, 613]
constexpr double kBoundaryFraction = 0.99;
constexpr double kBarrierFactor = 10;  // mu: each step aims at a gap smaller by it
constexpr double kDecrease = 0.01;     // alpha: the share of the predicted decrease of the residual that is asked for
constexpr double kBacktracking = 0.5;  // beta: the factor on a step that was too long

// Solved is claimed only where max|min(c_i z_i, w_i)| <= this * max|q|, c_i the largest |entry| of M's column i.
constexpr double kAcceptedResidual = 1e-4;

// A Newton step cut shorter than this was cut by rounding errors, not by the problem: the square root of the unit
// round-off, as is usual where a decrease is told from noise.
constexpr double kShortestStep = 0x1p-26;

/// Whether the time is over, asked at every 16th of the columns of a loop: of some thousands, a step takes seconds.
bool is_late(Index column, double deadline_s) { return column % 16 == 15 && !(wall_clock_s() < deadline_s); }

/// Factors the lower triangle of A in place as L L'; false, with A spoiled, when a pivot is not positive and finite, or
/// the time is over. Column by column, so that nothing is allocated.
bool cholesky_in_place(Matrix& A, double deadline_s) {
  const Index n = A.rows();
  for (Index j = 0; j < n; ++j) {
    if (is_late(j, deadline_s)) return false;
    A.col(j).tail(n - j).noalias() -= A.block(j, 0, n - j, j) * A.row(j).head(j).transpose();
    const double pivot = A(j, j);
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    A.col(j).tail(n - j) /= std::sqrt(pivot);
  }
  return true;
}

/// How a run of the method ends.
enum class InteriorEnd { kConverged, kStalled, kBreakdown, kIterationLimit, kTimeLimit };

constexpr const char* kAcceptedAsItIs = "no step reduces the residual further; accepted as it is";

const char* words_of(InteriorEnd end) {
  switch (end) {
    case InteriorEnd::kStalled: return "no step reduces the residual further";
    case InteriorEnd::kBreakdown: return "the Newton system could not be solved";
    default: return "";
  }
}

Claim claim_of(InteriorEnd end) {
  switch (end) {
    case InteriorEnd::kConverged: return Claim::kSolved;
    case InteriorEnd::kIterationLimit: return Claim::kIterationLimit;
    case InteriorEnd::kTimeLimit: return Claim::kTimeLimit;
    case InteriorEnd::kStalled:
    case InteriorEnd::kBreakdown: break;
  }
  return Claim::kNumericalFailure;
}

/// A point of the method: z, the slack y, which tends to M z + q, both kept positive, and their multipliers; or a step
/// of them.
struct Point {
  Vector z, y;           // n
  Vector lambda, kappa;  // n: of z >= 0 and of y >= 0

  void resize(Index n) {
    for (Vector* part : {&z, &y, &lambda, &kappa}) part->resize(n);
  }
  double surrogate_gap() const { return z.dot(lambda) + y.dot(kappa); }
};

/// Solves LCP(q, M) as a convex quadratic program by the primal-dual interior-point method.
///
/// minimize f(z) subject to z >= 0, y >= 0, y = M z + q, with f(z) = 1/2 z'Mz + q'z (the work done, and the paper's
/// program) or, where M is not symmetric, f(z) = z'(Mz + q). For positive semidefinite M a solution of the LCP is a
/// solution of the program. With the former both y_i and its multiplier vanish on active contacts, so that they are only
/// of the size of sqrt(gap).
/// Without a strictly feasible point (contact normals that positively span space) there is no central path and the
/// method may stall. For other M it finds at best a stationary point, and says solved only where the LCP holds.
/// The multiplier of y = M z + q is eliminated (it equals -kappa). O(n^3) per step; solve() allocates nothing.
/// [Boyd, Vandenberghe 2004, section 11.7; docs/reference/solvers/primal_dual.md]
class PrimalDual final : public Solver {
 public:
  explicit PrimalDual(const PrimalDualSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kCapabilities; }

 protected:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  void resize_workspace(Index n);
  void set_start();
  InteriorEnd iterate(double deadline_s, Counters& counters);
  /// r_dual_ = H z + q - lambda - M'kappa and r_pri_ = M z + q - y at `point`.
  void evaluate_residuals(const Point& point);
  double residual_norm(const Point& point, double t) const;
  bool converged() const;
  bool find_direction(double t, double deadline_s, Counters& counters);
  bool form_newton_matrix(double deadline_s);
  bool factor_newton_matrix(double deadline_s, Counters& counters);
  double longest_step() const;
  void step_to_trial(double s);
  bool line_search(double t);
  double lcp_residual();
  void finish_on_support(double deadline_s, Vector& z);
  void exchange_negative(Vector& z);
  void settle(InteriorEnd end, double deadline_s, Answer& answer);

  PrimalDualSettings settings_;
  Matrix M_;
  Matrix H_;  // Hessian of f
  Vector q_;
  Vector column_scale_;

  Point point_, trial_, direction_;
  Vector r_dual_, r_pri_;  // n: of the last point evaluated
  Vector work_;            // n
  Vector unfinished_;      // n
  AnswerTest test_;
  Matrix newton_, factor_;
  std::vector<Index> support_;  // n
};

/// True when M is symmetric up to the rounding of a product N'(G*N) formed in double.
bool nearly_symmetric(const Matrix& M) {
  const double tolerance =
      static_cast<double>(M.rows()) * std::numeric_limits<double>::epsilon() * M.cwiseAbs().maxCoeff();
  return (M - M.transpose()).cwiseAbs().maxCoeff() <= tolerance;
}

void PrimalDual::on_load(const Problem& problem) {
  Lcp lcp = make_lcp(problem);
  const Index n = lcp.size();
  resize_workspace(n);
  if (settings_.test == FinalTest::kResidual) test_.load(problem);
  q_ = std::move(lcp.q);
  M_ = std::move(lcp.M);
  if (n == 0) return;
  column_scale_ = M_.cwiseAbs().colwise().maxCoeff();
  H_ = M_ + M_.transpose();
  if (nearly_symmetric(M_)) H_ *= 0.5;
}

void PrimalDual::resize_workspace(Index n) {
  for (Point* point : {&point_, &trial_, &direction_}) point->resize(n);
  for (Vector* vector : {&r_dual_, &r_pri_, &work_, &unfinished_}) vector->resize(n);
  newton_.resize(n, n);
  factor_.resize(n, n);
  support_.resize(static_cast<std::size_t>(n));
}

void PrimalDual::set_start() {
  point_.z.setOnes();
  point_.y = q_;
  point_.y.noalias() += M_ * point_.z;
  point_.y = point_.y.cwiseMax(1.0);
  point_.lambda.setOnes();
  point_.kappa = point_.y.cwiseInverse();
}

void PrimalDual::evaluate_residuals(const Point& point) {
  r_dual_ = q_ - point.lambda;
  r_dual_.noalias() += H_ * point.z;
  r_dual_.noalias() -= M_.transpose() * point.kappa;
  r_pri_ = q_ - point.y;
  r_pri_.noalias() += M_ * point.z;
}

/// Norm of (dual, centrality, primal) residual at `point`, for which the residuals were evaluated.
double PrimalDual::residual_norm(const Point& point, double t) const {
  return std::sqrt(r_dual_.squaredNorm() + r_pri_.squaredNorm() +
                   (point.z.array() * point.lambda.array() - 1 / t).matrix().squaredNorm() +
                   (point.y.array() * point.kappa.array() - 1 / t).matrix().squaredNorm());
}

/// Whether point_ meets the absolute tolerances: the Euclidean norm of each residual in the units of q, the surrogate
/// gap in those of z'q. False for NaN. @pre r_pri_ and r_dual_ are those of point_
bool PrimalDual::converged() const {
  return r_pri_.norm() <= settings_.residual_tolerance && r_dual_.norm() <= settings_.residual_tolerance &&
         point_.surrogate_gap() <= settings_.gap_tolerance;
}

/// newton_ (lower triangle) = H + diag(lambda / z) + M' diag(kappa / y) M. False where the time is over.
bool PrimalDual::form_newton_matrix(double deadline_s) {
  const Index n = q_.size();
  for (Index j = 0; j < n; ++j) {
    if (is_late(j, deadline_s)) return false;
    work_.array() = point_.kappa.array() / point_.y.array() * M_.col(j).array();
    auto column = newton_.col(j).tail(n - j);
    column = H_.col(j).tail(n - j);
    column.noalias() += M_.rightCols(n - j).transpose() * work_;
    newton_(j, j) += point_.lambda(j) / point_.z(j);
  }
  return true;
}

/// Factors newton_ into factor_. Where it is not positive definite, multiples of the identity are added, relative to
/// its largest diagonal entry: from the rounding error of the entries to what dominates them. False when none helps.
bool PrimalDual::factor_newton_matrix(double deadline_s, Counters& counters) {
  constexpr double kFirstCorrection = 1e-15;
  constexpr double kCorrectionGrowth = 100.0;
  constexpr double kLastCorrection = 1e3;
  const double largest = newton_.diagonal().cwiseAbs().maxCoeff();
  for (double correction = 0; correction <= kLastCorrection;
       correction = correction > 0 ? correction * kCorrectionGrowth : kFirstCorrection) {
    factor_ = newton_;
    factor_.diagonal().array() += correction * largest;
    ++counters.factorizations;
    if (cholesky_in_place(factor_, deadline_s)) return true;
  }
  return false;
}

/// The Newton step on the perturbed optimality conditions, the slack and the multipliers eliminated. [BV04 (11.55)]
bool PrimalDual::find_direction(double t, double deadline_s, Counters& counters) {
  if (!form_newton_matrix(deadline_s) || !factor_newton_matrix(deadline_s, counters)) return false;
  const auto z = point_.z.array();
  const auto y = point_.y.array();
  work_.array() = 1 / (t * y) - point_.kappa.array() - point_.kappa.array() / y * r_pri_.array();
  direction_.z.array() = 1 / (t * z) - point_.lambda.array() - r_dual_.array();
  direction_.z.noalias() += M_.transpose() * work_;
  factor_.triangularView<Eigen::Lower>().solveInPlace(direction_.z);
  factor_.transpose().triangularView<Eigen::Upper>().solveInPlace(direction_.z);
  direction_.y = r_pri_;
  direction_.y.noalias() += M_ * direction_.z;
  direction_.lambda.array() = 1 / (t * z) - point_.lambda.array() - point_.lambda.array() / z * direction_.z.array();
  direction_.kappa.array() = 1 / (t * y) - point_.kappa.array() - point_.kappa.array() / y * direction_.y.array();
  return direction_.z.allFinite() && direction_.y.allFinite() && direction_.lambda.allFinite() &&
         direction_.kappa.allFinite();
}

/// The longest step <= 1 that keeps the multipliers nonnegative.
double PrimalDual::longest_step() const {
  double s = 1.0;
  for (Index i = 0; i < q_.size(); ++i) {
    if (direction_.lambda(i) < 0) s = std::min(s, -point_.lambda(i) / direction_.lambda(i));
    if (direction_.kappa(i) < 0) s = std::min(s, -point_.kappa(i) / direction_.kappa(i));
  }
  return s;
}

void PrimalDual::step_to_trial(double s) {
  trial_.z = point_.z + s * direction_.z;
  trial_.y = point_.y + s * direction_.y;
  trial_.lambda = point_.lambda + s * direction_.lambda;
  trial_.kappa = point_.kappa + s * direction_.kappa;
}

/// Backtracks until the trial is strictly inside and the residual norm has fallen by the share alpha s; then moves
/// there. False when no step of a length that matters does. On entry the residuals are those of point_, on success the
/// new ones.
bool PrimalDual::line_search(double t) {
  const double norm = residual_norm(point_, t);
  for (double s = kBoundaryFraction * longest_step(); s >= kShortestStep; s *= kBacktracking) {
    step_to_trial(s);
    if (!(trial_.z.minCoeff() > 0 && trial_.y.minCoeff() > 0)) continue;
    if (!(trial_.lambda.minCoeff() > 0 && trial_.kappa.minCoeff() > 0)) continue;  // rounding at the boundary
    evaluate_residuals(trial_);
    if (residual_norm(trial_, t) <= (1 - kDecrease * s) * norm) {
      std::swap(point_, trial_);
      return true;
    }
  }
  return false;
}

InteriorEnd PrimalDual::iterate(double deadline_s, Counters& counters) {
  const double constraints = 2.0 * static_cast<double>(q_.size());
  evaluate_residuals(point_);
  for (;; ++counters.iterations) {
    if (converged()) return InteriorEnd::kConverged;
    if (counters.iterations >= settings_.max_iterations) return InteriorEnd::kIterationLimit;
    if (!(wall_clock_s() < deadline_s)) return InteriorEnd::kTimeLimit;
    const double t = kBarrierFactor * constraints / point_.surrogate_gap();
    if (!std::isfinite(t)) return InteriorEnd::kBreakdown;
    if (!find_direction(t, deadline_s, counters)) {
      return wall_clock_s() < deadline_s ? InteriorEnd::kBreakdown : InteriorEnd::kTimeLimit;
    }
    if (!line_search(t)) return InteriorEnd::kStalled;
  }
}

/// max |min(c_i z_i, w_i)|: c_i z_i is the largest change in w that leaving out z_i would make.
/// Infinity when it is not a number. Leaves w in work_.
double PrimalDual::lcp_residual() {
  work_ = q_;
  work_.noalias() += M_ * point_.z;
  double worst = 0;
  for (Index i = 0; i < q_.size(); ++i) {
    const double residual = std::abs(std::min(column_scale_(i) * point_.z(i), work_(i)));
    if (!(residual <= worst)) worst = std::isfinite(residual) ? residual : std::numeric_limits<double>::infinity();
  }
  return worst;
}

/// The power of two by which the largest entry comes near 1; 1 for zeros.
template <class Entries>
double scale_of(const Entries& entries) {
  const double largest = entries.cwiseAbs().maxCoeff();
  return largest > 0 ? std::exp2(-std::ilogb(largest)) : 1;
}

/// The solution of M z = -q on the rows and columns of the nonzero entries of z, by elimination with complete pivoting
/// of what is scaled to entries of about 1; what depends on the pivots before it, to rounding, or comes after the
/// deadline, stays zero. O(k^3). Spoils factor_, direction_ and work_.
void PrimalDual::finish_on_support(double deadline_s, Vector& z) {
  constexpr double kDependent = 1e-12;
  Index order = 0;
  for (Index i = 0; i < z.size(); ++i) {
    if (z(i) > 0) support_[static_cast<std::size_t>(order++)] = i;
  }
  auto block = factor_.topLeftCorner(order, order);
  auto x = work_.head(order);
  const auto member = [this](Index k) { return support_[static_cast<std::size_t>(k)]; };
  for (Index c = 0; c < order; ++c) {
    for (Index r = 0; r < order; ++r) block(r, c) = M_(member(r), member(c));
  }
  for (Index r = 0; r < order; ++r) {
    const double scale = scale_of(block.row(r));
    block.row(r) *= scale;
    x(r) = -scale * q_(member(r));
  }
  auto scale = direction_.z.head(order);  // of columns
  for (Index c = 0; c < order; ++c) {
    scale(c) = scale_of(block.col(c));
    block.col(c) *= scale(c);
  }
  double first = 0;
  Index rank = 0;
  for (; rank < order; ++rank) {
    const Index left = order - rank;
    Index row = 0;
    Index column = 0;
    const double largest = block.bottomRightCorner(left, left).cwiseAbs().maxCoeff(&row, &column);
    first = std::max(first, largest);
    if (!(largest > kDependent * first) || is_late(rank, deadline_s)) break;
    block.row(rank).swap(block.row(rank + row));
    std::swap(x(rank), x(rank + row));
    block.col(rank).swap(block.col(rank + column));
    std::swap(scale(rank), scale(rank + column));
    std::swap(support_[static_cast<std::size_t>(rank)], support_[static_cast<std::size_t>(rank + column)]);
    for (Index r = rank + 1; r < order; ++r) {
      const double factor = block(r, rank) / block(rank, rank);
      block.row(r).tail(left) -= factor * block.row(rank).tail(left);
      x(r) -= factor * x(rank);
    }
  }
  z.setZero();
  for (Index k = rank; k-- > 0;) {
    x(k) /= block(k, k);
    x.head(k) -= x(k) * block.col(k).head(k);
    z(member(k)) = scale(k) * x(k);
  }
}

/// The z_i below zero become zero, and those whose w_i is become positive: the next support. Spoils work_
void PrimalDual::exchange_negative(Vector& z) {
  work_ = q_;
  work_.noalias() += M_ * z;
  for (Index i = 0; i < z.size(); ++i) z(i) = z(i) == 0 && work_(i) < 0 ? 1 : std::max(z(i), 0.0);
}

/// An interior point has no zeros, and is only as near to w = 0 as its gap: those that the residual takes for zero
/// become so, and where that does not pass, or is not accurate, what remains is solved for; of a bare LCP a few times
/// more, after the exchange of what is negative then. If none of that passes, the former is the answer to a bare LCP, or
/// else the point as it is. @pre answer.z is point_.z, and work_ its w
void PrimalDual::settle(InteriorEnd end, double deadline_s, Answer& answer) {
  constexpr double kAccurate = 1e-9;
  constexpr int kMostExchanges = 10;
  for (Index i = 0; i < q_.size(); ++i) {
    if (column_scale_(i) * answer.z(i) < work_(i)) answer.z(i) = 0;
  }
  const bool is_bare = problem().contact() == nullptr;
  const bool passes = test_.settle(answer, deadline_s);
  if (passes ? !is_bare || test_.backward_error() <= kAccurate : answer.claim != Claim::kNumericalFailure) return;
  const bool stalled = end == InteriorEnd::kStalled;
  unfinished_ = passes ? answer.z : point_.z;
  answer.claim = Claim::kSolved;
  answer.detail = stalled ? "no step reduces the residual further; finished on its support" : "finished on its support";
  for (int exchanges = is_bare ? kMostExchanges : 0;; --exchanges) {
    finish_on_support(deadline_s, answer.z);
    if (test_.settle(answer, deadline_s) || answer.claim == Claim::kUnsolvable) return;
    if (exchanges == 0 || !(wall_clock_s() < deadline_s)) break;
    answer.claim = Claim::kSolved;
    exchange_negative(answer.z);
  }
  answer.z = unfinished_;
  if (!is_bare) return;
  answer.claim = Claim::kSolved;
  answer.detail = stalled ? kAcceptedAsItIs : "";
  test_.settle(answer, deadline_s);
}

void PrimalDual::on_solve(const SolveRequest& request, Answer& answer) {
  answer.counters = {.iterations = 0, .pivots = -1, .factorizations = 0};
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  if (q_.isZero(0)) {  // z = 0 solves it, and max|q| gives no scale to judge another answer by
    answer.claim = Claim::kSolved;
    if (settings_.test == FinalTest::kResidual) test_.settle(answer, deadline_s);  // q may have been rounded to zero
    return;
  }
  set_start();
  const InteriorEnd end = iterate(deadline_s, answer.counters);
  answer.z = point_.z;
  const bool accepted = lcp_residual() <= kAcceptedResidual * q_.cwiseAbs().maxCoeff();
  answer.claim = claim_of(end);
  answer.detail = words_of(end);
  if (end == InteriorEnd::kConverged && !accepted) {
    answer.claim = Claim::kNumericalFailure;
    answer.detail = "converged to a point that does not solve the LCP";
  } else if (end == InteriorEnd::kStalled && accepted) {
    answer.claim = Claim::kSolved;
    answer.detail = kAcceptedAsItIs;
  }
  if (answer.claim == Claim::kSolved && settings_.test == FinalTest::kResidual) settle(end, deadline_s, answer);
}

}  // namespace

SolverDefinition lcpbench_solver_primal_dual() {
  return define_solver<PrimalDual, PrimalDualSettings>(
      {.name = "primal_dual",
       .summary = "primal-dual interior point on the quadratic program of the LCP, dense, the paper's method",
       .source = "Boyd, Vandenberghe: Convex Optimization, 2004, section 11.7; Drumwright, Shell 2012",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
