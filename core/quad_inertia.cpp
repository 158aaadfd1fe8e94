#include "core/quad_inertia.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lcpbench {
namespace {

/// Proven of the eigenvalues of a matrix scaled to unit diagonal.
constexpr double kLeastEigenvalue = 0x1p-64;
/// Of the length of a column outside the range so far: what rounding may leave of a dependent one, and what at least is
/// outside of an independent one. Of a row, what at least is outside the span of those before it.
constexpr double kLeft = 0x1p-104;
constexpr double kOutside = 0x1p-90;
constexpr double kLeastLength = 0x1p-64;

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

Quad length_of(const Quad* x, std::size_t size) {
  Quad square = 0;
  for (std::size_t i = 0; i < size; ++i) square += x[i] * x[i];
  return sqrt(square);
}

Quad sum_of_magnitudes(const QuadVector& x) {
  Quad sum = 0;
  for (const Quad value : x) sum += abs(value);
  return sum;
}

QuadMatrix leading_columns(const QuadMatrix& A, std::size_t count) {
  QuadMatrix leading(A.rows, count);
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < count; ++j) leading(i, j) = A(i, j);
  }
  return leading;
}

/// A few roundings for each of `terms` terms of a sum.
Quad rounding_of(std::size_t terms) { return 4 * static_cast<double>(terms + 2) * kQuadUnitRoundoff; }

/// See orthonormal_range(). R has the chosen columns by the basis, in the order of both, and is upper triangular.
Quad tilt_of(const QuadMatrix& unit, const std::vector<std::size_t>& chosen, const QuadMatrix& basis) {
  const std::size_t n = chosen.size();
  Quad squares = 0;
  for (std::size_t j = 0; j < n; ++j) {
    QuadVector column(n, 0);  // of R^-1
    column[j] = 1;
    for (std::size_t i = j + 1; i-- > 0;) {
      for (std::size_t k = i + 1; k <= j; ++k) column[i] -= dot(basis, i, unit, chosen[k]) * column[k];
      column[i] /= dot(basis, i, unit, chosen[i]);
      squares += column[i] * column[i];
    }
  }
  return rounding_of(unit.rows + n) * sqrt(Quad{static_cast<double>(n)} * squares);
}

// Orthonormal basis of the span of X's columns, each of which adds at least kOutside of its length. @param left  of a
// length, what is outside at most @param tilt  set to a bound on the sine of the angle by which rounding turns the span
// of the columns chosen: their norm is at most the root of their number, the rounding of each a few units, and
// R^-1 = (B'X)^-1 carries it to the basis B. [Wedin 1972] The column chosen is orthogonalized once more:
// what the rounding of the earlier steps left along the basis would otherwise grow with the cancellation. [Giraud,
// Langou, Rozloznik 2005]
QuadMatrix orthonormal_range(QuadMatrix X, Quad& left, Quad* tilt = nullptr) {
  left = 0;
  scale_to_unit_length(X);
  const QuadMatrix unit = tilt != nullptr ? X : QuadMatrix();
  std::vector<std::size_t> chosen;
  const auto finish = [&](QuadMatrix basis) {
    if (tilt != nullptr) *tilt = tilt_of(unit, chosen, basis);
    return basis;
  };
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
    if (!(square > kOutside * kOutside)) {
      left = sqrt(square);
      return finish(leading_columns(basis, rank));
    }
    for (std::size_t b = 0; b < rank; ++b) remove_component(basis, b, X, longest);
    const Quad length = sqrt(dot(X, longest, X, longest));
    for (std::size_t i = 0; i < X.rows; ++i) basis(i, rank) = X(i, longest) / length;
    used[longest] = true;
    chosen.push_back(longest);
    for (std::size_t j = 0; j < X.cols; ++j) {
      if (!used[j]) remove_component(basis, rank, X, j);
    }
  }
  return finish(std::move(basis));
}

// The same, but `left` is 1 where the rank is another one with all rows scaled to unit length: a column that differs
// from others in a light coordinate alone seems to depend on them.
QuadMatrix visible_range(const QuadMatrix& X, Quad& left, Quad& tilt) {
  QuadMatrix scaled = X;
  for (std::size_t i = 0; i < X.rows; ++i) {
    Quad square = 0;
    for (std::size_t j = 0; j < X.cols; ++j) square += X(i, j) * X(i, j);
    for (std::size_t j = 0; j < X.cols && square > 0; ++j) scaled(i, j) /= sqrt(square);
  }
  const std::size_t rank = orthonormal_range(std::move(scaled), left).cols;
  const bool is_visible = left <= kLeft;
  QuadMatrix range = orthonormal_range(X, left, &tilt);
  if (!is_visible || range.cols != rank) left = 1;
  return range;
}

bool all_within(const QuadMatrix& A, Quad bound) {
  return std::all_of(A.entries.begin(), A.entries.end(), [bound](Quad entry) { return abs(entry) <= bound; });
}

/// The columns of G = L D L' up to what lies below n 2^-52 max G_ii, by diagonal pivoting. None where what is left out
/// is no rounding.
std::optional<QuadMatrix> pivoted_columns(QuadMatrix G) {
  const std::size_t n = G.rows;
  Quad largest = 0;
  for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, G(i, i));
  const Quad cut = static_cast<double>(n) * 0x1p-52 * largest;
  std::vector<QuadVector> columns;
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
  }
  if (!all_within(G, static_cast<double>(n) * cut)) return std::nullopt;
  QuadMatrix X(n, columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (std::size_t i = 0; i < n; ++i) X(i, j) = columns[j][i];
  }
  return X;
}

QuadMatrix identity(std::size_t size) {
  QuadMatrix unit(size, size);
  for (std::size_t i = 0; i < size; ++i) unit(i, i) = 1;
  return unit;
}

/// B'G B
QuadMatrix projected(const QuadMatrix& G, const QuadMatrix& B) {
  QuadMatrix projection(B.cols, B.cols);
  for (std::size_t j = 0; j < B.cols; ++j) {
    QuadVector column(B.rows);
    for (std::size_t i = 0; i < B.rows; ++i) column[i] = B(i, j);
    const QuadVector moved = multiply_transposed(B, multiply(G, column.data()).data());
    for (std::size_t i = 0; i <= j; ++i) projection(i, j) = projection(j, i) = moved[i];
  }
  return projection;
}

QuadMatrix magnitudes(QuadMatrix A) {
  for (Quad& entry : A.entries) entry = abs(entry);
  return A;
}

/// The largest entry of |B|'|G||B|: in its terms the entries of B'G B are rounded.
Quad largest_of_magnitudes(const QuadMatrix& G, const QuadMatrix& B) {
  const QuadVector entries = projected(magnitudes(G), magnitudes(B)).entries;
  return entries.empty() ? Quad{0} : *std::max_element(entries.begin(), entries.end());
}

/// The longest row of |B|'|W|: in its terms the entries of B'W are rounded.
Quad longest_of_magnitudes(const QuadMatrix& W, const QuadMatrix& B) {
  Quad longest = 0;
  for (std::size_t j = 0; j < B.cols; ++j) {
    QuadVector column(B.rows);
    for (std::size_t i = 0; i < B.rows; ++i) column[i] = abs(B(i, j));
    const QuadVector row = multiply_transposed(magnitudes(W), column.data());
    longest = std::max(longest, length_of(row.data(), row.size()));
  }
  return longest;
}

/// Whether all eigenvalues of B'G B stand out of its rounding, which is that of its largest entries.
bool has_gap(const QuadMatrix& projection) {
  Quad least = std::numeric_limits<double>::infinity(), largest = 0;
  for (std::size_t i = 0; i < projection.rows; ++i) {
    least = std::min(least, projection(i, i));
    largest = std::max(largest, projection(i, i));
  }
  return least >= 0x1p-40 * largest && proven_positive_definite(projection, 2 * projection.rows, kLeastEigenvalue);
}

/// X'X
QuadMatrix gram_of_columns(const QuadMatrix& X) {
  QuadMatrix gram(X.cols, X.cols);
  for (std::size_t i = 0; i < X.cols; ++i) {
    for (std::size_t j = 0; j <= i; ++j) gram(i, j) = gram(j, i) = dot(X, i, X, j);
  }
  return gram;
}

}  // namespace

QuadInertia::QuadInertia(const Inertia& inertia) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    add_inertia(dense->G);
  } else if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    for (const Matrix& block : bodies->blocks) add_inertia(block);
  } else if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    add_factors(*factors);
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
  block.matrix = QuadMatrix(Matrix(G.selfadjointView<Eigen::Lower>()));
  if (!factor_regular(block, 0)) find_range(block);
  add(std::move(block));
}

void QuadInertia::add_factors(const FactoredInertia& factors) {
  const QuadMatrix X(factors.X);
  const QuadVector alpha(factors.alpha.begin(), factors.alpha.end());
  Block block;
  block.matrix = weighted_gram(X, alpha);
  well_defined_ = well_defined_ && (factors.alpha.array() >= 0).all();
  const bool known = X.cols < X.rows ? factor_independent(block, X, alpha) : factor_regular(block, X.cols + 2);
  if (!known && well_defined_) {
    QuadMatrix weighted = X;
    for (std::size_t k = 0; k < X.cols; ++k) {
      const Quad root = sqrt(alpha[k]);
      for (std::size_t i = 0; i < X.rows; ++i) weighted(i, k) *= root;
    }
    find_range(block, weighted);
  }
  add(std::move(block));
}

/// For G = W W': B'G B is factored without forming it.
void QuadInertia::find_range(Block& block, const QuadMatrix& W) {
  Quad left = 0;
  block.range = visible_range(W, left, block.tilt);
  QuadMatrix inside = W;
  if (block.range->cols == block.size()) {
    block.range.reset();
    block.is_by_rows = true;
    block.tilt = 0;
    block.spread = longest_of_magnitudes(W, identity(block.size()));
  } else {
    block.spread = longest_of_magnitudes(W, *block.range);
    inside = QuadMatrix(block.range->cols, W.cols);
    for (std::size_t j = 0; j < W.cols; ++j) {
      for (std::size_t i = 0; i < inside.rows; ++i) inside(i, j) = dot(*block.range, i, W, j);
    }
  }
  if (left > kLeft || !block.factor.factor_product(std::move(inside), kLeastLength)) unresolved_ = true;
}

/// For a given G.
void QuadInertia::find_range(Block& block) {
  Quad left = 0;
  block.range = visible_range(block.matrix, left, block.tilt);
  const QuadMatrix projection = projected(block.matrix, *block.range);
  block.formed = largest_of_magnitudes(block.matrix, *block.range);
  if (!block.factor.factor(projection)) {
    cut(block);
  } else if (left > kLeft || projection.rows == block.size() || !has_gap(projection)) {
    unresolved_ = true;
  }
}

/// G* of a block that is indefinite: with the range of the columns that stand out of its rounding.
void QuadInertia::cut(Block& block) {
  const std::optional<QuadMatrix> columns = pivoted_columns(block.matrix);
  is_cut_ = true;
  well_defined_ = well_defined_ && columns;
  if (!well_defined_) return;
  Quad left = 0;
  block.range = orthonormal_range(*columns, left);
  well_defined_ = block.factor.factor(projected(block.matrix, *block.range));
}

void QuadInertia::add_inverse(const Matrix& Ginv) {
  Block block;
  block.matrix = QuadMatrix(Ginv);
  block.is_inverse = true;
  has_inertia_ = false;
  add(std::move(block));
}

/// Factors a block that is regular beyond doubt.
bool QuadInertia::factor_regular(Block& block, std::size_t formation_terms) {
  return lcpbench::proven_positive_definite(block.matrix, formation_terms, kLeastEigenvalue) &&
         block.factor.factor(block.matrix);
}

/// Takes factors that are independent beyond doubt, if every alpha is positive. @returns whether they are
bool QuadInertia::factor_independent(Block& block, const QuadMatrix& X, const QuadVector& alpha) {
  QuadMatrix columns = X;
  scale_to_unit_length(columns);
  const QuadMatrix gram = gram_of_columns(columns);
  if (!lcpbench::proven_positive_definite(gram, X.rows + 6, kLeastEigenvalue) || !block.factor.factor(gram))
    return false;
  for (std::size_t k = 0; k < X.cols; ++k) {
    if (!(alpha[k] > 0)) return false;
    block.weights.push_back(alpha[k] * dot(X, k, X, k));
  }
  Quad left = 0;
  block.range = orthonormal_range(columns, left);
  block.columns = std::move(columns);
  return true;
}

void QuadInertia::Block::solve(Quad* x) const {
  if (is_inverse) {
    const QuadVector y = multiply(matrix, x);
    std::copy(y.begin(), y.end(), x);
  } else if (columns || range) {
    const QuadMatrix& basis = columns ? *columns : *range;
    QuadVector c = multiply_transposed(basis, x);
    factor.solve(c.data());
    if (columns) {
      for (std::size_t k = 0; k < c.size(); ++k) c[k] /= weights[k];
      factor.solve(c.data());
    }
    const QuadVector y = multiply(basis, c.data());
    std::copy(y.begin(), y.end(), x);
  } else {
    factor.solve(x);
  }
}

QuadVector QuadInertia::Block::solve_error(const Quad* x) const {
  if (columns) return error_by_columns(x);
  if (range) return error_by_range(*range, x);
  return is_by_rows ? error_by_range(identity(size()), x) : QuadVector(size(), 0);
}

/// Of y = X K^-1 W^-1 K^-1 X'x with K = X'X, step by step: each product is rounded, and K is off by the rounding of its
/// formation and factorization.
QuadVector QuadInertia::Block::error_by_columns(const Quad* x) const {
  const QuadMatrix& X = *columns;
  const Quad unit = rounding_of(X.rows + X.cols);
  QuadMatrix inverse(X.cols, X.cols);  // of K, by rows
  for (std::size_t k = 0; k < X.cols; ++k) {
    inverse(k, k) = 1;
    factor.solve(&inverse(k, 0));
  }
  QuadVector c = multiply_transposed(X, x), error(c.size(), 0);
  factor.solve(c.data());
  const Quad first = unit * (length_of(x, X.rows) + sum_of_magnitudes(c));
  for (std::size_t k = 0; k < c.size(); ++k) {
    for (std::size_t j = 0; j < c.size(); ++j) error[k] += abs(inverse(k, j)) * first;
    error[k] = (error[k] + unit * abs(c[k])) / weights[k];
    c[k] /= weights[k];
  }
  factor.solve(c.data());
  for (Quad& value : error) value += unit * sum_of_magnitudes(c);
  QuadVector bound(X.rows, 0);
  for (std::size_t i = 0; i < X.rows; ++i) {
    for (std::size_t k = 0; k < X.cols; ++k) {
      Quad reach = 0;  // of X K^-1
      for (std::size_t j = 0; j < X.cols; ++j) reach += X(i, j) * inverse(j, k);
      bound[i] += abs(reach) * error[k] + unit * abs(X(i, k)) * abs(c[k]);
    }
  }
  return bound;
}

/// Of y = B S^-1 B'x with S = C C' = R R': B may be turned by `tilt`, C and each product are rounded. h = R'S^-1 B'x.
/// @param B  `range`, or the identity
QuadVector QuadInertia::Block::error_by_range(const QuadMatrix& B, const Quad* x) const {
  const std::size_t rank = B.cols;
  const Quad unit = rounding_of(B.rows + rank);
  const QuadMatrix root = factor.root(), inverse = factor.inverse_root();
  QuadVector t = multiply_transposed(B, x);
  factor.solve(t.data());
  const QuadVector h = multiply_transposed(root, t.data());
  Quad seen = (unit + tilt) * length_of(x, B.rows);  // of B'x, and of S t
  seen += unit * (formed * sum_of_magnitudes(t) + spread * length_of(h.data(), rank));
  QuadVector error(rank, unit * spread * sum_of_magnitudes(t)), bound(B.rows, 0);
  for (std::size_t j = 0; j < rank; ++j) {
    Quad off = seen;
    for (std::size_t k = 0; k <= j; ++k) off += unit * abs(root(j, k) * h[k]);
    for (std::size_t k = j; k < rank; ++k) error[k] += abs(inverse(k, j)) * off;
    for (std::size_t k = 0; k <= j; ++k) error[k] += unit * abs(root(j, k) * t[j]);
  }
  for (std::size_t i = 0; i < B.rows; ++i) {
    bound[i] = (unit + tilt) * sum_of_magnitudes(t);
    for (std::size_t k = 0; k < rank; ++k) {
      Quad reach = 0;  // of B R'^-1
      for (std::size_t j = 0; j <= k; ++j) reach += B(i, j) * inverse(k, j);
      bound[i] += abs(reach) * error[k];
    }
  }
  return bound;
}

bool QuadInertia::has_reduced_rank() const {
  return std::any_of(blocks_.begin(), blocks_.end(), [](const Block& block) { return block.range || block.is_by_rows; });
}

QuadVector QuadInertia::solve_error(const QuadVector& x) const {
  QuadVector bound;
  for (const Block& block : blocks_) {
    const QuadVector part = block.solve_error(x.data() + block.offset);
    bound.insert(bound.end(), part.begin(), part.end());
  }
  return bound;
}

bool QuadInertia::proven_positive_definite() const {
  return well_defined() && std::all_of(blocks_.begin(), blocks_.end(), [](const Block& block) {
           if (block.is_inverse) return lcpbench::proven_positive_definite(block.matrix, 0);
           return !block.range;
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
