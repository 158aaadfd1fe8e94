#include "study/evaluation/contact_evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "study/evaluation/measures.h"

namespace lcpbench {
namespace {

// Throws Doubt if a value may exceed `largest`, which is one of them, by more than kSettled times `largest`. Values
// that equal its leading parts pass. Quads are compared as they are and never throw. @pre no value is negative
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

}  // namespace

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

template <class Real>
bool ContactEvaluation<Real>::respond(const Vector& answer, const RealVector& z, RealVector& v_plus, RealVector& w) {
  v_plus = lcp->response(z);
  w = lcp->all_rows(z, v_plus);
  if constexpr (std::is_same_v<Real, Quad>) {
    const bool finite = all_finite(w) && all_finite(v_plus);
    if (finite && !exact && !inertia.is_cut() && is_in_doubt(z, v_plus, w) && !resolve()) return false;
    if (!exact) return true;
    v_plus = exact->velocity(answer);
    w = exact->complement(answer);
  }
  return true;
}

/// True if the rounding of G* may change some w_i by more than kSettled times the larger of two numbers: the residual
/// of the row (a negative z_i counts as 0), and kSolvedVelocityResidual times the scale of its island.
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
    if (worst >= lcp->impulses()) {
      const ContactLayout& layout = lcp->layout();
      const auto contact = static_cast<std::size_t>(layout.cone_contact[worst - lcp->impulses()]);
      const auto first = w.begin() + layout.friction_offset();
      const auto least = std::min_element(first + layout.friction_begin[contact],
                                          first + layout.friction_begin[contact + 1],
                                          [](const Real& a, const Real& b) { return leading(a) < leading(b); });
      errors.worst.slip = to_double(z[worst] - *least);
    }
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
  return settled(largest, kSettledByData * scale);
}

/// With G (v+ - v) = G G* J f: the part of J f in the range of G, which a BoundedInertia has whole.
template <class Real>
Real ContactEvaluation<Real>::work_gain(const RealVector& z, const RealVector& v_plus) const {
  if (lcp->at_rest(z)) return 0;
  RealVector momentum = lcp->generalized_impulse(z);
  if constexpr (std::is_same_v<Real, Quad>) {
    if (inertia.is_cut()) {  // its range is not that of G
      inertia.solve(momentum);
      momentum = inertia.apply(momentum);
    } else {
      momentum = difference(momentum, inertia.outside_range(momentum));
    }
  }
  if (std::all_of(momentum.begin(), momentum.end(), is_zero<Real>)) return 0;
  return dot(momentum, sum(v_plus, lcp->velocity_before())) / Real(2);
}

/// The work that a solution may gain by the offsets of its rows: -b'f_N and the same of friction [J].
template <class Real>
Real ContactEvaluation<Real>::work_of_offset(const RealVector& z) const {
  Real work = 0;
  for (std::size_t i = 0; i < lcp->offsets(); ++i) work -= lcp->offset(i) * z[i];
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
double ContactEvaluation<Real>::forward_velocity(const RealVector& velocity) const {
  if (!v_star || !inertia.has_inertia()) return Errors::kNone;
  const RealVector apart = difference(velocity, *v_star);
  const RealVector& v = lcp->velocity_before();
  return settled(quotient(sqrt(dot(apart, inertia.apply(apart))), sqrt(dot(v, inertia.apply(v)))));
}

template struct ContactEvaluation<Quad>;
template struct ContactEvaluation<Bounded>;

}  // namespace lcpbench
