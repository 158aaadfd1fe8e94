#pragma once

#include "core/types.h"

namespace lcpbench {

/// The memory of the vectors that Solver::solve cleared last in this thread.
///
/// on_solve() gets an answer without velocity and Farkas vector. A solver that returns one and allocates nothing fills
/// the vector here (after resizing it, which allocates when the answer had none before) and swaps it into the answer.
struct ClearedVectors {
  Vector z;  ///< of a refusal: solve() gives it back
  Vector velocity;
  Vector farkas;
};

ClearedVectors& cleared_vectors();

}  // namespace lcpbench
