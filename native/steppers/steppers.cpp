#include "core/error.h"
#include "core/stepper.h"
#include "core/suggestion.h"

namespace lcpbench {

StepperDefinition lcpbench_stepper_exact();
StepperDefinition lcpbench_stepper_convex();
StepperDefinition lcpbench_stepper_pgs();
StepperDefinition lcpbench_stepper_sequential_impulses();
StepperDefinition lcpbench_stepper_soft_step();
StepperDefinition lcpbench_stepper_xpbd();
StepperDefinition lcpbench_stepper_admm();
StepperDefinition lcpbench_stepper_apgd();
StepperDefinition lcpbench_stepper_nothing();

const std::vector<StepperDefinition>& registered_steppers() {
  static const std::vector<StepperDefinition> steppers{
      lcpbench_stepper_exact(),     lcpbench_stepper_convex(),
      lcpbench_stepper_pgs(),       lcpbench_stepper_sequential_impulses(),
      lcpbench_stepper_soft_step(), lcpbench_stepper_xpbd(),
      lcpbench_stepper_admm(),      lcpbench_stepper_apgd(),
      lcpbench_stepper_nothing()};
  return steppers;
}

const StepperDefinition& find_stepper(const std::string& name) {
  std::vector<std::string> names;
  std::string known;
  for (const StepperDefinition& stepper : registered_steppers()) {
    if (stepper.name == name) return stepper;
    names.push_back(stepper.name);
    known += (known.empty() ? "" : ", ") + stepper.name;
  }
  throw InputError("unknown stepper '" + name + "'" + did_you_mean(name, names) + "; known: " + known);
}

Spec canonical_stepper_spec(const Spec& spec) {
  const StepperDefinition& stepper = find_stepper(spec.name);
  return {stepper.name, stepper.changed_settings(spec.options)};
}

std::string stepper_label(const Spec& spec) {
  const Spec canonical = canonical_stepper_spec(spec);
  if (canonical.name != "exact" || canonical.options.size() > 1) return canonical.text();
  if (canonical.options.empty()) return find_stepper("exact").settings().front().default_value;
  return canonical.options.front().first == "solver" ? canonical.options.front().second : canonical.text();
}

std::unique_ptr<Stepper> make_stepper(const Spec& spec, const WorkerOpener& open) {
  return find_stepper(spec.name).make(canonical_stepper_spec(spec).options, open);
}

}  // namespace lcpbench
