// No unit test: the part of AnswerTest for separate bodies.
#include "native/answer_test/bodies_test.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <iterator>
#include <limits>
#include <variant>

#include "core/entries.h"
#include "native/answer_test/beside_rows.h"
#include "native/answer_test/small_blocks.h"
#include "native/proofs/doubtful_inertia.h"
#include "native/proofs/scaled_numbers.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTrusted = 0.1;           ///< share of a block's least eigenvalue that rounding may take
constexpr double kSmallestSafe = 1e-280;   ///< sums of products above this lose nothing that counts to underflow
constexpr Index kLargeBlock = 8;           ///< from this order on the kernels for double are faster

/// Of 113 bits, fitted to times of piles, walls and blocks of 2 to 20 coordinates, in units of 0.2 ns: for each entry
/// of [N D], for each coordinate, and for the cube of each block's order.
constexpr double kWorkOfEntry = 560, kWorkOfCoordinate = 6000, kWorkOfCube = 100;

/// largest := max(largest, x). NaN and infinity make it infinite, and it stays so.
template <class Scalar>
void raise(Scalar& largest, Scalar x) {
  if (!(x <= largest)) largest = x < static_cast<Scalar>(kInfinity) ? x : static_cast<Scalar>(kInfinity);
}

Index nonzeros(const Matrix& J) { return (J.array() != 0).count(); }
Index nonzeros(const SparseMatrix& J) { return J.nonZeros(); }

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
template <class Scalar>
struct SeenByColumn {
  const Scalar* coordinates;  ///< those of BodiesTest::Room: v+, bound and reach of each
  Scalar velocity = 0;        ///< J_j'v+
  Scalar bound = 0;           ///< |J_j|' times bound
  Scalar reach = 0;           ///< and times reach

  /// Adds the terms of coordinate `i`, where J_j is `value`, not zero.
  void add(Index i, double value) {
    const Scalar* const here = coordinates + 3 * i;
    const Scalar size = static_cast<Scalar>(std::abs(value));
    velocity += static_cast<Scalar>(value) * here[0];
    bound += size * here[1];
    reach += size * here[2];
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
template <class Scalar>
struct AddedImpulse {
  Scalar impulse;
  Scalar* to;
  Scalar* terms;
  Index last = -1;

  void add(Index i, double value) {
    const Scalar part = impulse * static_cast<Scalar>(value);
    to[i] += part;
    terms[i] += magnitude(part);
    last = i;
  }
};

template <class Scalar, class Room>
auto row_of(const ContactProblem& contact, Index j, const Beside<Scalar>& beside, const Room& room) {
  SeenByColumn<Scalar> seen{.coordinates = room.coordinates.data()};
  sum_column(contact, j, seen);
  typename Room::Row row{.column = j,
                         .w = seen.velocity,
                         .rounding = seen.bound,
                         .reach = seen.reach,
                         .compliance = beside.compliance};
  row.w += beside.offset + beside.yields;
  row.rounding += static_cast<Scalar>(4 * room.roundoff) * (beside.terms + beside.terms_of_yields);
  if (beside.compliance > 0) row.reach = root_of(row.reach * row.reach + beside.compliance);
  return row;
}

/// Whether a row is off by more than any answer may be, and by more than the rows before it.
template <class Scalar, class Island>
bool is_too_much(Scalar off, const Island& island) {
  return off > island.certain && off > static_cast<Scalar>(kClaimedResidual) * island.scale;
}

/// residual / scale; infinity, so that nothing is claimed, where either is not finite.
template <class Scalar>
double relative(Scalar residual, Scalar scale) {
  const bool are_finite = scale <= static_cast<Scalar>(DBL_MAX) && residual < static_cast<Scalar>(kInfinity);
  return are_finite ? static_cast<double>(residual / scale) : kInfinity;
}

}  // namespace

template <class Scalar>
void BodiesTest::Room<Scalar>::reserve(const Sizes& sizes) {
  for_each_vector(sizes, [](auto& vector, Index size) { vector.reserve(static_cast<std::size_t>(size)); });
}

template <class Scalar>
void BodiesTest::Room<Scalar>::resize(const Sizes& sizes) {
  for_each_vector(sizes, [](auto& vector, Index size) { vector.resize(static_cast<std::size_t>(size)); });
}

template <class Scalar>
template <class Visit>
void BodiesTest::Room<Scalar>::for_each_vector(const Sizes& sizes, Visit&& visit) {
  for (std::vector<Scalar>* by_coordinate : {&impulse, &terms, &u, &bound, &reach, &root}) {
    visit(*by_coordinate, sizes.ngc);
  }
  visit(coordinates, 3 * sizes.ngc);
  visit(factors, sizes.factors);
  visit(inverse, 4 * sizes.largest_block);
  if (sizeof(Scalar) == sizeof(double) && sizes.largest_block >= kLargeBlock) {
    const Index stride = sizes.largest_block + cholesky::kMargin;
    visit(dense, stride * stride);
    visit(work, cholesky::work_size(sizes.largest_block));
  }
  visit(islands, sizes.islands);
  visit(rows, sizes.most_directions);
}

BodiesTest::BodiesTest() : kernels_(cholesky::engine(isa_level())) {}

void BodiesTest::load(const ContactProblem& contact, const IslandNumbers* numbers) {
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
  sizes_ = {.ngc = contact.ngc(), .islands = numbers_.count};
  places_.clear();
  double cubes = 0;  // of the blocks' orders
  Index first = 0;
  for (const Matrix& block : std::get<BlockInertia>(contact.inertia).blocks) {
    places_.push_back({.first = first, .factor = sizes_.factors, .order = block.rows()});
    first += block.rows();
    sizes_.factors += block.size();
    sizes_.largest_block = std::max(sizes_.largest_block, block.rows());
    cubes += static_cast<double>(block.size() * block.rows());
  }
  work_in_quad_ = kWorkOfCoordinate * static_cast<double>(sizes_.ngc) + kWorkOfCube * cubes;
  for (const Jacobian* J : {&contact.N, &contact.D}) {
    const Index entries = std::visit([](const auto& matrix) { return nonzeros(matrix); }, *J);
    work_in_quad_ += kWorkOfEntry * static_cast<double>(entries);
  }
  for (const int edges : contact.edges) sizes_.most_directions = std::max<Index>(sizes_.most_directions, edges / 2);
  double_.roundoff = 0x1p-53;
  double_.reserve(sizes_);
  quad_.roundoff = kQuadUnitRoundoff;
  quad_.reserve(sizes_);
}

/// In double, whose rounding is far below the share of it that counts.
void BodiesTest::measure_scales() {
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

/// As respond_block(), but L has the inverse of each diagonal entry in its place. @returns false, with L, reach and x
/// unchanged, where the block is not definite
bool BodiesTest::respond_by_kernels(const Matrix& block, double* L, double* reach, double* x,
                                    Room<double>& room) const {
  const Index n = block.rows();
  const Index stride = n + cholesky::kMargin;
  cholesky::take_lower(block.data(), n, room.dense.data(), stride);
  if (!kernels_.factor(room.dense.data(), stride, n, n, room.work.data())) return false;
  cholesky::keep_columns(room.dense.data(), stride, n, n, L);
  kernels_.measure_inverse(L, n, reach, room.work.data());
  kernels_.solve_lower(L, n, n, x);
  kernels_.solve_transposed(L, n, n, x);
  return true;
}

/// u of one block for its impulse, and its reach. @returns whether it is definite
template <class Scalar>
bool BodiesTest::factor_and_respond(const Matrix& block, const Place& place, Room<Scalar>& room) const {
  const Index n = place.order;
  Scalar* const L = room.factors.data() + place.factor;
  Scalar* const x = room.u.data() + place.first;
  Scalar* const reach = room.reach.data() + place.first;
  if constexpr (sizeof(Scalar) == sizeof(double)) {
    if (n >= kLargeBlock && respond_by_kernels(block, L, reach, x, room)) return true;
  }
  const auto respond_sized = n == 3   ? respond_block<3, Scalar>
                             : n == 6 ? respond_block<6, Scalar>
                                      : respond_block<0, Scalar>;
  return respond_sized(block, L, room.inverse.data(), reach, x);
}

/// A bound on M_jj of a row that may need one: Row::reach squared is many times as much where its blocks are
/// ill-conditioned. O(the squares of the orders of the blocks that the row touches)
template <class Scalar>
Scalar BodiesTest::diagonal_of(const typename Room<Scalar>::Row& row, Room<Scalar>& room) const {
  Scalar square = 0;
  const Place* place = nullptr;
  Scalar* const x = room.inverse.data();
  const auto finish_block = [&] {
    if (place == nullptr) return;
    const Scalar* const L = room.factors.data() + place->factor;
    bool is_large = false;  // then its factor is that of the kernels
    if constexpr (sizeof(Scalar) == sizeof(double)) {
      is_large = place->order >= kLargeBlock;
      if (is_large) kernels_.solve_lower(L, place->order, place->order, x);
    }
    if (!is_large) solve_lower<0>(L, static_cast<std::size_t>(place->order), x);
    for (Index i = 0; i < place->order; ++i) square += x[i] * x[i];
  };
  const bool is_normal = row.column < contact_->nc();
  const Index column = is_normal ? row.column : row.column - contact_->nc();
  for_each_entry(is_normal ? contact_->N : contact_->D, column, [&](Index i, double value) {
    const bool goes_back = place != nullptr && i < place->first;
    if (goes_back) square = static_cast<Scalar>(kInfinity);  // unsorted entries give no bound here
    if (place == nullptr || goes_back || i >= place->first + place->order) {
      finish_block();
      place = &*std::prev(std::upper_bound(places_.begin(), places_.end(), i,
                                           [](Index at, const Place& next) { return at < next.first; }));
      std::fill_n(x, place->order, Scalar(0));
    }
    x[i - place->first] += static_cast<Scalar>(value);
  });
  finish_block();
  const Scalar bound = static_cast<Scalar>(1 + 2 * kTrusted) * square + row.compliance;
  return std::min(row.reach * row.reach, bound);
}

template <class Scalar>
void BodiesTest::add_impulses(const Vector& z, Room<Scalar>& room) const {
  std::fill(room.impulse.begin(), room.impulse.end(), Scalar(0));
  std::fill(room.terms.begin(), room.terms.end(), Scalar(0));
  for (std::size_t k = 0; k < room.islands.size(); ++k) {
    room.islands[k] = {0, 0, static_cast<Scalar>(scales_[k].value()), 0, 0, 0, 0, false, true};
  }
  for (Index j = 0; j < layout_.lambda_offset(); ++j) {
    if (z(j) == 0) continue;
    AddedImpulse<Scalar> added{
        .impulse = static_cast<Scalar>(z(j)), .to = room.impulse.data(), .terms = room.terms.data()};
    sum_column(*contact_, j, added);
    if (added.last < 0) continue;
    const Index island = numbers_.of_coordinate[static_cast<std::size_t>(added.last)];  // that of all its entries
    room.islands[static_cast<std::size_t>(island)].presses = true;
  }
}

/// u of one block, by Cholesky; reach, root, and how far u may be off. Only what touches the block can put it off, of
/// one island at a time. @param sums relative rounding of an impulse on a coordinate
template <class Scalar>
void BodiesTest::respond(const Matrix& block, const Place& place, Scalar sums, Room<Scalar>& room) const {
  const auto n = static_cast<std::size_t>(place.order);
  const auto at = static_cast<std::size_t>(place.first);
  Scalar* const x = room.u.data() + at;
  std::copy_n(room.impulse.data() + at, n, x);
  const bool is_definite = factor_and_respond(block, place, room);
  Scalar condition = 0;
  for (std::size_t k = 0; k < n; ++k) {
    room.root[at + k] = root_of(static_cast<Scalar>(block(static_cast<Index>(k), static_cast<Index>(k))));
    const Scalar scaled = room.reach[at + k] * room.root[at + k];
    condition += scaled * scaled;
  }
  const Scalar lost = static_cast<Scalar>(room.roundoff * static_cast<double>(n * (8 + 4 * n))) * condition;
  const bool is_known = is_definite && lost < static_cast<Scalar>(kTrusted);
  const auto island_of = [&](std::size_t i) {
    const Index k = numbers_.of_coordinate[at + i];
    return k < 0 ? nullptr : &room.islands[static_cast<std::size_t>(k)];
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (Island<Scalar>* const island = island_of(i)) island->rounded = island->lost = island->moved = 0;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (island_of(i) == nullptr) continue;
    Island<Scalar>& island = *island_of(i);
    const bool is_safe = room.terms[at + i] == 0 || room.terms[at + i] > static_cast<Scalar>(kSmallestSafe);
    island.is_known = island.is_known && is_known && is_safe;
    island.rounded += room.reach[at + i] * room.terms[at + i];
    island.lost += room.reach[at + i] * room.root[at + i] * static_cast<Scalar>(static_cast<double>(8 + 4 * n));
    island.moved += room.root[at + i] * magnitude(x[i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Island<Scalar>* const island = island_of(i);
    room.bound[at + i] = 0;
    if (island == nullptr) continue;
    const Scalar off = sums * island->rounded + static_cast<Scalar>(room.roundoff) * island->lost * island->moved;
    room.bound[at + i] = room.reach[at + i] * off;
  }
}

/// min(M_jj z_j, w) or more, of a row with z_j >= 0.
template <class Scalar>
void BodiesTest::offer(const typename Room<Scalar>::Row& row, Scalar w, double z, Island<Scalar>& island,
                       Room<Scalar>& room) const {
  Scalar pressure = row.reach * row.reach * static_cast<Scalar>(z);
  const auto off = [&](Scalar least) { return least < 0 ? -least : (least < pressure ? least : pressure); };
  if (z > 0 && is_too_much(off(w + row.rounding), island)) pressure = diagonal_of(row, room) * static_cast<Scalar>(z);
  raise(island.worst, off(w));
  raise(island.certain, std::max(off(w + row.rounding), off(w - row.rounding)));
  raise(island.rounding, row.rounding);
  if (!(row.rounding <= row.rounding)) raise(island.certain, row.rounding);
}

/// v joins u, and the rounding of rows joins its bound.
template <class Scalar>
void BodiesTest::show_velocity(Room<Scalar>& room) const {
  const Scalar dots = static_cast<Scalar>(room.roundoff * static_cast<double>(4 + contact_->ngc()));
  for (std::size_t i = 0; i < room.u.size(); ++i) {
    const Scalar v = static_cast<Scalar>(v_(static_cast<Index>(i)));
    room.bound[i] += dots * (magnitude(room.u[i]) + magnitude(v));
    room.u[i] += v;
    const Scalar coordinates[] = {room.u[i], room.bound[i], room.reach[i]};
    std::copy_n(coordinates, 3, room.coordinates.data() + 3 * i);
  }
}

template <class Scalar>
void BodiesTest::measure_friction(Index contact, const typename Room<Scalar>::Row& normal, Vector& z,
                                  Room<Scalar>& room) const {
  const auto c = static_cast<std::size_t>(contact);
  Island<Scalar>& island = room.islands[static_cast<std::size_t>(numbers_.of_contact[c])];
  const Index first = layout_.friction_offset() + layout_.friction_begin[c];
  const Index half = (layout_.friction_begin[c + 1] - layout_.friction_begin[c]) / 2;
  Scalar largest = 0;
  const BesideFriction<Scalar> beside(*contact_, layout_, contact, z);
  for (Index t = 0; t < half; ++t) {
    room.rows[static_cast<std::size_t>(t)] = row_of<Scalar>(*contact_, first + t, beside.of(t), room);
    raise(largest, magnitude(room.rows[static_cast<std::size_t>(t)].w));
  }
  double& lambda = z(layout_.lambda_offset() + layout_.lambda[c]);
  lambda = static_cast<double>(largest);
  if (!std::isfinite(lambda)) raise(island.certain, static_cast<Scalar>(kInfinity));
  const Scalar bound = static_cast<Scalar>(lambda);
  Scalar unused = static_cast<Scalar>(contact_->mu(contact)) * static_cast<Scalar>(z(contact));
  Scalar terms = unused;
  for (Index t = 0; t < half; ++t) {
    const auto& row = room.rows[static_cast<std::size_t>(t)];
    offer(row, bound + row.w, z(first + t), island, room);
    offer(row, bound - row.w, z(first + half + t), island, room);
    const Scalar used = static_cast<Scalar>(z(first + t)) + static_cast<Scalar>(z(first + half + t));
    unused -= used;
    terms += used;
  }
  const Scalar rounding = terms * static_cast<Scalar>(room.roundoff * static_cast<double>(2 + 4 * half));
  const Scalar left = magnitude(unused) + rounding;
  Scalar most = static_cast<Scalar>(1 + 2 * kTrusted) * normal.reach * normal.reach * left;
  if (is_too_much(std::min(bound, most), island)) most = std::min(most, diagonal_of(normal, room) * left);
  raise(island.worst, unused > 0 && bound < most ? bound : most);
  raise(island.certain, unused > rounding && bound < most ? bound : most);
  raise(island.rounding, 2 * normal.reach * normal.reach * rounding);
}

template <class Scalar>
contact_lemke::Residual BodiesTest::complete(Vector& z, Room<Scalar>& room) {
  room.resize(sizes_);
  if (scales_.empty()) measure_scales();
  add_impulses(z, room);
  const double most_terms = static_cast<double>(64 + (z.array() != 0).count());
  const std::vector<Matrix>& blocks = std::get<BlockInertia>(contact_->inertia).blocks;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    respond(blocks[k], places_[k], static_cast<Scalar>(room.roundoff * most_terms), room);
  }
  show_velocity(room);
  contact_lemke::Residual residual;
  for (Index c = 0; c < contact_->nc(); ++c) {
    const auto contact = static_cast<std::size_t>(c);
    const Index lambda = layout_.lambda[contact];
    if (numbers_.of_contact[contact] < 0) {
      if (lambda >= 0) z(layout_.lambda_offset() + lambda) = largest_creep(*contact_, layout_, c, z);
      if (contact_->offset(c) < 0) residual = {kInfinity, kInfinity};  // nothing moves it
      continue;
    }
    Island<Scalar>& island = room.islands[static_cast<std::size_t>(numbers_.of_contact[contact])];
    const auto row = row_of<Scalar>(*contact_, c, beside_normal<Scalar>(*contact_, c, z(c)), room);
    offer(row, row.w, z(c), island, room);
    if (lambda >= 0) measure_friction(c, row, z, room);
  }
  double rounding = 0;
  for (const Island<Scalar>& island : room.islands) {
    const bool is_certain = island.is_known || !island.presses;
    rounding = std::max(rounding, is_certain ? relative(island.rounding, island.scale) : kInfinity);
    residual.velocity = std::max(residual.velocity, relative(island.worst, island.scale));
    residual.certain = std::max(residual.certain, is_certain ? relative(island.certain, island.scale) : kInfinity);
  }
  // Half, because M_jj is known only to within 20 %. Twice, because lambda has an error as large as that of its row.
  least_ = residual.velocity / 2 - 2 * rounding;
  return residual;
}

template contact_lemke::Residual BodiesTest::complete(Vector& z, Room<double>& room);
template contact_lemke::Residual BodiesTest::complete(Vector& z, Room<Quad>& room);

}  // namespace lcpbench
