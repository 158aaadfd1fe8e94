#include "native/auto/held_contacts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <variant>

#include "native/contacts/contact_edges.h"
#include "native/velocity_ipm/multifrontal_cholesky.h"
#include "native/velocity_ipm/nested_dissection.h"

namespace lcpbench {
namespace {

/// Guesses of a solve: the first, and those after contacts were let go or held.
constexpr int kTries = 3;

/// W times the inertia that a contact feels: S = A'G*A is met but for the inverse of this in each step.
constexpr double kStiffness = 1e9;
/// Of contacts with hardly any load, against that with the largest.
constexpr double kLeastLoad = 1e-2;
constexpr int kMostSteps = 8;

/// Velocities A'u + b, relative to max|q|: at the first no further step is taken, at the second the guess may stand.
constexpr double kHeldStill = 1e-10;
constexpr double kLargestMiss = 1e-9;
/// A step that does not bring them to this part of the last has met rounding.
constexpr double kProgress = 0.5;

/// Of the largest impulse: a contact that pulls less is open, and friction beyond its pyramid by less is on it.
constexpr double kNoImpulse = 1e-9;
/// In the last answer a lambda above this part of max|v| is slip.
constexpr double kSlip = 1e-6;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }
std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Calls work(at) where at(pointer) is the vector of `size` entries there, of fixed length where that is 6: a body.
template <class Work>
void with_size(int size, Work&& work) {
  using Six = Eigen::Matrix<double, 6, 1>;
  if (size == Six::RowsAtCompileTime) {
    work([](auto* entries) {
      using Entries = std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(entries)>>, const Six, Six>;
      return Eigen::Map<Entries>(entries);
    });
  } else {
    work([size](auto* entries) {
      using Entries =
          std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(entries)>>, const Vector, Vector>;
      return Eigen::Map<Entries>(entries, size);
    });
  }
}

/// The blocks of G.
const Matrix& block_of(const ContactProblem& contact, std::size_t block) {
  if (const auto* dense = std::get_if<DenseInertia>(&contact.inertia)) return dense->G;
  return std::get<BlockInertia>(contact.inertia).blocks[block];
}

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

HeldContacts::HeldContacts() : factors_(multifrontal_cholesky()) {}

bool HeldContacts::takes(const ContactProblem& contact) {
  return std::holds_alternative<BlockInertia>(contact.inertia) || std::holds_alternative<DenseInertia>(contact.inertia);
}

void HeldContacts::load(const Problem& problem, const Vector& v) {
  problem_ = &problem;
  contact_ = problem.contact();
  has_test_ = false;
  if (!has_last_sizes() || !fill_columns()) {
    find_graph();
    fill_columns();
  }
  factor_inertia();
  set_velocity(v);
}

/// The bodies, the columns, and if other bodies are coupled than last the order of elimination.
void HeldContacts::find_graph() {
  bodies_.swap(last_bodies_);
  coupled_.swap(last_coupled_);
  find_bodies();
  find_columns();
  find_coupled();
  take_room();
  if (bodies_ != last_bodies_ || coupled_ != last_coupled_) analyze();
  for (Part& part : parts_) part.place = places_[at(part.body)].first;
}

/// Whether bodies and columns are as many and as long as in the last problem.
bool HeldContacts::has_last_sizes() const {
  if (contacts_.size() != contact_->edges.size() || body_of_.size() != at(contact_->ngc())) return false;
  if (block_sizes_.size() != blocks_of(*contact_)) return false;
  for (std::size_t b = 0; b < block_sizes_.size(); ++b) {
    if (block_of(*contact_, b).rows() != block_sizes_[b]) return false;
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (contacts_[c].columns != 1 + directions_of(*contact_, static_cast<Index>(c))) return false;
  }
  return true;
}

/// Blocks next to each other that the same contacts touch become one: their columns are never apart.
void HeldContacts::find_bodies() {
  const std::size_t blocks = blocks_of(*contact_);
  body_of_.resize(at(contact_->ngc()));
  block_sizes_.resize(blocks);
  std::size_t coordinate = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const Index size = block_sizes_[b] = block_of(*contact_, b).rows();
    for (Index i = 0; i < size; ++i) body_of_[coordinate++] = static_cast<int>(b);
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
  bodies_.clear();
  coordinate = 0;
  std::size_t factor = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto size = static_cast<int>(block_of(*contact_, b).rows());
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
void HeldContacts::find_columns() {
  contacts_.clear();
  parts_.clear();
  Columns columns;
  Index direction = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    columns.parts = parts_.size();
    visit_contact(*contact_, c, direction, [&](int, Index row, double) {
      const int body = body_of_[at(row)];
      const auto is_body = [body](const Part& part) { return part.body == body; };
      const auto begin = parts_.begin() + static_cast<std::ptrdiff_t>(columns.parts);
      if (std::none_of(begin, parts_.end(), is_body)) parts_.push_back({.body = body});
    });
    const auto begin = parts_.begin() + static_cast<std::ptrdiff_t>(columns.parts);
    std::sort(begin, parts_.end(), [](const Part& a, const Part& b) { return a.body < b.body; });
    columns.end_parts = parts_.size();
    columns.rows = 0;
    for (std::size_t p = columns.parts; p < columns.end_parts; ++p) {
      const Body& body = bodies_[at(parts_[p].body)];
      parts_[p].row = columns.rows;
      parts_[p].first = body.first;
      parts_[p].size = body.size;
      columns.rows += body.size;
    }
    columns.columns = 1 + directions_of(*contact_, c);
    contacts_.push_back(columns);
    columns.entries += at(columns.rows) * at(columns.columns);
    columns.first += at(columns.columns);
    direction += contact_->edges[at(c)];
  }
}

void HeldContacts::analyze() {
  std::vector<Eigen::Triplet<double>> pairs;
  for (int b = 0; b < static_cast<int>(bodies_.size()); ++b) pairs.emplace_back(b, b, 1.0);
  for (const auto& [a, b] : coupled_) pairs.emplace_back(b, a, 1.0);
  const auto size = static_cast<Index>(bodies_.size());
  SparseMatrix graph(size, size);
  graph.setFromTriplets(pairs.begin(), pairs.end());
  place_bodies(graph);
  lay_out_matrix();
  factors_->analyze(matrix_);
}

/// Pairs of bodies that a contact touches, the first before the second.
void HeldContacts::find_coupled() {
  coupled_.clear();
  for (const Columns& contact : contacts_) {
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

void HeldContacts::place_bodies(const SparseMatrix& coupled) {
  const std::vector<int> order = nested_dissection(coupled);
  places_.assign(bodies_.size(), {});
  int first = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    places_[at(order[k])].first = first;
    places_[at(order[k])].rank = static_cast<int>(k);
    first += bodies_[at(order[k])].size;
  }
  std::vector<std::vector<int>> later(bodies_.size());
  for (int b = 0; b < static_cast<int>(bodies_.size()); ++b) {
    for (SparseMatrix::InnerIterator other(coupled, b); other; ++other) {
      const auto a = static_cast<int>(other.row());
      if (a == b) continue;
      const bool is_later = places_[at(a)].rank > places_[at(b)].rank;
      later[at(is_later ? b : a)].push_back(is_later ? a : b);
    }
  }
  below_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    std::vector<int>& all = later[b];
    std::sort(all.begin(), all.end(), [&](int x, int y) { return places_[at(x)].rank < places_[at(y)].rank; });
    places_[b].below = below_.size();
    int skip = 0;
    for (const int a : all) {
      below_.push_back({.body = a, .skip = skip});
      skip += bodies_[at(a)].size;
    }
    places_[b].end_below = below_.size();
  }
}

/// Column by column in the order of elimination: its own body's rows from the diagonal on, then those of below_.
void HeldContacts::lay_out_matrix() {
  const Index ngc = contact_->ngc();
  std::vector<int> body_at(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) body_at[at(places_[b].rank)] = static_cast<int>(b);
  std::vector<int> begin{0};
  std::vector<int> rows;
  for (const int b : body_at) {
    const Place& place = places_[at(b)];
    for (int j = 0; j < bodies_[at(b)].size; ++j) {
      for (int i = j; i < bodies_[at(b)].size; ++i) rows.push_back(place.first + i);
      for (std::size_t k = place.below; k < place.end_below; ++k) {
        const int other = below_[k].body;
        for (int i = 0; i < bodies_[at(other)].size; ++i) rows.push_back(places_[at(other)].first + i);
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

/// @returns false where a contact touches a body that it did not touch when the graph was found
bool HeldContacts::fill_columns() {
  const std::size_t last = contacts_.empty() ? 0 : at(contacts_.back().rows) * at(contacts_.back().columns);
  entries_.assign(contacts_.empty() ? 0 : contacts_.back().entries + last, 0.0);
  bool fits = true;
  Index direction = 0;
  for (std::size_t c = 0; c < contacts_.size() && fits; ++c) {
    const Columns& contact = contacts_[c];
    double* column = entries_.data() + contact.entries;
    fits = fill_column(contact_->N, static_cast<Index>(c), contact, column);
    for (int t = 0; t + 1 < contact.columns && fits; ++t) {
      column += contact.rows;
      fits = fill_column(contact_->D, direction + t, contact, column);
    }
    direction += contact_->edges[c];
  }
  return fits;
}

bool HeldContacts::fill_column(const Jacobian& J, Index number, const Columns& contact, double* column) const {
  const Part* const begin = parts_.data() + contact.parts;
  const Part* const end = parts_.data() + contact.end_parts;
  const Part* part = begin;  // entries of a body follow each other
  bool fits = true;
  const auto put = [&](Index row, double entry) {
    const auto is_in = [row](const Part* p) { return row >= p->first && row < p->first + p->size; };
    if (part == end || !is_in(part)) part = std::find_if(begin, end, [&](const Part& p) { return is_in(&p); });
    if (part == end) {
      fits = false;
    } else {
      column[part->row + (row - part->first)] = entry;
    }
  };
  const auto* sparse = std::get_if<SparseMatrix>(&J);
  if (sparse == nullptr || !sparse->isCompressed()) {
    for_each_entry(J, number, put);
    return fits;
  }
  const int* const rows = sparse->innerIndexPtr();
  const double* const values = sparse->valuePtr();
  for (int e = sparse->outerIndexPtr()[number]; e < sparse->outerIndexPtr()[number + 1]; ++e) {
    if (values[e] != 0) put(rows[e], values[e]);
  }
  return fits;
}

/// Cholesky factors of each body's G, by columns, with the inverse of each diagonal entry in its place; and what a
/// contact feels of it, as if G were diagonal.
void HeldContacts::factor_inertia() {
  inertia_factors_.assign(
      bodies_.empty() ? 0 : bodies_.back().factor + at(bodies_.back().size) * at(bodies_.back().size), 0.0);
  is_definite_ = true;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const int n = bodies_[b].size;
    double* const L = inertia_factors_.data() + bodies_[b].factor;
    int first = 0;
    for (std::size_t k = bodies_[b].block; first < n; ++k) {
      const Matrix& block = block_of(*contact_, k);
      for (Index j = 0; j < block.cols(); ++j) {
        for (Index i = j; i < block.rows(); ++i) L[(first + j) * n + first + i] = block(i, j);
      }
      first += static_cast<int>(block.rows());
    }
    for (int j = 0; j < n; ++j) {
      double* const column = L + j * n;
      for (int k = 0; k < j; ++k) {
        const double* const before = L + k * n;
        for (int i = j; i < n; ++i) column[i] -= before[j] * before[i];
      }
      is_definite_ = is_definite_ && column[j] > 0;
      const double inverse = 1 / std::sqrt(column[j]);
      column[j] = inverse;
      for (int i = j + 1; i < n; ++i) column[i] *= inverse;
    }
  }
  strength_.resize(contacts_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Columns& contact = contacts_[c];
    double response = 0;
    for (std::size_t p = contact.parts; p < contact.end_parts; ++p) {
      const Body& body = bodies_[at(parts_[p].body)];
      int row = parts_[p].row;
      int left = body.size;
      for (std::size_t k = body.block; left > 0; ++k) {
        const Matrix& block = block_of(*contact_, k);
        for (Index i = 0; i < block.rows(); ++i, ++row) {
          const double entry = entries_[contact.entries + at(row)];
          response += entry * entry / block(i, i);
        }
        left -= static_cast<int>(block.rows());
      }
    }
    strength_[c] = response > 0 ? 1 / response : 0;
  }
}

void HeldContacts::take_room() {
  const std::size_t columns = contacts_.empty() ? 0 : contacts_.back().first + at(contacts_.back().columns);
  int most = 0;
  for (const Columns& contact : contacts_) most = std::max(most, contact.columns);
  scaled_.resize(at(most));
  most = 0;
  for (const Body& body : bodies_) most = std::max(most, body.size);
  product_.resize(at(most) * at(most));
  impulses_.resize(columns);
  misses_.resize(columns);
  held_.resize(contacts_.size());
  load_.resize(contacts_.size());
  for (Vector* room : {&v_, &u_, &step_, &impulse_}) room->resize(contact_->ngc());
}

void HeldContacts::set_velocity(const Vector& v) {
  given_v_ = v;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    v_.segment(places_[b].first, bodies_[b].size) = v.segment(bodies_[b].first, bodies_[b].size);
  }
  if (has_test_) test_.set_velocity(v);
}

/// products := columns' x
void HeldContacts::multiply(const Columns& contact, const Vector& x, double* products) const {
  std::fill_n(products, contact.columns, 0.0);
  const double* const entries = entries_.data() + contact.entries;
  for (std::size_t p = contact.parts; p < contact.end_parts; ++p) {
    const double* const part = x.data() + parts_[p].place;
    with_size(parts_[p].size, [&](auto vector) {
      const double* const column = entries + parts_[p].row;
      for (int t = 0; t < contact.columns; ++t) products[t] += vector(column + t * contact.rows).dot(vector(part));
    });
  }
}

/// to += columns factors
void HeldContacts::add_columns(const Columns& contact, const double* factors, Vector& to) const {
  const double* const entries = entries_.data() + contact.entries;
  for (std::size_t p = contact.parts; p < contact.end_parts; ++p) {
    double* const part = to.data() + parts_[p].place;
    with_size(parts_[p].size, [&](auto vector) {
      const double* const column = entries + parts_[p].row;
      for (int t = 0; t < contact.columns; ++t) vector(part) += factors[t] * vector(column + t * contact.rows);
    });
  }
}

/// to += G* impulse; impulse is used up.
void HeldContacts::add_response(Vector& impulse, Vector& to) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const int n = bodies_[b].size;
    const double* const L = inertia_factors_.data() + bodies_[b].factor;
    double* const x = impulse.data() + places_[b].first;
    for (int j = 0; j < n; ++j) {
      x[j] *= L[j * n + j];
      for (int i = j + 1; i < n; ++i) x[i] -= L[j * n + i] * x[j];
    }
    double* const u = to.data() + places_[b].first;
    for (int j = n; j-- > 0;) {
      for (int i = j + 1; i < n; ++i) x[j] -= L[j * n + i] * x[i];
      x[j] *= L[j * n + j];
      u[j] += x[j];
    }
  }
}

void HeldContacts::measure_scale() {
  scale_ = 0;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    double* const q = misses_.data() + contacts_[c].first;
    multiply(contacts_[c], v_, q);
    q[0] += offset(c);
    for (int t = 0; t < contacts_[c].columns; ++t) scale_ = std::max(scale_, std::abs(q[t]));
  }
}

bool HeldContacts::held(const ContactProblem& contact, const Vector& v, const Vector& start) {
  if (start.size() != lcp_size(contact) || !start.allFinite()) return false;
  const double most = kSlip * v.lpNorm<Eigen::Infinity>();
  Index lambda = contact.nc() + cols(contact.D);
  bool presses = false;
  for (Index c = 0; c < contact.nc(); ++c) {
    presses = presses || start(c) > 0;
    if (contact.edges[at(c)] == 0) continue;
    if (start(c) > 0 && contact.mu(c) > 0 && !(start(lambda) <= most)) return false;
    ++lambda;
  }
  return presses;
}

/// The impulses of the last answer, and what it held.
void HeldContacts::take_start(const Vector& start) {
  const Index nc = contact_->nc();
  Index direction = nc;
  for (Index c = 0; c < nc; ++c) {
    const Columns& contact = contacts_[at(c)];
    double* const f = impulses_.data() + contact.first;
    const int edges = contact_->edges[at(c)];
    f[0] = start(c);
    for (int t = 0; t + 1 < contact.columns; ++t) f[1 + t] = start(direction + t) - start(direction + edges / 2 + t);
    held_[at(c)] = f[0] > 0 ? 1 : 0;
    direction += edges;
  }
}

/// Loaded contacts take more of a change than those that hardly press.
void HeldContacts::weigh() {
  double largest = 0;
  for (const Columns& contact : contacts_) largest = std::max(largest, impulses_[contact.first]);
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const double share = largest > 0 ? impulses_[contacts_[c].first] / largest : 1;
    load_[c] = held_[c] != 0 ? kStiffness * strength_[c] * std::max(share, kLeastLoad) : 0;
  }
}

/// Rows of a column of `body` between its own rows and those of `below`.
int HeldContacts::skip(int body, int below) const {
  std::size_t k = places_[at(body)].below;
  while (below_[k].body != below) ++k;
  return below_[k].skip;
}

/// Whether they touch the same bodies.
bool HeldContacts::are_alike(const Columns& a, const Columns& b) const {
  const auto is_same = [](const Part& x, const Part& y) { return x.body == y.body; };
  const auto begin = parts_.begin();
  return std::equal(begin + static_cast<std::ptrdiff_t>(a.parts), begin + static_cast<std::ptrdiff_t>(a.end_parts),
                    begin + static_cast<std::ptrdiff_t>(b.parts), begin + static_cast<std::ptrdiff_t>(b.end_parts),
                    is_same);
}

/// A W A' of contacts `first` to `end` - 1, which touch the same bodies.
void HeldContacts::add_to_matrix(std::size_t first, std::size_t end) {
  double* const values = matrix_.valuePtr();
  const Columns& all = contacts_[first];
  for (std::size_t q = all.parts; q < all.end_parts; ++q) {
    const int column_body = parts_[q].body;
    const int size = bodies_[at(column_body)].size;
    const int* const begin = matrix_.outerIndexPtr() + places_[at(column_body)].first;
    for (std::size_t p = all.parts; p < all.end_parts; ++p) {
      const int row_body = parts_[p].body;
      const bool is_own = p == q;
      if (!is_own && places_[at(row_body)].rank < places_[at(column_body)].rank) continue;
      const int gap = is_own ? 0 : skip(column_body, row_body);
      const int rows = bodies_[at(row_body)].size;
      std::fill_n(product_.data(), at(size) * at(rows), 0.0);
      with_size(rows, [&](auto vector) {
        for (std::size_t c = first; c < end; ++c) {
          if (held_[c] == 0) continue;
          const double* column = entries_.data() + contacts_[c].entries;
          for (int t = 0; t < contacts_[c].columns; ++t, column += all.rows) {
            const auto from = vector(column + parts_[p].row);
            double* to = product_.data();
            for (int j = 0; j < size; ++j, to += rows) vector(to) += load_[c] * column[parts_[q].row + j] * from;
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

/// Of G + A W A'.
bool HeldContacts::factor() {
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    int first = 0;
    for (std::size_t k = bodies_[b].block; first < bodies_[b].size; ++k) {
      const Matrix& block = block_of(*contact_, k);
      for (Index j = 0; j < block.cols(); ++j) {
        double* const to = matrix_.valuePtr() + matrix_.outerIndexPtr()[places_[b].first + first + j];
        for (Index i = j; i < block.rows(); ++i) to[i - j] = block(i, j);
      }
      first += static_cast<int>(block.rows());
    }
  }
  for (std::size_t c = 0; c < contacts_.size();) {
    const std::size_t first = c;
    while (++c < contacts_.size() && are_alike(contacts_[first], contacts_[c])) {
    }
    add_to_matrix(first, c);
  }
  return factors_->factor(matrix_);
}

/// u of the impulses.
void HeldContacts::respond() {
  impulse_.setZero(v_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Columns& contact = contacts_[c];
    const double* const f = impulses_.data() + contact.first;
    if (std::any_of(f, f + contact.columns, [](double x) { return x != 0; })) add_columns(contact, f, impulse_);
  }
  u_ = v_;
  add_response(impulse_, u_);
}

/// A'u + b of what is held. @returns the largest, relative to max|q|
double HeldContacts::miss() {
  respond();
  double largest = 0;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (held_[c] == 0) continue;
    const Columns& contact = contacts_[c];
    double* const w = misses_.data() + contact.first;
    multiply(contact, u_, w);
    w[0] += offset(c);
    for (int t = 0; t < contact.columns; ++t) largest = std::max(largest, std::abs(w[t]));
  }
  return largest / scale_;
}

/// f -= W (w - A'y) for (G + A W A') y = A W w, which changes u by - y. @returns the largest of the new w, relative to
/// max|q|, but for the rounding of the factors
double HeldContacts::improve() {
  step_.setZero(v_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (held_[c] == 0) continue;
    const double* const w = misses_.data() + contacts_[c].first;
    for (int t = 0; t < contacts_[c].columns; ++t) scaled_[at(t)] = load_[c] * w[t];
    add_columns(contacts_[c], scaled_.data(), step_);
  }
  factors_->solve(step_);
  double largest = 0;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (held_[c] == 0) continue;
    double* const w = misses_.data() + contacts_[c].first;
    double* const f = impulses_.data() + contacts_[c].first;
    multiply(contacts_[c], step_, scaled_.data());
    for (int t = 0; t < contacts_[c].columns; ++t) {
      w[t] -= scaled_[at(t)];
      f[t] -= load_[c] * w[t];
      largest = std::max(largest, std::abs(w[t]));
    }
  }
  return largest / scale_;
}

/// Steps until nothing held moves, or rounding is met. After the first the velocity is taken from the impulses again:
/// it was the largest, and the factors are not exact.
void HeldContacts::approach() {
  double now = miss();
  for (int step = 0; step < kMostSteps && now > kHeldStill; ++step) {
    const double before = now;
    now = improve();
    if (step == 0) now = miss();
    if (!(now <= kProgress * before)) return;
  }
}

/// Whether the impulses are in their cones and leave no contact held that moves, and no other within its clearance.
/// What is outside by rounding is brought back.
bool HeldContacts::is_confirmed() {
  double largest = 0;
  for (const Columns& contact : contacts_) largest = std::max(largest, impulses_[contact.first]);
  const double none = kNoImpulse * largest;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    double* const f = impulses_.data() + contacts_[c].first;
    if (f[0] < -none) return false;
    f[0] = std::max(f[0], 0.0);
    const double most = contact_->mu(static_cast<Index>(c)) * f[0];
    double friction = 0;
    for (int t = 1; t < contacts_[c].columns; ++t) friction += std::abs(f[t]);
    if (friction <= most) continue;
    if (!(friction <= most + none)) return false;
    for (int t = 1; t < contacts_[c].columns; ++t) f[t] *= most / friction;
  }
  if (!(miss() <= kLargestMiss)) return false;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (held_[c] == 0 && !(clearance(c) >= -kLargestMiss * scale_)) return false;
  }
  return true;
}

/// The least of (N + mu d)'u + b over the contact's directions d: where it is not negative, neither is w, and the
/// impulses that hold the others are those of least energy.
double HeldContacts::clearance(std::size_t contact) {
  multiply(contacts_[contact], u_, scaled_.data());
  double slip = 0;
  for (int t = 1; t < contacts_[contact].columns; ++t) slip = std::max(slip, std::abs(scaled_[at(t)]));
  return scaled_[0] + offset(contact) - contact_->mu(static_cast<Index>(contact)) * slip;
}

/// Lets go what pulls, and holds what approaches or slips without a load. @returns whether there was any
bool HeldContacts::change_guess() {
  double largest = 0;
  for (const Columns& contact : contacts_) largest = std::max(largest, impulses_[contact.first]);
  bool changes = false;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    double* const f = impulses_.data() + contacts_[c].first;
    const bool pulls = held_[c] != 0 && f[0] < -kNoImpulse * largest;
    const bool approaches = held_[c] == 0 && clearance(c) < -kLargestMiss * scale_;
    if (pulls) std::fill_n(f, contacts_[c].columns, 0.0);
    if (pulls || approaches) held_[c] = approaches ? 1 : 0;
    changes = changes || pulls || approaches;
  }
  return changes;
}

void HeldContacts::write(Answer& answer) const {
  answer.clear();
  answer.claim = Claim::kSolved;
  answer.z.resize(problem_->size());
  answer.z.setZero();
  Index direction = contact_->nc();
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const double* const f = impulses_.data() + contacts_[c].first;
    const int edges = contact_->edges[c];
    answer.z(static_cast<Index>(c)) = f[0];
    for (int t = 0; t + 1 < contacts_[c].columns; ++t) {
      answer.z(direction + t) = std::max(f[1 + t], 0.0);
      answer.z(direction + edges / 2 + t) = std::max(-f[1 + t], 0.0);
    }
    direction += edges;
  }
  answer.velocity.resize(contact_->ngc());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    answer.velocity.segment(bodies_[b].first, bodies_[b].size) = u_.segment(places_[b].first, bodies_[b].size);
  }
}

bool HeldContacts::solve(const Vector& start, double deadline_s, Answer& answer, Counters& work) {
  measure_scale();
  if (!is_definite_ || !(scale_ > 0 && scale_ <= std::numeric_limits<double>::max())) return false;
  take_start(start);
  for (int guess = 0; guess < kTries; ++guess) {
    weigh();
    ++work.factorizations;
    if (!factor()) return false;
    approach();
    if (!is_confirmed()) {
      if (!change_guess()) return false;
      continue;
    }
    write(answer);
    if (!has_test_) test_.load(*problem_, AnswerTest::Bodies::kOneByOne);
    if (!has_test_) test_.set_velocity(given_v_);
    has_test_ = true;
    return test_.settle(answer, deadline_s);
  }
  return false;
}

}  // namespace lcpbench
