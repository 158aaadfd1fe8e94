#pragma once

#include <string>

#include "adapters/capture/scene.h"

namespace lcpbench::capture {

/// A scene as text of MuJoCo's model format (MJCF): bodies, hinges, loops, friction, gravity and the step. Velocities,
/// forces and settings of the solver are not part of it. Body i is named "b<i>", its hinge "j<i>". O(bodies^2)
std::string model_text(const Scene& scene);

}  // namespace lcpbench::capture
