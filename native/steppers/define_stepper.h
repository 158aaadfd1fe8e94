#pragma once

#include <memory>
#include <string>
#include <utility>

#include "core/stepper.h"

namespace lcpbench {

/// Completes a definition from its settings struct, which may have make_canonical(). StepperType is made of settings,
/// and of a WorkerOpener if it takes one.
template <class StepperType, class Settings>
StepperDefinition define_stepper(StepperDefinition definition) {
  static const std::string name = definition.name;
  definition.settings = [] { return describe_settings<Settings>(); };
  definition.changed_settings = [](const Options& options) {
    Settings settings = parse_settings<Settings>(name, options);
    if constexpr (requires { settings.make_canonical(); }) settings.make_canonical();
    return lcpbench::changed_settings(settings);
  };
  definition.make = [](const Options& options, const WorkerOpener& open) -> std::unique_ptr<Stepper> {
    if constexpr (std::is_constructible_v<StepperType, Settings, WorkerOpener>)
      return std::make_unique<StepperType>(parse_settings<Settings>(name, options), open);
    else
      return std::make_unique<StepperType>(parse_settings<Settings>(name, options));
  };
  return definition;
}

}  // namespace lcpbench
