#include "native/auto/sticking_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "native/auto/body_vectors.h"
#include "native/contacts/contact_edges.h"

namespace lcpbench {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }
std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::size_t blocks_of(const ContactProblem& contact) {
  const auto* blocks = std::get_if<BlockInertia>(&contact.inertia);
  return blocks == nullptr ? 1 : blocks->blocks.size();
}

/// Directions in which friction holds the contact, each for two opposite ones.
int directions_of(const ContactProblem& problem, Index contact) {
  return problem.mu(contact) > 0 ? problem.edges[at(contact)] / 2 : 0;
}

/// visit(column, row, entry) for the columns N_c and the first half of D_c, numbered from 0.
template <class Visit>
void visit_contact(const ContactProblem& problem, Index contact, Index direction, Visit&& visit) {
  for_each_entry(problem.N, contact, [&](Index row, double entry) { visit(0, row, entry); });
  for (int t = 0; t < directions_of(problem, contact); ++t) {
    for_each_entry(problem.D, direction + t, [&](Index row, double entry) { visit(1 + t, row, entry); });
  }
}

}  // namespace

const Matrix& sticking_block(const ContactProblem& contact, std::size_t block) {
  if (const auto* dense = std::get_if<DenseInertia>(&contact.inertia)) return dense->G;
  return std::get<BlockInertia>(contact.inertia).blocks[block];
}

StickingGraph::StickingGraph() : kernels_(cholesky::engine(isa_level())) {}

bool StickingGraph::load(const ContactProblem& contact) {
  contact_ = &contact;
  bool is_new = false;
  if (!has_last_sizes() || !fill_columns()) {
    find();
    fill_columns();
    is_new = bodies_ != last_bodies_ || coupled_ != last_coupled_;
    if (!is_new) set_places(std::move(places_));
  }
  invert_diagonal();
  has_factors_ = false;
  measure_strength();
  return is_new;
}

void StickingGraph::set_places(std::vector<int> places) {
  places_ = std::move(places);
  for (StickingPart& part : parts_) part.place = places_[at(part.body)];
}

/// The bodies and the columns.
void StickingGraph::find() {
  bodies_.swap(last_bodies_);
  coupled_.swap(last_coupled_);
  find_bodies();
  find_columns();
  find_coupled();
  take_room();
}

/// The memory for factor_inertia().
void StickingGraph::take_room() {
  std::ptrdiff_t largest = 0;
  for (const StickingBody& body : bodies_) {
    largest = std::max<std::ptrdiff_t>(largest, body.size);
  }
  const std::ptrdiff_t stride = largest + cholesky::kMargin;
  dense_.resize(static_cast<std::size_t>(stride * stride));
  work_.resize(static_cast<std::size_t>(cholesky::work_size(largest)));
  inertia_factors_.resize(bodies_.empty() ? 0
                                          : bodies_.back().factor + at(bodies_.back().size) * at(bodies_.back().size));
}

/// Whether bodies and columns are as many and as long as in the last problem.
bool StickingGraph::has_last_sizes() const {
  if (contacts_.size() != contact_->edges.size() || body_of_.size() != at(contact_->ngc())) return false;
  if (block_sizes_.size() != blocks_of(*contact_)) return false;
  for (std::size_t b = 0; b < block_sizes_.size(); ++b) {
    if (sticking_block(*contact_, b).rows() != block_sizes_[b]) return false;
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (contacts_[c].columns != 1 + directions_of(*contact_, static_cast<Index>(c))) return false;
  }
  return true;
}

/// Blocks next to each other that the same contacts touch become one: their columns are never apart.
void StickingGraph::find_bodies() {
  const std::size_t blocks = blocks_of(*contact_);
  body_of_.resize(at(contact_->ngc()));
  block_sizes_.resize(blocks);
  std::size_t coordinate = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const Index size = block_sizes_[b] = sticking_block(*contact_, b).rows();
    for (Index i = 0; i < size; ++i) body_of_[coordinate++] = static_cast<int>(b);
  }
  bodies_.clear();
  if (blocks == 1) {
    bodies_.push_back({.size = static_cast<int>(contact_->ngc())});
    return;
  }
  std::vector<std::uint64_t>& touched = signatures_;  // sums over contacts of a number of each
  touched.assign(blocks, 0);
  last_touched_.assign(blocks, -1);
  Index direction = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    const std::uint64_t number = (static_cast<std::uint64_t>(c) + 1) * 0x9e3779b97f4a7c15U;
    visit_contact(*contact_, c, direction, [&](int, Index row, double) {
      const auto b = at(body_of_[at(row)]);
      if (last_touched_[b] == c) return;
      last_touched_[b] = c;
      touched[b] += number ^ (number >> 29U);
    });
    direction += contact_->edges[at(c)];
  }
  coordinate = 0;
  std::size_t factor = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto size = static_cast<int>(sticking_block(*contact_, b).rows());
    if (b > 0 && touched[b] == touched[b - 1]) {
      bodies_.back().size += size;
    } else {
      if (b > 0) factor += at(bodies_.back().size) * at(bodies_.back().size);
      bodies_.push_back({.size = size, .first = static_cast<int>(coordinate), .block = b, .factor = factor});
    }
    for (int i = 0; i < size; ++i) body_of_[coordinate++] = static_cast<int>(bodies_.size()) - 1;
  }
}

/// The bodies of each contact, and where its columns will stand.
void StickingGraph::find_columns() {
  contacts_.clear();
  parts_.clear();
  coordinates_.clear();
  StickingColumns columns;
  Index direction = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    columns.parts = parts_.size();
    if (is_one()) {
      parts_.push_back({.body = 0});
    } else {
      visit_contact(*contact_, c, direction, [&](int, Index row, double) {
        const int body = body_of_[at(row)];
        const auto is_body = [body](const StickingPart& part) { return part.body == body; };
        const auto begin = parts_.begin() + static_cast<std::ptrdiff_t>(columns.parts);
        if (std::none_of(begin, parts_.end(), is_body)) parts_.push_back({.body = body});
      });
    }
    const auto begin = parts_.begin() + static_cast<std::ptrdiff_t>(columns.parts);
    std::sort(begin, parts_.end(), [](const StickingPart& a, const StickingPart& b) { return a.body < b.body; });
    columns.end_parts = parts_.size();
    columns.coordinates = coordinates_.size();
    columns.rows = 0;
    for (std::size_t p = columns.parts; p < columns.end_parts; ++p) {
      const StickingBody& body = bodies_[at(parts_[p].body)];
      parts_[p].row = columns.rows;
      parts_[p].first = body.first;
      parts_[p].size = body.size;
      columns.rows += body.size;
      for (int i = 0; i < body.size; ++i) coordinates_.push_back(body.first + i);
    }
    columns.stride = columns.rows + (is_one() ? static_cast<int>(cholesky::kMargin) : 0);
    columns.columns = 1 + directions_of(*contact_, c);
    contacts_.push_back(columns);
    columns.entries += at(columns.stride) * at(columns.columns);
    columns.first += at(columns.columns);
    direction += contact_->edges[at(c)];
  }
}

/// Pairs of bodies that a contact touches, the first before the second.
void StickingGraph::find_coupled() {
  coupled_.clear();
  for (const StickingColumns& contact : contacts_) {
    for (std::size_t a = contact.parts; a < contact.end_parts; ++a) {
      for (std::size_t b = a + 1; b < contact.end_parts; ++b) {
        const std::pair<int, int> pair(parts_[a].body, parts_[b].body);
        if (coupled_.empty() || coupled_.back() != pair) coupled_.push_back(pair);
      }
    }
  }
  std::sort(coupled_.begin(), coupled_.end());
  coupled_.erase(std::unique(coupled_.begin(), coupled_.end()), coupled_.end());
}

/// @returns false where a contact touches a body that it did not touch when the graph was found
bool StickingGraph::fill_columns() {
  const std::size_t last = contacts_.empty() ? 0 : at(contacts_.back().stride) * at(contacts_.back().columns);
  entries_.assign(contacts_.empty() ? 0 : contacts_.back().entries + last, 0.0);
  bool fits = true;
  Index direction = 0;
  for (std::size_t c = 0; c < contacts_.size() && fits; ++c) {
    const StickingColumns& contact = contacts_[c];
    double* column = entries_.data() + contact.entries;
    fits = fill_column(contact_->N, static_cast<Index>(c), contact, column);
    for (int t = 0; t + 1 < contact.columns && fits; ++t) {
      column += contact.stride;
      fits = fill_column(contact_->D, direction + t, contact, column);
    }
    direction += contact_->edges[c];
  }
  return fits;
}

bool StickingGraph::fill_column(const Jacobian& J, Index number, const StickingColumns& contact, double* column) const {
  const StickingPart* const begin = parts_.data() + contact.parts;
  const StickingPart* const end = parts_.data() + contact.end_parts;
  const StickingPart* part = begin;  // entries of a body follow each other
  bool fits = true;
  const auto put = [&](Index row, double entry) {
    const auto is_in = [row](const StickingPart* p) { return row >= p->first && row < p->first + p->size; };
    if (part == end || !is_in(part)) part = std::find_if(begin, end, [&](const StickingPart& p) { return is_in(&p); });
    if (part == end) {
      fits = false;
    } else {
      column[part->row + (row - part->first)] = entry;
    }
  };
  const auto* dense = std::get_if<Matrix>(&J);
  if (dense != nullptr && is_one()) {
    std::copy_n(dense->col(number).data(), contact.rows, column);
    return true;
  }
  const auto* sparse = std::get_if<SparseMatrix>(&J);
  if (sparse == nullptr || !sparse->isCompressed()) {
    for_each_entry(J, number, put);
    return fits;
  }
  const int first = sparse->outerIndexPtr()[number];
  const int count = sparse->outerIndexPtr()[number + 1] - first;
  const int* const rows = sparse->innerIndexPtr() + first;
  const double* const values = sparse->valuePtr() + first;
  if (is_one()) {
    for (int e = 0; e < count; ++e) column[rows[e]] = values[e];
    return true;
  }
  if (count == contact.rows && std::equal(rows, rows + count, coordinates_.data() + contact.coordinates)) {
    std::copy_n(values, count, column);  // every coordinate of its bodies, as most have
    return true;
  }
  for (int e = 0; e < count; ++e) {
    if (values[e] != 0) put(rows[e], values[e]);
  }
  return fits;
}

void StickingGraph::invert_diagonal() {
  inverse_diagonal_.resize(at(contact_->ngc()));
  for (const StickingBody& body : bodies_) {
    for_each_block(body, [&](int first, const Matrix& block) {
      for (Index j = 0; j < block.cols(); ++j) inverse_diagonal_[at(body.first + first + j)] = 1 / block(j, j);
    });
  }
}

/// Cholesky factors of each body's G, by columns, with the inverse of each diagonal entry in its place.
void StickingGraph::factor_inertia() {
  has_factors_ = true;
  for (const StickingBody& body : bodies_) {
    factor_inertia(body, inertia_factors_.data() + body.factor);
  }
}

void StickingGraph::copy_inertia(const StickingBody& body, double* to) const {
  const std::ptrdiff_t stride = body.size + cholesky::kMargin;
  const bool is_one_block = sticking_block(*contact_, body.block).rows() == body.size;
  if (!is_one_block) std::fill_n(to, body.size * stride, 0.0);
  for_each_block(body, [&](int first, const Matrix& block) {
    cholesky::take_lower(block.data(), block.rows(), to + first * (stride + 1), stride);
  });
}

void StickingGraph::factor_inertia(const StickingBody& body, double* L) {
  const std::ptrdiff_t n = body.size;
  const std::ptrdiff_t stride = n + cholesky::kMargin;
  copy_inertia(body, dense_.data());
  if (!kernels_.factor(dense_.data(), stride, n, n, work_.data())) {
    std::fill_n(L, n * n, std::numeric_limits<double>::quiet_NaN());  // no velocity passes a test then
    return;
  }
  cholesky::keep_columns(dense_.data(), stride, n, n, L);
}

void StickingGraph::measure_strength() {
  strength_.resize(contacts_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const double* const normal = columns(contacts_[c]);
    double response = 0;
    for (std::size_t p = contacts_[c].parts; p < contacts_[c].end_parts; ++p) {
      const double* const entries = normal + parts_[p].row;
      const double* const inverse = inverse_diagonal_.data() + parts_[p].first;
      for (int i = 0; i < parts_[p].size; ++i) response += entries[i] * entries[i] * inverse[i];
    }
    strength_[c] = response > 0 ? 1 / response : 0;
  }
}

std::size_t StickingGraph::column_count() const {
  return contacts_.empty() ? 0 : contacts_.back().first + at(contacts_.back().columns);
}

void StickingGraph::order(const Vector& x, Vector& ordered) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    ordered.segment(places_[b], bodies_[b].size) = x.segment(bodies_[b].first, bodies_[b].size);
  }
}

void StickingGraph::restore(const Vector& ordered, Vector& x) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    x.segment(bodies_[b].first, bodies_[b].size) = ordered.segment(places_[b], bodies_[b].size);
  }
}

void StickingGraph::multiply(const Vector& x, double* products) const {
  if (is_one() && !contacts_.empty()) {
    const StickingColumns& first = contacts_.front();
    return kernels_.multiply_transposed(entries_.data(), first.stride, first.rows,
                                        static_cast<std::ptrdiff_t>(column_count()), x.data(), products);
  }
  for (const StickingColumns& contact : contacts_) multiply_contact(contact, x, products + contact.first);
}

void StickingGraph::multiply_contact(const StickingColumns& contact, const Vector& x, double* products) const {
  const double* const entries = columns(contact);
  std::fill_n(products, contact.columns, 0.0);
  for (std::size_t p = contact.parts; p < contact.end_parts; ++p) {
    const double* const part = x.data() + parts_[p].place;
    with_body_size(parts_[p].size, [&](auto vector) {
      const double* const column = entries + parts_[p].row;
      for (int t = 0; t < contact.columns; ++t) products[t] += vector(column + t * contact.stride).dot(vector(part));
    });
  }
}

void StickingGraph::add_columns(const double* factors, Vector& to) const {
  if (is_one() && !contacts_.empty()) {
    const StickingColumns& first = contacts_.front();
    return kernels_.multiply(entries_.data(), first.stride, first.rows, static_cast<std::ptrdiff_t>(column_count()),
                             factors, to.data());
  }
  for (const StickingColumns& contact : contacts_) {
    const double* const own = factors + contact.first;
    if (std::any_of(own, own + contact.columns, [](double x) { return x != 0; })) add_contact(contact, own, to);
  }
}

void StickingGraph::add_contact(const StickingColumns& contact, const double* factors, Vector& to) const {
  const double* const entries = columns(contact);
  for (std::size_t p = contact.parts; p < contact.end_parts; ++p) {
    double* const part = to.data() + parts_[p].place;
    with_body_size(parts_[p].size, [&](auto vector) {
      const double* const column = entries + parts_[p].row;
      for (int t = 0; t < contact.columns; ++t) vector(part) += factors[t] * vector(column + t * contact.stride);
    });
  }
}

void StickingGraph::add_response(Vector& impulse, Vector& to) {
  if (!has_factors_) factor_inertia();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const int n = bodies_[b].size;
    const double* const L = inertia_factors_.data() + bodies_[b].factor;
    double* const x = impulse.data() + places_[b];
    double* const u = to.data() + places_[b];
    kernels_.solve_lower(L, n, n, x);
    kernels_.solve_transposed(L, n, n, x);
    for (int i = 0; i < n; ++i) u[i] += x[i];
  }
}

void StickingGraph::subtract_inertia(const Vector& x, Vector& from) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    for_each_block(bodies_[b], [&](int first, const Matrix& block) {
      const double* const given = x.data() + places_[b] + first;
      double* const to = from.data() + places_[b] + first;
      with_body_size(static_cast<int>(block.rows()), [&](auto vector) {
        constexpr int kSize = std::remove_reference_t<decltype(vector(to))>::RowsAtCompileTime;
        const Eigen::Map<const Eigen::Matrix<double, kSize, kSize>> G(block.data(), block.rows(), block.cols());
        vector(to).noalias() -= G * vector(given);
      });
    });
  }
}

void StickingGraph::respond_by_diagonal(Vector& x) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    double* const part = x.data() + places_[b];
    const double* const inverse = inverse_diagonal_.data() + bodies_[b].first;
    for (int i = 0; i < bodies_[b].size; ++i) part[i] *= inverse[i];
  }
}

}  // namespace lcpbench
