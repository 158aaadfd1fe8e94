#include "native/auto/sticking_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "core/entries.h"
#include "core/isa.h"
#include "native/velocity_ipm/assembly_tree.h"
#include "native/velocity_ipm/multifrontal.h"

namespace lcpbench {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

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

/// visit(block, first coordinate)
template <class Visit>
void for_each_block(const std::vector<const Matrix*>& blocks, Visit&& visit) {
  Index first = 0;
  for (const Matrix* block : blocks) {
    visit(*block, first);
    first += block->rows();
  }
}

}  // namespace

StickingSystem::StickingSystem() : kernels_(cholesky::engine(isa_level())), factors_(multifrontal_cholesky()) {}

void StickingSystem::load(const ContactProblem& contact) {
  contact_ = &contact;
  take_blocks();
  if (!has_last_sizes() || !fill_columns()) {
    find_columns();
    analyze();
    fill_columns();
  }
  has_inertia_factors_ = false;
  for_each_block(blocks_, [this](const Matrix& block, Index first) {
    inverse_diagonal_.segment(first, block.rows()) = block.diagonal().cwiseInverse();
  });
  strength_.clear();
  for (const StickingColumns& own : contacts_) {
    double response = 0;
    for (int k = 0; k < own.size; ++k) {
      const double entry = columns(own)[k];
      response += entry * entry * inverse_diagonal_(rows(own)[k]);
    }
    strength_.push_back(response > 0 ? 1 / response : 0);
  }
}

/// Lists the blocks of G; a dense G is one block. @pre the inertia is given in one of these two forms
void StickingSystem::take_blocks() {
  blocks_.clear();
  if (const auto* dense = std::get_if<DenseInertia>(&contact_->inertia)) {
    blocks_.push_back(&dense->G);
  } else {
    for (const Matrix& block : std::get<BlockInertia>(contact_->inertia).blocks) blocks_.push_back(&block);
  }
}

/// Whether there are as many blocks, of the same orders, and as many contacts, with as many columns each, as when the
/// columns were found: then fill_columns() stays within their room. @pre take_blocks()
bool StickingSystem::has_last_sizes() const {
  const auto is_as_long = [](const Matrix* block, Index size) { return block->rows() == size; };
  if (!std::equal(blocks_.begin(), blocks_.end(), block_sizes_.begin(), block_sizes_.end(), is_as_long)) return false;
  if (contacts_.size() != contact_->edges.size()) return false;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (contacts_[c].columns != 1 + directions_of(*contact_, static_cast<Index>(c))) return false;
  }
  return true;
}

/// The coordinates of each contact, and where its columns will stand.
void StickingSystem::find_columns() {
  block_sizes_.clear();
  block_of_.clear();
  std::vector<int> block_begin;
  for (const Matrix* block : blocks_) {
    block_begin.push_back(static_cast<int>(block_of_.size()));
    block_of_.insert(block_of_.end(), at(block->rows()), static_cast<int>(block_sizes_.size()));
    block_sizes_.push_back(block->rows());
  }
  contacts_.clear();
  rows_.clear();
  StickingColumns next;
  std::vector<int> touched, last_touched;
  Index direction = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    touched.clear();
    if (is_one()) {
      touched.push_back(0);
    } else {
      visit_contact(*contact_, c, direction, [&](int, Index row, double) {
        const int block = block_of_[at(row)];
        if (std::find(touched.begin(), touched.end(), block) == touched.end()) touched.push_back(block);
      });
      std::sort(touched.begin(), touched.end());
    }
    if (c == 0 || touched != last_touched) {
      next.places += at(next.size) * at(next.size + 1) / 2;  // of the contact before
      next.rows = rows_.size();
      for (const int block : touched) {
        for (int i = 0; i < block_sizes_[at(block)]; ++i) rows_.push_back(block_begin[at(block)] + i);
      }
      next.size = static_cast<int>(rows_.size() - next.rows);
    }
    next.columns = 1 + directions_of(*contact_, c);
    contacts_.push_back(next);
    next.entries += at(next.size) * at(next.columns);
    next.first += at(next.columns);
    direction += contact_->edges[at(c)];
    touched.swap(last_touched);
  }
}

/// The order of elimination, the pattern of the matrix, and where in it the blocks and the contacts add.
void StickingSystem::analyze() {
  const Index ngc = contact_->ngc();
  inertia_factors_.resize(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) inertia_factors_[b].resize(blocks_[b]->rows(), blocks_[b]->rows());
  inverse_diagonal_.resize(ngc);
  if (is_one()) {
    const std::size_t order = at(ngc), stride = order + cholesky::kMargin;
    dense_.resize(stride * stride);
    weighted_.assign(stride * column_count(), 0.0);
    work_.resize(at(cholesky::work_size(ngc)));
    dense_factors_.resize(order * order);
    return;
  }
  std::vector<std::pair<int, int>> pairs;  // of coordinates, the second not above the first
  const auto add_pairs = [&pairs](int size, const auto& row) {
    for (int j = 0; j < size; ++j) {
      for (int i = j; i < size; ++i) pairs.emplace_back(row(i), row(j));
    }
  };
  for_each_block(blocks_, [&](const Matrix& block, Index first) {
    add_pairs(static_cast<int>(block.rows()), [first](int i) { return static_cast<int>(first) + i; });
  });
  const std::size_t of_blocks = pairs.size();
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (shares_rows(c)) continue;
    add_pairs(contacts_[c].size, [&](int i) { return rows(contacts_[c])[i]; });
  }
  const auto pattern = [&](const auto& place) {
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [i, j] : pairs)
      entries.emplace_back(std::max(place(i), place(j)), std::min(place(i), place(j)), 1);
    SparseMatrix lower(ngc, ngc);
    lower.setFromTriplets(entries.begin(), entries.end());
    return lower;
  };
  const std::vector<int> order = elimination_order(pattern([](int i) { return i; }));
  order_.resize(at(ngc));
  for (std::size_t k = 0; k < order.size(); ++k) order_[at(order[k])] = static_cast<int>(k);
  matrix_ = pattern([this](int i) { return order_[at(i)]; });
  factors_->analyze(matrix_);
  inertia_places_.clear();
  places_.clear();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    (k < of_blocks ? inertia_places_ : places_).push_back(place_of(pairs[k].first, pairs[k].second));
  }
  int largest = 0;
  for (const StickingColumns& contact : contacts_) largest = std::max(largest, contact.size);
  product_.resize(at(largest) * at(largest));
  part_.resize(largest);
  ordered_.resize(ngc);
}

/// Of the entry for two coordinates, in the values of matrix_.
int StickingSystem::place_of(int i, int j) const {
  const auto [column, row] = std::minmax(order_[at(i)], order_[at(j)]);
  const int* const inner = matrix_.innerIndexPtr();
  const int* const outer = matrix_.outerIndexPtr();
  return static_cast<int>(std::lower_bound(inner + outer[column], inner + outer[column + 1], row) - inner);
}

/// @returns false where a contact touches a block that it did not touch when the columns were found
bool StickingSystem::fill_columns() {
  const StickingColumns last = contacts_.empty() ? StickingColumns{} : contacts_.back();
  entries_.assign(last.entries + at(last.size) * at(last.columns), 0.0);
  local_.assign(at(contact_->ngc()), -1);
  bool fits = true;
  Index direction = 0;
  for (std::size_t c = 0; c < contacts_.size() && fits; ++c) {
    const StickingColumns& contact = contacts_[c];
    const bool shares = shares_rows(c);
    if (c > 0 && !shares) {
      for (int k = 0; k < contacts_[c - 1].size; ++k) local_[at(rows(contacts_[c - 1])[k])] = -1;
    }
    for (int k = 0; k < contact.size && !shares; ++k) local_[at(rows(contact)[k])] = k;
    double* const to = entries_.data() + contact.entries;
    visit_contact(*contact_, static_cast<Index>(c), direction, [&](int column, Index row, double entry) {
      const int k = is_one() ? static_cast<int>(row) : local_[at(row)];
      fits = fits && k >= 0;
      if (k >= 0) to[column * contact.size + k] = entry;
    });
    direction += contact_->edges[c];
  }
  return fits;
}

/// With the contact before it.
bool StickingSystem::shares_rows(std::size_t contact) const {
  if (contact == 0) return false;
  const StickingColumns& before = contacts_[contact - 1];
  return before.rows == contacts_[contact].rows && before.size == contacts_[contact].size;
}

std::size_t StickingSystem::column_count() const {
  return contacts_.empty() ? 0 : contacts_.back().first + at(contacts_.back().columns);
}

void StickingSystem::multiply(const Vector& x, double* products) {
  if (is_one()) {
    const Eigen::Map<const Matrix> A(entries_.data(), x.size(), static_cast<Index>(column_count()));
    Eigen::Map<Vector>(products, A.cols()).noalias() = A.transpose() * x;
    return;
  }
  for (const StickingColumns& contact : contacts_) {
    for (int k = 0; k < contact.size; ++k) part_(k) = x(rows(contact)[k]);
    const double* column = columns(contact);
    for (int t = 0; t < contact.columns; ++t, column += contact.size) {
      *products++ = Eigen::Map<const Vector>(column, contact.size).dot(part_.head(contact.size));
    }
  }
}

void StickingSystem::add_columns(const double* factors, Vector& to) {
  if (is_one()) {
    const Eigen::Map<const Matrix> A(entries_.data(), to.size(), static_cast<Index>(column_count()));
    to.noalias() += A * Eigen::Map<const Vector>(factors, A.cols());
    return;
  }
  for (const StickingColumns& contact : contacts_) {
    const double* const own = factors + contact.first;
    if (std::all_of(own, own + contact.columns, [](double x) { return x == 0; })) continue;
    const double* column = columns(contact);
    part_.head(contact.size).setZero();
    for (int t = 0; t < contact.columns; ++t, column += contact.size) {
      part_.head(contact.size) += own[t] * Eigen::Map<const Vector>(column, contact.size);
    }
    for (int k = 0; k < contact.size; ++k) to(rows(contact)[k]) += part_(k);
  }
}

void StickingSystem::add_response(Vector& impulse, Vector& to) {
  std::size_t b = 0;
  for_each_block(blocks_, [&](const Matrix& block, Index first) {
    Matrix& L = inertia_factors_[b++];
    if (!has_inertia_factors_) {
      L = block;
      const Eigen::LLT<Eigen::Ref<Matrix>> in_place(L);
      if (in_place.info() != Eigen::Success) L.setConstant(std::numeric_limits<double>::quiet_NaN());  // passes no test
    }
    auto part = impulse.segment(first, block.rows());
    L.triangularView<Eigen::Lower>().solveInPlace(part);
    L.transpose().triangularView<Eigen::Upper>().solveInPlace(part);
    to.segment(first, block.rows()) += part;
  });
  has_inertia_factors_ = true;
}

void StickingSystem::subtract_inertia(const Vector& x, Vector& from) const {
  for_each_block(blocks_, [&](const Matrix& block, Index first) {
    from.segment(first, block.rows()).noalias() -= block * x.segment(first, block.rows());
  });
}

bool StickingSystem::factor_one(const std::vector<double>& weights) {
  const Index order = blocks_.front()->rows();
  const Index stride = order + cholesky::kMargin;
  cholesky::take_lower(blocks_.front()->data(), order, dense_.data(), stride);
  Index count = 0;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (weights[c] == 0) continue;
    const Eigen::Map<const Matrix> own(columns(contacts_[c]), order, contacts_[c].columns);
    Eigen::Map<Matrix, 0, Eigen::OuterStride<>>(weighted_.data() + count * stride, order, own.cols(),
                                                Eigen::OuterStride<>(stride)) = std::sqrt(weights[c]) * own;
    count += own.cols();
  }
  kernels_.add_product(dense_.data(), stride, weighted_.data(), stride, order, count, work_.data());
  if (!kernels_.factor(dense_.data(), stride, order, order, work_.data())) return false;
  cholesky::keep_columns(dense_.data(), stride, order, order, dense_factors_.data());
  return true;
}

bool StickingSystem::factor(const std::vector<double>& weights) {
  if (is_one()) return factor_one(weights);
  double* const values = matrix_.valuePtr();
  std::fill_n(values, matrix_.nonZeros(), 0.0);
  const int* place = inertia_places_.data();
  for (const Matrix* block : blocks_) {
    for (Index j = 0; j < block->cols(); ++j) {
      for (Index i = j; i < block->rows(); ++i) values[*place++] += (*block)(i, j);
    }
  }
  for (std::size_t c = 0; c < contacts_.size();) {
    const StickingColumns& first = contacts_[c];
    const int size = first.size;
    std::fill_n(product_.data(), size * size, 0.0);
    for (bool is_first = true; c < contacts_.size() && (is_first || shares_rows(c)); ++c, is_first = false) {
      const double* column = columns(contacts_[c]);
      for (int t = 0; t < contacts_[c].columns && weights[c] != 0; ++t, column += size) {
        for (int j = 0; j < size; ++j) {
          const double factor = weights[c] * column[j];
          double* const to = product_.data() + j * size;
          for (int i = j; i < size; ++i) to[i] += factor * column[i];
        }
      }
    }
    place = places_.data() + first.places;
    for (int j = 0; j < size; ++j) {
      for (int i = j; i < size; ++i) values[*place++] += product_[at(j * size + i)];
    }
  }
  return factors_->factor(matrix_);
}

void StickingSystem::solve(Vector& x) {
  if (is_one()) {
    kernels_.solve_lower(dense_factors_.data(), x.size(), x.size(), x.data());
    kernels_.solve_transposed(dense_factors_.data(), x.size(), x.size(), x.data());
    return;
  }
  for (std::size_t i = 0; i < order_.size(); ++i) ordered_(order_[i]) = x(static_cast<Index>(i));
  factors_->solve(ordered_);
  for (std::size_t i = 0; i < order_.size(); ++i) x(static_cast<Index>(i)) = ordered_(order_[i]);
}

}  // namespace lcpbench
