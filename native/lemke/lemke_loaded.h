#pragma once

#include <memory>

#include "core/isa.h"
#include "core/problem.h"
#include "native/lemke/lemke_engine.h"

namespace lcpbench {

enum class LemkeEngine { kDense, kKernel };

namespace lemke {

/// @throws std::invalid_argument when this processor lacks the level
std::unique_ptr<Engine> make_engine(LemkeEngine engine, IsaLevel level);

/// Contact problems in factors, unless Problem::formation() asks for another matrix: M is not formed here.
void load(const Problem& problem, bool covers_all, Engine& engine);

}  // namespace lemke
}  // namespace lcpbench
