#include "native/auto/separator.h"

#include <algorithm>
#include <cstddef>
#include <variant>
#include <vector>

#include "native/contacts/contact_edges.h"

namespace lcpbench {
namespace {

/// The bodies that contacts touch along their normals, and the contacts of each body.
class BodyGraph {
 public:
  explicit BodyGraph(const ContactProblem& contact) {
    std::vector<std::size_t> body_of;
    const auto& blocks = std::get<BlockInertia>(contact.inertia).blocks;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      body_of.insert(body_of.end(), static_cast<std::size_t>(blocks[b].rows()), b);
    }
    body_begin_.assign(1, 0);
    for (Index c = 0; c < contact.nc(); ++c) {
      for_each_entry(contact.N, c, [&](Index row, double) {
        const std::size_t body = body_of[static_cast<std::size_t>(row)];
        if (bodies_.size() == body_begin_.back() || bodies_.back() != body) bodies_.push_back(body);
      });
      body_begin_.push_back(bodies_.size());
    }
    contact_begin_.assign(blocks.size() + 1, 0);
    for (const std::size_t body : bodies_) ++contact_begin_[body + 1];
    for (std::size_t b = 0; b < blocks.size(); ++b) contact_begin_[b + 1] += contact_begin_[b];
    contacts_.resize(bodies_.size());
    std::vector<std::size_t> next(contact_begin_.begin(), contact_begin_.end() - 1);
    for (std::size_t c = 0; c + 1 < body_begin_.size(); ++c) {
      for (std::size_t k = body_begin_[c]; k < body_begin_[c + 1]; ++k) contacts_[next[bodies_[k]]++] = c;
    }
  }

  std::size_t first() const { return bodies_.empty() ? 0 : bodies_.front(); }

  struct Search {
    std::size_t reached = 0;
    std::size_t levels = 0;
    std::size_t last = 0;
  };
  /// Level by level from a body.
  Search search(std::size_t from) const {
    std::vector<char> is_seen(contact_begin_.size(), 0);
    std::vector<std::size_t> queue{from};
    is_seen[from] = 1;
    Search found;
    for (std::size_t begin = 0; begin < queue.size(); ++found.levels) {
      const std::size_t end = queue.size();
      for (; begin < end; ++begin) {
        for (std::size_t k = contact_begin_[queue[begin]]; k < contact_begin_[queue[begin] + 1]; ++k) {
          for (std::size_t l = body_begin_[contacts_[k]]; l < body_begin_[contacts_[k] + 1]; ++l) {
            if (is_seen[bodies_[l]] != 0) continue;
            is_seen[bodies_[l]] = 1;
            queue.push_back(bodies_[l]);
          }
        }
      }
    }
    found.reached = queue.size();
    found.last = queue.back();
    return found;
  }

 private:
  std::vector<std::size_t> body_begin_, bodies_;       // by contact
  std::vector<std::size_t> contact_begin_, contacts_;  // by body
};

}  // namespace

double separator_size(const ContactProblem& contact) {
  const std::size_t bodies = std::get<BlockInertia>(contact.inertia).blocks.size();
  if (bodies == 0 || contact.nc() == 0) return 0;
  const BodyGraph graph(contact);
  const BodyGraph::Search found = graph.search(graph.search(graph.first()).last);
  const double coordinates = static_cast<double>(contact.ngc()) / static_cast<double>(bodies);
  return coordinates * static_cast<double>(found.reached) / static_cast<double>(found.levels);
}

}  // namespace lcpbench
