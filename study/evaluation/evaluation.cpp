#include "study/evaluation/evaluation.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "core/answer/farkas.h"
#include "core/answer/lcp_error.h"
#include "core/compliance.h"
#include "study/evaluation/contact_evaluation.h"

namespace lcpbench {
namespace {

constexpr Index kLargestBareOrderForTruth = 64;

/// Rows that are limited by what others carry are no LCP on a fixed box, of which the theorem is.
Truth bare_truth(const Lcp& lcp) {
  const std::vector<int>& of = lcp.bounds.friction_of;
  const bool has_friction = std::any_of(of.begin(), of.end(), [](int row) { return row >= 0; });
  if (has_friction || lcp.size() > kLargestBareOrderForTruth) return Truth::kUnknown;
  QuadMatrix symmetric(lcp.M);
  for (std::size_t i = 0; i < symmetric.rows; ++i) {
    for (std::size_t j = 0; j <= i; ++j) symmetric(i, j) = symmetric(j, i) = symmetric(i, j) + symmetric(j, i);
  }
  return proven_positive_definite(symmetric, 1) ? Truth::kSolvable : Truth::kUnknown;
}

/// Whether no impulses without end are missing the offset of a bounded row: it yields, its impulse has two bounds, or
/// the offset is zero, or of the sign in which a limit opens.
bool rest_satisfies(const BoundedRows& rows, Index row) {
  const int load = rows.bounds.friction_of[static_cast<std::size_t>(row)];
  if (rows.yields(row) > 0 || (load >= 0 && rows.yields(load) > 0) || rows.offset(row) == 0) return true;
  if (load >= 0) return std::isfinite(rows.bounds.upper(load));
  return rows.offset(row) > 0 ? std::isfinite(rows.bounds.lower(row)) : std::isfinite(rows.bounds.upper(row));
}

bool every_row_yields(const BoundedRows& rows) {
  for (Index row = 0; row < rows.size(); ++row) {
    const int load = rows.bounds.friction_of[static_cast<std::size_t>(row)];
    const Index of = load < 0 ? row : Index{load};
    const bool is_finite = std::isfinite(rows.bounds.lower(of)) && std::isfinite(rows.bounds.upper(of));
    if (!(rows.yields(row) > 0 || rows.yields(of) > 0 || is_finite)) return false;
  }
  return true;
}

/// Whether bodies at rest satisfy each contact, whatever impulses it takes: the same theorem with a regular G.
bool rest_satisfies(const ContactProblem& problem) {
  for (Index row = 0; row < problem.rows.size(); ++row) {
    if (!rest_satisfies(problem.rows, row)) return false;
  }
  for (Index i = 0; i < problem.nc(); ++i) {
    if (problem.normal_compliance(i) > 0) continue;
    const bool has_tangential_offset = problem.tangential_offset(i, 0) != 0 || problem.tangential_offset(i, 1) != 0;
    if (!(problem.offset(i) >= 0) || (has_tangential_offset && !(problem.tangential_compliance(i) > 0))) return false;
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
  explicit Data(const Problem& the_problem) : problem(the_problem), is_finite(why_not({}, problem).empty()) {
    if (!is_finite) return;
    if (problem.contact() == nullptr) {
      blocks = row_islands(problem.lcp().M);
    } else {
      contact.emplace(*problem.contact());
    }
  }

  Problem problem;  // keeps the data alive that the others refer to
  bool is_finite;   // it has neither NaN nor infinity; else nothing is measured
  RowIslands blocks;
  std::optional<ContactEvaluation> contact;
};

namespace {

Errors bare_errors(const Lcp& lcp, const RowIslands& blocks, const Answer& answer) {
  Errors errors;
  errors.usable = true;
  const QuadVector z = numbers(answer.z);
  const LcpError<Quad> error = lcp_error<Quad>(lcp, z, blocks);
  if (!lcp.is_mixed()) {
    if (!all_finite(error.w)) return errors;
    errors.min_z = z.empty() ? 0 : answer.z.minCoeff();
    errors.complementarity_j = to_double(complementarity(z, error.w));
  }
  errors.natural_residual = to_double(error.natural);
  errors.backward_row_norm = to_double(error.backward);
  errors.decide(kSolvedBackwardError);
  if (error.row >= 0) {
    errors.worst = {
        .row = error.row,
        .z = answer.z(error.row),
        .w = to_double(error.w[static_cast<std::size_t>(error.row)]),
        .scale = to_double(error.scale)};
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
  if (!errors.usable || !data_->is_finite) return errors;
  if (data_->contact) return data_->contact->errors(answer, FrictionModel::kPyramid);
  return bare_errors(data_->problem.lcp(), data_->blocks, answer);
}

Judgement Evaluator::judge(const Answer& answer) {
  Judgement judgement;
  judgement.errors = errors(answer);
  judgement.proof_holds = answer.farkas.size() > 0 && check_farkas(answer.farkas);
  if (!judgement.proof_holds) return judgement;
  if (const ContactProblem* contact = data_->problem.contact(); contact != nullptr) {
    judgement.errors.least_violation_m_per_s = least_violation(*contact, answer.farkas);
  } else {
    judgement.errors.proof_margin = proof_margin(data_->problem.lcp(), answer.farkas);
  }
  return judgement;
}

double Evaluator::forward_velocity(const Answer& answer) {
  const bool usable = answer.z.size() == data_->problem.size() && answer.z.allFinite();
  return usable && data_->contact ? data_->contact->forward_velocity(answer.z) : Errors::kNone;
}

void Evaluator::set_certified_velocity(const Vector& v_star) {
  const ContactProblem* const problem = data_->problem.contact();
  if (problem == nullptr || v_star.size() != problem->ngc() || !v_star.allFinite()) {
    throw std::invalid_argument("set_certified_velocity: needs a contact problem and ngc finite entries");
  }
  if (data_->contact) data_->contact->set_certified_velocity(v_star);
}

Truth Evaluator::truth() const {
  if (!data_->is_finite) return Truth::kUnknown;
  if (data_->problem.contact() == nullptr) return bare_truth(data_->problem.lcp());
  const ContactProblem& problem = *data_->problem.contact();
  if (!(problem.mu.array() >= 0).all()) return Truth::kUnknown;
  if (every_contact_yields(problem) && every_row_yields(problem.rows) && has_semidefinite_response(problem.inertia)) return Truth::kSolvable;
  if (!rest_satisfies(problem)) return Truth::kUnknown;
  return data_->contact->proven_positive_definite() ? Truth::kSolvable : Truth::kUnknown;
}

bool Evaluator::check_farkas(const Vector& u) const {
  const ContactProblem* const problem = data_->problem.contact();
  return problem != nullptr ? proves_unsolvable(*problem, u) : proves_unsolvable(data_->problem.lcp(), u);
}

}  // namespace lcpbench
