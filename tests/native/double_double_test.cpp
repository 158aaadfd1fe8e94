#define LCPBENCH_LEVEL double_double_test
#include "native/contact_lemke/double_double.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/quad.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::lemke::double_double_test {
namespace {

constexpr double kRoundoff = 0x1p-104;

Quad exactly(DoubleDouble x) { return static_cast<Quad>(x.high) + static_cast<Quad>(x.low); }

double relative_error(DoubleDouble x, Quad truth) {
  return to_double(abs(exactly(x) - truth) / (truth == 0 ? Quad(1) : abs(truth)));
}

/// A pair that 113 bits hold exactly.
DoubleDouble draw(testing::Uniform& uniform) {
  const double high = uniform();
  return DoubleDouble::exact_sum(high, static_cast<float>(high * 0x1p-54 * uniform()));
}

TEST(DoubleDoubleTest, HasMoreThanAHundredBits) {
  testing::Uniform uniform(1);
  for (int k = 0; k < 2000; ++k) {
    const DoubleDouble a = draw(uniform), b = draw(uniform);
    const Quad x = exactly(a), y = exactly(b);
    EXPECT_LE(relative_error(a * b, x * y), kRoundoff);
    EXPECT_LE(relative_error(a / b, x / y), 4 * kRoundoff);
    EXPECT_LE(relative_error(square_root(a * a), abs(x)), 4 * kRoundoff);
    // Of sums the error is relative to the result even where the first parts cancel.
    EXPECT_LE(relative_error(a + b, x + y), kRoundoff);
    EXPECT_LE(relative_error(a - DoubleDouble(a.high), x - static_cast<Quad>(a.high)), kRoundoff);
  }
}

TEST(DoubleDoubleTest, ComparesByBothParts) {
  const DoubleDouble one(1), more(1, 0x1p-60), less(1, -0x1p-60);
  EXPECT_TRUE(less < one && one < more && more > less && one <= one && one >= one && one == one && one != more);
}

TEST(DoubleDoubleTest, KeepsNanAndInfinityApartFromNumbers) {
  const DoubleDouble infinity(INFINITY), nan(NAN), one(1);
  EXPECT_TRUE(one < infinity);
  EXPECT_FALSE(infinity + one < infinity);
  EXPECT_FALSE(infinity - infinity == DoubleDouble(0));
  EXPECT_FALSE(nan < one || nan > one || nan == one || nan <= one || nan >= one);
  EXPECT_EQ(static_cast<double>(one / DoubleDouble(0)), INFINITY);
  EXPECT_EQ(static_cast<double>(square_root(DoubleDouble(0))), 0);
}

}  // namespace
}  // namespace lcpbench::lemke::double_double_test
