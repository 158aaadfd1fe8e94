// The edges of the cones and the range of the inertia, for ContactSolvability.
#include <algorithm>
#include <cmath>
#include <utility>

#include "native/contacts/contact_edges.h"
#include "native/answer_test/contact_solvability.h"
#include "native/answer_test/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Entries of a scaled matrix above this are more than rounding.
constexpr Quad kLeastPivot = 0x1p-92;
/// Of a sum in 113 bits, relative to its terms.
constexpr Quad kRoundingOfSum = 0x1p-100;
/// Of a path in 113 bits, relative to the speed that no impulse reaches. One ulp of the data is 2^-52.
constexpr Quad kLargestMiss = 0x1p-80;

}  // namespace

/// A basis of the range of X by elimination of columns with complete pivoting: ones in the rows of the pivots.
void ContactSolvability::find_range() {
  if (has_range_) return;
  has_range_ = true;
  const Index ngc = X_->rows();
  const Index count = X_->cols();
  range_.resize(static_cast<std::size_t>(ngc * count));
  unit_.assign(static_cast<std::size_t>(ngc), 0);
  rank_ = count;
  const auto at = [&](Index i, Index k) -> Quad& { return range_[static_cast<std::size_t>(i * count + k)]; };
  for (Index k = 0; k < count; ++k) {
    const double largest = ngc > 0 ? X_->col(k).cwiseAbs().maxCoeff() : 0.0;
    const int exponent = largest > 0 ? -exponent_of(largest) : 0;
    for (Index i = 0; i < ngc; ++i) at(i, k) = scaled(static_cast<Quad>((*X_)(i, k)), exponent);
  }
  for (Index i = 0; i < ngc; ++i) {
    Quad largest = 0;
    for (Index k = 0; k < count; ++k) largest = std::max(largest, magnitude(at(i, k)));
    if (!(largest > 0)) continue;
    unit_[static_cast<std::size_t>(i)] = exponent_of(to_double(largest));
    for (Index k = 0; k < count; ++k) at(i, k) = scaled(at(i, k), -unit_[static_cast<std::size_t>(i)]);
  }
  least_range_pivot_ = 1;
  pivot_rows_.clear();
  rank_ = 0;
  for (; rank_ < std::min(ngc, count); ++rank_) {
    Index row = 0;
    Index column = rank_;
    for (Index i = 0; i < ngc; ++i) {
      for (Index k = rank_; k < count; ++k) {
        if (magnitude(at(i, k)) > magnitude(at(row, column))) row = i, column = k;
      }
    }
    const Quad pivot = at(row, column);
    if (!(magnitude(pivot) > kLeastPivot)) break;
    least_range_pivot_ = std::min(least_range_pivot_, magnitude(pivot));
    pivot_rows_.push_back(row);
    for (Index i = 0; i < ngc; ++i) std::swap(at(i, rank_), at(i, column));
    for (Index i = 0; i < ngc; ++i) at(i, rank_) /= pivot;
    for (Index k = 0; k < count; ++k) {
      const Quad factor = at(row, k);
      if (k == rank_ || factor == 0) continue;
      for (Index i = 0; i < ngc; ++i) at(i, k) -= factor * at(i, rank_);
      at(row, k) = 0;
    }
  }
  for (Index i = 0; i < ngc; ++i) {
    for (Index k = 0; k < rank_; ++k) {
      range_[static_cast<std::size_t>(i * rank_ + k)] = scaled(at(i, k), unit_[static_cast<std::size_t>(i)]);
    }
  }
}

void ContactSolvability::find_unreached_velocity() {
  const Index ngc = X_->rows();
  unreached_v_.assign(v_, v_ + ngc);
  for (Index k = 0; k < rank_; ++k) {
    const Index row = pivot_rows_[static_cast<std::size_t>(k)];
    const Quad share = static_cast<Quad>(v_[row]) / reach(row, k, Quad());
    for (Index i = 0; i < ngc && share != 0; ++i)
      unreached_v_[static_cast<std::size_t>(i)] -= share * reach(i, k, Quad());
  }
  for (const Index row : pivot_rows_) unreached_v_[static_cast<std::size_t>(row)] = 0;
}

void ContactSolvability::find_edges() {
  edges_.clear();
  has_friction_ = false;
  Index first = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index edges = contact_->edges[static_cast<std::size_t>(c)];
    const double mu = contact_->mu(c);
    if (edges == 0 || mu == 0) edges_.push_back({.contact = c});
    for (Index t = 0; t < edges && mu > 0; ++t) {
      edges_.push_back({.contact = c, .direction = first + t, .factor = mu});
      has_friction_ = true;
    }
    first += edges;
  }
  of_normals_ = !has_friction_;
}

void ContactSolvability::find_normals() {
  edges_.clear();
  of_normals_ = true;
  for (Index c = 0; c < contact_->nc(); ++c) edges_.push_back({.contact = c});
}

bool ContactSolvability::is_reached(const Edge& edge) const {
  bool reached = false;
  visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double, double) {
    for (Index k = 0; k < rank_; ++k) reached = reached || reach(i, k, Quad()) != 0;
  });
  return reached;
}

/// Edges that nothing reaches and that separate as they are: they have part in no u, and would set a scale for others.
/// @returns whether there were such
bool ContactSolvability::drop_satisfied_edges() {
  const std::size_t all = edges_.size();
  std::erase_if(edges_, [&](const Edge& edge) {
    Quad sum = 0;
    Quad terms = 0;
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const Quad term = static_cast<Quad>(entry) * static_cast<Quad>(factor) * speed(i, Quad());
      sum += term;
      terms += magnitude(term);
    });
    return sum >= kRoundingOfSum * terms && !is_reached(edge);
  });
  return edges_.size() < all;
}

bool ContactSolvability::is_confirmed_by(double missed) {
  find_range();
  find_unreached_velocity();
  Quad unreached = 0;
  Quad speed = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {  // in the units of the coordinates that contacts see
    visit_edge(*contact_, c, -1, 0, [&](Index i, double entry, double) {
      const Quad size = magnitude(static_cast<Quad>(entry));
      unreached = std::max(unreached, size * magnitude(this->speed(i, Quad())));
      speed = std::max(speed, size * magnitude(static_cast<Quad>(v_[i])));
    });
  }
  return static_cast<Quad>(missed) * speed <= kLargestMiss * unreached;
}

/// Only edges that are in the last basis: a u of these alone is one of all.
void ContactSolvability::keep_basic_edges() {
  const auto edges = static_cast<Index>(edges_.size());
  std::sort(basis_.begin(), basis_.end());
  std::size_t kept = 0;
  for (const Index j : basis_) {
    if (j < edges) edges_[kept++] = edges_[static_cast<std::size_t>(j)];
  }
  edges_.resize(kept);
}

}  // namespace lcpbench
