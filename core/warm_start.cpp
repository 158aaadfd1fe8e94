#include "core/warm_start.h"

#include <algorithm>
#include <numeric>

namespace lcpbench {

ContactId contact_id(std::string_view name) {
  ContactId id = 0xcbf29ce484222325U;
  for (const char c : name) id = (id ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return id;
}

void ContactMatch::find(std::span<const ContactId> before, std::span<const ContactId> now) {
  before_.resize(now.size());
  sorted_.clear();
  sorted_.reserve(std::max(before.size(), now.size()));  // now is before in the next step
  matched_ = 0;
  std::size_t expected = 0;  // index before of the contact that comes next if the order is kept
  for (std::size_t k = 0; k < now.size(); ++k) {
    const bool is_next = expected < before.size() && before[expected] == now[k];
    before_[k] = is_next ? static_cast<Index>(expected) : find_sorted(before, now[k]);
    if (before_[k] < 0) continue;
    ++matched_;
    expected = static_cast<std::size_t>(before_[k]) + 1;
  }
}

Index ContactMatch::find_sorted(std::span<const ContactId> before, ContactId id) {
  const auto id_of = [&](Index k) { return before[static_cast<std::size_t>(k)]; };
  if (sorted_.size() != before.size()) {
    sorted_.resize(before.size());
    std::iota(sorted_.begin(), sorted_.end(), Index{0});
    std::sort(sorted_.begin(), sorted_.end(), [&](Index a, Index b) { return id_of(a) < id_of(b); });
  }
  const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), id,
                                      [&](Index k, ContactId wanted) { return id_of(k) < wanted; });
  return found != sorted_.end() && id_of(*found) == id ? *found : -1;
}

void matched_start(const Vector& z, const ContactLayout& layout_before, const ContactMatch& match,
                   const ContactLayout& layout_now, Vector& start) {
  start.setZero(layout_now.size());
  if (layout_now.rows == layout_before.rows) start.tail(layout_now.rows) = z.tail(layout_now.rows);
  for (std::size_t c = 0; c < match.before().size(); ++c) {
    if (match.before()[c] < 0) continue;
    const auto was = static_cast<std::size_t>(match.before()[c]);
    start(static_cast<Index>(c)) = z(match.before()[c]);
    const Index from = layout_before.friction_begin[was];
    const Index to = layout_now.friction_begin[c];
    const Index edges = layout_now.friction_begin[c + 1] - to;
    if (edges == 0 || layout_before.friction_begin[was + 1] - from != edges) continue;
    std::copy_n(z.data() + layout_before.friction_offset() + from, edges,
                start.data() + layout_now.friction_offset() + to);
    start(layout_now.lambda_offset() + layout_now.lambda[c]) =
        z(layout_before.lambda_offset() + layout_before.lambda[was]);
  }
}

}  // namespace lcpbench
