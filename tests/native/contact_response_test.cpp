// What contact_lemke knows of the G* in use, on which its proofs that there is a solution rest.
#include <Eigen/Eigenvalues>
#include <cmath>

#include <gtest/gtest.h>

#include "core/types.h"
#include "native/contact_lemke/contact_lemke.h"

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

/// v + G^-1 N z of one contact without friction, as an engine has it.
Vector velocity_after(const contact_lemke::Engine& engine, const Matrix& G, const Vector& v, const Vector& N, double z) {
  const std::ptrdiff_t offsets[] = {0, G.rows()}, friction_begin[] = {0, 0};
  const double* const block = G.data();
  const double mu = 0;
  contact_lemke::Input input{.ngc = G.rows(), .nc = 1, .v = v.data(), .N = N.data(), .friction_begin = friction_begin};
  input.mu = &mu;
  input.inertia.blocks = 1;
  input.inertia.offsets = offsets;
  input.inertia.G = &block;
  LoadedContacts contacts(engine);
  contacts.load(input);
  Vector velocity(G.rows());
  contacts.respond(&z, velocity.data());
  return velocity;
}

// Pivots are chosen by size, and what is eliminated must not stand in the way of the rest in any arithmetic.
TEST(ContactResponseTest, EachPrecisionInvertsTheInertiaWhateverTheOrderOfItsPivots) {
  const Vector v{{1, -2, 3, 0.5, -1}}, N{{-1, 2, 1, 3, 0.25}};
  const contact_lemke::Engine* const engines[] = {&lemke::baseline::kContactEngine, &lemke::quad::kContactEngine};
  for (Index largest = 0; largest < 5; ++largest) {
    Matrix G = Matrix::Constant(5, 5, 0.125);
    for (Index i = 0; i < 5; ++i) G(i, i) = 1 + static_cast<double>((i + 5 - largest) % 5);
    const Vector expected = v + 2 * G.llt().solve(N);
    for (const contact_lemke::Engine* engine : engines) {
      EXPECT_LE((velocity_after(*engine, G, v, N, 2) - expected).lpNorm<Eigen::Infinity>(), 1e-13) << largest;
    }
  }
}

}  // namespace
}  // namespace lcpbench
