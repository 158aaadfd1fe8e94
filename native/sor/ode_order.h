#pragma once

#include <cstdint>
#include <vector>

#include "core/scene.h"

// The order in which ODE 0.16 goes through the rows of a step: a method makes the same iterates only in this order.

namespace lcpbench {

/// ODE's random numbers (dRandSetSeed, dRandInt): a linear congruential generator with 32 bits whose upper bits are
/// folded into the lower ones for small ranges. ODE has one sequence per process; here each object has its own.
class OdeRandom {
 public:
  explicit OdeRandom(std::uint32_t seed) : state_(seed) {}

  /// 0, ..., count - 1, as dRandInt(count). One step of the generator. @pre count > 0
  std::uint32_t below(std::uint32_t count);

 private:
  std::uint32_t state_;
};

/// ODE's shuffle of the rows of an island, which ODE does after every eight sweeps: each place from the second on is
/// exchanged with itself or an earlier one.
void shuffle(std::vector<Index>& order, OdeRandom& random);

/// The contacts of each island, in the order of their rows; the islands in the order in which they are solved. Contacts
/// between bodies connect them to islands; a contact with the world belongs to its body's. ODE puts new bodies and
/// contacts at the head of its lists and walks from body to body depth first; the order is that of a world to which
/// bodies and contacts were added as listed in the scene. Bodies without contacts make no island.
/// O(bodies + contacts).
std::vector<std::vector<Index>> ode_islands(const RigidScene& scene);

}  // namespace lcpbench
