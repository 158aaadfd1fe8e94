#include "study/evaluation/farkas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gmpxx.h>

namespace lcpbench {
namespace {

// mantissa * 2^exponent, exactly.
class Dyadic {
 public:
  Dyadic() = default;
  explicit Dyadic(double value) {
    if (value == 0) return;
    int exponent = 0;
    mantissa_ = std::ldexp(std::frexp(value, &exponent), kDoubleBits);
    exponent_ = exponent - kDoubleBits;
  }

  explicit Dyadic(const std::string& integer) : mantissa_(integer) {}

  int sign() const { return sgn(mantissa_); }

  Dyadic& operator+=(const Dyadic& other) {
    if (other.sign() == 0) return *this;
    if (sign() == 0) return *this = other;
    if (exponent_ > other.exponent_) {
      mantissa_ <<= static_cast<mp_bitcnt_t>(exponent_ - other.exponent_);
      exponent_ = other.exponent_;
      mantissa_ += other.mantissa_;
    } else {
      mantissa_ += other.mantissa_ << static_cast<mp_bitcnt_t>(other.exponent_ - exponent_);
    }
    return *this;
  }

  friend Dyadic operator*(const Dyadic& a, const Dyadic& b) {
    Dyadic product;
    product.mantissa_ = a.mantissa_ * b.mantissa_;
    product.exponent_ = a.exponent_ + b.exponent_;
    return product;
  }

  /// a / b towards zero. @pre b is not zero
  friend double quotient(const Dyadic& a, const Dyadic& b) {
    mpq_class ratio(a.mantissa_, b.mantissa_);
    ratio.canonicalize();
    const long shift = a.exponent_ - b.exponent_;
    if (shift >= 0) return mpq_class(ratio << static_cast<mp_bitcnt_t>(shift)).get_d();
    return mpq_class(ratio >> static_cast<mp_bitcnt_t>(-shift)).get_d();
  }

 private:
  static constexpr int kDoubleBits = 53;

  mpz_class mantissa_;
  long exponent_ = 0;
};

using DyadicVector = std::vector<Dyadic>;

DyadicVector exact(const Vector& x) {
  DyadicVector y;
  for (const double value : x) y.emplace_back(value);
  return y;
}

bool is_zero(const DyadicVector& x) {
  return std::all_of(x.begin(), x.end(), [](const Dyadic& value) { return value.sign() == 0; });
}

Dyadic dot(const Vector& a, const DyadicVector& b) {
  Dyadic sum;
  for (Index i = 0; i < a.size(); ++i) sum += Dyadic(a(i)) * b[static_cast<std::size_t>(i)];
  return sum;
}

// A'x for the rows of x from `begin` on that A has.
DyadicVector transposed_times(const Matrix& A, const DyadicVector& x, std::size_t begin) {
  DyadicVector y(static_cast<std::size_t>(A.cols()));
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = 0; i < A.rows(); ++i) {
      y[static_cast<std::size_t>(j)] += Dyadic(A(i, j)) * x[begin + static_cast<std::size_t>(i)];
    }
  }
  return y;
}

DyadicVector times(const Jacobian& N, const DyadicVector& u) {
  DyadicVector p(static_cast<std::size_t>(rows(N)));
  for (Index j = 0; j < cols(N); ++j) {
    const Dyadic& u_j = u[static_cast<std::size_t>(j)];
    if (u_j.sign() == 0) continue;
    if (const auto* dense = std::get_if<Matrix>(&N)) {
      for (Index i = 0; i < dense->rows(); ++i) p[static_cast<std::size_t>(i)] += Dyadic((*dense)(i, j)) * u_j;
    } else {
      for (SparseMatrix::InnerIterator entry(std::get<SparseMatrix>(N), j); entry; ++entry) {
        p[static_cast<std::size_t>(entry.row())] += Dyadic(entry.value()) * u_j;
      }
    }
  }
  return p;
}

// u'(N'v + b)
Dyadic fall(const ContactProblem& problem, const DyadicVector& u) {
  Dyadic sum = dot(problem.v, times(problem.N, u));
  sum += dot(problem.b, u);
  return sum;
}

double least_violation(const ContactProblem& problem, const DyadicVector& u) {
  Dyadic total;
  for (const Dyadic& value : u) total += value;
  return total.sign() > 0 ? -quotient(fall(problem, u), total) : std::numeric_limits<double>::quiet_NaN();
}

bool annihilates(const Matrix& A, const DyadicVector& p, std::size_t begin) {
  return A.allFinite() && is_zero(transposed_times(A, p, begin));
}

struct NullSpaceTest {
  const DyadicVector& p;

  bool operator()(const DenseInertia& inertia) const { return annihilates(inertia.G, p, 0); }
  bool operator()(const BlockInertia& inertia) const {
    std::size_t begin = 0;
    for (const Matrix& block : inertia.blocks) {
      if (!annihilates(block, p, begin)) return false;
      begin += static_cast<std::size_t>(block.rows());
    }
    return true;
  }
  bool operator()(const FactoredInertia& inertia) const {
    if (!inertia.X.allFinite() || !inertia.alpha.allFinite()) return false;
    for (Index k = 0; k < inertia.X.cols(); ++k) {
      if (inertia.alpha(k) != 0 && dot(inertia.X.col(k), p).sign() != 0) return false;
    }
    return true;
  }
  bool operator()(const InverseInertia& inertia) const { return annihilates(inertia.Ginv, p, 0); }
};

bool nonnegative(const Vector& u) {
  return std::all_of(u.begin(), u.end(), [](double value) { return value >= 0 && std::isfinite(value); });
}

}  // namespace

bool proves_unsolvable(const ContactProblem& problem, const Vector& u) {
  if (u.size() != problem.nc() || !nonnegative(u) || !all_finite(problem.N) || !problem.v.allFinite()) return false;
  if (!problem.b.allFinite()) return false;
  const DyadicVector exact_u = exact(u);
  return fall(problem, exact_u).sign() < 0 && std::visit(NullSpaceTest{times(problem.N, exact_u)}, problem.inertia);
}

bool proves_unsolvable(const Lcp& lcp, const Vector& u) {
  if (u.size() != lcp.size() || !nonnegative(u) || !lcp.M.allFinite() || !lcp.q.allFinite()) return false;
  const DyadicVector exact_u = exact(u);
  if (!(dot(lcp.q, exact_u).sign() < 0)) return false;
  const DyadicVector columns = transposed_times(lcp.M, exact_u, 0);
  return std::all_of(columns.begin(), columns.end(), [](const Dyadic& value) { return value.sign() <= 0; });
}

double least_violation(const ContactProblem& problem, const Vector& u) { return least_violation(problem, exact(u)); }

double least_violation(const ContactProblem& problem, std::span<const std::string> u) {
  return least_violation(problem, DyadicVector(u.begin(), u.end()));
}

}  // namespace lcpbench
