#include "native/answer_test/answer_test.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "core/entries.h"
#include "core/quad.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// With an offset that may ask for too much, bodies of more coordinates are not asked whether they have a solution: in
/// doubt that takes dense matrices.
constexpr Index kLargestAsked = 600;

/// About what the unit of AnswerTest::work_in_quad() takes.
constexpr double kSecondsPerMultiplication = 2e-10;

}  // namespace

AnswerTest::AnswerTest()
    : judge_(make_contact_lemke_engine(isa_level())), quad_judge_(contact_lemke::quad::create_engine()) {}

void AnswerTest::load(const Problem& problem, Bodies bodies, const IslandNumbers* numbers) {
  completed_.resize(problem.size());
  bare_ = problem.contact() == nullptr;
  by_bodies_ =
      bodies == Bodies::kOneByOne && !bare_ && std::holds_alternative<BlockInertia>(problem.contact()->inertia);
  may_be_unsolvable_ = is_singular_ = false;
  exact_.reset();
  contact_ = problem.contact();
  impulses_ = bare_ ? 0 : contact_->nc() + cols(contact_->D);
  if (bare_) return bare_test_.load(problem.lcp());
  const ContactProblem& contact = *contact_;
  quad_is_loaded_ = false;
  may_be_unsolvable_ = may_be_unsolvable(contact) && !(by_bodies_ && contact.ngc() > kLargestAsked);
  if (by_bodies_) {
    bodies_test_.load(contact, numbers);
  } else {
    contacts_.load(contact);
    quad_judge_->reserve(contacts_.input);
    judge_->load(contacts_.input);
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
  if (by_bodies_) return bodies_test_.set_velocity(v);
  contacts_.set_velocity(v);
  judge_->set_velocity(contacts_.v.data());
  if (quad_is_loaded_) quad_judge_->set_velocity(contacts_.v.data());
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
  return by_bodies_ ? solves_bodies() : solves_contacts();
}

/// Of contacts: sets the normal impulses to zero where no contact of the island approaches, which no impulses then
/// solve exactly, and friction impulses where no contact presses. Interior-point methods leave small impulses there.
/// Contacts without entries that do not yield along their normal are in no island: their impulses become zero, too.
void AnswerTest::release() {
  const bool has_islands = by_bodies_ || contacts_.input.island_of_contact != nullptr;
  const IslandNumbers& islands = by_bodies_ ? bodies_test_.islands() : contacts_.islands;
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

bool AnswerTest::solves_bodies() {
  if (bodies_test_.complete(completed_).certain <= std::max(kClaimedResidual, allowed_)) return true;
  const double allowed = std::max(kClaimedQuadResidual, allowed_);
  if (bodies_test_.least() > allowed) return false;
  const double work = bodies_test_.work_in_quad();
  if (!has_time_for(kSecondsPerMultiplication * work)) return false;
  work_in_quad_ += work;
  return residual_in_quad() <= allowed;
}

/// Sets the lambdas of completed_.
double AnswerTest::residual_in_quad() {
  if (!exact_) {
    exact_.emplace(*contact_);
    exact_->set_velocity(velocity_);
  }
  if (!exact_->lcp) return std::numeric_limits<double>::infinity();
  exact_->complete(completed_, point_);
  return exact_->rho(point_);
}

bool AnswerTest::solves_contacts() {
  const contact_lemke::Residual residual = judge_->complete(completed_.data());
  residual_ = residual.velocity;
  if (residual.certain <= kClaimedResidual) return true;
  return has_time_for_quad() && complete_in_quad().certain <= kClaimedQuadResidual;
}

/// Of contacts that are tested together. Sets the lambdas of completed_, and residual_.
contact_lemke::Residual AnswerTest::complete_in_quad() {
  constexpr double kPrice = 168;  // of a multiplication in 113 bits
  const auto ngc = static_cast<double>(contacts_.input.ngc);
  const auto impulses = static_cast<double>(impulses_);
  work_in_quad_ += kPrice * ngc * ((quad_is_loaded_ ? 0 : 2 * ngc * ngc) + 12 * (ngc + impulses));
  const contact_lemke::Residual residual = quad_judge().complete(completed_.data());
  residual_ = residual.velocity;
  return residual;
}

/// Whether the problem that completed_ seems to solve has a solution.
AnswerTest::Outcome AnswerTest::confirm(double deadline_s) {
  if (bare_) return bare_test_.disproves(completed_, deadline_s) ? Outcome::kUnsolvable : Outcome::kSolved;
  if (!is_singular_) return Outcome::kSolved;
  if (residual_ > kSureResidual && has_time_for_quad()) complete_in_quad();
  if (residual_ <= kSureResidual) return Outcome::kSolved;
  if (is_disproved(deadline_s)) return Outcome::kUnsolvable;
  return wall_clock_s() < deadline_s ? Outcome::kUnconfirmed : Outcome::kOutOfTime;
}

/// Of contacts: whether they are proven to have no solution.
bool AnswerTest::is_disproved(double deadline_s) {
  return may_be_unsolvable_ && farkas_.proves_unsolvable(velocity_, deadline_s);
}

/// Whether contacts that are tested together can be loaded in 113 bits before the deadline.
bool AnswerTest::has_time_for_quad() {
  if (quad_is_loaded_) return true;
  constexpr double kSecondsPerEntry = 5e-8;
  const auto ngc = static_cast<double>(contact_->ngc());
  return has_time_for(kSecondsPerEntry * ngc * (ngc * ngc + 2 * static_cast<double>(impulses_)));
}

/// Whether so many seconds, on a processor like those of today, end before the deadline; if not, notes it.
bool AnswerTest::has_time_for(double seconds) {
  const bool has_time = std::isinf(deadline_s_) || wall_clock_s() + seconds < deadline_s_;
  lacks_time_ = lacks_time_ || !has_time;
  return has_time;
}

contact_lemke::Engine& AnswerTest::quad_judge() {
  if (!quad_is_loaded_) quad_judge_->load(contacts_.input);
  quad_is_loaded_ = true;
  return *quad_judge_;
}

}  // namespace lcpbench
