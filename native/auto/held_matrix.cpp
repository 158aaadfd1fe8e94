#include "native/auto/held_matrix.h"

#include <algorithm>

#include "native/auto/body_vectors.h"
#include "native/velocity_ipm/multifrontal_cholesky.h"
#include "native/velocity_ipm/nested_dissection.h"

namespace lcpbench {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Whether they touch the same bodies.
bool are_alike(const HeldGraph& graph, const HeldColumns& a, const HeldColumns& b) {
  const auto is_same = [](const HeldPart& x, const HeldPart& y) { return x.body == y.body; };
  const auto begin = graph.parts().begin();
  return std::equal(begin + static_cast<std::ptrdiff_t>(a.parts), begin + static_cast<std::ptrdiff_t>(a.end_parts),
                    begin + static_cast<std::ptrdiff_t>(b.parts), begin + static_cast<std::ptrdiff_t>(b.end_parts),
                    is_same);
}

}  // namespace

HeldMatrix::HeldMatrix() : factors_(multifrontal_cholesky()) {}

void HeldMatrix::analyze(const HeldGraph& graph, Index ngc) {
  std::vector<Eigen::Triplet<double>> pairs;
  const auto size = static_cast<Index>(graph.bodies().size());
  for (int b = 0; b < static_cast<int>(size); ++b) pairs.emplace_back(b, b, 1.0);
  for (const auto& [a, b] : graph.coupled()) pairs.emplace_back(b, a, 1.0);
  SparseMatrix coupled(size, size);
  coupled.setFromTriplets(pairs.begin(), pairs.end());
  place_bodies(graph, coupled);
  lay_out(graph, ngc);
  product_.resize(at(graph.largest_body()) * at(graph.largest_body()));
  factors_->analyze(matrix_);
}

std::vector<int> HeldMatrix::places() const {
  std::vector<int> places;
  for (const Place& place : places_) places.push_back(place.first);
  return places;
}

void HeldMatrix::place_bodies(const HeldGraph& graph, const SparseMatrix& coupled) {
  const std::vector<HeldBody>& bodies = graph.bodies();
  const std::vector<int> order = nested_dissection(coupled);
  places_.assign(bodies.size(), {});
  int first = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    places_[at(order[k])].first = first;
    places_[at(order[k])].rank = static_cast<int>(k);
    first += bodies[at(order[k])].size;
  }
  std::vector<std::vector<int>> later(bodies.size());
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b) {
    for (SparseMatrix::InnerIterator other(coupled, b); other; ++other) {
      const auto a = static_cast<int>(other.row());
      if (a == b) continue;
      const bool is_later = places_[at(a)].rank > places_[at(b)].rank;
      later[at(is_later ? b : a)].push_back(is_later ? a : b);
    }
  }
  below_.clear();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    std::vector<int>& all = later[b];
    std::sort(all.begin(), all.end(), [&](int x, int y) { return places_[at(x)].rank < places_[at(y)].rank; });
    places_[b].below = below_.size();
    int skip = 0;
    for (const int a : all) {
      below_.push_back({.body = a, .skip = skip});
      skip += bodies[at(a)].size;
    }
    places_[b].end_below = below_.size();
  }
}

/// Column by column in the order of elimination: its own body's rows from the diagonal on, then those of below_.
void HeldMatrix::lay_out(const HeldGraph& graph, Index ngc) {
  const std::vector<HeldBody>& bodies = graph.bodies();
  std::vector<int> body_at(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) body_at[at(places_[b].rank)] = static_cast<int>(b);
  std::vector<int> begin{0};
  std::vector<int> rows;
  for (const int b : body_at) {
    const Place& place = places_[at(b)];
    for (int j = 0; j < bodies[at(b)].size; ++j) {
      for (int i = j; i < bodies[at(b)].size; ++i) rows.push_back(place.first + i);
      for (std::size_t k = place.below; k < place.end_below; ++k) {
        const int other = below_[k].body;
        for (int i = 0; i < bodies[at(other)].size; ++i) rows.push_back(places_[at(other)].first + i);
      }
      begin.push_back(static_cast<int>(rows.size()));
    }
  }
  matrix_ = SparseMatrix(ngc, ngc);
  matrix_.resizeNonZeros(static_cast<Index>(rows.size()));
  std::copy(begin.begin(), begin.end(), matrix_.outerIndexPtr());
  std::copy(rows.begin(), rows.end(), matrix_.innerIndexPtr());
  std::fill_n(matrix_.valuePtr(), rows.size(), 0.0);
}

/// Rows of a column of `body` between its own rows and those of `below`.
int HeldMatrix::skip(int body, int below) const {
  std::size_t k = places_[at(body)].below;
  while (below_[k].body != below) ++k;
  return below_[k].skip;
}

/// A W A' of contacts `first` to `end` - 1, which touch the same bodies.
void HeldMatrix::add_contacts(const HeldGraph& graph, const std::vector<double>& weights, std::size_t first,
                              std::size_t end) {
  const std::vector<HeldPart>& parts = graph.parts();
  const std::vector<HeldBody>& bodies = graph.bodies();
  const std::vector<HeldColumns>& contacts = graph.contacts();
  double* const values = matrix_.valuePtr();
  const HeldColumns& all = contacts[first];
  for (std::size_t q = all.parts; q < all.end_parts; ++q) {
    const int column_body = parts[q].body;
    const int size = bodies[at(column_body)].size;
    const int* const begin = matrix_.outerIndexPtr() + places_[at(column_body)].first;
    for (std::size_t p = all.parts; p < all.end_parts; ++p) {
      const int row_body = parts[p].body;
      const bool is_own = p == q;
      if (!is_own && places_[at(row_body)].rank < places_[at(column_body)].rank) continue;
      const int gap = is_own ? 0 : skip(column_body, row_body);
      const int rows = bodies[at(row_body)].size;
      std::fill_n(product_.data(), at(size) * at(rows), 0.0);
      with_body_size(rows, [&](auto vector) {
        for (std::size_t c = first; c < end; ++c) {
          if (weights[c] == 0) continue;
          const double* column = graph.columns(contacts[c]);
          for (int t = 0; t < contacts[c].columns; ++t, column += all.rows) {
            const auto from = vector(column + parts[p].row);
            double* to = product_.data();
            for (int j = 0; j < size; ++j, to += rows) vector(to) += weights[c] * column[parts[q].row + j] * from;
          }
        }
      });
      for (int j = 0; j < size; ++j) {
        const double* const from = product_.data() + j * rows;
        double* const to = values + begin[j] + (is_own ? -j : size - j + gap);
        for (int i = is_own ? j : 0; i < rows; ++i) to[i] += from[i];
      }
    }
  }
}

bool HeldMatrix::factor(const HeldGraph& graph, const std::vector<double>& weights) {
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  for (std::size_t b = 0; b < graph.bodies().size(); ++b) {
    graph.for_each_block(graph.bodies()[b], [&](int first, const Matrix& block) {
      for (Index j = 0; j < block.cols(); ++j) {
        double* const to = matrix_.valuePtr() + matrix_.outerIndexPtr()[places_[b].first + first + j];
        for (Index i = j; i < block.rows(); ++i) to[i - j] = block(i, j);
      }
    });
  }
  const std::vector<HeldColumns>& contacts = graph.contacts();
  for (std::size_t c = 0; c < contacts.size();) {
    const std::size_t first = c;
    while (++c < contacts.size() && are_alike(graph, contacts[first], contacts[c])) {
    }
    add_contacts(graph, weights, first, c);
  }
  return factors_->factor(matrix_);
}

}  // namespace lcpbench
