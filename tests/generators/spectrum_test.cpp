#include "generators/paper/spectrum.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "generators/random.h"
#include "tests/generators/generator_checks.h"

namespace lcpbench::spectrum_test {
namespace {

ColumnMajor<double> square(std::size_t n, std::vector<double> columns) {
  ColumnMajor<double> matrix(n, n);
  matrix.data = std::move(columns);
  return matrix;
}

// The C library's functions are good to an ulp or two here; ours promise 1e-15.
TEST(PortableFunctionsTest, AgreeWithTheLibrary) {
  DrawSequence draws({1, 2, 3}, Purpose::kConditioning);
  for (int i = 0; i < 20000; ++i) {
    const double exponent =
        static_cast<double>(draws.signed_grid()) * 0x1p-12 + static_cast<double>(draws.unit_grid()) * 0x1p-32;
    const double power = portable_exp2(exponent);
    EXPECT_NEAR(power / std::exp2(exponent), 1, 1e-15) << exponent;
    EXPECT_NEAR(portable_log2(power), std::log2(power), 1e-15 * std::max(1.0, std::fabs(exponent))) << exponent;
  }
  EXPECT_EQ(portable_exp2(0), 1);
  EXPECT_EQ(portable_exp2(-30), 0x1p-30);
  EXPECT_EQ(portable_log2(1), 0);
  EXPECT_EQ(portable_log2(0x1p40), 40);
}

TEST(WeightedOuterSumTest, GivesTheSum) {
  ColumnMajor<double> X(2, 2);
  X.data = {1, 2, 3, -1};
  const ColumnMajor<double> sum = weighted_outer_sum(X, {2, 1});
  EXPECT_EQ(sum.data, (std::vector<double>{2 + 9, 4 - 3, 4 - 3, 8 + 1}));
}

TEST(SafelyPositiveDefiniteTest, AcceptsOnlyWhatIsPositiveDefiniteBeyondDoubt) {
  EXPECT_TRUE(safely_positive_definite(square(2, {2, 1, 1, 2})));
  EXPECT_TRUE(safely_positive_definite(square(2, {1, 0, 0, 1e-300})));  // badly scaled, not badly conditioned
  EXPECT_FALSE(safely_positive_definite(square(2, {1, 1, 1, 1})));
  EXPECT_FALSE(safely_positive_definite(square(2, {1, 1, 1, 1 + 0x1p-52})));  // positive definite, by a hair
  EXPECT_FALSE(safely_positive_definite(square(2, {1, 2, 2, 1})));
  EXPECT_FALSE(safely_positive_definite(square(1, {0})));
  EXPECT_FALSE(safely_positive_definite(square(1, {std::numeric_limits<double>::quiet_NaN()})));
}

TEST(SpectrumTest, VectorsAreOrthonormalAndRebuildTheMatrix) {
  DrawSequence draws({1, 2, 3}, Purpose::kInertiaVectors);
  const std::size_t n = 12;
  ColumnMajor<double> Y(n, n);
  for (double& entry : Y.data) entry = static_cast<double>(draws.signed_grid()) * kGridStep;
  const Eigensystem spectrum = spectrum_of_square(Y);
  const ColumnMajor<double> original = weighted_outer_sum(Y, std::vector<double>(n, 1.0));
  const ColumnMajor<double> rebuilt = weighted_outer_sum(spectrum.vectors, spectrum.values);
  const double tolerance = static_cast<double>(n) * 0x1p-52;
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < n; ++i) {
      double product = 0;
      for (std::size_t k = 0; k < n; ++k) product += spectrum.vectors(k, i) * spectrum.vectors(k, j);
      EXPECT_NEAR(product, i == j ? 1 : 0, 4 * tolerance);
      EXPECT_NEAR(rebuilt(i, j), original(i, j), 4 * tolerance * spectrum.values.back());
    }
    if (j > 0) {
      EXPECT_LE(spectrum.values[j - 1], spectrum.values[j]);
    }
  }
}

TEST(MapSpectrumTest, EachMapDoesWhatItsNameSays) {
  const std::vector<double> values{0.5, 5, 50, 5e3};
  const std::vector<double> logarithmic = map_spectrum(values, 1e8, SpectrumMap::kLogLinear);
  EXPECT_EQ(logarithmic.front(), 1);
  EXPECT_NEAR(logarithmic[1], 1e2, 1e-12);
  EXPECT_NEAR(logarithmic[2], 1e4, 1e-10);
  EXPECT_EQ(logarithmic.back(), 1e8);

  const std::vector<double> linear = map_spectrum({1, 2, 5}, 101, SpectrumMap::kLinear);
  EXPECT_EQ(linear, (std::vector<double>{1, 26, 101}));

  const std::vector<double> geometric = map_spectrum({1, 1.5, 7}, 1e4, SpectrumMap::kGeometric);
  EXPECT_EQ(geometric.front(), 1);
  EXPECT_NEAR(geometric[1], 1e2, 1e-12);
  EXPECT_EQ(geometric.back(), 1e4);
}

}  // namespace
}  // namespace lcpbench::spectrum_test
