#include "native/contacts/body_graph.h"

#include <variant>

#include "core/entries.h"

namespace lcpbench {

void BodyGraph::reserve(const ContactProblem& contact) {
  const auto bodies = std::get<BlockInertia>(contact.inertia).blocks.size();
  const auto contacts = static_cast<std::size_t>(contact.nc());
  body_of_.reserve(static_cast<std::size_t>(contact.ngc()));
  body_begin_.reserve(contacts + 1);
  bodies_.reserve(kMostBodies * contacts);
  contacts_.reserve(kMostBodies * contacts);
  for (auto* per_body : {&contact_begin_, &next_, &queue_}) per_body->reserve(bodies + 1);
  is_seen_.reserve(bodies + 1);
}

void BodyGraph::build(const ContactProblem& contact) {
  const auto& blocks = std::get<BlockInertia>(contact.inertia).blocks;
  body_of_.clear();
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    body_of_.insert(body_of_.end(), static_cast<std::size_t>(blocks[b].rows()), b);
  }
  bodies_.clear();
  body_begin_.assign(1, 0);
  for (Index c = 0; c < contact.nc(); ++c) {
    for_each_entry(contact.N, c, [&](Index row, double) {
      const std::size_t body = body_of_[static_cast<std::size_t>(row)];
      if (bodies_.size() == body_begin_.back() || bodies_.back() != body) bodies_.push_back(body);
    });
    body_begin_.push_back(bodies_.size());
  }
  contact_begin_.assign(blocks.size() + 1, 0);
  for (const std::size_t body : bodies_) ++contact_begin_[body + 1];
  for (std::size_t b = 0; b < blocks.size(); ++b) contact_begin_[b + 1] += contact_begin_[b];
  contacts_.resize(bodies_.size());
  next_.assign(contact_begin_.begin(), contact_begin_.end() - 1);
  for (std::size_t c = 0; c + 1 < body_begin_.size(); ++c) {
    for (std::size_t k = body_begin_[c]; k < body_begin_[c + 1]; ++k) contacts_[next_[bodies_[k]]++] = c;
  }
}

/// Level by level from a body.
BodyGraph::Search BodyGraph::search(std::size_t from) {
  is_seen_.assign(contact_begin_.size(), 0);
  queue_.assign(1, from);
  is_seen_[from] = 1;
  Search found;
  for (std::size_t begin = 0; begin < queue_.size(); ++found.levels) {
    const std::size_t end = queue_.size();
    for (; begin < end; ++begin) {
      for (std::size_t k = contact_begin_[queue_[begin]]; k < contact_begin_[queue_[begin] + 1]; ++k) {
        for (std::size_t l = body_begin_[contacts_[k]]; l < body_begin_[contacts_[k] + 1]; ++l) {
          if (is_seen_[bodies_[l]] != 0) continue;
          is_seen_[bodies_[l]] = 1;
          queue_.push_back(bodies_[l]);
        }
      }
    }
  }
  found.reached = queue_.size();
  found.last = queue_.back();
  return found;
}

double BodyGraph::separator_size(const ContactProblem& contact) {
  const std::size_t bodies = std::get<BlockInertia>(contact.inertia).blocks.size();
  if (bodies == 0 || contact.nc() == 0) return 0;
  build(contact);
  const Search found = search(search(bodies_.empty() ? 0 : bodies_.front()).last);
  const double coordinates = static_cast<double>(contact.ngc()) / static_cast<double>(bodies);
  return coordinates * static_cast<double>(found.reached) / static_cast<double>(found.levels);
}

}  // namespace lcpbench
