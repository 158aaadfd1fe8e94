#include "native/sor/contact_blocks.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <variant>

namespace lcpbench {
namespace {

constexpr Index kBody = 6;   // coordinates of a body in space
constexpr Index kPoint = 3;  // of a sphere without friction, in an island that leaves out what nothing turns

}  // namespace

void project_on_cross_polytope(double* y, Index size, double radius) {
  double sum = 0;
  for (Index i = 0; i < size; ++i) sum += std::abs(y[i]);
  if (sum <= radius) return;
  double threshold = 0;
  for (Index step = 0; step < size; ++step) {
    sum = 0;
    Index kept = 0;
    for (Index i = 0; i < size; ++i) {
      if (!(std::abs(y[i]) > threshold)) continue;
      sum += std::abs(y[i]);
      ++kept;
    }
    if (kept == 0) break;
    const double next = (sum - radius) / static_cast<double>(kept);
    if (!(next > threshold)) break;
    threshold = next;
  }
  for (Index i = 0; i < size; ++i) y[i] = std::copysign(std::max(std::abs(y[i]) - threshold, 0.0), y[i]);
}

void ContactBlocks::load(const Inertia& inertia, const ContactImpulses& state) {
  contacts_.clear();
  runs_.clear();
  values_.clear();
  responses_.clear();
  contacts_.reserve(static_cast<std::size_t>(state.contacts));
  if (!factor(inertia)) roots_.clear();
  Index rows = 0;
  Index most_rows = 1;
  for (Index contact = 0; contact < state.contacts; ++contact) {
    const Index number = state.friction_of[static_cast<std::size_t>(contact)];
    const bool slides = number >= 0 && state.mu(contact) > 0;
    const SignedFriction* friction = slides ? &state.frictions[static_cast<std::size_t>(number)] : nullptr;
    Contact block{.first_row = rows,
                  .rows = friction == nullptr ? 1 : 1 + friction->directions,
                  .run = runs_.size(),
                  .value = values_.size(),
                  .column = friction == nullptr ? 0 : friction->first_column,
                  .mu = state.mu(contact)};
    find_runs(state, friction, block);
    add_values(state, friction, block);
    contacts_.push_back(block);
    rows += block.rows;
    most_rows = std::max(most_rows, block.rows);
  }
  impulses.setZero(rows);
  curvature.setZero(rows);
  coupling_.setZero(rows);
  velocities_.resize(most_rows);
  steps_.resize(most_rows);
  for (Contact& block : contacts_) find_curvature(state, block);
  velocity.resize(state.u0.size());
}

/// @returns false where the columns have to be stored twice
bool ContactBlocks::factor(const Inertia& inertia) {
  roots_.clear();
  root_of_.clear();
  const auto* blocks = std::get_if<BlockInertia>(&inertia);
  if (blocks == nullptr) return false;
  for (const Matrix& block : blocks->blocks) {
    root_of_.insert(root_of_.end(), static_cast<std::size_t>(block.rows()), static_cast<Index>(roots_.size()));
    const Eigen::LLT<Matrix> factors(block);
    if (factors.info() != Eigen::Success) return false;
    roots_.push_back(factors.matrixL());
  }
  return true;
}

/// What any row of the contact touches.
void ContactBlocks::find_runs(const ContactImpulses& state, const SignedFriction* friction, Contact& block) {
  const auto contact = static_cast<Index>(contacts_.size());
  for (Index row = 0; row < block.rows; ++row) {
    state.columns.J.for_each_run(row == 0 ? contact : friction->first_column + row - 1,
                                 [&](Index first, Index size, const double*) {
                                   const auto is_this = [first](const Run& run) { return run.first == first; };
                                   const auto begin = runs_.begin() + static_cast<std::ptrdiff_t>(block.run);
                                   if (std::any_of(begin, runs_.end(), is_this)) return;
                                   runs_.push_back({first, size});
                                 });
  }
  block.runs = runs_.size() - block.run;
  const auto begin = runs_.begin() + static_cast<std::ptrdiff_t>(block.run);
  const Index size = block.runs == 0 ? 0 : begin->size;
  const bool is_size_of_all = std::all_of(begin, runs_.end(), [size](const Run& run) { return run.size == size; });
  block.run_size = is_size_of_all ? size : 0;
}

void ContactBlocks::add_values(const ContactImpulses& state, const SignedFriction* friction, Contact& block) {
  const auto contact = static_cast<Index>(contacts_.size());
  const auto add = [&](const PackedColumns& columns, std::vector<double>& to, Index column, const Run& run) {
    const std::size_t at = to.size();
    to.resize(at + static_cast<std::size_t>(run.size), 0.0);
    columns.for_each_run(column, [&](Index first, Index size, const double* entries) {
      if (first == run.first) std::copy(entries, entries + size, to.data() + at);
    });
    return at;
  };
  for (std::size_t r = block.run; r < runs_.size(); ++r) {
    for (Index row = 0; row < block.rows; ++row) {
      const Index column = row == 0 ? contact : friction->first_column + row - 1;
      const std::size_t at = add(state.columns.J, values_, column, runs_[r]);
      if (roots_.empty()) {
        add(state.columns.response, responses_, column, runs_[r]);
      } else {
        whiten(runs_[r], values_.data() + at);
      }
    }
  }
}

/// part := L^-1 part.
void ContactBlocks::whiten(const Run& run, double* part) const {
  const Matrix& L = roots_[static_cast<std::size_t>(root_of_[static_cast<std::size_t>(run.first)])];
  for (Index i = 0; i < run.size; ++i) {
    for (Index k = 0; k < i; ++k) part[i] -= L(i, k) * part[k];
    part[i] /= L(i, i);
  }
}

/// M_ij of two rows of the contact.
double ContactBlocks::product(const Contact& block, Index i, Index j) const {
  const double* left = values_.data() + block.value;
  const double* right = (roots_.empty() ? responses_.data() : values_.data()) + block.value;
  double sum = 0;
  for (std::size_t r = block.run; r < block.run + block.runs; ++r) {
    const Index size = runs_[r].size;
    for (Index k = 0; k < size; ++k) sum += left[i * size + k] * right[j * size + k];
    left += block.rows * size;
    right += block.rows * size;
  }
  return sum;
}

void ContactBlocks::find_curvature(const ContactImpulses& state, Contact& block) {
  const Index contact = static_cast<Index>(&block - contacts_.data());
  curvature(block.first_row) = std::max(state.columns.diagonal(contact), 0.0);
  const Index directions = block.rows - 1;
  if (directions == 0 || state.columns.diagonal.segment(block.column, directions).isZero(0)) return;
  double largest = 0;
  if (directions == 2) {
    const double a = product(block, 1, 1), b = product(block, 1, 2), c = product(block, 2, 2);
    largest = (a + c) / 2 + std::hypot((a - c) / 2, b);
  } else {
    Matrix friction(directions, directions);
    for (Index i = 0; i < directions; ++i) {
      for (Index j = 0; j < directions; ++j) friction(i, j) = product(block, 1 + i, 1 + j);
    }
    largest = Eigen::SelfAdjointEigenSolver<Matrix>(friction, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
  }
  for (Index t = 1; t <= directions; ++t) {
    curvature(block.first_row + t) = std::max(largest, 0.0);
    coupling_(block.first_row + t) = product(block, t, 0);
  }
}

void ContactBlocks::take(const ContactImpulses& state) {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& block = contacts_[c];
    impulses(block.first_row) = state.impulse(static_cast<Index>(c));
    impulses.segment(block.first_row + 1, block.rows - 1) = state.impulse.segment(block.column, block.rows - 1);
  }
  offset_ = state.offset;
  velocity = state.u;
  Index first = 0;
  for (const Matrix& L : roots_) {
    for (Index i = 0; i < L.rows(); ++i) {  // entry i of L'u asks for later ones only
      double sum = 0;
      for (Index k = i; k < L.rows(); ++k) sum += L(k, i) * velocity(first + k);
      velocity(first + i) = sum;
    }
    first += L.rows();
  }
}

void ContactBlocks::write(ContactImpulses& state) const {
  state.impulse.setZero();
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& block = contacts_[c];
    state.impulse(static_cast<Index>(c)) = impulses(block.first_row);
    state.impulse.segment(block.column, block.rows - 1) = impulses.segment(block.first_row + 1, block.rows - 1);
  }
}

/// kRows, kSize: known to the compiler where not 0.
template <int kRows, int kSize>
double ContactBlocks::update(const Contact& block, double relaxation) {
  const Index rows = kRows > 0 ? kRows : block.rows;
  double fixed[kRows > 0 ? std::size_t{2} * kRows : 1];
  double* const w = kRows > 0 ? fixed : velocities_.data();
  double* const step = kRows > 0 ? fixed + kRows : steps_.data();
  std::fill(w, w + rows, 0.0);
  const Run* const runs = runs_.data() + block.run;
  const double* J = values_.data() + block.value;
  for (std::size_t r = 0; r < block.runs; ++r) {
    const Index size = kSize > 0 ? kSize : runs[r].size;
    const double* const u = velocity.data() + runs[r].first;
    for (Index row = 0; row < rows; ++row, J += size) {
      double sum = 0;
      for (Index k = 0; k < size; ++k) sum += J[k] * u[k];
      w[row] += sum;
    }
  }
  if (offset_.size() > 0) w[0] += offset_(static_cast<Index>(&block - contacts_.data()));

  double* const x = impulses.data() + block.first_row;
  const double* const bend = curvature.data() + block.first_row;
  double off = std::abs(std::min(w[0], bend[0] * x[0]));
  const double normal = bend[0] > 0 ? std::max(x[0] - relaxation * w[0] / bend[0], 0.0) : x[0];
  step[0] = normal - x[0];
  x[0] = normal;
  bool moves = step[0] != 0;
  if (rows > 1 && bend[1] > 0) {
    const double length = relaxation / bend[1];
    for (Index t = 1; t < rows; ++t) {
      w[t] += coupling_(block.first_row + t) * step[0];
      step[t] = x[t] - length * w[t];
    }
    project_on_cross_polytope(step + 1, rows - 1, block.mu * normal);
    for (Index t = 1; t < rows; ++t) {
      const double next = step[t];
      step[t] -= x[t];
      x[t] = next;
      moves = moves || step[t] != 0;
      off = max_or_infinity(off, std::abs(step[t]) / length);
    }
  } else {  // friction that moves nothing needs no impulse
    for (Index t = 1; t < rows; ++t) {
      step[t] = -x[t];
      x[t] = 0;
      moves = moves || step[t] != 0;
    }
  }
  if (!moves) return off;

  const double* response = (roots_.empty() ? responses_.data() : values_.data()) + block.value;
  for (std::size_t r = 0; r < block.runs; ++r) {
    const Index size = kSize > 0 ? kSize : runs[r].size;
    double* const u = velocity.data() + runs[r].first;
    for (Index row = 0; row < rows; ++row, response += size) {
      for (Index k = 0; k < size; ++k) u[k] += step[row] * response[k];
    }
  }
  return off;
}

double ContactBlocks::sweep(double relaxation, bool backwards) {
  const std::size_t count = contacts_.size();
  double off = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Contact& block = contacts_[backwards ? count - 1 - i : i];
    double own = 0;
    if (block.run_size == kBody && block.rows == 3) {
      own = update<3, kBody>(block, relaxation);
    } else if (block.run_size == kBody && block.rows == 1) {
      own = update<1, kBody>(block, relaxation);
    } else if (block.run_size == kPoint && block.rows == 1) {
      own = update<1, kPoint>(block, relaxation);
    } else {
      own = update<0, 0>(block, relaxation);
    }
    off = max_or_infinity(off, own);
  }
  return off;
}

}  // namespace lcpbench
