#include "native/answer_test/answer_test.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "core/entries.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// With an offset that may ask for too much, bodies of more coordinates are not asked whether they have a solution: in
/// doubt that takes dense matrices.
constexpr Index kLargestAsked = 600;

/// About what the unit of AnswerTest::work_in_quad() takes.
constexpr double kSecondsPerMultiplication = 2e-10;

/// Of 113 bits, fitted to times of piles, walls and blocks of 2 to 20 coordinates, in that unit: for each entry of
/// [N D], for each coordinate, and for the cube of each block's order.
constexpr double kWorkOfEntry = 560, kWorkOfCoordinate = 6000, kWorkOfCube = 100;

Index nonzeros(const Matrix& J) { return (J.array() != 0).count(); }
Index nonzeros(const SparseMatrix& J) { return J.nonZeros(); }

double work_in_quad_of(const ContactProblem& contact) {
  const auto cube = [](Index order) { return kWorkOfCube * static_cast<double>(order * order * order); };
  const auto* const bodies = std::get_if<BlockInertia>(&contact.inertia);
  double work = kWorkOfCoordinate * static_cast<double>(contact.ngc()) + (bodies == nullptr ? cube(contact.ngc()) : 0);
  for (std::size_t k = 0; bodies != nullptr && k < bodies->blocks.size(); ++k) work += cube(bodies->blocks[k].rows());
  for (const Jacobian* J : {&contact.N, &contact.D}) {
    const Index entries = std::visit([](const auto& matrix) { return nonzeros(matrix); }, *J);
    work += kWorkOfEntry * static_cast<double>(entries);
  }
  return work;
}

}  // namespace

AnswerTest::AnswerTest() : judge_(make_contact_lemke_engine(isa_level())) {}

void AnswerTest::load(const Problem& problem, const IslandNumbers* numbers) {
  completed_.resize(problem.size());
  bare_ = problem.contact() == nullptr;
  may_be_unsolvable_ = is_singular_ = false;
  exact_.reset();
  contact_ = problem.contact();
  if (bare_) return bare_test_.load(problem.lcp());
  const ContactProblem& contact = *contact_;
  by_blocks_ = std::holds_alternative<BlockInertia>(contact.inertia);
  by_factors_ = std::holds_alternative<FactoredInertia>(contact.inertia);
  may_be_unsolvable_ = may_be_unsolvable(contact) && !(by_blocks_ && contact.ngc() > kLargestAsked);
  if (by_factors_) {
    contacts_.load(contact);
    judge_->load(contacts_.input);
  } else {
    contact_test_.load(contact, numbers);
  }
  doubtful_.load(contact);
  is_singular_ = doubtful_.may_be_singular();
  if (may_be_unsolvable_) farkas_.load(contact);
  velocity_ = contact.v;
  moves_.reserve(static_cast<std::size_t>(contact.nc()));  // no island is without a contact
}

void AnswerTest::set_velocity(const Vector& v) {
  velocity_ = v;
  if (exact_) exact_->set_velocity(v);
  if (!by_factors_) return contact_test_.set_velocity(v);
  contacts_.set_velocity(v);
  judge_->set_velocity(contacts_.v.data());
}

bool AnswerTest::settle(Answer& answer, double deadline_s) {
  if (answer.claim != Claim::kSolved) return false;
  deadline_s_ = deadline_s;
  work_in_quad_ = 0;
  lacks_time_ = false;
  Outcome outcome = Outcome::kResidual;
  if (solves(answer.z)) {
    outcome = confirm(deadline_s);
  } else if (lacks_time_) {
    outcome = Outcome::kOutOfTime;
  }
  switch (outcome) {
    case Outcome::kSolved:
      completed_.swap(answer.z);
      if (bare_ || !is_singular_ || doubtful_.confirms(*contact_, velocity_, answer)) return true;
      completed_.swap(answer.z);
      answer.detail = "residual";
      break;
    case Outcome::kUnsolvable: report_proof(answer); return false;
    case Outcome::kResidual: answer.detail = "residual"; break;
    case Outcome::kUnconfirmed: answer.detail = "unconfirmed"; break;
    case Outcome::kOutOfTime:
      answer.claim = Claim::kTimeLimit;
      answer.detail.clear();
      return false;
  }
  answer.claim = Claim::kNumericalFailure;
  return false;
}

void AnswerTest::settle_ray(Answer& answer, double deadline_s, const Vector* u) {
  bool proven = false;
  if (bare_) {
    proven = u != nullptr ? bare_test_.disproves_near(*u, deadline_s) : bare_test_.disproves(deadline_s);
  } else {
    proven = is_disproved(deadline_s);
  }
  if (proven) return report_proof(answer);
  answer.claim = Claim::kNumericalFailure;
  answer.detail = "ray";
}

void AnswerTest::report_proof(Answer& answer) {
  answer.claim = Claim::kUnsolvable;
  answer.detail = bare_ ? "proven" : "the normals contradict each other";
  answer.farkas = bare_ ? bare_test_.proof() : farkas_.proof();
}

bool AnswerTest::solves(const Vector& z) {
  backward_error_ = std::numeric_limits<double>::infinity();
  if (!z.allFinite()) return false;
  completed_ = z.cwiseMax(0.0);
  if (bare_) return (backward_error_ = bare_test_.backward_error(completed_)) <= kClaimedBackwardError;
  release();
  return solves_contacts();
}

/// Of contacts: sets the normal impulses to zero where no contact of the island approaches, which no impulses then
/// solve exactly, and friction impulses where no contact presses. Interior-point methods leave small impulses there.
/// Contacts without entries that do not yield along their normal are in no island: their impulses become zero, too.
void AnswerTest::release() {
  const bool has_islands = !by_factors_ || contacts_.input.island_of_contact != nullptr;
  const IslandNumbers& islands = by_factors_ ? contacts_.islands : contact_test_.islands();
  const auto island_of = [&](Index c) { return has_islands ? islands.of_contact[static_cast<std::size_t>(c)] : 0; };
  moves_.assign(static_cast<std::size_t>(has_islands ? islands.count : 1), 0);
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index island = island_of(c);
    if (island < 0 || moves_[static_cast<std::size_t>(island)] != 0) continue;
    double q = contact_->offset(c);
    for_each_entry(contact_->N, c, [&](Index i, double entry) { q += entry * velocity_(i); });
    if (!(q >= 0)) moves_[static_cast<std::size_t>(island)] = 1;
  }
  Index first = contact_->nc();  // friction impulse of the contact
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index island = island_of(c);
    if (island < 0 || moves_[static_cast<std::size_t>(island)] == 0) completed_(c) = 0;
    const Index edges = contact_->edges[static_cast<std::size_t>(c)];
    if (!(completed_(c) > 0)) completed_.segment(first, edges).setZero();
    first += edges;
  }
}

bool AnswerTest::solves_contacts() {
  const contact_lemke::Residual residual =
      by_factors_ ? judge_->complete(completed_.data()) : contact_test_.complete(completed_);
  residual_ = residual.velocity;
  // By factors, velocity + rounding <= certain in the worst row.
  least_ = by_factors_ ? 2 * residual.velocity - residual.certain : contact_test_.least();
  const double allowed = by_blocks_ ? allowed_ : 0;
  if (residual.certain <= std::max(kClaimedResidual, allowed)) return true;
  if (least_ > std::max(kClaimedQuadResidual, allowed)) return false;
  return measure_in_quad() && residual_ <= std::max(kClaimedQuadResidual, allowed);
}

/// Sets the lambdas of completed_, and residual_. @returns false where there is no time for that
bool AnswerTest::measure_in_quad() {
  const double work = work_in_quad_of(*contact_);
  const bool has_time = std::isinf(deadline_s_) || wall_clock_s() + kSecondsPerMultiplication * work < deadline_s_;
  lacks_time_ = lacks_time_ || !has_time;
  if (!has_time) return false;
  work_in_quad_ += work;
  if (!exact_) {
    exact_.emplace(*contact_);
    exact_->set_velocity(velocity_);
  }
  residual_ = least_ = std::numeric_limits<double>::infinity();
  if (!exact_->lcp) return true;
  exact_->complete(completed_, point_);
  residual_ = least_ = exact_->rho(point_);
  return true;
}

/// Whether the problem that completed_ seems to solve has a solution.
AnswerTest::Outcome AnswerTest::confirm(double deadline_s) {
  if (bare_) return bare_test_.disproves(completed_, deadline_s) ? Outcome::kUnsolvable : Outcome::kSolved;
  if (!is_singular_) return Outcome::kSolved;
  if (residual_ > kSureResidual && !(least_ > kSureResidual)) measure_in_quad();
  if (residual_ <= kSureResidual) return Outcome::kSolved;
  if (is_disproved(deadline_s)) return Outcome::kUnsolvable;
  return wall_clock_s() < deadline_s ? Outcome::kUnconfirmed : Outcome::kOutOfTime;
}

/// Of contacts: whether they are proven to have no solution.
bool AnswerTest::is_disproved(double deadline_s) {
  return may_be_unsolvable_ && farkas_.proves_unsolvable(velocity_, deadline_s);
}

}  // namespace lcpbench
