#pragma once

#include <span>
#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"
#include "core/problem.h"

namespace lcpbench {

/// Cuts islands out of a contact problem, without going through its other contacts and coordinates each time. Uses its
/// own memory and that of the parts again.
class ProblemCutter {
 public:
  /// @param whole  has contacts
  void load(const Problem& whole);

  const ContactProblem& whole() const { return *whole_; }
  const Problem& problem() const { return problem_; }
  const ContactLayout& layout() const { return layout_; }

  /// part := the problem of some contacts on the coordinates of their island, v as given (ngc of the whole).
  /// @pre both ascend, and nothing couples the coordinates to others
  /// @param with_friction false: as if the contacts had no edges
  /// @param part  what it held is lost: nobody else may read it
  void cut(std::span<const Index> contacts, std::span<const Index> coordinates, const Vector& v, bool with_friction,
           ContactProblem& part);

 private:
  Problem problem_;
  const ContactProblem* whole_ = nullptr;
  ContactLayout layout_;
  std::vector<Index> local_;         ///< of each coordinate of the whole: its index in the part; -1 between calls
  std::vector<Index> directions_;    ///< of a part
  std::vector<Index> block_begins_;  ///< of block inertia, see block_begins()
};

}  // namespace lcpbench
