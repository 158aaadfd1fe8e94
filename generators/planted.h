#pragma once

#include <cstdint>
#include <vector>

#include "generators/column_major.h"
#include "generators/experiment_set.h"

// Symmetric positive definite LCPs around a solution that was drawn first: easy problems with an answer that is known
// without any solver, on which every solver that claims the class has to be right.

namespace lcpbench {

/// How the problem is handed out: as frictionless contacts (v = q, N = I, G* = M), or as (q, M) alone.
enum class PlantedForm { kContact, kLcp };

struct PlantedReading {
  PlantedForm form = PlantedForm::kContact;
  std::int64_t n_max = 20;
  double condition = 1e4;
};

/// w = M z + q holds exactly in the doubles below: M on the 2^-36 grid, z on 2^-8, w on 2^-20, q on 2^-44.
struct PlantedSample {
  ColumnMajor<double> M;  ///< n x n, symmetric, eigenvalues from 1/condition to 1 up to the rounding to its grid
  std::vector<double> q;
  std::vector<double> z;  ///< the only solution: in each row z > 0 and w = 0, or z = 0 and w > 0
  std::vector<double> w;
};

struct PlantedFeatures {};
using PlantedSet = ExperimentSet<PlantedFeatures, PlantedReading>;

/// planted/definite.
const std::vector<PlantedSet>& planted_sets();

/// One trial: a function of its arguments alone, bit for bit on every processor with IEEE doubles.
/// O(n^3), about 8 sweeps of Jacobi rotations.
PlantedSample draw_planted(const PlantedSet& set, const PlantedReading& reading, std::uint64_t seed,
                           std::uint64_t trial);

}  // namespace lcpbench
