#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// Identifies a contact from step to step, as a rule unique within a step: a number for its two bodies and the feature
/// (vertex, edge or face) that touches, as engines give it.
using ContactId = std::uint64_t;

/// The id of a name as scenes files have it (`contact_ids`): FNV-1a in 64 bits. Two names of one step may get the same
/// id. This makes a warm start less useful, but no answer wrong.
ContactId contact_id(std::string_view name);

/// Finds contacts of one step in the step before. Keeps its memory: a call allocates only when one of its
/// steps has more contacts than all steps of earlier calls.
class ContactMatch {
 public:
  /// O(contacts) where both steps have the same contacts in the same order, else O(contacts log contacts). A contact
  /// whose id is repeated is matched with any contact before that has this id, several perhaps with the same one.
  void find(std::span<const ContactId> before, std::span<const ContactId> now);

  /// For each contact of now its index in the step before; -1 when it is new.
  const std::vector<Index>& before() const { return before_; }
  /// Number of contacts of now that are not new.
  Index matched() const { return matched_; }

 private:
  Index find_sorted(std::span<const ContactId> before, ContactId id);

  std::vector<Index> before_;
  std::vector<Index> sorted_;  // indices of the contacts before, ascending by id; empty until needed
  Index matched_ = 0;
};

/// Writes into `start` (resized) the answer z of the step before as a guess at the answer now: f_N, f_D and lambda of
/// each contact that was there, f_N alone where its number of edges changed, zero for those that are new; and
/// f_R where there are as many bounded rows as before, which keep their order. It is a guess: solvers check what they
/// get from it as they check every answer. O(n); allocates where `start` has to grow.
/// @param layout_before, layout_now  of the two problems @param match  of their contacts
/// @pre z has layout_before.size() entries and is not `start`; match.before() has layout_now.nc
void matched_start(const Vector& z, const ContactLayout& layout_before, const ContactMatch& match,
                   const ContactLayout& layout_now, Vector& start);

}  // namespace lcpbench
