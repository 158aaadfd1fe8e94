#pragma once

#include <memory>

#include "core/isa.h"
#include "core/problem.h"
#include "native/lemke/lemke_engine.h"

namespace lcpbench {

/// kOrdered: that of rules=2012, which no setting names.
enum class LemkeEngine { kDense, kKernel, kOrdered };

namespace lemke {

/// The ordered engine is the same at each level.
/// @throws std::invalid_argument when this processor lacks the level
std::unique_ptr<Engine> make_engine(LemkeEngine engine, IsaLevel level);

/// Contact problems in factors, unless Problem::formation() asks for another matrix: M is not formed here.
void load(const Problem& problem, Engine& engine);

}  // namespace lemke
}  // namespace lcpbench
