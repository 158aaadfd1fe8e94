#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/settings.h"
#include "generators/paper.h"

// Random rigid bodies with frictionless point contacts: the counterpart, for physics engines, of those experiments of
// the paper that have one. An engine cannot be given the paper's dense random columns; it can be given these scenes.

namespace lcpbench {

enum class NormalReading { kGeneral, kAxis };

struct RigidReading {
  Redundancy redundancy = Redundancy::kMultiple;
  NormalReading normals = NormalReading::kGeneral;
  std::int64_t bodies_max = 4;
  std::int64_t nc_max = 20;
};

struct RigidFeatures {
  bool redundant = false;
  bool conditioned = false;
};

using Triple = std::array<double, 3>;

/// Symbols and units as in RigidBody. Position on the 2^-10 grid, velocities on the 2^-20 grid.
struct RigidBodySample {
  double mass = 0;
  ColumnMajor<double> inertia;  ///< 3 x 3, symmetric, of a mass distribution that exists
  Triple position{};
  Triple linear_velocity{};
  Triple angular_velocity{};
};

/// Symbols as in RigidContact; body_b = -1 is the world. Point on the 2^-10 grid, normal on the 2^-40 grid: the
/// contact's row [n; r x n] is then exact in double.
struct RigidContactSample {
  int body_a = 0;
  int body_b = -1;
  Triple point{};
  Triple normal{};
};

/// 4 row(contact) = (4 - quarter) row(first) + quarter row(second), exactly.
struct RigidDependence {
  std::size_t contact = 0;
  std::size_t first = 0;
  std::size_t second = 0;
  int quarter = 0;
};

struct RigidSample {
  std::vector<RigidBodySample> bodies;
  std::vector<RigidContactSample> contacts;
  std::vector<RigidDependence> dependences;  ///< how the sample came about, not part of the problem
};

struct RigidSet {
  std::string name;
  std::string stream;  ///< name of its random stream: that of another set when the problems are the same
  std::string summary;
  RigidFeatures features;
  double condition = 0;  ///< 0 unless features.conditioned

  std::vector<SettingInfo> (*options)() = nullptr;
  RigidReading (*parse)(std::string_view owner, const Options&) = nullptr;  ///< throws InputError
  Options (*changed)(std::string_view owner, const Options&) = nullptr;  ///< off their defaults, in declaration order
};

/// rigid/exp1, exp2, exp5-*, exp6-*.
const std::vector<RigidSet>& rigid_sets();

/// One trial: a function of its arguments alone, bit for bit on every processor with IEEE doubles. O(contacts +
/// bodies).
RigidSample draw_rigid(const RigidSet& set, const RigidReading& reading, std::uint64_t seed, std::uint64_t trial);

}  // namespace lcpbench
