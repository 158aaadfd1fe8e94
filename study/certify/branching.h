#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/lcp.h"
#include "study/certify/certificate.h"
#include "study/certify/deadline.h"
#include "study/certify/exact_system.h"

namespace lcpbench::exact {

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
/// @param lcp  `system`, rounded to doubles. @throws TimePassed
BranchingOutcome branch(const Lcp& lcp, const ExactSystem& system, const Deadline& deadline,
                        const AcceptsVertex& accepts);

}  // namespace lcpbench::exact
