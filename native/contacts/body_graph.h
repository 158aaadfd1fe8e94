#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// The bodies of an island that contacts touch along their normals, and the contacts of each body.
class BodyGraph {
 public:
  /// Memory for problems of this size whose contacts touch two bodies each. @pre BlockInertia
  void reserve(const ContactProblem& contact);

  /// Mean number of bodies whose removal cuts the bodies of an island in two, as coordinates: those of a level of a
  /// breadth-first search over contacts, from a body at an end. A sparse factorization of the island has a dense block
  /// of about this order, and costs about its cube. A stack has 6, a wall grows with the root of its bodies, a pile
  /// with the power 2/3. O(bodies and contacts); allocates only what was not reserved. @pre BlockInertia, one island
  double separator_size(const ContactProblem& contact);

 private:
  struct Search {
    std::size_t reached = 0;
    std::size_t levels = 0;
    std::size_t last = 0;
  };
  static constexpr std::size_t kMostBodies = 2;  ///< of a contact

  void build(const ContactProblem& contact);
  Search search(std::size_t from);

  std::vector<std::size_t> body_of_;                   ///< by coordinate
  std::vector<std::size_t> body_begin_, bodies_;       ///< by contact
  std::vector<std::size_t> contact_begin_, contacts_;  ///< by body
  std::vector<std::size_t> next_, queue_;
  std::vector<char> is_seen_;
};

}  // namespace lcpbench
