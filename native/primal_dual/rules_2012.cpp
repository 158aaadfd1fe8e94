#include "native/primal_dual/rules_2012.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/timed_solve.h"
#include "native/primal_dual/cholesky.h"

namespace lcpbench {
namespace {

// The numbers of the code of 2012.
constexpr double kBarrierFactor = 10;
constexpr double kDecrease = 0.05;
constexpr double kBacktracking = 0.5;
constexpr double kBoundaryFraction = 0.99;  // [BV04 p. 613]
constexpr double kShortestStep = 0x1p-52;

/// An answer is accepted at once when min z, min w >= -kAccepted and |z'w| < kAccepted: the square root of the unit
/// round-off of 2^-52.
constexpr double kAccepted = 0x1p-26;

}  // namespace

const char* words_of(InteriorEnd end) {
  switch (end) {
    case InteriorEnd::kStalled: return "no step reduces the residual further";
    case InteriorEnd::kBreakdown: return "the Newton system could not be solved";
    default: return "";
  }
}

Claim claim_of(InteriorEnd end) {
  switch (end) {
    case InteriorEnd::kAccepted:
    case InteriorEnd::kConverged: return Claim::kSolved;
    case InteriorEnd::kIterationLimit: return Claim::kIterationLimit;
    case InteriorEnd::kTimeLimit: return Claim::kTimeLimit;
    case InteriorEnd::kStalled:
    case InteriorEnd::kBreakdown: break;
  }
  return Claim::kNumericalFailure;
}

void FeasibleProgram::resize(Index n, Index m) {
  for (Matrix* matrix : {&P, &newton_, &factor_}) matrix->resize(n, n);
  A.resize(m, n);
  for (Vector* vector : {&p, &r_dual_, &dx_, &trial_x_}) vector->resize(n);
  for (Vector* vector : {&c, &slack_, &lambda_, &r_cent_, &dlambda_, &trial_lambda_, &weight_}) vector->resize(m);
}

/// Sets slack_ and both residuals for x and lambda.
void FeasibleProgram::evaluate(const Vector& x, const Vector& lambda, double t) {
  slack_ = c;
  slack_.noalias() += A * x;
  r_dual_ = p;
  r_dual_.noalias() += P * x;
  r_dual_.noalias() -= A.transpose() * lambda;
  r_cent_ = lambda.cwiseProduct(slack_).array() - 1 / t;
}

double FeasibleProgram::residual_norm() const { return std::sqrt(r_dual_.squaredNorm() + r_cent_.squaredNorm()); }

/// Newton's step on both residuals, the multipliers eliminated. [BV04 (11.54)]
bool FeasibleProgram::find_direction(Counters& counters) {
  const Index n = P.rows();
  weight_ = lambda_.cwiseQuotient(slack_);
  for (Index j = 0; j < n; ++j) {
    dlambda_ = weight_.cwiseProduct(A.col(j));
    newton_.col(j).tail(n - j) = P.col(j).tail(n - j);
    newton_.col(j).tail(n - j).noalias() += A.rightCols(n - j).transpose() * dlambda_;
  }
  if (!factor_with_corrections(newton_, factor_, counters)) return false;
  dlambda_ = r_cent_.cwiseQuotient(slack_);
  dx_ = -r_dual_;
  dx_.noalias() -= A.transpose() * dlambda_;
  solve_with_factor(factor_, dx_);
  trial_lambda_.noalias() = A * dx_;
  dlambda_ = -dlambda_ - weight_.cwiseProduct(trial_lambda_);
  return dx_.allFinite() && dlambda_.allFinite();
}

/// Backtracks until every constraint holds strictly and the residual norm has fallen by the share alpha s, and moves
/// there. False when no step does.
bool FeasibleProgram::line_search(double t, Vector& x) {
  const double norm = residual_norm();
  double longest = 1;
  for (Index i = 0; i < lambda_.size(); ++i) {
    if (dlambda_(i) < 0) longest = std::min(longest, -lambda_(i) / dlambda_(i));
  }
  for (double s = kBoundaryFraction * longest; s >= kShortestStep; s *= kBacktracking) {
    trial_x_ = x + s * dx_;
    trial_lambda_ = lambda_ + s * dlambda_;
    evaluate(trial_x_, trial_lambda_, t);
    if (!(slack_.minCoeff() > 0 && trial_lambda_.minCoeff() > 0)) continue;
    if (!(residual_norm() <= (1 - kDecrease * s) * norm)) continue;
    x.swap(trial_x_);
    lambda_.swap(trial_lambda_);
    return true;
  }
  return false;
}

InteriorEnd FeasibleProgram::minimize(const Rules2012Settings& settings, double deadline_s,
                                      const std::function<bool(const Vector&)>& accepts, Vector& x,
                                      Counters& counters) {
  const auto constraints = static_cast<double>(A.rows());
  slack_ = c;
  slack_.noalias() += A * x;
  lambda_ = slack_.cwiseInverse();
  for (std::int64_t iteration = 0;; ++iteration, ++counters.iterations) {
    if (accepts(x)) return InteriorEnd::kAccepted;
    if (iteration >= settings.max_iterations) return InteriorEnd::kIterationLimit;
    if (!(wall_clock_s() < deadline_s)) return InteriorEnd::kTimeLimit;
    const double gap = slack_.dot(lambda_);
    const double t = kBarrierFactor * constraints / gap;
    evaluate(x, lambda_, t);
    if (gap <= settings.gap_tolerance && r_dual_.norm() <= settings.residual_tolerance) return InteriorEnd::kConverged;
    if (!std::isfinite(t) || !find_direction(counters)) return InteriorEnd::kBreakdown;
    if (!line_search(t, x)) return InteriorEnd::kStalled;
  }
}

void PrimalDual2012::load(const Lcp& lcp) {
  lcp_ = lcp;
  const Index n = lcp.size();
  program_.resize(n, 2 * n);
  program_.P = 0.5 * (lcp.M + lcp.M.transpose());
  program_.p = 0.5 * lcp.q;
  program_.A.topRows(n).setIdentity();
  program_.A.bottomRows(n) = lcp.M;
  program_.c.head(n).setZero();
  program_.c.tail(n) = lcp.q;
  phase_1_.resize(n + 1, 2 * n);
  phase_1_.P.setZero();
  phase_1_.p.setZero();
  phase_1_.p(n) = 1;
  phase_1_.A.leftCols(n) = program_.A;
  phase_1_.A.col(n).setOnes();
  phase_1_.c = program_.c;
  start_.resize(n + 1);
  w_.resize(n);
  best_.resize(n);
}

/// The code's test of z, which also keeps the best z so far.
bool PrimalDual2012::accepts(const Vector& z) {
  w_ = lcp_.q;
  w_.noalias() += lcp_.M * z;
  const double product = std::abs(z.dot(w_));
  if (product < best_product_) {
    best_product_ = product;
    best_ = z;
  }
  return z.minCoeff() >= -kAccepted && w_.minCoeff() >= -kAccepted && product < kAccepted;
}

/// Phase I: from z = 0, the least violation of all constraints, until none is left. Leaves z in start_. kAccepted: z is
/// strictly feasible.
InteriorEnd PrimalDual2012::find_start(const Rules2012Settings& settings, double deadline_s, Counters& counters) {
  const Index n = lcp_.size();
  start_.setZero();
  start_(n) = 1 + std::max(0.0, -lcp_.q.minCoeff());
  return phase_1_.minimize(
      settings, deadline_s, [n](const Vector& x) { return x(n) < 0; }, start_, counters);
}

void PrimalDual2012::solve(const Rules2012Settings& settings, double deadline_s, Answer& answer) {
  const Index n = lcp_.size();
  best_.setZero();
  best_product_ = std::numeric_limits<double>::infinity();
  InteriorEnd end = InteriorEnd::kAccepted;
  if (n > 0 && !accepts(best_)) {
    best_product_ = std::numeric_limits<double>::infinity();
    end = find_start(settings, deadline_s, answer.counters);
    answer.z = start_.head(n);
    if (end == InteriorEnd::kAccepted) {
      end = program_.minimize(
          settings, deadline_s, [this](const Vector& z) { return accepts(z); }, answer.z, answer.counters);
    } else {
      accepts(answer.z);
      if (end == InteriorEnd::kConverged) end = InteriorEnd::kStalled;
    }
  }
  answer.z = best_;
  answer.claim = claim_of(end);
  answer.detail = words_of(end);
}

}  // namespace lcpbench
