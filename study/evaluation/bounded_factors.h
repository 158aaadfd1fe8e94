#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <optional>
#include <span>

namespace lcpbench {

/// Factors A = U D U' of symmetric positive definite matrices in double, U upper triangular with ones on its diagonal,
/// each with a bound of |A^-1|, the matrix of magnitudes. One allocation of a kind for all matrices.
///
/// The last row is eliminated first. The inertia of a robot whose coordinates are listed from its root to its leaves
/// then fills in no entry, and zeros cost nothing. O(n^3) at most for each matrix, O(nonzeros of U) for each solution.
///
/// Bound. S = U D U' of the computed factors differs from A by E, |E| <= gamma |U| D |U'|, and no entry of |U| D |U'|
/// exceeds the largest diagonal entry of S. With M(U) = 2 I - |U|, the comparison matrix, H = M(U)^-T D^-1 M(U)^-1 is
/// at least |S^-1|, and A^-1 = (I - S^-1 E)^-1 S^-1 gives |A^-1| b <= H b + t |H b|_1 / (1 - t |H 1|_1) H 1 for
/// b >= 0, with t at least any |E_ij|. When t |H 1|_1 < 1, no A + s E, 0 <= s <= 1, is singular. A is then positive
/// definite as S is. [Higham 2002, "Accuracy and Stability of Numerical Algorithms", 8.3, 9.3, 14.6]
class BoundedFactors {
 public:
  /// @param memory  of the factors; must outlive this object.
  explicit BoundedFactors(std::pmr::memory_resource* memory = std::pmr::get_default_resource())
      : matrices_(memory),
        end_(memory),
        rows_(memory),
        values_(memory),
        inverse_pivots_(memory),
        of_ones_(memory),
        inverses_(memory),
        work_(memory) {}

  /// Adds the factors of A. False, and nothing is added, unless A is proven positive definite with no eigenvalue
  /// below `least`.
  /// @param A  n x n by columns; symmetric; diagonal entries from 1 to 4, no magnitude above 4.
  bool add(std::span<const double> A, std::size_t n, double least);

  /// Makes room for so many columns, of so many entries above the diagonal, of so many matrices.
  void reserve(std::size_t matrices, std::size_t columns, std::size_t entries);

  std::size_t count() const { return matrices_.size(); }

  /// x := S^-1 x, computed in double. The computed x solves A x = b but for residual(matrix) |x|_1 in each row.
  void solve(std::size_t matrix, std::span<double> x) const;
  /// b := at least |A^-1| b, for b >= 0.
  void bound(std::size_t matrix, std::span<double> b) const;
  /// At least |A^-1| 1.
  std::span<const double> bound_of_ones(std::size_t matrix) const {
    return std::span(of_ones_).subspan(matrices_[matrix].first, matrices_[matrix].order);
  }
  double residual(std::size_t matrix) const { return matrices_[matrix].residual; }

 private:
  struct Factored {
    std::size_t first = 0;  ///< of its columns
    std::size_t order = 0;
    double residual = 0;
    double rounding = 0;                 ///< at least any |E_ij|, divided by 1 - rounding |H 1|_1
    std::optional<std::size_t> inverse;  ///< of |U^-1| in inverses_, where it replaces M(U)^-1
  };

  std::size_t begin(std::size_t column) const { return column == 0 ? 0 : end_[column - 1]; }
  bool eliminate(const Factored& matrix, std::span<const double> A, double least);
  bool invert(Factored& matrix);
  bool find_bound(Factored& matrix, double least);
  void compare(const Factored& matrix, std::span<double> b) const;
  void multiply_by_inverse(const Factored& matrix, std::span<double> b) const;
  void discard(const Factored& matrix);

  std::pmr::vector<Factored> matrices_;
  std::pmr::vector<std::size_t>
      end_;  ///< of each column of U less the diagonal; the last column of a matrix comes first
  std::pmr::vector<std::uint32_t> rows_;  ///< in the matrix, ascending
  std::pmr::vector<double> values_;
  std::pmr::vector<double> inverse_pivots_;  ///< 1 / D, the last one of a matrix first
  std::pmr::vector<double> of_ones_;
  std::pmr::vector<double> inverses_;  ///< n x n by columns, above the diagonal
  std::pmr::vector<double> work_;      ///< scratch of add(): what is left of A, by columns
};

}  // namespace lcpbench
