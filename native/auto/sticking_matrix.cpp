#include "native/auto/sticking_matrix.h"

#include <algorithm>
#include <cmath>

#include "core/isa.h"
#include "native/auto/body_vectors.h"
#include "native/velocity_ipm/multifrontal_cholesky.h"
#include "native/velocity_ipm/elimination_order.h"

namespace lcpbench {
namespace {

/// Columns that are multiplied together.
constexpr std::ptrdiff_t kTogether = 48;

std::size_t at(std::ptrdiff_t i) { return static_cast<std::size_t>(i); }

/// Whether they touch the same bodies.
bool are_alike(const StickingGraph& graph, const StickingColumns& a, const StickingColumns& b) {
  const auto is_same = [](const StickingPart& x, const StickingPart& y) { return x.body == y.body; };
  const auto begin = graph.parts().begin();
  return std::equal(begin + static_cast<std::ptrdiff_t>(a.parts), begin + static_cast<std::ptrdiff_t>(a.end_parts),
                    begin + static_cast<std::ptrdiff_t>(b.parts), begin + static_cast<std::ptrdiff_t>(b.end_parts),
                    is_same);
}

}  // namespace

StickingMatrix::StickingMatrix() : factors_(multifrontal_cholesky()), kernels_(cholesky::engine(isa_level())) {}

void StickingMatrix::analyze(const StickingGraph& graph, Index ngc) {
  order_ = graph.is_one() ? ngc : 0;
  if (graph.is_one()) {
    places_.assign(1, {});
    return;
  }
  std::vector<Eigen::Triplet<double>> pairs;
  const auto size = static_cast<Index>(graph.bodies().size());
  for (int b = 0; b < static_cast<int>(size); ++b) pairs.emplace_back(b, b, 1.0);
  for (const auto& [a, b] : graph.coupled()) pairs.emplace_back(b, a, 1.0);
  SparseMatrix coupled(size, size);
  coupled.setFromTriplets(pairs.begin(), pairs.end());
  place_bodies(graph, coupled);
  lay_out(graph, ngc);
  factors_->analyze(matrix_);
}

void StickingMatrix::take_room(const StickingGraph& graph) {
  int most = graph.is_one() ? graph.bodies().front().size : 0;
  std::size_t parts = 0;
  for (const StickingColumns& contact : graph.contacts()) {
    most = std::max(most, contact.rows);
    parts = std::max(parts, contact.end_parts - contact.parts);
  }
  const std::size_t stride = at(most) + at(cholesky::kMargin);
  ordered_.reserve(parts);
  columns_.resize(stride * at(kTogether));
  product_.resize(stride * stride);
  work_.resize(at(cholesky::work_size(most)));
  one_.resize(at(order_ * order_));
}

std::vector<int> StickingMatrix::places() const {
  std::vector<int> places;
  for (const Place& place : places_) places.push_back(place.first);
  return places;
}

void StickingMatrix::place_bodies(const StickingGraph& graph, const SparseMatrix& coupled) {
  const std::vector<StickingBody>& bodies = graph.bodies();
  const std::vector<int> order = elimination_order(coupled);
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
void StickingMatrix::lay_out(const StickingGraph& graph, Index ngc) {
  const std::vector<StickingBody>& bodies = graph.bodies();
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
int StickingMatrix::skip(int body, int below) const {
  std::size_t k = places_[at(body)].below;
  while (below_[k].body != below) ++k;
  return below_[k].skip;
}

/// The parts of a contact, in the order of elimination.
void StickingMatrix::order_parts(const StickingGraph& graph, const StickingColumns& contact) {
  const auto begin = graph.parts().begin();
  ordered_.assign(begin + static_cast<std::ptrdiff_t>(contact.parts),
                  begin + static_cast<std::ptrdiff_t>(contact.end_parts));
  std::sort(ordered_.begin(), ordered_.end(), [](const StickingPart& a, const StickingPart& b) { return a.place < b.place; });
}

/// A W A' of contacts `first` to `end` - 1, which touch the same bodies, as a dense matrix over these.
void StickingMatrix::add_contacts(const StickingGraph& graph, const std::vector<double>& weights, std::size_t first,
                              std::size_t end) {
  const StickingColumns& all = graph.contacts()[first];
  if (all.rows == 0) return;
  order_parts(graph, all);
  const std::ptrdiff_t stride = all.rows + cholesky::kMargin;
  std::fill_n(product_.data(), stride * stride, 0.0);
  std::ptrdiff_t count = 0;
  const auto add_product = [&] {
    kernels_.add_product(product_.data(), stride, columns_.data(), stride, all.rows, count, work_.data());
    count = 0;
  };
  for (std::size_t c = first; c < end; ++c) {
    if (weights[c] == 0) continue;
    const double root = std::sqrt(weights[c]);
    const double* column = graph.columns(graph.contacts()[c]);
    for (int t = 0; t < graph.contacts()[c].columns; ++t, column += all.stride) {
      double* to = columns_.data() + count * stride;
      for (const StickingPart& part : ordered_) {
        with_body_size(part.size, [&](auto vector) { vector(to) = root * vector(column + part.row); });
        to += part.size;
      }
      std::fill_n(to, cholesky::kMargin, 0.0);
      if (++count == kTogether) add_product();
    }
  }
  if (count > 0) add_product();
  scatter(stride);
}

/// Adds the dense matrix over ordered_.
void StickingMatrix::scatter(std::ptrdiff_t stride) {
  const double* column = product_.data();  // from its diagonal on
  for (std::size_t q = 0; q < ordered_.size(); ++q) {
    const int size = ordered_[q].size;
    for (int j = 0; j < size; ++j, column += stride + 1) {
      double* const to = matrix_.valuePtr() + matrix_.outerIndexPtr()[ordered_[q].place + j];
      const double* from = column;
      for (int i = 0; i < size - j; ++i) to[i] += from[i];
      from += size - j;
      for (std::size_t p = q + 1; p < ordered_.size(); ++p) {
        double* const below = to + size - j + skip(ordered_[q].body, ordered_[p].body);
        with_body_size(ordered_[p].size, [&](auto vector) { vector(below) += vector(from); });
        from += ordered_[p].size;
      }
    }
  }
}

/// Dense: all contacts are columns of one matrix.
bool StickingMatrix::factor_one(const StickingGraph& graph, const std::vector<double>& weights) {
  const std::ptrdiff_t stride = order_ + cholesky::kMargin;
  graph.copy_inertia(graph.bodies().front(), product_.data());
  std::ptrdiff_t count = 0;
  const auto add_product = [&] {
    kernels_.add_product(product_.data(), stride, columns_.data(), stride, order_, count, work_.data());
    count = 0;
  };
  const std::vector<StickingColumns>& contacts = graph.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (weights[c] == 0) continue;
    const double root = std::sqrt(weights[c]);
    const double* column = graph.columns(contacts[c]);
    for (int t = 0; t < contacts[c].columns; ++t, column += stride) {
      Eigen::Map<Vector>(columns_.data() + count * stride, stride) = root * Eigen::Map<const Vector>(column, stride);
      if (++count == kTogether) add_product();
    }
  }
  if (count > 0) add_product();
  if (!kernels_.factor(product_.data(), stride, order_, order_, work_.data())) return false;
  cholesky::keep_columns(product_.data(), stride, order_, order_, one_.data());
  return true;
}

void StickingMatrix::solve(Vector& x) {
  if (order_ == 0) return factors_->solve(x);
  kernels_.solve_lower(one_.data(), order_, order_, x.data());
  kernels_.solve_transposed(one_.data(), order_, order_, x.data());
}

bool StickingMatrix::factor(const StickingGraph& graph, const std::vector<double>& weights) {
  if (graph.is_one()) return factor_one(graph, weights);
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  for (std::size_t b = 0; b < graph.bodies().size(); ++b) {
    graph.for_each_block(graph.bodies()[b], [&](int first, const Matrix& block) {
      for (Index j = 0; j < block.cols(); ++j) {
        double* const to = matrix_.valuePtr() + matrix_.outerIndexPtr()[places_[b].first + first + j];
        for (Index i = j; i < block.rows(); ++i) to[i - j] = block(i, j);
      }
    });
  }
  const std::vector<StickingColumns>& contacts = graph.contacts();
  for (std::size_t c = 0; c < contacts.size();) {
    const std::size_t first = c;
    while (++c < contacts.size() && are_alike(graph, contacts[first], contacts[c])) {
    }
    add_contacts(graph, weights, first, c);
  }
  return factors_->factor(matrix_);
}

}  // namespace lcpbench
