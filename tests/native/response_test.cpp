#define LCPBENCH_LEVEL response_test

#include "native/kernels/response.h"

#include <gtest/gtest.h>

#include "core/types.h"

namespace lcpbench::response_test {
namespace {

using Response = lemke::response_test::Response<double>;

/// G = X X'.
void load(const Matrix& X, Response& response) {
  const Vector alpha = Vector::Ones(X.cols());
  contact_lemke::Input input;
  input.ngc = X.rows();
  input.inertia.factors = X.cols();
  input.inertia.X = X.data();
  input.inertia.alpha = alpha.data();
  response.load(input);
}

// G = 1 + 2^-54 + 2^-54 + ...: every addition rounds its term away.
TEST(ResponseTest, TheBackwardErrorCoversTheSumOfManyFactors) {
  for (const Index factors : {100, 10000}) {
    Matrix X = Matrix::Constant(1, factors, 0x1p-27);
    X(0, 0) = 1;
    Response response;
    load(X, response);
    EXPECT_GE(response.backward_error(), static_cast<double>(factors - 1) * 0x1p-54);
    EXPECT_LE(response.backward_error(), static_cast<double>(factors + 12) * 0x1p-52);
  }
}

// All factors are multiples of (1, 21/16). Their sums round down in G_11 and G_12 and up in G_22, so that the rounded G
// is regular, and the more so the more factors there are.
TEST(ResponseTest, NothingIsKnownOfASumThatIsRegularByRoundingAlone) {
  for (const Index factors : {10, 1000, 100000}) {
    Matrix X(2, factors);
    X.row(0).setConstant(73.0 / 64 * 0x1p-27);
    X(0, 0) = 1;
    X.row(1) = 21.0 / 16 * X.row(0);
    Response response;
    load(X, response);
    ASSERT_TRUE(response.full_rank());
    EXPECT_EQ(response.backward_error(), lemke::response_test::kInfinity<double>);
    EXPECT_EQ(response.largest_backward_error(), lemke::response_test::kInfinity<double>);
  }
}

}  // namespace
}  // namespace lcpbench::response_test
