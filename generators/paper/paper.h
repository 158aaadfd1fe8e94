#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "generators/column_major.h"
#include "generators/experiment_set.h"
#include "generators/random.h"
#include "generators/paper/spectrum.h"

// The random contact problems of Drumwright and Shell, "Extensive analysis of linear complementarity problem (LCP)
// solver performance on randomly generated rigid body contact problems" (IROS 2012): Algorithms III.1 (frictionless,
// monotone) and IV.1 (frictional, copositive), Experiments 1 to 6. Where the paper leaves a point open, each reading of
// it is a named option; docs/reference/generators.md gives the reasons.

namespace lcpbench {

enum class Redundancy { kMultiple, kCombination };
enum class Placement { kLast, kRandom };
enum class SizeReading { kText, kSwapped };
enum class EdgeReading { kShared, kPerContact };
enum class RankReading { kUpToFull, kBelowFull, kFromOne };
enum class MatrixReading { kPseudoInverse, kLiteral };
enum class InverseReading { kSvd, kPlain };
enum class WeightDistribution { kUniform, kOne, kWide };
enum class VectorDistribution { kUniform, kPositive, kBell };

/// One reading of the paper's open points.
struct PaperReading {
  Redundancy redundancy = Redundancy::kMultiple;
  Placement placement = Placement::kLast;
  SizeReading sizes = SizeReading::kText;
  EdgeReading edges = EdgeReading::kShared;
  RankReading rank = RankReading::kUpToFull;
  MatrixReading matrix = MatrixReading::kPseudoInverse;
  SpectrumMap spectrum = SpectrumMap::kLogLinear;
  WeightDistribution alpha = WeightDistribution::kUniform;
  VectorDistribution x = VectorDistribution::kUniform;
  double condition = 0;  ///< of the inertia, log-linear spectrum; 0: as drawn
  InverseReading inverse = InverseReading::kSvd;
  double cone_diagonal = 0;
  std::int64_t ngc_max = 15;
  std::int64_t nc_max = 20;
};

/// The variation of an experiment. It decides which readings matter, and therefore which options the set has.
struct PaperFeatures {
  bool frictional = false;
  bool redundant = false;    ///< some contacts depend on others
  bool reduced = false;      ///< inertia of random rank
  bool conditioned = false;  ///< spectrum of the inertia mapped into [1, condition]
  std::int64_t ngc_max = 15;
  std::int64_t nc_max = 20;
};

/// A contact whose columns are an integral combination of those of other, independent contacts.
struct Dependence {
  std::size_t contact = 0;
  std::vector<std::size_t> sources;
  std::vector<std::int64_t> factors;  ///< one for each source, none of them 0
};

enum class InertiaForm { kDense, kFactored, kInverse };

/// One problem in plain arrays; symbols and shapes as in ContactProblem. Every number except those of G is a multiple
/// of 2^-20 with far fewer than 53 bits, so that sums of a few of them are exact.
struct PaperSample {
  std::vector<double> v;
  ColumnMajor<double> N;
  ColumnMajor<double> D;
  std::vector<int> edges;
  std::vector<double> mu;

  InertiaForm form = InertiaForm::kDense;
  ColumnMajor<double> G;      ///< kDense: the inertia; kInverse: what stands for its inverse
  ColumnMajor<double> X;      ///< kFactored
  std::vector<double> alpha;  ///< kFactored

  std::vector<Dependence> dependences;  ///< ascending by contact; how the sample came about, not part of the problem
};

using PaperSet = ExperimentSet<PaperFeatures, PaperReading>;

/// All experiments of the paper, in its order, monotone before copositive.
const std::vector<PaperSet>& paper_sets();

/// One trial: a function of its arguments alone, bit for bit on every processor with IEEE doubles.
/// O(ngc nc edges + ngc^3), for conditioned sets about 8 sweeps of Jacobi rotations more.
PaperSample draw_paper(const PaperSet& set, const PaperReading& reading, std::uint64_t seed, std::uint64_t trial);

}  // namespace lcpbench
