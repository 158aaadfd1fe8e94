// ODE's own steps of a world on a rigid scene: dWorldQuickStep, and dWorldStep, its Dantzig solver on a matrix that it
// forms itself.
//
// One step of length 1 s with error reduction, damping, gravity and gyroscopic terms off: force then equals impulse,
// and the rows of the step are those of the scene's LCP, with cfm added to their diagonal.
//
// With friction dWorldStep solves another problem than ours: the limits of the friction impulses are mu times the
// normal impulses that a solve without friction gives, and stay so. Every such answer says this in its detail.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <numbers>
#include <vector>

#include <ode/ode.h>

#include "adapters/worker/self_timed.h"
static_assert(sizeof(dReal) == sizeof(double), "needs ODE in double precision");
#endif

namespace lcpbench {
namespace {

struct OdeQuickstepSettings {
  static constexpr Capabilities capabilities{.needs = Needs::kScene,
                                             .guarantees =
                                                 "converges for symmetric positive semidefinite M (no friction), "
                                                 "0 < w < 2; with friction none"};

  std::int64_t iterations = 20;
  double w = 1.3;
  double cfm = 0.0;
  std::int64_t seed = 0;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 0, .max = 1000000000},
          "sweeps over the constraints (dWorldSetQuickStepNumIterations); 20 is ODE's default");
    field("w", w, RealRange{.min = 1e-6, .max = 2.0}, "over-relaxation (dWorldSetQuickStepW); 1.3 is ODE's default");
    field("cfm", cfm, RealRange{.min = 0.0}, "constraint force mixing: solves M + cfm I; ODE's default is 1e-10");
    field("seed", seed, IntegerRange{.min = 0, .max = 4294967295},
          "of ODE's random numbers, which order the constraints");
  }
};

struct OdeStepSettings {
  static constexpr Capabilities capabilities{
      .needs = Needs::kScene,
      .guarantees = "symmetric positive definite M + cfm I without friction; with friction it solves another problem"};

  double cfm = 0.0;

  void visit(auto&& field) {
    field("cfm", cfm, RealRange{.min = 0.0}, "constraint force mixing: solves M + cfm I; ODE's default is 1e-10");
  }
};

class OdeQuickstep;
class OdeStep;

#ifndef LCPBENCH_DESCRIBE_ONLY

// ODE reports trouble through process-wide handlers that take no context.
std::string g_message;

void keep_message(int number, const char* format, va_list arguments) {
  char text[200];
  std::vsnprintf(text, sizeof text, format, arguments);
  g_message = "ODE message " + std::to_string(number) + ": " + text;
}

/// The last message of ODE since the last call; "" if there is none.
std::string take_ode_message() { return std::exchange(g_message, {}); }

/// Starts ODE at the first call, for the thread that calls, and closes it at the end of the process.
void start_ode() {
  static const struct Library {
    Library() {
      dInitODE2(0);
      dAllocateODEDataForThread(static_cast<unsigned>(dAllocateMaskAll));
      dSetMessageHandler(keep_message);
    }
    ~Library() { dCloseODE(); }
  } library;
}

bool has_friction(const RigidContact& contact) { return contact.edges > 0 && contact.mu > 0; }

Eigen::Vector3d second_tangent(const RigidContact& contact) { return contact.normal.cross(contact.tangent); }

/// The first of ODE's two friction directions; the second is normal x this.
Eigen::Vector3d turned_tangent(const RigidContact& contact) {
  return std::numbers::sqrt2 / 2 * (contact.tangent + second_tangent(contact));
}

/// The scene as ODE has it.
///
/// Friction: ODE limits the impulse along each of its two directions, |x_i| <= mu f_N: a square. The pyramid of the
/// scene, |g_1| + |g_2| <= mu f_N along t and n x t, is that square turned by 45 degrees: ODE is given (t + n x t) /
/// sqrt(2) for its first direction, takes n x that for the second, and mu / sqrt(2). A contact with mu = 0 has no
/// friction rows.
///
/// An offset b is a surface that moves along the normal (dContactMotionN): a contact's velocity is to be -b at least.
/// @pre start_ode() was called.
class OdeWorld {
 public:
  OdeWorld(const Problem& problem, double cfm)
      : scene_(*problem.scene()),
        layout_(contact_layout(*problem.contact())),
        id_(dWorldCreate()),
        joints_(dJointGroupCreate(0)) {
    dWorldSetGravity(id_, 0, 0, 0);
    dWorldSetERP(id_, 0);
    dWorldSetCFM(id_, cfm);
    dWorldSetContactSurfaceLayer(id_, 0);
    dWorldSetAutoDisableFlag(id_, 0);
    dWorldSetStepIslandsProcessingMaxThreadCount(id_, 1);
    for (const RigidBody& body : scene_.bodies) add(body);
    for (const RigidContact& contact : scene_.contacts) add(contact);
    feedback_.resize(contacts_.size());  // ODE keeps pointers into it
    for (std::size_t i = 0; i < contacts_.size(); ++i) dJointSetFeedback(contacts_[i], &feedback_[i]);
  }
  ~OdeWorld() {
    dJointGroupDestroy(joints_);
    dWorldDestroy(id_);
  }
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  dWorldID id() const { return id_; }

  /// Takes one step from the scene's positions and velocities by `step`, dWorldQuickStep or dWorldStep, which `name`
  /// names. Then z has the impulses from the forces on the contacts; lambda, which ODE does not have, comes from the
  /// velocities after the step: the largest slip along a friction direction. A step without a message claims a
  /// solution. @returns whether ODE finished the step
  bool solve(int (*step)(dWorldID, dReal), const char* name, std::int64_t seed, Answer& answer) {
    take_ode_message();
    dRandSetSeed(static_cast<unsigned long>(seed));
    reset();
    if (step(id_, 1.0) == 0) {
      answer.detail = std::string(name) + " failed";
      return false;
    }
    read(answer.z);
    answer.detail = take_ode_message();  // "LCP internal error" of dWorldStep comes this way, and no other
    if (answer.detail.empty()) answer.claim = Claim::kSolved;
    return true;
  }

 private:
  void add(const RigidBody& body) {
    const dBodyID id = dBodyCreate(id_);
    dMass mass;
    const Eigen::Matrix3d& I = body.inertia;
    dMassSetParameters(&mass, body.mass, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    dBodySetMass(id, &mass);
    dBodySetGyroscopicMode(id, 0);
    bodies_.push_back(id);
  }

  void add(const RigidContact& contact) {
    dContact data{};
    for (int k = 0; k < 3; ++k) {
      data.geom.pos[k] = contact.point(k);
      data.geom.normal[k] = contact.normal(k);
    }
    if (has_friction(contact)) {
      data.surface.mode = dContactFDir1 | dContactApprox1;
      data.surface.mu = contact.mu / std::numbers::sqrt2;
      const Eigen::Vector3d first = turned_tangent(contact);
      for (int k = 0; k < 3; ++k) data.fdir1[k] = first(k);
    }
    if (contact.b != 0) {
      data.surface.mode |= dContactMotionN;
      data.surface.motionN = -contact.b;
    }
    const dJointID joint = dJointCreateContact(id_, joints_, &data);
    const dBodyID second =
        contact.body_b == RigidContact::kWorld ? nullptr : bodies_[static_cast<std::size_t>(contact.body_b)];
    dJointAttach(joint, bodies_[static_cast<std::size_t>(contact.body_a)], second);
    contacts_.push_back(joint);
  }

  /// A step moves the bodies; this puts them back.
  void reset() {
    constexpr dQuaternion kUpright = {1, 0, 0, 0};
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const RigidBody& body = scene_.bodies[i];
      dBodySetPosition(bodies_[i], body.position(0), body.position(1), body.position(2));
      dBodySetQuaternion(bodies_[i], kUpright);  // inertia is given in world axes
      dBodySetLinearVel(bodies_[i], body.linear_velocity(0), body.linear_velocity(1), body.linear_velocity(2));
      dBodySetAngularVel(bodies_[i], body.angular_velocity(0), body.angular_velocity(1), body.angular_velocity(2));
      dBodySetForce(bodies_[i], 0, 0, 0);
      dBodySetTorque(bodies_[i], 0, 0, 0);
    }
  }

  void read(Vector& z) const {
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const RigidContact& contact = scene_.contacts[i];
      const Eigen::Map<const Eigen::Vector3d> force(feedback_[i].f1);
      z(static_cast<Index>(i)) = force.dot(contact.normal) / contact.normal.squaredNorm();
      if (layout_.lambda[i] < 0) continue;
      Eigen::Vector2d impulse = Eigen::Vector2d::Zero();  // along t and n x t
      if (has_friction(contact)) {
        // Normals and tangents of a file are orthogonal to 1e-6 only: the force is taken apart along its own rows.
        Eigen::Matrix3d rows;
        rows.col(0) = contact.normal;
        rows.col(1) = turned_tangent(contact);
        rows.col(2) = contact.normal.cross(rows.col(1));
        const Eigen::Vector3d parts = rows.inverse() * force;
        z(static_cast<Index>(i)) = parts(0);
        impulse = std::numbers::sqrt2 / 2 * Eigen::Vector2d(parts(1) - parts(2), parts(1) + parts(2));
      }
      const Index first = layout_.friction_offset() + layout_.friction_begin[i];
      for (Index k = 0; k < 2; ++k) {
        z(first + k) = std::max(impulse(k), 0.0);
        z(first + 2 + k) = std::max(0.0 - impulse(k), 0.0);
      }
      const Eigen::Vector3d slip = velocity(contact.body_a, contact.point) - velocity(contact.body_b, contact.point);
      z(layout_.lambda_offset() + layout_.lambda[i]) =
          std::max(std::abs(contact.tangent.dot(slip)), std::abs(second_tangent(contact).dot(slip)));
    }
  }

  /// After a step, of the point where it was before: the step has moved the bodies.
  Eigen::Vector3d velocity(int body, const Eigen::Vector3d& point) const {
    if (body == RigidContact::kWorld) return Eigen::Vector3d::Zero();
    const auto b = static_cast<std::size_t>(body);
    const Eigen::Map<const Eigen::Vector3d> linear(dBodyGetLinearVel(bodies_[b]));
    const Eigen::Map<const Eigen::Vector3d> angular(dBodyGetAngularVel(bodies_[b]));
    return linear + angular.cross(point - scene_.bodies[b].position);
  }

  RigidScene scene_;
  ContactLayout layout_;
  dWorldID id_;
  dJointGroupID joints_;
  std::vector<dBodyID> bodies_;
  std::vector<dJointID> contacts_;
  std::vector<dJointFeedback> feedback_;
};

class OdeQuickstep final : public Adapter<OdeQuickstepSettings>, public SelfTimed {
 public:
  explicit OdeQuickstep(const OdeQuickstepSettings& settings) : Adapter(settings), iterations_(settings.iterations) {
    start_ode();
  }

  /// A step does more than solve: it finds islands, forms rows, moves bodies. A step of no iterations does all that and
  /// nothing else: its time is counted as set-up, and the time of the solve is what the iterations add.
  void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
    iterations_ = settings_.iterations;
    timed_solve(*this, problem, request, result);
    if (result.answer.claim == Claim::kUnsupported) return;
    iterations_ = 0;
    TimedAnswer overhead;
    timed_solve(*this, problem, request, overhead);
    SolveTimes& times = result.times;
    const SolveTimes& step = overhead.times;
    // The difference may be negative, because both times are measured with noise.
    times.solve_wall_s = std::max(0.0, times.solve_wall_s - step.solve_wall_s);
    times.solve_cpu_s = std::max(0.0, times.solve_cpu_s - step.solve_cpu_s);
    times.setup_wall_s += step.solve_wall_s;
    times.setup_cpu_s += step.solve_cpu_s;
  }

 private:
  std::string take(const Problem& problem) override {
    world_ = std::make_unique<OdeWorld>(problem, settings_.cfm);
    dWorldSetQuickStepNumIterations(world_->id(), static_cast<int>(iterations_));
    dWorldSetQuickStepW(world_->id(), settings_.w);
    return {};
  }

  /// QuickStep has no test of convergence and no way to say that it failed: a finished step is its claim.
  void call(const SolveRequest&, Answer& answer) override {
    const bool finished = world_->solve(dWorldQuickStep, "dWorldQuickStep", settings_.seed, answer);
    if (finished) answer.counters.iterations = iterations_;
  }

  std::int64_t iterations_;  // of the next load
  std::unique_ptr<OdeWorld> world_;
};

class OdeStep final : public Adapter<OdeStepSettings> {
 public:
  explicit OdeStep(const OdeStepSettings& settings) : Adapter(settings) { start_ode(); }

 private:
  std::string take(const Problem& problem) override {
    world_ = std::make_unique<OdeWorld>(problem, settings_.cfm);
    return {};
  }

  void call(const SolveRequest&, Answer& answer) override {
    constexpr std::int64_t kSeed = 0;
    world_->solve(dWorldStep, "dWorldStep", kSeed, answer);
    if (answer.claim == Claim::kSolved && problem().contact()->frictional()) {
      answer.detail = "another problem: friction limited by the normal impulses of a solve without friction";
    }
  }

  std::unique_ptr<OdeWorld> world_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ode_quickstep() {
  return define_adapter<OdeQuickstep, OdeQuickstepSettings>(
      {.name = "ode_quickstep",
       .summary = "ODE's dWorldQuickStep on the rigid scene (projected successive over-relaxation)",
       .source = "Open Dynamics Engine; a finished step counts as a claim, it has no failure"});
}

SolverDefinition lcpbench_solver_ode_step() {
  return define_adapter<OdeStep, OdeStepSettings>(
      {.name = "ode_step",
       .summary = "ODE's dWorldStep on the rigid scene (Dantzig's principal pivoting)",
       .source = "Open Dynamics Engine; after Baraff, SIGGRAPH 1994"});
}

}  // namespace lcpbench
