#include "native/auto/island.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "native/answer_test/rest.h"
#include "native/contacts/contact_impulses.h"
#include "native/contacts/row_bounds.h"
#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {
void IslandOfProblem::load(ProblemCutter& whole, const Island& island, const Vector& v, std::vector<char>& carries,
                           const IslandSolver::Load& how) {
  cutter_ = &whole;
  how_ = how;
  carries_ = &carries;
  island_ = island;
  is_loaded_ = false;
  update(v);
}

void IslandOfProblem::update(const Vector& v) {
  const ContactProblem& whole = cutter_->whole();
  is_at_rest_ = std::ranges::none_of(island_.contacts, [&, to_rounding = may_be_unsolvable(whole)](Index contact) {
    return may_approach(whole, contact, v, to_rounding);
  });
  if (is_at_rest_) return;
  if (is_loaded_) {
    for (Index i = 0; i < v_.size(); ++i) v_(i) = v(island_.coordinates[static_cast<std::size_t>(i)]);
    return solver_.update(v_);
  }
  cut(v);
  solver_.load(problem_, v_, how_);
  is_loaded_ = true;
}

void IslandOfProblem::cut(const Vector& v) {
  ProblemCutter& whole = *cutter_;
  const ContactProblem& given = whole.whole();
  // Where mu = 0 the slip gives lambda, which body by body is as certain as the velocity. In an inertia that couples
  // more, or in bodies near singular, the directions of friction may be the ones that double knows nothing of: then
  // their rows are solved and tested too.
  const bool by_bodies = std::holds_alternative<BlockInertia>(given.inertia);
  bool has_friction = false;
  bool has_rows = false;
  for (const Index contact : island_.contacts) {
    const bool rows = given.edges[static_cast<std::size_t>(contact)] > 0;
    has_rows = has_rows || rows;
    has_friction = has_friction || (rows && given.mu(contact) > 0);
  }
  const auto cut_out = [&](bool with_friction) {
    problem_ = Problem();
    if (part_.use_count() != 1) part_.swap(spare_);
    if (part_.use_count() != 1) part_ = std::make_shared<ContactProblem>();
    whole.cut(island_.contacts, island_.coordinates, v, with_friction, *part_);
    problem_ = Problem("", part_);
  };
  const bool keeps_rows = has_friction || (has_rows && !by_bodies);
  const bool is_whole = keeps_rows == has_rows && static_cast<Index>(island_.contacts.size()) == given.nc() &&
                        static_cast<Index>(island_.coordinates.size()) == given.ngc() && v == given.v;
  if (is_whole) {
    problem_ = whole.problem();
  } else {
    cut_out(keeps_rows);
  }
  if (by_bodies && has_rows && !has_friction && !is_benign(problem_.contact()->inertia)) cut_out(true);
  place_unknowns(whole.layout());
  v_ = problem_.contact()->v;
  u_.resize(v_.size());
  start_.resize(problem_.size());
  answer_.reserve(problem_);
}

void IslandOfProblem::place_unknowns(const ContactLayout& layout) {
  const std::vector<Index>& contacts = island_.contacts;
  place_.assign(contacts.begin(), contacts.end());
  if (!problem_.contact()->frictional()) return;
  for (const Index contact : contacts) {
    const auto c = static_cast<std::size_t>(contact);
    for (Index t = layout.friction_begin[c]; t < layout.friction_begin[c + 1]; ++t) {
      place_.push_back(layout.friction_offset() + t);
    }
  }
  for (const Index contact : contacts) {
    const Index lambda = layout.lambda[static_cast<std::size_t>(contact)];
    if (lambda >= 0) place_.push_back(layout.lambda_offset() + lambda);
  }
}

Claim IslandOfProblem::solve(const Vector* start, const AutoLimits& limits, Vector& z, Vector& u, AutoReport& report) {
  if (is_at_rest_) return remain_at_rest(report);
  if (start != nullptr) {
    for (Index i = 0; i < start_.size(); ++i) start_(i) = (*start)(place_[static_cast<std::size_t>(i)]);
  }
  solver_.solve(start != nullptr ? &start_ : nullptr, limits, answer_, report);
  if (answer_.claim != Claim::kSolved && answer_.claim != Claim::kUnsolvable && rests(u)) {
    is_at_rest_ = true;
    return remain_at_rest(report);
  }
  for (Index i = 0; i < answer_.z.size(); ++i) z(place_[static_cast<std::size_t>(i)]) = answer_.z(i);
  tell_what_is_carried();
  // Of contacts that have friction rows and a lambda, but not in the answer, the slip is asked for.
  const bool asks_for_slip = !problem_.contact()->frictional() && cutter_->whole().frictional();
  if (answer_.claim == Claim::kSolved && (gave_velocity() || asks_for_slip)) write_velocity(u);
  return answer_.claim;
}

void IslandOfProblem::write_velocity(Vector& u) {
  if (answer_.velocity.size() == 0) solver_.respond(answer_, u_);
  const Vector& own = answer_.velocity.size() > 0 ? static_cast<const Vector&>(answer_.velocity) : u_;
  for (Index i = 0; i < own.size(); ++i) u(island_.coordinates[static_cast<std::size_t>(i)]) = own(i);
}

/// Whether z = 0 solves the island, where no method does.
bool IslandOfProblem::rests(const Vector& u) const {
  RestTest test(cutter_->whole(), cutter_->layout(), u);
  for (const Index contact : island_.contacts) test.add(contact);
  return test.passes();
}

Claim IslandOfProblem::remain_at_rest(AutoReport& report) {
  ++report.at_rest;
  tell_what_is_carried();
  return Claim::kSolved;
}

void IslandOfProblem::tell_what_is_carried() {
  const bool carries = !is_at_rest_ && problem_.contact()->frictional();
  for (const Index contact : island_.contacts) (*carries_)[static_cast<std::size_t>(contact)] = carries ? 1 : 0;
}

}  // namespace lcpbench
