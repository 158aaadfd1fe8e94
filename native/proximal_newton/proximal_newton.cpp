#include "native/proximal_newton/proximal_newton.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <variant>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// The factors of the added compliance after a proximal problem that ended in a few steps, and after one that did not
/// end.
constexpr double kStiffer = 0.7, kSofter = 2;
/// Tangents get so many times the compliance of the normal: Newton's steps then fail less.
constexpr double kTangentialShare = 3;
constexpr int kFewSteps = 6, kMostSteps = 15;
/// A proximal problem is solved if what is left is at most this part of its change of velocity, in the norm of G.
constexpr double kInexact = 0.5;
/// What is left has to fall by this part of itself times the step's length, which is halved down to the second.
constexpr double kLeastFall = 1e-4, kShortestStep = 0x1p-6;
/// So many steps in which the residual does not fall to a half: the method wanders.
constexpr std::int64_t kMostIdleSteps = 1500;
/// Softness is a compliance that all contacts have for a while, over the mean M_nn. Where the method wanders it becomes
/// 1, and is multiplied by kHarder again and again, until it is less than kLeastSoftness and becomes 0: each time after
/// kMostIdleSteps, or as soon as a proximal problem is solved with share |f - f'| <= kLittle softness |f|: f - f' then
/// changes the solution less than the softness does.
constexpr double kHarder = 0.1, kLeastSoftness = 1e-8, kLittle = 0.3;
/// If no error was stated, a last proximal problem has this part of the share: its answer is near rounding.
constexpr double kLast = 0.1;

/// Fitted to times of made problems: the work of respond() for each coordinate of a contact, and that of note() as a
/// multiple of work_of_residual().
constexpr double kWorkOfCoordinate = 50, kWorkOfNote = 2;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A Ginv of more coordinates takes more than a second to invert, in 113 bits and in double, and nothing stops it.
constexpr Index kLargestPrecise = 100, kLargestInverted = 1000;

/// Whether Ginv is inverted within a second: a large one only in double.
bool is_quickly_inverted(const Matrix& Ginv) {
  if (Ginv.rows() <= kLargestPrecise) return true;
  if (Ginv.rows() > kLargestInverted) return false;
  const Eigen::LLT<Matrix> factors(Ginv);
  return factors.info() == Eigen::Success &&
         is_far_from_singular(Ginv, factors.solve(Matrix::Identity(Ginv.rows(), Ginv.cols())), InverseProof::kRegular);
}

/// The inertia with a G; nothing if it came as factors or as an inverse and double does not prove it regular. A given G
/// is not tested. O(ngc^3) unless G is given
std::optional<Inertia> regular_inertia(const Inertia& inertia) {
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    const Matrix G = inverse_inertia(DenseInertia{inverse->Ginv});
    const bool moves_all = inverse->Ginv.rows() == 0 || inverse->Ginv.diagonal().minCoeff() > 0;
    if (!moves_all || !is_far_from_singular(inverse->Ginv, G, InverseProof::kRegular)) return {};
    return DenseInertia{G};
  }
  std::vector<double> work;
  const auto* factors = std::get_if<FactoredInertia>(&inertia);
  const bool is_regular =
      factors == nullptr || (factors->X.cols() >= factors->X.rows() && is_far_from_dependent(*factors, work));
  return is_regular ? std::optional(inertia) : std::nullopt;
}

}  // namespace

void ProximalNewton::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  result_.reserve(problem);
  refusal_.clear();
  if (const auto* given = std::get_if<InverseInertia>(&contact.inertia); given && !is_quickly_inverted(given->Ginv)) {
    refusal_ = "it needs G, and takes long to invert a Ginv that is nearly singular or of more than " +
               std::to_string(kLargestInverted) + " coordinates";
    return;
  }
  const std::optional<Inertia> inertia = regular_inertia(contact.inertia);
  if (!inertia) {
    refusal_ = "it needs an inertia of full rank";
    return;
  }
  state_.load(problem);
  if (const Index outside = find_contact_rows(state_, rows_); outside >= 0) {
    refusal_ = "contact " + std::to_string(outside) + ": its friction directions are not those of a regular polygon";
    return;
  }
  work_of_response_ = 0;
  for (const ContactRows& rows : rows_) work_of_response_ += kWorkOfCoordinate * static_cast<double>(rows.J.cols());
  polygons_.find(state_);
  matrix_.load(*inertia, rows_);
  load_test(problem);
  for (Response* response : {&now_at_, &next_at_}) {
    response->impulse.setZero(3, state_.contacts);
    response->slope.resize(rows_.size());
    for (Vector* vector : {&response->velocity, &response->left, &response->momentum}) vector->resize(coordinates());
  }
  for (Vector* vector : {&from_velocity_, &step_, &change_}) vector->resize(coordinates());
  from_.resize(3, state_.contacts);
  compliance_.resize(3, state_.contacts);
  pull_.resize(3, state_.contacts);
  if (state_.contacts > 0) mean_normal_ = state_.columns.diagonal.head(state_.contacts).mean();
  best_impulse_.resize(state_.impulse.size());
}

void ProximalNewton::begin(const Vector* start, double error) {
  begin_result({.iterations = 0, .pivots = -1, .factorizations = 0});
  now_ = {.is_last = error > 0};
  best_ = {.tolerance = error > 0 ? error : settings_.tolerance,
           .accept_residual = error > 0 ? error : std::max(settings_.tolerance, kAcceptedResidual)};
  if (!refusal_.empty()) return;
  test_.allow(error);
  best_impulse_.setZero();
  from_.setZero();
  from_velocity_ = state_.u0;
  if (start != nullptr && start->size() == problem().size() && start->allFinite()) {
    state_.set_impulses(*start);
    from_velocity_ = state_.u;
    net_impulses(state_, from_);
  }
  begin_proximal();
  if (!(now_at_.size < kInfinity)) {  // the start is so large that its norms are beyond double
    from_.setZero();
    from_velocity_ = state_.u0;
    begin_proximal();
  }
  note();
}

void ProximalNewton::begin_proximal() {
  const double soft = now_.softness > 0 ? now_.softness * mean_normal_ : 0;  // the mean may be beyond double
  for (Index i = 0; i < state_.contacts; ++i) {
    const Index friction = rows_[static_cast<std::size_t>(i)].friction;
    const auto set = [&](Index row, double added) {
      compliance_(row, i) = added + soft;
      pull_(row, i) = added * from_(row, i);
    };
    set(0, now_.share * state_.columns.diagonal(i));
    if (friction < 0) continue;
    const SignedFriction& own = state_.frictions[static_cast<std::size_t>(friction)];
    const double largest = state_.columns.diagonal.segment(own.first_column, own.directions).maxCoeff();
    for (const Index tangent : {1, 2}) set(tangent, kTangentialShare * now_.share * largest);
  }
  now_.steps = 0;
  now_at_.velocity = from_velocity_;
  respond(now_at_);
}

/// The impulses of one contact at a velocity, and their slope.
void ProximalNewton::respond(std::size_t index, Response& to) const {
  const ContactRows& rows = rows_[index];
  const FrictionPolygon* const polygon = polygons_.of(index);
  const auto i = static_cast<Index>(index);
  Eigen::Vector3d w = rows.velocity(to.velocity);
  auto impulse = to.impulse.col(i);
  Eigen::Matrix3d& slope = to.slope[index];
  impulse.setZero();
  slope.setZero();
  if (state_.offset.size() > 0) w(0) += state_.offset(i);
  const double yields = compliance_(0, i) + (state_.compliance.size() > 0 ? state_.compliance(i) : 0);
  const double normal = (pull_(0, i) - w(0)) / yields;
  if (!(yields > 0) || !(normal > 0)) return;
  impulse(0) = normal;
  slope(0, 0) = 1 / yields;
  if (polygon == nullptr) return;
  if (state_.offset_t.size() > 0) w.tail<2>() += state_.offset_t.segment<2>(2 * i);
  const double slides = compliance_(1, i) + (state_.compliance_t.size() > 0 ? state_.compliance_t(i) : 0);
  if (!(slides > 0)) return;
  const Eigen::Vector2d free = (pull_.col(i).tail<2>() - w.tail<2>()) / slides;
  const FrictionPolygon::Nearest nearest = polygon->nearest(free, state_.mu(i) * normal);
  impulse.tail<2>() = nearest.point;
  slope.bottomRightCorner<2, 2>() = nearest.slope / slides;
  slope.bottomLeftCorner<2, 1>() = state_.mu(i) / yields * nearest.growth;
}

/// All of `to` from its velocity.
void ProximalNewton::respond(Response& to) {
  for (std::size_t i = 0; i < rows_.size(); ++i) respond(i, to);
  if (state_.has_inverse()) {  // the rows of a contact are fewer than its directions
    change_.setZero();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Eigen::Vector3d impulse = to.impulse.col(static_cast<Index>(i));
      if (impulse(0) > 0) rows_[i].add_momentum(-impulse, change_);
    }
    to.left = to.velocity - state_.u0;
    state_.add_response(change_, to.left);
  } else {
    set_net_impulses(to.impulse, polygons_, state_);
    to.left = to.velocity - state_.u;
  }
  to.momentum.noalias() = matrix_.G() * to.left;
  to.size = std::sqrt(std::max(to.left.dot(to.momentum), 0.0));
  best_.work += work_of_response_;
}

/// @returns whether less is left of the proximal problem
bool ProximalNewton::newton_step() {
  if (now_at_.size == 0) return false;
  ++result_.counters.factorizations;
  const bool has_factors = matrix_.factor(now_at_.slope);
  best_.work += matrix_.work();
  if (!has_factors) return false;
  step_ = now_at_.momentum;
  matrix_.solve(step_);
  for (double length = 1; length >= kShortestStep; length /= 2) {
    next_at_.velocity = now_at_.velocity - length * step_;
    respond(next_at_);
    if (!(next_at_.size < (1 - kLeastFall * length) * now_at_.size)) continue;
    std::swap(now_at_, next_at_);
    return true;
  }
  return false;
}

/// Keeps the impulses that have been reached, if their residual is the least so far.
void ProximalNewton::note() {
  set_net_impulses(now_at_.impulse, polygons_, state_);
  best_.work += kWorkOfNote * state_.work_of_residual();
  const double residual = state_.residual() / state_.scale;
  if (!(residual < best_.residual)) return;
  best_.residual = residual;
  best_impulse_ = state_.impulse;
  if (residual > now_.halved / 2) return;
  now_.halved = residual;
  now_.step_then = result_.counters.iterations;
}

/// Begins anew from zero impulses, with the largest softness.
void ProximalNewton::soften() {
  from_.setZero();
  from_velocity_ = state_.u0;
  now_.has_softened = true;
  now_.softness = 1 / kHarder;
  harden();
  now_.share = kFirstShare;
  begin_proximal();
}

/// Goes on to the next softness. The first share is the last softness.
void ProximalNewton::harden() {
  now_.share = now_.softness;
  now_.softness *= kHarder;
  if (now_.softness < kLeastSoftness) now_.softness = 0;
  now_.soft_since = now_.step_then = result_.counters.iterations;
  now_.halved = best_.residual;
}

bool ProximalNewton::run(double work, double deadline_s) {
  const double until = best_.work + work;
  while (best_.work < until) {
    const auto stops = [&](Claim claim) {
      end(claim, deadline_s);
      return true;
    };
    if (!(wall_clock_s() < deadline_s)) return stops(Claim::kTimeLimit);
    if (result_.counters.iterations >= settings_.max_iterations) return stops(Claim::kIterationLimit);
    if (now_.softness == 0 && result_.counters.iterations - now_.step_then > kMostIdleSteps) {
      if (now_.has_softened || best_.residual <= best_.accept_residual) return stops(Claim::kNumericalFailure);
      soften();
    }
    ++now_.steps;
    ++result_.counters.iterations;
    const bool falls = newton_step();
    step_ = now_at_.velocity - from_velocity_;
    next_at_.momentum.noalias() = matrix_.G() * step_;
    const double moved = std::sqrt(std::max(step_.dot(next_at_.momentum), 0.0));
    const bool is_there = falls ? now_at_.size <= kInexact * moved : now_at_.size == 0;
    const bool has_failed = !is_there && (!falls || now_.steps >= kMostSteps);
    if (!is_there && !has_failed) continue;
    const bool has_settled =
        is_there && now_.share * (now_at_.impulse - from_).norm() <= kLittle * now_.softness * now_at_.impulse.norm();
    if (is_there) {
      note();
      from_ = now_at_.impulse;
      from_velocity_ = now_at_.velocity;
    }
    const bool has_aim = best_.residual <= best_.tolerance;
    if (has_aim && now_.is_last && end(Claim::kNumericalFailure, deadline_s)) return true;
    if (has_aim && !now_.is_last) {
      now_.is_last = true;
      now_.share *= kLast;
    } else if (now_.softness > 0 && (has_settled || result_.counters.iterations - now_.soft_since > kMostIdleSteps)) {
      harden();
    } else if (has_failed) {
      now_.share *= kSofter;
    } else if (now_.steps <= kFewSteps) {
      now_.share *= kStiffer;
    }
    begin_proximal();
  }
  report_best(Claim::kIterationLimit);
  return false;
}

namespace {

constexpr Capabilities kCapabilities{.needs = Needs::kFactored,
                                     .compliance = true,
                                     .guarantees = "none with friction: Newton's steps need not converge",
                                     .warm_start = true,
                                     .obeys_time_limit = true,
                                     .allocation_free = true};

}  // namespace

const Capabilities& ProximalNewton::capabilities() const { return kCapabilities; }

std::unique_ptr<BudgetedSolver> make_proximal_newton() {
  return std::make_unique<ProximalNewton>(ProximalNewtonSettings{});
}

SolverDefinition lcpbench_solver_proximal_newton() {
  return define_solver<ProximalNewton, ProximalNewtonSettings>(
      {.name = "proximal_newton",
       .summary = "soft contact problems that yield from the last impulses, each by Newton's method; sparse",
       .source = "Rockafellar 1976, Monotone operators and the proximal point algorithm; Qi, Sun 1993",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
