#include "study/evaluation/evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory_resource>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "core/exact_inertia.h"
#include "core/round_cone.h"
#include "study/evaluation/backward_error.h"
#include "study/evaluation/cone_friction.h"
#include "study/evaluation/farkas.h"

namespace lcpbench {
namespace {

constexpr Index kLargestBareOrderForTruth = 64;

template <class Real>
std::vector<Real> numbers(const Vector& x) {
  return std::vector<Real>(x.begin(), x.end());
}

template <class Real>
Real dot(const std::vector<Real>& a, const std::vector<Real>& b) {
  Real sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!surely_equal(a[i], 0) || !is_finite(b[i])) sum += a[i] * b[i];
  }
  return sum;
}

template <class Real>
Real max_abs(const std::vector<Real>& x) {
  Real largest = 0;
  for (const Real& value : x) largest = larger(largest, abs(value));
  return largest;
}

template <class Real>
std::vector<Real> difference(std::vector<Real> a, const std::vector<Real>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

template <class Real>
std::vector<Real> sum(std::vector<Real> a, const std::vector<Real>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

template <class Real>
std::vector<Real> magnitudes(std::vector<Real> x) {
  for (Real& value : x) value = abs(value);
  return x;
}

// Beyond doubt.
template <class Real>
bool is_zero(const Real& x) {
  return surely_equal(x, 0);
}

template <class Real>
bool all_finite(const std::vector<Real>& x) {
  return std::all_of(x.begin(), x.end(), [](const Real& value) { return is_finite(value); });
}

// Whether one is zero and the other surely no less.
template <class Real>
bool is_complementary(const Real& a, const Real& b) {
  return (surely_equal(a, 0) && surely_at_most(0, b)) || (surely_equal(b, 0) && surely_less(0, a));
}

template <class Real>
bool all_complementary(const std::vector<Real>& z, const std::vector<Real>& w) {
  return std::equal(z.begin(), z.end(), w.begin(), is_complementary<Real>);
}

// max_i value_i / scale_i
template <class Real>
Real largest_quotient(const std::vector<Real>& values, const std::vector<Real>& scales) {
  Real largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) largest = larger(largest, quotient(abs(values[i]), scales[i]));
  return largest;
}

// Whether x, rounded to double, is at most or below a bound. @throws Doubt
bool at_most(Quad x, double bound) { return to_double(x) <= bound; }
bool below(Quad x, double bound) { return to_double(x) < bound; }
bool difference_below(Quad a, Quad b, double bound) { return to_double(a) - to_double(b) < bound; }

// What rounding to double may change is in doubt as well.
bool below(Bounded x, double bound) {
  x.error += 0x1p-50 * (std::abs(x.high) + bound);
  if (surely_less(x, bound)) return true;
  if (surely_less(bound, x)) return false;
  throw Doubt();
}
bool at_most(const Bounded& x, double bound) { return below(x, bound); }
bool difference_below(const Bounded& a, const Bounded& b, double bound) {
  Bounded x = a - b;
  x.error += 0x1p-50 * (std::abs(a.high) + std::abs(b.high));
  return below(x, bound);
}

// That no value of these exceeds `largest`, one of them, by more than a number may be off that is passed on.
// @throws Doubt
void demand_largest(const QuadVector&, std::span<const std::size_t>, Quad) {}
void demand_largest(const BoundedVector& values, std::span<const std::size_t> indices, const Bounded& largest) {
  for (const std::size_t i : indices) {
    const Bounded& value = values[i];
    if (surely_equal(value, 0)) continue;  // none is smaller
    const double excess = (value.high - largest.high) + (value.low - largest.low) + 4 * (value.error + largest.error);
    const bool same = value.high == largest.high && value.low == largest.low;
    if (!same && !(excess <= kSettled * std::abs(largest.high))) throw Doubt();
  }
}

Truth bare_truth(const Lcp& lcp) {
  if (lcp.size() > kLargestBareOrderForTruth) return Truth::kUnknown;
  QuadMatrix symmetric(lcp.M);
  for (std::size_t i = 0; i < symmetric.rows; ++i) {
    for (std::size_t j = 0; j <= i; ++j) symmetric(i, j) = symmetric(j, i) = symmetric(i, j) + symmetric(j, i);
  }
  return lcp.q.allFinite() && proven_positive_definite(symmetric, 1) ? Truth::kSolvable : Truth::kUnknown;
}

}  // namespace

// The contact side of an Evaluator: what needs v, N, D, mu and G apart.
template <class Real>
struct ContactEvaluation {
  using RealVector = std::vector<Real>;
  using RealInertia = std::conditional_t<std::is_same_v<Real, Quad>, QuadInertia, BoundedInertia>;

  /// @param memory  must outlive this object.
  ContactEvaluation(const ContactProblem& contact, const IslandRows& of_rows, std::pmr::memory_resource* memory)
      : problem(contact), islands(of_rows), inertia(inertia_in(memory, contact.inertia)) {
    if (!inertia.well_defined()) return;
    lcp.emplace(contact, inertia, memory);
    if constexpr (std::is_same_v<Real, Quad>) {
      if (inertia.needs_exact()) resolve();
    }
    if (contact.frictional() && why_no_round_cone(contact).empty()) cone.emplace(contact, *lcp);
  }

  void measure(const RealVector& z, const RealVector& v_plus, const RealVector& w, Errors& errors);
  /// Whether the rounding of G* in 113 bits may be a part of the residuals that counts.
  bool is_in_doubt(const RealVector& z, const RealVector& v_plus, const RealVector& w);
  /// From now on residuals are those of exact arithmetic, where there is G* in it.
  bool resolve();
  double velocity_mismatch(const Vector& velocity, const RealVector& z, const RealVector& v_plus) const;
  void measure_returned(const Vector& velocity, const RealVector& z, const RealVector& v_plus, Errors& errors);
  double forward_velocity(const RealVector& velocity) const;

  const ContactProblem& problem;
  const IslandRows& islands;
  RealInertia inertia;
  std::optional<ContactLcp<Real>> lcp;
  std::optional<ConeFriction<Real>> cone;  // where the friction names one
  std::optional<RealVector> v_star;
  std::optional<ExactContacts> exact;

 private:
  static RealInertia inertia_in(std::pmr::memory_resource* memory, const Inertia& inertia) {
    if constexpr (std::is_same_v<Real, Quad>) {
      return RealInertia(inertia);
    } else {
      return RealInertia(inertia, memory);
    }
  }
  Real island_scale(std::size_t island) const;
  const RealVector& scales();
  Real row_residual(std::size_t row, const RealVector& z, const RealVector& w);
  RealVector measure_residual(const RealVector& z, const RealVector& w, Errors& errors);
  double model_error(const RealVector& z, const RealVector& v_plus, const RealVector& residuals);
  Real work_gain(const RealVector& z, const RealVector& v_plus) const;
  Real work_of_offset(const RealVector& z) const;
  Real velocity_scale(std::size_t coordinate, const RealVector& z);
  Real velocity_rounding(std::size_t coordinate, const Real& inverse, const RealVector& z);
  /// What the impulses of an island add up to.
  struct IslandImpulses {
    Real size = 0;     ///< sqrt(v'G v) + sum_j sqrt(M_jj) |f_j|
    double count = 0;  ///< of the f_j that are not zero
  };
  /// What the scales of the velocity's coordinates have in common.
  struct ImpulseScale {
    RealVector generalized;  ///< |J| |f|
    IslandNumbers numbers;
    std::vector<IslandImpulses> islands;  ///< the first of what no contact moves
  };
  static Real root(const Real& square);
  const ImpulseScale& impulse_scale_of(const RealVector& z);
  std::pair<Real, Real> moved_by(std::size_t coordinate, const RealVector& x);

  Real diagonal(std::size_t row);

  std::optional<ImpulseScale> impulse_scale_;  // of the answer that is measured
  RealVector inverse_row_;                     // zeros between uses
  std::vector<std::size_t> pattern_;
  RealVector scales_;     // made by scales()
  RealVector diagonals_;  // of exact; -1 where not yet made
};

template <class Real>
Real ContactEvaluation<Real>::island_scale(std::size_t island) const {
  Real largest_q = 0;
  Real floor = 0;
  for (const std::size_t row : islands.rows(island)) {
    if (row >= lcp->impulses()) break;              // q_i is zero
    if (lcp->representative(row) != row) continue;  // of the same magnitudes
    const Real magnitude = abs(lcp->q(row));
    if (!surely_less(magnitude, largest_q)) largest_q = larger(largest_q, magnitude);
  }
  const Real enough = largest_q * Real(kSolvedVelocityResidual);
  for (const std::size_t row : islands.rows(island)) {
    if (row >= lcp->impulses()) break;
    if (lcp->representative(row) != row || surely_less(Real(lcp->formation_limit(row)), enough)) continue;
    floor = larger(floor, lcp->formation_error(row));
  }
  return larger(largest_q, floor / Real(kSolvedVelocityResidual));
}

template <class Real>
Real ContactEvaluation<Real>::diagonal(std::size_t row) {
  if constexpr (std::is_same_v<Real, Quad>) {
    if (exact) {
      if (diagonals_.empty()) diagonals_.assign(lcp->impulses(), -1);
      if (diagonals_[row] < 0) diagonals_[row] = exact->diagonal(static_cast<Index>(row));
      return diagonals_[row];
    }
  }
  return lcp->diagonal(row);
}

template <class Real>
bool ContactEvaluation<Real>::resolve() {
  std::optional<ExactResponse> response = ExactResponse::of(problem.inertia);
  if (!response) return false;
  exact.emplace(problem, *std::move(response));
  return true;
}

/// A part of 2^-30, as for Bounded measures, of each row's residual or of what its island allows.
template <class Real>
bool ContactEvaluation<Real>::is_in_doubt(const RealVector& z, const RealVector& v_plus, const RealVector& w) {
  if constexpr (std::is_same_v<Real, Quad>) {
    if (lcp->at_rest(z)) return false;
    const QuadVector impulse = lcp->generalized_impulse(z);
    const QuadVector change = difference(v_plus, lcp->velocity_before());
    const std::vector<double> bounds = inertia.rounding(impulse, lcp->generalized_impulse_scale(z), change);
    for (std::size_t island = 0; island < islands.count(); ++island) {
      for (const std::size_t row : islands.rows(island)) {
        if (row >= lcp->impulses()) break;
        const double counts = to_double(larger(scales()[island] * Quad{kSolvedVelocityResidual},
                                               abs(smaller(z[row] > 0 ? diagonal(row) * z[row] : Quad{0}, w[row]))));
        if (!(lcp->rounding(row, bounds, v_plus) <= kSettled * counts)) return true;
      }
    }
  }
  return false;
}

/// Of the islands' residuals. An answer that leaves none needs no scale.
template <class Real>
const std::vector<Real>& ContactEvaluation<Real>::scales() {
  for (std::size_t island = scales_.size(); island < islands.count(); ++island) scales_.push_back(island_scale(island));
  return scales_;
}

template <class Real>
Real ContactEvaluation<Real>::row_residual(std::size_t row, const RealVector& z, const RealVector& w) {
  if constexpr (std::is_same_v<Real, Bounded>) {
    // A bound on M_ii mostly shows which of the two is smaller.
    if (row < lcp->impulses() && surely_less(0, z[row])) {
      const Real velocity = abs(w[row]);
      if (surely_less(velocity, z[row] * Real(lcp->plain_least_diagonal(row)))) return velocity;
      if (surely_less(velocity, z[row] * Real(lcp->least_diagonal(row)))) return velocity;
    }
  }
  // M_ii is needed only where its factor is not zero.
  const auto scaled = [this](std::size_t of, Real factor) {
    return surely_equal(factor, 0) ? factor : diagonal(of) * factor;
  };
  const Real residual = row < lcp->impulses() ? abs(smaller(scaled(row, z[row]), w[row]))
                                              : abs(smaller(z[row], scaled(lcp->normal_of_cone(row), w[row])));
  if (std::is_same_v<Real, Bounded> && !is_finite(residual)) throw Doubt();
  return is_finite(residual) ? residual : Real{std::numeric_limits<double>::infinity()};
}

/// Returns the residuals of all rows.
template <class Real>
std::vector<Real> ContactEvaluation<Real>::measure_residual(const RealVector& z, const RealVector& w, Errors& errors) {
  Real largest = 0;
  Real rho = 0;
  std::optional<std::size_t> worst_island;
  std::size_t worst = 0;
  const bool nonnegative_diagonal = std::is_same_v<Real, Bounded> && inertia.has_inertia();
  RealVector residuals(z.size());
  RealVector relatives(islands.count());
  for (std::size_t island = 0; island < islands.count(); ++island) {
    Real residual = 0;
    std::size_t row_of_island = 0;
    for (const std::size_t row : islands.rows(island)) {
      if (nonnegative_diagonal && is_complementary(z[row], w[row])) continue;
      residuals[row] = row_residual(row, z, w);
      if (leading(residuals[row]) > leading(residual)) row_of_island = row;
      residual = larger(residual, residuals[row]);
    }
    largest = larger(largest, residual);
    if (surely_equal(residual, 0)) continue;
    relatives[island] = quotient(residual, scales()[island]);
    if (leading(relatives[island]) > leading(rho)) {
      worst_island = island;
      worst = row_of_island;
    }
    rho = larger(rho, relatives[island]);
  }
  if (worst_island) {
    std::vector<std::size_t> all(islands.count());
    std::iota(all.begin(), all.end(), std::size_t{0});
    demand_largest(relatives, all, relatives[*worst_island]);
    demand_largest(residuals, islands.rows(*worst_island), residuals[worst]);
    errors.worst = {static_cast<Index>(worst), settled(z[worst]), settled(w[worst]), settled(residuals[worst]),
                    settled(scales()[*worst_island])};
  }
  errors.velocity_residual_m_per_s = settled(largest);
  errors.velocity_residual_relative = settled(rho);
  errors.solved = at_most(rho, kSolvedVelocityResidual) && std::isfinite(errors.velocity_residual_m_per_s);
  return residuals;
}

/// The cone shares the normal rows with the pyramid.
template <class Real>
double ContactEvaluation<Real>::model_error(const RealVector& z, const RealVector& v_plus,
                                            const RealVector& residuals) {
  if (!cone) return Errors::kNone;
  Real largest = 0;
  for (Index contact = 0; contact < problem.nc(); ++contact) {
    largest = larger(largest, residuals[static_cast<std::size_t>(contact)]);
    if (cone->has_friction(contact)) largest = larger(largest, cone->residual(contact, z, v_plus));
  }
  if (surely_equal(largest, 0)) return 0;
  double scale = 0;
  for (const Real& each : scales()) scale = std::max(scale, to_double(each));
  return settled(largest, kSettledBackward * scale);
}

/// With G (v+ - v) without the cancellation of v+ - v. A BoundedInertia is regular.
template <class Real>
Real ContactEvaluation<Real>::work_gain(const RealVector& z, const RealVector& v_plus) const {
  if (lcp->at_rest(z)) return 0;
  RealVector momentum = lcp->generalized_impulse(z);
  if (std::is_same_v<Real, Quad> && inertia.has_inertia()) {
    const RealVector impulse = momentum;
    inertia.solve(momentum);
    momentum = inertia.apply(momentum);
    for (std::size_t i = 0; exact && i < impulse.size(); ++i) {
      if (exact->is_regular(static_cast<Index>(i))) momentum[i] = impulse[i];
    }
  }
  if (std::all_of(momentum.begin(), momentum.end(), is_zero<Real>)) return 0;
  return dot(momentum, sum(v_plus, lcp->velocity_before())) / Real(2);
}

/// -b'f_N: what a solution may gain by the offset. Of a solution f_N'(N'v+ + b) = 0.
template <class Real>
Real ContactEvaluation<Real>::work_of_offset(const RealVector& z) const {
  Real work = 0;
  for (Index i = 0; i < problem.b.size(); ++i) work -= Real(problem.b(i)) * z[static_cast<std::size_t>(i)];
  return work;
}

template <class Real>
void ContactEvaluation<Real>::measure(const RealVector& z, const RealVector& v_plus, const RealVector& w,
                                      Errors& errors) {
  const RealVector residuals = measure_residual(z, w, errors);
  errors.model_error_m_per_s = model_error(z, v_plus, residuals);
  Real violation = 0;
  for (std::size_t i = 0; i < lcp->contacts(); ++i) violation = larger(violation, -w[i]);
  errors.violation_m_per_s = settled(violation);
  Real cone_violation = 0;
  for (std::size_t i = lcp->impulses(); i < lcp->size(); ++i) cone_violation = larger(cone_violation, -w[i]);
  errors.cone_violation = settled(cone_violation);
  const Real gain = work_gain(z, v_plus);
  errors.work_gain_j = settled(gain);
  errors.forward_velocity = forward_velocity(v_plus);

  const Real work = work_of_offset(z);
  errors.criterion = difference_below(gain, work, kCriterionWork) && below(violation, kCriterionViolation);
}

template <class Real>
double ContactEvaluation<Real>::velocity_mismatch(const Vector& returned, const RealVector& z,
                                                  const RealVector& v_plus) const {
  if (returned.size() == 0) return Errors::kNone;
  if (returned.size() != problem.ngc() || !returned.allFinite()) return std::numeric_limits<double>::infinity();
  const auto same = [](const Real& x, double y) { return std::is_same_v<Real, Bounded> && surely_equal(x, y); };
  if (std::equal(v_plus.begin(), v_plus.end(), returned.begin(), same)) return 0;
  const RealVector velocity = numbers<Real>(returned);
  const RealVector& v = lcp->velocity_before();
  const RealVector apart = difference(velocity, v_plus);
  const RealVector speeds = sum(magnitudes(velocity), magnitudes(v));
  const RealVector impulse_scale = lcp->generalized_impulse_scale(z);
  if (!inertia.has_inertia()) {
    return settled(largest_quotient(apart, sum(speeds, inertia.scale(impulse_scale))), kSettledBackward);
  }
  if constexpr (std::is_same_v<Real, Quad>) {
    const Real in_range = largest_quotient(inertia.apply(apart), sum(inertia.scale(speeds), impulse_scale));
    const Real outside = max_abs(inertia.outside_range(difference(velocity, v)));
    return settled(larger(in_range, quotient(outside, max_abs(velocity) + max_abs(v))));
  } else {  // a BoundedInertia is regular
    const RealVector scale = sum(inertia.scale(speeds), impulse_scale);
    const Real in_double = largest_quotient(inertia.apply_in_double(apart), scale);
    if (is_settled(in_double, kSettledBackward)) return to_double(in_double);
    return settled(largest_quotient(inertia.apply(apart), scale), kSettledBackward);
  }
}

/// What rounding may leave where exact sums cancel. |u_i| <= sqrt(G*_ii) |u|_G for all u, so |G*_i' J_j| <= sqrt(G*_ii
/// M_jj).
template <class Real>
Real ContactEvaluation<Real>::velocity_rounding(std::size_t coordinate, const Real& inverse, const RealVector& z) {
  const ImpulseScale& of = impulse_scale_of(z);
  const IslandImpulses& island = of.islands[static_cast<std::size_t>(of.numbers.of_coordinate[coordinate] + 1)];
  const Real rounding = Real(island.count + 1) * (Real(0x1p-53) * root(inverse) * island.size + Real(0x1p-1074));
  if (std::is_same_v<Real, Bounded> && !is_finite(rounding)) throw Doubt();
  return rounding;
}

template <class Real>
Real ContactEvaluation<Real>::root(const Real& square) {
  return leading(square) > 0 ? sqrt(square) : Real(0);
}

/// All islands in one pass over the scene, however many coordinates ask.
template <class Real>
const typename ContactEvaluation<Real>::ImpulseScale& ContactEvaluation<Real>::impulse_scale_of(const RealVector& z) {
  if (impulse_scale_) return *impulse_scale_;
  ImpulseScale& scale = impulse_scale_.emplace();
  scale.generalized = lcp->generalized_impulse_scale(z);
  scale.numbers.find(problem);
  scale.islands.resize(static_cast<std::size_t>(scale.numbers.count) + 1);
  if (inertia.has_inertia()) {
    const RealVector& v = lcp->velocity_before();
    const RealVector momentum = inertia.apply(v);
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (surely_equal(v[i], 0) && is_finite(momentum[i])) continue;
      scale.islands[static_cast<std::size_t>(scale.numbers.of_coordinate[i] + 1)].size += v[i] * momentum[i];
    }
    for (IslandImpulses& island : scale.islands) island.size = root(island.size);
  }
  const ContactLayout& layout = lcp->layout();
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto at = static_cast<std::size_t>(contact);
    if (scale.numbers.of_contact[at] < 0) continue;
    IslandImpulses& island = scale.islands[static_cast<std::size_t>(scale.numbers.of_contact[at] + 1)];
    const auto add = [&](Index row) {
      const auto j = static_cast<std::size_t>(row);
      if (surely_equal(z[j], 0)) return;
      island.size += root(diagonal(j)) * abs(z[j]);
      ++island.count;
    };
    add(contact);
    for (Index d = layout.friction_begin[at]; d < layout.friction_begin[at + 1]; ++d) add(layout.friction_offset() + d);
  }
  return scale;
}

/// (|v| + |G*| x)_i for x >= 0, and G*_ii.
template <class Real>
std::pair<Real, Real> ContactEvaluation<Real>::moved_by(std::size_t coordinate, const RealVector& x) {
  Real sum = abs(lcp->velocity_before()[coordinate]);
  if constexpr (std::is_same_v<Real, Quad>) {
    if (exact) {
      const auto i = static_cast<Index>(coordinate);
      for (std::size_t j = 0; j < x.size(); ++j) {
        if (x[j] != 0) sum += abs(exact->inverse(i, static_cast<Index>(j))) * x[j];
      }
      return {sum, exact->inverse(i, i)};
    }
  }
  inverse_row_.resize(x.size(), 0);
  inverse_row_[coordinate] = 1;
  pattern_.assign(1, coordinate);
  inertia.solve(inverse_row_, pattern_);
  const Real own = inverse_row_[coordinate];
  for (const std::size_t j : pattern_) {
    sum += abs(inverse_row_[j]) * x[j];
    inverse_row_[j] = 0;
  }
  return {sum, own};
}

/// (|v| + |G*| |J| |f|)_i + rounding_i / 1e-4
template <class Real>
Real ContactEvaluation<Real>::velocity_scale(std::size_t coordinate, const RealVector& z) {
  const auto [moved, inverse] = moved_by(coordinate, impulse_scale_of(z).generalized);
  return moved + velocity_rounding(coordinate, inverse, z) / Real(kSolvedReturnedVelocity);
}

template <class Real>
void ContactEvaluation<Real>::measure_returned(const Vector& returned, const RealVector& z, const RealVector& v_plus,
                                               Errors& errors) {
  if (returned.size() == 0) return;
  errors.returned_velocity_error = std::numeric_limits<double>::infinity();
  if (returned.size() == problem.ngc() && returned.allFinite()) {
    const RealVector& v = lcp->velocity_before();
    impulse_scale_.reset();
    Real largest = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double given = returned(static_cast<Index>(i));
      const Real apart = abs(Real(given) - v_plus[i]);
      if (surely_equal(apart, 0)) continue;
      Real error = quotient(apart, abs(v[i]) + abs(v_plus[i] - v[i]));
      if (!surely_at_most(error, kSolvedReturnedVelocity)) error = quotient(apart, velocity_scale(i, z));
      if (leading(error) > leading(largest)) {
        errors.worst_coordinate = {static_cast<Index>(i), given, to_double(v_plus[i])};
      }
      largest = larger(largest, error);
    }
    at_most(largest, kSolvedReturnedVelocity);  // @throws Doubt
    errors.returned_velocity_error = settled(largest, kSettledBackward);
  }
  errors.solved = errors.solved && errors.velocity_passes();
}

template <class Real>
double ContactEvaluation<Real>::forward_velocity(const RealVector& velocity) const {
  if (!v_star || !inertia.has_inertia()) return Errors::kNone;
  const RealVector apart = difference(velocity, *v_star);
  const RealVector& v = lcp->velocity_before();
  return settled(quotient(sqrt(dot(apart, inertia.apply(apart))), sqrt(dot(v, inertia.apply(v)))));
}

struct Evaluator::Data {
  Data(const Problem& the_problem, Precision precision) : problem(the_problem) {
    if (const ContactProblem* data = problem.contact()) {
      islands.emplace(row_islands(*data));
      if (precision == Precision::kAsNeeded) first.emplace(*data, *islands, &memory);
      if (first && !first->lcp) first.reset();
    } else if (problem.lcp().M.allFinite() && problem.lcp().q.allFinite()) {
      bare.emplace(problem.lcp());
      islands.emplace(row_islands(problem.lcp().M));
    }
  }

  // The contact problem in 113 bits, made when it is first needed.
  ContactEvaluation<Quad>& in_quad() {
    if (!quad) {
      quad.emplace(*problem.contact(), *islands, &memory);
      if (v_star) quad->v_star = numbers<Quad>(*v_star);
    }
    return *quad;
  }

  // What `of` gives in Bounded arithmetic, or else in 113 bits.
  template <class Of>
  auto measured(const Of& of) {
    if (first) {
      try {
        return of(*first);
      } catch (const Doubt&) {
      }
    }
    return of(in_quad());
  }

  // Enough for a step of one robot, where allocations one by one would take a fifth of the time.
  std::array<std::byte, 1 << 14> small;
  std::pmr::monotonic_buffer_resource memory{small.data(), small.size()};
  Problem problem;  // keeps the data alive that the others refer to
  std::optional<IslandRows> islands;
  std::optional<BareQuadLcp> bare;
  std::optional<ContactEvaluation<Bounded>> first;
  std::optional<ContactEvaluation<Quad>> quad;
  std::optional<Vector> v_star;
};

namespace {

// False when the answer has no measures.
template <class Real>
bool measure_rows(EvaluatedLcp<Real>& lcp, const IslandRows& islands, const std::vector<Real>& z,
                  const std::vector<Real>& u, const std::vector<Real>& w, BackwardError<Real>& row_norm,
                  Errors& errors) {
  if (!all_finite(w) || !all_finite(u)) {
    if (std::is_same_v<Real, Bounded>) throw Doubt();
    return false;
  }
  errors.min_z = z.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (const Real& value : z) errors.min_z = std::min(errors.min_z, to_double(value));
  if (all_complementary(z, w)) {
    errors.natural_residual = errors.complementarity_j = errors.backward_componentwise = errors.backward_row_norm = 0;
    return true;
  }
  Real natural = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (!is_complementary(z[i], w[i])) natural = larger(natural, abs(smaller(z[i], w[i])));
  }
  errors.natural_residual = settled(natural);
  errors.complementarity_j = settled(dot(z, w));
  row_norm = mixed_backward_error(lcp, z, u, w, BackwardScale::kRowNorm, islands);
  errors.backward_componentwise =
      settled(mixed_backward_error(lcp, z, u, w, BackwardScale::kComponentwise, islands).error, kSettledBackward);
  errors.backward_row_norm = settled(row_norm.error, kSettledBackward);
  return true;
}

template <class Real>
Errors contact_errors(ContactEvaluation<Real>& contact, const Answer& answer, Errors errors) {
  if constexpr (std::is_same_v<Real, Quad>) errors.unresolved = contact.inertia.unresolved();
  if (!contact.lcp) return errors;
  const std::vector<Real> z = numbers<Real>(answer.z);
  std::vector<Real> u = contact.lcp->response(z);
  std::vector<Real> w = contact.lcp->all_rows(z, u);
  if constexpr (std::is_same_v<Real, Quad>) {
    const bool finite = all_finite(w) && all_finite(u);
    if (finite && !contact.exact && !contact.inertia.is_cut() && contact.is_in_doubt(z, u, w) && !contact.resolve()) {
      errors.unresolved = true;
      return errors;
    }
    if (contact.exact) {
      u = contact.exact->velocity(answer.z);
      w = contact.exact->complement(answer.z);
    }
  }
  BackwardError<Real> row_norm;
  if (!measure_rows(*contact.lcp, contact.islands, z, u, w, row_norm, errors)) return errors;
  contact.measure(z, u, w, errors);
  errors.velocity_mismatch = contact.velocity_mismatch(answer.velocity, z, u);
  contact.measure_returned(answer.velocity, z, u, errors);
  return errors;
}

Errors bare_errors(BareQuadLcp& lcp, const IslandRows& islands, const Answer& answer, Errors errors) {
  const QuadVector z = numbers<Quad>(answer.z);
  const QuadVector w = lcp.response(z);
  BackwardError<Quad> row_norm;
  if (!measure_rows<Quad>(lcp, islands, z, w, w, row_norm, errors)) return errors;
  errors.solved = errors.backward_row_norm <= kSolvedBackwardError;
  if (row_norm.row) {
    errors.worst = {.row = static_cast<Index>(*row_norm.row),
                    .z = answer.z(static_cast<Index>(*row_norm.row)),
                    .w = to_double(w[*row_norm.row])};
  }
  return errors;
}

}  // namespace

Evaluator::Evaluator(const Problem& problem, Precision precision) : data_(std::make_unique<Data>(problem, precision)) {}
Evaluator::~Evaluator() = default;

Errors Evaluator::errors(const Answer& answer) {
  Errors errors;
  errors.usable = answer.z.size() == data_->problem.size() && answer.z.allFinite();
  if (!errors.usable) return errors;
  if (data_->bare) return bare_errors(*data_->bare, *data_->islands, answer, errors);
  if (data_->problem.contact() == nullptr) return errors;
  return data_->measured([&](auto& contact) { return contact_errors(contact, answer, errors); });
}

Judgement Evaluator::judge(const Answer& answer) {
  Judgement judgement;
  judgement.errors = errors(answer);
  judgement.proof_holds = answer.farkas.size() > 0 && check_farkas(answer.farkas);
  if (const ContactProblem* contact = data_->problem.contact(); contact != nullptr && judgement.proof_holds) {
    judgement.errors.least_violation_m_per_s = least_violation(*contact, answer.farkas);
  }
  return judgement;
}

double Evaluator::forward_velocity(const Answer& answer) {
  const bool usable = answer.z.size() == data_->problem.size() && answer.z.allFinite();
  if (!usable || data_->problem.contact() == nullptr) return Errors::kNone;
  return data_->measured([&]<class Real>(ContactEvaluation<Real>& contact) {
    if (!contact.lcp) return Errors::kNone;
    const std::vector<Real> v_plus = contact.lcp->response(numbers<Real>(answer.z));
    if (all_finite(v_plus)) return contact.forward_velocity(v_plus);
    if (std::is_same_v<Real, Bounded>) throw Doubt();
    return Errors::kNone;
  });
}

void Evaluator::set_certified_velocity(const Vector& v_star) {
  const ContactProblem* const problem = data_->problem.contact();
  if (problem == nullptr || v_star.size() != problem->ngc() || !v_star.allFinite()) {
    throw std::invalid_argument("set_certified_velocity: needs a contact problem and ngc finite entries");
  }
  data_->v_star = v_star;
  if (data_->first) data_->first->v_star = numbers<Bounded>(v_star);
  if (data_->quad) data_->quad->v_star = numbers<Quad>(v_star);
}

Truth Evaluator::truth() const {
  if (data_->problem.contact() == nullptr) return bare_truth(data_->problem.lcp());
  const ContactProblem& problem = *data_->problem.contact();
  if (!problem.v.allFinite() || !(problem.mu.array() >= 0).all() || !(problem.b.array() >= 0).all() ||
      !problem.b.allFinite()) {
    return Truth::kUnknown;
  }
  const bool proven = (data_->first && data_->first->inertia.proven_positive_definite()) ||
                      data_->in_quad().inertia.proven_positive_definite();
  return proven ? Truth::kSolvable : Truth::kUnknown;
}

bool Evaluator::check_farkas(const Vector& u) const {
  const ContactProblem* const problem = data_->problem.contact();
  return problem != nullptr ? proves_unsolvable(*problem, u) : proves_unsolvable(data_->problem.lcp(), u);
}

}  // namespace lcpbench
