#include "study/certify/integer_solve.h"

#include <algorithm>
#include <numeric>

#include <flint/nmod_vec.h>

#include "study/certify/lifting.h"

namespace lcpbench::exact {
namespace {

constexpr mp_limb_t kPrime = 9223372036854775783U;  // 2^63 - 25

// Row `target` less the multiple of row `source` that leaves no entry in column j; columns before j are not needed.
void eliminate(nmod_mat_struct* a, Index target, Index source, Index j) {
  const mp_limb_t ratio = nmod_div(a->rows[target][j], a->rows[source][j], a->mod);
  _nmod_vec_scalar_addmul_nmod(a->rows[target] + j, a->rows[source] + j, a->c - j, nmod_neg(ratio, a->mod), a->mod);
}

}  // namespace

Minor independent_minor(const IntegerMatrix& A, const Deadline& deadline) {
  Residues residues(A, kPrime);
  nmod_mat_struct* const a = residues.get();
  std::vector<Index> free_rows(static_cast<std::size_t>(A.rows()));
  std::iota(free_rows.begin(), free_rows.end(), Index{0});
  Minor minor;
  for (Index j = 0; j < A.cols() && !free_rows.empty(); ++j) {
    deadline.check();
    const auto pivot = std::find_if(free_rows.begin(), free_rows.end(), [&](Index i) { return a->rows[i][j] != 0; });
    if (pivot == free_rows.end()) continue;
    const Index row = *pivot;
    free_rows.erase(pivot);
    minor.rows.push_back(row);
    minor.columns.push_back(j);
    for (const Index i : free_rows) {
      if (a->rows[i][j] != 0) eliminate(a, i, row, j);
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
