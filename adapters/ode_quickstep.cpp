// ODE's dWorldQuickStep, the real one, on a rigid scene.
//
// One step of length 1 s with error reduction, damping, gravity and gyroscopic terms off: force then equals impulse,
// and the step solves exactly the scene's frictionless LCP, with M + cfm I for M.
#include "core/registry.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <cstdarg>
#include <cstdio>
#include <vector>

#include <ode/ode.h>
static_assert(sizeof(dReal) == sizeof(double), "this adapter is for ODE in double precision");
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{.needs = Needs::kScene,
                                     .frictionless_only = true,
                                     .guarantees = "converges for symmetric positive semidefinite M, 0 < w < 2"};

struct OdeQuickstepSettings {
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

#ifndef LCPBENCH_DESCRIBE_ONLY

// ODE reports trouble through process-wide handlers that take no context.
std::string g_message;

void keep_message(int number, const char* format, va_list arguments) {
  char text[200];
  std::vsnprintf(text, sizeof text, format, arguments);
  g_message = "ODE message " + std::to_string(number) + ": " + text;
}

struct OdeLibrary {
  OdeLibrary() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    dSetMessageHandler(keep_message);
  }
  ~OdeLibrary() { dCloseODE(); }
};

class World {
 public:
  explicit World(const OdeQuickstepSettings& settings) : id_(dWorldCreate()), joints_(dJointGroupCreate(0)) {
    dWorldSetGravity(id_, 0, 0, 0);
    dWorldSetERP(id_, 0);
    dWorldSetCFM(id_, settings.cfm);
    dWorldSetContactSurfaceLayer(id_, 0);
    dWorldSetAutoDisableFlag(id_, 0);
    dWorldSetStepIslandsProcessingMaxThreadCount(id_, 1);
    dWorldSetQuickStepNumIterations(id_, static_cast<int>(settings.iterations));
    dWorldSetQuickStepW(id_, settings.w);
  }
  ~World() {
    dJointGroupDestroy(joints_);
    dWorldDestroy(id_);
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

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
    data.surface.mode = 0;
    data.surface.mu = 0;
    for (int k = 0; k < 3; ++k) {
      data.geom.pos[k] = contact.point(k);
      data.geom.normal[k] = contact.normal(k);
    }
    const dJointID joint = dJointCreateContact(id_, joints_, &data);
    const dBodyID second =
        contact.body_b == RigidContact::kWorld ? nullptr : bodies_[static_cast<std::size_t>(contact.body_b)];
    dJointAttach(joint, bodies_[static_cast<std::size_t>(contact.body_a)], second);
    contacts_.push_back(joint);
  }

  /// Feedback points into this vector: call once, after the last contact.
  void connect_feedback() {
    feedback_.resize(contacts_.size());
    for (std::size_t i = 0; i < contacts_.size(); ++i) dJointSetFeedback(contacts_[i], &feedback_[i]);
  }

  /// A step moves the bodies; this puts them back.
  void reset(const RigidScene& scene) {
    constexpr dQuaternion kUpright = {1, 0, 0, 0};
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const RigidBody& body = scene.bodies[i];
      dBodySetPosition(bodies_[i], body.position(0), body.position(1), body.position(2));
      dBodySetQuaternion(bodies_[i], kUpright);  // inertia is given in world axes
      dBodySetLinearVel(bodies_[i], body.linear_velocity(0), body.linear_velocity(1), body.linear_velocity(2));
      dBodySetAngularVel(bodies_[i], body.angular_velocity(0), body.angular_velocity(1), body.angular_velocity(2));
      dBodySetForce(bodies_[i], 0, 0, 0);
      dBodySetTorque(bodies_[i], 0, 0, 0);
    }
  }

  bool step() { return dWorldQuickStep(id_, 1.0) != 0; }

  /// Force on body_a along the contact's normal, per unit of the normal: the impulse of a step of 1 s.
  double normal_impulse(std::size_t contact, const Eigen::Vector3d& normal) const {
    const dReal* force = feedback_[contact].f1;
    return (force[0] * normal(0) + force[1] * normal(1) + force[2] * normal(2)) / normal.squaredNorm();
  }

 private:
  dWorldID id_;
  dJointGroupID joints_;
  std::vector<dBodyID> bodies_;
  std::vector<dJointID> contacts_;
  std::vector<dJointFeedback> feedback_;
};

class OdeQuickstep final : public Solver {
 public:
  explicit OdeQuickstep(const OdeQuickstepSettings& settings) : settings_(settings) { static const OdeLibrary library; }
  const Capabilities& capabilities() const override { return kCapabilities; }

 protected:
  void on_load(const Problem& problem) override {
    const RigidScene& scene = *problem.scene();
    world_ = std::make_unique<World>(settings_);
    for (const RigidBody& body : scene.bodies) world_->add(body);
    for (const RigidContact& contact : scene.contacts) world_->add(contact);
    world_->connect_feedback();
  }

  void on_solve(const SolveRequest&, Answer& answer) override {
    const RigidScene& scene = *problem().scene();
    g_message.clear();
    dRandSetSeed(static_cast<unsigned long>(settings_.seed));
    world_->reset(scene);
    if (!world_->step()) {
      answer.detail = "dWorldQuickStep failed";
      return;
    }
    for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
      answer.z(static_cast<Index>(i)) = world_->normal_impulse(i, scene.contacts[i].normal);
    }
    answer.counters.iterations = settings_.iterations;
    answer.detail = g_message;
    // QuickStep has no test of convergence and no way to say that it failed: a finished step is its claim.
    if (g_message.empty()) answer.claim = Claim::kSolved;
  }

 private:
  OdeQuickstepSettings settings_;
  std::unique_ptr<World> world_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ode_quickstep() {
  SolverDefinition definition{
      .name = "ode_quickstep",
      .summary = "ODE's dWorldQuickStep on the rigid scene (projected successive over-relaxation)",
      .source = "Open Dynamics Engine; a finished step counts as a claim, it has no failure",
      .capabilities = kCapabilities};
#ifdef LCPBENCH_DESCRIBE_ONLY
  return with_settings<OdeQuickstepSettings>(std::move(definition));
#else
  return define_solver<OdeQuickstep, OdeQuickstepSettings>(std::move(definition));
#endif
}

}  // namespace lcpbench
