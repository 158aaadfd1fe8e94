#include "native/contact_ipm/contact_ipm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/proximal_newton/proximal_newton.h"

namespace lcpbench {
namespace {

/// Of its cone, which the friction of the start takes.
constexpr double kUsedCone = 0.8;
/// Of the step to the nearest boundary. [Mehrotra 1992]
constexpr double kBoundaryFraction = 0.995;
/// Where the corrector's step is shorter than the first, the step is repeated without second-order terms, towards at
/// least this part of the mean product.
constexpr double kShortStep = 0.1;
constexpr double kCentring = 0.8;
/// So many short steps in a row, among the first kFirstSteps or the first kFurtherSteps after a start: it was too near to
/// the boundary. The path begins anew then, up to twice, with slacks and impulses so many times as large. On 77 captured
/// steps with mass ratios of 1e4 and 1e6 this takes 0.59 of the factorizations.
constexpr int kMostShortSteps = 4;
constexpr std::int64_t kFirstSteps = 10, kFurtherSteps = 6;
constexpr std::array kLargerStarts{30.0, 900.0};
/// So many steps without the residual falling to a half, or a shorter step than this: the path folds.
constexpr std::int64_t kMostIdleSteps = 18;
constexpr double kShortestStep = 1e-8;
/// The compliance with which proximal problems begin then, see ProximalNewton::kFirstShare.
constexpr double kShareAfterFold = 2e-3;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Fitted to times of scenes: work for each coordinate of a contact and for each pair, in one step.
constexpr double kWorkOfCoordinate = 100, kWorkOfPair = 180;

/// Mehrotra's predictor-corrector method for contacts with friction, also large sparse ones.
///
/// A *pair* is a multiplier x and a slack s, both positive, whose product falls to zero: f_N and w_N of a contact; each
/// f_D,k and w_D,k = lambda + d_k'w_T; lambda and mu f_N - sum f_D. All impulses are kept in one unit, so that the
/// products are energies, which all tend to one number: with a unit for each contact a heavy body on a light one takes
/// many more steps. A Newton step for all pairs and the momentum, G (u - v) = J f, is eliminated contact by contact:
/// the change of a contact's impulses is a 3 x 3 matrix K, not symmetric, times that of its velocity, and G + J'K J, of
/// the order of the velocity, is factored by NewtonMatrix. Without friction the problem is convex. With it the path
/// that the products follow may fold: the steps become short. Then ProximalNewton goes on from the best impulses.
/// [Mehrotra 1992; Wright 1997, ch. 10;
/// docs/reference/solvers/contact_ipm.md]
///
/// kSolved: as of ProximalNewton.
class ContactIpm final : public ProximalNewton {
 public:
  explicit ContactIpm(const ProximalNewtonSettings& settings) : ProximalNewton(settings) {}
  const Capabilities& capabilities() const override;

 private:
  struct Contact {
    const FrictionPolygon* polygon = nullptr;  ///< nullptr: no friction impulse
    Index normal = 0;                          ///< pair of the normal; those of the edges, and that of lambda follow
    double mu = 0;
    double stops = 0, stops_slip = 0;        ///< x that stops 1 m/s of approach, of slip, if alone
    double yields = 0, compliance_t = 0;     ///< r_n, r_t

    Index edges() const { return polygon == nullptr ? 0 : polygon->edges(); }
    Index edge(Index k) const { return normal + 1 + k; }
    Index lambda() const { return normal + 1 + edges(); }
  };
  /// The elimination of a contact. With y = w_T and w = (w_N, y), changes d: dx_N = at_rest - by_normal dw_N;
  /// d lambda = lambda_at_rest - lambda_by_normal dx_N - lambda_by_slip dy; df_T = friction_at_rest +
  /// friction_by_normal dx_N - friction_by_slip dy.
  struct Elimination {
    double by_normal = 0, at_rest = 0;
    double lambda_by_normal = 0, lambda_by_edges = 0, lambda_divisor = 1, lambda_at_rest = 0;
    Eigen::Vector2d edges_sum, friction_by_normal, friction_at_rest;
    Eigen::Matrix2d friction_by_slip, softening;  ///< softening: (I + r_t friction_by_slip)^-1
  };

  void on_load(const Problem& problem) override;
  void begin(const Vector* start, double error) override;
  bool run(double work, double deadline_s) override;

  double mehrotra_step();
  bool is_jammed(double length);
  void leave_path();
  void set_start(double scale);
  Eigen::Vector3d velocity(std::size_t contact) const;
  void evaluate();
  bool factor();
  void eliminate(std::size_t contact);
  void find_direction(Vector& dx, Vector& ds);
  Eigen::Vector3d constant_impulse(std::size_t contact);
  double longest_step(const Vector& dx, const Vector& ds) const;

  std::vector<Contact> contacts_;
  std::vector<Elimination> eliminations_;
  Vector x_, s_;    // of each pair
  Vector slack_residual_;  // of each pair: s as the impulses and velocities give it, less s
  Vector target_;   // what x s is to become, less x s
  Vector dx_, ds_, predicted_dx_, predicted_ds_;
  double impulse_ = 1;  ///< of a unit of x
  double work_of_step_ = 0;
  bool is_on_path_ = false;
  int short_steps_ = 0;       ///< the last ones in a row
  std::size_t restarts_ = 0;  ///< of the path
};

void ContactIpm::on_load(const Problem& problem) {
  ProximalNewton::on_load(problem);
  if (!refusal_.empty()) return;
  contacts_.assign(rows_.size(), {});
  eliminations_.resize(rows_.size());
  const Vector& diagonal = state_.columns.diagonal;
  const double largest = diagonal.size() > 0 ? diagonal.maxCoeff() : 0;
  const auto inverse = [largest](double entry) { return 1 / (entry > 0 ? entry : largest > 0 ? largest : 1); };
  // The geometric mean of 1 / M_nn: about what stops 1 m/s at a contact.
  double logarithms = 0;
  for (Index i = 0; i < state_.contacts; ++i) logarithms += std::log(inverse(diagonal(i)));
  impulse_ = std::exp(logarithms / static_cast<double>(std::max<Index>(state_.contacts, 1)));
  Index pairs = 0;
  work_of_step_ = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const auto index = static_cast<Index>(i);
    Contact& contact = contacts_[i];
    contact.normal = pairs;
    contact.mu = state_.mu(index);
    contact.stops = inverse(diagonal(index)) / impulse_;
    if (state_.compliance.size() > 0) contact.yields = state_.compliance(index);
    if (contact.mu > 0) contact.polygon = polygons_.of(i);
    if (contact.polygon != nullptr) {
      const SignedFriction& own = state_.frictions[static_cast<std::size_t>(rows_[i].friction)];
      contact.stops_slip = inverse(diagonal.segment(own.first_column, own.directions).maxCoeff()) / impulse_;
      if (state_.compliance_t.size() > 0) contact.compliance_t = state_.compliance_t(index);
    }
    const Index own_pairs = contact.polygon == nullptr ? 1 : contact.edges() + 2;
    pairs += own_pairs;
    work_of_step_ +=
        kWorkOfCoordinate * static_cast<double>(rows_[i].J.cols()) + kWorkOfPair * static_cast<double>(own_pairs);
  }
  for (Vector* pair : {&x_, &s_, &slack_residual_, &target_, &dx_, &ds_, &predicted_dx_, &predicted_ds_}) {
    pair->resize(pairs);
  }
}

void ContactIpm::begin(const Vector* /*start*/, double error) {
  ProximalNewton::begin(nullptr, error);
  if (!refusal_.empty()) return;
  is_on_path_ = true;
  short_steps_ = 0;
  restarts_ = 0;
  set_start(1);
  evaluate();
}

/// Steps along the path until the residual is small enough; where the path folds, proximal problems go on.
bool ContactIpm::run(double work, double deadline_s) {
  const double until = best_.work + work;
  while (is_on_path_) {
    if (!(best_.work < until)) break;
    const auto stops = [&](Claim claim) {
      end(claim, deadline_s);
      return true;
    };
    if (!(wall_clock_s() < deadline_s)) return stops(Claim::kTimeLimit);
    if (result_.counters.iterations >= settings_.max_iterations) return stops(Claim::kIterationLimit);
    ++result_.counters.iterations;
    const double length = mehrotra_step();
    bool goes_on = length > 0;
    if (is_jammed(length)) {
      goes_on = true;
      short_steps_ = 0;
      now_.step_then = result_.counters.iterations;
      set_start(kLargerStarts[restarts_++]);
      evaluate();
    } else if (goes_on) {
      evaluate();
      note();
    }
    const bool has_ended = best_.residual <= best_.tolerance && end(Claim::kNumericalFailure, deadline_s);
    if (has_ended && result_.claim != Claim::kNumericalFailure) return true;
    if (has_ended || !goes_on || result_.counters.iterations - now_.step_then > kMostIdleSteps) leave_path();
  }
  return ProximalNewton::run(until - best_.work, deadline_s);
}

/// Mehrotra's predictor and corrector from (x, s). @returns its length; 0: the path ends
double ContactIpm::mehrotra_step() {
  if (!factor()) return 0;
  const auto pairs = static_cast<double>(x_.size());
  const double mean = x_.dot(s_) / pairs;  // mu of the paper
  // The predictor aims at products of zero. How far it can go tells how much to centre.
  target_ = -x_.cwiseProduct(s_);
  find_direction(predicted_dx_, predicted_ds_);
  const double reach = std::min(1.0, longest_step(predicted_dx_, predicted_ds_));
  double after = 0;
  for (Index i = 0; i < x_.size(); ++i) {
    after += (x_(i) + reach * predicted_dx_(i)) * (s_(i) + reach * predicted_ds_(i)) / pairs;
  }
  const double ratio = std::clamp(after / mean, 0.0, 1.0), centring = ratio * ratio * ratio;  // sigma of the paper
  // The corrector, with the same factors, aims at products of sigma mu, and takes the second-order terms along.
  target_.array() += centring * mean - predicted_dx_.array() * predicted_ds_.array();
  find_direction(dx_, ds_);
  double length = std::min(1.0, kBoundaryFraction * longest_step(dx_, ds_));
  if (length < kShortStep) {
    target_.array() = std::max(centring, kCentring) * mean - x_.array() * s_.array();
    find_direction(dx_, ds_);
    length = std::min(1.0, kBoundaryFraction * longest_step(dx_, ds_));
  }
  if (!(length > kShortestStep) || !step_.allFinite()) return 0;
  x_ += length * dx_;
  s_ += length * ds_;
  now_at_.velocity += length * step_;
  return length;
}

/// Whether the path is to begin anew after a step of this length, from a larger start.
bool ContactIpm::is_jammed(double length) {
  short_steps_ = length < kShortStep ? short_steps_ + 1 : 0;
  const std::int64_t most = kFirstSteps + kFurtherSteps * static_cast<std::int64_t>(restarts_);
  return short_steps_ >= kMostShortSteps && restarts_ < kLargerStarts.size() && result_.counters.iterations <= most;
}

/// The best impulses become the first ones of proximal problems.
void ContactIpm::leave_path() {
  is_on_path_ = false;
  result_.detail.clear();
  now_.halved = best_.residual;
  now_.step_then = result_.counters.iterations;
  if (best_.residual < kInfinity) {
    state_.impulse = best_impulse_;
    state_.recompute_velocity();
    net_impulses(state_, from_);
    from_velocity_ = state_.u;
    now_.share = kShareAfterFold;
  }
  begin_proximal();
}

/// The velocity before the impact, and at each contact the impulses that would stop it alone, as far as friction can.
/// Slacks are at least the largest approach or slip, and normal impulses what stops it, but where a contact is open by
/// more: smaller ones take more steps. Both are `scale` times as large.
void ContactIpm::set_start(double scale) {
  now_at_.velocity = state_.u0;
  const double least = scale * state_.speed;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    const Eigen::Vector3d w = velocity(i);
    s_(contact.normal) = std::max(std::abs(w(0)), least);
    x_(contact.normal) = contact.stops * least * (least / s_(contact.normal));
    if (contact.polygon == nullptr) continue;
    const Eigen::Vector2d slip = w.tail<2>();
    const auto edges = static_cast<double>(contact.edges());
    const double most = contact.mu * x_(contact.normal);  // sum of x of the edges
    const double part = std::min(1.0, kUsedCone / 2 * most / (contact.stops_slip * slip.norm()));
    double lambda = least, sum = 0;
    for (Index k = 0; k < contact.edges(); ++k) {
      const double along = -contact.polygon->direction(k).dot(slip);
      lambda = std::max(lambda, along + least);
      const double stop = 2 / edges * part * contact.stops_slip * along;
      x_(contact.edge(k)) = kUsedCone / 2 * most / edges + std::max(stop, 0.0);
      sum += x_(contact.edge(k));
    }
    for (Index k = 0; k < contact.edges(); ++k) {
      s_(contact.edge(k)) = std::max(lambda + contact.polygon->direction(k).dot(slip), least);
    }
    x_(contact.lambda()) = lambda;
    s_(contact.lambda()) = std::max(most - sum, 0.1 * most);
  }
}

/// The contact's velocities, without compliance.
Eigen::Vector3d ContactIpm::velocity(std::size_t contact) const {
  const auto i = static_cast<Index>(contact);
  Eigen::Vector3d w = rows_[contact].velocity(now_at_.velocity);
  if (state_.offset.size() > 0) w(0) += state_.offset(i);
  if (state_.offset_t.size() > 0) w.tail<2>() += state_.offset_t.segment<2>(2 * i);
  return w;
}

/// The impulses, and the residuals of the momentum's balance and of the slacks.
void ContactIpm::evaluate() {
  change_ = now_at_.velocity - state_.u0;
  now_at_.momentum.noalias() = matrix_.G() * change_;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    auto impulse = now_at_.impulse.col(static_cast<Index>(i));
    impulse.setZero();
    impulse(0) = impulse_ * x_(contact.normal);
    double sum = 0;
    for (Index k = 0; k < contact.edges(); ++k) {
      impulse.tail<2>() += impulse_ * x_(contact.edge(k)) * contact.polygon->direction(k);
      sum += x_(contact.edge(k));
    }
    rows_[i].add_momentum(-impulse, now_at_.momentum);
    const Eigen::Vector3d w = velocity(i);
    slack_residual_(contact.normal) = w(0) + contact.yields * impulse(0) - s_(contact.normal);
    if (contact.polygon == nullptr) continue;
    const Eigen::Vector2d slip = w.tail<2>() + contact.compliance_t * impulse.tail<2>();
    const Index lambda = contact.lambda();
    for (Index k = 0; k < contact.edges(); ++k) {
      slack_residual_(contact.edge(k)) = x_(lambda) + contact.polygon->direction(k).dot(slip) - s_(contact.edge(k));
    }
    slack_residual_(lambda) = contact.mu * x_(contact.normal) - sum - s_(lambda);
  }
}

/// What depends on x and s alone, and K.
void ContactIpm::eliminate(std::size_t index) {
  const Contact& contact = contacts_[index];
  Elimination& of = eliminations_[index];
  Eigen::Matrix3d& K = now_at_.slope[index];
  const double x = x_(contact.normal);
  of.by_normal = x / (s_(contact.normal) + contact.yields * impulse_ * x);
  K.setZero();
  K(0, 0) = impulse_ * of.by_normal;
  if (contact.polygon == nullptr) return;
  double sum = 0;
  of.edges_sum.setZero();
  of.friction_by_slip.setZero();
  for (Index k = 0; k < contact.edges(); ++k) {
    const double weight = x_(contact.edge(k)) / s_(contact.edge(k));
    const Eigen::Vector2d direction = contact.polygon->direction(k);
    sum += weight;
    of.edges_sum += weight * direction;
    of.friction_by_slip += weight * direction * direction.transpose();
  }
  const double lambda = x_(contact.lambda());
  of.lambda_divisor = s_(contact.lambda()) + lambda * sum;
  of.lambda_by_normal = contact.mu * lambda / of.lambda_divisor;
  of.lambda_by_edges = lambda / of.lambda_divisor;
  of.friction_by_slip -= of.lambda_by_edges * of.edges_sum * of.edges_sum.transpose();
  of.friction_by_slip *= impulse_;
  of.friction_by_normal = impulse_ * of.lambda_by_normal * of.edges_sum;
  of.softening = Eigen::Matrix2d::Identity();
  if (contact.compliance_t > 0) {
    of.softening = (of.softening + contact.compliance_t * of.friction_by_slip).inverse().eval();
  }
  K.bottomLeftCorner<2, 1>() = of.by_normal * of.softening * of.friction_by_normal;
  K.bottomRightCorner<2, 2>() = of.softening * of.friction_by_slip;
}

bool ContactIpm::factor() {
  for (std::size_t i = 0; i < contacts_.size(); ++i) eliminate(i);
  ++result_.counters.factorizations;
  const bool has_factors = matrix_.factor(now_at_.slope);
  best_.work += matrix_.work() + work_of_step_;
  return has_factors;
}

/// The Newton step towards products x s + target_ and residuals of zero. The velocity's is step_.
void ContactIpm::find_direction(Vector& dx, Vector& ds) {
  step_ = -now_at_.momentum;
  for (std::size_t i = 0; i < contacts_.size(); ++i) rows_[i].add_momentum(constant_impulse(i), step_);
  matrix_.solve(step_);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    const Elimination& of = eliminations_[i];
    const Index normal = contact.normal, lambda = contact.lambda();
    const Eigen::Vector3d w = rows_[i].velocity(step_);
    dx(normal) = of.at_rest - of.by_normal * w(0);
    ds(normal) = w(0) + contact.yields * impulse_ * dx(normal) + slack_residual_(normal);
    if (contact.polygon == nullptr) continue;
    Eigen::Vector2d slip = w.tail<2>();
    if (contact.compliance_t > 0) {
      slip += contact.compliance_t * of.softening *
              (of.friction_at_rest + dx(normal) * of.friction_by_normal - of.friction_by_slip * slip);
    }
    dx(lambda) = of.lambda_at_rest - of.lambda_by_normal * dx(normal) - of.lambda_by_edges * of.edges_sum.dot(slip);
    double sum = 0;
    for (Index k = 0; k < contact.edges(); ++k) {
      const Index edge = contact.edge(k);
      ds(edge) = dx(lambda) + contact.polygon->direction(k).dot(slip) + slack_residual_(edge);
      dx(edge) = (target_(edge) - x_(edge) * ds(edge)) / s_(edge);
      sum += dx(edge);
    }
    ds(lambda) = contact.mu * dx(normal) - sum + slack_residual_(lambda);
  }
}

/// The change of the contact's impulses towards target_, if its velocity stays.
Eigen::Vector3d ContactIpm::constant_impulse(std::size_t index) {
  const Contact& contact = contacts_[index];
  Elimination& of = eliminations_[index];
  const Index normal = contact.normal, lambda = contact.lambda();
  of.at_rest = (target_(normal) - x_(normal) * slack_residual_(normal)) /
               (s_(normal) + contact.yields * impulse_ * x_(normal));
  Eigen::Vector3d impulse(impulse_ * of.at_rest, 0, 0);
  if (contact.polygon == nullptr) return impulse;
  double sum = 0;
  Eigen::Vector2d along = Eigen::Vector2d::Zero();
  for (Index k = 0; k < contact.edges(); ++k) {
    const Index edge = contact.edge(k);
    const double own = (target_(edge) - x_(edge) * slack_residual_(edge)) / s_(edge);
    sum += own;
    along += own * contact.polygon->direction(k);
  }
  of.lambda_at_rest =
      (target_(lambda) - x_(lambda) * slack_residual_(lambda)) / of.lambda_divisor + of.lambda_by_edges * sum;
  of.friction_at_rest = impulse_ * (along - of.lambda_at_rest * of.edges_sum);
  impulse.tail<2>() = of.softening * (of.friction_at_rest + of.at_rest * of.friction_by_normal);
  return impulse;
}

double ContactIpm::longest_step(const Vector& dx, const Vector& ds) const {
  if (dx.size() == 0) return kInfinity;
  const auto steepest = [](const Vector& change, const Vector& of) {
    return (-change.array() / of.array()).maxCoeff();
  };
  return 1 / std::max({steepest(dx, x_), steepest(ds, s_), 0.0});
}

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .compliance = true,
    .guarantees = "none with friction: the path may fold, and Newton's steps need not converge",
    .obeys_time_limit = true,
    .allocation_free = true};

const Capabilities& ContactIpm::capabilities() const { return kCapabilities; }

}  // namespace

std::unique_ptr<BudgetedSolver> make_contact_ipm() { return std::make_unique<ContactIpm>(ProximalNewtonSettings{}); }

SolverDefinition lcpbench_solver_contact_ipm() {
  return define_solver<ContactIpm, ProximalNewtonSettings>(
      {.name = "contact_ipm",
       .summary =
           "predictor-corrector interior point on the contacts with their friction, then proximal_newton; sparse",
       .source = "Mehrotra 1992, On the implementation of a primal-dual interior point method",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
