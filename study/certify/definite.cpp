#include "study/certify/definite.h"

#include <Eigen/Cholesky>
#include <limits>

#include "study/certify/integers.h"

namespace lcpbench::exact {
namespace {

// Far enough from the ends of the range that no product of two entries overflows, or underflows to any effect.
constexpr double kLargest = 1e140;
constexpr double kSmallest = 1e-140;
constexpr Index kLargestMinor = 64;

bool definite_in_double(const Matrix& A) {
  const double smallest = A.diagonal().minCoeff();
  const double largest = A.diagonal().maxCoeff();
  if (!(smallest >= kSmallest && largest <= kLargest)) return false;
  // The rounding error of the factorization is at most (n + 1) u trace(A) to first order in the spectral norm, that of
  // the subtraction below u trace(A); four times as much leaves room for the higher orders.
  const double shift = 4 * static_cast<double>(A.rows() + 2) * std::numeric_limits<double>::epsilon() * A.trace();
  Matrix shifted = A;
  shifted.diagonal().array() -= shift;
  return Eigen::LLT<Matrix>(shifted).info() == Eigen::Success;
}

bool definite_by_minors(const Matrix& A, const Deadline& deadline) {
  IntegerMatrix a = to_dyadic(A).m;
  Integer previous(1);
  for (Index s = 0; s < a.rows(); ++s) {
    if (fmpz_sgn(a(s, s)) <= 0) return false;  // the leading minor of order s + 1
    for (Index i = s + 1; i < a.rows(); ++i) {
      deadline.check();
      for (Index j = s + 1; j < a.cols(); ++j) {
        set_difference_of_products(a(i, j), a(i, j), a(s, s), a(i, s), a(s, j));
        fmpz_divexact(a(i, j), a(i, j), previous.get());
      }
    }
    fmpz_set(previous.get(), a(s, s));
  }
  return true;
}

}  // namespace

bool positive_definite(const Matrix& A, const Deadline& deadline) {
  return A.rows() == 0 || definite_in_double(A) || (A.rows() <= kLargestMinor && definite_by_minors(A, deadline));
}

}  // namespace lcpbench::exact
