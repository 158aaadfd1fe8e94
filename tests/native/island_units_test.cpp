#include "native/contacts/island_units.h"

#include <cmath>

#include <gtest/gtest.h>

#include "native/contacts/row_bounds.h"

namespace lcpbench::island_units_test {
namespace {

/// One coordinate and one contact on each of several bodies.
class Bodies {
 public:
  explicit Bodies(Index count) {
    contact_.v = Vector::Zero(count);
    contact_.N = Matrix(Matrix::Identity(count, count));
    contact_.D = Matrix(count, 0);
    contact_.edges.assign(static_cast<std::size_t>(count), 0);
    contact_.mu = Vector::Zero(count);
    contact_.inertia = BlockInertia{std::vector<Matrix>(static_cast<std::size_t>(count), Matrix::Identity(1, 1))};
    units_.load(contact_);
  }

  /// The units for these speeds, which are the sums of terms of that size.
  Vector units_for(const Vector& v, const Vector& magnitudes) {
    units_.clear();
    for (Index i = 0; i < v.size(); ++i) {
      units_.add_row(i, {.approach = std::abs(v(i)), .magnitudes = magnitudes(i)});
    }
    units_.choose(v);
    Vector units(v.size());
    for (Index i = 0; i < v.size(); ++i) {
      units(i) = units_.of_contact(i);
      EXPECT_EQ(units_.of_coordinate(i), units(i));
    }
    return units;
  }
  Vector units_for(const Vector& v) { return units_for(v, v.cwiseAbs()); }

 private:
  ContactProblem contact_;
  IslandUnits units_;
};

TEST(IslandUnitsTest, BringEveryIslandToTheLargestInPowersOfTwo) {
  const Vector v{{-1e10, 3, -1e-5, 0, -9.9e9}};
  const Vector units = Bodies(5).units_for(v);
  for (const Index i : {0, 1, 2, 4}) {
    int exponent = 0;
    EXPECT_EQ(std::frexp(units(i), &exponent), 0.5) << i;
    EXPECT_GE(std::abs(v(i)) * units(i), 1e10) << i;
    EXPECT_LT(std::abs(v(i)) * units(i), 2e10) << i;
  }
  EXPECT_EQ(units(0), 1);
  EXPECT_EQ(units(3), 1);  // at rest
}

// What rounding leaves of terms of one must not look like a velocity.
TEST(IslandUnitsTest, DoNotEnlargeRounding) {
  const Vector units = Bodies(2).units_for(Vector{{-1, -1e-17}}, Vector{{1, 1}});
  EXPECT_GT(units(1), 1);
  EXPECT_LE(units(1) * 0x1p-50, 0x1p-33);
}

TEST(IslandUnitsTest, StayInTheRangeOfDouble) {
  const Vector v{{-1e300, -1e-300, 1e5}};
  const Vector units = Bodies(3).units_for(v);
  EXPECT_TRUE(v.cwiseProduct(units).allFinite());
  EXPECT_TRUE(v.cwiseQuotient(units).allFinite());
  EXPECT_EQ(Bodies(2).units_for(Vector{{-HUGE_VAL, -1}}), Vector::Ones(2));
}

// N'v = -1e-400 comes out as zero in double.
TEST(RowBoundsTest, TheRoundingOfARowCoversProductsThatUnderflow) {
  ContactProblem contact;
  contact.v = Vector{{0, -1e-200}};
  contact.N = Matrix{{1.0, 0.0}, {1e-200, 0.0}};
  EXPECT_EQ(normal_row(contact, 0, contact.v), 0);
  EXPECT_GT(rounding_of_row(contact, 0, contact.v), 0);
  EXPECT_EQ(rounding_of_row(contact, 1, contact.v), 0);
}

// 0.3 * 0.7 + b is 0 in double and -1.3e-17 exactly.
TEST(RowBoundsTest, AContactMayApproachByWhatRoundingHides) {
  ContactProblem contact;
  contact.v = Vector{{0.7}};
  contact.N = Matrix{{0.3}};
  contact.D = Matrix(1, 0);
  contact.edges = {0};
  contact.mu = Vector::Zero(1);
  contact.b = Vector{{-(0.3 * 0.7)}};
  contact.inertia = DenseInertia{Matrix::Identity(1, 1)};
  ASSERT_LT(std::fma(0.3, 0.7, contact.b(0)), 0);
  EXPECT_FALSE(may_approach(contact, 0, contact.v, false));
  EXPECT_TRUE(may_approach(contact, 0, contact.v, true));
  EXPECT_FALSE(may_approach(contact, 0, Vector{{0.8}}, true));
  EXPECT_TRUE(may_approach(contact, 0, Vector{{std::nan("")}}, false));
}

}  // namespace
}  // namespace lcpbench::island_units_test
