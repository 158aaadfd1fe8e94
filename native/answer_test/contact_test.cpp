// No unit test: a part of AnswerTest.
#include "native/answer_test/contact_test.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <variant>

#include "core/entries.h"
#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRoundoff = 0x1p-53;
constexpr double kTrusted = 0.1;          ///< share of a block's least eigenvalue that rounding may take
constexpr double kSmallestSafe = 1e-280;  ///< sums of products above this lose nothing that counts to underflow
constexpr Index kLargeBlock = 8;          ///< from this order on the kernels are faster

/// largest := max(largest, x). NaN and infinity make it infinite, and it stays so.
void raise(double& largest, double x) {
  if (!(x <= largest)) largest = x < kInfinity ? x : kInfinity;
}

/// sum.add(row, value) for the nonzero entries of column `j` of [N D]. The sum stays in registers where it can.
template <class Sum>
void sum_column(const ContactProblem& contact, Index j, Sum& sum) {
  const bool is_normal = j < contact.nc();
  const Jacobian& J = is_normal ? contact.N : contact.D;
  const Index column = is_normal ? j : j - contact.nc();
  const auto* sparse = std::get_if<SparseMatrix>(&J);
  if (sparse == nullptr || !sparse->isCompressed()) {
    return for_each_entry(J, column, [&](Index i, double value) { sum.add(i, value); });
  }
  const double* const values = sparse->valuePtr();
  const int* const rows = sparse->innerIndexPtr();
  const int end = sparse->outerIndexPtr()[column + 1];
  Sum own = sum;
  for (int k = sparse->outerIndexPtr()[column]; k < end; ++k) {
    if (values[k] != 0) own.add(rows[k], values[k]);
  }
  sum = own;
}

/// Products of a column J_j of [N D] with v+, and of its magnitudes with the bounds, summed by sum_column().
template <class Coordinate>
struct SeenByColumn {
  const Coordinate* coordinates;
  double velocity = 0;  ///< J_j'v+
  double bound = 0;     ///< |J_j|' times bound
  double reach = 0;     ///< and times reach

  /// Adds the terms of coordinate `i`, where J_j is `value`, not zero.
  void add(Index i, double value) {
    const Coordinate& here = coordinates[i];
    const double size = std::abs(value);
    velocity += value * here.velocity;
    bound += size * here.bound;
    reach += size * here.reach;
  }
};

/// J_j'v, summed by sum_column().
struct VelocityOfColumn {
  const double* v;
  double velocity = 0, terms = 0, entries = 0;

  void add(Index i, double value) {
    velocity += value * v[i];
    terms += std::abs(value * v[i]);
    ++entries;
  }
};

/// An impulse along a column, and the magnitudes of its terms.
struct AddedImpulse {
  double impulse;
  double* to;
  double* terms;
  Index last = -1;

  void add(Index i, double value) {
    const double part = impulse * value;
    to[i] += part;
    terms[i] += std::abs(part);
    last = i;
  }
};

/// The same in more bits.
struct ExactImpulse {
  double impulse;
  long double* to;

  void add(Index i, double value) { to[i] += static_cast<long double>(value) * impulse; }
};

/// Whether a row is off by more than any answer may be, and by more than the rows before it.
template <class Island>
bool is_too_much(double off, const Island& island) {
  return off > island.certain && off > kClaimedResidual * island.scale;
}

/// residual / scale; infinity, so that nothing is claimed, where either is not finite.
double relative(double residual, double scale) {
  return scale <= DBL_MAX && residual < kInfinity ? residual / scale : kInfinity;
}

// Cholesky factors as the kernels of cholesky_engine.h store them: L by columns of n entries, with the inverse of each
// diagonal entry in its place. What stands above the diagonal is neither written nor read.

/// L of block = L L'. @returns whether the block is positive definite; if not, L means nothing
bool factor_block(const Matrix& block, double* L) {
  const Index n = block.rows();
  for (Index j = 0; j < n; ++j) {
    double* const column = L + j * n;
    std::copy(block.data() + j * n + j, block.data() + (j + 1) * n, column + j);
    for (Index k = 0; k < j; ++k) {
      const double* const before = L + k * n;
      for (Index i = j; i < n; ++i) column[i] -= before[i] * before[j];
    }
    if (!(column[j] > 0)) return false;
    column[j] = 1 / std::sqrt(column[j]);
    for (Index i = j + 1; i < n; ++i) column[i] *= column[j];
  }
  return true;
}

/// x := L^-1 x, for an x whose entries before `first` are zero.
void solve_lower(const double* L, Index n, double* x, Index first = 0) {
  for (Index i = first; i < n; ++i) {
    const double* const column = L + i * n;
    const double value = x[i] *= column[i];
    for (Index k = i + 1; k < n; ++k) x[k] -= column[k] * value;
  }
}

/// x := L'^-1 x
void solve_transposed(const double* L, Index n, double* x) {
  for (Index i = n; i-- > 0;) {
    const double* const column = L + i * n;
    double sum = x[i];
    for (Index k = i + 1; k < n; ++k) sum -= column[k] * x[k];
    x[i] = sum * column[i];
  }
}

}  // namespace

ContactTest::ContactTest() : kernels_(cholesky::engine(isa_level())) {}

void ContactTest::load(const ContactProblem& contact, const IslandNumbers* numbers) {
  contact_ = &contact;
  layout_ = contact_layout(contact);
  if (numbers != nullptr && !numbers->of_contact.empty()) {
    numbers_.of_contact = numbers->of_contact;
    numbers_.of_coordinate = numbers->of_coordinate;
    numbers_.count = numbers->count;
  } else {
    numbers_.find(contact);
  }
  scales_.reserve(static_cast<std::size_t>(numbers_.count));
  set_velocity(contact.v);
  blocks_.clear();
  is_factored_ = false;
  Index factors = 0, largest = 0;
  if (const auto* inverse = std::get_if<InverseInertia>(&contact.inertia)) {
    blocks_.push_back({.given = &inverse->Ginv, .is_inverse = true, .first = 0, .factor = 0});
  } else {
    for_each_matrix(contact.inertia, [&](const Matrix& G, Index first) {
      blocks_.push_back({.given = &G, .is_inverse = false, .first = first, .factor = factors});
      factors += G.size();
      largest = std::max(largest, G.rows());
    });
  }
  const auto take = [](auto& vector, Index size) { vector.resize(static_cast<std::size_t>(size)); };
  take(factors_, factors);
  take(part_, largest);
  if (largest >= kLargeBlock) {
    const Index stride = largest + cholesky::kMargin;
    take(dense_, stride * stride);
    take(work_, cholesky::work_size(largest));
  }
  take(impulse_, contact.ngc());
  take(terms_, contact.ngc());
  exact_.reserve(impulse_.size());
  take(coordinates_, contact.ngc());
  take(islands_, numbers_.count);
  const auto most = std::max_element(contact.edges.begin(), contact.edges.end());
  take(rows_, most == contact.edges.end() ? 0 : *most / 2);
}

/// In double, whose rounding is far below the share of it that counts.
void ContactTest::measure_scales() {
  scales_.assign(static_cast<std::size_t>(numbers_.count), {});
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index island = numbers_.of_contact[static_cast<std::size_t>(c)];
    if (island < 0) continue;
    ContactScale<double>& scale = scales_[static_cast<std::size_t>(island)];
    const auto add_row = [&](Index column) {
      VelocityOfColumn sum{v_.data()};
      sum_column(*contact_, column, sum);
      scale.add_row(sum.velocity, sum.terms, sum.entries);
      return sum.velocity;
    };
    scale.add_approach(add_row(c) + contact_->offset(c));
    const Index first = layout_.friction_begin[static_cast<std::size_t>(c)];
    const Index half = (layout_.friction_begin[static_cast<std::size_t>(c) + 1] - first) / 2;
    for (Index t = 0; t < half; ++t) add_row(layout_.friction_offset() + first + t);
  }
}

/// With a sharper bound where the first one is too large for a small residual.
contact_lemke::Residual ContactTest::complete(Vector& z) {
  if (scales_.empty()) measure_scales();
  if (!is_factored_) {
    for (Block& block : blocks_) block.is_inverse ? measure_inverse(block) : factor(block);
    is_factored_ = true;
  }
  exact_.clear();
  const contact_lemke::Residual residual = measure(z);
  if (residual.certain <= kClaimedResidual || !(residual.velocity <= kClaimedResidual)) return residual;
  sum_exactly(z);
  return measure(z);
}

contact_lemke::Residual ContactTest::measure(Vector& z) {
  add_impulses(z);
  const auto most_terms = static_cast<double>(64 + (z.array() != 0).count());
  for (const Block& block : blocks_) respond(block, most_terms);
  contact_lemke::Residual residual;
  for (Index c = 0; c < contact_->nc(); ++c) {
    const auto contact = static_cast<std::size_t>(c);
    const Index lambda = layout_.lambda[contact];
    if (numbers_.of_contact[contact] < 0) {
      if (lambda >= 0) z(layout_.lambda_offset() + lambda) = largest_creep(*contact_, layout_, c, z);
      if (contact_->offset(c) < 0) residual = {kInfinity, kInfinity};  // nothing moves it
      continue;
    }
    const Row row = row_of(c, beside_normal(*contact_, c, z(c)));
    offer(row, row.w, z(c), islands_[static_cast<std::size_t>(numbers_.of_contact[contact])]);
    if (lambda >= 0) measure_friction(c, row, z);
  }
  double rounding = 0;
  for (const Island& island : islands_) {
    const bool is_certain = island.is_known || !island.presses;
    rounding = std::max(rounding, is_certain ? relative(island.rounding, island.scale) : kInfinity);
    residual.velocity = std::max(residual.velocity, relative(island.worst, island.scale));
    residual.certain = std::max(residual.certain, is_certain ? relative(island.certain, island.scale) : kInfinity);
  }
  // Half, because M_jj is known only to within 20 %. Twice, because lambda has an error as large as that of its row.
  least_ = residual.velocity / 2 - 2 * rounding;
  return residual;
}

/// Reach, of the given G*.
void ContactTest::measure_inverse(Block& block) {
  block.is_known = true;
  for (Index i = 0; i < block.order(); ++i) {
    const double diagonal = (*block.given)(i, i);
    block.is_known = block.is_known && diagonal >= 0;
    coordinates_[static_cast<std::size_t>(i)].reach = std::sqrt(diagonal);
  }
}

/// L, and reach and root of the block's coordinates.
void ContactTest::factor(Block& block) {
  const Index n = block.order();
  const Matrix& given = *block.given;
  double* const L = factors_.data() + block.factor;
  double* const x = part_.data();
  const bool is_large = n >= kLargeBlock;
  const bool is_definite = is_large ? factor_by_kernels(given, L, x) : factor_block(given, L);
  double condition = 0;
  for (Index k = 0; is_definite && k < n; ++k) {
    Coordinate& here = coordinates_[static_cast<std::size_t>(block.first + k)];
    here.root = std::sqrt(given(k, k));
    if (is_large) {
      here.reach = x[k];
    } else {
      std::fill(x, x + n, 0.0);
      x[k] = 1;
      lcpbench::solve_lower(L, n, x, k);
      here.reach = std::sqrt(std::inner_product(x + k, x + n, x + k, 0.0));
    }
    condition += here.reach * here.root * here.reach * here.root;
  }
  block.is_known = is_definite && kRoundoff * static_cast<double>(n * (8 + 4 * n)) * condition < kTrusted;
}

/// L, and the lengths of the columns of its inverse. @returns false where the block is not definite
bool ContactTest::factor_by_kernels(const Matrix& given, double* L, double* reach) {
  const Index n = given.rows();
  const Index stride = n + cholesky::kMargin;
  cholesky::take_lower(given.data(), n, dense_.data(), stride);
  if (!kernels_.factor(dense_.data(), stride, n, n, work_.data())) return false;
  cholesky::keep_columns(dense_.data(), stride, n, n, L);
  kernels_.measure_inverse(L, n, reach, work_.data());
  return true;
}

/// x := L^-1 x
void ContactTest::solve_lower(const Block& block, double* x) const {
  const double* const L = factors_.data() + block.factor;
  const Index n = block.order();
  if (n >= kLargeBlock) return kernels_.solve_lower(L, n, n, x);
  lcpbench::solve_lower(L, n, x);
}

/// x := L'^-1 x
void ContactTest::solve_transposed(const Block& block, double* x) const {
  const double* const L = factors_.data() + block.factor;
  const Index n = block.order();
  if (n >= kLargeBlock) return kernels_.solve_transposed(L, n, n, x);
  lcpbench::solve_transposed(L, n, x);
}

void ContactTest::add_impulses(const Vector& z) {
  std::fill(impulse_.begin(), impulse_.end(), 0.0);
  std::fill(terms_.begin(), terms_.end(), 0.0);
  for (std::size_t k = 0; k < islands_.size(); ++k) {
    islands_[k] = {};
    islands_[k].scale = scales_[k].value();
  }
  for (Index j = 0; j < layout_.lambda_offset(); ++j) {
    if (z(j) == 0) continue;
    AddedImpulse added{.impulse = z(j), .to = impulse_.data(), .terms = terms_.data()};
    sum_column(*contact_, j, added);
    if (added.last < 0) continue;
    const Index island = numbers_.of_coordinate[static_cast<std::size_t>(added.last)];  // that of all its entries
    islands_[static_cast<std::size_t>(island)].presses = true;
  }
}

/// exact_: the impulses, in more bits.
void ContactTest::sum_exactly(const Vector& z) {
  exact_.assign(impulse_.size(), 0);
  for (Index j = 0; j < layout_.lambda_offset(); ++j) {
    if (z(j) == 0) continue;
    ExactImpulse added{.impulse = z(j), .to = exact_.data()};
    sum_column(*contact_, j, added);
  }
}

/// v+ of one block, and how far it may be off. @param terms_of_sum terms that an impulse on a coordinate sums up
void ContactTest::respond(const Block& block, double terms_of_sum) {
  const Index end = block.first + block.order();
  for (Index i = block.first; i < end; ++i) {
    const Index island = numbers_.of_coordinate[static_cast<std::size_t>(i)];
    const double terms = terms_[static_cast<std::size_t>(i)];
    const bool is_safe = block.is_known && (terms == 0 || terms > kSmallestSafe);
    if (island >= 0 && !is_safe) islands_[static_cast<std::size_t>(island)].is_known = false;
  }
  if (block.is_inverse) {
    multiply(block, kRoundoff * terms_of_sum);
  } else {
    solve(block, kRoundoff * terms_of_sum);
    if (!exact_.empty() && block.is_known) bound_by_residual(block, terms_of_sum);
  }
  const double dots = kRoundoff * static_cast<double>(4 + contact_->ngc());
  for (Index i = block.first; i < end; ++i) {
    Coordinate& here = coordinates_[static_cast<std::size_t>(i)];
    here.bound += dots * (std::abs(here.velocity) + std::abs(v_(i)));
    here.velocity += v_(i);
  }
}

/// G* times the impulses, and its error. Only what touches the block can put it off, of one island at a time.
void ContactTest::solve(const Block& block, double sums) {
  const auto n = static_cast<std::size_t>(block.order());
  const auto at = static_cast<std::size_t>(block.first);
  double* const x = part_.data();
  std::copy_n(impulse_.data() + at, n, x);
  solve_lower(block, x);
  solve_transposed(block, x);
  const auto island_of = [&](std::size_t i) {
    const Index k = numbers_.of_coordinate[at + i];
    return k < 0 ? nullptr : &islands_[static_cast<std::size_t>(k)];
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (Island* const island = island_of(i)) island->rounded = island->lost = island->moved = 0;
  }
  for (std::size_t i = 0; i < n; ++i) {
    Island* const island = island_of(i);
    if (island == nullptr) continue;
    const Coordinate& here = coordinates_[at + i];
    island->rounded += here.reach * terms_[at + i];
    island->lost += here.reach * here.root * static_cast<double>(8 + 4 * n);
    island->moved += here.root * std::abs(x[i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    Coordinate& here = coordinates_[at + i];
    const Island* const island = island_of(i);
    here.velocity = x[i];
    here.bound = island == nullptr ? 0.0
                                   : here.reach * (sums * island->rounded + kRoundoff * island->lost * island->moved);
  }
}

/// The same error by what the response c leaves: r = J f - G c, in more bits. c_i is off by no more than reach_i |r|_G*.
void ContactTest::bound_by_residual(const Block& block, double terms) {
  constexpr double kLongRoundoff = static_cast<double>(LDBL_EPSILON) / 2;
  constexpr double kRoom = 1.25;  // for reach and L, which are known to within kTrusted
  const Index n = block.order(), first = block.first;
  long double* const left = exact_.data() + first;
  double impulses = 0, scaled = 0, moved = 0;
  for (Index j = 0; j < n; ++j) {
    const Coordinate& here = coordinates_[static_cast<std::size_t>(first + j)];
    const double* const column = block.given->data() + j * n;
    for (Index i = 0; i < n; ++i) left[i] -= static_cast<long double>(column[i]) * here.velocity;
    impulses += here.reach * terms_[static_cast<std::size_t>(first + j)];
    scaled += here.reach * here.root;
    moved += here.root * std::abs(here.velocity);
  }
  double* const x = part_.data();
  std::copy_n(left, n, x);
  solve_lower(block, x);
  const double own = kLongRoundoff * (static_cast<double>(4 + n) + terms) * (impulses + scaled * moved);
  const double off = kRoom * (Eigen::Map<const Vector>(x, n).norm() + own);
  for (Index i = 0; i < n; ++i) {
    Coordinate& here = coordinates_[static_cast<std::size_t>(first + i)];
    here.bound = std::min(here.bound, here.reach * off);
  }
}

/// The same by the given G*.
void ContactTest::multiply(const Block& block, double sums) {
  const Index n = block.order();
  const double rounding = sums + kRoundoff * static_cast<double>(2 + 2 * n);
  for (Coordinate& here : coordinates_) here.velocity = here.bound = 0;
  for (Index j = 0; j < n; ++j) {
    const double impulse = impulse_[static_cast<std::size_t>(j)];
    const double terms = rounding * terms_[static_cast<std::size_t>(j)];
    if (!(terms != 0)) continue;
    const double* const column = block.given->data() + j * n;
    for (Index i = 0; i < n; ++i) {
      Coordinate& here = coordinates_[static_cast<std::size_t>(i)];
      here.velocity += column[i] * impulse;
      here.bound += std::abs(column[i]) * terms;
    }
  }
}

ContactTest::Row ContactTest::row_of(Index column, const Beside& beside) const {
  SeenByColumn<Coordinate> seen{.coordinates = coordinates_.data()};
  sum_column(*contact_, column, seen);
  Row row{.column = column,
          .w = seen.velocity + (beside.offset + beside.yields),
          .rounding = seen.bound + 4 * kRoundoff * (beside.terms + beside.terms_of_yields),
          .reach = seen.reach,
          .compliance = beside.compliance};
  if (row.compliance > 0) row.reach = std::sqrt(row.reach * row.reach + row.compliance);
  return row;
}

/// min(M_jj z_j, w) or more, of a row with z_j >= 0.
void ContactTest::offer(const Row& row, double w, double z, Island& island) {
  double pressure = row.reach * row.reach * z;
  const auto off = [&](double least) { return least < 0 ? -least : std::min(least, pressure); };
  if (z > 0 && is_too_much(off(w + row.rounding), island)) pressure = diagonal_of(row) * z;
  raise(island.worst, off(w));
  raise(island.certain, std::max(off(w + row.rounding), off(w - row.rounding)));
  raise(island.rounding, row.rounding);
  if (!(row.rounding <= row.rounding)) raise(island.certain, row.rounding);
}

void ContactTest::measure_friction(Index contact, const Row& normal, Vector& z) {
  const auto c = static_cast<std::size_t>(contact);
  Island& island = islands_[static_cast<std::size_t>(numbers_.of_contact[c])];
  const Index first = layout_.friction_offset() + layout_.friction_begin[c];
  const Index half = (layout_.friction_begin[c + 1] - layout_.friction_begin[c]) / 2;
  const BesideFriction beside(*contact_, layout_, contact, z);
  double& lambda = z(layout_.lambda_offset() + layout_.lambda[c]);
  lambda = 0;
  for (Index t = 0; t < half; ++t) {
    Row& row = rows_[static_cast<std::size_t>(t)];
    row = row_of(first + t, beside.of(t));
    raise(lambda, std::abs(row.w));
  }
  if (!std::isfinite(lambda)) raise(island.certain, kInfinity);
  double unused = contact_->mu(contact) * z(contact);
  double terms = unused;
  for (Index t = 0; t < half; ++t) {
    const Row& row = rows_[static_cast<std::size_t>(t)];
    offer(row, lambda + row.w, z(first + t), island);
    offer(row, lambda - row.w, z(first + half + t), island);
    const double used = z(first + t) + z(first + half + t);
    unused -= used;
    terms += used;
  }
  const double rounding = terms * kRoundoff * static_cast<double>(2 + 4 * half);
  const double left = std::abs(unused) + rounding;
  double most = (1 + 2 * kTrusted) * normal.reach * normal.reach * left;
  if (is_too_much(std::min(lambda, most), island)) most = std::min(most, diagonal_of(normal) * left);
  raise(island.worst, unused > 0 && lambda < most ? lambda : most);
  raise(island.certain, unused > rounding && lambda < most ? lambda : most);
  raise(island.rounding, 2 * normal.reach * normal.reach * rounding);
}

/// A bound on M_jj of a row that may need one: Row::reach squared is many times as much where its blocks are
/// ill-conditioned. O(the squares of the orders of the blocks that the row touches)
double ContactTest::diagonal_of(const Row& row) {
  if (blocks_.size() == 1 && blocks_.front().is_inverse) return row.reach * row.reach;
  double square = 0;
  const Block* block = nullptr;
  double* const x = part_.data();
  const auto finish_block = [&] {
    if (block == nullptr) return;
    solve_lower(*block, x);
    square += Eigen::Map<const Vector>(x, block->order()).squaredNorm();
  };
  const bool is_normal = row.column < contact_->nc();
  const Index column = is_normal ? row.column : row.column - contact_->nc();
  for_each_entry(is_normal ? contact_->N : contact_->D, column, [&](Index i, double value) {
    const bool goes_back = block != nullptr && i < block->first;
    if (goes_back) square = kInfinity;  // unsorted entries give no bound here
    if (block == nullptr || goes_back || i >= block->first + block->order()) {
      finish_block();
      block = &*std::prev(std::upper_bound(blocks_.begin(), blocks_.end(), i,
                                           [](Index at, const Block& next) { return at < next.first; }));
      std::fill_n(x, block->order(), 0.0);
    }
    x[i - block->first] += value;
  });
  finish_block();
  return std::min(row.reach * row.reach, (1 + 2 * kTrusted) * square + row.compliance);
}

}  // namespace lcpbench
