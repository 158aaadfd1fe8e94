#pragma once

#include "core/isa.h"
#include "core/problem.h"
#include "native/lemke/lemke_engine.h"

namespace lcpbench {

/// kOrdered: that of rules=2012, which no setting names.
enum class LemkeEngine { kDense, kKernel, kOrdered };
/// 53 or 113 bits.
enum class LemkeArithmetic { kDouble, kQuad };

namespace lemke {

/// One of Lemke's engines, with the problem that it holds.
class LoadedEngine {
 public:
  /// Another arithmetic than double is that of the kernel engine; 113 bits and the ordered engine are the same at each
  /// level.
  /// @throws std::invalid_argument when this processor lacks the level, or for another engine in other arithmetic.
  LoadedEngine(LemkeEngine engine, IsaLevel level, LemkeArithmetic arithmetic = LemkeArithmetic::kDouble);
  ~LoadedEngine();
  LoadedEngine(const LoadedEngine&) = delete;
  LoadedEngine& operator=(const LoadedEngine&) = delete;

  /// Contact problems in factors, unless Problem::formation() asks for another matrix: M is not formed here. In 113 bits all follows from the problem's data, G^-1 included.
  void load(const Problem& problem);

  Outcome solve(const Rules& rules, double* z) { return engine_.solve(state_, rules, z); }

  /// @pre engine is not kDense
  std::ptrdiff_t walk(const Cell* cells, std::ptrdiff_t count, const WalkRules& rules, double* z) {
    return engine_.walk(state_, cells, count, rules, z);
  }

 private:
  void load_contact(const ContactProblem& contact);
  void load_matrix(const Lcp& lcp);

  const Engine& engine_;
  bool from_data_;
  void* state_ = nullptr;
};

}  // namespace lemke
}  // namespace lcpbench
