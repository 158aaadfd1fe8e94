#include "native/sor/ode_order.h"

#include <utility>

namespace lcpbench {
namespace {

/// How many of the lower bits decide a number below `count`: ODE's ranges end at 2, 4, 16, 2^8 and 2^16.
int deciding_bits(std::uint32_t count) {
  for (const int bits : {1, 2, 4, 8, 16}) {
    if (count <= std::uint32_t{1} << bits) return bits;
  }
  return 32;
}

/// The contacts of each body, the last one first.
std::vector<std::vector<Index>> contacts_of_bodies(const RigidScene& scene) {
  std::vector<std::vector<Index>> contacts(scene.bodies.size());
  for (std::size_t i = scene.contacts.size(); i-- > 0;) {
    const RigidContact& contact = scene.contacts[i];
    contacts[static_cast<std::size_t>(contact.body_a)].push_back(static_cast<Index>(i));
    if (contact.body_b != RigidContact::kWorld) {
      contacts[static_cast<std::size_t>(contact.body_b)].push_back(static_cast<Index>(i));
    }
  }
  return contacts;
}

class IslandWalk {
 public:
  explicit IslandWalk(const RigidScene& scene)
      : scene_(scene),
        contacts_(contacts_of_bodies(scene)),
        body_seen_(scene.bodies.size()),
        contact_seen_(scene.contacts.size()) {}

  bool seen(std::size_t body) const { return body_seen_[body]; }

  std::vector<Index> from(std::size_t first) {
    std::vector<Index> island;
    std::vector<std::size_t> waiting{first};
    body_seen_[first] = true;
    while (!waiting.empty()) {
      const std::size_t body = waiting.back();
      waiting.pop_back();
      for (const Index contact : contacts_[body]) take(contact, body, island, waiting);
    }
    return island;
  }

 private:
  void take(Index index, std::size_t body, std::vector<Index>& island, std::vector<std::size_t>& waiting) {
    const auto c = static_cast<std::size_t>(index);
    if (contact_seen_[c]) return;
    contact_seen_[c] = true;
    island.push_back(index);
    const RigidContact& contact = scene_.contacts[c];
    const int other = static_cast<std::size_t>(contact.body_a) == body ? contact.body_b : contact.body_a;
    if (other == RigidContact::kWorld || body_seen_[static_cast<std::size_t>(other)]) return;
    body_seen_[static_cast<std::size_t>(other)] = true;
    waiting.push_back(static_cast<std::size_t>(other));
  }

  const RigidScene& scene_;
  std::vector<std::vector<Index>> contacts_;
  std::vector<bool> body_seen_;
  std::vector<bool> contact_seen_;
};

}  // namespace

std::uint32_t OdeRandom::below(std::uint32_t count) {
  state_ = 1664525U * state_ + 1013904223U;
  const int bits = deciding_bits(count);
  std::uint32_t word = state_;
  for (int shift = 16; shift >= bits; shift /= 2) word ^= word >> shift;
  const std::uint64_t range = std::uint64_t{1} << bits;
  return static_cast<std::uint32_t>((word & (range - 1)) * count >> bits);
}

void shuffle(std::vector<Index>& order, OdeRandom& random) {
  for (std::size_t i = 1; i < order.size(); ++i) {
    std::swap(order[i], order[random.below(static_cast<std::uint32_t>(i + 1))]);
  }
}

std::vector<std::vector<Index>> ode_islands(const RigidScene& scene) {
  IslandWalk walk(scene);
  std::vector<std::vector<Index>> islands;
  for (std::size_t body = scene.bodies.size(); body-- > 0;) {
    if (walk.seen(body)) continue;
    std::vector<Index> island = walk.from(body);
    if (!island.empty()) islands.push_back(std::move(island));
  }
  return islands;
}

}  // namespace lcpbench
