#include "study/certify/integer_solve.h"

#include <algorithm>
#include <numeric>

#include <flint/nmod_mat.h>
#include <flint/nmod_vec.h>

#include "study/certify/lifting.h"

namespace lcpbench::exact {
namespace {

constexpr mp_limb_t kPrime = 9223372036854775783U;  // 2^63 - 25

/// A matrix modulo kPrime: FLINT's nmod_mat with an owner.
class Residues {
 public:
  explicit Residues(const IntegerMatrix& a) {
    nmod_mat_init(matrix_, a.rows(), a.cols(), kPrime);
    fmpz_mat_get_nmod_mat(matrix_, a.get());
  }
  Residues(const Residues&) = delete;
  Residues& operator=(const Residues&) = delete;
  ~Residues() { nmod_mat_clear(matrix_); }

  mp_limb_t operator()(Index i, Index j) const { return matrix_->rows[i][j]; }

  // Row `target` less the multiple of row `source` that leaves no entry in column j; columns before j are not needed.
  void eliminate(Index target, Index source, Index j) {
    const nmod_t& mod = matrix_->mod;
    const mp_limb_t ratio = nmod_div(matrix_->rows[target][j], matrix_->rows[source][j], mod);
    _nmod_vec_scalar_addmul_nmod(matrix_->rows[target] + j, matrix_->rows[source] + j, matrix_->c - j,
                                 nmod_neg(ratio, mod), mod);
  }

 private:
  nmod_mat_t matrix_;
};

}  // namespace

Minor independent_minor(const IntegerMatrix& A, const Deadline& deadline) {
  Residues residues(A);
  std::vector<Index> free_rows(static_cast<std::size_t>(A.rows()));
  std::iota(free_rows.begin(), free_rows.end(), Index{0});
  Minor minor;
  for (Index j = 0; j < A.cols() && !free_rows.empty(); ++j) {
    deadline.check();
    const auto pivot = std::find_if(free_rows.begin(), free_rows.end(), [&](Index i) { return residues(i, j) != 0; });
    if (pivot == free_rows.end()) continue;
    const Index row = *pivot;
    free_rows.erase(pivot);
    minor.rows.push_back(row);
    minor.columns.push_back(j);
    for (const Index i : free_rows) {
      if (residues(i, j) != 0) residues.eliminate(i, row, j);
    }
  }
  return minor;
}

Equations part(const Equations& e, const Minor& minor) {
  const auto size = static_cast<Index>(minor.columns.size());
  Equations square{IntegerMatrix(size, size), IntegerMatrix(size, 1)};
  for (Index i = 0; i < size; ++i) {
    const Index row = minor.rows[static_cast<std::size_t>(i)];
    fmpz_set(square.b(i, 0), e.b(row, 0));
    for (Index j = 0; j < size; ++j) {
      fmpz_set(square.A(i, j), e.A(row, minor.columns[static_cast<std::size_t>(j)]));
    }
  }
  return square;
}

std::optional<IntegerVector> solve_independent_part(const Equations& e, const Deadline& deadline) {
  const Minor minor = independent_minor(e.A, deadline);
  if (std::find(minor.rows.begin(), minor.rows.end(), Index{0}) == minor.rows.end()) return std::nullopt;
  const Equations square = part(e, minor);
  IntegerMatrix x;
  Integer denominator;
  if (!Lifting(square.A, deadline).solve(square.b, x, denominator)) return std::nullopt;
  IntegerVector solution(static_cast<std::size_t>(e.A.cols()));
  for (std::size_t j = 0; j < minor.columns.size(); ++j) {
    fmpz_swap(solution[static_cast<std::size_t>(minor.columns[j])].get(), x(static_cast<Index>(j), 0));
  }
  return solution;
}

}  // namespace lcpbench::exact
