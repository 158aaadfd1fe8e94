#include "native/sor/contact_blocks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

namespace lcpbench {
namespace {

constexpr Index kBody = 6;   // coordinates of a body in space
constexpr Index kPoint = 3;  // of a body that nothing turns

// Work of an update, fitted to times of sweeps over 18 to 20,842 contacts, in units of 0.2 ns.
constexpr double kWorkOfContact = 36;
constexpr double kWorkOfGeneralEntry = 2;  // of rows that the compiler does not know the size of; else 1

template <int kSize>
using Values = Eigen::Map<const Eigen::Array<double, kSize, 1>>;

// By value, so that they are one instruction each: half of the branches in an update would be mispredicted.
inline double larger(double a, double b) { return a < b ? b : a; }
inline double smaller(double a, double b) { return b < a ? b : a; }

/// project_on_cross_polytope of two entries.
inline void project_on_square(double& y, double& z, double radius) {
  const double a = std::abs(y);
  const double b = std::abs(z);
  const double threshold = larger(larger((a + b - radius) / 2, larger(a, b) - radius), 0.0);
  y = std::copysign(larger(a - threshold, 0.0), y);
  z = std::copysign(larger(b - threshold, 0.0), z);
}

/// 1 / value, 0 for 0; small enough that an over-relaxed one is finite.
double inverse(double value) { return value > 0 ? std::min(1 / value, std::numeric_limits<double>::max() / 2) : 0.0; }

/// L of a block, by columns. @returns whether it is definite
bool factor_block(const Matrix& block, double* L) {
  const Index n = block.rows();
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) {
      double sum = block(i, j);
      for (Index k = 0; k < j; ++k) sum -= L[k * n + i] * L[k * n + j];
      L[j * n + i] = sum;
    }
    const double pivot = L[j * n + j];
    if (!(pivot > 0)) return false;
    for (Index i = j; i < n; ++i) L[j * n + i] /= std::sqrt(pivot);
  }
  return true;
}

/// x := L^-1 x
void solve_lower(const double* L, Index n, double* x) {
  for (Index i = 0; i < n; ++i) {
    x[i] /= L[i * n + i];
    for (Index k = i + 1; k < n; ++k) x[k] -= L[i * n + k] * x[i];
  }
}

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
  column_.clear();
  runs_.clear();
  values_.clear();
  responses_.clear();
  work_ = 0;
  contacts_.reserve(static_cast<std::size_t>(state.contacts));
  column_.reserve(static_cast<std::size_t>(state.contacts));
  if (!factor(inertia)) bodies_.clear();
  BlockInverse inverse;
  if (bodies_.empty() && state.columns.response.cols() == 0) inverse = BlockInverse(inertia);
  Index rows = 0;
  Index most_rows = 1;
  for (Index contact = 0; contact < state.contacts; ++contact) {
    const Index number = state.friction_of[static_cast<std::size_t>(contact)];
    const bool slides = number >= 0 && state.mu(contact) > 0;
    const SignedFriction* friction = slides ? &state.frictions[static_cast<std::size_t>(number)] : nullptr;
    Contact block{.first_row = rows,
                  .run = runs_.size(),
                  .value = values_.size(),
                  .mu = state.mu(contact),
                  .normal = 0,
                  .friction = 0,
                  .normal_inverse = 0,
                  .friction_inverse = 0,
                  .rows = friction == nullptr ? 1 : 1 + static_cast<int>(friction->directions),
                  .runs = 0,
                  .run_size = 0};
    column_.push_back(friction == nullptr ? 0 : friction->first_column);
    find_runs(state, contact, block);
    add_values(state.columns.J, contact, block, values_, [this](Index first, double* part) {
      if (bodies_.empty()) return;
      const Body& body = bodies_[body_of_[static_cast<std::size_t>(first)]];
      solve_lower(roots_.data() + body.root, body.size, part);
    });
    if (bodies_.empty()) add_responses(state, inverse, contact, block);
    const bool is_general = block.run_size != kBody && block.run_size != kPoint;
    const auto entries = static_cast<double>(values_.size() - block.value);
    work_ += kWorkOfContact + 2 * entries * (is_general ? kWorkOfGeneralEntry : 1);
    contacts_.push_back(block);
    rows += block.rows;
    most_rows = std::max<Index>(most_rows, block.rows);
  }
  impulses.setZero(rows);
  coupling_.setZero(rows);
  load_softness(state, rows);
  velocities_.resize(most_rows);
  steps_.resize(most_rows);
  for (Index contact = 0; contact < contacts(); ++contact) {
    find_curvature(state, contact, contacts_[static_cast<std::size_t>(contact)]);
  }
  offset_.resize(state.offset.size());
  velocity.resize(state.u0.size());
  errors.setZero(contacts());
}

void ContactBlocks::load_softness(const ContactImpulses& state, Index rows) {
  soft_.clear();
  if (state.compliance.size() == 0 && state.tangents.cols() == 0) return;
  tangents_.setZero(2, rows);
  soft_.resize(contacts_.size());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const auto contact = static_cast<Index>(c);
    if (state.compliance.size() > 0) soft_[c].normal = state.compliance(contact);
    if (state.compliance_t.size() > 0) soft_[c].tangential = state.compliance_t(contact);
    for (Index row = 1; state.tangents.cols() > 0 && row < contacts_[c].rows; ++row) {
      tangents_.col(contacts_[c].first_row + row) = state.tangents.col(column_of(contact, row));
    }
  }
}

/// @returns false where the columns have to be stored twice
bool ContactBlocks::factor(const Inertia& inertia) {
  bodies_.clear();
  roots_.clear();
  body_of_.clear();
  const auto* blocks = std::get_if<BlockInertia>(&inertia);
  if (blocks == nullptr) return false;
  Index first = 0;
  std::size_t values = 0;
  for (const Matrix& block : blocks->blocks) {
    body_of_.insert(body_of_.end(), static_cast<std::size_t>(block.rows()), bodies_.size());
    bodies_.push_back({first, block.rows(), values});
    first += block.rows();
    values += static_cast<std::size_t>(block.size());
  }
  roots_.resize(values);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!factor_block(blocks->blocks[b], roots_.data() + bodies_[b].root)) return false;
  }
  return true;
}

/// Appends the runs of coordinates that any row of the contact touches, in rising order. Of separate bodies, adjacent
/// blocks with at most six coordinates together become one run: as a rule a body's translation and rotation.
void ContactBlocks::find_runs(const ContactImpulses& state, Index contact, Contact& block) {
  const auto begin = static_cast<std::ptrdiff_t>(block.run);
  for (Index row = 0; row < block.rows; ++row) {
    state.columns.J.for_each_run(column_of(contact, row), [&](Index first, const PackedColumns::Entries& run) {
      const auto is_this = [first](const Run& other) { return other.first == first; };
      if (std::none_of(runs_.begin() + begin, runs_.end(), is_this)) runs_.push_back({first, run.size()});
    });
  }
  const auto by_first = [](const Run& a, const Run& b) { return a.first < b.first; };
  std::sort(runs_.begin() + begin, runs_.end(), by_first);
  const auto merges = [this](Run& run, const Run& next) {
    const bool meets = !bodies_.empty() && run.first + run.size == next.first && run.size + next.size <= kBody;
    if (meets) run.size += next.size;
    return meets;
  };
  std::size_t last = block.run;
  for (std::size_t r = block.run + 1; r < runs_.size(); ++r) {
    if (!merges(runs_[last], runs_[r])) runs_[++last] = runs_[r];
  }
  if (runs_.size() > block.run) runs_.resize(last + 1);
  block.runs = static_cast<int>(runs_.size() - block.run);
  const Index size = block.runs == 0 ? 0 : runs_[block.run].size;
  const auto has_size = [size](const Run& run) { return run.size == size; };
  block.run_size = std::all_of(runs_.begin() + begin, runs_.end(), has_size) ? static_cast<int>(size) : 0;
}

/// @param finish (first row, entries) of each run of a column
template <class Finish>
void ContactBlocks::add_values(const PackedColumns& columns, Index contact, const Contact& block,
                               std::vector<double>& to, const Finish& finish) const {
  if (block.runs == 0) return;  // `columns` may have no columns where there are no coordinates
  const std::size_t begin = to.size();
  Index size = 0;
  for (const Run& run : runs_of(block)) size += run.size;
  to.resize(begin + static_cast<std::size_t>(block.rows * size), 0.0);
  for (Index row = 0; row < block.rows; ++row) {
    columns.for_each_run(column_of(contact, row), [&](Index first, const PackedColumns::Entries& entries) {
      double* part = to.data() + begin;
      for (const Run& run : runs_of(block)) {
        if (first < run.first + run.size) {
          part += row * run.size + first - run.first;
          break;
        }
        part += block.rows * run.size;
      }
      std::copy_n(entries.data(), entries.size(), part);
      finish(first, part);
    });
  }
}

/// @param inverse of the inertia, where the columns of the state have no response
void ContactBlocks::add_responses(const ContactImpulses& state, const BlockInverse& inverse, Index contact,
                                  const Contact& block) {
  if (inverse.dimension() == 0) {
    return add_values(state.columns.response, contact, block, responses_, [](Index, double*) {});
  }
  add_values(state.columns.J, contact, block, responses_, [&inverse](Index first, double* part) {
    const Matrix& body = inverse.inverse(inverse.block_of(first));
    Eigen::Map<Vector> entries(part, body.rows());
    entries = body * entries;  // Eigen takes a temporary
  });
}

/// M_ij of two rows of the contact, of which one at most is its normal.
double ContactBlocks::product(const Contact& block, Index i, Index j) const {
  const double* left = values_.data() + block.value;
  const double* right = (bodies_.empty() ? responses_.data() : values_.data()) + block.value;
  double sum = 0;
  for (const Run& run : runs_of(block)) {
    const Index size = run.size;
    for (Index k = 0; k < size; ++k) sum += left[i * size + k] * right[j * size + k];
    left += block.rows * size;
    right += block.rows * size;
  }
  if (soft_.empty()) return sum;
  const auto contact = static_cast<std::size_t>(&block - contacts_.data());
  return sum + soft_[contact].tangential * tangents_.col(block.first_row + i).dot(tangents_.col(block.first_row + j));
}

void ContactBlocks::find_curvature(const ContactImpulses& state, Index contact, Contact& block) {
  block.normal = std::max(state.columns.diagonal(contact), 0.0);
  block.normal_inverse = inverse(block.normal);
  const Index directions = block.rows - 1;
  if (directions == 0 || state.columns.diagonal.segment(column_of(contact, 1), directions).isZero(0)) return;
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
  block.friction = std::max(largest, 0.0);
  block.friction_inverse = inverse(block.friction);
  for (Index t = 1; t <= directions; ++t) {
    coupling_(block.first_row + t) = product(block, t, 0);
  }
}

void ContactBlocks::take(const ContactImpulses& state) {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& block = contacts_[c];
    impulses(block.first_row) = state.impulse(static_cast<Index>(c));
    impulses.segment(block.first_row + 1, block.rows - 1) = state.impulse.segment(column_[c], block.rows - 1);
  }
  offset_ = state.offset;
  for (std::size_t c = 0; c < soft_.size() && state.offset_t.size() > 0; ++c) {
    soft_[c].offset = state.offset_t.segment<2>(2 * static_cast<Index>(c));
  }
  velocity = state.u;
  for (const Body& body : bodies_) {
    const double* L = roots_.data() + body.root;
    for (Index i = 0; i < body.size; ++i, L += body.size) {  // entry i of L'u asks for later ones only
      double sum = 0;
      for (Index k = i; k < body.size; ++k) sum += L[k] * velocity(body.first + k);
      velocity(body.first + i) = sum;
    }
  }
}

void ContactBlocks::project() {
  for (const Contact& block : contacts_) {
    double* const x = impulses.data() + block.first_row;
    x[0] = std::max(x[0], 0.0);
    project_on_cross_polytope(x + 1, block.rows - 1, block.mu * x[0]);
  }
}

void ContactBlocks::write(ContactImpulses& state) const {
  state.impulse.setZero();
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& block = contacts_[c];
    state.impulse(static_cast<Index>(c)) = impulses(block.first_row);
    state.impulse.segment(column_[c], block.rows - 1) = impulses.segment(block.first_row + 1, block.rows - 1);
  }
}

/// w := the velocities of the contact's rows. kRows, kSize: known to the compiler where not 0.
template <int kRows, int kSize>
[[gnu::always_inline]] inline void ContactBlocks::find_velocities(const Contact& block, double* w) const {
  const double* J = values_.data() + block.value;
  if constexpr (kRows > 0 && kSize % 2 == 0 && kSize > 0) {
    std::array<Eigen::Array2d, std::size_t{kRows}> sums;
    for (Eigen::Array2d& sum : sums) sum.setZero();
    for (const Run& run : runs_of(block)) {
      const double* const u = velocity.data() + run.first;
      for (int row = 0; row < kRows; ++row, J += kSize) {
        for (int k = 0; k < kSize; k += 2) sums[static_cast<std::size_t>(row)] += Values<2>(J + k) * Values<2>(u + k);
      }
    }
    for (int row = 0; row < kRows; ++row) w[row] = sums[static_cast<std::size_t>(row)].sum();
  } else {
    const Index rows = kRows > 0 ? kRows : block.rows;
    std::fill_n(w, rows, 0.0);
    for (const Run& run : runs_of(block)) {
      const Index size = kSize > 0 ? kSize : run.size;
      const double* const u = velocity.data() + run.first;
      for (Index row = 0; row < rows; ++row, J += size) {
        for (Index k = 0; k < size; ++k) w[row] += J[k] * u[k];
      }
    }
  }
}

/// Adds the tangential offsets, and what the contact yields.
void ContactBlocks::add_softness(const Contact& block, Index contact, double* w) const {
  const Softness& soft = softness(contact);
  const double* const x = impulses.data() + block.first_row;
  w[0] += soft.normal * x[0];
  Eigen::Vector2d net(0, 0);
  for (Index t = 1; t < block.rows; ++t) net += x[t] * tangents_.col(block.first_row + t);
  const Eigen::Vector2d beside = soft.offset + soft.tangential * net;
  for (Index t = 1; t < block.rows; ++t) w[t] += tangents_.col(block.first_row + t).dot(beside);
}

/// What the steps of the contact's impulses change.
template <int kRows, int kSize>
[[gnu::always_inline]] inline void ContactBlocks::add_steps(const Contact& block, const double* step) {
  const double* response = (bodies_.empty() ? responses_.data() : values_.data()) + block.value;
  for (const Run& run : runs_of(block)) {
    double* const u = velocity.data() + run.first;
    if constexpr (kRows > 0 && kSize > 0) {
      Eigen::Array<double, kSize, 1> sum = Values<kSize>(u);
      for (int row = 0; row < kRows; ++row, response += kSize) sum += step[row] * Values<kSize>(response);
      Eigen::Map<Eigen::Array<double, kSize, 1>>{u} = sum;
    } else {
      for (Index row = 0; row < block.rows; ++row, response += run.size) {
        for (Index k = 0; k < run.size; ++k) u[k] += step[row] * response[k];
      }
    }
  }
}

void ContactBlocks::add(Index contact, const double* steps) {
  const Contact& block = of(contact);
  for (Index row = 0; row < block.rows; ++row) impulses(block.first_row + row) += steps[row];
  add_steps<0, 0>(block, steps);
}

template <bool kSoft, int kRows, int kSize>
void ContactBlocks::update(const Contact& block, Index contact, double relaxation, Step& sum) {
  const Index rows = kRows > 0 ? kRows : block.rows;
  double fixed[kRows > 0 ? std::size_t{2} * kRows : 1];
  double* const w = kRows > 0 ? fixed : velocities_.data();
  double* const step = kRows > 0 ? fixed + kRows : steps_.data();
  find_velocities<kRows, kSize>(block, w);
  if (offset_.size() > 0) w[0] += offset_(contact);
  if constexpr (kSoft) add_softness(block, contact, w);

  double* const x = impulses.data() + block.first_row;
  double off = std::abs(smaller(w[0], block.normal * x[0]));
  const double normal = larger(x[0] - relaxation * block.normal_inverse * w[0], 0.0);
  step[0] = normal - x[0];
  x[0] = normal;
  bool moves = step[0] != 0;
  sum.size += block.normal * step[0] * step[0];
  if (rows > 1 && block.friction > 0) {
    const double length = relaxation * block.friction_inverse;
    const double* const coupling = coupling_.data() + block.first_row;
    for (Index t = 1; t < rows; ++t) step[t] = x[t] - length * (w[t] + coupling[t] * step[0]);
    if (rows == 3) {
      project_on_square(step[1], step[2], block.mu * normal);
    } else {
      project_on_cross_polytope(step + 1, rows - 1, block.mu * normal);
    }
    double largest = 0;
    double squares = 0;
    for (Index t = 1; t < rows; ++t) {
      const double next = step[t];
      step[t] -= x[t];
      x[t] = next;
      moves = moves || step[t] != 0;
      largest = larger(largest, std::abs(step[t]));
      squares += step[t] * step[t];
    }
    off = larger(off, largest / length);
    sum.size += block.friction * squares;
  } else {  // friction that moves nothing needs no impulse
    for (Index t = 1; t < rows; ++t) {
      step[t] = -x[t];
      x[t] = 0;
      moves = moves || step[t] != 0;
    }
  }
  if (kRows > 0 || moves) add_steps<kRows, kSize>(block, step);
  errors(contact) = off;
  sum.off = larger(sum.off, off);
}

template <bool kSoft>
void ContactBlocks::update(Index contact, double relaxation, Step& sum) {
  const Contact& block = of(contact);
  if (block.run_size == kBody && block.rows == 3) {
    update<kSoft, 3, kBody>(block, contact, relaxation, sum);
  } else if (block.run_size == kBody && block.rows == 1) {
    update<kSoft, 1, kBody>(block, contact, relaxation, sum);
  } else if (block.run_size == kPoint && block.rows == 1) {
    update<kSoft, 1, kPoint>(block, contact, relaxation, sum);
  } else {
    update<kSoft, 0, 0>(block, contact, relaxation, sum);
  }
}

/// larger() forgets what is not a number, a sum does not.
ContactBlocks::Step ContactBlocks::checked(const Step& sum) {
  return {std::isnan(sum.size) ? std::numeric_limits<double>::infinity() : sum.off, sum.size};
}

ContactBlocks::Step ContactBlocks::sweep(double relaxation) {
  Step sum;
  if (is_soft()) {
    for (Index i = 0; i < contacts(); ++i) update<true>(i, relaxation, sum);
  } else {
    for (Index i = 0; i < contacts(); ++i) update<false>(i, relaxation, sum);
  }
  return checked(sum);
}

ContactBlocks::Step ContactBlocks::sweep(std::span<const Index> contacts, double relaxation) {
  Step sum;
  if (is_soft()) {
    for (const Index contact : contacts) update<true>(contact, relaxation, sum);
  } else {
    for (const Index contact : contacts) update<false>(contact, relaxation, sum);
  }
  return checked(sum);
}

}  // namespace lcpbench
