#include "study/evaluation/evaluation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "study/evaluation/backward_error.h"
#include "study/evaluation/farkas.h"
#include "study/evaluation/island_rows.h"

namespace lcpbench {
namespace {

constexpr Index kLargestBareOrderForTruth = 64;

QuadVector quad(const Vector& x) { return QuadVector(x.begin(), x.end()); }

Quad dot(const QuadVector& a, const QuadVector& b) {
  Quad sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

Quad max_abs(const QuadVector& x) {
  Quad largest = 0;
  for (const Quad value : x) largest = std::max(largest, abs(value));
  return largest;
}

QuadVector difference(QuadVector a, const QuadVector& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

QuadVector sum(QuadVector a, const QuadVector& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

QuadVector magnitudes(QuadVector x) {
  for (Quad& value : x) value = abs(value);
  return x;
}

bool all_finite(const QuadVector& x) {
  return std::all_of(x.begin(), x.end(), [](Quad value) { return is_finite(value); });
}

// max_i value_i / scale_i
Quad largest_quotient(const QuadVector& values, const QuadVector& scales) {
  Quad largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) largest = std::max(largest, quotient(abs(values[i]), scales[i]));
  return largest;
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
struct ContactEvaluation {
  explicit ContactEvaluation(const ContactProblem& contact)
      : problem(contact), islands(row_islands(contact)), inertia(contact.inertia) {
    if (!inertia.well_defined()) return;
    lcp.emplace(contact, inertia);
    for (std::size_t island = 0; island < islands.count(); ++island) scales.push_back(island_scale(island));
  }

  void measure(const QuadVector& z, const QuadVector& v_plus, const QuadVector& w, Errors& errors);
  void measure_returned(const Vector& velocity, const QuadVector& z, const QuadVector& v_plus, Errors& errors) const;
  double forward_velocity(const QuadVector& velocity) const;

  const ContactProblem& problem;
  IslandRows islands;
  QuadInertia inertia;
  std::optional<ContactQuadLcp> lcp;
  QuadVector scales;  // of the islands' residuals
  std::optional<QuadVector> v_star;

 private:
  Quad island_scale(std::size_t island) const;
  Quad row_residual(std::size_t row, const QuadVector& z, const QuadVector& w);
  void measure_residual(const QuadVector& z, const QuadVector& w, Errors& errors);
  Quad largest_normal_velocity(const QuadVector& velocity) const;
  Quad largest_normal_q() const;
  Quad work_of_offset(const QuadVector& z) const;
  Quad mismatch(const QuadVector& velocity, const QuadVector& z, const QuadVector& v_plus) const;
  void measure_work(const QuadVector& z, const QuadVector& v_plus, Errors& errors) const;
  void measure_cone(const QuadVector& z, const QuadVector& w, Errors& errors) const;
  double forward_normal(const QuadVector& velocity) const;
};

Quad ContactEvaluation::island_scale(std::size_t island) const {
  Quad largest_q = 0;
  Quad floor = 0;
  for (const std::size_t row : islands.rows(island)) {
    largest_q = std::max(largest_q, abs(lcp->q(row)));
    floor = std::max(floor, lcp->formation_error(row));
  }
  return std::max(largest_q, floor / kSolvedVelocityResidual);
}

Quad ContactEvaluation::row_residual(std::size_t row, const QuadVector& z, const QuadVector& w) {
  // M_ii is needed only where its factor is not zero.
  const auto scaled = [this](std::size_t of, Quad factor) { return factor == 0 ? factor : lcp->diagonal(of) * factor; };
  const Quad residual = row < lcp->impulses() ? abs(std::min(scaled(row, z[row]), w[row]))
                                              : abs(std::min(z[row], scaled(lcp->normal_of_cone(row), w[row])));
  return is_finite(residual) ? residual : Quad{std::numeric_limits<double>::infinity()};
}

void ContactEvaluation::measure_residual(const QuadVector& z, const QuadVector& w, Errors& errors) {
  Quad largest = 0;
  Quad rho = 0;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    Quad residual = 0;
    std::size_t worst = 0;
    for (const std::size_t row : islands.rows(island)) {
      const Quad of_row = row_residual(row, z, w);
      if (of_row > residual) {
        residual = of_row;
        worst = row;
      }
    }
    largest = std::max(largest, residual);
    const Quad relative = quotient(residual, scales[island]);
    if (!(relative > rho)) continue;
    rho = relative;
    errors.worst = {static_cast<Index>(worst), to_double(z[worst]), to_double(w[worst]), to_double(residual),
                    to_double(scales[island])};
  }
  errors.velocity_residual_m_per_s = to_double(largest);
  errors.velocity_residual_relative = to_double(rho);
}

Quad ContactEvaluation::largest_normal_velocity(const QuadVector& velocity) const {
  Quad largest = 0;
  for (std::size_t i = 0; i < lcp->contacts(); ++i) largest = std::max(largest, abs(lcp->project(i, velocity)));
  return largest;
}

Quad ContactEvaluation::largest_normal_q() const {
  Quad largest = 0;
  for (std::size_t i = 0; i < lcp->contacts(); ++i) largest = std::max(largest, abs(lcp->q(i)));
  return largest;
}

void ContactEvaluation::measure_work(const QuadVector& z, const QuadVector& v_plus, Errors& errors) const {
  const QuadVector& v = lcp->velocity_before();
  const QuadVector momentum =
      inertia.has_inertia() ? inertia.apply(difference(v_plus, v)) : lcp->generalized_impulse(z);
  const Quad work = dot(momentum, sum(v_plus, v)) / 2;
  errors.work_gain_j = to_double(work);
  if (inertia.has_inertia()) errors.work_gain_relative = to_double(quotient(work, dot(v, inertia.apply(v)) / 2));
}

/// -b'f_N: what a solution may gain by the offset. Of a solution f_N'(N'v+ + b) = 0.
Quad ContactEvaluation::work_of_offset(const QuadVector& z) const {
  Quad work = 0;
  for (Index i = 0; i < problem.b.size(); ++i) work -= problem.b(i) * z[static_cast<std::size_t>(i)];
  return work;
}

void ContactEvaluation::measure_cone(const QuadVector& z, const QuadVector& w, Errors& errors) const {
  Quad violation = 0;
  for (std::size_t i = lcp->impulses(); i < lcp->size(); ++i) violation = std::max(violation, -w[i]);
  Quad largest_impulse = 0;
  for (std::size_t i = 0; i < lcp->impulses(); ++i) largest_impulse = std::max(largest_impulse, abs(z[i]));
  errors.cone_violation = to_double(violation);
  errors.cone_violation_relative = to_double(quotient(violation, largest_impulse));
}

void ContactEvaluation::measure(const QuadVector& z, const QuadVector& v_plus, const QuadVector& w, Errors& errors) {
  measure_residual(z, w, errors);
  Quad violation = 0;
  for (std::size_t i = 0; i < lcp->contacts(); ++i) violation = std::max(violation, -w[i]);
  errors.violation_m_per_s = to_double(violation);
  errors.violation_relative = to_double(quotient(violation, largest_normal_q()));
  measure_work(z, v_plus, errors);
  measure_cone(z, w, errors);
  errors.forward_velocity = forward_velocity(v_plus);
  errors.forward_normal = forward_normal(v_plus);

  errors.solved =
      errors.velocity_residual_relative <= kSolvedVelocityResidual && std::isfinite(errors.velocity_residual_m_per_s);
  errors.criterion = errors.work_gain_j - to_double(work_of_offset(z)) < kCriterionWork &&
                     errors.violation_m_per_s < kCriterionViolation;
}

Quad ContactEvaluation::mismatch(const QuadVector& velocity, const QuadVector& z, const QuadVector& v_plus) const {
  const QuadVector& v = lcp->velocity_before();
  const QuadVector speeds = sum(magnitudes(velocity), magnitudes(v));
  const QuadVector impulse_scale = lcp->generalized_impulse_scale(z);
  const QuadVector apart = difference(velocity, v_plus);
  if (!inertia.has_inertia()) return largest_quotient(apart, sum(speeds, inertia.scale(impulse_scale)));
  const Quad in_range = largest_quotient(inertia.apply(apart), sum(inertia.scale(speeds), impulse_scale));
  const Quad outside = max_abs(inertia.outside_range(difference(velocity, v)));
  return std::max(in_range, quotient(outside, max_abs(velocity) + max_abs(v)));
}

void ContactEvaluation::measure_returned(const Vector& velocity, const QuadVector& z, const QuadVector& v_plus,
                                         Errors& errors) const {
  if (velocity.size() == 0) return;
  if (velocity.size() != problem.ngc() || !velocity.allFinite()) {
    errors.velocity_mismatch = std::numeric_limits<double>::infinity();
    return;
  }
  const QuadVector returned = quad(velocity);
  errors.velocity_mismatch = to_double(mismatch(returned, z, v_plus));
  errors.forward_velocity_returned = forward_velocity(returned);
  errors.forward_normal_returned = forward_normal(returned);
}

double ContactEvaluation::forward_velocity(const QuadVector& velocity) const {
  if (!v_star || !inertia.has_inertia()) return Errors::kNone;
  const QuadVector apart = difference(velocity, *v_star);
  const QuadVector& v = lcp->velocity_before();
  return to_double(quotient(sqrt(dot(apart, inertia.apply(apart))), sqrt(dot(v, inertia.apply(v)))));
}

double ContactEvaluation::forward_normal(const QuadVector& velocity) const {
  if (!v_star) return Errors::kNone;
  return to_double(quotient(largest_normal_velocity(difference(velocity, *v_star)), largest_normal_q()));
}

struct Evaluator::Data {
  explicit Data(const Problem& the_problem) : problem(the_problem) {
    if (const ContactProblem* data = problem.contact()) {
      contact.emplace(*data);
    } else if (problem.lcp().M.allFinite() && problem.lcp().q.allFinite()) {
      bare.emplace(problem.lcp());
      blocks.emplace(row_islands(problem.lcp().M));
    }
  }

  // nullptr when the data allow no evaluation.
  QuadLcp* lcp() {
    if (bare) return &*bare;
    return contact && contact->lcp ? &*contact->lcp : nullptr;
  }

  const IslandRows& islands() const { return contact ? contact->islands : *blocks; }

  Problem problem;  // keeps the data alive that the others refer to
  std::optional<BareQuadLcp> bare;
  std::optional<IslandRows> blocks;  // of the bare LCP
  std::optional<ContactEvaluation> contact;
};

Evaluator::Evaluator(const Problem& problem) : data_(std::make_unique<Data>(problem)) {}
Evaluator::~Evaluator() = default;

Errors Evaluator::errors(const Answer& answer) {
  Errors errors;
  errors.usable = answer.z.size() == data_->problem.size() && answer.z.allFinite();
  QuadLcp* lcp = data_->lcp();
  if (!errors.usable || lcp == nullptr) return errors;

  const QuadVector z = quad(answer.z);
  const QuadVector u = lcp->response(z);
  const QuadVector w = lcp->all_rows(z, u);
  if (!all_finite(w) || !all_finite(u)) return errors;

  Quad natural = 0;
  Quad magnitude = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    natural = std::max(natural, abs(std::min(z[i], w[i])));
    magnitude += abs(z[i] * w[i]);
  }
  errors.natural_residual = to_double(natural);
  errors.complementarity_j = to_double(dot(z, w));
  errors.complementarity_relative = to_double(quotient(dot(z, w), magnitude));
  errors.min_z = z.empty() ? 0 : answer.z.minCoeff();
  const IslandRows& islands = data_->islands();
  const BackwardError row_norm = mixed_backward_error(*lcp, z, BackwardScale::kRowNorm, islands);
  errors.backward_componentwise =
      to_double(mixed_backward_error(*lcp, z, BackwardScale::kComponentwise, islands).error);
  errors.backward_row_norm = to_double(row_norm.error);
  if (data_->contact) {
    data_->contact->measure(z, u, w, errors);
    data_->contact->measure_returned(answer.velocity, z, u, errors);
  } else {
    errors.solved = errors.backward_row_norm <= kSolvedBackwardError;
    if (row_norm.row) {
      errors.worst = {.row = static_cast<Index>(*row_norm.row),
                      .z = answer.z(static_cast<Index>(*row_norm.row)),
                      .w = to_double(w[*row_norm.row])};
    }
  }
  return errors;
}

double Evaluator::forward_velocity(const Answer& answer) {
  const bool usable = answer.z.size() == data_->problem.size() && answer.z.allFinite();
  if (!usable || !data_->contact || !data_->contact->lcp) return Errors::kNone;
  const QuadVector v_plus = data_->contact->lcp->response(quad(answer.z));
  return all_finite(v_plus) ? data_->contact->forward_velocity(v_plus) : Errors::kNone;
}

void Evaluator::set_certified_velocity(const Vector& v_star) {
  if (!data_->contact || v_star.size() != data_->contact->problem.ngc() || !v_star.allFinite()) {
    throw std::invalid_argument("set_certified_velocity: needs a contact problem and ngc finite entries");
  }
  data_->contact->v_star = quad(v_star);
}

Truth Evaluator::truth() const {
  if (!data_->contact) return bare_truth(data_->problem.lcp());
  const ContactProblem& problem = data_->contact->problem;
  const bool proven =
      problem.v.allFinite() && (problem.mu.array() >= 0).all() && (problem.b.array() >= 0).all() &&
      problem.b.allFinite() && data_->contact->inertia.proven_positive_definite();
  return proven ? Truth::kSolvable : Truth::kUnknown;
}

bool Evaluator::check_farkas(const Vector& u) const {
  return data_->contact ? proves_unsolvable(data_->contact->problem, u) : proves_unsolvable(data_->problem.lcp(), u);
}

}  // namespace lcpbench
