#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <vector>

#include "native/kernels/pack.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The shortest of the x that minimize |B x - b|, for a square B that elimination found singular. O(k^3 + n k^2), k the
/// number of columns that are not unit columns; allocates.
///
/// The row of a unit column is satisfied exactly, whatever the other entries of x are. So the entries y of the k other
/// columns minimize |A y - a| in the k other rows: y = y0 + N t, with the shortest y0 by a complete orthogonal
/// decomposition of A, its numerical rank and null space N. Then t minimizes |y|^2 + |c - C y|^2, where c - C y are the
/// entries of the unit columns.
class LeastSquares {
 public:
  /// False, and x unchanged, when an entry of B or b is not finite.
  /// @param unit_row  unit_row(column): the row of its 1, or -1 if it is not a unit column. No row occurs twice
  /// @param B, b  B(row, column), called only for the other columns, and b(row)
  /// @param x  `order` entries
  template <class UnitRow, class Entry, class Side>
  static bool solve(Count order, UnitRow unit_row, Entry B, Side b, double* x) {
    std::vector<Count> column_of_row(static_cast<std::size_t>(order), -1);
    std::vector<Count> columns, rows, unit_rows;
    for (Count c = 0; c < order; ++c) {
      const Count row = unit_row(c);
      if (row < 0) columns.push_back(c);
      if (row >= 0) column_of_row[static_cast<std::size_t>(row)] = c;
    }
    for (Count r = 0; r < order; ++r) (column_of_row[static_cast<std::size_t>(r)] < 0 ? rows : unit_rows).push_back(r);
    const Matrix A = part(rows, columns, B);
    const Matrix C = part(unit_rows, columns, B);
    const Vector a = part(rows, b);
    const Vector c = part(unit_rows, b);
    if (!A.allFinite() || !C.allFinite() || !a.allFinite() || !c.allFinite()) return false;
    const Vector y = shortest(A, a, C, c);
    const Vector unit_entries = c - C * y;
    for (std::size_t i = 0; i < columns.size(); ++i) x[columns[i]] = y(static_cast<Count>(i));
    for (std::size_t i = 0; i < unit_rows.size(); ++i) {
      x[column_of_row[static_cast<std::size_t>(unit_rows[i])]] = unit_entries(static_cast<Count>(i));
    }
    return true;
  }

 private:
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;

  static Vector shortest(const Matrix& A, const Vector& a, const Matrix& C, const Vector& c) {
    const Eigen::CompleteOrthogonalDecomposition<Matrix> decomposition(A);
    Vector y = decomposition.solve(a);
    const Count free = A.cols() - decomposition.rank();
    if (free == 0) return y;
    const Matrix null_space = decomposition.colsPermutation() * decomposition.matrixZ().transpose().rightCols(free);
    Matrix stacked(free + C.rows(), free);
    stacked << Matrix::Identity(free, free), C * null_space;
    Vector side(free + C.rows());
    side << Vector::Zero(free), c - C * y;
    y += null_space * stacked.householderQr().solve(side);
    return y;
  }

  template <class Entry>
  static Matrix part(const std::vector<Count>& rows, const std::vector<Count>& columns, Entry B) {
    Matrix matrix(rows.size(), columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      for (std::size_t r = 0; r < rows.size(); ++r) {
        matrix(static_cast<Count>(r), static_cast<Count>(c)) = B(rows[r], columns[c]);
      }
    }
    return matrix;
  }

  template <class Side>
  static Vector part(const std::vector<Count>& rows, Side b) {
    Vector vector(rows.size());
    for (std::size_t r = 0; r < rows.size(); ++r) vector(static_cast<Count>(r)) = b(rows[r]);
    return vector;
  }
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
