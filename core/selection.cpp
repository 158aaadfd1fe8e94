#include "core/selection.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/compliance.h"

namespace lcpbench {

std::vector<Index> block_begins(const BlockInertia& inertia, std::vector<Index> memory) {
  std::vector<Index> begins = std::move(memory);
  begins.assign(1, 0);
  for (const Matrix& block : inertia.blocks) begins.push_back(begins.back() + block.rows());
  return begins;
}

void blocks_on(const BlockInertia& inertia, const std::vector<Index>& begins, std::span<const Index> coordinates,
               BlockInertia& part) {
  std::size_t count = 0;
  for (auto first = coordinates.begin(); first != coordinates.end();) {
    const auto end = std::upper_bound(begins.begin(), begins.end(), *first);
    const auto last = std::lower_bound(first, coordinates.end(), *end);
    const Matrix& block = inertia.blocks[static_cast<std::size_t>(end - begins.begin()) - 1];
    if (count == part.blocks.size()) part.blocks.emplace_back();
    if (last - first == block.rows()) {
      part.blocks[count] = block;
    } else {
      const Eigen::Map<const Eigen::Array<Index, Eigen::Dynamic, 1>> own(&*first, last - first);
      const auto inside = own - *(end - 1);
      part.blocks[count] = block(inside, inside);
    }
    ++count;
    first = last;
  }
  part.blocks.resize(count);
}

Inertia inertia_on(const Inertia& inertia, const std::vector<Index>& coordinates) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return DenseInertia{dense->G(coordinates, coordinates)};
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    return InverseInertia{inverse->Ginv(coordinates, coordinates)};
  }
  if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    BlockInertia part;
    blocks_on(*bodies, block_begins(*bodies), coordinates, part);
    return part;
  }
  const auto& factors = std::get<FactoredInertia>(inertia);
  const Matrix X = factors.X(coordinates, Eigen::all);
  std::vector<Index> used;
  for (Index k = 0; k < X.cols(); ++k) {
    if (!X.col(k).isZero(0)) used.push_back(k);
  }
  return FactoredInertia{X(Eigen::all, used), factors.alpha(used)};
}

std::vector<Index> all_indices(Index count) {
  std::vector<Index> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), Index{0});
  return indices;
}

Jacobian part_of(const Jacobian& J, const std::vector<Index>& rows, const std::vector<Index>& columns) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return Matrix((*dense)(rows, columns));
  const auto& sparse = std::get<SparseMatrix>(J);
  std::vector<Index> place(static_cast<std::size_t>(sparse.rows()), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) place[static_cast<std::size_t>(rows[i])] = static_cast<Index>(i);
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (SparseMatrix::InnerIterator entry(sparse, columns[c]); entry; ++entry) {
      const Index row = place[static_cast<std::size_t>(entry.row())];
      if (row >= 0) entries.emplace_back(row, static_cast<Index>(c), entry.value());
    }
  }
  SparseMatrix part(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  part.setFromTriplets(entries.begin(), entries.end());
  return part;
}

std::vector<Index> directions_of(const ContactProblem& problem, const std::vector<Index>& contacts) {
  const ContactLayout layout = contact_layout(problem);
  std::vector<Index> directions;
  for (const Index contact : contacts) {
    const auto i = static_cast<std::size_t>(contact);
    for (Index t = layout.friction_begin[i]; t < layout.friction_begin[i + 1]; ++t) directions.push_back(t);
  }
  return directions;
}

ContactProblem select_contacts(const ContactProblem& problem, const std::vector<Index>& contacts) {
  ContactProblem part = problem;
  const std::vector<Index> rows = all_indices(problem.ngc());
  part.N = part_of(problem.N, rows, contacts);
  part.D = part_of(problem.D, rows, directions_of(problem, contacts));
  part.mu = problem.mu(contacts);
  if (problem.has_offset()) part.b = problem.b(contacts);
  select_softness(problem, contacts, part);
  part.edges.clear();
  for (const Index contact : contacts) part.edges.push_back(problem.edges[static_cast<std::size_t>(contact)]);
  return part;
}

ContactProblem select_rows(const ContactProblem& problem, const std::vector<Index>& kept) {
  ContactProblem part = problem;
  const BoundedRows& rows = problem.rows;
  part.rows = {};
  if (kept.empty()) return part;
  part.rows.R = part_of(rows.R, all_indices(problem.ngc()), kept);
  part.rows.bounds = rows.bounds.of_rows(kept);
  if (rows.b.size() > 0) part.rows.b = rows.b(kept);
  if (rows.compliance.size() > 0) part.rows.compliance = rows.compliance(kept);
  for (const Index row : kept) {
    part.rows.is_angle.push_back(rows.is_angle[static_cast<std::size_t>(row)]);
    if (!rows.names.empty()) part.rows.names.push_back(rows.names[static_cast<std::size_t>(row)]);
  }
  return part;
}

ContactProblem select_coordinates(const ContactProblem& problem, const std::vector<Index>& coordinates) {
  ContactProblem part = problem;
  part.v = problem.v(coordinates);
  part.N = part_of(problem.N, coordinates, all_indices(problem.nc()));
  part.D = part_of(problem.D, coordinates, all_indices(cols(problem.D)));
  if (problem.has_rows()) part.rows.R = part_of(problem.rows.R, coordinates, all_indices(problem.rows.size()));
  part.inertia = inertia_on(problem.inertia, coordinates);
  return part;
}

}  // namespace lcpbench
