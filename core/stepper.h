#pragma once

#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/problem.h"
#include "core/settings.h"
#include "core/solver.h"
#include "core/timed_solve.h"
#include "core/warm_start.h"

namespace lcpbench {

/// What an engine knows at the beginning of a time step, once it has found the contacts.
struct StepProblem {
  /// Free bodies with their contacts, or the contact problem of a robot. Velocities are those that the step's forces
  /// give without any contact. Offsets are those of a step that is solved at once: gap / h of an open contact, and of a
  /// closed one minus the velocity at which it is to bounce off.
  std::variant<RigidScene, ContactProblem> contacts;
  Vector force_change;         ///< the part of these velocities that the step's forces give
  std::vector<double> gaps;    ///< [m] of each contact; negative: penetration
  std::vector<ContactId> ids;  ///< of each contact, the same from step to step
  double h = 0;                ///< length of the step [s]
};

struct StepAnswer {
  Vector velocity;    ///< at the end of the step
  Vector correction;  ///< positions move by h velocity and by this; empty: by h velocity alone
  int substeps = 1;   ///< equal ones, after each of which the bodies have moved
  /// kSolved: its solver says so. kIterationLimit: a stepper of a fixed number of iterations. Without a velocity, why.
  Claim claim = Claim::kNumericalFailure;
  std::string detail;
  double elsewhere_s = 0;  ///< CPU time that a worker process took [s]
};

/// A way to take a time step: what an engine does once it has the contacts. It keeps what it needs of the step before,
/// such as the impulses by contact. One object for one simulation.
class Stepper {
 public:
  virtual ~Stepper() = default;
  Stepper() = default;
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;
  virtual void step(const StepProblem& problem, StepAnswer& answer) = 0;
};

/// Opens a solver that runs in another process.
using WorkerOpener = std::function<std::unique_ptr<TimedSolver>(const Spec&)>;

/// All that is known of a stepper without running it.
struct StepperDefinition {
  std::string name;
  std::string summary;      ///< one line
  std::string source;       ///< where it was published
  bool bodies_only = true;  ///< refuses scenes with joints
  std::vector<SettingInfo> (*settings)() = nullptr;
  Options (*changed_settings)(const Options&) = nullptr;  ///< only those off their defaults; throws InputError
  std::unique_ptr<Stepper> (*make)(const Options&, const WorkerOpener&) = nullptr;
};

/// Every stepper, in a fixed order.
const std::vector<StepperDefinition>& registered_steppers();

/// @throws InputError naming the known steppers.
const StepperDefinition& find_stepper(const std::string& name);

/// `spec` checked and in canonical form, as canonical_solver_spec() gives it.
Spec canonical_stepper_spec(const Spec& spec);

/// The spec's canonical text, or the solver's spec alone where the stepper is `exact{solver=...}` and no more.
std::string stepper_label(const Spec& spec);

/// @param open  for the solvers that `exact` runs in their workers; empty: it refuses them
/// @throws InputError for unknown names and bad settings
std::unique_ptr<Stepper> make_stepper(const Spec& spec, const WorkerOpener& open = {});

}  // namespace lcpbench
