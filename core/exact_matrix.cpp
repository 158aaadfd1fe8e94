#include "core/exact_matrix.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <utility>

#include "core/prime_field.h"

namespace lcpbench {
namespace {

using Element = PrimeField::Element;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// The magnitude is below 2^bits.
std::int64_t bits(const Dyadic& x) {
  if (x.is_zero()) return 0;
  return Dyadic::kLimbBits * (x.high() - 1) + static_cast<std::int64_t>(std::bit_width(x.limbs().back()));
}

/// Multiplies row i, or column j, of A by 2^(64 limbs).
void shift_row(ExactMatrix& A, Index i, std::int64_t limbs) {
  for (Index j = 0; j < A.cols; ++j) A(i, j) = A(i, j).shifted(limbs);
}
void shift_column(ExactMatrix& A, Index j, std::int64_t limbs) {
  for (Index i = 0; i < A.rows; ++i) A(i, j) = A(i, j).shifted(limbs);
}

template <class At>
std::int64_t least_exponent(Index count, const At& entry) {
  std::optional<std::int64_t> least;
  for (Index k = 0; k < count; ++k) {
    if (const Dyadic& x = entry(k); !x.is_zero()) least = least ? std::min(*least, x.low()) : x.low();
  }
  return least.value_or(0);
}

void scale_row_to_integers(ExactMatrix& A, Index i) {
  shift_row(A, i, -least_exponent(A.cols, [&](Index j) -> const Dyadic& { return A(i, j); }));
}

/// Rows and columns times powers of two, which change no rank: integers.
void scale_to_integers(ExactMatrix& A) {
  for (Index i = 0; i < A.rows; ++i) scale_row_to_integers(A, i);
  for (Index j = 0; j < A.cols; ++j) {
    shift_column(A, j, -least_exponent(A.rows, [&](Index i) -> const Dyadic& { return A(i, j); }));
  }
}

/// No minor of `order` rows of the integers A is 2^bits or more. [Hadamard 1893]
std::int64_t bits_of_minors(const ExactMatrix& A, Index order) {
  std::vector<std::int64_t> rows;
  for (Index i = 0; i < A.rows; ++i) {
    std::int64_t most = 0;
    for (Index j = 0; j < A.cols; ++j) most = std::max(most, bits(A(i, j)));
    rows.push_back(most + static_cast<std::int64_t>(std::bit_width(at(A.cols))));
  }
  std::sort(rows.begin(), rows.end(), std::greater<>());
  std::int64_t sum = 1;
  for (Index k = 0; k < std::min(order, A.rows); ++k) sum += rows[at(k)];
  return sum;
}

constexpr std::int64_t kBitsOfPrime = 61;

std::vector<Element> residues(const ExactMatrix& A, const PrimeField& field) {
  std::vector<Element> values;
  for (const Dyadic& entry : A.entries) values.push_back(field.of(entry));
  return values;
}

/// row[j] -= factor * of[j]
void subtract_multiple(const PrimeField& field, Element* row, Element factor, const Element* of, Index count) {
  for (Index j = 0; j < count; ++j) row[j] = field.subtract(row[j], field.multiply(factor, of[j]));
}

/// Gauss-Jordan elimination modulo the prime: A (rows x cols, by rows) becomes its reduced row echelon form. With
/// `only_below`, what stands above the pivots is not eliminated. @returns the columns with pivots: each that does not
/// depend on those before it @param determinant  of these columns, where they are as many as the rows
std::vector<Index> eliminate(const PrimeField& field, std::vector<Element>& A, Index rows, Index cols, bool only_below,
                             Element& determinant) {
  const auto row = [&](Index i) { return A.data() + i * cols; };
  std::vector<Index> columns;
  determinant = field.one();
  for (Index j = 0; j < cols; ++j) {
    const auto done = static_cast<Index>(columns.size());
    Index pivot = done;
    while (pivot < rows && row(pivot)[j] == 0) ++pivot;
    if (pivot == rows) continue;
    if (pivot != done) {
      std::swap_ranges(row(pivot), row(pivot) + cols, row(done));
      determinant = field.subtract(0, determinant);
    }
    determinant = field.multiply(determinant, row(done)[j]);
    const Element inverse = field.inverse(row(done)[j]);
    for (Index k = j; k < cols; ++k) row(done)[k] = field.multiply(row(done)[k], inverse);
    for (Index i = only_below ? done + 1 : 0; i < rows; ++i) {
      if (i != done && row(i)[j] != 0) subtract_multiple(field, row(i) + j, row(i)[j], row(done) + j, cols - j);
    }
    columns.push_back(j);
  }
  return columns;
}

/// A symmetric matrix times powers of two in rows and columns alike, so that it has integers: entry (i, j) of it is
/// 2^(64 (shift_i + shift_j + common)) times that of A.
struct SymmetricIntegers {
  ExactMatrix A;
  std::vector<std::int64_t> shift;
  std::int64_t common = 0;

  explicit SymmetricIntegers(ExactMatrix given) : A(std::move(given)), shift(at(A.rows), 0) {
    for (Index i = 0; i < A.rows; ++i) {
      const std::int64_t high = A(i, i).high();
      shift[at(i)] = -(high >= 0 ? high / 2 : -((1 - high) / 2));
      shift_row(A, i, shift[at(i)]);
      shift_column(A, i, shift[at(i)]);
    }
    common = -least_exponent(A.rows * A.cols, [this](Index k) -> const Dyadic& { return A.entries[at(k)]; });
    for (Dyadic& entry : A.entries) entry = entry.shifted(common);
  }
};

/// The leading minors of A (n x n, by rows) modulo the prime, up to the first that is zero: all pivots are diagonal
/// entries. If no minor is zero and `inverts`, A becomes its inverse, else it is scratch.
std::vector<Element> leading_minors(const PrimeField& field, std::vector<Element>& A, Index n, bool inverts) {
  const auto row = [&](Index i) { return A.data() + i * n; };
  std::vector<Element> minors;
  Element minor = field.one();
  for (Index k = 0; k < n && row(k)[k] != 0; ++k) {
    minor = field.multiply(minor, row(k)[k]);
    minors.push_back(minor);
    const Element inverse = field.inverse(row(k)[k]);
    row(k)[k] = field.one();
    const Index first = inverts ? 0 : k;  // row, and column, of what is still used
    for (Index j = first; j < n; ++j) row(k)[j] = field.multiply(row(k)[j], inverse);
    for (Index i = inverts ? 0 : k + 1; i < n; ++i) {
      if (i == k || row(i)[k] == 0) continue;
      const Element factor = std::exchange(row(i)[k], 0);
      subtract_multiple(field, row(i) + first, factor, row(k) + first, n - first);
    }
  }
  return minors;
}

/// Integers whose magnitudes are below 2^bits, from their values modulo primes of a larger product.
/// @param values_of  gives the values modulo a prime; none where the prime is of no use
/// @returns nullopt where the product of the primes of no use is more than 2^most_of_no_use
template <class ValuesOf>
std::optional<std::vector<Dyadic>> integers_of_residues(std::int64_t bits, std::int64_t most_of_no_use,
                                                        const ValuesOf& values_of) {
  std::vector<const PrimeField*> fields;
  std::vector<std::vector<std::uint64_t>> values;  // by integer, then by field
  std::int64_t of_no_use = 0;
  for (std::size_t index = 0; static_cast<std::int64_t>(fields.size()) * kBitsOfPrime < bits + 2; ++index) {
    const PrimeField& field = prime_field(index);
    const std::vector<Element> elements = values_of(field);
    if (elements.empty()) {
      if ((of_no_use += kBitsOfPrime) > most_of_no_use) return std::nullopt;
      continue;
    }
    fields.push_back(&field);
    values.resize(elements.size());
    for (std::size_t k = 0; k < elements.size(); ++k) values[k].push_back(field.value(elements[k]));
  }
  const Residues residues(fields);
  std::vector<Dyadic> integers;
  for (const auto& of_integer : values) integers.push_back(residues.integer(of_integer));
  return integers;
}

}  // namespace

ExactMatrix::ExactMatrix(const Matrix& doubles) : ExactMatrix(doubles.rows(), doubles.cols()) {
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < cols; ++j) (*this)(i, j) = Dyadic(doubles(i, j));
  }
}

ExactMatrix transposed(const ExactMatrix& A) {
  ExactMatrix T(A.cols, A.rows);
  for (Index i = 0; i < A.rows; ++i) {
    for (Index j = 0; j < A.cols; ++j) T(j, i) = A(i, j);
  }
  return T;
}

ExactMatrix product(const ExactMatrix& A, const ExactMatrix& B) {
  ExactMatrix C(A.rows, B.cols);
  for (Index i = 0; i < A.rows; ++i) {
    for (Index k = 0; k < A.cols; ++k) {
      if (A(i, k).is_zero()) continue;
      for (Index j = 0; j < B.cols; ++j) C(i, j) += A(i, k) * B(k, j);
    }
  }
  return C;
}

ExactMatrix columns_of(const ExactMatrix& A, const std::vector<Index>& columns) {
  ExactMatrix B(A.rows, static_cast<Index>(columns.size()));
  for (Index i = 0; i < B.rows; ++i) {
    for (Index j = 0; j < B.cols; ++j) B(i, j) = A(i, columns[at(j)]);
  }
  return B;
}

std::optional<std::vector<Index>> independent_columns(const ExactMatrix& A) {
  ExactMatrix integers = A;
  scale_to_integers(integers);
  std::vector<Index> most;
  std::int64_t tried = 0;
  for (std::size_t index = 0;; ++index, tried += kBitsOfPrime) {
    const auto order = static_cast<Index>(most.size()) + 1;
    if (order > std::min(A.rows, A.cols)) return most;
    const std::int64_t needed = bits_of_minors(integers, order);
    if (tried > needed) return most;
    if (needed > kMostExactBits) return std::nullopt;
    const PrimeField& field = prime_field(index);
    std::vector<Element> rest = residues(integers, field);
    Element determinant = 0;
    std::vector<Index> columns = eliminate(field, rest, A.rows, A.cols, true, determinant);
    if (columns.size() > most.size()) most = std::move(columns);
  }
}

std::optional<bool> is_positive_definite(const ExactMatrix& A) {
  if (A.rows == 0) return true;
  const SymmetricIntegers integers(A);
  const std::int64_t most = bits_of_minors(integers.A, A.rows);
  if (most > kMostExactBits) return std::nullopt;
  // Where a minor is zero modulo each of so many primes it is zero: a minor that all of them divide is larger.
  const auto minors = integers_of_residues(most, most * A.rows, [&](const PrimeField& field) {
    std::vector<Element> rest = residues(integers.A, field);
    std::vector<Element> values = leading_minors(field, rest, A.rows, false);
    return static_cast<Index>(values.size()) == A.rows ? values : std::vector<Element>();
  });
  return minors && std::all_of(minors->begin(), minors->end(), [](const Dyadic& minor) { return minor.sign() > 0; });
}

std::optional<ExactInverse> inverse_of_definite(ExactMatrix given) {
  const SymmetricIntegers integers(std::move(given));
  const Index n = integers.A.rows;
  const std::int64_t most = bits_of_minors(integers.A, n);
  if (most > kMostExactBits) return std::nullopt;
  const auto adjugate = integers_of_residues(most, most * n, [&](const PrimeField& field) {
    std::vector<Element> values;  // the rows up to the diagonal, then the determinant
    std::vector<Element> inverse = residues(integers.A, field);
    const std::vector<Element> minors = leading_minors(field, inverse, n, true);
    if (static_cast<Index>(minors.size()) < n) return values;
    const Element determinant = n > 0 ? minors.back() : field.one();
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j <= i; ++j) values.push_back(field.multiply(determinant, inverse[at(i * n + j)]));
    }
    values.push_back(determinant);
    return values;
  });
  if (!adjugate) return std::nullopt;
  ExactInverse result{ExactMatrix(n, n), adjugate->back()};
  auto next = adjugate->begin();
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j <= i; ++j) {
      const std::int64_t shift = integers.shift[at(i)] + integers.shift[at(j)] + integers.common;
      result.numerator(i, j) = result.numerator(j, i) = (next++)->shifted(shift);
    }
  }
  return result;
}

std::optional<ExactSolution> solve_exactly(const ExactMatrix& A, const std::vector<Dyadic>& b) {
  const Index n = A.rows;
  ExactMatrix all(n, n + 1);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) all(i, j) = A(i, j);
    all(i, n) = b[at(i)];
    scale_row_to_integers(all, i);
  }
  const std::int64_t most = bits_of_minors(all, n);
  if (most > kMostExactBits) return std::nullopt;
  auto values = integers_of_residues(most, most, [&](const PrimeField& field) {
    std::vector<Element> numerators;  // and then the determinant
    std::vector<Element> reduced = residues(all, field);
    Element determinant = 0;
    const std::vector<Index> columns = eliminate(field, reduced, n, n + 1, false, determinant);
    if (static_cast<Index>(columns.size()) < n || (n > 0 && columns.back() == n)) return numerators;  // A is singular
    for (Index i = 0; i < n; ++i) numerators.push_back(field.multiply(determinant, reduced[at(i * (n + 1) + n)]));
    numerators.push_back(determinant);
    return numerators;
  });
  if (!values) return ExactSolution{};
  if (values->back().sign() < 0) std::transform(values->begin(), values->end(), values->begin(), std::negate<>());
  ExactSolution solution{std::move(*values), {}};
  solution.denominator = std::move(solution.numerators.back());
  solution.numerators.pop_back();
  return solution;
}

}  // namespace lcpbench
