#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// The name of a contact that it keeps from step to step, as a rule unique in its step: the pair of bodies and the
/// feature, as engines number them.
using ContactId = std::uint64_t;

/// The id of a name as scenes files have it (`contact_ids`): FNV-1a in 64 bits. Two names of one step may get the same
/// id, which costs a warm start some of its use and no answer its truth.
ContactId contact_id(std::string_view name);

/// Finds contacts of one step in the step before. Keeps its memory: a step with no more contacts than one before
/// allocates nothing.
class ContactMatch {
 public:
  /// O(contacts) where both steps list them in one order, else O(contacts log contacts). Of ids that appear more than
  /// once some are matched.
  void find(std::span<const ContactId> before, std::span<const ContactId> now);

  /// For each contact of now its index before, -1: it is new.
  const std::vector<Index>& before() const { return before_; }
  /// Contacts of now that are not new.
  Index matched() const { return matched_; }

 private:
  Index find_sorted(std::span<const ContactId> before, ContactId id);

  std::vector<Index> before_;
  std::vector<Index> sorted_;  // indices by id; empty until it is needed
  Index matched_ = 0;
};

/// Writes into `start` (resized) the answer z of the step before as a guess at the answer now: f_N, f_D and lambda of
/// each contact that was there, f_N alone where its number of edges changed, zero for those that are new. It is a
/// guess: solvers that use it prove their answer as they prove every other. O(n); allocates where `start` has to grow.
/// @param layout_before, layout_now of the two problems @param match of their contacts
/// @pre z has layout_before.size() entries, match.before() has layout_now.nc
void matched_start(const Vector& z, const ContactLayout& layout_before, const ContactMatch& match,
                   const ContactLayout& layout_now, Vector& start);

}  // namespace lcpbench
