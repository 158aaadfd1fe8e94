#include "generators/planted.h"

#include <utility>

#include "generators/random.h"
#include "generators/paper/spectrum.h"

namespace lcpbench {
namespace {

constexpr int kMatrixBits = 36;
constexpr int kValueBits = 8;
constexpr double kMatrixSteps = 0x1p36;
constexpr double kValueStep = 0x1p-8;
constexpr double kProductStep = 0x1p-44;  // of M z
constexpr int kSlackShift = kMatrixBits + kValueBits - kGridBits;
/// Rounding M to its grid moves eigenvalues by at most n 2^-37, below 1e-9 at n = 100: for condition numbers up to 1e6
/// a thousandth of the smallest one. This margin is kept, so that the bound holds for the rounded matrix.
constexpr double kKeptForRounding = 0.999;
constexpr std::int64_t kLargestOrder = 100;
constexpr double kLargestCondition = 1e6;

/// Orthonormal columns: eigenvectors of Y Y' for a Y with uniform entries.
Eigensystem draw_spectrum(const TrialKey& key, std::size_t n) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    DrawSequence draws(key, Purpose::kMatrixVectors, attempt);
    ColumnMajor<double> Y(n, n);
    for (double& entry : Y.data) entry = static_cast<double>(draws.signed_grid()) * kGridStep;
    if (!safely_positive_definite(weighted_outer_sum(Y, std::vector<double>(n, 1.0)))) continue;
    return spectrum_of_square(std::move(Y));
  }
}

/// Logarithmically uniform from 1 to `largest`.
double draw_condition(const TrialKey& key, double largest) {
  DrawSequence draws(key, Purpose::kMatrixCondition);
  const double share = static_cast<double>(draws.unit_grid()) * kGridStep;
  const double usable = largest * kKeptForRounding;
  return usable > 1 ? portable_exp2(share * portable_log2(usable)) : 1.0;
}

std::int64_t nearest_step(double value) { return static_cast<std::int64_t>(value + (value >= 0 ? 0.5 : -0.5)); }

/// In steps of 2^-36.
ColumnMajor<std::int64_t> draw_matrix(const TrialKey& key, std::size_t n, double largest_condition) {
  const double condition = draw_condition(key, largest_condition);
  const Eigensystem spectrum = draw_spectrum(key, n);
  std::vector<double> eigenvalues = map_spectrum(spectrum.values, condition, SpectrumMap::kLogLinear);
  for (double& value : eigenvalues) value /= condition;
  const ColumnMajor<double> exact = weighted_outer_sum(spectrum.vectors, eigenvalues);
  ColumnMajor<std::int64_t> steps(n, n);
  for (std::size_t i = 0; i < exact.data.size(); ++i) steps.data[i] = nearest_step(exact.data[i] * kMatrixSteps);
  return steps;
}

struct PlantedSettings {
  PlantedReading reading;

  void visit(auto&& field) {
    field("form", reading.form, Choices<PlantedForm>{{{"contact", PlantedForm::kContact}, {"lcp", PlantedForm::kLcp}}},
          "frictionless contacts with v = q, N = I, G* = M, or the bare (q, M)");
    field("n_max", reading.n_max, IntegerRange{1, kLargestOrder}, "ceiling of the order n");
    field("condition", reading.condition, RealRange{.min = 1, .max = kLargestCondition},
          "ceiling of the condition number of M");
  }
};

}  // namespace

PlantedSample draw_planted(const PlantedSet& set, const PlantedReading& reading, std::uint64_t seed,
                           std::uint64_t trial) {
  const TrialKey key{stream_id(set.stream), seed, trial};
  const auto n = static_cast<std::size_t>(DrawSequence(key, Purpose::kMatrixOrder).integer(1, reading.n_max));
  const ColumnMajor<std::int64_t> M = draw_matrix(key, n, reading.condition);

  DrawSequence support(key, Purpose::kPlantedSupport);
  DrawSequence values(key, Purpose::kPlantedValues);
  std::vector<std::int64_t> z(n);
  std::vector<std::int64_t> w(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (support.integer(0, 1) == 1) {
      z[i] = values.integer(1, std::int64_t{1} << kValueBits);
    } else {
      w[i] = values.unit_grid() + 1;
    }
  }

  PlantedSample sample;
  sample.M = ColumnMajor<double>(n, n);
  for (std::size_t i = 0; i < M.data.size(); ++i) sample.M.data[i] = static_cast<double>(M.data[i]) / kMatrixSteps;
  for (std::size_t i = 0; i < n; ++i) {
    // |M_ij| <= 1 and z_j <= 1: at most 100 2^44 + 2^44, exact in 64 bits and, below 2^53, in a double.
    std::int64_t q = w[i] * (std::int64_t{1} << kSlackShift);
    for (std::size_t j = 0; j < n; ++j) q -= M(i, j) * z[j];
    sample.q.push_back(static_cast<double>(q) * kProductStep);
    sample.z.push_back(static_cast<double>(z[i]) * kValueStep);
    sample.w.push_back(static_cast<double>(w[i]) * kGridStep);
  }
  return sample;
}

const std::vector<PlantedSet>& planted_sets() {
  static const std::vector<PlantedSet> sets = [] {
    PlantedSet set{
        "planted/definite", "planted/definite", "symmetric positive definite M, a solution that was drawn first", {}};
    read_options_as<PlantedSettings>(set);
    return std::vector{set};
  }();
  return sets;
}

}  // namespace lcpbench
