#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "generators/paper/paper.h"

// Random rigid bodies with point contacts, without and with friction. They are the counterparts of Experiments 1, 2, 5
// and 6 of the paper for physics engines: an engine takes these scenes, but not the dense random columns of the
// paper.

namespace lcpbench {

/// Directions of normals and tangents: any, or along the coordinate axes.
enum class NormalReading { kGeneral, kAxis };

/// Edges of the friction pyramid. Engines have four; more is another model of the same contact.
enum class PyramidEdges { k4 = 4, k8 = 8, k16 = 16 };

struct RigidReading {
  Redundancy redundancy = Redundancy::kMultiple;
  NormalReading normals = NormalReading::kGeneral;
  PyramidEdges edges = PyramidEdges::k4;  ///< of frictional sets
  std::int64_t bodies_max = 4;
  std::int64_t nc_max = 20;
};

struct RigidFeatures {
  bool frictional = false;
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

/// Symbols as in RigidContact; body_b = -1 is the world. Point on the 2^-10 grid, normal and tangent on the 2^-40 grid:
/// the rows [n; r x n] and [t; r x t] are then exact in double. mu on the 2^-20 grid.
struct RigidContactSample {
  int body_a = 0;
  int body_b = -1;
  Triple point{};
  Triple normal{};
  Triple tangent{};  ///< orthogonal to the normal within 2e-12; zero without friction
  double mu = 0;
};

/// 4 row(contact) = (4 - quarter) row(first) + quarter row(second), exactly, for the normal and the first tangent.
struct RigidDependence {
  std::size_t contact = 0;
  std::size_t first = 0;
  std::size_t second = 0;
  int quarter = 0;
};

struct RigidSample {
  std::vector<RigidBodySample> bodies;
  std::vector<RigidContactSample> contacts;
  int edges = 0;                             ///< of every contact: 0 without friction
  std::vector<RigidDependence> dependences;  ///< how the sample came about, not part of the problem
};

using RigidSet = ExperimentSet<RigidFeatures, RigidReading>;

/// rigid/exp1, exp2, exp5-*, exp6-*, then rigid/frictional/exp1, ... alike: the same scenes with friction.
const std::vector<RigidSet>& rigid_sets();

/// One trial: a function of its arguments alone, bit for bit on every processor with IEEE doubles. O(contacts +
/// bodies) on average: some draws are rejected and repeated. @pre `reading` is within the ranges of the set's options
RigidSample draw_rigid(const RigidSet& set, const RigidReading& reading, std::uint64_t seed, std::uint64_t trial);

/// The first half of the friction directions of a pyramid with this many edges, at angles 2 pi k / edges from the
/// tangent in the plane across the normal; the other half are their negatives. On the 2^-40 grid: their rows are exact.
/// The directions of 8 edges are among those of 16. Only for 8 and 16: with 4, the scene has them.
std::vector<Triple> friction_directions(const RigidContactSample& contact, PyramidEdges edges);

}  // namespace lcpbench
