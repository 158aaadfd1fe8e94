#include "native/contacts/islands.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "core/compliance.h"
#include "core/selection.h"

namespace lcpbench {
namespace {

/// The rows and columns of a square matrix at `indices` - offset. @pre ascending
Matrix principal_part(const Matrix& matrix, std::span<const Index> indices, Index offset) {
  const Index size = static_cast<Index>(indices.size());
  if (size > 0 && indices.back() - indices.front() == size - 1) {
    const Index first = indices.front() - offset;
    return matrix.block(first, first, size, size);
  }
  Matrix part(size, size);
  for (Index j = 0; j < size; ++j) {
    for (Index i = 0; i < size; ++i) {
      part(i, j) = matrix(indices[static_cast<std::size_t>(i)] - offset, indices[static_cast<std::size_t>(j)] - offset);
    }
  }
  return part;
}

/// The rows keep their order.
void restrict_sparse(const SparseMatrix& J, std::span<const Index> columns, Index rows, const std::vector<Index>& local,
                     SparseMatrix& part) {
  part.resize(rows, static_cast<Index>(columns.size()));
  Index most = 0;
  for (const Index column : columns) most += J.col(column).nonZeros();
  part.resizeNonZeros(most);
  Index entries = 0;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (SparseMatrix::InnerIterator entry(J, columns[j]); entry; ++entry) {
      const Index row = local[static_cast<std::size_t>(entry.row())];
      if (row < 0 || entry.value() == 0) continue;
      part.innerIndexPtr()[entries] = static_cast<SparseMatrix::StorageIndex>(row);
      part.valuePtr()[entries] = entry.value();
      ++entries;
    }
    part.outerIndexPtr()[j + 1] = static_cast<SparseMatrix::StorageIndex>(entries);
  }
  part.resizeNonZeros(entries);
}

/// part := J(rows, columns). In place, because moving a sparse matrix copies it.
/// @param local  the place of each row of J in `rows`, -1: it has none
void restrict_columns(const Jacobian& J, std::span<const Index> columns, std::span<const Index> rows,
                      const std::vector<Index>& local, Jacobian& part) {
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    part = Matrix((*dense)(rows, columns));
  } else {
    restrict_sparse(std::get<SparseMatrix>(J), columns, static_cast<Index>(rows.size()), local,
                    part.emplace<SparseMatrix>());
  }
}

}  // namespace

ProblemCutter::ProblemCutter(const Problem& whole)
    : problem_(whole),
      whole_(problem_.contact()),
      layout_(contact_layout(*whole_)),
      local_(static_cast<std::size_t>(whole_->ngc()), -1) {
  const auto* blocks = std::get_if<BlockInertia>(&whole_->inertia);
  if (blocks == nullptr) return;
  block_begin_.push_back(0);
  block_of_.reserve(local_.size());
  for (const Matrix& block : blocks->blocks) {
    block_of_.insert(block_of_.end(), static_cast<std::size_t>(block.rows()), block_begin_.size() - 1);
    block_begin_.push_back(block_begin_.back() + block.rows());
  }
}

ContactProblem ProblemCutter::cut(std::span<const Index> contacts, std::span<const Index> coordinates, const Vector& v,
                                  bool with_friction) {
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    local_[static_cast<std::size_t>(coordinates[i])] = static_cast<Index>(i);
  }
  ContactProblem part;
  part.v.resize(static_cast<Index>(coordinates.size()));
  for (std::size_t i = 0; i < coordinates.size(); ++i) part.v(static_cast<Index>(i)) = v(coordinates[i]);
  part.mu = Vector::Zero(static_cast<Index>(contacts.size()));
  if (std::any_of(contacts.begin(), contacts.end(), [this](Index c) { return whole_->offset(c) != 0; })) {
    part.b.resize(part.mu.size());
    for (std::size_t k = 0; k < contacts.size(); ++k) part.b(static_cast<Index>(k)) = whole_->offset(contacts[k]);
  }
  std::vector<Index> directions;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto c = static_cast<std::size_t>(contacts[k]);
    part.edges.push_back(with_friction ? whole_->edges[c] : 0);
    if (!with_friction) continue;
    part.mu(static_cast<Index>(k)) = whole_->mu(contacts[k]);
    for (Index t = layout_.friction_begin[c]; t < layout_.friction_begin[c + 1]; ++t) directions.push_back(t);
  }
  restrict_columns(whole_->N, contacts, coordinates, local_, part.N);
  restrict_columns(whole_->D, directions, coordinates, local_, part.D);
  part.inertia = cut_inertia(coordinates);
  if (whole_->is_soft()) select_softness(*whole_, {contacts.begin(), contacts.end()}, part);
  if (!with_friction) part.compliance_t = part.offset_t = Vector();
  for (const Index coordinate : coordinates) local_[static_cast<std::size_t>(coordinate)] = -1;
  return part;
}

Inertia ProblemCutter::cut_inertia(std::span<const Index> coordinates) const {
  const Inertia& inertia = whole_->inertia;
  if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) return cut_blocks(*blocks, coordinates);
  return inertia_on(inertia, {coordinates.begin(), coordinates.end()});
}

/// An island may have some coordinates of a block only, which the block itself does not couple with the others.
BlockInertia ProblemCutter::cut_blocks(const BlockInertia& inertia, std::span<const Index> coordinates) const {
  BlockInertia part;
  for (std::size_t first = 0; first < coordinates.size();) {
    const std::size_t block = block_of(coordinates[first]);
    std::size_t last = first;
    while (last < coordinates.size() && coordinates[last] < block_begin_[block + 1]) ++last;
    part.blocks.push_back(
        principal_part(inertia.blocks[block], coordinates.subspan(first, last - first), block_begin_[block]));
    first = last;
  }
  return part;
}

}  // namespace lcpbench
