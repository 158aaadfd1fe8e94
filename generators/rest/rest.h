#pragma once

#include "generators/made/made.h"

// Contact problems whose bodies can come to rest, or cannot, by construction: each is a step of 5 ms that begins at
// rest, under gravity and pressing forces.

namespace lcpbench {

namespace rest {
class Scene;
}

struct RestReading {
  double margin = 0;  ///< 0: drawn, from 1.02 to 100
  std::int64_t nc_max = 200;
};

struct RestFeatures {
  void (*build)(rest::Scene&) = nullptr;
};

using RestSet = ExperimentSet<RestFeatures, RestReading>;

/// rest/<class>, in alphabetical order.
const std::vector<RestSet>& rest_sets();

/// One trial, bit for bit on every processor with IEEE doubles. With a margin above 1, impulses balance the load up to
/// rounding that lie in the friction pyramids of mu / margin, and press no contact with a positive offset: v+ = 0 is a
/// solution. With a margin below 1 no impulses in the friction cones balance it, nor would any in round cones.
MadeSample draw_rest(const RestSet& set, const RestReading& reading, std::uint64_t seed, std::uint64_t trial);

}  // namespace lcpbench
