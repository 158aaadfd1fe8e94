#include "study/evaluation/evaluation.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>

#include "core/compliance.h"
#include "core/quad_inertia.h"
#include "study/evaluation/backward_error.h"
#include "study/evaluation/contact_evaluation.h"
#include "study/evaluation/farkas.h"
#include "study/evaluation/measures.h"
#include "study/evaluation/mixed_errors.h"
#include "study/evaluation/returned_velocity.h"

namespace lcpbench {
namespace {

constexpr Index kLargestBareOrderForTruth = 64;

Truth bare_truth(const Lcp& lcp) {
  if (lcp.size() > kLargestBareOrderForTruth) return Truth::kUnknown;
  QuadMatrix symmetric(lcp.M);
  for (std::size_t i = 0; i < symmetric.rows; ++i) {
    for (std::size_t j = 0; j <= i; ++j) symmetric(i, j) = symmetric(j, i) = symmetric(i, j) + symmetric(j, i);
  }
  return proven_positive_definite(symmetric, 1) ? Truth::kSolvable : Truth::kUnknown;
}

/// Whether bodies at rest satisfy each contact, whatever impulses it takes: the same theorem with a regular G.
bool rest_satisfies(const ContactProblem& problem) {
  for (Index i = 0; i < problem.nc(); ++i) {
    if (problem.normal_compliance(i) > 0) continue;
    const bool creeps = problem.tangential_offset(i, 0) != 0 || problem.tangential_offset(i, 1) != 0;
    if (!(problem.offset(i) >= 0) || (creeps && !(problem.tangential_compliance(i) > 0))) return false;
  }
  return true;
}

/// Readers allow a given G* to be indefinite by rounding.
bool has_semidefinite_response(const Inertia& inertia) {
  const auto* given = std::get_if<InverseInertia>(&inertia);
  if (given == nullptr) return true;
  const QuadInertia response(DenseInertia{given->Ginv});
  return response.well_defined() && !response.is_cut();
}

}  // namespace

struct Evaluator::Data {
  explicit Data(const Problem& the_problem) : problem(the_problem) {
    if (!why_not({}, problem).empty()) return;  // it has NaN or infinity
    const ContactProblem* const data = problem.contact();
    islands.emplace(data != nullptr ? row_islands(*data) : row_islands(problem.lcp().M));
    if (data != nullptr) contact.emplace(*data, *islands);
  }

  Problem problem;                    // keeps the data alive that the others refer to
  std::optional<IslandRows> islands;  // none where the data are not finite: then nothing is measured
  std::optional<ContactEvaluation> contact;
};

namespace {

// False when the answer has no measures.
bool measure_rows(const QuadVector& z, const QuadVector& u, const QuadVector& w, Errors& errors) {
  if (!all_finite(w) || !all_finite(u)) return false;
  errors.min_z = z.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (const Quad value : z) errors.min_z = std::min(errors.min_z, to_double(value));
  Quad natural = 0, sum = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (is_complementary(z[i], w[i])) continue;
    natural = larger(natural, abs(smaller(z[i], w[i])));
    sum += z[i] * w[i];
  }
  errors.natural_residual = to_double(natural);
  errors.complementarity_j = to_double(sum);
  return true;
}

Errors contact_errors(ContactEvaluation& contact, const Answer& answer, Errors errors) {
  errors.unresolved = contact.inertia.unresolved();
  if (!contact.lcp) return errors;
  const QuadVector z = numbers(answer.z);
  const QuadVector u = contact.lcp->response(z), w = contact.lcp->all_rows(z, u);
  const Errors unmeasured = errors;
  if (measure_rows(z, u, w, errors)) {
    contact.measure(z, u, w, errors);
    ReturnedVelocity returned(contact, z, u);
    errors.velocity_mismatch = returned.mismatch(answer.velocity);
    returned.measure(answer.velocity, errors);
  }
  if (!contact.inertia.well_defined()) errors = unmeasured;  // 113 bits were needed, and found no G*
  errors.unresolved = contact.inertia.unresolved();
  return errors;
}

Errors bare_errors(const Lcp& lcp, const IslandRows& islands, const Answer& answer, Errors errors) {
  const QuadVector z = numbers(answer.z);
  const QuadVector w = complement(lcp, z);
  if (!measure_rows(z, w, w, errors)) return errors;
  const BackwardError backward = backward_error(lcp, z, w, islands);
  errors.backward_row_norm = to_double(backward.error);
  errors.decide(kSolvedBackwardError);
  if (backward.row) {
    errors.worst = {.row = static_cast<Index>(*backward.row),
                    .z = answer.z(static_cast<Index>(*backward.row)),
                    .w = to_double(w[*backward.row])};
  }
  return errors;
}

}  // namespace

Evaluator::Evaluator(const Problem& problem) : data_(std::make_unique<Data>(problem)) {}
Evaluator::~Evaluator() = default;

Errors Evaluator::errors(const Answer& answer) {
  Errors errors;
  errors.usable = answer.claim != Claim::kUnsupported && answer.z.size() == data_->problem.size() &&
                  answer.z.allFinite();  // a refusal has no answer, also where an answer has no numbers
  if (!errors.usable || !data_->islands) return errors;
  if (data_->contact) return contact_errors(*data_->contact, answer, errors);
  const Lcp& lcp = data_->problem.lcp();
  return lcp.is_mixed() ? mixed_errors(lcp, answer.z) : bare_errors(lcp, *data_->islands, answer, errors);
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
  if (!usable || !data_->contact || !data_->contact->lcp) return Errors::kNone;
  const QuadVector v_plus = data_->contact->lcp->response(numbers(answer.z));
  return all_finite(v_plus) ? data_->contact->forward_velocity(v_plus) : Errors::kNone;
}

void Evaluator::set_certified_velocity(const Vector& v_star) {
  const ContactProblem* const problem = data_->problem.contact();
  if (problem == nullptr || v_star.size() != problem->ngc() || !v_star.allFinite()) {
    throw std::invalid_argument("set_certified_velocity: needs a contact problem and ngc finite entries");
  }
  if (data_->contact) data_->contact->v_star = numbers(v_star);
}

Truth Evaluator::truth() const {
  if (!data_->islands) return Truth::kUnknown;
  if (data_->problem.contact() == nullptr) {
    return has_friction(data_->problem.lcp()) ? Truth::kUnknown : bare_truth(data_->problem.lcp());
  }
  const ContactProblem& problem = *data_->problem.contact();
  if (!(problem.mu.array() >= 0).all()) return Truth::kUnknown;
  if (every_contact_yields(problem) && has_semidefinite_response(problem.inertia)) return Truth::kSolvable;
  if (!rest_satisfies(problem)) return Truth::kUnknown;
  return data_->contact->inertia.proven_positive_definite() ? Truth::kSolvable : Truth::kUnknown;
}

bool Evaluator::check_farkas(const Vector& u) const {
  const ContactProblem* const problem = data_->problem.contact();
  if (problem != nullptr) return proves_unsolvable(*problem, u);
  return !data_->problem.lcp().is_mixed() && proves_unsolvable(data_->problem.lcp(), u);
}

}  // namespace lcpbench
