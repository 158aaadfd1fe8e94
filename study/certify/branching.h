#pragma once

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "core/lcp.h"
#include "study/certify/certificate.h"
#include "study/certify/deadline.h"
#include "study/certify/exact_system.h"
#include "study/certify/integer_solve.h"
#include "study/certify/reduction.h"

namespace lcpbench::exact {

/// y as integers, row by row, in the units of the problem; other rows are zero.
using Multipliers = std::vector<std::pair<Index, Integer>>;

/// Checks leaves of proofs by branching on one system: by multiplication over the integers alone.
class LeafCheck {
 public:
  /// @param system,deadline  outlive this. Every function @throws TimePassed.
  LeafCheck(const ExactSystem& system, const Deadline& deadline);

  /// False where K is singular: then nothing can be checked.
  bool possible() const { return system_.potentials() == 0 || K_.possible(); }

  /// y contradicts w = q + M z >= 0, z >= 0 with w_i = 0 where w_is_zero[i], z_i = 0 where z_is_zero[i]:
  /// q'y < 0, y_i >= 0 for the other w_i, (M'y)_j <= 0 for the other z_j.
  bool contradicts(const Multipliers& y, const std::vector<char>& w_is_zero, const std::vector<char>& z_is_zero) const;

  /// y that is zero but for `rows`, with (M'y)_j = 0 in `tight` and q'y = -1, up to a positive factor. Of equations
  /// that depend on each other a largest independent part is taken; no value where they contradict q'y = -1.
  std::optional<Multipliers> exact(const std::vector<Index>& rows, const std::vector<Index>& tight) const;

  /// The same with all rows and columns, by Lemke's method in integers; of small systems only. Where it ends at a
  /// solution of the system instead, that.
  std::optional<Multipliers> exact(const std::vector<char>& w_is_zero, const std::vector<char>& z_is_zero,
                                   std::optional<ExactPoint>& solution) const;

 private:
  const ExactSystem& system_;
  const Deadline& deadline_;
  std::vector<slong> row_shift_;
  Lifting K_;
  std::optional<ReducedSystem> small_;  ///< the potentials eliminated
};

/// The result of a search through all 2^n cones: a proof that none holds a solution, or a solution.
struct BranchingOutcome {
  std::vector<ProofNode> proof;  ///< empty unless every leaf was contradicted and checked
  bool solved = false;           ///< a vertex was accepted
  std::optional<ExactPoint> solution;  ///< found in integers
};

/// Whether a vertex, in floats, that is complementary to rounding leads to a solution.
using AcceptsVertex = std::function<bool(const Vector& z)>;

/// Branch and bound over the pairs (z_i, w_i): the relaxation in floats, in each node the pair whose z_i w_i is largest
/// is split into w_i = 0 and z_i = 0, each leaf is checked exactly. A leaf that is not confirmed leaves no proof; the
/// search goes on for a solution, until the deadline. No path is longer than n.
/// @param lcp  of `check`'s system, rounded to doubles
BranchingOutcome branch(const Lcp& lcp, const LeafCheck& check, const Deadline& deadline, const AcceptsVertex& accepts);

/// The certificate that `proof` gives.
void take_branches(std::vector<ProofNode> proof, Certificate& certificate);

}  // namespace lcpbench::exact
