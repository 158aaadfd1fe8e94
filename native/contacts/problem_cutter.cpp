#include "native/contacts/problem_cutter.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "core/compliance.h"
#include "core/selection.h"

namespace lcpbench {
namespace {

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

/// The alternative T of a variant, with its memory where it holds one.
template <class T, class Variant>
T& as(Variant& variant) {
  T* const held = std::get_if<T>(&variant);
  return held != nullptr ? *held : variant.template emplace<T>();
}

/// part := J(rows, columns).
/// @param local  the place of each row of J in `rows`, -1: it has none
void restrict_columns(const Jacobian& J, std::span<const Index> columns, std::span<const Index> rows,
                      const std::vector<Index>& local, Jacobian& part) {
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    as<Matrix>(part) = (*dense)(rows, columns);
  } else {
    restrict_sparse(std::get<SparseMatrix>(J), columns, static_cast<Index>(rows.size()), local, as<SparseMatrix>(part));
  }
}

}  // namespace

void ProblemCutter::load(const Problem& whole) {
  problem_ = whole;
  whole_ = problem_.contact();
  layout_ = contact_layout(*whole_, std::move(layout_));
  local_.assign(static_cast<std::size_t>(whole_->ngc()), -1);
  const auto* bodies = std::get_if<BlockInertia>(&whole_->inertia);
  if (bodies != nullptr) block_begins_ = block_begins(*bodies, std::move(block_begins_));
}

void ProblemCutter::cut(std::span<const Index> contacts, std::span<const Index> coordinates, const Vector& v,
                        bool with_friction, ContactProblem& part) {
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    local_[static_cast<std::size_t>(coordinates[i])] = static_cast<Index>(i);
  }
  part.v = v(coordinates);
  part.mu = whole_->mu(contacts);
  if (!with_friction) part.mu.setZero();
  part.b.resize(0);
  if (whole_->has_offset()) part.b = whole_->b(contacts);
  if (part.b.isZero(0)) part.b.resize(0);
  part.edges.clear();
  directions_.clear();
  for (const Index contact : contacts) {
    const auto c = static_cast<std::size_t>(contact);
    part.edges.push_back(with_friction ? whole_->edges[c] : 0);
    if (!with_friction) continue;
    for (Index t = layout_.friction_begin[c]; t < layout_.friction_begin[c + 1]; ++t) directions_.push_back(t);
  }
  restrict_columns(whole_->N, contacts, coordinates, local_, part.N);
  restrict_columns(whole_->D, directions_, coordinates, local_, part.D);
  if (const auto* bodies = std::get_if<BlockInertia>(&whole_->inertia)) {
    blocks_on(*bodies, block_begins_, coordinates, as<BlockInertia>(part.inertia));
  } else {
    part.inertia = inertia_on(whole_->inertia, {coordinates.begin(), coordinates.end()});
  }
  part.compliance_n = part.compliance_t = part.offset_t = Vector();
  if (whole_->is_soft()) select_softness(*whole_, {contacts.begin(), contacts.end()}, part);
  if (!with_friction) part.compliance_t = part.offset_t = Vector();
  for (const Index coordinate : coordinates) local_[static_cast<std::size_t>(coordinate)] = -1;
}

}  // namespace lcpbench
