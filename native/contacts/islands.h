#pragma once

#include <span>
#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"
#include "core/problem.h"

namespace lcpbench {

/// Cuts parts out of a contact problem.
class ProblemCutter {
 public:
  explicit ProblemCutter(const Problem& whole);

  const ContactProblem& whole() const { return *whole_; }
  const Problem& problem() const { return problem_; }
  const ContactLayout& layout() const { return layout_; }

  /// The problem of some contacts on the coordinates of their island, v as given (ngc of the whole).
  /// @pre both ascend, and nothing couples the coordinates to others
  /// @param with_friction false: as if the contacts had no edges
  ContactProblem cut(std::span<const Index> contacts, std::span<const Index> coordinates, const Vector& v,
                     bool with_friction);

 private:
  Inertia cut_inertia(std::span<const Index> coordinates) const;
  std::size_t block_of(Index coordinate) const { return block_of_[static_cast<std::size_t>(coordinate)]; }
  BlockInertia cut_blocks(const BlockInertia& inertia, std::span<const Index> coordinates) const;

  Problem problem_;
  const ContactProblem* whole_;
  ContactLayout layout_;
  std::vector<Index> local_;           ///< of each coordinate of the whole; -1 between calls
  std::vector<Index> block_begin_;     ///< of block inertia: first coordinate of each block, and their number
  std::vector<std::size_t> block_of_;  ///< of block inertia: the block that each coordinate is in
};

}  // namespace lcpbench
