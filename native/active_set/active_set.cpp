#include "native/active_set/active_set.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <variant>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/contacts/dense_data.h"

namespace lcpbench {
namespace {

using active_set::Ending;
using active_set::InertiaForm;

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .frictionless_only = true,
    .max_size = 10000,  // the whitened normals and the active ones are dense
    .max_entries = 1'000'000,
    .guarantees = "every frictionless contact problem: solved, or recognised as unsolvable",
    .warm_start = true,
    .obeys_time_limit = true,
    .allocation_free = true};

constexpr Capabilities kSoft = with_compliance(kCapabilities);

/// Products of coordinates and contacts up to which sixteen steps take microseconds at most.
constexpr std::ptrdiff_t kSmallSystem = 1024;

/// More multiplications than any limit on work asks for.
constexpr double kMostWork = 0x1p60;

/// What load() needs to know to take memory, for an inertia in any form.
active_set::Input dimensions_of(const ContactProblem& contact) {
  const auto* factored = std::get_if<FactoredInertia>(&contact.inertia);
  return {.ngc = contact.ngc(),
          .nc = contact.nc(),
          .soft = contact.compliance_n.size(),
          .form = InertiaForm::kFactors,
          .factors = factored != nullptr ? factored->X.cols() : contact.ngc()};
}

void report(const active_set::Outcome& outcome, Answer& answer) {
  answer.counters.iterations = outcome.steps;
  answer.counters.pivots = outcome.steps;
  answer.counters.factorizations = outcome.factorizations;
  switch (outcome.ending) {
    case Ending::kSolved: answer.claim = Claim::kSolved; return;
    case Ending::kInfeasible: answer.claim = Claim::kUnsolvable; return;
    case Ending::kRejected:
      answer.claim = Claim::kNumericalFailure;
      answer.detail = "own test failed";
      return;
    case Ending::kStepLimit:
    case Ending::kWorkLimit: answer.claim = Claim::kIterationLimit; return;
    case Ending::kTimeLimit: answer.claim = Claim::kTimeLimit; return;
    case Ending::kBreakdown:
      answer.claim = Claim::kNumericalFailure;
      answer.detail = "inertia";
      return;
  }
}

}  // namespace

active_set::Engine::~Engine() = default;

std::unique_ptr<active_set::Engine> make_active_set_engine(IsaLevel level) {
  if (level > best_isa_level()) throw std::invalid_argument("this processor lacks the instruction-set level asked for");
#if defined(__x86_64__)
  if (level >= IsaLevel::kAvx2) return std::unique_ptr<active_set::Engine>(active_set::avx2::create_engine());
#endif
  return std::unique_ptr<active_set::Engine>(active_set::baseline::create_engine());
}

ActiveSet::ActiveSet(const ActiveSetSettings& settings, IsaLevel level)
    : settings_(settings), engine_(make_active_set_engine(level)) {}

const Capabilities& ActiveSet::capabilities() const {
  return yields_without_friction(problem()) ? kSoft : kCapabilities;
}

double ActiveSet::load_work(const Problem& problem, Index idle) {
  const ContactProblem& contact = *problem.contact();
  const double ngc = static_cast<double>(contact.ngc() - idle);
  const double nc = static_cast<double>(contact.nc());
  // Fitted to what the engine in double takes; of blocks it leaves out the zeros.
  if (std::holds_alternative<BlockInertia>(contact.inertia)) return 15 * ngc * (ngc + nc) + 10000;
  return ngc * ngc * (ngc / 2 + nc) + 10000;
}

void ActiveSet::reserve(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  engine_->reserve(dimensions_of(contact));
  doubtful_.reserve(contact);
  v_.reserve(contact.ngc());
  dense_normals_.reserve(contact.ngc() * contact.nc());
  dense_inertia_.reserve(contact.ngc() * contact.ngc());
  farkas_.reserve(contact.nc());
  islands_.reserve(contact.ngc(), contact.nc());
}

void ActiveSet::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  describe(contact);
  doubtful_.load(contact);
  engine_->load(input_);
  farkas_.resize(input_.nc);
  outcome_ = {};
}

/// Points input_ to the problem's own arrays where it has dense ones.
void ActiveSet::describe(const ContactProblem& contact) {
  input_ = {};
  input_.ngc = contact.ngc();
  input_.nc = contact.nc();
  v_ = contact.v;
  input_.v = v_.data();
  input_.N = dense_data(contact.N, dense_normals_);
  if (contact.has_offset()) input_.b = contact.b.data();
  if (contact.compliance_n.size() > 0) {
    input_.soft = input_.nc;
    input_.compliance = contact.compliance_n.data();
  }
  if (const auto* dense = std::get_if<DenseInertia>(&contact.inertia)) {
    input_.matrix = dense->G.data();
  } else if (const auto* factors = std::get_if<FactoredInertia>(&contact.inertia)) {
    input_.form = InertiaForm::kFactors;
    input_.matrix = factors->X.data();
    input_.factors = factors->X.cols();
    input_.alpha = factors->alpha.data();
  } else if (const auto* inverse = std::get_if<InverseInertia>(&contact.inertia)) {
    input_.form = InertiaForm::kInverse;
    input_.matrix = inverse->Ginv.data();
  } else {
    copy_dense(std::get<BlockInertia>(contact.inertia), input_.ngc, dense_inertia_);
    input_.matrix = dense_inertia_.data();
  }
  // With an offset, a contact that nothing moves has a w of its own: it may not be counted to the island of the others.
  if (couples_all(contact.inertia) && !contact.has_offset()) return;
  islands_.find(contact);
  input_.islands = islands_.count;
  input_.island_of_contact = islands_.of_contact.data();
  input_.island_of_coordinate = islands_.of_coordinate.data();
}

void ActiveSet::on_update(const Vector& v) {
  if (!v.allFinite()) return Solver::on_update(v);  // refuses it, as load does
  v_ = v;
  engine_->update(v_.data());
}

void ActiveSet::begin_solve(const Vector* start) {
  outcome_ = {};
  rules_ = {};
  rules_.accept_residual = accepted();
  rules_.max_steps = settings_.max_iterations > 0 ? static_cast<std::ptrdiff_t>(settings_.max_iterations)
                                                  : 20 * (input_.nc + input_.ngc) + 100;
  rules_.clock_s = wall_clock_s;
  rules_.time_limit_s = std::numeric_limits<double>::infinity();
  if (start != nullptr && start->size() == input_.nc) rules_.start = start->data();
}

bool ActiveSet::solve_within(const Budget& budget, Answer& answer) {
  begin_solve(budget.start);
  if (budget.work < kMostWork) rules_.max_work = static_cast<std::ptrdiff_t>(std::ceil(budget.work));
  rules_.begin_s = 0;
  rules_.time_limit_s = budget.deadline_s;
  answer.reserve(problem());
  answer.z.resize(problem().size());
  answer.z.setZero();
  answer.velocity.resize(input_.ngc);
  const bool is_too_late = std::isfinite(budget.deadline_s) && !(wall_clock_s() < budget.deadline_s);
  if (is_too_late) {
    outcome_.ending = Ending::kTimeLimit;
  } else {
    outcome_ = engine_->solve(rules_, answer.z.data(), answer.velocity.data(), farkas_.data());
  }
  const bool has_ended = outcome_.ending != Ending::kWorkLimit;
  finish(answer);
  return has_ended;
}

void ActiveSet::on_solve(const SolveRequest& request, Answer& answer) {
  if (!(request.time_limit_s > 0)) {  // the clock is first read after some steps
    return report({.ending = Ending::kTimeLimit}, answer);
  }
  begin_solve(request.start);
  rules_.time_limit_s = request.time_limit_s;
  // Reading the clock takes as long as several steps of a small problem.
  const bool reads_clock = !std::isinf(request.time_limit_s) && input_.ngc * input_.nc > kSmallSystem;
  rules_.begin_s = reads_clock ? wall_clock_s() : std::numeric_limits<double>::quiet_NaN();
  answer.velocity.resize(input_.ngc);
  outcome_ = engine_->solve(rules_, answer.z.data(), answer.velocity.data(), farkas_.data());
  finish(answer);
}

double ActiveSet::residual(const Answer& answer) {
  const bool has_answer = outcome_.ending == Ending::kSolved || outcome_.ending == Ending::kRejected;
  return has_answer ? engine_->residual(answer.z.data()) : std::numeric_limits<double>::infinity();
}

/// Writes claim, proof and text of a solve that has ended.
void ActiveSet::finish(Answer& answer) {
  if (outcome_.ending == Ending::kSolved && !doubtful_.confirms(*problem().contact(), v_.view(), answer)) {
    outcome_.ending = Ending::kRejected;
  }
  const bool has_answer = outcome_.ending == Ending::kSolved || outcome_.ending == Ending::kRejected;
  const bool is_unproven = outcome_.ending == Ending::kInfeasible && !is_disproved();
  if (is_unproven) outcome_.ending = Ending::kBreakdown;
  if (!has_answer || !outcome_.has_velocity) answer.velocity.resize(0);
  if (outcome_.ending == Ending::kInfeasible) {
    answer.farkas.resize(input_.nc);
    farkas_support_.write_proof(answer.farkas);
  }
  report(outcome_, answer);
  if (is_unproven) answer.detail = "no proof";
}

/// The largest residual, relative to the scale of each island, of an answer that is claimed as solved.
double ActiveSet::accepted() const {
  return std::min(settings_.accept_residual, doubtful_.may_be_singular() ? kSureResidual : kClaimedResidual);
}

/// Whether the contacts of farkas_ prove that there is no solution.
bool ActiveSet::is_disproved() {
  if (input_.compliance != nullptr) return false;  // the proof knows nothing of it
  constexpr double kNoShare = 0x1p-80;             // of the largest: rounding
  const double largest = farkas_.view().maxCoeff();
  support_.clear();
  for (Index j = 0; j < input_.nc; ++j) {
    if (farkas_(j) > kNoShare * largest) support_.push_back(j);
  }
  const Index factors = input_.form == InertiaForm::kFactors ? input_.factors : input_.ngc;
  const FarkasSupport::ConstMatrixMap X(input_.matrix, input_.ngc, factors);
  const bool asks_too_much = input_.form == InertiaForm::kDense && input_.b != nullptr;  // of regular inertia
  return farkas_support_.proves_unsolvable(*problem().contact(), asks_too_much ? nullptr : &X, v_.data(), support_);
}

SolverDefinition lcpbench_solver_active_set() {
  return define_solver<ActiveSet, ActiveSetSettings>(
      {.name = "active_set",
       .summary = "dual active set for the projection of v on the frictionless contacts, in whitened velocity space",
       .source =
           "Goldfarb, Idnani 1983, A numerically stable dual method for solving strictly convex quadratic programs",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
