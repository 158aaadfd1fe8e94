#pragma once

#include <cstdint>
#include <vector>

#include "study/certify/deadline.h"
#include "study/certify/integers.h"

namespace lcpbench::exact {

/// Solves A x = denominator b exactly for a square A and any number of right-hand sides, by p-adic lifting. [Dixon
/// 1982]
///
/// A^-1 modulo a prime of 61 bits gives one digit of x after the other; x follows from its digits by rational
/// reconstruction, tried each time their number has doubled and checked by multiplication, at the latest when there are
/// as many as Hadamard's bound asks for. O(n^3) for A^-1, then O(n^2) a digit: products of machine words, one for each
/// 52 bits of an entry of A that are not all zero.
///
/// The deadline is read at least every O(n^2) word operations. @throws TimePassed
class Lifting {
 public:
  /// @param A,deadline  outlive this
  Lifting(const IntegerMatrix& A, const Deadline& deadline);

  /// A^-1 was found to exist; false where A is singular modulo two primes. With a probability near 2^-120 that is
  /// wrong.
  bool possible() const { return possible_; }

  /// False where A is not invertible and b is not zero; x is zero where b is. @param b,x  n x 1
  bool solve(const IntegerMatrix& b, IntegerMatrix& x, Integer& denominator) const;

  /// |det A| / divisor, modulo as many primes as Hadamard's bound asks for. @pre possible(); divisor > 0 divides det A
  Integer determinant_over(const Integer& divisor) const;

 private:
  /// Entry (row, column) of A holds value 2^(52 slice), among others.
  struct Slice {
    std::int64_t value;
    std::int32_t column;
    std::int32_t slice;
  };

  mp_limb_t determinant_modulo(mp_limb_t prime) const;
  bool invert_modulo(mp_limb_t prime);
  void slice_rows();
  double hadamard_bits() const;
  std::vector<mp_limb_t> next_digits(IntegerVector& residual) const;
  bool reconstruct(const std::vector<std::vector<mp_limb_t>>& digits, double numerator_bits, double denominator_bits,
                   IntegerMatrix& x, Integer& denominator) const;
  bool checks(const IntegerMatrix& b, const IntegerMatrix& x, const Integer& denominator) const;

  const IntegerMatrix& A_;
  const Deadline& deadline_;
  Index n_;
  nmod_t modulus_{};
  std::vector<mp_limb_t> inverse_;  // n x n, by rows
  std::vector<std::vector<Slice>> rows_;
  bool possible_ = false;
};

}  // namespace lcpbench::exact
