#include "native/answer_test/farkas_support.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "native/contacts/contact_edges.h"
#include "native/answer_test/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Normals above which nothing is tried: a system of so many equations takes 113 bits seconds.
constexpr Index kMostNormals = 400;
/// Multiplications modulo primes above which the rank is not asked for: some tens of milliseconds. And about those that
/// the residue of a double takes.
constexpr double kMostWork = 4e6;
constexpr double kOfResidue = 20;
/// The primes of prime_field() that are used are above 2^61.
constexpr std::size_t kBitsOfPrime = 61;
/// Integers in the same proportion as u are looked for up to the first; the second is relative.
constexpr double kLargestInteger = 0x1p20;
constexpr Quad kNearInteger = 0x1p-40;
/// Products of doubles outside of this range and its reciprocal may have lost digits, or all.
constexpr double kLargestProduct = 0x1p800;

template <class Real>
constexpr bool kIsDouble = sizeof(Real) == sizeof(double);

template <class Real>
constexpr double kRoundoff = kIsDouble<Real> ? 0x1p-53 : kQuadUnitRoundoff;

/// a b, of double no number where it is out of range. Of Quad it is exact.
template <class Real>
Real product(double a, double b) {
  const Real value = static_cast<Real>(a) * static_cast<Real>(b);
  if constexpr (kIsDouble<Real>) {
    const double size = std::abs(value);
    if (a != 0 && b != 0 && !(size < kLargestProduct && size > 1 / kLargestProduct)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
  }
  return value;
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

PrimeField::Element residue(double x, const PrimeField& field) {
  if (x == 0) return 0;
  const OddParts parts = odd_parts(x);
  const PrimeField::Element base = field.of(parts.exponent < 0 ? (field.prime() + 1) / 2 : 2);
  const PrimeField::Element power = field.power(base, static_cast<std::uint64_t>(std::abs(parts.exponent)));
  const PrimeField::Element size = field.multiply(field.of(parts.mantissa), power);
  return x < 0 ? field.subtract(0, size) : size;
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
  coordinate_exponent_.reserve(static_cast<std::size_t>(ngc));
  is_chosen_.reserve(rows);
  const auto reserve_system = [&](auto& system) {
    for (auto* matrix : {&system.A, &system.terms_of_A, &system.eliminated}) matrix->reserve(rows * order);
    for (auto* matrix : {&system.entries, &system.terms}) matrix->reserve(order * order);
    system.inverse.reserve(2 * order * order);
  };
  reserve_system(in_double_);
  reserve_system(in_quad_);
  u_.reserve(order);
  constexpr auto kMostResidues = static_cast<std::size_t>(kMostWork / kOfResidue);
  residues_of_X_.reserve(std::min(static_cast<std::size_t>(ngc) * rows, kMostResidues));
  residues_.reserve(std::min(rows * order, kMostResidues));
}

bool FarkasSupport::proves_unsolvable(const ContactProblem& contact, const ConstMatrixMap* X, const double* v,
                                      const std::vector<Index>& normals) {
  contact_ = &contact;
  X_ = X;
  normals_ = &normals;
  order_ = static_cast<Index>(normals.size());
  if (order_ == 0 || order_ > std::min(reach_size() + 1, kMostNormals)) return false;
  find_exponents();
  return (finds_negative(in_double_, v) || finds_negative(in_quad_, v)) && (reach_size() < order_ || lacks_rank());
}

/// Whether the enclosure in this arithmetic proves u > 0 and (N'v + b)'u < 0.
template <class Real>
bool FarkasSupport::finds_negative(System<Real>& system, const double* v) {
  form(system);
  return choose_rows(system) && invert(system) && encloses_negative(system, v);
}

void FarkasSupport::find_exponents() {
  row_exponent_.clear();
  column_exponent_.clear();
  coordinate_exponent_.assign(static_cast<std::size_t>(contact_->ngc()), X_ == nullptr ? 0 : kNoExponent);
  for (Index k = 0; k < reach_size(); ++k) {
    const double largest = X_ == nullptr ? 1.0 : X_->rows() > 0 ? X_->col(k).cwiseAbs().maxCoeff() : 0.0;
    row_exponent_.push_back(largest > 0 ? -exponent_of(largest) : 0);
    for (Index i = 0; X_ != nullptr && i < X_->rows(); ++i) {
      if ((*X_)(i, k) == 0) continue;
      int& most = coordinate_exponent_[static_cast<std::size_t>(i)];
      most = std::max(most, exponent_of((*X_)(i, k)) + row_exponent_.back());
    }
  }
  for (Index j = 0; j < order_; ++j) {
    int largest = kNoExponent;
    for_each_entry(contact_->N, normal(j), [&](Index i, double entry) {
      const int of_X = coordinate_exponent_[static_cast<std::size_t>(i)];
      if (entry != 0 && of_X != kNoExponent) largest = std::max(largest, exponent_of(entry) + of_X);
    });
    column_exponent_.push_back(largest == kNoExponent ? 0 : -largest);
  }
}

/// The scaled entries of A, and the magnitudes that each adds up.
template <class Real>
void FarkasSupport::form(System<Real>& system) const {
  const auto size = static_cast<std::size_t>(reach_size() * order_);
  system.A.assign(size, Real{0});
  system.terms_of_A.assign(size, Real{0});
  for (Index j = 0; j < order_; ++j) {
    for_each_entry(contact_->N, normal(j), [&](Index i, double entry) {
      for (Index k = X_ != nullptr ? 0 : i; k < (X_ != nullptr ? reach_size() : i + 1); ++k) {
        const Real term = product<Real>(reach(i, k), entry);
        at(system.A, k, j) += term;
        at(system.terms_of_A, k, j) += magnitude(term);
      }
    });
    for (Index k = 0; k < reach_size(); ++k) {
      const int exponent = row_exponent_[static_cast<std::size_t>(k)] + column_exponent_[static_cast<std::size_t>(j)];
      at(system.A, k, j) = scaled(at(system.A, k, j), exponent);
      at(system.terms_of_A, k, j) = scaled(at(system.terms_of_A, k, j), exponent);
    }
  }
}

/// All rows of A but one fewer than the columns are left out, by elimination with complete pivoting. Those chosen and,
/// last, sum u = 1 are the system.
template <class Real>
bool FarkasSupport::choose_rows(System<Real>& system) {
  const Index count = reach_size();
  system.eliminated = system.A;
  system.entries.assign(static_cast<std::size_t>(order_ * order_), Real{1});
  system.terms.assign(static_cast<std::size_t>(order_ * order_), Real{1});
  is_chosen_.assign(static_cast<std::size_t>(count), 0);
  for (Index r = 0; r + 1 < order_; ++r) {
    Index row = -1;
    Index column = 0;
    Real largest = 0;
    for (Index k = 0; k < count; ++k) {
      if (is_chosen_[static_cast<std::size_t>(k)] != 0) continue;
      for (Index j = 0; j < order_; ++j) {
        const Real size = magnitude(at(system.eliminated, k, j));
        if (size > largest) largest = size, row = k, column = j;
      }
    }
    if (row < 0) return false;
    is_chosen_[static_cast<std::size_t>(row)] = 1;
    for (Index j = 0; j < order_; ++j) {
      at(system.entries, r, j) = at(system.A, row, j);
      at(system.terms, r, j) = at(system.terms_of_A, row, j);
    }
    for (Index k = 0; k < count; ++k) {
      if (is_chosen_[static_cast<std::size_t>(k)] != 0) continue;
      const Real factor = at(system.eliminated, k, column) / at(system.eliminated, row, column);
      for (Index j = 0; j < order_ && factor != 0; ++j) {
        at(system.eliminated, k, j) -= factor * at(system.eliminated, row, j);
      }
      at(system.eliminated, k, column) = 0;
    }
  }
  return true;
}

/// The inverse of the system, about, by Gauss and Jordan with partial pivoting.
template <class Real>
bool FarkasSupport::invert(System<Real>& system) const {
  const Index width = 2 * order_;
  system.inverse.assign(static_cast<std::size_t>(order_ * width), Real{0});
  const auto entry = [&](Index i, Index j) -> Real& { return system.inverse[static_cast<std::size_t>(i * width + j)]; };
  for (Index i = 0; i < order_; ++i) {
    for (Index j = 0; j < order_; ++j) entry(i, j) = at(system.entries, i, j);
    entry(i, order_ + i) = 1;
  }
  for (Index k = 0; k < order_; ++k) {
    Index pivot = k;
    for (Index i = k + 1; i < order_; ++i) {
      if (magnitude(entry(i, k)) > magnitude(entry(pivot, k))) pivot = i;
    }
    if (!(magnitude(entry(pivot, k)) > 0)) return false;
    for (Index j = 0; j < width && pivot != k; ++j) std::swap(entry(pivot, j), entry(k, j));
    const Real reciprocal = 1 / entry(k, k);
    for (Index j = 0; j < width; ++j) entry(k, j) *= reciprocal;
    for (Index i = 0; i < order_; ++i) {
      const Real factor = entry(i, k);
      for (Index j = 0; j < width && i != k && factor != 0; ++j) entry(i, j) -= factor * entry(k, j);
    }
  }
  for (Index i = 0; i < order_; ++i) {
    // Written behind what is still to be read.
    for (Index j = 0; j < order_; ++j) at(system.inverse, i, j) = entry(i, order_ + j);
  }
  return true;
}

/// Whether the exact system B u = e, e the last unit vector, has a solution u > 0 with v'N u < 0. With R about the
/// inverse of B and |I - R B| < 1, u is off by at most |R| |B u~ - e| / (1 - |I - R B|).
template <class Real>
bool FarkasSupport::encloses_negative(System<Real>& system, const double* v) {
  const Real sums = static_cast<Real>(4 * kRoundoff<Real> * static_cast<double>(contact_->ngc() + order_ + 5));
  const Real room = 0x1.2p0;  // for the rounding of the bounds themselves
  const Index last = order_ - 1;
  Real missed = 0;
  Real inverse = 0;
  Real off_unit = 0;
  for (Index r = 0; r < order_; ++r) {
    Real sum = r == last ? -1 : 0;
    Real terms = 1;
    Real size = 0;
    Real off = 0;
    for (Index j = 0; j < order_; ++j) {
      const Real u = at(system.inverse, j, last);
      sum += at(system.entries, r, j) * u;
      terms += at(system.terms, r, j) * magnitude(u);
      size += magnitude(at(system.inverse, r, j));
      Real error = j == r ? -1 : 0;
      Real magnitudes = 1;
      for (Index k = 0; k < order_; ++k) {
        error += at(system.inverse, r, k) * at(system.entries, k, j);
        magnitudes += magnitude(at(system.inverse, r, k)) * at(system.terms, k, j);
      }
      off += magnitude(error) + sums * magnitudes;
    }
    if (!(off < Real{0.5} && size - size == 0 && terms - terms == 0)) return false;
    missed = std::max(missed, magnitude(sum) + sums * terms);
    inverse = std::max(inverse, size);
    off_unit = std::max(off_unit, off);
  }
  const Real off = room * inverse * missed / (1 - off_unit);
  Real value = 0;
  Real rounding = kIsDouble<Real> ? 1 / kLargestProduct : 0;  // of what scaling loses to underflow
  u_.clear();
  for (Index j = 0; j < order_; ++j) {
    const Real u = at(system.inverse, j, last);
    if (!(u > off)) return false;
    const int exponent = column_exponent_[static_cast<std::size_t>(j)];
    Real cost = scaled(static_cast<Real>(contact_->offset(normal(j))), exponent);
    Real terms = magnitude(cost);
    for_each_entry(contact_->N, normal(j), [&](Index i, double entry) {
      const Real term = scaled(product<Real>(entry, v[i]), exponent);
      cost += term;
      terms += magnitude(term);
    });
    value += cost * u;
    rounding += terms * (off + sums * u);
    u_.push_back(static_cast<Quad>(u));
  }
  return value < -room * rounding;
}

/// A minor of all columns of A, made integers, is below 2 to this in magnitude.
std::size_t FarkasSupport::bits_of_minors() const {
  std::size_t of_X = 1;
  for (Index k = 0; k < reach_size() && X_ != nullptr; ++k) {
    BitRange range;
    for (const double entry : X_->col(k)) range.add(entry);
    of_X = std::max(of_X, range.bits());
  }
  // Of the sum of ngc products, and of the Euclidean length of `order_` such sums.
  const auto of_sums = static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(contact_->ngc())) +
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
  const auto rows = static_cast<double>(X_ != nullptr ? X_->rows() : 1);
  const auto columns = static_cast<double>(order_);
  const double work =
      static_cast<double>(reach_size()) * (rows * (kOfResidue + columns) + columns * (kOfResidue + columns)) +
      kOfResidue * rows * columns;
  if (static_cast<double>(primes) * work > kMostWork) return false;
  for (std::size_t k = 0; k < primes; ++k) {
    if (!lacks_rank(prime_field(k))) return false;
  }
  return true;
}

/// The same modulo a prime.
bool FarkasSupport::lacks_rank(const PrimeField& field) {
  const Index count = reach_size();
  residues_.assign(static_cast<std::size_t>(count * order_), 0);
  const auto entry = [&](Index k, Index j) -> PrimeField::Element& {
    return residues_[static_cast<std::size_t>(k * order_ + j)];
  };
  const Index entries = X_ != nullptr ? X_->size() : 0;
  residues_of_X_.resize(static_cast<std::size_t>(entries));
  for (Index i = 0; i < entries; ++i) residues_of_X_[static_cast<std::size_t>(i)] = residue(X_->data()[i], field);
  for (Index j = 0; j < order_; ++j) {
    for_each_entry(contact_->N, normal(j), [&](Index i, double value) {
      const PrimeField::Element of_N = residue(value, field);
      if (X_ == nullptr) entry(i, j) = of_N;
      for (Index k = 0; k < count && X_ != nullptr; ++k) {
        const PrimeField::Element of_X = residues_of_X_[static_cast<std::size_t>(i + k * X_->rows())];
        entry(k, j) = field.add(entry(k, j), field.multiply(of_X, of_N));
      }
    });
  }
  for (Index j = 0; j < order_; ++j) {  // rows up to j have the pivots of the columns before
    Index pivot = j;
    while (pivot < count && entry(pivot, j) == 0) ++pivot;
    if (pivot >= count) return true;
    for (Index l = j; l < order_; ++l) std::swap(entry(pivot, l), entry(j, l));
    const PrimeField::Element inverse = field.inverse(entry(j, j));
    for (Index k = j + 1; k < count; ++k) {
      const PrimeField::Element factor = field.multiply(entry(k, j), inverse);
      for (Index l = j; l < order_ && factor != 0; ++l) {
        entry(k, l) = field.subtract(entry(k, l), field.multiply(factor, entry(j, l)));
      }
    }
  }
  return false;
}

void FarkasSupport::write_proof(Eigen::Ref<Vector> u) const {
  u.setZero();
  const auto share = [&](Index j) {
    return scaled(u_[static_cast<std::size_t>(j)], column_exponent_[static_cast<std::size_t>(j)]);
  };
  Quad least = share(0);
  for (Index j = 1; j < order_; ++j) least = std::min(least, share(j));
  for (Index j = 0; j < order_; ++j) {
    const Quad ratio = share(j) / least;
    const double near = std::round(to_double(ratio));
    const Quad off = magnitude(ratio - static_cast<Quad>(near));
    const bool is_integer = near <= kLargestInteger && off <= kNearInteger * ratio;
    u(normal(j)) = is_integer ? near : to_double(ratio);
  }
}

}  // namespace lcpbench
