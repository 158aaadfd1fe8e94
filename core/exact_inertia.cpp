#include "core/exact_inertia.h"

#include <algorithm>
#include <utility>

namespace lcpbench {
namespace {

using Block = ExactResponse::Block;

std::optional<Block> inverse_block(const ExactMatrix& G) {
  std::optional<ExactInverse> inverse = inverse_of_definite(G);
  if (!inverse) return std::nullopt;
  return Block{.numerator = std::move(inverse->numerator), .denominator = std::move(inverse->denominator)};
}

/// B (B'G B)^-1 B' for columns B that are a basis of the range of G.
std::optional<Block> pseudo_inverse_block(const ExactMatrix& G, const ExactMatrix& B) {
  const ExactMatrix of_rows = transposed(B);
  const std::optional<ExactInverse> inverse = inverse_of_definite(product(of_rows, product(G, B)));
  if (!inverse) return std::nullopt;
  Block block{.numerator = product(product(B, inverse->numerator), of_rows), .denominator = inverse->denominator};
  block.range.emplace(B.rows, B.cols);
  for (Index i = 0; i < B.rows; ++i) {
    for (Index j = 0; j < B.cols; ++j) (*block.range)(i, j) = to_double(quotient(B(i, j), Dyadic(1.0)));
  }
  return block;
}

std::optional<Block> block_of_inertia(const Matrix& doubles, bool& indefinite) {
  if (doubles.rows() > kMostExactCoordinates || !doubles.allFinite()) return std::nullopt;
  const ExactMatrix G(Matrix(doubles.selfadjointView<Eigen::Lower>()));
  const auto independent = independent_columns(G);
  if (!independent) return std::nullopt;
  // Of a symmetric matrix the rows of independent columns are independent, too: the rest depends on this part.
  const auto rank = static_cast<Index>(independent->size());
  ExactMatrix part(rank, rank);
  for (Index i = 0; i < rank; ++i) {
    for (Index j = 0; j < rank; ++j)
      part(i, j) = G((*independent)[static_cast<std::size_t>(i)], (*independent)[static_cast<std::size_t>(j)]);
  }
  const std::optional<bool> definite = is_positive_definite(part);
  indefinite = indefinite || !definite.value_or(true);
  if (!definite.value_or(false)) return std::nullopt;
  return rank == G.rows ? inverse_block(G) : pseudo_inverse_block(G, columns_of(G, *independent));
}

/// G = X diag(alpha) X' has the range of the columns of X with alpha > 0.
std::optional<Block> block_of_factors(const FactoredInertia& inertia) {
  if (inertia.X.rows() > kMostExactCoordinates || !inertia.X.allFinite() || !inertia.alpha.allFinite() ||
      (inertia.alpha.array() < 0).any()) {
    return std::nullopt;
  }
  std::vector<Index> weighted;
  for (Index k = 0; k < inertia.alpha.size(); ++k) {
    if (inertia.alpha(k) > 0) weighted.push_back(k);
  }
  const ExactMatrix X = columns_of(ExactMatrix(inertia.X), weighted);
  ExactMatrix weighted_rows = transposed(X);
  for (Index k = 0; k < X.cols; ++k) {
    const Dyadic alpha(inertia.alpha(weighted[static_cast<std::size_t>(k)]));
    for (Index i = 0; i < X.rows; ++i) weighted_rows(k, i) = weighted_rows(k, i) * alpha;
  }
  const auto independent = independent_columns(X);
  if (!independent) return std::nullopt;
  const ExactMatrix G = product(X, weighted_rows);
  if (static_cast<Index>(independent->size()) == X.rows) return inverse_block(G);
  return pseudo_inverse_block(G, columns_of(X, *independent));
}

std::optional<Block> block_of_inverse(const Matrix& Ginv) {
  if (Ginv.rows() > kMostExactCoordinates || !Ginv.allFinite()) return std::nullopt;
  return Block{.numerator = ExactMatrix(Ginv)};
}

}  // namespace

void ExactResponse::Block::multiply(Quad* x) const {
  std::vector<Dyadic> exact;
  for (Index i = 0; i < size(); ++i) exact.emplace_back(x[i]);
  for (Index i = 0; i < size(); ++i) {
    Dyadic sum;
    for (Index j = 0; j < size(); ++j) sum += numerator(i, j) * exact[static_cast<std::size_t>(j)];
    x[i] = quotient(sum, denominator);
  }
}

bool ExactResponse::add(std::optional<Block> block) {
  if (!block) return false;
  block->first = static_cast<Index>(block_of_.size());
  block_of_.resize(block_of_.size() + static_cast<std::size_t>(block->size()), blocks_.size());
  blocks_.push_back(std::move(*block));
  return true;
}

std::optional<ExactResponse> ExactResponse::of(const Inertia& inertia, bool* indefinite) {
  ExactResponse response;
  bool known = true;
  bool is_indefinite = false;
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    known = response.add(block_of_inertia(dense->G, is_indefinite));
  } else if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    for (const Matrix& block : bodies->blocks) known = known && response.add(block_of_inertia(block, is_indefinite));
  } else if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    known = response.add(block_of_factors(*factors));
  } else {
    known = response.add(block_of_inverse(std::get<InverseInertia>(inertia).Ginv));
  }
  if (indefinite != nullptr) *indefinite = is_indefinite;
  if (!known) return std::nullopt;
  return response;
}

}  // namespace lcpbench
