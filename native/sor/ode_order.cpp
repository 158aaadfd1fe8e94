#include "native/sor/ode_order.h"

#include <utility>

namespace lcpbench {
namespace {

/// How many low bits of a random word dRandInt(count) uses. It treats counts up to 2, 4, 16, 2^8, 2^16 and above apart.
int bits_used(std::uint32_t count) {
  for (const int bits : {1, 2, 4, 8, 16}) {
    if (count <= std::uint32_t{1} << bits) return bits;
  }
  return 32;
}

/// The contacts of each body, as ODE lists them: the last one added comes first.
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

}  // namespace

std::uint32_t OdeRandom::below(std::uint32_t count) {
  state_ = 1664525U * state_ + 1013904223U;
  const int bits = bits_used(count);
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
  const std::vector<std::vector<Index>> contacts = contacts_of_bodies(scene);
  std::vector<bool> body_seen(scene.bodies.size());
  std::vector<bool> contact_seen(scene.contacts.size());
  std::vector<std::vector<Index>> islands;
  for (std::size_t first = scene.bodies.size(); first-- > 0;) {
    if (body_seen[first]) continue;
    body_seen[first] = true;
    std::vector<std::size_t> waiting{first};
    std::vector<Index> island;
    while (!waiting.empty()) {
      const std::size_t body = waiting.back();
      waiting.pop_back();
      for (const Index index : contacts[body]) {
        const auto c = static_cast<std::size_t>(index);
        if (contact_seen[c]) continue;
        contact_seen[c] = true;
        island.push_back(index);
        const RigidContact& contact = scene.contacts[c];
        const int other = static_cast<std::size_t>(contact.body_a) == body ? contact.body_b : contact.body_a;
        if (other == RigidContact::kWorld || body_seen[static_cast<std::size_t>(other)]) continue;
        body_seen[static_cast<std::size_t>(other)] = true;
        waiting.push_back(static_cast<std::size_t>(other));
      }
    }
    if (!island.empty()) islands.push_back(std::move(island));
  }
  return islands;
}

}  // namespace lcpbench
