#pragma once

#include <span>
#include <variant>
#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"
#include "core/problem.h"

namespace lcpbench {

/// J's column times v. @pre J has rows
inline double dot_column(const Jacobian& J, Index column, const Vector& v) {
  return std::visit([&](const auto& matrix) { return matrix.col(column).dot(v); }, J);
}

/// Cuts parts out of a contact problem.
class ProblemCutter {
 public:
  explicit ProblemCutter(const Problem& whole);

  const ContactProblem& whole() const { return *whole_; }
  const Problem& problem() const { return problem_; }
  const ContactLayout& layout() const { return layout_; }

  /// The problem of some contacts on the coordinates of their island, v as given (ngc of the whole).
  /// @param with_friction false: as if the contacts had no edges
  ContactProblem cut(std::span<const Index> contacts, std::span<const Index> coordinates, const Vector& v,
                     bool with_friction);

  /// Those of an island's coordinates that belong to bodies (blocks of the inertia) which the contacts touch,
  /// ascending.
  /// @pre block inertia @param coordinates of the island, ascending
  std::vector<Index> moved(std::span<const Index> contacts, std::span<const Index> coordinates) const;

  /// Per body (block of the inertia), 1 for those that one of the contacts touches. @pre block inertia
  std::vector<char> bodies_of(std::span<const Index> contacts) const;

  /// Whether the contact touches one of them. @param bodies as of bodies_of()
  bool touches(Index contact, const std::vector<char>& bodies) const;

 private:
  template <class Visit>
  void for_each_row(Index contact, Visit&& visit) const;
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
