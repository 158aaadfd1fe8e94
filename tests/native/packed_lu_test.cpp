// Eigen is not renamed here, so the class must not be that of any level.
#define LCPBENCH_LEVEL packed_lu_test

#include "native/lemke/packed_lu.h"

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {
namespace {

/// Each third column a unit column, as bases have them.
Matrix basis_of(Index n) {
  testing::Uniform uniform(3);
  Matrix basis = uniform.matrix(n, n);
  for (Index j = 0; j < n; j += 3) basis.col(j) = Vector::Unit(n, j * 7 % n);
  return basis;
}

TEST(PackedLuTest, IsEigensBitForBitAndTakesNoMemory) {
  lemke::packed_lu_test::PackedLu<double> packed;
  // From 384 on blocks are packed off the stack: single rows and columns left over, and blocks of the largest size.
  for (const Index n : {1, 16, 17, 100, 383, 384, 385, 511, 1025, 2060}) {
    const Matrix basis = basis_of(n);
    packed.load(n);
    const int allocations = testing::count_allocations([&] { packed.factor(basis); });
    const Eigen::PartialPivLU<Matrix> eigen(basis);
    EXPECT_EQ(allocations, 0) << n;
    EXPECT_TRUE(packed.matrixLU() == eigen.matrixLU()) << n;
    EXPECT_TRUE(packed.permutationP().indices() == eigen.permutationP().indices()) << n;
  }
}

}  // namespace
}  // namespace lcpbench
