#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/spec.h"
#include "core/swept_solver.h"
#include "native/lemke/lemke.h"

namespace lcpbench {

/// A parameterisation that is to be solved, by its number in the sweep.
struct LemkeTry {
  std::uint32_t cell = 0;
  double time_limit_s = 0;  ///< wall clock, on the cell's own path
};

/// A path to its end, and the parameterisations that take it.
struct LemkeLeaf {
  std::vector<std::uint32_t> cells;  ///< ascending
  Answer answer;
  double wall_s = 0;  ///< of that path, from its first pivot to its last; see lemke::Leaf
  double cpu_s = 0;   ///< of this thread
};

/// What Solver hands to a solver without compliance, and how it takes the answer back: a sweep is no Solver. The first
/// is the problem, or the rigid equivalent of its soft contacts; the second withdraws what is solved for that alone.
Problem without_compliance(const Problem& problem);
void return_to_given(const Problem& given, const Problem& rigid, Answer& answer);

/// Lemke's method at many pairs of tolerances: each pivot that paths have in common is done once.
///
/// Answers are bit for bit those of `Lemke` with each pair; see docs/reference/solvers/lemke.md. Memory beside that of
/// one Lemke: a saved basis for each point at which paths part on the way to the present one, fewer than cells. It is
/// the kernel (k^2 doubles, k the number of basic z and z0) and some vectors; with rules=2012 three vectors of n.
class LemkeSweep {
 public:
  /// @param cells at least one; all with engine=kernel or rules=2012, with test=none, and alike but for the two
  ///     tolerances
  LemkeSweep(std::span<const LemkeSettings> cells, IsaLevel level = isa_level());

  /// Reads settings of `lemke`. Returns nothing if there are no cells, if they differ in more than the tolerances, if
  /// the engine is dense, or if `test` is not none: this refuses test=auto, the default, even where it tests nothing.
  /// @throws InputError
  static std::optional<std::vector<LemkeSettings>> readable(std::span<const Options> cells);

  /// As Solver::load.
  void load(const Problem& problem);

  /// The ends of the paths of these cells, in any order; a cell named twice stands in its leaf twice. Refused problems
  /// have one leaf, kUnsupported. Returns the number of pivots done, each counted once.
  std::int64_t walk(std::span<const LemkeTry> tries, std::vector<LemkeLeaf>& leaves);

 private:
  struct Collector;
  void read_idle_clocks();
  static void collect(void* collector, const lemke::Leaf& leaf);

  LemkeSettings common_;
  Capabilities capabilities_;
  std::vector<lemke::Cell> cells_;
  std::unique_ptr<lemke::Engine> engine_;
  std::string refusal_;
  Index n_ = 0;
  Problem given_, rigid_;
  double idle_wall_s_ = 0;  // see lemke::WalkRules
  double idle_cpu_s_ = 0;
  std::vector<lemke::Cell> tried_;
  Vector z_;  // n: where the engine writes
};

/// SolverDefinition::make_swept of `lemke`: null where LemkeSweep::readable has nothing.
std::unique_ptr<SweptSolver> make_swept_lemke(const std::vector<Options>& cells);

}  // namespace lcpbench
