#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/registry.h"
#include "core/selection.h"
#include "native/steppers/define_stepper.h"

namespace lcpbench {
namespace {

struct ExactSettings {
  std::string solver = "auto";
  bool warm = true;
  bool project = true;
  double time_limit = 60;

  void visit(auto&& field) {
    field("solver", solver, "a solver's spec: name{key=value,...}");
    field("warm", warm, "start from the last answer, by contact, if the solver takes a start and runs in this process");
    field("project", project, "take penetration back by a second problem, without friction, in metres");
    field("time_limit", time_limit, RealRange{.min = 0}, "[s] of a solve");
  }
  void make_canonical() { solver = canonical_solver_spec(parse_spec(solver)).text(); }
};

/// What may stay, so that contacts are found again where an engine reports overlaps only [m]: less than a body falls in
/// a step. It goes with h squared: a depth that stayed in shorter steps would keep their motion from the limit of short
/// steps.
double allowed_depth(double h) { return std::min(1e-4, 4 * h * h); }

/// An excess over the allowed depth that starts no correction [m]: a tenth, at most 4 % of what a body falls in a step.
/// Less is left by the last digits of a velocity, step after step, and costs a problem of all contacts each time.
double tolerated_excess(double h) { return 0.1 * allowed_depth(h); }

/// The offset that takes penetration back: a fifth of its excess, or all that is left where that is little. An open gap
/// may close, by no more than the deepest penetration, which is as far as a correction moves a contact.
double position_offset(double gap, double approach, double deepest, double h) {
  constexpr double kCorrectedShare = 0.2;
  if (gap > 0) return std::clamp(gap + approach, 0.0, deepest);
  const double excess = std::max(0.0, -gap - allowed_depth(h));
  return -std::max(kCorrectedShare * excess, std::min(excess, tolerated_excess(h)));
}

Vector along_columns(const Jacobian& J, const Vector& u) {
  return std::visit([&](const auto& matrix) { return Vector(matrix.transpose() * u); }, J);
}

/// Bodies and contacts at rest, without friction, with these offsets. Joints stay closed, and their limits leave what
/// `velocity` leaves of their gaps in a step of length h.
Problem displaced(const Problem& problem, const Vector& offsets, const Vector& velocity, double h) {
  if (const RigidScene* scene = problem.scene()) {
    RigidScene result = *scene;
    for (RigidBody& body : result.bodies) body.linear_velocity = body.angular_velocity = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < result.contacts.size(); ++i) {
      result.contacts[i].edges = 0;
      result.contacts[i].mu = 0;
      result.contacts[i].b = offsets(static_cast<Index>(i));
    }
    return {"", std::move(result)};
  }
  ContactProblem result = *problem.contact();
  result.v.setZero();
  std::fill(result.edges.begin(), result.edges.end(), 0);
  result.mu.setZero();
  result.D = SparseMatrix(result.ngc(), 0);
  result.b = offsets;
  if (!result.has_rows()) return {"", std::move(result)};
  std::vector<Index> kept;  // without dry friction, motors and brakes
  for (Index i = 0; i < result.rows.size(); ++i) {
    const double lower = result.rows.bounds.lower(i), upper = result.rows.bounds.upper(i);
    if (result.rows.bounds.friction_of[static_cast<std::size_t>(i)] < 0 && std::isinf(upper - lower)) kept.push_back(i);
  }
  result = select_rows(result, kept);
  BoundedRows& rows = result.rows;
  const Vector left = along_columns(rows.R, velocity);
  Vector b = Vector::Zero(rows.size());
  for (Index i = 0; i < rows.size(); ++i) {
    const double gap = h * (left(i) + rows.offset(i));
    if (!rows.bounds.is_free(i)) b(i) = rows.bounds.lower(i) == 0 ? std::max(0.0, gap) : std::min(0.0, gap);
  }
  rows.b = std::move(b);
  rows.compliance.resize(0);
  return {"", std::move(result)};
}

/// A solver with the answer to its last problem.
class StartedSolver {
 public:
  explicit StartedSolver(const Spec& spec, const WorkerOpener& open) {
    const RegisteredSolver& solver = find_solver(spec.name);
    if (solver.in_process()) {
      own_ = make_solver(spec);
    } else if (open) {
      other_ = open(spec);
    } else {
      throw InputError("solver '" + spec.name + "' runs in a worker, which is not to be had here");
    }
  }

  /// @returns the CPU time that a worker took [s]
  double solve(const Problem& problem, const std::vector<ContactId>& ids, double time_limit_s, bool warm,
               Answer& answer) {
    if (own_ == nullptr) {
      other_->run(problem, {.time_limit_s = time_limit_s}, timed_);
      answer = timed_.answer;
      return timed_.times.setup_cpu_s + timed_.times.solve_cpu_s;
    }
    const ContactLayout layout = contact_layout(*problem.contact());
    const bool start = warm && own_->capabilities().warm_start && last_.size() > 0;
    if (start) {
      match_.find(ids_, ids);
      matched_start(last_, layout_, match_, layout, start_);
      own_->update(problem);
    } else {
      own_->load(problem);
    }
    own_->solve({.start = start ? &start_ : nullptr, .time_limit_s = time_limit_s}, answer);
    last_.resize(0);
    if (answer.z.size() == problem.size() && answer.z.allFinite()) last_ = answer.z;
    ids_ = ids;
    layout_ = layout;
    return 0;
  }

 private:
  std::unique_ptr<Solver> own_;
  std::unique_ptr<TimedSolver> other_;
  TimedAnswer timed_;
  Vector last_;
  ContactLayout layout_;
  std::vector<ContactId> ids_;
  ContactMatch match_;
  Vector start_;
};

/// One solve a step by any solver, of the velocities (Moreau 1988; Anitescu, Potra 1997: an open contact closes in the
/// step at most), then one of the positions where a penetration is too deep. Every answer with finite impulses moves the
/// bodies, whatever its claim.
class Exact : public Stepper {
 public:
  Exact(const ExactSettings& settings, const WorkerOpener& open)
      : settings_(settings),
        velocities_(parse_spec(settings.solver), open),
        positions_(make_solver(parse_spec("auto{error=0.005}"))) {}

  void step(const StepProblem& step, StepAnswer& answer) override {
    answer = {};
    const Problem problem = std::visit([](const auto& contacts) { return Problem("", contacts); }, step.contacts);
    const ContactProblem& contact = *problem.contact();
    if (contact.nc() == 0 && !contact.has_rows()) {
      answer.velocity = contact.v;
      answer.claim = Claim::kSolved;
      return;
    }
    answer.elsewhere_s = velocities_.solve(problem, step.ids, settings_.time_limit, settings_.warm, answer_);
    answer.claim = answer_.claim;
    answer.detail = answer_.detail;
    const auto velocity = velocity_of(problem);
    if (!velocity) return;
    answer.velocity = *velocity;
    if (settings_.project && contact.nc() > 0) correct(problem, step, answer);
  }

 private:
  /// Of the last answer; none where it has no finite impulses.
  std::optional<Vector> velocity_of(const Problem& problem) const {
    if (answer_.z.size() != problem.size() || !answer_.z.allFinite()) return std::nullopt;
    const ContactProblem& contact = *problem.contact();
    if (answer_.velocity.size() == contact.ngc() && answer_.velocity.allFinite()) return answer_.velocity;
    return post_impact_velocity(contact, answer_.z);
  }

  /// The smallest change of positions, in the metric of the inertia, that takes a share of each penetration back and
  /// opens none: a problem in metres. Without an answer nothing is corrected.
  void correct(const Problem& found, const StepProblem& step, StepAnswer& answer) {
    const double deepest = -*std::min_element(step.gaps.begin(), step.gaps.end());
    if (!(deepest > allowed_depth(step.h) + tolerated_excess(step.h))) return;
    Vector offsets = step.h * along_columns(found.contact()->N, answer.velocity);
    for (Index i = 0; i < offsets.size(); ++i) {
      offsets(i) = position_offset(step.gaps[static_cast<std::size_t>(i)], offsets(i), deepest, step.h);
    }
    const Problem problem = displaced(found, offsets, answer.velocity, step.h);
    positions_->load(problem);
    positions_->solve({.time_limit_s = settings_.time_limit}, answer_);
    const auto change = velocity_of(problem);
    if (!change) return;
    answer.correction = *change;
    // What cannot be corrected, as a body in a gap that is too narrow, must not be thrown out.
    const double farthest = along_columns(problem.contact()->N, answer.correction).lpNorm<Eigen::Infinity>();
    if (farthest > deepest) answer.correction *= deepest / farthest;
  }

  ExactSettings settings_;
  StartedSolver velocities_;
  std::unique_ptr<Solver> positions_;  ///< to a few per cent of a correction, whatever solves the velocities
  Answer answer_;
};

/// The same with the convex relaxation.
struct ConvexSettings : ExactSettings {
  ConvexSettings() { solver = "cone_ipm{cone=true,slip=none}"; }
};

}  // namespace

StepperDefinition lcpbench_stepper_exact() {
  return define_stepper<Exact, ExactSettings>(
      {.name = "exact",
       .summary = "one solve a step by any solver, from its last answer, then one of the positions",
       .source = "Anitescu, Potra, Formulating dynamic multi-rigid-body contact problems with friction, 1997",
       .bodies_only = false});
}

StepperDefinition lcpbench_stepper_convex() {
  return define_stepper<Exact, ConvexSettings>(
      {.name = "convex",
       .summary = "exact with the convex relaxation, in which what slides lifts off, as in MuJoCo and Drake's SAP",
       .source = "Anitescu, Optimization-based simulation of nonsmooth rigid multibody dynamics, 2006",
       .bodies_only = false});
}

}  // namespace lcpbench
