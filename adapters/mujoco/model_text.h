#pragma once

#include <string>

#include "adapters/capture/scene.h"

namespace lcpbench::capture {

/// A scene as text of MuJoCo's model format (MJCF). Body i is named "b<i>", its hinge "j<i>".
std::string model_text(const Scene& scene);

}  // namespace lcpbench::capture
