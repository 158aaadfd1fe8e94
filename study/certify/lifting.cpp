#include "study/certify/lifting.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <flint/fmpq.h>
#include <flint/nmod_vec.h>
#include <flint/ulong_extras.h>

namespace lcpbench::exact {
namespace {

/// |part of an entry| < 2^52 and digit < 2^61: 2^13 such products add up below 2^126.
constexpr int kSliceBits = 52;
constexpr int kPrimeBits = 60;
constexpr Index kMostColumns = Index{1} << 13;
constexpr std::size_t kFirstAttempt = 8;
/// Extra bits of a reconstruction, so that a wrong one is multiplied out with a chance of 2^-30 only.
constexpr double kGuardBits = 30;

__extension__ using Wide = __int128;
__extension__ using UnsignedWide = unsigned __int128;

// a -= value 2^shift
void subtract_shifted(Integer& a, Wide value, slong shift) {
  if (value == 0) return;
  Integer part;
  const auto high = static_cast<std::uint64_t>(static_cast<UnsignedWide>(value) >> 64);
  fmpz_set_signed_uiui(part.get(), high, static_cast<std::uint64_t>(value));
  fmpz_mul_2exp(part.get(), part.get(), static_cast<ulong>(shift));
  fmpz_sub(a.get(), a.get(), part.get());
}

// log2 of the Euclidean norm, rounded up; 0 for a zero vector.
double norm_bits(slong largest_bits, Index length) {
  return static_cast<double>(largest_bits) + 0.5 * std::log2(static_cast<double>(std::max(length, Index{1})));
}

Integer power_of_two(double bits) {
  Integer power(1);
  fmpz_mul_2exp(power.get(), power.get(), static_cast<ulong>(std::max(bits, 0.0)));
  return power;
}

/// p, p^2, p^4, ... up to the power that halves `count` digits.
std::vector<Integer> squarings(mp_limb_t prime, std::size_t count) {
  std::vector<Integer> powers(1);
  fmpz_set_ui(powers[0].get(), prime);
  for (std::size_t length = 2; length < count; length *= 2) {
    Integer next;
    fmpz_mul(next.get(), powers.back().get(), powers.back().get());
    powers.push_back(std::move(next));
  }
  return powers;
}

/// The sum of digits_i p^i. @param digits  used up
Integer joined(IntegerVector& digits, const std::vector<Integer>& powers) {
  for (std::size_t level = 0; digits.size() > 1; ++level) {
    const std::size_t half = (digits.size() + 1) / 2;
    for (std::size_t i = 0; 2 * i < digits.size(); ++i) {
      if (2 * i + 1 < digits.size()) {
        fmpz_addmul(digits[2 * i].get(), digits[2 * i + 1].get(), powers[level].get());
      }
      if (i > 0) fmpz_swap(digits[i].get(), digits[2 * i].get());
    }
    digits.resize(half);
  }
  return digits.empty() ? Integer() : std::move(digits.front());
}

// The residue of smallest size.
void center(Integer& a, const Integer& modulus) {
  Integer twice;
  fmpz_mul_2exp(twice.get(), a.get(), 1);
  if (fmpz_cmp(twice.get(), modulus.get()) > 0) fmpz_sub(a.get(), a.get(), modulus.get());
}

}  // namespace

Lifting::Lifting(const IntegerMatrix& A, const Deadline& deadline) : A_(A), deadline_(deadline), n_(A.rows()) {
  if (n_ > kMostColumns) return;
  mp_limb_t prime = UWORD(1) << kPrimeBits;
  for (int attempt = 0; attempt < 2 && !possible_; ++attempt) {
    prime = n_nextprime(prime, 0);
    possible_ = invert_modulo(prime);
  }
  if (possible_) slice_rows();
}

// Gauss and Jordan, in place: a column of the unit matrix takes that of the pivot.
bool Lifting::invert_modulo(mp_limb_t prime) {
  nmod_init(&modulus_, prime);
  const auto n = static_cast<std::size_t>(n_);
  inverse_.assign(n * n, 0);
  for (Index i = 0; i < n_; ++i) {
    deadline_.check();
    for (Index j = 0; j < n_; ++j) {
      inverse_[static_cast<std::size_t>(i * n_ + j)] = fmpz_get_nmod(A_(i, j), modulus_);
    }
  }
  std::vector<std::size_t> swapped(n);
  for (std::size_t k = 0; k < n; ++k) {
    deadline_.check();
    std::size_t from = k;
    while (from < n && inverse_[from * n + k] == 0) ++from;
    if (from == n) return false;
    swapped[k] = from;
    mp_limb_t* pivot_row = &inverse_[k * n];
    if (from != k) std::swap_ranges(pivot_row, pivot_row + n, &inverse_[from * n]);
    const mp_limb_t reciprocal = nmod_inv(pivot_row[k], modulus_);
    pivot_row[k] = 1;
    _nmod_vec_scalar_mul_nmod(pivot_row, pivot_row, n_, reciprocal, modulus_);
    for (std::size_t i = 0; i < n; ++i) {
      mp_limb_t* row = &inverse_[i * n];
      if (i == k || row[k] == 0) continue;
      const mp_limb_t factor = nmod_neg(row[k], modulus_);
      row[k] = 0;
      _nmod_vec_scalar_addmul_nmod(row, pivot_row, n_, factor, modulus_);
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    if (swapped[k] == k) continue;
    for (std::size_t i = 0; i < n; ++i) std::swap(inverse_[i * n + k], inverse_[i * n + swapped[k]]);
  }
  return true;
}

mp_limb_t Lifting::determinant_modulo(mp_limb_t prime) const {
  nmod_t modulus;
  nmod_init(&modulus, prime);
  const auto n = static_cast<std::size_t>(n_);
  std::vector<mp_limb_t> entries(n * n);
  for (Index i = 0; i < n_; ++i) {
    deadline_.check();
    for (Index j = 0; j < n_; ++j) entries[static_cast<std::size_t>(i * n_ + j)] = fmpz_get_nmod(A_(i, j), modulus);
  }
  mp_limb_t determinant = 1;
  for (std::size_t k = 0; k < n; ++k) {
    deadline_.check();
    std::size_t from = k;
    while (from < n && entries[from * n + k] == 0) ++from;
    if (from == n) return 0;
    mp_limb_t* pivot_row = &entries[k * n];
    if (from != k) {
      std::swap_ranges(pivot_row, pivot_row + n, &entries[from * n]);
      determinant = nmod_neg(determinant, modulus);
    }
    determinant = nmod_mul(determinant, pivot_row[k], modulus);
    const mp_limb_t reciprocal = nmod_inv(pivot_row[k], modulus);
    for (std::size_t i = k + 1; i < n; ++i) {
      mp_limb_t* row = &entries[i * n];
      if (row[k] == 0) continue;
      const mp_limb_t factor = nmod_neg(nmod_mul(row[k], reciprocal, modulus), modulus);
      _nmod_vec_scalar_addmul_nmod(row + k, pivot_row + k, static_cast<slong>(n - k), factor, modulus);
    }
  }
  return determinant;
}

Integer Lifting::determinant_over(const Integer& divisor) const {
  const double bound = hadamard_bits() - static_cast<double>(fmpz_bits(divisor.get())) + 3;
  Integer quotient;
  Integer modulus(1);
  mp_limb_t prime = UWORD(1) << kPrimeBits;
  while (static_cast<double>(fmpz_bits(modulus.get())) <= bound + 1) {
    prime = n_nextprime(prime, 0);
    const mp_limb_t reduced = fmpz_fdiv_ui(divisor.get(), prime);
    if (reduced == 0) continue;
    const mp_limb_t residue = n_mulmod2(determinant_modulo(prime), n_invmod(reduced, prime), prime);
    fmpz_CRT_ui(quotient.get(), quotient.get(), modulus.get(), residue, prime, 1);
    fmpz_mul_ui(modulus.get(), modulus.get(), prime);
  }
  fmpz_abs(quotient.get(), quotient.get());
  return quotient;
}

void Lifting::slice_rows() {
  rows_.resize(static_cast<std::size_t>(n_));
  Integer rest;
  for (Index i = 0; i < n_; ++i) {
    deadline_.check();
    std::vector<Slice>& row = rows_[static_cast<std::size_t>(i)];
    for (Index j = 0; j < n_; ++j) {
      const int sign = fmpz_sgn(A_(i, j));
      if (sign == 0) continue;
      fmpz_abs(rest.get(), A_(i, j));
      auto slice = static_cast<std::int32_t>(fmpz_val2(rest.get()) / kSliceBits);
      fmpz_fdiv_q_2exp(rest.get(), rest.get(), static_cast<ulong>(slice * kSliceBits));
      for (; rest.sign() != 0; ++slice) {
        const ulong low = fmpz_fdiv_ui(rest.get(), UWORD(1) << kSliceBits);
        if (low != 0) row.push_back({sign * static_cast<std::int64_t>(low), static_cast<std::int32_t>(j), slice});
        fmpz_fdiv_q_2exp(rest.get(), rest.get(), kSliceBits);
      }
    }
    std::stable_sort(row.begin(), row.end(), [](const Slice& a, const Slice& b) { return a.slice < b.slice; });
  }
}

// Of the determinant: the smaller of the products of the norms of the rows, and of the columns.
double Lifting::hadamard_bits() const {
  double rows = 0;
  double columns = 0;
  for (Index i = 0; i < n_; ++i) {
    slong row = 0;
    slong column = 0;
    for (Index j = 0; j < n_; ++j) {
      row = std::max(row, static_cast<slong>(fmpz_bits(A_(i, j))));
      column = std::max(column, static_cast<slong>(fmpz_bits(A_(j, i))));
    }
    rows += norm_bits(row, n_);
    columns += norm_bits(column, n_);
  }
  return std::min(rows, columns);
}

// d = A^-1 r modulo p, then r = (r - A d) / p.
std::vector<mp_limb_t> Lifting::next_digits(IntegerVector& residual) const {
  const auto n = static_cast<std::size_t>(n_);
  std::vector<mp_limb_t> reduced(n);
  std::vector<mp_limb_t> digits(n);
  for (std::size_t i = 0; i < n; ++i) reduced[i] = fmpz_get_nmod(residual[i].get(), modulus_);
  const int limbs = _nmod_vec_dot_bound_limbs(n_, modulus_);
  for (std::size_t i = 0; i < n; ++i) {
    digits[i] = _nmod_vec_dot(&inverse_[i * n], reduced.data(), n_, modulus_, limbs);
  }
  for (std::size_t i = 0; i < n; ++i) {
    Wide sum = 0;
    std::int32_t present = 0;
    for (const Slice& entry : rows_[i]) {
      if (entry.slice != present) {
        subtract_shifted(residual[i], sum, slong{present} * kSliceBits);
        sum = 0;
        present = entry.slice;
      }
      sum += static_cast<Wide>(entry.value) * static_cast<Wide>(digits[static_cast<std::size_t>(entry.column)]);
    }
    subtract_shifted(residual[i], sum, slong{present} * kSliceBits);
    fmpz_divexact_ui(residual[i].get(), residual[i].get(), modulus_.n);
  }
  return digits;
}

// Entries mostly share their denominator: those already found are multiplied in first.
bool Lifting::reconstruct(const std::vector<std::vector<mp_limb_t>>& digits, double numerator_bits,
                          double denominator_bits, IntegerMatrix& x, Integer& denominator) const {
  const std::vector<Integer> powers = squarings(modulus_.n, digits.size());
  Integer modulus(1);
  fmpz_set_ui(modulus.get(), modulus_.n);
  fmpz_pow_ui(modulus.get(), modulus.get(), digits.size());
  const Integer most_numerator = power_of_two(numerator_bits);
  const Integer most_denominator = power_of_two(denominator_bits);
  fmpz_one(denominator.get());
  IntegerVector found_with(static_cast<std::size_t>(n_));  // the denominator at that time
  Integer numerator;
  Integer factor;
  for (Index j = 0; j < n_; ++j) {
    deadline_.check();
    IntegerVector own(digits.size());
    for (std::size_t d = 0; d < digits.size(); ++d) fmpz_set_ui(own[d].get(), digits[d][static_cast<std::size_t>(j)]);
    Integer value = joined(own, powers);
    fmpz_mul(value.get(), value.get(), denominator.get());
    fmpz_mod(value.get(), value.get(), modulus.get());
    Integer centered = value;
    center(centered, modulus);
    if (fmpz_cmpabs(centered.get(), most_numerator.get()) > 0) {
      if (_fmpq_reconstruct_fmpz_2(numerator.get(), factor.get(), value.get(), modulus.get(), most_numerator.get(),
                                   most_denominator.get()) == 0) {
        return false;
      }
      fmpz_mul(denominator.get(), denominator.get(), factor.get());
      if (fmpz_cmp(denominator.get(), most_denominator.get()) > 0) return false;
      centered = numerator;
    }
    fmpz_set(x(j, 0), centered.get());
    found_with[static_cast<std::size_t>(j)] = denominator;
  }
  for (Index j = 0; j < n_; ++j) {
    const Integer& own = found_with[static_cast<std::size_t>(j)];
    if (fmpz_equal(own.get(), denominator.get()) != 0) continue;
    fmpz_divexact(factor.get(), denominator.get(), own.get());
    fmpz_mul(x(j, 0), x(j, 0), factor.get());
  }
  return true;
}

bool Lifting::checks(const IntegerMatrix& b, const IntegerMatrix& x, const Integer& denominator) const {
  Integer difference;
  for (Index i = 0; i < n_; ++i) {
    deadline_.check();
    fmpz_mul(difference.get(), b(i, 0), denominator.get());
    for (Index j = 0; j < n_; ++j) {
      if (fmpz_is_zero(A_(i, j)) == 0) fmpz_submul(difference.get(), A_(i, j), x(j, 0));
    }
    if (difference.sign() != 0) return false;
  }
  return true;
}

bool Lifting::solve(const IntegerMatrix& b, IntegerMatrix& x, Integer& denominator) const {
  x = IntegerMatrix(n_, 1);
  fmpz_one(denominator.get());
  if (fmpz_mat_is_zero(b.get()) != 0) return true;
  if (!possible_) return false;
  IntegerVector residual(static_cast<std::size_t>(n_));
  slong largest = 0;
  for (Index i = 0; i < n_; ++i) {
    fmpz_set(residual[static_cast<std::size_t>(i)].get(), b(i, 0));
    largest = std::max(largest, static_cast<slong>(fmpz_bits(b(i, 0))));
  }
  const double b_bits = norm_bits(largest, n_);
  // Of the determinants in Cramer's rule: one column of A is b. The norm of an integer column is 1 or more.
  const double bound = 2 * hadamard_bits() + b_bits + 2 + kGuardBits;
  const auto enough = static_cast<std::size_t>(bound / kPrimeBits) + 1;
  std::vector<std::vector<mp_limb_t>> digits;
  for (std::size_t attempt = std::min(kFirstAttempt, enough);; attempt = std::min(2 * attempt, enough)) {
    while (digits.size() < attempt) {
      deadline_.check();
      digits.push_back(next_digits(residual));
    }
    const double bits = static_cast<double>(attempt * kPrimeBits) - kGuardBits;
    const double denominator_bits = std::max(0.0, (bits - b_bits) / 2);
    if (reconstruct(digits, bits - denominator_bits, denominator_bits, x, denominator) && checks(b, x, denominator)) {
      return true;
    }
    if (attempt == enough) return false;
  }
}

}  // namespace lcpbench::exact
