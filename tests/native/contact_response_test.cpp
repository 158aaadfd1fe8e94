// What contact_lemke knows of the G* in use, on which its proofs that there is a solution rest.
#include <Eigen/Eigenvalues>
#include <cmath>

#include <gtest/gtest.h>

#include "core/types.h"

#define LCPBENCH_LEVEL contact_response_test
#include "native/contact_lemke/response.h"

namespace lcpbench {
namespace {

using Response = lemke::LCPBENCH_LEVEL::Response<double>;

Response::Certainty certainty(const contact_lemke::Input& input) {
  Response response;
  response.load(input);
  return response.certainty();
}

Response::Certainty certainty_of_inverse(const Matrix& Ginv) {
  contact_lemke::Input input{.ngc = Ginv.rows()};
  input.inertia.Ginv = Ginv.data();
  return certainty(input);
}

Response::Certainty certainty_of_factors(const Matrix& X, double alpha) {
  const Vector weights = Vector::Constant(X.cols(), alpha);
  contact_lemke::Input input{.ngc = X.rows()};
  input.inertia.factors = X.cols();
  input.inertia.X = X.data();
  input.inertia.alpha = weights.data();
  return certainty(input);
}

// Squares of entries of 1e-170 are zero, and those of 1e170 infinite.
TEST(ContactResponseTest, CertaintyBoundsAGivenInverseOfAnySize) {
  const Matrix Ginv{{2, 1}, {1, 3}};
  for (const double size : {1e-300, 1e-170, 1e-50, 1.0, 1e50, 1e170, 1e300}) {
    const Response::Certainty known = certainty_of_inverse(size * Ginv);
    EXPECT_GE(known.norm, size * Ginv.operatorNorm()) << size;
    EXPECT_GT(known.error, 0) << size;
  }
  EXPECT_LE(certainty_of_inverse(Ginv).norm, 1.3 * Ginv.norm());
}

TEST(ContactResponseTest, CertaintyBoundsTheInverseOfFactorsOfAnySize) {
  const Matrix X{{1, 2}, {-1, 1}, {2, 1}};
  const double inverse_norm = 1 / (X.transpose() * X).eval().selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
  for (const double size : {1e-150, 1e-100, 1e-50, 1.0, 1e50, 1e100, 1e150}) {
    const Response::Certainty known = certainty_of_factors(X, size);
    EXPECT_GE(known.norm, inverse_norm / size) << size;
    EXPECT_GT(known.error, 0) << size;
  }
  EXPECT_LT(certainty_of_factors(X, 1).norm, 3 * inverse_norm);
}

}  // namespace
}  // namespace lcpbench
