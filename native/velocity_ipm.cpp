#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/answer_storage.h"
#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/active_set.h"
#include "native/velocity_ipm/whitened_normals.h"

namespace lcpbench {
namespace {

enum class Algebra { kAuto, kDense, kSparse };

struct VelocityIpmSettings {
  Algebra algebra = Algebra::kAuto;
  double tolerance = 1e-9;
  double accept_residual = 3e-5;
  double shift = 1e-12;
  bool finish = true;
  std::int64_t max_iterations = 100;

  void visit(auto&& field) {
    field("algebra", algebra,
          Choices<Algebra>{{{"auto", Algebra::kAuto}, {"dense", Algebra::kDense}, {"sparse", Algebra::kSparse}}},
          "Cholesky of the Newton matrix; auto: sparse for block inertia with a sparse N; sparse needs block inertia");
    field("tolerance", tolerance, RealRange{.min = 0}, "stop when the velocity residual is at most this times max|q|");
    field("accept_residual", accept_residual, RealRange{.min = 0},
          "claim solved only when the velocity residual, evaluated in double, is at most this times max|q|");
    field("shift", shift, RealRange{.min = 0, .max = 1},
          "shift max|M_ii| I is added to M in each step: contacts that push against each other have no central path");
    field("finish", finish, "go on from the pressed contacts to full accuracy");
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "predictor-corrector steps");
  }
};

constexpr double kBoundaryFraction = 0.995;  // of the step to the nearest boundary [Mehrotra 1992]
constexpr double kShortestStep = 0x1p-26;    // shorter ones were cut by rounding, not by the problem

// So many steps without the residual falling to a half: no solution (the impulses grow without bound), or rounding.
constexpr int kMostIdleSteps = 25;
constexpr double kProgress = 0.5;

/// A point: f > 0, s > 0 and y, with residuals y - W f and W'y + q - s.
struct Point {
  Vector f;  // nc, impulses [N s]
  Vector s;  // nc, normal velocities [m/s]
  Vector y;  // change of velocity in whitened coordinates

  void resize(Index contacts, Index coordinates) {
    f.resize(contacts);
    s.resize(contacts);
    y.resize(coordinates);
  }
};

enum class Stop { kConverged, kStalled, kBreakdown, kIterationLimit, kTimeLimit };

/// Solves frictionless contact problems by Mehrotra's predictor-corrector method in velocity space,
///
///     minimize 1/2 (u - v)'G (u - v) subject to N'u >= 0,
///
/// the multipliers being the impulses. Each step factors one matrix of the order of the velocity (ngc), not of the
/// contacts, whatever their number and redundancy: I + W diag(f / (s + shift f)) W' in coordinates where G = I.
/// Block inertia with a sparse N: sparse LDL', whose cost follows the graph of bodies. Dense: O(ngc^2 (nc + ngc)).
/// [Mehrotra 1992; Wright 1997, ch. 10; docs/primal_dual.md]
///
/// Finish. Dense: the dual active-set method from the contacts that are pressed. Sparse: their velocities are brought
/// to zero by regularised Newton steps with one more factorization; the better point is returned.
///
/// kSolved: the velocity residual, computed from z alone, is within accept_residual; kUnsolvable: shown by the finish;
/// kNumericalFailure: it is not, with what ended the iteration.
class VelocityIpm final : public Solver {
 public:
  explicit VelocityIpm(const VelocityIpmSettings& settings) : settings_(settings), active_set_({}) {}
  const Capabilities& capabilities() const override;

 private:
  void on_load(const Problem& problem) override;
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  void set_velocity(const Vector& v);
  void set_start();
  Stop iterate(double deadline_s, Counters& counters);
  void evaluate_residuals();
  bool factor(Counters& counters);
  void find_direction();
  double longest_step() const;
  double gap_after(double step) const;
  double relative_residual(const Vector& f);
  void finish_sparse(Counters& counters);
  bool finish_dense(const SolveRequest& request, Answer& answer);
  void pressed_contacts(Vector& f) const;

  VelocityIpmSettings settings_;
  ActiveSet active_set_;
  std::unique_ptr<WhitenedNormals> normals_;  // null: the inertia is not what the algebra asked for needs
  bool is_sparse_ = false;
  Jacobian N_;
  Vector v_;
  Vector q_;
  Vector diagonal_;  // M_ii
  double q_max_ = 0;
  double shift_ = 0;

  Point point_, step_;
  Vector dual_residual_;    // y - W f
  Vector primal_residual_;  // W'y + q - s
  Vector target_;           // what f s is to become, less f s
  Vector contacts_;         // scratch, nc
  Vector coordinates_;      // scratch
};

/// Both of them and the pattern of the inertia: what a scene of many bodies is.
bool is_sparse_problem(const ContactProblem& contact) {
  return std::holds_alternative<SparseMatrix>(contact.N) && std::holds_alternative<BlockInertia>(contact.inertia);
}

void VelocityIpm::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  is_sparse_ =
      settings_.algebra == Algebra::kSparse || (settings_.algebra == Algebra::kAuto && is_sparse_problem(contact));
  normals_ = is_sparse_ ? sparse_whitened_normals(contact) : dense_whitened_normals(contact);
  if (normals_ == nullptr) return;
  if (!is_sparse_ && settings_.finish) active_set_.load(problem);
  N_ = contact.N;
  diagonal_ = normals_->squared_norms();
  shift_ = contact.nc() > 0 ? settings_.shift * diagonal_.maxCoeff() : 0;
  for (Point* point : {&point_, &step_}) point->resize(contact.nc(), normals_->coordinates());
  for (Vector* vector : {&primal_residual_, &target_, &contacts_}) vector->resize(contact.nc());
  for (Vector* vector : {&dual_residual_, &coordinates_}) vector->resize(normals_->coordinates());
  set_velocity(contact.v);
}

void VelocityIpm::on_update(const Vector& v) {
  if (normals_ == nullptr || !v.allFinite()) return Solver::on_update(v);
  if (!is_sparse_ && settings_.finish) active_set_.update(v);
  set_velocity(v);
}

void VelocityIpm::set_velocity(const Vector& v) {
  v_ = v;
  q_ = std::visit([&](const auto& N) { return Vector(N.transpose() * v); }, N_);
  q_max_ = q_.size() > 0 ? q_.cwiseAbs().maxCoeff() : 0;
}

/// y = 0, s of the size of q, and f such that f and s are as far from their boundaries in the same unit.
void VelocityIpm::set_start() {
  const double largest = diagonal_.maxCoeff();
  point_.y.setZero();
  point_.s = q_.cwiseAbs().cwiseMax(0.1 * q_max_);
  for (Index i = 0; i < q_.size(); ++i) point_.f(i) = point_.s(i) / (diagonal_(i) > 0 ? diagonal_(i) : largest);
}

void VelocityIpm::evaluate_residuals() {
  normals_->combine(point_.f, dual_residual_);
  dual_residual_ = point_.y - dual_residual_;
  normals_->project(point_.y, primal_residual_);
  primal_residual_ += q_ - point_.s;
}

bool VelocityIpm::factor(Counters& counters) {
  ++counters.factorizations;
  contacts_.array() = point_.f.array() / (point_.s.array() + shift_ * point_.f.array());
  return contacts_.allFinite() && normals_->factor(contacts_);
}

/// The Newton step towards f s + target_, residuals zero.
void VelocityIpm::find_direction() {
  const auto f = point_.f.array();
  const auto denominator = point_.s.array() + shift_ * f;
  contacts_.array() = (target_.array() - f * primal_residual_.array()) / denominator;
  normals_->combine(contacts_, step_.y);
  step_.y -= dual_residual_;
  normals_->solve(step_.y);
  normals_->project(step_.y, step_.s);
  step_.f.array() = (target_.array() - f * (step_.s + primal_residual_).array()) / denominator;
  step_.s += primal_residual_ + shift_ * step_.f;
}

/// The longest step <= 1 that leaves f and s nonnegative.
double VelocityIpm::longest_step() const {
  double step = 1.0;
  for (Index i = 0; i < q_.size(); ++i) {
    if (step_.f(i) < 0) step = std::min(step, -point_.f(i) / step_.f(i));
    if (step_.s(i) < 0) step = std::min(step, -point_.s(i) / step_.s(i));
  }
  return step;
}

double VelocityIpm::gap_after(double step) const { return (point_.f + step * step_.f).dot(point_.s + step * step_.s); }

/// max |min(M_ii f_i, w_i)| / max|q| with w = W'W f + q: the evaluation's measure, in double. Infinity for NaN.
double VelocityIpm::relative_residual(const Vector& f) {
  normals_->combine(f, coordinates_);
  normals_->project(coordinates_, contacts_);
  double worst = 0;
  for (Index i = 0; i < q_.size(); ++i) {
    const double off = std::abs(std::min(diagonal_(i) * f(i), contacts_(i) + q_(i)));
    if (!std::isfinite(off)) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, off);
  }
  return worst / q_max_;
}

Stop VelocityIpm::iterate(double deadline_s, Counters& counters) {
  const double contacts = static_cast<double>(q_.size());
  double best = std::numeric_limits<double>::infinity();
  int idle_steps = 0;
  for (;; ++counters.iterations) {
    const double residual = relative_residual(point_.f);
    if (residual <= settings_.tolerance) return Stop::kConverged;
    idle_steps = residual < kProgress * best ? 0 : idle_steps + 1;
    best = std::min(best, residual);
    if (idle_steps > kMostIdleSteps) return Stop::kStalled;
    if (counters.iterations >= settings_.max_iterations) return Stop::kIterationLimit;
    if (!(wall_clock_s() < deadline_s)) return Stop::kTimeLimit;
    evaluate_residuals();
    if (!factor(counters)) return Stop::kBreakdown;
    const double gap = point_.f.dot(point_.s);
    target_ = -point_.f.cwiseProduct(point_.s);
    find_direction();
    const double predicted = gap_after(longest_step()) / gap;
    const double centering = predicted * predicted * predicted;  // [Mehrotra 1992]
    target_.array() += centering * gap / contacts - step_.f.array() * step_.s.array();
    find_direction();
    const double length = std::min(1.0, kBoundaryFraction * longest_step());
    if (!(step_.f.allFinite() && step_.s.allFinite())) return Stop::kBreakdown;
    if (!(length >= kShortestStep) || !(gap > std::numeric_limits<double>::min())) return Stop::kStalled;
    point_.f += length * step_.f;
    point_.s += length * step_.s;
    point_.y += length * step_.y;
  }
}

/// f of the contacts that are pressed rather than parting, in the same unit; 0 for the others.
void VelocityIpm::pressed_contacts(Vector& f) const {
  for (Index i = 0; i < q_.size(); ++i) f(i) = diagonal_(i) * point_.f(i) > point_.s(i) ? point_.f(i) : 0;
}

/// Brings the velocities of the pressed contacts to zero: M df = -w on them, solved as the least-squares problem that
/// redundant contacts make of it, (M + I / weight) df = -w, in velocity space. The steps repair what the weight leaves;
/// it stands 1e8 above the diagonal of M, halfway in digits between the problem and its rounding.
void VelocityIpm::finish_sparse(Counters& counters) {
  constexpr double kWeight = 1e8;
  constexpr int kRounds = 6;
  double best = relative_residual(point_.f);
  Vector& f = step_.f;
  Vector& weights = step_.s;
  pressed_contacts(f);
  const double largest = diagonal_.maxCoeff();
  for (Index i = 0; i < f.size(); ++i) weights(i) = f(i) > 0 ? kWeight / largest : 0;
  ++counters.factorizations;
  if (!normals_->factor(weights)) return;
  for (int round = 0; round < kRounds; ++round) {
    target_ = f.cwiseMax(0.0);
    const double residual = relative_residual(target_);  // leaves W f and W'W f behind
    if (residual < best) {
      best = residual;
      point_.f = target_;
    } else if (round > 0) {
      return;
    }
    // df = -weights (w + W'dy) with (I + W weights W') dy = -W weights w.
    contacts_ = weights.cwiseProduct(contacts_ + q_);
    f = target_ - contacts_;
    normals_->combine(contacts_, step_.y);
    normals_->solve(step_.y);
    normals_->project(step_.y, contacts_);
    f += weights.cwiseProduct(contacts_);
  }
}

/// False when the active set has no answer either.
bool VelocityIpm::finish_dense(const SolveRequest& request, Answer& answer) {
  pressed_contacts(contacts_);
  const Counters counters = answer.counters;
  const Vector before = answer.z;
  active_set_.solve({.start = &contacts_, .time_limit_s = request.time_limit_s}, answer);
  const std::int64_t steps = answer.counters.pivots;
  const std::int64_t factorizations = answer.counters.factorizations;
  answer.counters = counters;
  answer.counters.pivots = steps;
  answer.counters.factorizations += factorizations;
  if (answer.claim == Claim::kSolved || answer.claim == Claim::kUnsolvable) return true;
  answer.z = before;
  answer.velocity.resize(0);
  return false;
}

void VelocityIpm::on_solve(const SolveRequest& request, Answer& answer) {
  answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  if (normals_ == nullptr) {
    answer.claim = Claim::kUnsupported;
    answer.detail = "algebra=sparse needs an inertia of positive definite blocks";
    return;
  }
  if (q_max_ == 0) {  // z = 0 solves it, and max|q| gives no scale to judge another answer by
    answer.claim = Claim::kSolved;
    answer.velocity = v_;
    return;
  }
  set_start();
  const Stop stop = iterate(wall_clock_s() + request.time_limit_s, answer.counters);
  if (stop == Stop::kIterationLimit || stop == Stop::kTimeLimit) {
    answer.claim = stop == Stop::kTimeLimit ? Claim::kTimeLimit : Claim::kIterationLimit;
    answer.z = point_.f;
    return;
  }
  answer.z = point_.f;
  if (settings_.finish && !is_sparse_ && finish_dense(request, answer)) return;
  if (settings_.finish && is_sparse_) finish_sparse(answer.counters);
  answer.z = point_.f;
  const double residual = relative_residual(answer.z);
  answer.claim = residual <= settings_.accept_residual ? Claim::kSolved : Claim::kNumericalFailure;
  normals_->velocity(v_, coordinates_, answer.velocity);
  if (stop == Stop::kStalled) answer.detail = "no step goes further";
  if (stop == Stop::kBreakdown) answer.detail = "the Newton system could not be solved";
}

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .frictionless_only = true,
    .guarantees = "solvable frictionless contact problems, redundant contacts included",
    .obeys_time_limit = true};

const Capabilities& VelocityIpm::capabilities() const { return kCapabilities; }

}  // namespace

SolverDefinition lcpbench_solver_velocity_ipm() {
  return define_solver<VelocityIpm, VelocityIpmSettings>(
      {.name = "velocity_ipm",
       .summary = "predictor-corrector interior point in velocity space, dense or sparse, finished to full accuracy",
       .source = "Mehrotra 1992, On the implementation of a primal-dual interior point method",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
