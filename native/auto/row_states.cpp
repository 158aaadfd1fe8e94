#include "native/auto/row_states.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/compliance.h"
#include "core/entries.h"

namespace lcpbench {
namespace {

/// What is left of a row after elimination, over its largest entry, that counts as nothing: the row is redundant.
constexpr double kRedundant = 1e-11;

/// An impulse between bounds may pass one by this share of its own size and the bound's: rounding of its equations.
constexpr double kRounding = 1e-12;

/// Rows whose bound is reached by this share of their velocity begin between bounds: contacts may help to hold them.
constexpr double kLikelyHeld = 0.5;

Vector times(const Jacobian& J, const Vector& x) {
  return std::visit([&](const auto& matrix) { return Vector(matrix * x); }, J);
}

Vector transposed_times(const Jacobian& J, const Vector& x) {
  return std::visit([&](const auto& matrix) { return Vector(matrix.transpose() * x); }, J);
}

}  // namespace

bool RowStates::takes(const ContactProblem& problem) {
  const bool has_blocks = std::holds_alternative<BlockInertia>(problem.inertia);
  if (!has_blocks && !std::holds_alternative<DenseInertia>(problem.inertia)) return false;
  const std::vector<int>& of = problem.rows.bounds.friction_of;
  if (std::any_of(of.begin(), of.end(), [](int load) { return load >= 0; })) return false;
  if (!has_blocks) return problem.ngc() <= kMostCoordinates;
  RowStates all;  // rows between bounds connect no more than all rows
  all.load_blocks(problem);
  all.states_.assign(static_cast<std::size_t>(problem.rows.size()), State::kBetween);
  all.group_coordinates();
  return std::all_of(all.groups_.begin(), all.groups_.end(), [](const Group& group) {
    return std::ssize(group.coordinates) <= kMostCoordinates;
  });
}

void RowStates::load_blocks(const ContactProblem& problem) {
  problem_ = &problem;
  begins_.clear();
  block_of_.resize(static_cast<std::size_t>(problem.ngc()));
  for_each_matrix(problem.inertia, [&](const Matrix& G, Index first) {
    std::fill_n(block_of_.begin() + first, G.rows(), static_cast<Index>(begins_.size()));
    begins_.push_back(first);
  });
}

void RowStates::load(const ContactProblem& problem) {
  load_blocks(problem);
  const BoundedRows& rows = problem.rows;
  // M_ii = sum over the blocks of G of |L^-1 R_i|^2.
  diagonal_ = Vector::Zero(rows.size());
  std::vector<std::vector<Index>> rows_of(begins_.size());
  for (Index i = 0; i < rows.size(); ++i) {
    for_each_entry(rows.R, i, [&](Index j, double) {
      std::vector<Index>& list = rows_of[static_cast<std::size_t>(block_of_[static_cast<std::size_t>(j)])];
      if (list.empty() || list.back() != i) list.push_back(i);
    });
  }
  for_each_matrix(problem.inertia, [&](const Matrix& G, Index first) {
    const auto block = static_cast<std::size_t>(block_of_[static_cast<std::size_t>(first)]);
    if (rows_of[block].empty()) return;
    Matrix R = Matrix::Zero(G.rows(), std::ssize(rows_of[block]));
    for (Index k = 0; k < R.cols(); ++k) {
      for_each_entry(rows.R, rows_of[block][static_cast<std::size_t>(k)], [&](Index j, double entry) {
        if (j >= first && j < first + G.rows()) R(j - first, k) = entry;
      });
    }
    const Eigen::LLT<Matrix> llt(G);
    llt.matrixL().solveInPlace(R);
    for (Index k = 0; k < R.cols(); ++k) diagonal_(rows_of[block][static_cast<std::size_t>(k)]) += R.col(k).squaredNorm();
  });
}

void RowStates::guess(const Vector* z) {
  const BoundedRows& rows = problem_->rows;
  states_.assign(static_cast<std::size_t>(rows.size()), State::kBetween);
  const Vector w = transposed_times(rows.R, problem_->v);
  for (Index i = 0; i < rows.size(); ++i) {
    State& state = states_[static_cast<std::size_t>(i)];
    const double lower = rows.bounds.lower(i), upper = rows.bounds.upper(i);
    if (z != nullptr) {
      const double f = (*z)(z->size() - rows.size() + i);
      if (f <= lower) state = State::kLower;
      if (f >= upper) state = State::kUpper;
      continue;
    }
    const double velocity = w(i) + rows.offset(i), own = diagonal_(i) + rows.yields(i);
    if (velocity > 0 && kLikelyHeld * velocity > -lower * own) state = State::kLower;
    if (velocity < 0 && kLikelyHeld * velocity < -upper * own) state = State::kUpper;
  }
}

double RowStates::bound(Index row) const {
  const LcpBounds& bounds = problem_->rows.bounds;
  const State state = states_[static_cast<std::size_t>(row)];
  return state == State::kLower ? bounds.lower(row) : state == State::kUpper ? bounds.upper(row) : 0;
}

/// groups_: the blocks of G, joined where a row between bounds has entries in several.
void RowStates::group_coordinates() {
  const BoundedRows& rows = problem_->rows;
  std::vector<Index> parent(begins_.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto find = [&](Index block) {
    while (parent[static_cast<std::size_t>(block)] != block) block = parent[static_cast<std::size_t>(block)];
    return block;
  };
  std::vector<Index> block_of_row(static_cast<std::size_t>(rows.size()), -1);
  for (Index i = 0; i < rows.size(); ++i) {
    if (states_[static_cast<std::size_t>(i)] != State::kBetween) continue;
    Index& own = block_of_row[static_cast<std::size_t>(i)];
    for_each_entry(rows.R, i, [&](Index j, double) {
      const Index other = find(block_of_[static_cast<std::size_t>(j)]);
      if (own < 0) own = other;
      const Index root = find(own);
      parent[static_cast<std::size_t>(std::max(root, other))] = std::min(root, other);
    });
  }
  std::vector<Index> group_of_block(begins_.size(), -1);
  groups_.clear();
  group_of_.resize(block_of_.size());
  place_in_.resize(block_of_.size());
  for (std::size_t j = 0; j < block_of_.size(); ++j) {
    Index& group = group_of_block[static_cast<std::size_t>(find(block_of_[j]))];
    if (group < 0) {
      group = std::ssize(groups_);
      groups_.emplace_back();
    }
    group_of_[j] = group;
    std::vector<Index>& coordinates = groups_[static_cast<std::size_t>(group)].coordinates;
    place_in_[j] = std::ssize(coordinates);
    coordinates.push_back(static_cast<Index>(j));
  }
  for (Index i = 0; i < rows.size(); ++i) {
    const Index block = block_of_row[static_cast<std::size_t>(i)];
    if (block < 0) continue;
    groups_[static_cast<std::size_t>(group_of_block[static_cast<std::size_t>(find(block))])].rows.push_back(i);
  }
}

bool RowStates::reduce() {
  const BoundedRows& rows = problem_->rows;
  group_coordinates();
  momentum_.setZero(problem_->ngc());
  for_each_matrix(problem_->inertia, [&](const Matrix& G, Index first) {
    momentum_.segment(first, G.rows()).noalias() = G * problem_->v.segment(first, G.rows());
  });
  for (Index i = 0; i < rows.size(); ++i) {
    const double f = bound(i);
    if (f != 0) for_each_entry(rows.R, i, [&](Index j, double entry) { momentum_(j) += entry * f; });
  }
  for (Group& group : groups_) {
    const auto size = std::ssize(group.coordinates);
    group.A = Matrix::Zero(size, size);
    group.momentum = momentum_(group.coordinates);
  }
  for_each_matrix(problem_->inertia, [&](const Matrix& G, Index first) {
    const auto at = static_cast<std::size_t>(first);
    groups_[static_cast<std::size_t>(group_of_[at])].A.block(place_in_[at], place_in_[at], G.rows(), G.cols()) = G;
  });
  Index next = 0;
  for (Group& group : groups_) {
    if (!eliminate(group)) return false;
    group.first = next;
    next += std::ssize(group.free);
  }
  if (!reduce_contacts()) return false;
  return contacts_.v.allFinite() && contacts_.b.allFinite() && contacts_.offset_t.allFinite();
}

/// Gauss-Jordan elimination with the largest entry of each row for its pivot. Rows that yield add to the inertia.
bool RowStates::eliminate(Group& group) {
  const BoundedRows& rows = problem_->rows;
  const auto size = std::ssize(group.coordinates);
  std::vector<Index> hard;
  for (const Index row : group.rows) {
    const double r = rows.yields(row);
    if (r == 0) {
      hard.push_back(row);
      continue;
    }
    Vector column = Vector::Zero(size);
    for_each_entry(rows.R, row, [&](Index j, double entry) { column(place_in_[static_cast<std::size_t>(j)]) = entry; });
    group.A.noalias() += (column / r) * column.transpose();
    group.momentum -= column * (rows.offset(row) / r);
  }
  const auto count = std::ssize(hard);
  if (count == 0) {
    group.free.resize(group.coordinates.size());
    std::iota(group.free.begin(), group.free.end(), Index{0});
    group.T.resize(0, size);
    group.constant.resize(0);
    return true;
  }
  Matrix E = Matrix::Zero(count, size + 1);  // E velocity = its last column
  for (Index k = 0; k < count; ++k) {
    const Index row = hard[static_cast<std::size_t>(k)];
    for_each_entry(rows.R, row, [&](Index j, double entry) { E(k, place_in_[static_cast<std::size_t>(j)]) = entry; });
    E(k, size) = -rows.offset(row);
  }
  std::vector<char> is_pivot(static_cast<std::size_t>(size), 0);
  std::vector<Index> kept;  // rows of E
  const Vector whole = E.leftCols(size).cwiseAbs().rowwise().maxCoeff();
  const double fastest = E.col(size).cwiseAbs().maxCoeff();
  for (Index k = 0; k < count; ++k) {
    Index pivot = 0;
    const double largest = E.row(k).head(size).cwiseAbs().maxCoeff(&pivot);
    if (!(largest > kRedundant * whole(k))) {
      if (!(std::abs(E(k, size)) <= kRedundant * fastest)) return false;
      continue;
    }
    E.row(k) /= E(k, pivot);
    for (Index other = 0; other < count; ++other) {
      const double factor = E(other, pivot);
      if (other != k && factor != 0) E.row(other) -= factor * E.row(k);
      if (other != k) E(other, pivot) = 0;
    }
    is_pivot[static_cast<std::size_t>(pivot)] = 1;
    kept.push_back(k);
    group.pivots.push_back(pivot);
    group.equations.push_back(hard[static_cast<std::size_t>(k)]);
  }
  for (Index j = 0; j < size; ++j) {
    if (is_pivot[static_cast<std::size_t>(j)] == 0) group.free.push_back(j);
  }
  group.T = -E(kept, group.free);
  group.constant = E(kept, Eigen::all).col(size);
  return true;
}

/// Z'J, dense or sparse as J is.
Jacobian RowStates::reduced(const Jacobian& J, Index coordinates) const {
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    Matrix result(coordinates, dense->cols());
    std::vector<Index> free, pivots;
    const auto in_all = [](const Group& group, const std::vector<Index>& places, std::vector<Index>& all) {
      all.clear();
      for (const Index place : places) all.push_back(group.coordinates[static_cast<std::size_t>(place)]);
    };
    for (const Group& group : groups_) {
      in_all(group, group.free, free);
      auto part = result.middleRows(group.first, std::ssize(free));
      part = (*dense)(free, Eigen::all);
      if (group.T.isZero(0)) continue;
      in_all(group, group.pivots, pivots);
      part.noalias() += group.T.transpose() * Matrix((*dense)(pivots, Eigen::all));
    }
    return result;
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (Index column = 0; column < cols(J); ++column) {
    for_each_entry(J, column, [&](Index j, double entry) {
      const auto at = static_cast<std::size_t>(j);
      const Group& group = groups_[static_cast<std::size_t>(group_of_[at])];
      const auto free = std::lower_bound(group.free.begin(), group.free.end(), place_in_[at]);
      if (free != group.free.end() && *free == place_in_[at]) {
        entries.emplace_back(group.first + (free - group.free.begin()), column, entry);
        return;
      }
      const auto pivot = std::find(group.pivots.begin(), group.pivots.end(), place_in_[at]) - group.pivots.begin();
      for (Index k = 0; k < group.T.cols(); ++k) {
        if (group.T(pivot, k) != 0) entries.emplace_back(group.first + k, column, entry * group.T(pivot, k));
      }
    });
  }
  SparseMatrix matrix(coordinates, cols(J));
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// The velocity of a group is Z y + (0, constant), Z = (1, T) over its free coordinates and its pivots.
bool RowStates::reduce_contacts() {
  const ContactProblem& problem = *problem_;
  Index count = 0;
  for (const Group& group : groups_) count += std::ssize(group.free);
  BlockInertia inertia;
  contacts_.v.resize(count);
  Vector constant = Vector::Zero(problem.ngc());
  bool is_moved = false;
  for (Group& group : groups_) {
    Matrix A = group.A(group.free, group.free);
    Vector momentum = group.momentum(group.free);
    if (!group.pivots.empty()) {
      const Vector rest = group.momentum - group.A(Eigen::all, group.pivots) * group.constant;
      momentum = rest(group.free) + group.T.transpose() * rest(group.pivots);
      const Matrix coupled = group.A(group.free, group.pivots) * group.T;
      const Matrix of_pivots = group.A(group.pivots, group.pivots);
      A += coupled + coupled.transpose() + group.T.transpose() * of_pivots * group.T;
      A = ((A + A.transpose()) / 2).eval();
      for (std::size_t k = 0; k < group.pivots.size(); ++k) {
        const double speed = group.constant(static_cast<Index>(k));
        constant(group.coordinates[static_cast<std::size_t>(group.pivots[k])]) = speed;
        is_moved = is_moved || speed != 0;
      }
    }
    if (A.rows() == 0) continue;
    group.reduced.compute(A);
    contacts_.v.segment(group.first, A.rows()) = group.reduced.solve(momentum);
    inertia.blocks.push_back(std::move(A));
  }
  contacts_.N = reduced(problem.N, count);
  contacts_.D = reduced(problem.D, count);
  contacts_.edges = problem.edges;
  contacts_.mu = problem.mu;
  contacts_.b = problem.b;
  contacts_.compliance_n = problem.compliance_n;
  contacts_.compliance_t = problem.compliance_t;
  contacts_.offset_t = problem.offset_t;
  if (inertia.blocks.size() == 1) {
    contacts_.inertia = DenseInertia{std::move(inertia.blocks.front())};
  } else {
    contacts_.inertia = std::move(inertia);
  }
  return !is_moved || add_offsets(constant);
}

/// Rows between bounds that ask for a velocity move the contacts: that of the pivots becomes their offset.
/// @returns false where one becomes negative: there may be no solution, which takes the methods long to find out
bool RowStates::add_offsets(const Vector& velocity) {
  const Index nc = problem_->nc();
  if (contacts_.b.size() == 0) contacts_.b = Vector::Zero(nc);
  const Vector approach = transposed_times(problem_->N, velocity);
  contacts_.b += approach;
  if ((approach.array() < 0 && contacts_.b.array() < 0).any()) return false;
  if (cols(problem_->D) == 0) return true;
  if (contacts_.offset_t.size() == 0) contacts_.offset_t = Vector::Zero(2 * nc);
  const Vector slip = transposed_times(problem_->D, velocity);
  Index direction = 0;
  for (Index c = 0; c < nc; ++c) {
    const Index edges = problem_->edges[static_cast<std::size_t>(c)];
    if (edges > 0) contacts_.offset_t(2 * c) += slip(direction);
    if (edges > 2) contacts_.offset_t(2 * c + 1) += slip(direction + edges / 4);
    direction += edges;
  }
  return true;
}

Vector RowStates::velocity_after(const Vector& z_of_contacts) const {
  const Index nc = problem_->nc();
  Vector change = times(contacts_.N, z_of_contacts.head(nc));
  if (problem_->frictional()) change += times(contacts_.D, z_of_contacts.segment(nc, cols(contacts_.D)));
  for (const Group& group : groups_) {
    auto part = change.segment(group.first, std::ssize(group.free));
    if (part.size() > 0) group.reduced.solveInPlace(part);
  }
  return contacts_.v + change;
}

bool RowStates::settle(const Vector& z_of_contacts, const Vector& velocity_of_contacts) {
  const ContactProblem& problem = *problem_;
  z_.resize(lcp_size(problem));
  z_.head(z_of_contacts.size()) = z_of_contacts;
  velocity_.resize(problem.ngc());
  for (const Group& group : groups_) {
    const Vector free = velocity_of_contacts.segment(group.first, std::ssize(group.free));
    const Vector pivots = group.T * free + group.constant;
    for (std::size_t k = 0; k < group.free.size(); ++k) {
      velocity_(group.coordinates[static_cast<std::size_t>(group.free[k])]) = free(static_cast<Index>(k));
    }
    for (std::size_t k = 0; k < group.pivots.size(); ++k) {
      velocity_(group.coordinates[static_cast<std::size_t>(group.pivots[k])]) = pivots(static_cast<Index>(k));
    }
  }
  impulse_ = times(problem.N, z_.head(problem.nc()));
  if (problem.frictional()) impulse_ += times(problem.D, z_.segment(problem.nc(), cols(problem.D)));
  find_impulses();
  bool right = true;
  for (Index i = 0; i < problem.rows.size(); ++i) {
    State state = states_[static_cast<std::size_t>(i)];
    if (!is_wrong(i, state)) continue;
    right = false;
    states_[static_cast<std::size_t>(i)] = state;
  }
  return right;
}

/// f_R: of rows between bounds what the momentum of their pivots misses.
void RowStates::find_impulses() {
  const BoundedRows& rows = problem_->rows;
  auto f = z_.tail(rows.size());
  f.setZero();
  for (Index i = 0; i < rows.size(); ++i) f(i) = bound(i);
  for (const Group& group : groups_) {
    for (const Index row : group.rows) {
      const double r = rows.yields(row);
      if (r > 0) f(row) = -(dot_column(rows.R, row, velocity_) + rows.offset(row)) / r;
    }
    if (group.equations.empty()) continue;
    const Vector missing = group.A * velocity_(group.coordinates) - group.momentum - impulse_(group.coordinates);
    const auto count = std::ssize(group.equations);
    Matrix at_pivots = Matrix::Zero(count, count);  // pivots x equations
    std::vector<Index> place(group.coordinates.size(), -1);
    for (Index k = 0; k < count; ++k) place[static_cast<std::size_t>(group.pivots[static_cast<std::size_t>(k)])] = k;
    for (Index k = 0; k < count; ++k) {
      for_each_entry(rows.R, group.equations[static_cast<std::size_t>(k)], [&](Index j, double entry) {
        const Index pivot = place[static_cast<std::size_t>(place_in_[static_cast<std::size_t>(j)])];
        if (pivot >= 0) at_pivots(pivot, k) = entry;
      });
    }
    const Vector impulses = at_pivots.isDiagonal(0) ? Vector(missing(group.pivots).cwiseQuotient(at_pivots.diagonal()))
                                                    : Vector(at_pivots.partialPivLu().solve(missing(group.pivots)));
    for (Index k = 0; k < count; ++k) f(group.equations[static_cast<std::size_t>(k)]) = impulses(k);
  }
}

/// @param state  the row's own; becomes the one that the sign of its impulse, or of its velocity, asks for
bool RowStates::is_wrong(Index row, State& state) const {
  const BoundedRows& rows = problem_->rows;
  const double f = z_(z_.size() - rows.size() + row);
  const double lower = rows.bounds.lower(row), upper = rows.bounds.upper(row);
  if (state == State::kBetween) {
    const double rounding = kRounding * std::abs(f);
    if (f >= lower - rounding && f <= upper + rounding) return false;
    state = f < lower ? State::kLower : State::kUpper;
    return true;
  }
  const double w = dot_column(rows.R, row, velocity_) + rows.offset(row) + rows.yields(row) * f;
  const double rounding = kRounding * (std::abs(rows.offset(row)) + std::abs(dot_column(rows.R, row, problem_->v)));
  const bool holds = state == State::kLower ? w >= -rounding : w <= rounding;
  state = State::kBetween;
  return !holds;
}

bool RowStates::holds() const {
  constexpr double kLeastResidual = 2.5e-13;  // m/s: half of what is claimed of the least scale
  constexpr double kImbalance = 1e-12;
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const ContactProblem& problem = *problem_;
  const BoundedRows& rows = problem.rows;
  const Vector f = z_.tail(rows.size());
  // G (v+ - v) = J f, entry by entry beside its terms.
  Vector imbalance = times(rows.R, f) + impulse_, terms = Vector::Zero(problem.ngc());
  const auto add_terms = [&](const Jacobian& J, Index first) {
    for (Index column = 0; column < cols(J); ++column) {
      const double impulse = std::abs(z_(first + column));
      if (impulse != 0) for_each_entry(J, column, [&](Index j, double entry) { terms(j) += std::abs(entry) * impulse; });
    }
  };
  add_terms(problem.N, 0);
  add_terms(problem.D, problem.nc());
  add_terms(rows.R, z_.size() - rows.size());
  for_each_matrix(problem.inertia, [&](const Matrix& G, Index first) {
    const Vector change = velocity_.segment(first, G.rows()) - problem.v.segment(first, G.rows());
    imbalance.segment(first, G.rows()).noalias() -= G * change;
    terms.segment(first, G.rows()).noalias() += G.cwiseAbs() * change.cwiseAbs();
  });
  if (!(imbalance.cwiseAbs().array() <= kImbalance * terms.array()).all()) return false;
  const ContactLayout layout = contact_layout(problem);
  const auto passes = [](double impulse, double w) { return impulse > 0 ? std::abs(w) <= kLeastResidual : w >= -kLeastResidual; };
  const SoftRows<double> soft(problem, layout);
  for (Index c = 0; c < problem.nc(); ++c) {
    const double f_N = z_(c);
    if (f_N < 0) return false;
    if (!passes(f_N, dot_column(problem.N, c, velocity_) + problem.offset(c) + problem.normal_compliance(c) * f_N)) return false;
    const Index lambda = layout.lambda[static_cast<std::size_t>(c)];
    if (lambda < 0) continue;
    const auto yielding = soft.yielding(c, [&](Index i) { return z_(i); });
    const auto offset = soft.offset(c);
    double slack = problem.mu(c) * f_N;
    const Index first = layout.friction_begin[static_cast<std::size_t>(c)];
    const double slip = z_(layout.lambda_offset() + lambda);
    for (Index t = first; t < layout.friction_begin[static_cast<std::size_t>(c) + 1]; ++t) {
      const double f_D = z_(layout.friction_offset() + t);
      slack -= f_D;
      double w = dot_column(problem.D, t, velocity_) + slip;
      if (problem.is_soft()) w += soft.along(c, t - first, offset) + soft.along(c, t - first, yielding);
      if (f_D < 0 || !passes(f_D, w)) return false;
    }
    const double rounding = 8 * kEpsilon * problem.mu(c) * f_N;
    if (slip < 0 || (slip <= kLeastResidual ? slack < -rounding : std::abs(slack) > rounding)) return false;
  }
  // A row's velocity is right to the rounding of its terms, which count as nothing in any scale, whatever its lever.
  for (Index i = 0; i < rows.size(); ++i) {
    double w = rows.offset(i) + rows.yields(i) * f(i), size = std::abs(w) + std::abs(rows.offset(i)), entries = 1;
    for_each_entry(rows.R, i, [&](Index j, double entry) {
      w += entry * velocity_(j);
      size += std::abs(entry) * (std::abs(problem.v(j)) + std::abs(velocity_(j)));
      ++entries;
    });
    const double rounding = 2 * entries * kEpsilon * size;
    const double lower = rows.bounds.lower(i), upper = rows.bounds.upper(i);
    if (!(f(i) >= lower && f(i) <= upper)) return false;
    if (w > rounding && f(i) > lower) return false;
    if (w < -rounding && f(i) < upper) return false;
  }
  return true;
}

}  // namespace lcpbench
