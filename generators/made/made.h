#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "generators/column_major.h"
#include "generators/experiment_set.h"

// Contact problems of bodies and mechanisms that a short program each makes: masonry, grains, machines. Sizes, friction
// coefficients, edges, masses, velocities and offsets are drawn anew for each trial, over wide ranges.

namespace lcpbench {

namespace made {
class Scene;
}

/// Velocities before the impact, beside one step of gravity: none, slow ones, or fast ones.
enum class MadeMotion { kDrawn, kRest, kSlide, kImpact };

/// Edges of the friction pyramid, the same for all contacts of a problem; 0: no friction.
enum class MadeEdges { kDrawn = -1, k0 = 0, k2 = 2, k4 = 4, k6 = 6, k8 = 8, k12 = 12, k16 = 16 };

/// The options of a set; MadeSettings in made.cpp says what each means.
struct MadeReading {
  std::int64_t nc_min = 10;
  std::int64_t nc_max = 1000;
  double mu_min = 0;
  double mu_max = 2;
  MadeEdges edges = MadeEdges::kDrawn;
  double offsets = 0.5;
  double mass_ratio = 1;
  MadeMotion motion = MadeMotion::kDrawn;
};

struct MadeFeatures {
  void (*build)(made::Scene&) = nullptr;
  std::int64_t nc_max = 0;
  bool held_out = false;  ///< whatever is fitted to measurements must not see this set
};

/// One problem in plain arrays; symbols and shapes as in ContactProblem.
struct MadeSample {
  using Column = std::vector<std::pair<std::size_t, double>>;  ///< (row, entry), rows ascending, no entry is zero

  std::vector<double> v;
  std::vector<ColumnMajor<double>> blocks;  ///< of the inertia, in order, each symmetric positive definite
  bool is_dense = false;                    ///< inertia, N and D are written whole
  std::vector<Column> N;
  std::vector<Column> D;
  std::vector<int> edges;
  std::vector<double> mu;
  std::vector<double> b;
};

using MadeSet = ExperimentSet<MadeFeatures, MadeReading>;

/// made/<class>, in alphabetical order.
const std::vector<MadeSet>& made_sets();

/// One trial: a function of its arguments alone, bit for bit on every processor with IEEE doubles.
MadeSample draw_made(const MadeSet& set, const MadeReading& reading, std::uint64_t seed, std::uint64_t trial);

}  // namespace lcpbench
