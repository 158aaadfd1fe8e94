#include "native/auto/island_solver.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <variant>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_friction_ipm();
SolverDefinition lcpbench_solver_velocity_ipm();

namespace {

/// Approaching faster than this part of max|N'v|, a contact that was left out comes back; far below what the test of an
/// answer allows, above the rounding of the velocity.
constexpr double kApproaching = 1e-9;

double dot_column(const Jacobian& J, Index column, const Vector& v) {
  return std::visit([&](const auto& matrix) { return matrix.col(column).dot(v); }, J);
}

void add_product(const Jacobian& J, const Eigen::Ref<const Vector>& f, Vector& to) {
  if (f.size() == 0) return;
  std::visit([&](const auto& matrix) { to.noalias() += matrix * f; }, J);
}

bool has_friction(const ContactProblem& whole, Index contact) {
  return whole.edges[static_cast<std::size_t>(contact)] > 0 && whole.mu(contact) > 0;
}

}  // namespace

double AutoLimits::time() const { return std::isinf(deadline_s) ? deadline_s : deadline_s - wall_clock_s(); }

void IslandSolver::load(ProblemCutter& whole, Island island, const Vector& v, std::vector<char>& carries) {
  cutter_ = &whole;
  carries_ = &carries;
  island_ = std::move(island);
  is_kept_.assign(island_.contacts.size(), 0);
  approach_.resize(static_cast<Index>(island_.contacts.size()));
  kept_.clear();
  method_ = Method::kNone;
  measure_approach(v);
  if (keep_what_may_press()) build(v);
}

/// Fills approach_. @returns whether any contact approaches
bool IslandSolver::measure_approach(const Vector& v) {
  const Jacobian& N = cutter_->whole().N;
  fastest_ = scale_ = 0;
  for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
    const double velocity = dot_column(N, island_.contacts[k], v);
    approach_(static_cast<Index>(k)) = velocity;
    fastest_ = std::max(fastest_, -velocity);
    scale_ = std::max(scale_, std::abs(velocity));
  }
  return fastest_ > 0;
}

/// @returns whether contacts were added
bool IslandSolver::keep_what_may_press() {
  const bool all = !settings_.leave_out;
  if (!all && !(fastest_ > 0)) return false;
  const bool some =
      !all && is_scene() && static_cast<std::int64_t>(island_.contacts.size()) >= settings_.leave_out_from;
  bool added = false;
  for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
    if (is_kept_[k] != 0 || (some && approach_(static_cast<Index>(k)) > fastest_)) continue;
    is_kept_[k] = 1;
    added = true;
  }
  return added;
}

void IslandSolver::build(const Vector& v) {
  const ContactProblem& whole = cutter_->whole();
  kept_.clear();
  bool with_friction = false;
  for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
    if (is_kept_[k] == 0) continue;
    kept_.push_back(island_.contacts[k]);
    with_friction = with_friction || has_friction(whole, island_.contacts[k]);
  }
  part_ = Problem("", cutter_->cut(kept_, island_.coordinates, v, with_friction));
  const ContactProblem& part = *part_.contact();
  needs_velocity_ = kept_.size() < island_.contacts.size();
  for (const Index contact : kept_) {
    const bool rows = whole.edges[static_cast<std::size_t>(contact)] > 0;
    (*carries_)[static_cast<std::size_t>(contact)] = with_friction && rows ? 1 : 0;
    needs_velocity_ = needs_velocity_ || (rows && !with_friction);
  }
  v_ = part.v;
  u_.resize(part.ngc());
  impulse_.resize(part.ngc());
  start_.setZero(part_.size());
  place_unknowns(part);
  load_method(choose_method());
  answer_.z.resize(part_.size());
  answer_.velocity.resize(part.ngc());
}

IslandSolver::Method IslandSolver::choose_method() const {
  const ContactProblem& part = *part_.contact();
  const bool sparse = is_scene() && std::holds_alternative<SparseMatrix>(part.N);
  if (part.frictional()) {
    return sparse && part_.size() >= settings_.sparse_friction_from ? Method::kFrictionIpm : Method::kContactLemke;
  }
  return sparse && part.nc() >= settings_.sparse_from ? Method::kVelocityIpm : Method::kActiveSet;
}

void IslandSolver::load_method(Method method) {
  method_ = method;
  switch (method) {
    case Method::kNone: return;
    case Method::kActiveSet:
      if (active_set_ == nullptr) active_set_ = std::make_unique<ActiveSet>(ActiveSetSettings{});
      break;
    case Method::kContactLemke:
      if (contact_lemke_ == nullptr) contact_lemke_ = std::make_unique<ContactLemke>(ContactLemkeSettings{});
      break;
    case Method::kVelocityIpm:
      if (velocity_ipm_ == nullptr) velocity_ipm_ = lcpbench_solver_velocity_ipm().make({});
      break;
    case Method::kFrictionIpm:
      if (friction_ipm_ == nullptr) friction_ipm_ = lcpbench_solver_friction_ipm().make({});
      break;
  }
  solver().load(part_);
  if (needs_velocity_ && method_ != Method::kActiveSet) inverse_ = BlockInverse(part_.contact()->inertia);
}

void IslandSolver::place_unknowns(const ContactProblem& part) {
  const ContactLayout& layout = cutter_->layout();
  place_.assign(kept_.begin(), kept_.end());
  if (!part.frictional()) return;
  for (const Index contact : kept_) {
    const auto c = static_cast<std::size_t>(contact);
    for (Index t = layout.friction_begin[c]; t < layout.friction_begin[c + 1]; ++t) {
      place_.push_back(layout.friction_offset() + t);
    }
  }
  for (const Index contact : kept_) {
    const Index lambda = layout.lambda[static_cast<std::size_t>(contact)];
    if (lambda >= 0) place_.push_back(layout.lambda_offset() + lambda);
  }
}

Solver& IslandSolver::solver() {
  switch (method_) {
    case Method::kContactLemke: return *contact_lemke_;
    case Method::kVelocityIpm: return *velocity_ipm_;
    case Method::kFrictionIpm: return *friction_ipm_;
    default: return *active_set_;
  }
}

void IslandSolver::update(const Vector& v) {
  measure_approach(v);
  if (keep_what_may_press()) return build(v);
  if (method_ == Method::kNone) return;
  for (std::size_t i = 0; i < island_.coordinates.size(); ++i) v_(static_cast<Index>(i)) = v(island_.coordinates[i]);
  solver().update(v_);
}

Claim IslandSolver::solve(const Vector* start, const AutoLimits& limits, Vector& z, Vector& u, AutoReport& report) {
  if (method_ == Method::kNone) {
    ++report.at_rest;
    report.left_out += static_cast<Index>(island_.contacts.size());
    return Claim::kSolved;
  }
  for (;;) {
    const Claim claim = run(start, limits, report);
    if (claim != Claim::kSolved) return claim;
    if (!needs_velocity_ && !gave_velocity()) break;
    add_velocity(u);
    const Index back = leaves_some_out() ? bring_back(u) : 0;
    if (back == 0) break;
    report.brought_back += back;
    for (std::size_t i = 0; i < island_.coordinates.size(); ++i) u(island_.coordinates[i]) = v_(static_cast<Index>(i));
    build(u);
    start = nullptr;
  }
  for (std::size_t i = 0; i < place_.size(); ++i) z(place_[i]) = answer_.z(static_cast<Index>(i));
  report.left_out += static_cast<Index>(island_.contacts.size() - kept_.size());
  return Claim::kSolved;
}

/// The method, and where it does not get there the next.
Claim IslandSolver::run(const Vector* start, const AutoLimits& limits, AutoReport& report) {
  for (;;) {
    const Claim claim = run_once(start, limits, report);
    const bool gave_up = claim == Claim::kNumericalFailure || claim == Claim::kUnsupported ||
                         (claim == Claim::kIterationLimit && limits.max_pivots == 0);
    if (!gave_up || method_ == Method::kContactLemke) return claim;
    load_method(method_ == Method::kVelocityIpm ? Method::kActiveSet : Method::kContactLemke);
    start = nullptr;
  }
}

Claim IslandSolver::run_once(const Vector* start, const AutoLimits& limits, AutoReport& report) {
  SolveRequest request;
  request.time_limit_s = limits.time();
  if (!(request.time_limit_s > 0)) return Claim::kTimeLimit;
  if (limits.exhausted(report.counters())) return Claim::kIterationLimit;
  if (start != nullptr) {
    for (std::size_t i = 0; i < place_.size(); ++i) start_(static_cast<Index>(i)) = (*start)(place_[i]);
    request.start = &start_;
  }
  const std::int64_t pivots = limits.max_pivots > 0 ? limits.pivots(report.counters()) : 0;
  switch (method_) {
    case Method::kNone: break;
    case Method::kActiveSet:
      ++report.active_set;
      active_set_->limit_iterations(pivots);
      break;
    case Method::kContactLemke:
      ++report.contact_lemke;
      contact_lemke_->limit_pivots(pivots);
      break;
    case Method::kVelocityIpm: ++report.velocity_ipm; break;
    case Method::kFrictionIpm: ++report.friction_ipm; break;
  }
  solver().solve(request, answer_);
  const std::string_view rung = is_sparse(method_) ? std::string_view() : std::string_view(answer_.detail);
  report.add(answer_.counters, rung);
  return answer_.claim;
}

/// The island's coordinates of u.
void IslandSolver::add_velocity(Vector& u) {
  if (answer_.velocity.size() > 0) {
    u_ = answer_.velocity;
  } else {
    const ContactProblem& part = *part_.contact();
    impulse_.setZero();
    add_product(part.N, answer_.z.head(part.nc()), impulse_);
    add_product(part.D, answer_.z.segment(part.nc(), cols(part.D)), impulse_);
    u_ = v_;
    inverse_.add_product(impulse_, u_);
  }
  for (std::size_t i = 0; i < island_.coordinates.size(); ++i) u(island_.coordinates[i]) = u_(static_cast<Index>(i));
}

/// @returns how many contacts that were left out approach in u; they are kept from now on.
Index IslandSolver::bring_back(const Vector& u) {
  Index count = 0;
  for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
    if (is_kept_[k] != 0 || dot_column(cutter_->whole().N, island_.contacts[k], u) >= -kApproaching * scale_) continue;
    is_kept_[k] = 1;
    ++count;
  }
  return count;
}

}  // namespace lcpbench
