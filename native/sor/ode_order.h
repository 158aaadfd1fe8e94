#pragma once

#include <cstdint>
#include <vector>

#include "core/scene.h"

// The order in which ODE 0.16 goes through the rows of a step: what a method has to repeat to make the same iterates.

namespace lcpbench {

/// ODE's process-wide random numbers, here one sequence per object: a linear congruential generator with 32 bits whose
/// upper bits are folded into the lower ones for small ranges (dRandSetSeed, dRandInt).
class OdeRandom {
 public:
  explicit OdeRandom(std::uint32_t seed) : state_(seed) {}

  /// 0, ..., count - 1, as dRandInt(count). One step of the generator. @pre count > 0
  std::uint32_t below(std::uint32_t count);

 private:
  std::uint32_t state_;
};

/// ODE's shuffle of the rows between two sweeps: each place from the second on is exchanged with itself or an earlier
/// one.
void shuffle(std::vector<Index>& order, OdeRandom& random);

/// The contacts of each island, in the order of its rows. Islands are bodies that touch each other, the world not
/// counted, and are solved one after the other. ODE puts new bodies and contacts at the head of its lists and walks
/// from body to body depth first; the order is that of a world to which bodies and contacts were added as the scene
/// lists them. Bodies without contacts make no island. O(bodies + contacts).
std::vector<std::vector<Index>> ode_islands(const RigidScene& scene);

}  // namespace lcpbench
