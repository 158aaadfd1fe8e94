#include "native/proximal_newton/newton_matrix.h"

#include <algorithm>
#include <map>
#include <utility>
#include <variant>

#include "native/velocity_ipm/assembly_tree.h"
#include "native/velocity_ipm/multifrontal.h"

namespace lcpbench {
namespace {

/// Fitted to times of made problems: the work for each unit of SparseFactorization::Cost (the elimination looks for
/// pivots), and for each ordered pair of coordinates that a contact moves.
constexpr double kWorkOfPivoting = 3, kWorkOfPair = 13;

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Square and compressed. Entries of the same place are added; zeros are kept.
SparseMatrix with_entries(Index size, const Triplets& entries) {
  SparseMatrix matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

void NewtonMatrix::load(const Inertia& inertia, const std::vector<ContactRows>& rows) {
  rows_ = &rows;
  Triplets entries;
  const auto add = [&entries](const Matrix& G, Index first) {
    for (Index j = 0; j < G.cols(); ++j) {
      for (Index i = 0; i < G.rows(); ++i) {
        entries.emplace_back(static_cast<int>(first + i), static_cast<int>(first + j), G(i, j));
      }
    }
  };
  if (std::holds_alternative<BlockInertia>(inertia)) {
    for_each_matrix(inertia, add);
  } else {
    add(dense_inertia(inertia), 0);
  }
  const Index size = dimension(inertia);
  G_ = with_entries(size, entries);
  std::map<std::vector<int>, std::size_t> known;
  places_of_.clear();
  for (const ContactRows& own : rows) {
    const auto [found, is_new] = known.try_emplace(own.coordinates, known.size());
    places_of_.push_back(found->second);
    if (!is_new) continue;
    for (const int j : own.coordinates) {
      for (const int i : own.coordinates) entries.emplace_back(i, j, 0.0);
    }
  }
  const std::vector<int> ordered = elimination_order(with_entries(size, entries).triangularView<Eigen::Lower>());
  position_.resize(ordered.size());
  int next = 0;
  for (const int row : ordered) position_[static_cast<std::size_t>(row)] = next++;
  const auto position = [this](Index i) { return position_[static_cast<std::size_t>(i)]; };
  Triplets below;
  for (const auto& entry : entries) {
    const int row = position(entry.row()), column = position(entry.col());
    if (row >= column) below.emplace_back(row, column, entry.value());
  }
  const SparseMatrix lower = with_entries(size, below);
  G_entries_.assign(lower.valuePtr(), lower.valuePtr() + lower.nonZeros());
  G_entries_.insert(G_entries_.end(), lower.valuePtr(), lower.valuePtr() + lower.nonZeros());
  entries_ = G_entries_;
  places_.assign(known.size(), {});
  for (const auto& [coordinates, index] : known) {
    for (const int j : coordinates) {
      for (const int i : coordinates) {
        const auto [column, row] = std::minmax({position(i), position(j)});
        const int* const first = lower.innerIndexPtr() + lower.outerIndexPtr()[column];
        const int* const last = lower.innerIndexPtr() + lower.outerIndexPtr()[column + 1];
        const auto place = static_cast<int>(std::lower_bound(first, last, row) - lower.innerIndexPtr());
        places_[index].push_back(row == position(i) ? place : place + static_cast<int>(lower.nonZeros()));
      }
    }
  }
  factors_ = multifrontal_lu();
  factors_->analyze(lower);
  ordered_.resize(size);
}

bool NewtonMatrix::factor(const std::vector<Eigen::Matrix3d>& slopes, double weight) {
  for (std::size_t k = 0; k < entries_.size(); ++k) entries_[k] = weight * G_entries_[k];
  work_ = kWorkOfPivoting * factors_->cost().factor;
  for (std::size_t c = 0; c < slopes.size(); ++c) {
    if (!(slopes[c](0, 0) > 0)) continue;
    const Eigen::Matrix3Xd& J = (*rows_)[c].J;
    const int* place = places_[places_of_[c]].data();
    for (Index b = 0; b < J.cols(); ++b) {
      const Eigen::Vector3d moved = slopes[c] * J.col(b);
      for (Index a = 0; a < J.cols(); ++a) entries_[static_cast<std::size_t>(*place++)] += J.col(a).dot(moved);
    }
    work_ += kWorkOfPair * static_cast<double>(J.cols() * J.cols());
  }
  return factors_->factor(entries_.data(), entries_.data() + entries_.size() / 2);
}

void NewtonMatrix::solve(Vector& x) {
  for (Index i = 0; i < x.size(); ++i) ordered_(position_[static_cast<std::size_t>(i)]) = x(i);
  factors_->solve(ordered_);
  for (Index i = 0; i < x.size(); ++i) x(i) = ordered_(position_[static_cast<std::size_t>(i)]);
}

}  // namespace lcpbench
