#pragma once

#include <memory>
#include <string>

#include "adapters/capture/engine.h"

namespace lcpbench::capture {

/// An engine that is a program of its own and steps a model file: it is told the file, and gives the contact problem of
/// each step. docs/reference/external.md describes the lines.
/// @throws InputError when the program does not start, or refuses the model
std::unique_ptr<Engine> make_model_engine(const Scene& scene, const std::string& model);

}  // namespace lcpbench::capture
