#pragma once

#include "core/isa.h"
#include "core/problem.h"
#include "native/lemke_engine.h"

namespace lcpbench {

enum class LemkeEngine { kDense, kKernel };

namespace lemke {

/// One of Lemke's engines, with the problem that it holds.
class LoadedEngine {
 public:
  /// @throws std::invalid_argument when this processor lacks the level.
  LoadedEngine(LemkeEngine engine, IsaLevel level);
  ~LoadedEngine();
  LoadedEngine(const LoadedEngine&) = delete;
  LoadedEngine& operator=(const LoadedEngine&) = delete;

  /// Contact problems in factors: M is not formed here.
  void load(const Problem& problem);

  Outcome solve(const Rules& rules, double* z) { return engine_.solve(state_, rules, z); }

  /// @pre engine is kKernel
  std::ptrdiff_t walk(const Cell* cells, std::ptrdiff_t count, const WalkRules& rules, double* z) {
    return engine_.walk(state_, cells, count, rules, z);
  }

 private:
  void load_contact(const ContactProblem& contact);
  void load_matrix(const Lcp& lcp);

  const Engine& engine_;
  void* state_ = nullptr;
};

}  // namespace lemke
}  // namespace lcpbench
