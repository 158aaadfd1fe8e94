#include "study/evaluation/evaluation.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory_resource>
#include <optional>
#include <stdexcept>
#include <type_traits>

#include "core/compliance.h"
#include "core/exact_inertia.h"
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
  return given == nullptr || ExactResponse::of(DenseInertia{given->Ginv}).has_value();
}

}  // namespace

struct Evaluator::Data {
  Data(const Problem& the_problem, Precision precision) : problem(the_problem) {
    if (!why_not({}, problem).empty()) return;  // it has NaN or infinity
    if (const ContactProblem* data = problem.contact()) {
      islands.emplace(row_islands(*data));
      if (precision == Precision::kAsNeeded) first.emplace(*data, *islands, &memory);
      if (first && !first->lcp) first.reset();
    } else {
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
  std::optional<IslandRows> islands;  // none where the data are not finite: then nothing is measured
  std::optional<ContactEvaluation<Bounded>> first;
  std::optional<ContactEvaluation<Quad>> quad;
  std::optional<Vector> v_star;
};

namespace {

// False when the answer has no measures.
template <class Real>
bool measure_rows(const std::vector<Real>& z, const std::vector<Real>& u, const std::vector<Real>& w, Errors& errors) {
  if (!all_finite(w) || !all_finite(u)) {
    if (std::is_same_v<Real, Bounded>) throw Doubt();
    return false;
  }
  errors.min_z = z.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (const Real& value : z) errors.min_z = std::min(errors.min_z, to_double(value));
  if (all_complementary(z, w)) {
    errors.natural_residual = errors.complementarity_j = 0;
    return true;
  }
  Real natural = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (!is_complementary(z[i], w[i])) natural = larger(natural, abs(smaller(z[i], w[i])));
  }
  errors.natural_residual = settled(natural);
  errors.complementarity_j = settled(dot(z, w));
  return true;
}

template <class Real>
Errors contact_errors(ContactEvaluation<Real>& contact, const Answer& answer, Errors errors) {
  if constexpr (std::is_same_v<Real, Quad>) errors.unresolved = contact.inertia.unresolved();
  if (!contact.lcp) return errors;
  const std::vector<Real> z = numbers<Real>(answer.z);
  std::vector<Real> u, w;
  if (!contact.respond(answer.z, z, u, w)) {
    errors.unresolved = true;
    return errors;
  }
  if (!measure_rows(z, u, w, errors)) return errors;
  contact.measure(z, u, w, errors);
  ReturnedVelocity<Real> returned(contact, z, u);
  errors.velocity_mismatch = returned.mismatch(answer.velocity);
  returned.measure(answer.velocity, errors);
  return errors;
}

Errors bare_errors(const Lcp& lcp, const IslandRows& islands, const Answer& answer, Errors errors) {
  const QuadVector z = numbers<Quad>(answer.z);
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

Evaluator::Evaluator(const Problem& problem, Precision precision) : data_(std::make_unique<Data>(problem, precision)) {}
Evaluator::~Evaluator() = default;

Errors Evaluator::errors(const Answer& answer) {
  Errors errors;
  errors.usable = answer.claim != Claim::kUnsupported && answer.z.size() == data_->problem.size() &&
                  answer.z.allFinite();  // a refusal has no answer, also where an answer has no numbers
  if (!errors.usable || !data_->islands) return errors;
  if (data_->problem.contact() == nullptr && data_->problem.lcp().is_mixed()) {
    return mixed_errors(data_->problem.lcp(), answer.z);
  }
  if (data_->problem.contact() == nullptr) {
    return bare_errors(data_->problem.lcp(), *data_->islands, answer, errors);
  }
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
  if (!usable || !data_->islands || data_->problem.contact() == nullptr) return Errors::kNone;
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
  if (!data_->islands) return Truth::kUnknown;
  if (data_->problem.contact() == nullptr) {
    return has_friction(data_->problem.lcp()) ? Truth::kUnknown : bare_truth(data_->problem.lcp());
  }
  const ContactProblem& problem = *data_->problem.contact();
  if (!(problem.mu.array() >= 0).all()) return Truth::kUnknown;
  if (every_contact_yields(problem) && has_semidefinite_response(problem.inertia)) return Truth::kSolvable;
  if (!rest_satisfies(problem)) return Truth::kUnknown;
  const bool proven = (data_->first && data_->first->inertia.proven_positive_definite()) ||
                      data_->in_quad().inertia.proven_positive_definite();
  return proven ? Truth::kSolvable : Truth::kUnknown;
}

bool Evaluator::check_farkas(const Vector& u) const {
  const ContactProblem* const problem = data_->problem.contact();
  if (problem != nullptr) return proves_unsolvable(*problem, u);
  return !data_->problem.lcp().is_mixed() && proves_unsolvable(data_->problem.lcp(), u);
}

}  // namespace lcpbench
