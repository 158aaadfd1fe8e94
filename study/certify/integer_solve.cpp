#include "study/certify/integer_solve.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <flint/fmpq.h>
#include <flint/nmod_vec.h>
#include <flint/ulong_extras.h>

#include "core/selection.h"

namespace lcpbench::exact {
namespace {

constexpr mp_limb_t kPrime = 9223372036854775783U;  // 2^63 - 25

// Row `target` less the multiple of row `source` that leaves no entry in column j; columns before j are not needed.
void eliminate(nmod_mat_struct* a, Index target, Index source, Index j) {
  const mp_limb_t ratio = nmod_div(a->rows[target][j], a->rows[source][j], a->mod);
  _nmod_vec_scalar_addmul_nmod(a->rows[target] + j, a->rows[source] + j, a->c - j, nmod_neg(ratio, a->mod), a->mod);
}

constexpr int kPrimeBits = 60;
constexpr slong kFirstAttempt = 8;
constexpr Index kLargestOrder = Index{1} << 13;

/// x / denominator = of, modulo `modulus`, with a denominator up to d and numerators up to b_size d, d the largest for
/// which there is one such x at most. False where there is none.
bool reconstruct(const IntegerMatrix& of, const Integer& modulus, const Integer& b_size, IntegerMatrix& x,
                 Integer& denominator) {
  Integer most_numerator;
  Integer most_denominator;
  fmpz_fdiv_q_2exp(most_denominator.get(), modulus.get(), 1);
  fmpz_fdiv_q(most_denominator.get(), most_denominator.get(), b_size.get());
  fmpz_sqrt(most_denominator.get(), most_denominator.get());
  if (most_denominator.sign() == 0) return false;
  fmpz_mul(most_numerator.get(), most_denominator.get(), b_size.get());
  fmpz_one(denominator.get());
  Integer value;
  Integer numerator;
  Integer factor;
  for (Index j = 0; j < of.rows(); ++j) {
    fmpz_mul(value.get(), of(j, 0), denominator.get());
    fmpz_mod(value.get(), value.get(), modulus.get());
    if (_fmpq_reconstruct_fmpz_2(numerator.get(), factor.get(), value.get(), modulus.get(), most_numerator.get(),
                                 most_denominator.get()) == 0) {
      return false;
    }
    for (Index i = 0; i < j && fmpz_is_one(factor.get()) == 0; ++i) fmpz_mul(x(i, 0), x(i, 0), factor.get());
    fmpz_mul(denominator.get(), denominator.get(), factor.get());
    if (fmpz_cmp(denominator.get(), most_denominator.get()) > 0) return false;
    fmpz_set(x(j, 0), numerator.get());
  }
  return true;
}

/// Gauss's elimination in place: returns the determinant. Gauss and Jordan's, where the inverse is wanted: a column of
/// the unit matrix takes that of the pivot. Not FLINT's, which looks at no clock.
mp_limb_t eliminate(nmod_mat_struct* a, bool invert, const Deadline& deadline) {
  const slong n = a->r;
  const nmod_t modulus = a->mod;
  mp_limb_t determinant = 1;
  std::vector<slong> swapped(index(n));
  for (slong k = 0; k < n; ++k) {
    deadline.check();
    slong from = k;
    while (from < n && a->rows[from][k] == 0) ++from;
    if (from == n) return 0;
    swapped[index(k)] = from;
    std::swap_ranges(a->rows[k], a->rows[k] + n, a->rows[from]);
    if (from != k) determinant = nmod_neg(determinant, modulus);
    mp_limb_t* const pivot = a->rows[k];
    determinant = nmod_mul(determinant, pivot[k], modulus);
    const mp_limb_t reciprocal = nmod_inv(pivot[k], modulus);
    pivot[k] = 1;
    const slong begin = invert ? 0 : k;
    _nmod_vec_scalar_mul_nmod(pivot + begin, pivot + begin, n - begin, reciprocal, modulus);
    for (slong i = invert ? 0 : k + 1; i < n; ++i) {
      mp_limb_t* const row = a->rows[i];
      if (i == k || row[k] == 0) continue;
      const mp_limb_t factor = nmod_neg(row[k], modulus);
      row[k] = 0;
      _nmod_vec_scalar_addmul_nmod(row + begin, pivot + begin, n - begin, factor, modulus);
    }
  }
  for (slong k = n; invert && k-- > 0;) {
    const slong other = swapped[index(k)];
    for (slong i = 0; i < n && other != k; ++i) std::swap(a->rows[i][k], a->rows[i][other]);
  }
  return determinant;
}

}  // namespace

Lifting::Lifting(const IntegerMatrix& A, const Deadline& deadline) : A_(A), deadline_(deadline) {
  mp_limb_t prime = UWORD(1) << kPrimeBits;
  for (int attempt = 0; attempt < 2 && !possible_ && A.rows() <= kLargestOrder; ++attempt) {
    prime = n_nextprime(prime, 0);
    inverse_ = Residues(A, prime);
    possible_ = eliminate(inverse_.get(), true, deadline) != 0;
  }
}

// A digit d is A^-1 r modulo p; then r = (r - A d) / p. x is the sum of the digits times the powers of p.
bool Lifting::solve(const IntegerMatrix& b, IntegerMatrix& x, Integer& denominator) const {
  const Index n = A_.rows();
  x = IntegerMatrix(n, 1);
  fmpz_one(denominator.get());
  if (fmpz_mat_is_zero(b.get()) != 0) return true;
  deadline_.check();
  if (!possible_) return false;
  const mp_limb_t prime = inverse_.get()->mod.n;
  Integer most_numerator;
  Integer most_denominator;
  fmpz_mat_solve_bound(most_numerator.get(), most_denominator.get(), A_.get(), b.get());
  const slong b_bits = std::abs(fmpz_mat_max_bits(b.get()));
  const auto bits = [](const Integer& value) { return static_cast<slong>(fmpz_bits(value.get())); };
  const slong enough =
      1 + (2 + b_bits + 2 * std::max(bits(most_denominator), bits(most_numerator) - b_bits + 1)) / kPrimeBits;
  Integer b_size;
  fmpz_one_2exp(b_size.get(), static_cast<ulong>(b_bits));
  IntegerMatrix residual = b;
  IntegerMatrix sum(n, 1);
  IntegerMatrix product(n, 1);
  IntegerMatrix digit(n, 1);
  IntegerMatrix scaled(n, 1);
  Integer power(1);
  slong attempt = std::min(kFirstAttempt, enough);
  for (slong digits = 1;; ++digits) {
    deadline_.check();
    const Residues reduced(residual, prime);
    Residues digits_modulo(digit, prime);
    nmod_mat_mul(digits_modulo.get(), inverse_.get(), reduced.get());
    fmpz_mat_set_nmod_mat_unsigned(digit.get(), digits_modulo.get());
    fmpz_mat_scalar_addmul_fmpz(sum.get(), digit.get(), power.get());
    fmpz_mul_ui(power.get(), power.get(), prime);
    if (digits >= attempt) {
      if (reconstruct(sum, power, b_size, x, denominator)) {
        fmpz_mat_mul(product.get(), A_.get(), x.get());
        fmpz_mat_scalar_mul_fmpz(scaled.get(), b.get(), denominator.get());
        if (fmpz_mat_equal(product.get(), scaled.get()) != 0) return true;
      }
      if (digits >= enough) return false;
      attempt = std::min(2 * attempt, enough);
    }
    fmpz_mat_mul(product.get(), A_.get(), digit.get());
    fmpz_mat_sub(residual.get(), residual.get(), product.get());
    fmpz_mat_scalar_divexact_ui(residual.get(), residual.get(), prime);
  }
}

Integer Lifting::determinant_over(const Integer& divisor) const {
  Integer bound;
  fmpz_mat_det_bound(bound.get(), A_.get());
  fmpz_cdiv_q(bound.get(), bound.get(), divisor.get());
  fmpz_mul_2exp(bound.get(), bound.get(), 1);
  Integer quotient;
  Integer modulus(1);
  mp_limb_t prime = UWORD(1) << kPrimeBits;
  while (fmpz_cmp(modulus.get(), bound.get()) <= 0) {
    deadline_.check();
    prime = n_nextprime(prime, 0);
    const mp_limb_t remainder = fmpz_fdiv_ui(divisor.get(), prime);
    if (remainder == 0) continue;
    Residues reduced(A_, prime);
    const mp_limb_t determinant = eliminate(reduced.get(), false, deadline_);
    const mp_limb_t residue = n_mulmod2(determinant, n_invmod(remainder, prime), prime);
    fmpz_CRT_ui(quotient.get(), quotient.get(), modulus.get(), residue, prime, 1);
    fmpz_mul_ui(modulus.get(), modulus.get(), prime);
  }
  fmpz_abs(quotient.get(), quotient.get());
  return quotient;
}

Minor independent_minor(const IntegerMatrix& A, const Deadline& deadline) {
  Residues residues(A, kPrime);
  nmod_mat_struct* const a = residues.get();
  std::vector<Index> free_rows = all_indices(A.rows());
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
    const Index row = minor.rows[index(i)];
    fmpz_set(square.b(i, 0), e.b(row, 0));
    for (Index j = 0; j < size; ++j) {
      fmpz_set(square.A(i, j), e.A(row, minor.columns[index(j)]));
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
  IntegerVector solution(index(e.A.cols()));
  for (std::size_t j = 0; j < minor.columns.size(); ++j) {
    fmpz_swap(solution[index(minor.columns[j])].get(), x(static_cast<Index>(j), 0));
  }
  return solution;
}

}  // namespace lcpbench::exact
