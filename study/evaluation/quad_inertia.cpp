#include "study/evaluation/quad_inertia.h"

#include <algorithm>
#include <utility>

namespace lcpbench {
namespace {

constexpr double kDependentLength = 0x1p-48;
/// A pivot above this part of its diagonal entry cannot be the rounding of 113 bits.
constexpr double kClearPivot = 0x1p-40;
constexpr double kSingularPivot = 0x1p-96;

Quad dot(const QuadMatrix& A, std::size_t column, const QuadMatrix& B, std::size_t other) {
  Quad sum = 0;
  for (std::size_t i = 0; i < A.rows; ++i) sum += A(i, column) * B(i, other);
  return sum;
}

void remove_component(const QuadMatrix& basis, std::size_t b, QuadMatrix& X, std::size_t column) {
  const Quad along = dot(basis, b, X, column);
  for (std::size_t i = 0; i < X.rows; ++i) X(i, column) -= along * basis(i, b);
}

void scale_to_unit_length(QuadMatrix& X) {
  for (std::size_t j = 0; j < X.cols; ++j) {
    const Quad length = sqrt(dot(X, j, X, j));
    for (std::size_t i = 0; i < X.rows; ++i) X(i, j) = length > 0 ? X(i, j) / length : 0;
  }
}

QuadMatrix leading_columns(const QuadMatrix& A, std::size_t count) {
  QuadMatrix leading(A.rows, count);
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < count; ++j) leading(i, j) = A(i, j);
  }
  return leading;
}

// Orthonormal basis of the span of X's columns. Their lengths are taken out first, so that the decision on the rank
// does not depend on them. The column chosen is orthogonalized once more: what the rounding of the earlier steps left
// along the basis would otherwise grow with the cancellation. [Giraud, Langou, Rozloznik 2005]
QuadMatrix orthonormal_range(QuadMatrix X) {
  scale_to_unit_length(X);
  QuadMatrix basis(X.rows, std::min(X.rows, X.cols));
  std::vector<bool> used(X.cols, false);
  for (std::size_t rank = 0; rank < basis.cols; ++rank) {
    std::size_t longest = 0;
    Quad square = 0;
    for (std::size_t j = 0; j < X.cols; ++j) {
      const Quad candidate = used[j] ? 0 : dot(X, j, X, j);
      if (!(candidate > square)) continue;
      square = candidate;
      longest = j;
    }
    if (!(sqrt(square) > kDependentLength)) return leading_columns(basis, rank);
    for (std::size_t b = 0; b < rank; ++b) remove_component(basis, b, X, longest);
    const Quad length = sqrt(dot(X, longest, X, longest));
    for (std::size_t i = 0; i < X.rows; ++i) basis(i, rank) = X(i, longest) / length;
    used[longest] = true;
    for (std::size_t j = 0; j < X.cols; ++j) {
      if (!used[j]) remove_component(basis, rank, X, j);
    }
  }
  return basis;
}

struct Factors {
  QuadMatrix X;
  QuadVector alpha;
  bool complete = false;  ///< what was left out is rounding, not a negative part
};

bool all_within(const QuadMatrix& A, Quad bound) {
  return std::all_of(A.entries.begin(), A.entries.end(), [bound](Quad entry) { return abs(entry) <= bound; });
}

// G = X diag(alpha) X' up to what lies below n 2^-52 max G_ii, by LDL' with diagonal pivoting.
Factors pivoted_factors(QuadMatrix G) {
  const std::size_t n = G.rows;
  Quad largest = 0;
  for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, G(i, i));
  const Quad cut = static_cast<double>(n) * 0x1p-52 * largest;
  std::vector<QuadVector> columns;
  Factors factors;
  for (std::size_t rank = 0; rank < n; ++rank) {
    std::size_t p = 0;
    for (std::size_t i = 1; i < n; ++i) {
      if (G(i, i) > G(p, p)) p = i;
    }
    const Quad pivot = G(p, p);
    if (!(pivot > cut)) break;
    QuadVector column(n);
    for (std::size_t i = 0; i < n; ++i) column[i] = G(i, p) / pivot;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) G(i, j) -= pivot * column[i] * column[j];
    }
    columns.push_back(std::move(column));
    factors.alpha.push_back(pivot);
  }
  factors.complete = all_within(G, static_cast<double>(n) * cut);
  factors.X = QuadMatrix(n, columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (std::size_t i = 0; i < n; ++i) factors.X(i, j) = columns[j][i];
  }
  return factors;
}

}  // namespace

QuadInertia::QuadInertia(const Inertia& inertia) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    add_inertia(dense->G);
  } else if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    for (const Matrix& block : bodies->blocks) add_inertia(block);
  } else if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    add_factors(QuadMatrix(factors->X), QuadVector(factors->alpha.begin(), factors->alpha.end()));
  } else {
    add_inverse(std::get<InverseInertia>(inertia).Ginv);
  }
}

void QuadInertia::add(Block block) {
  const QuadVector& entries = block.matrix.entries;
  const bool finite = std::all_of(entries.begin(), entries.end(), [](Quad entry) { return is_finite(entry); });
  well_defined_ = well_defined_ && finite;
  block.offset = dimension_;
  dimension_ += block.size();
  block_of_row_.resize(dimension_, blocks_.size());
  blocks_.push_back(std::move(block));
}

void QuadInertia::add_inertia(const Matrix& G) {
  Block block;
  block.matrix = QuadMatrix(G);
  if (!factor_regular(block)) {
    const Factors factors = pivoted_factors(block.matrix);
    well_defined_ = factors.complete && factor_in_range(block, factors.X, factors.alpha) && well_defined_;
  }
  add(std::move(block));
}

void QuadInertia::add_factors(const QuadMatrix& X, const QuadVector& alpha) {
  Block block;
  block.matrix = weighted_gram(X, alpha);
  block.formation_terms = X.cols + 2;
  if (X.cols < X.rows || !factor_regular(block)) {
    well_defined_ = factor_in_range(block, X, alpha) && well_defined_;
  }
  add(std::move(block));
}

void QuadInertia::add_inverse(const Matrix& Ginv) {
  Block block;
  block.matrix = QuadMatrix(Ginv);
  block.is_inverse = true;
  has_inertia_ = false;
  add(std::move(block));
}

/// Factors a block that is regular beyond doubt. Small pivots may be the rounding of a singular block whose coordinates
/// differ much in scale, so that they have to be proven positive.
bool QuadInertia::factor_regular(Block& block) {
  if (block.factor.factor(block.matrix, kClearPivot)) return true;
  return lcpbench::proven_positive_definite(block.matrix, block.formation_terms) &&
         block.factor.factor(block.matrix, kSingularPivot);
}

bool QuadInertia::factor_in_range(Block& block, const QuadMatrix& X, const QuadVector& alpha) {
  QuadMatrix range = orthonormal_range(X);
  QuadMatrix projected(range.cols, X.cols);
  for (std::size_t i = 0; i < range.cols; ++i) {
    for (std::size_t j = 0; j < X.cols; ++j) projected(i, j) = dot(range, i, X, j);
  }
  const bool factored = block.factor.factor(weighted_gram(projected, alpha), 0);
  block.range = std::move(range);
  return factored;
}

void QuadInertia::Block::solve(Quad* x) const {
  if (is_inverse) {
    const QuadVector y = multiply(matrix, x);
    std::copy(y.begin(), y.end(), x);
  } else if (range) {
    QuadVector coordinates = multiply_transposed(*range, x);
    factor.solve(coordinates.data());
    const QuadVector y = multiply(*range, coordinates.data());
    std::copy(y.begin(), y.end(), x);
  } else {
    factor.solve(x);
  }
}

bool QuadInertia::proven_positive_definite() const {
  return std::all_of(blocks_.begin(), blocks_.end(), [](const Block& block) {
    return lcpbench::proven_positive_definite(block.matrix, block.formation_terms);
  });
}

void QuadInertia::solve(QuadVector& x) const {
  for (const Block& block : blocks_) block.solve(x.data() + block.offset);
}

void QuadInertia::solve(QuadVector& x, std::vector<std::size_t>& pattern) const {
  std::vector<std::size_t> touched;
  for (const std::size_t row : pattern) touched.push_back(block_of_row_[row]);
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  pattern.clear();
  for (const std::size_t b : touched) {
    blocks_[b].solve(x.data() + blocks_[b].offset);
    for (std::size_t i = 0; i < blocks_[b].size(); ++i) pattern.push_back(blocks_[b].offset + i);
  }
}

QuadVector QuadInertia::apply(const QuadVector& x) const {
  QuadVector y;
  for (const Block& block : blocks_) {
    const QuadVector part = multiply(block.matrix, x.data() + block.offset);
    y.insert(y.end(), part.begin(), part.end());
  }
  return y;
}

QuadVector QuadInertia::scale(const QuadVector& x) const {
  QuadVector y(dimension_, 0);
  for (const Block& block : blocks_) {
    for (std::size_t i = 0; i < block.size(); ++i) {
      for (std::size_t j = 0; j < block.size(); ++j) {
        y[block.offset + i] += abs(block.matrix(i, j)) * x[block.offset + j];
      }
    }
  }
  return y;
}

QuadVector QuadInertia::outside_range(const QuadVector& x) const {
  QuadVector rest(dimension_, 0);
  for (const Block& block : blocks_) {
    if (!block.range) continue;
    const QuadVector coordinates = multiply_transposed(*block.range, x.data() + block.offset);
    const QuadVector inside = multiply(*block.range, coordinates.data());
    for (std::size_t i = 0; i < block.size(); ++i) rest[block.offset + i] = x[block.offset + i] - inside[i];
  }
  return rest;
}

}  // namespace lcpbench
