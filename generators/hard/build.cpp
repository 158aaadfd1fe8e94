#include "generators/hard/build.h"

#include <cmath>

namespace lcpbench::hard {

double power_of_two(std::int64_t exponent) { return std::ldexp(1.0, static_cast<int>(exponent)); }

Table identity(std::size_t n) { return triangular(n, 0, 1, 0); }

Table matrix(const std::vector<Numbers>& rows) {
  Table M(rows.size(), rows.front().size());
  for (std::size_t i = 0; i < M.rows; ++i) {
    for (std::size_t j = 0; j < M.cols; ++j) M(i, j) = rows[i][j];
  }
  return M;
}

Table tridiagonal(std::size_t n, double below, double diagonal, double above) {
  Table M(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    M(i, i) = diagonal;
    if (i > 0) M(i, i - 1) = below;
    if (i + 1 < n) M(i, i + 1) = above;
  }
  return M;
}

Table triangular(std::size_t n, double below, double diagonal, double above) {
  Table M(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) M(i, j) = i == j ? diagonal : i > j ? below : above;
  }
  return M;
}

Table transposed(const Table& A) {
  Table T(A.cols, A.rows);
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < A.cols; ++j) T(j, i) = A(i, j);
  }
  return T;
}

Table product(const Table& A, const Table& B) {
  Table C(A.rows, B.cols);
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < B.cols; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < A.cols; ++k) sum += A(i, k) * B(k, j);
      C(i, j) = sum;
    }
  }
  return C;
}

Numbers times(const Table& M, const Numbers& x) {
  Numbers y(M.rows);
  for (std::size_t i = 0; i < M.rows; ++i) {
    for (std::size_t j = 0; j < M.cols; ++j) y[i] += M(i, j) * x[j];
  }
  return y;
}

Numbers constant(std::size_t n, double value) { return Numbers(n, value); }

Numbers unit(std::size_t n, std::size_t i) {
  Numbers x(n);
  x[i] = 1;
  return x;
}

Numbers alternating(std::size_t n, std::size_t first) {
  Numbers x(n);
  for (std::size_t i = first; i < n; i += 2) x[i] = 1;
  return x;
}

Numbers scaled(Numbers x, double factor) {
  for (double& entry : x) entry *= factor;
  return x;
}

Table skew_blocks(const Table& A) {
  Table M(A.rows + A.cols, A.rows + A.cols);
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < A.cols; ++j) {
      M(j, A.cols + i) = A(i, j);
      M(A.cols + i, j) = 0.0 - A(i, j);  // no -0.0, which hashes differently
    }
  }
  return M;
}

Numbers joined(const Numbers& first, const Numbers& second) {
  Numbers all = first;
  all.insert(all.end(), second.begin(), second.end());
  return all;
}

HardTruth solution(Numbers z, HardUnique unique, std::string reason, Numbers velocity) {
  return {HardKnown::kSolvable, unique, std::move(reason), std::move(z), true, std::move(velocity)};
}

HardTruth rounded_solution(Numbers z, HardUnique unique, std::string reason) {
  HardTruth truth = solution(std::move(z), unique, std::move(reason));
  truth.exact = false;
  return truth;
}

HardTruth solvable(HardUnique unique, std::string reason) { return solution({}, unique, std::move(reason)); }

HardTruth unsolvable(Numbers farkas, std::string reason) {
  HardTruth truth;
  truth.known = HardKnown::kUnsolvable;
  truth.reason = std::move(reason);
  truth.farkas = std::move(farkas);
  return truth;
}

HardCase lcp(Table M, Numbers q, HardTruth truth) {
  return {std::nullopt, std::move(M), std::move(q), std::move(truth)};
}

HardCase planted(Table M, const Numbers& z, const Numbers& w, HardUnique unique, std::string reason) {
  Numbers q = times(M, z);
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = w[i] - q[i];
  return lcp(std::move(M), std::move(q), solution(z, unique, std::move(reason)));
}

HardCase planted_ones(Table M, HardUnique unique, std::string reason) {
  const Numbers z = constant(M.rows, 1);
  return planted(std::move(M), z, constant(z.size(), 0), unique, std::move(reason));
}

HardCase with_scale(HardCase problem, ScaleDial scale) {
  const double factor = power_of_two(scale.value);
  problem.q = scaled(std::move(problem.q), factor);
  problem.truth.z = scaled(std::move(problem.truth.z), factor);
  if (scale.value != 0) problem.truth.reason += "; q, z and w in units of 2^" + std::to_string(scale.value);
  return problem;
}

namespace {

void append_column(const Numbers& column, double factor, ColumnMajor<double>& columns) {
  for (const double entry : column) columns.data.push_back(factor * entry + 0.0);  // no -0.0
  ++columns.cols;
}

}  // namespace

Contacts::Contacts(Table inertia, Numbers v, InertiaForm form) {
  sample_.N = ColumnMajor<double>(v.size(), 0);
  sample_.D = ColumnMajor<double>(v.size(), 0);
  sample_.v = std::move(v);
  sample_.form = form;
  sample_.G = std::move(inertia);
}

Contacts Contacts::reduced(ColumnMajor<double> X, Numbers v) {
  Contacts contacts(Table(), std::move(v), InertiaForm::kFactored);
  contacts.sample_.alpha = constant(X.cols, 1.0);
  contacts.sample_.X = std::move(X);
  return contacts;
}

void Contacts::add(Numbers normal) { add(std::move(normal), 0, {}); }

void Contacts::add(Numbers normal, double mu, const std::vector<Numbers>& directions) {
  append_column(normal, 1, sample_.N);
  for (const double factor : {1.0, -1.0}) {
    for (const Numbers& direction : directions) append_column(direction, factor, sample_.D);
  }
  sample_.edges.push_back(static_cast<int>(2 * directions.size()));
  sample_.mu.push_back(mu);
}

HardCase Contacts::with(HardTruth truth) const {
  return {sample_, {}, {}, std::move(truth)};
}

}  // namespace lcpbench::hard
