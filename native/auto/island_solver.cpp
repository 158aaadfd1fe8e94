#include "native/auto/island_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "native/answer_test/contact_solvability.h"
#include "native/auto/rest.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {
namespace {

/// Approaching faster than this part of max|N'v|, a contact that was left out presses; far below what the test of an
/// answer allows, above the rounding of the velocity.
constexpr double kApproaching = 1e-9;

/// Leave contacts out only if they are at least 1/8 of the island: the whole island has to be cut out as well.
constexpr std::size_t kLeastShare = 8;

/// Coordinates of a small island.
constexpr std::size_t kMostInTurn = 64;

/// w of the contact's normal row at u.
double normal_row(const ContactProblem& problem, Index contact, const Vector& u) {
  const double velocity = dot_column(problem.N, contact, u);
  return problem.has_offset() ? velocity + problem.b(contact) : velocity;
}

/// More than normal_row() rounds; 0 only where there is nothing to round.
double rounding_of_row(const ContactProblem& problem, Index contact, const Vector& v) {
  constexpr double kTwoRoundings = 0x1p-52;
  const double terms =
      std::abs(problem.offset(contact)) +
      std::visit([&](const auto& N) { return N.col(contact).cwiseAbs().dot(v.cwiseAbs()); }, problem.N);
  if (terms == 0) return 0;
  return kTwoRoundings * static_cast<double>(v.size() + 1) * terms + std::numeric_limits<double>::denorm_min();
}

}  // namespace

void IslandSolver::load(ProblemCutter& whole, Island island, const Vector& v, std::vector<char>& carries,
                        bool is_one_of_several, bool to_hold) {
  cutter_ = &whole;
  to_hold_ = to_hold;
  takes_turns_ = is_one_of_several && may_take_turns(island);
  carries_ = &carries;
  carried_ = nullptr;
  island_ = std::move(island);
  approach_.resize(static_cast<Index>(island_.contacts.size()));
  is_loaded_ = has_some_ = false;
  update(v);
}

bool IslandSolver::may_take_turns(const Island& island) { return island.coordinates.size() <= kMostInTurn; }

void IslandSolver::update(const Vector& v) {
  measure_approach(v);
  if (settings_.leave_out && !(fastest_ > 0)) {
    now_ = nullptr;
  } else if (!is_loaded_) {
    load_parts(v);
  } else {
    now_ = some_will_do() ? &some_ : &all_;
    now_->update(v);
  }
}

void IslandSolver::measure_approach(const Vector& v) {
  const ContactProblem& whole = cutter_->whole();
  const bool may_be_singular = ContactSolvability::is_asked(whole);
  fastest_ = scale_ = 0;
  for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
    const double velocity = normal_row(whole, island_.contacts[k], v);
    approach_(static_cast<Index>(k)) = velocity;
    // What no impulse moves has no solution where it approaches, be it by less than the rounding of its velocity.
    fastest_ = max_or_infinity(fastest_, -velocity);
    if (may_be_singular) {
      fastest_ = max_or_infinity(fastest_, rounding_of_row(whole, island_.contacts[k], v) - velocity);
    }
    scale_ = std::max(scale_, std::abs(velocity));
  }
}

void IslandSolver::load_parts(const Vector& v) {
  is_loaded_ = true;
  now_ = &all_;
  if (!find_what_may_press()) return all_.load(*cutter_, island_, v, takes_turns_, to_hold_);
  has_some_ = all_.load_when_needed(*cutter_, island_, v);
  if (!has_some_) return;
  if (all_.has_stand_in() && !keep_what_may_be_struck()) {
    has_some_ = false;
    return all_.update(v);
  }
  kept_.coordinates = cutter_->moved(kept_.contacts, island_.coordinates);
  some_.load(*cutter_, kept_, v);
  now_ = &some_;
}

/// Fills kept_, separating_ and left_out_. @returns whether enough is left out
bool IslandSolver::find_what_may_press() {
  separating_.clear();
  kept_.contacts.clear();
  const bool is_scene = std::holds_alternative<BlockInertia>(cutter_->whole().inertia);
  const auto contacts = static_cast<std::int64_t>(island_.contacts.size());
  if (!settings_.leave_out || !is_scene || contacts < settings_.leave_out_from) return false;
  for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
    if (may_press(k)) {
      kept_.contacts.push_back(island_.contacts[k]);
    } else {
      separating_.push_back(k);
    }
  }
  left_out_ = separating_;
  return leaves_enough_out();
}

/// Takes what touches a body that a kept contact touches from left_out_ into kept_: only the impulses of these contacts
/// can make another one approach. @returns whether enough is left out
bool IslandSolver::keep_what_may_be_struck() {
  const std::vector<char> bodies = cutter_->bodies_of(kept_.contacts);
  std::erase_if(left_out_, [&](std::size_t k) {
    const Index contact = island_.contacts[k];
    if (!cutter_->touches(contact, bodies)) return false;
    kept_.contacts.push_back(contact);
    return true;
  });
  std::sort(kept_.contacts.begin(), kept_.contacts.end());
  return leaves_enough_out();
}

bool IslandSolver::leaves_enough_out() const { return kLeastShare * left_out_.size() >= island_.contacts.size(); }

/// Whether the contacts that were found to separate still do.
bool IslandSolver::some_will_do() const {
  return has_some_ &&
         std::none_of(separating_.begin(), separating_.end(), [this](std::size_t k) { return may_press(k); });
}

Claim IslandSolver::solve(const Vector* start, const AutoLimits& limits, Vector& z, Vector& u, AutoReport& report) {
  if (now_ == nullptr) return remain_at_rest(report);
  bool is_brought_back = false;
  Claim claim = now_->solve(start, limits, report);
  if (claim == Claim::kSolved && now_ == &some_) {
    some_.write_velocity(u);
    const Index back = count_approaching(u);
    if (back > 0) {
      is_brought_back = true;
      report.brought_back += back;
      some_.take_back_velocity(u);
      has_some_ = false;
      now_ = &all_;
      all_.set_velocity(u);
      some_.write_impulses(z);
      claim = all_.solve(all_.has_stand_in() ? &z : nullptr, limits, report);
    }
  }
  if (gave_up(claim, limits, report) && !is_brought_back && rests(u)) {
    now_ = nullptr;
    return remain_at_rest(report);
  }
  if (claim != Claim::kSolved) return claim;
  now_->write_impulses(z);
  // Of contacts that have friction rows and a lambda, but not in the answer, the slip is asked for.
  if (now_->gave_velocity() || !now_->carries_friction()) now_->write_velocity(u);
  report.left_out += static_cast<Index>(island_.contacts.size() - now_->contacts().size());
  tell_what_is_carried();
  return claim;
}

/// Whether z = 0 solves the island, where no method does. Not of several islands in one: each has its own scale.
bool IslandSolver::rests(const Vector& u) const {
  if (!settings_.islands) return false;
  RestTest test(cutter_->whole(), cutter_->layout(), u);
  for (const Index contact : island_.contacts) test.add(contact);
  return test.passes();
}

Claim IslandSolver::remain_at_rest(AutoReport& report) {
  ++report.at_rest;
  report.left_out += static_cast<Index>(island_.contacts.size());
  tell_what_is_carried();
  return Claim::kSolved;
}

/// Contacts left out that approach in u.
Index IslandSolver::count_approaching(const Vector& u) const {
  return std::count_if(left_out_.begin(), left_out_.end(), [&](std::size_t k) {
    return !(normal_row(cutter_->whole(), island_.contacts[k], u) >= -kApproaching * scale_);
  });
}

void IslandSolver::tell_what_is_carried() {
  if (carried_ == now_) return;
  carried_ = now_;
  for (const Index contact : island_.contacts) (*carries_)[static_cast<std::size_t>(contact)] = 0;
  if (now_ == nullptr || !now_->carries_friction()) return;
  for (const Index contact : now_->contacts()) (*carries_)[static_cast<std::size_t>(contact)] = 1;
}

}  // namespace lcpbench
