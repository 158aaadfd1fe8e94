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

/// A cell (parameterisation) of the sweep that is to be solved.
struct LemkeTry {
  std::uint32_t cell = 0;   ///< its number in the sweep
  double time_limit_s = 0;  ///< wall clock, on the cell's own path
};

/// The end of a path, and the cells that take this path.
struct LemkeLeaf {
  std::vector<std::uint32_t> cells;  ///< ascending
  Answer answer;
  double wall_s = 0;  ///< of the path alone, in part extrapolated where it cycles; see lemke::Leaf
  double cpu_s = 0;   ///< likewise, of this thread
};

// A sweep is not a Solver. These do for it what Solver does for methods that do not take compliance.

/// The problem, or the rigid equivalent if its contacts are soft.
Problem without_compliance(const Problem& problem);

/// Withdraws the claim kSolved if z solves only `rigid`, the rigid equivalent of `given` (see creeps_as_given).
void return_to_given(const Problem& given, const Problem& rigid, Answer& answer);

/// Lemke's method at many pairs of tolerances: each pivot that paths have in common is done once.
///
/// Answers are bit for bit those of `Lemke` with each pair; see docs/reference/solvers/lemke.md. Memory beyond that of
/// one Lemke: a saved basis for each point at which the present path has parted from others, fewer than cells. A saved
/// basis is the kernel (k^2 doubles, k basic z and z0) and some vectors; with rules=2012 three vectors of n.
class LemkeSweep {
 public:
  /// @param cells at least one; all with engine=kernel or rules=2012, with test=none, and alike but for the two
  ///     tolerances
  /// @param level  of the engine; must not exceed best_isa_level()
  LemkeSweep(std::span<const LemkeSettings> cells, IsaLevel level = isa_level());

  /// Reads settings of `lemke`. Returns nothing if there are no cells, if they differ in more than the tolerances, if
  /// the engine is dense, or if `test` is not none. So test=auto, the default, is refused even where it means none.
  /// @throws InputError
  static std::optional<std::vector<LemkeSettings>> readable(std::span<const Options> cells);

  /// As Solver::load.
  void load(const Problem& problem);

  /// Replaces `leaves` by the ends of the paths of these cells, in any order; a cell named twice stands in its leaf
  /// twice. Refused problems have one leaf, kUnsupported. Returns the number of pivots done: shared ones count once.
  /// @pre load()
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

/// SolverDefinition::make_swept of `lemke`: null where LemkeSweep::readable returns nothing. @throws InputError
std::unique_ptr<SweptSolver> make_swept_lemke(const std::vector<Options>& cells);

}  // namespace lcpbench
