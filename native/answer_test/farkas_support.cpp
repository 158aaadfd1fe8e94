#include "native/answer_test/farkas_support.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "native/contacts/contact_edges.h"
#include "native/answer_test/scaled_numbers.h"

namespace lcpbench {
namespace {

__extension__ using Wide = unsigned __int128;

/// Normals above which nothing is tried: a system of so many equations takes 113 bits seconds.
constexpr Index kMostNormals = 400;
/// Multiplications modulo primes above which the rank is not asked for: some tens of milliseconds. And about those that
/// the residue of a double takes.
constexpr double kMostWork = 4e6;
constexpr double kOfResidue = 20;
/// Primes are between 2^61 and 2^62.
constexpr std::size_t kBitsOfPrime = 61;
constexpr std::uint64_t kAbovePrimes = std::uint64_t{1} << 62;

std::uint64_t product(std::uint64_t a, std::uint64_t b, std::uint64_t modulus) {
  return static_cast<std::uint64_t>(Wide{a} * b % modulus);
}

std::uint64_t power(std::uint64_t base, std::uint64_t exponent, std::uint64_t modulus) {
  std::uint64_t result = 1;
  for (; exponent != 0; exponent >>= 1U) {
    if ((exponent & 1U) != 0) result = product(result, base, modulus);
    base = product(base, base, modulus);
  }
  return result;
}

/// Of odd numbers above 40. These bases decide all numbers below 2^64. [Sorenson, Webster 2015]
bool is_prime(std::uint64_t n) {
  const int twos = std::countr_zero(n - 1);
  for (const std::uint64_t base : {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37}) {
    std::uint64_t x = power(base, (n - 1) >> static_cast<unsigned>(twos), n);
    if (x == 1 || x == n - 1) continue;
    int squared = 1;
    for (; squared < twos && x != n - 1; ++squared) x = product(x, x, n);
    if (x != n - 1) return false;
  }
  return true;
}

/// |x| = mantissa 2^exponent, mantissa odd.
struct OddParts {
  std::uint64_t mantissa = 0;
  int exponent = 0;
};

/// @param x not zero
OddParts odd_parts(double x) {
  constexpr int kDigits = std::numeric_limits<double>::digits;
  OddParts parts;
  parts.mantissa = static_cast<std::uint64_t>(std::ldexp(std::frexp(std::fabs(x), &parts.exponent), kDigits));
  const int zeros = std::countr_zero(parts.mantissa);
  parts.mantissa >>= static_cast<unsigned>(zeros);
  parts.exponent += zeros - kDigits;
  return parts;
}

std::uint64_t residue(double x, std::uint64_t prime) {
  if (x == 0) return 0;
  const OddParts parts = odd_parts(x);
  const std::uint64_t base = parts.exponent < 0 ? (prime + 1) / 2 : 2;
  const auto exponent = static_cast<std::uint64_t>(std::abs(parts.exponent));
  const std::uint64_t size = product(parts.mantissa % prime, power(base, exponent, prime), prime);
  return x < 0 && size != 0 ? prime - size : size;
}

/// Of numbers: the bits from the lowest that one of them has to the highest.
struct BitRange {
  int lowest = std::numeric_limits<int>::max();
  int highest = std::numeric_limits<int>::min();

  void add(double x) {
    if (x == 0) return;
    lowest = std::min(lowest, odd_parts(x).exponent);
    highest = std::max(highest, exponent_of(x));
  }
  std::size_t bits() const { return highest < lowest ? 0 : static_cast<std::size_t>(highest - lowest) + 1; }
};

}  // namespace

void FarkasSupport::reserve(Index ngc, Index factors, Index contacts) {
  const auto rows = static_cast<std::size_t>(factors);
  const auto order = static_cast<std::size_t>(std::min({contacts, factors + 1, kMostNormals}));
  row_exponent_.reserve(rows);
  column_exponent_.reserve(order);
  rows_.reserve(rows);
  is_chosen_.reserve(rows);
  eliminated_.reserve(rows * order);
  for (std::vector<Quad>* matrix : {&system_, &terms_}) matrix->reserve(order * order);
  inverse_.reserve(2 * order * order);
  constexpr auto kMostResidues = static_cast<std::size_t>(kMostWork / kOfResidue);
  residues_of_X_.reserve(std::min(static_cast<std::size_t>(ngc) * rows, kMostResidues));
  residues_.reserve(std::min(rows * order, kMostResidues));
}

bool FarkasSupport::proves_unsolvable(const ContactProblem& contact, const Eigen::Ref<const Matrix>& X, const double* v,
                                      const std::vector<Index>& normals) {
  contact_ = &contact;
  X_ = &X;
  normals_ = &normals;
  order_ = static_cast<Index>(normals.size());
  if (order_ == 0 || order_ > std::min(X.cols() + 1, kMostNormals)) return false;
  find_exponents();
  if (!choose_rows()) return false;
  form_system();
  return invert_system() && encloses_negative(v) && (X.cols() < order_ || lacks_rank());
}

/// Calls visit(term) for the scaled terms of entry (row, column) of A. Products of two doubles are exact.
template <class Visit>
void FarkasSupport::for_each_term(Index row, Index column, Visit&& visit) const {
  const int exponent =
      row_exponent_[static_cast<std::size_t>(row)] + column_exponent_[static_cast<std::size_t>(column)];
  for_each_entry(contact_->N, normal(column), [&](Index i, double entry) {
    const double entry_of_X = (*X_)(i, row);
    if (entry_of_X != 0) visit(scaled(static_cast<Quad>(entry_of_X) * static_cast<Quad>(entry), exponent));
  });
}

void FarkasSupport::find_exponents() {
  row_exponent_.clear();
  column_exponent_.clear();
  for (Index k = 0; k < X_->cols(); ++k) {
    const double largest = X_->rows() > 0 ? X_->col(k).cwiseAbs().maxCoeff() : 0.0;
    row_exponent_.push_back(largest > 0 ? -exponent_of(largest) : 0);
  }
  for (Index j = 0; j < order_; ++j) {
    int largest = kNoExponent;
    for_each_entry(contact_->N, normal(j), [&](Index i, double entry) {
      for (Index k = 0; k < X_->cols(); ++k) {
        const int of_X = exponent_of((*X_)(i, k));
        if (of_X == kNoExponent) continue;
        largest = std::max(largest, exponent_of(entry) + of_X + row_exponent_[static_cast<std::size_t>(k)]);
      }
    });
    column_exponent_.push_back(largest == kNoExponent ? 0 : -largest);
  }
}

/// All rows of A but one fewer than the columns are left out, by elimination with complete pivoting.
bool FarkasSupport::choose_rows() {
  const Index count = X_->cols();
  eliminated_.assign(static_cast<std::size_t>(count * order_), Quad{0});
  for (Index k = 0; k < count; ++k) {
    for (Index j = 0; j < order_; ++j) for_each_term(k, j, [&](Quad term) { at(eliminated_, k, j) += term; });
  }
  rows_.clear();
  is_chosen_.assign(static_cast<std::size_t>(count), 0);
  while (static_cast<Index>(rows_.size()) < order_ - 1) {
    Index row = -1;
    Index column = 0;
    Quad largest = 0;
    for (Index k = 0; k < count; ++k) {
      if (is_chosen_[static_cast<std::size_t>(k)] != 0) continue;
      for (Index j = 0; j < order_; ++j) {
        if (magnitude(at(eliminated_, k, j)) > largest) largest = magnitude(at(eliminated_, k, j)), row = k, column = j;
      }
    }
    if (row < 0) return false;
    rows_.push_back(row);
    is_chosen_[static_cast<std::size_t>(row)] = 1;
    for (Index k = 0; k < count; ++k) {
      if (is_chosen_[static_cast<std::size_t>(k)] != 0) continue;
      const Quad factor = at(eliminated_, k, column) / at(eliminated_, row, column);
      for (Index j = 0; j < order_ && factor != 0; ++j) at(eliminated_, k, j) -= factor * at(eliminated_, row, j);
      at(eliminated_, k, column) = 0;
    }
  }
  return true;
}

/// The rows chosen and, last, sum u = 1.
void FarkasSupport::form_system() {
  system_.assign(static_cast<std::size_t>(order_ * order_), Quad{1});
  terms_.assign(static_cast<std::size_t>(order_ * order_), Quad{1});
  for (Index r = 0; r + 1 < order_; ++r) {
    for (Index j = 0; j < order_; ++j) {
      at(system_, r, j) = at(terms_, r, j) = 0;
      for_each_term(rows_[static_cast<std::size_t>(r)], j, [&](Quad term) {
        at(system_, r, j) += term;
        at(terms_, r, j) += magnitude(term);
      });
    }
  }
}

/// inverse_ := about the inverse of the system, by Gauss and Jordan with partial pivoting.
bool FarkasSupport::invert_system() {
  const Index width = 2 * order_;
  inverse_.assign(static_cast<std::size_t>(order_ * width), Quad{0});
  const auto entry = [&](Index i, Index j) -> Quad& { return inverse_[static_cast<std::size_t>(i * width + j)]; };
  for (Index i = 0; i < order_; ++i) {
    for (Index j = 0; j < order_; ++j) entry(i, j) = at(system_, i, j);
    entry(i, order_ + i) = 1;
  }
  for (Index k = 0; k < order_; ++k) {
    Index pivot = k;
    for (Index i = k + 1; i < order_; ++i) {
      if (magnitude(entry(i, k)) > magnitude(entry(pivot, k))) pivot = i;
    }
    if (!(magnitude(entry(pivot, k)) > 0)) return false;
    for (Index j = 0; j < width && pivot != k; ++j) std::swap(entry(pivot, j), entry(k, j));
    const Quad reciprocal = 1 / entry(k, k);
    for (Index j = 0; j < width; ++j) entry(k, j) *= reciprocal;
    for (Index i = 0; i < order_; ++i) {
      const Quad factor = entry(i, k);
      for (Index j = 0; j < width && i != k && factor != 0; ++j) entry(i, j) -= factor * entry(k, j);
    }
  }
  for (Index i = 0; i < order_; ++i) {
    for (Index j = 0; j < order_; ++j) at(inverse_, i, j) = entry(i, order_ + j);  // behind what is still to be read
  }
  return true;
}

/// Whether the exact system B u = e, e the last unit vector, has a solution u > 0 with v'N u < 0. With R about the
/// inverse of B and |I - R B| < 1, u is off by at most |R| |B u~ - e| / (1 - |I - R B|).
bool FarkasSupport::encloses_negative(const double* v) {
  const Quad sums = static_cast<Quad>(4 * kQuadUnitRoundoff * static_cast<double>(X_->rows() + order_ + 4));
  constexpr Quad kRoom = 0x1.2p0;  // for the rounding of the bounds themselves
  const Index last = order_ - 1;
  Quad missed = 0;
  Quad inverse = 0;
  Quad off_unit = 0;
  for (Index r = 0; r < order_; ++r) {
    Quad sum = r == last ? -1 : 0;
    Quad terms = 1;
    Quad size = 0;
    Quad off = 0;
    for (Index j = 0; j < order_; ++j) {
      const Quad u = at(inverse_, j, last);
      sum += at(system_, r, j) * u;
      terms += at(terms_, r, j) * magnitude(u);
      size += magnitude(at(inverse_, r, j));
      Quad product = j == r ? -1 : 0;
      Quad magnitudes = 1;
      for (Index k = 0; k < order_; ++k) {
        product += at(inverse_, r, k) * at(system_, k, j);
        magnitudes += magnitude(at(inverse_, r, k)) * at(terms_, k, j);
      }
      off += magnitude(product) + sums * magnitudes;
    }
    if (!(off < Quad{0.5} && is_finite(size) && is_finite(terms))) return false;
    missed = std::max(missed, magnitude(sum) + sums * terms);
    inverse = std::max(inverse, size);
    off_unit = std::max(off_unit, off);
  }
  const Quad off = kRoom * inverse * missed / (1 - off_unit);
  Quad value = 0;
  Quad rounding = 0;
  for (Index j = 0; j < order_; ++j) {
    const Quad u = at(inverse_, j, last);
    if (!(u > off)) return false;
    Quad cost = 0;
    Quad terms = 0;
    for_each_entry(contact_->N, normal(j), [&](Index i, double entry) {
      const Quad term =
          scaled(static_cast<Quad>(entry) * static_cast<Quad>(v[i]), column_exponent_[static_cast<std::size_t>(j)]);
      cost += term;
      terms += magnitude(term);
    });
    value += cost * u;
    rounding += terms * (off + sums * u);
  }
  return value < -kRoom * rounding;
}

/// A minor of all columns of A, made integers, is below 2 to this in magnitude.
std::size_t FarkasSupport::bits_of_minors() const {
  std::size_t of_X = 0;
  for (Index k = 0; k < X_->cols(); ++k) {
    BitRange range;
    for (Index i = 0; i < X_->rows(); ++i) range.add((*X_)(i, k));
    of_X = std::max(of_X, range.bits());
  }
  // Of the sum of ngc products, and of the Euclidean length of `order_` such sums.
  const auto of_sums = static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(X_->rows())) +
                                                std::bit_width(static_cast<std::uint64_t>(order_)));
  std::size_t bits = 0;
  for (Index j = 0; j < order_; ++j) {
    BitRange range;
    for_each_entry(contact_->N, normal(j), [&](Index, double entry) { range.add(entry); });
    bits += of_X + range.bits() + of_sums;
  }
  return bits;
}

/// Whether A has less than full column rank, without any rounding. False too where that would take too long.
bool FarkasSupport::lacks_rank() {
  const std::size_t primes = bits_of_minors() / kBitsOfPrime + 1;
  const auto rows = static_cast<double>(X_->rows());
  const auto columns = static_cast<double>(order_);
  const double work =
      static_cast<double>(X_->cols()) * (rows * (kOfResidue + columns) + columns * (kOfResidue + columns)) +
      kOfResidue * rows * columns;
  if (static_cast<double>(primes) * work > kMostWork) return false;
  std::uint64_t prime = kAbovePrimes - 1;
  for (std::size_t found = 0; found < primes; prime -= 2) {
    if (!is_prime(prime)) continue;
    if (!lacks_rank(prime)) return false;
    ++found;
  }
  return true;
}

/// The same modulo a prime.
bool FarkasSupport::lacks_rank(std::uint64_t prime) {
  const Index ngc = X_->rows();
  const Index count = X_->cols();
  residues_of_X_.resize(static_cast<std::size_t>(ngc * count));
  residues_.assign(static_cast<std::size_t>(count * order_), 0);
  const auto of_X = [&](Index i, Index k) -> std::uint64_t& {
    return residues_of_X_[static_cast<std::size_t>(i * count + k)];
  };
  const auto entry = [&](Index k, Index j) -> std::uint64_t& {
    return residues_[static_cast<std::size_t>(k * order_ + j)];
  };
  for (Index i = 0; i < ngc; ++i) {
    for (Index k = 0; k < count; ++k) of_X(i, k) = residue((*X_)(i, k), prime);
  }
  for (Index j = 0; j < order_; ++j) {
    for_each_entry(contact_->N, normal(j), [&](Index i, double value) {
      const std::uint64_t of_N = residue(value, prime);
      for (Index k = 0; k < count; ++k) entry(k, j) = (entry(k, j) + product(of_X(i, k), of_N, prime)) % prime;
    });
  }
  for (Index j = 0; j < order_; ++j) {  // rows up to j have the pivots of the columns before
    Index pivot = j;
    while (pivot < count && entry(pivot, j) == 0) ++pivot;
    if (pivot >= count) return true;
    for (Index l = j; l < order_; ++l) std::swap(entry(pivot, l), entry(j, l));
    const std::uint64_t inverse = power(entry(j, j), prime - 2, prime);
    for (Index k = j + 1; k < count; ++k) {
      const std::uint64_t factor = prime - product(entry(k, j), inverse, prime);
      for (Index l = j; l < order_; ++l) entry(k, l) = (entry(k, l) + product(factor, entry(j, l), prime)) % prime;
    }
  }
  return false;
}

}  // namespace lcpbench
