#include "core/solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include "core/answer/contact_residual.h"
#include "core/answer/farkas.h"
#include "core/answer/lcp_error.h"
#include "core/answer/limits.h"
#include "core/compliance.h"
#include "core/contacts_of_rows.h"
#include "core/error.h"
#include "core/mixed_lcp.h"
#include "core/quad.h"

namespace lcpbench {
namespace {

/// In the order of Claim.
constexpr std::array kClaims{"solved",      "unsolvable", "iteration_limit", "time_limit", "numerical_failure",
                             "unsupported", "crashed"};

/// Calls visit(first, size) for all numbers of a problem, array by array.
template <class Visit>
void for_each_array(const Jacobian& J, const Visit& visit) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return visit(dense->data(), dense->size());
  const auto& sparse = std::get<SparseMatrix>(J);
  if (sparse.isCompressed()) return visit(sparse.valuePtr(), sparse.nonZeros());
  for (Index j = 0; j < sparse.outerSize(); ++j) {
    visit(sparse.valuePtr() + sparse.outerIndexPtr()[j], Index{sparse.innerNonZeroPtr()[j]});
  }
}

template <class Visit>
void for_each_array(const Problem& problem, const Visit& visit) {
  const ContactProblem* const contact = problem.contact();
  if (contact == nullptr) {
    visit(problem.lcp().M.data(), problem.lcp().M.size());
    visit(problem.lcp().bounds.mu.data(), problem.lcp().bounds.mu.size());
    return visit(problem.lcp().q.data(), problem.lcp().q.size());
  }
  for (const Vector* vector :
       {&contact->v, &contact->mu, &contact->b, &contact->compliance_n, &contact->compliance_t, &contact->offset_t}) {
    if (vector->size() > 0) visit(vector->data(), vector->size());
  }
  for_each_array(contact->N, visit);
  for_each_array(contact->D, visit);
  if (contact->has_rows()) {
    for_each_array(contact->rows.R, visit);
    for (const Vector* vector : {&contact->rows.b, &contact->rows.compliance, &contact->rows.bounds.mu}) {
      if (vector->size() > 0) visit(vector->data(), vector->size());
    }
  }
  for_each_matrix(contact->inertia, [&](const Matrix& matrix, Index) { visit(matrix.data(), matrix.size()); });
  const auto* factors = std::get_if<FactoredInertia>(&contact->inertia);
  if (factors != nullptr) visit(factors->alpha.data(), factors->alpha.size());
}

/// Eigen's allFinite() looks at one entry after the other, which for small problems takes as long as solving them. A
/// sum is finite only if all of its terms are; where finite terms overflow, Eigen has the last word. Eight sums do not
/// wait for one another.
bool data_are_finite(const Problem& problem) {
  constexpr Index kTogether = 8;
  double sum = 0;
  for_each_array(problem, [&](const double* entries, Index size) {
    double sums[kTogether] = {};
    Index i = 0;
    for (; i + kTogether <= size; i += kTogether) {
      for (Index k = 0; k < kTogether; ++k) sums[k] += entries[i + k];
    }
    double rest = 0;
    for (; i < size; ++i) rest += entries[i];
    sum += rest + (((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7])));
  });
  if (std::isfinite(sum)) return true;
  bool all = true;
  for_each_array(problem, [&](const double* entries, Index size) {
    all = all && Eigen::Map<const Vector>(entries, size).allFinite();
  });
  return all;
}

/// In 113 bits where products of three numbers may leave the range of double, and for limits of friction, which may be
/// large beside the row whose impulse they bound.
double backward_error(const Lcp& lcp, const Vector& z) {
  const auto is_moderate = [](double x) {
    return x == 0 || std::isinf(x) || (std::abs(x) > 1e-90 && std::abs(x) < 1e90);
  };
  const auto are_moderate = [&](const auto& numbers) { return numbers.unaryExpr(is_moderate).all(); };
  const LcpBounds& bounds = lcp.bounds;
  const bool moderate = bounds.mu.isZero(0) && are_moderate(bounds.lower) && are_moderate(bounds.upper) &&
                        are_moderate(lcp.M) && are_moderate(lcp.q) && are_moderate(z);
  if (moderate) return lcp_error(lcp, std::vector<double>(z.begin(), z.end())).backward;
  return to_double(lcp_error(lcp, std::vector<Quad>(z.begin(), z.end())).backward);
}

constexpr const char* kWrongUpdate = "update(v): needs a loaded contact problem and v of its ngc entries";

/// rho of z by the pyramid, from another velocity before the impact.
double velocity_residual(ContactProblem contact, const Vector& v, const Vector& z) {
  contact.v = v;
  ContactResidual residual(contact);
  return residual.lcp ? residual.rho(residual.at(z)) : std::numeric_limits<double>::infinity();
}

}  // namespace

const char* to_string(Claim claim) { return kClaims[static_cast<std::size_t>(claim)]; }

const char* to_string(Impulses impulses) {
  return std::array{"", "any", "even"}[static_cast<std::size_t>(impulses)];
}

Claim parse_claim(std::string_view text) {
  const auto found = std::find(kClaims.begin(), kClaims.end(), text);
  if (found != kClaims.end()) return static_cast<Claim>(found - kClaims.begin());
  throw InputError("unknown claim '" + std::string(text) + "'");
}

const char* to_string(Needs needs) {
  constexpr std::array kNames{"dense", "factored", "scene"};
  return kNames[static_cast<std::size_t>(needs)];
}

namespace {

std::string why_no_friction(const std::string& setting) {
  if (setting.empty()) return "needs a symmetric M: frictionless contacts only";
  return "has a round friction cone, which is another problem than this pyramid: " + setting + " solves that one";
}

/// Contacts that yield add coordinates of their own.
bool has_few_entries(const Problem& problem, Index most) {
  const ContactProblem* contact = problem.contact();
  return most > 0 && contact != nullptr && !contact->is_soft() &&
         dense_entries(*contact) + contact->ngc() * cols(contact->D) / 2 <= most;
}

std::string why_not(const Capabilities& capabilities, const Problem& problem, bool is_finite) {
  if (capabilities.needs == Needs::kScene && problem.scene() == nullptr) return "needs a rigid-body scene";
  if (capabilities.needs == Needs::kScene && problem.contact()->is_soft() && !capabilities.compliance) {
    return "takes no soft contacts: the equivalent rigid problem is no scene of bodies";
  }
  const bool takes_bounds = capabilities.boxed && problem.contact() == nullptr && problem.lcp().is_mixed();
  if (capabilities.needs == Needs::kFactored && problem.contact() == nullptr && !takes_bounds) {
    return "needs the contact problem (v, N, D, mu, G), not only (q, M)";
  }
  if (capabilities.captured_only && problem.engine_impulses() == nullptr) {
    return "needs a captured step with the impulses of its engine";
  }
  if (problem.size() > capabilities.max_size && !has_few_entries(problem, capabilities.max_entries)) {
    return "n = " + std::to_string(problem.size()) + " is over its limit of " + std::to_string(capabilities.max_size);
  }
  if (!is_finite && !data_are_finite(problem)) return "the data hold NaN or infinity";
  if (capabilities.frictionless_only) {
    if (const ContactProblem* contact = problem.contact()) {
      if (contact->frictional()) return why_no_friction(capabilities.friction_setting);
    } else if (problem.lcp().M != problem.lcp().M.transpose()) {
      return "needs a symmetric M";
    } else if (!capabilities.boxed && problem.lcp().bounds.needs_slacks()) {
      return "needs a symmetric M, which second bounds and friction rows do not leave";
    }
  }
  return {};
}


/// Methods on contacts take contacts in the place of bounded rows; those on matrices the mixed LCP.
bool is_for_contacts(const Capabilities& capabilities) {
  return capabilities.needs == Needs::kFactored || capabilities.compliance;
}

bool has_bounded_rows(const Problem& problem) { return problem.contact() != nullptr && problem.contact()->has_rows(); }

std::string why_no_rows(const Capabilities& capabilities, const Problem& problem) {
  if (capabilities.needs == Needs::kScene) return "takes no bounded rows";
  const BoundedRows& rows = problem.contact()->rows;
  if (capabilities.needs == Needs::kFactored && !capabilities.boxed && !ContactsOfRows::can_express(rows)) {
    return "takes no two rows of friction with one load, and no load with an upper bound";
  }
  if (rows.bounds.needs_slacks() && capabilities.frictionless_only && !capabilities.boxed) {
    return "needs a symmetric M, which second bounds and friction rows do not leave";
  }
  return {};
}

}  // namespace

std::string why_not(const Capabilities& capabilities, const Problem& problem) {
  if (!capabilities.rows && has_bounded_rows(problem)) {
    if (std::string reason = why_no_rows(capabilities, problem); !reason.empty()) return reason;
  }
  return why_not(capabilities, problem, false);
}

Lcp make_lcp(const Problem& problem) {
  return problem.contact() != nullptr ? form_lcp(*problem.contact(), problem.formation()) : problem.lcp();
}

void AnswerVector::resize(Index size) {
  if (size == this->size()) return;
  Vector::swap(memory_);  // one of the two is always empty
  if (size > 0) {
    Vector::resize(size);
    memory_.resize(0);
  }
}

void AnswerVector::reserve(Index size) {
  resize(0);
  memory_.resize(size);
}

void Answer::reserve(const Problem& problem) {
  clear();
  const ContactProblem* contact = problem.contact();
  z.reserve(problem.size());
  if (contact != nullptr) velocity.reserve(contact->ngc());
  farkas.reserve(contact != nullptr ? contact->nc() + contact->rows.size() : problem.size());
  detail.reserve(kLongestDetail);
}

void Answer::clear() {
  claim = Claim::kNumericalFailure;
  for (AnswerVector* vector : {&z, &velocity, &farkas}) vector->resize(0);
  counters = Counters{};
  impulses = Impulses::kUnstated;
  detail.clear();
}

namespace {

/// Its memory only grows: load() of some solvers allocates nothing for what they have had room for.
void keep(const Vector& v, Vector& kept) {
  if (kept.size() < v.size()) kept.resize(v.size());
  kept.head(v.size()) = v;
}

}  // namespace

/// The one place where bounded rows become contacts or a mixed LCP, soft contacts rigid, and mixed LCPs are reduced, for
/// solvers that know no others.
void Solver::take(const Problem& problem, bool is_finite) {
  contacts_of_rows_.reset();
  has_rows_ = !capabilities().rows && has_bounded_rows(problem);
  if (!has_rows_) return take_without_rows(problem, is_finite);
  with_rows_ = problem;
  problem_ = problem;
  refusal_ = why_no_rows(capabilities(), problem);
  if (refusal_.empty() && !is_finite && !data_are_finite(problem)) refusal_ = "the data hold NaN or infinity";
  if (!refusal_.empty()) return;
  const ContactProblem& contact = *problem.contact();
  if (is_for_contacts(capabilities()) && ContactsOfRows::can_express(contact.rows)) {
    contacts_of_rows_ = std::make_shared<ContactsOfRows>(contact);
    take_without_rows(Problem(problem.name(), contacts_of_rows_->contacts(), problem.formation()), false);
  } else {
    take_without_rows(Problem(problem.name(), make_lcp(problem)), false);
  }
}

void Solver::take_without_rows(const Problem& problem, bool is_finite) {
  problem_ = problem;
  if (requires_proofs_ && problem.contact() != nullptr) keep(problem.contact()->v, v_);
  is_equivalent_ = false;
  reduction_.reset();
  refusal_ = why_not(capabilities(), problem, is_finite);
  const ContactProblem* contact = problem.contact();
  if (refusal_.empty() && contact == nullptr && problem.lcp().is_mixed() && !capabilities().boxed) {
    reduction_ = std::make_shared<LcpReduction>(problem.lcp());
    given_ = problem;
    problem_ = Problem(problem.name(), reduction_->lcp());
    refusal_ = why_not(capabilities(), problem_, false);
    return;
  }
  if (!refusal_.empty() || contact == nullptr || !contact->is_soft() || capabilities().compliance) return;
  is_equivalent_ = true;
  keep(contact->v, v_);
  given_ = problem;
  problem_ = Problem(problem.name(), rigid_equivalent(*contact), problem.formation());
}

/// Whether no claim can hold on the rigid equivalent alone: no tangential offset is so fast that it counts in a scale,
/// and those that the problem has are of contacts that yield.
static bool is_like_its_equivalent(const ContactProblem& given) {
  constexpr double kSlow = 1e-2;  // m/s: a millionth of it is the least scale
  for (Index i = 0; i < given.offset_t.size(); ++i) {
    const double offset = std::abs(given.offset_t(i));
    if (offset != 0 && !(offset <= kSlow && given.tangential_compliance(i / 2) > 0)) return false;
  }
  return true;
}

/// The scales of the equivalent problem have the offsets in them, and its coordinates for these move, though little.
/// Only where this may matter the answer is tested, which allocates.
void Solver::return_to_given(Answer& answer) {
  const ContactProblem& given = *given_.contact();
  if (answer.velocity.size() > given.ngc()) {
    other_velocity_ = answer.velocity.head(given.ngc());
    std::swap(answer.velocity, other_velocity_);
  }
  const bool has_answer = answer.z.size() == given_.size() && answer.z.allFinite();
  if (answer.claim != Claim::kSolved || !has_answer || is_like_its_equivalent(given)) return;
  const Vector v = v_.head(given.ngc());
  if (velocity_residual(given, v, answer.z) <= kSolvedVelocityResidual) return;
  Vector all = problem_.contact()->v;
  all.head(v.size()) = v;
  if (velocity_residual(*problem_.contact(), all, answer.z) > kSolvedVelocityResidual) return;  // false by itself
  answer.claim = Claim::kNumericalFailure;
  answer.detail = "solves the equivalent rigid problem, but not the soft one";
}

/// The answer to the problem with bounded rows. A claim of the contacts, or of the mixed LCP, is tested where it may
/// not hold for the rows, which allocates. It stands where it is false for these, too: it is then the solver's own.
void Solver::return_to_rows(Answer& answer) {
  const ContactProblem& given = *with_rows_.contact();
  const Vector x = answer.z;
  if (contacts_of_rows_) {
    if (answer.velocity.size() > given.ngc()) answer.velocity = Vector(answer.velocity.head(given.ngc()));
    if (answer.z.size() > 0) answer.z = contacts_of_rows_->restore(answer.z);
    if (answer.farkas.size() > 0) answer.farkas = contacts_of_rows_->proof(answer.farkas);
  }
  const bool is_unproven = answer.farkas.size() > 0 && !proves_unsolvable(given, answer.farkas);
  if (answer.claim == Claim::kUnsolvable && (is_unproven || contacts_of_rows_ == nullptr)) {
    answer.claim = Claim::kNumericalFailure;
    if (contacts_of_rows_ == nullptr) answer.detail = "the mixed LCP, which is rounded, has no solution";
  }
  const bool has_answer = answer.z.size() == with_rows_.size() && answer.z.allFinite();
  if (answer.claim != Claim::kSolved || !has_answer) return;
  if (contacts_of_rows_) {
    const bool has_velocity = answer.velocity.size() == given.ngc();
    const Vector velocity = has_velocity ? Vector(answer.velocity) : post_impact_velocity(given, answer.z);
    if (!contacts_of_rows_->is_in_doubt(given, x, answer.z, velocity)) return;
  }
  if (velocity_residual(given, given.v, answer.z) <= kSolvedVelocityResidual) return;
  if (contacts_of_rows_) {
    const ContactProblem& contacts = contacts_of_rows_->contacts();
    if (velocity_residual(contacts, contacts.v, x) > kSolvedVelocityResidual) return;
  } else if (!(backward_error(with_rows_.lcp(), answer.z) <= kSolvedBackwardError)) {
    return;
  }
  answer.claim = Claim::kNumericalFailure;
  answer.detail = "solves the problem in other words, but not the bounded rows";
}

/// A claim stands as far as it is the solver's own: not where rounding in the reduction is what made it false.
void Solver::return_to_mixed(Answer& answer) const {
  if (answer.claim == Claim::kUnsolvable && !reduction_->is_exact()) {
    answer.claim = Claim::kNumericalFailure;
    answer.detail = "the reduced problem, which is rounded, has no solution";
  }
  answer.farkas.resize(0);  // of another problem
  if (answer.z.size() != problem_.size()) return;
  const Vector z = reduction_->restore(answer.z);
  if (answer.claim == Claim::kSolved && !(backward_error(given_.lcp(), z) <= kSolvedBackwardError)) {
    Lcp reduced = reduction_->lcp();
    reduced.bounds = LcpBounds::nonnegative(reduced.size());
    if (backward_error(reduced, answer.z) <= kSolvedBackwardError) {
      answer.claim = Claim::kNumericalFailure;
      answer.detail = "solves the reduced problem, but not the mixed one";
    }
  }
  answer.z = z;
}

void Solver::withdraw_unproven(Answer& answer) const {
  if (answer.farkas.size() == 0) return;
  const ContactProblem* contact = (is_equivalent_ ? given_ : problem_).contact();
  const bool is_proven = contact != nullptr ? proves_unsolvable(*contact, v_.head(contact->ngc()), answer.farkas)
                                            : proves_unsolvable(problem_.lcp(), answer.farkas);
  if (!is_proven) answer.claim = Claim::kNumericalFailure;
}

void Solver::load(const Problem& problem) {
  take(problem, false);
  if (refusal_.empty()) on_load(problem_);
}

void Solver::load_finite(const Problem& problem) {
  take(problem, true);
  if (refusal_.empty()) on_load(problem_);
}

void Solver::update(const Vector& v) {
  if (has_rows_) {
    if (!refusal_.empty() || v.size() != with_rows_.contact()->ngc()) throw std::invalid_argument(kWrongUpdate);
    ContactProblem contact = *with_rows_.contact();
    contact.v = v;
    return update(Problem(with_rows_.name(), std::move(contact), with_rows_.formation()));
  }
  const ContactProblem* contact = refusal_.empty() ? problem_.contact() : nullptr;
  if (contact == nullptr || v.size() != (is_equivalent_ ? given_.contact()->ngc() : contact->ngc())) {
    throw std::invalid_argument(kWrongUpdate);
  }
  if (requires_proofs_ || is_equivalent_) keep(v, v_);
  if (!is_equivalent_) return on_update(v);
  Vector all = contact->v;
  all.head(v.size()) = v;
  on_update(all);
}

void Solver::update(const Problem& problem) {
  take(problem, false);
  if (refusal_.empty()) on_change(problem_);
}

void Solver::on_update(const Vector& v) {
  ContactProblem contact = *problem_.contact();
  contact.v = v;
  const bool is_equivalent = is_equivalent_;  // what is loaded here is rigid
  load(Problem(problem_.name(), std::move(contact), problem_.formation()));
  is_equivalent_ = is_equivalent;
}

void Solver::solve(const SolveRequest& request, Answer& answer) {
  if (!refusal_.empty()) {  // problem_ may be no problem: nothing was loaded
    answer.clear();
    answer.claim = Claim::kUnsupported;
    answer.detail = refusal_;
    return;
  }
  // The memory for the longer velocity of a rigid equivalent is kept from one solve to the next.
  const bool has_room = is_equivalent_ && other_velocity_.size() == problem_.contact()->ngc();
  if (has_room) std::swap(answer.velocity, other_velocity_);
  answer.reserve(problem_);
  answer.z.resize(problem_.size());
  answer.z.setZero();
  SolveRequest own = request;
  Vector start;
  if (reduction_ || (has_rows_ && !contacts_of_rows_)) own.start = nullptr;
  if (own.start != nullptr && contacts_of_rows_) {
    start = contacts_of_rows_->start(*own.start);
    own.start = &start;
  }
  on_solve(own, answer);
  if (is_equivalent_) return_to_given(answer);
  if (answer.claim != Claim::kUnsolvable) answer.farkas.resize(0);  // of a part, or of a method whose turn is over
  if (requires_proofs_ && answer.claim == Claim::kUnsolvable) withdraw_unproven(answer);
  if (reduction_) return_to_mixed(answer);
  if (has_rows_) return_to_rows(answer);
  if (answer.claim == Claim::kNumericalFailure && answer.detail.empty()) {
    answer.detail = answer.z.allFinite() ? "found no answer that passes its test" : "its numbers became infinite";
  }
  // A solver that refuses only here may leave the zeros it was handed, and zeros solve some problems.
  if (answer.claim != Claim::kUnsupported) return;
  for (AnswerVector* vector : {&answer.z, &answer.velocity, &answer.farkas}) vector->resize(0);
}

}  // namespace lcpbench
