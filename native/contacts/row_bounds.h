#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "core/contact_problem.h"
#include "core/entries.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {

/// Of a body's inertia scaled to unit diagonal, whose least eigenvalue is then at least a third of that: the product of
/// the others is less than e.
inline constexpr double kLeastDeterminant = 0x1p-20;

/// Whether every body's inertia is conditioned so well that its response to any impulse has small relative errors in
/// double. @pre BlockInertia
inline bool is_benign(const Inertia& inertia) {
  const auto& blocks = std::get<BlockInertia>(inertia).blocks;
  return std::all_of(blocks.begin(), blocks.end(), [](const Matrix& block) {
    const Eigen::LLT<Matrix> factors(block);
    if (factors.info() != Eigen::Success) return false;
    double determinant = 1;
    for (Index i = 0; i < block.rows(); ++i) {
      const double pivot = factors.matrixLLT()(i, i);
      determinant *= pivot * pivot / block(i, i);
    }
    return determinant >= kLeastDeterminant;
  });
}

/// w of the contact's normal row at u.
inline double normal_row(const ContactProblem& problem, Index contact, const Vector& u) {
  const double velocity = dot_column(problem.N, contact, u);
  return problem.has_offset() ? velocity + problem.b(contact) : velocity;
}

/// More than normal_row() rounds, underflow included; 0 only where there is nothing to round.
inline double rounding_of_row(const ContactProblem& problem, Index contact, const Vector& v) {
  constexpr double kTwoRoundings = 0x1p-52;
  double terms = std::abs(problem.offset(contact));
  Index products = 0;
  for_each_entry(problem.N, contact, [&](Index row, double entry) {
    terms += std::abs(entry * v(row));
    if (v(row) != 0) ++products;
  });
  if (terms == 0 && products == 0) return 0;
  return kTwoRoundings * static_cast<double>(v.size() + 1) * terms +
         static_cast<double>(products + 1) * std::numeric_limits<double>::denorm_min();
}

/// At least |column'v|, by what the rounding of the sum may take from it.
struct SlipBound {
  const Vector& v;
  Index column;

  double operator()(const Matrix& matrix) const {
    const auto of_column = matrix.col(column);
    return of(of_column.dot(v), of_column.cwiseAbs().dot(v.cwiseAbs()), v.size());
  }
  double operator()(const SparseMatrix& matrix) const {
    double sum = 0, magnitudes = 0;
    Index terms = 0;
    for (SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry, ++terms) {
      const double product = entry.value() * v(entry.row());
      sum += product;
      magnitudes += std::abs(product);
    }
    return of(sum, magnitudes, terms);
  }
  static double of(double sum, double magnitudes, Index terms) {
    return std::abs(sum) + static_cast<double>(terms + 3) * 0x1p-53 * magnitudes;
  }
};

/// Whether the contact approaches at v, or its velocity is no number.
/// @param to_rounding  also where rounding alone may hide that it approaches: what no impulse moves then has no solution
inline bool may_approach(const ContactProblem& problem, Index contact, const Vector& v, bool to_rounding) {
  return !(normal_row(problem, contact, v) >= (to_rounding ? rounding_of_row(problem, contact, v) : 0.0));
}

}  // namespace lcpbench
