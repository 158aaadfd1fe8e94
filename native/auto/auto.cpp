#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/islands.h"
#include "core/registry.h"
#include "core/settings.h"
#include "core/timed_solve.h"
#include "core/answer/contact_residual.h"
#include "native/answer_test/answer_test.h"
#include "native/answer_test/rest.h"
#include "native/auto/bare_blocks.h"
#include "native/auto/even_impulses.h"
#include "native/auto/island.h"
#include "native/auto/island_solver.h"
#include "native/auto/methods.h"
#include "native/auto/report.h"
#include "native/auto/row_states.h"
#include "native/contacts/contact_impulses.h"
#include "native/contacts/row_bounds.h"
#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{
    .compliance = true,
    .rows = true,
    .guarantees = "contact problems with positive definite G and mu >= 0, barring ties; frictionless ones of any rank",
    .warm_start = true,
    .obeys_time_limit = true};

constexpr Capabilities on_contacts_alone() {
  Capabilities capabilities = kCapabilities;
  capabilities.rows = false;
  return capabilities;
}
constexpr Capabilities kOnContacts = on_contacts_alone();

struct AutoSettings {
  double error = 0;
  Impulses impulses = Impulses::kAny;

  void visit(auto&& field) {
    field("error", error, RealRange{.min = 0, .max = 0.1},
          "velocity residual of every island, relative to its scale, at which iterative methods may stop; 0: each "
          "method's own");
    field("impulses", impulses, Choices<Impulses>{{{"any", Impulses::kAny}, {"even", Impulses::kEven}}},
          "of contacts, where several give the same motion: those that a method reached, or those that equally stiff "
          "contacts would carry");
  }
};

/// Most coordinates of a small island. To load several such in turn into the same solvers takes no more time than to
/// fill memory of its own for each.
constexpr std::size_t kMaxInTurn = 64;

/// A smaller stated error counts as this one: iterative methods in double reach it, as a rule.
constexpr double kLeastError = 1e-12;

constexpr const char* kErrorHasNoEffect = "error above 5e-5 has no effect where G is not given as blocks";

double error_of(const AutoSettings& settings) {
  return settings.error > 0 ? std::max(settings.error, kLeastError) : 0;
}

AutoLimits limits_of(const SolveRequest& request, const AutoSettings& settings) {
  return {.deadline_s = wall_clock_s() + request.time_limit_s, .error = error_of(settings)};
}

/// Whether friction has rows, but no impulse: they may be left out.
bool has_rows_to_strip(const ContactProblem& contact) {
  return contact.frictional() && !(contact.mu.array() > 0).any();
}

/// Whether every contact is in one island, and little that no contact moves is left beside it. To cut a problem out of
/// itself would cost a third of the time of a few contacts.
/// @param numbers those of the problem @param idle coordinates that no contact moves
bool is_one_island(const ContactProblem& contact, const IslandNumbers& numbers, Index idle) {
  const auto is_in = [](Index island) { return island == 0; };
  return numbers.count == 1 && 2 * idle <= contact.ngc() && std::ranges::all_of(numbers.of_contact, is_in);
}

/// Whether no contact approaches at v: then zero impulses solve the whole problem.
bool nothing_approaches(const ContactProblem& contact, const Vector& v) {
  const bool to_rounding = may_be_unsolvable(contact);
  for (Index c = 0; c < contact.nc(); ++c) {
    if (may_approach(contact, c, v, to_rounding)) return false;
  }
  return true;
}

/// Whether zero impulses solve a problem that no method solved, by the measure of the verdict: it allows for rounding.
bool rests(const ContactProblem& contact, const Vector& v) {
  const ContactLayout layout = contact_layout(contact);
  RestTest test(contact, layout, v);
  for (Index c = 0; c < layout.nc; ++c) test.add(c);
  return test.passes();
}

/// What a user should call: an IslandSolver for each island of contacts, BareBlocks for a bare LCP. Hands out the best
/// answer that was tested. See docs/reference/solvers/auto.md.
///
/// On each island the methods take turns (island_solver.h) in an order (order.cpp). Rest is found in island_rest.cpp.
/// An island is unsolvable if a method or AnswerTest proves it (IslandSolver::take_turns).
///
/// kSolved: every part passed; kUnsolvable: some part was proven to have no solution (`farkas` is then a proof for the
/// whole where there is one for the part); else the claim of the first part that failed, and z has the best impulses
/// that were found for each. Where methods solved contacts, `detail` says which ones ran and the highest stage. Returns
/// the velocity where all methods gave one. SolveRequest::start should be the last answer: some methods begin from it,
/// and StickingContacts.
///
/// Bounded rows are solved by their states where those of small robots tell them (RowStates); else, and where the states
/// find no answer, as contacts (core/contacts_of_rows.h).
///
/// solve() allocates where a method is loaded that load() has not loaded, as for each of several blocks:
/// `allocation_free` is not promised.
class Auto final : public Solver {
 public:
  explicit Auto(const AutoSettings& settings, bool takes_rows = true)
      : settings_(settings), takes_rows_(takes_rows), later_(std::make_shared<LaterEngines>()) {
    if (settings.impulses == Impulses::kEven) even_.emplace();
  }
  const Capabilities& capabilities() const override { return takes_rows_ ? kCapabilities : kOnContacts; }

 private:
  void on_load(const Problem& problem) override {
    if (!load_rows(problem)) load(problem, false);
  }
  void on_update(const Vector& v) override;
  void on_change(const Problem& problem) override {
    if (!load_rows(problem)) load(problem, true);
  }
  void on_solve(const SolveRequest& request, Answer& answer) override;

  bool load_rows(const Problem& problem);
  void solve_rows(const SolveRequest& request, Answer& answer);
  bool solve_by_states(const SolveRequest& request, Answer& answer);
  void load(const Problem& problem, bool is_next_step);
  void load_whole(bool is_next_step);
  void load_islands(const ContactProblem& contact, bool is_next_step);
  void solve_whole(const SolveRequest& request, Answer& answer);
  void solve_islands(const SolveRequest& request, Answer& answer);
  void give_up(const IslandOfProblem& island, Answer& answer) const;
  void bound_slips(const Vector& u, Vector& z) const;
  void make_even(double deadline_s, Answer& answer);

  AutoSettings settings_;
  const bool takes_rows_;
  bool has_rows_ = false, by_states_ = false;
  RowStates states_;
  std::unique_ptr<Auto> between_, as_contacts_;  ///< of what the states leave; of contacts in the place of rows
  Answer part_;
  BareBlocks bare_;  ///< of bare LCPs, all

  std::shared_ptr<LaterEngines> later_;
  Methods shared_{later_};
  bool is_whole_ = false;     // one island that is the whole problem: goes to its solver as it is
  bool may_remain_ = false;   // then it is not solved while nothing approaches
  bool remains_ = false;      // so it is now
  bool has_methods_ = false;  // whole_ is loaded
  IslandSolver whole_{shared_, later_, error_of(settings_), true};

  IslandNumbers numbers_;  // unless the problem plainly goes to its solver as a whole
  std::vector<Island> found_;
  ProblemCutter cutter_;
  std::vector<std::unique_ptr<IslandOfProblem>> islands_;  // kept for the next problem
  std::size_t count_ = 0;                                  // of islands_ in use
  std::vector<char> carries_;                              // per contact: its lambda is in its island's answer
  Index falling_ = -1;  // a contact of no island whose offset is negative: no impulse helps it
  Vector v_, u_;
  std::optional<EvenImpulses> even_;  ///< where they are asked for
};

/// @returns whether the problem has bounded rows, and is taken
bool Auto::load_rows(const Problem& problem) {
  const ContactProblem* const contact = problem.contact();
  has_rows_ = contact != nullptr && contact->has_rows();
  if (!has_rows_) return false;
  by_states_ = settings_.impulses == Impulses::kAny && RowStates::takes(*contact);
  if (by_states_) states_.load(*contact);
  return true;
}

void Auto::solve_rows(const SolveRequest& request, Answer& answer) {
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  if (by_states_ && solve_by_states(request, answer)) return;
  if (as_contacts_ == nullptr) as_contacts_ = std::make_unique<Auto>(settings_, false);
  as_contacts_->load_finite(problem());
  as_contacts_->solve({.start = request.start, .time_limit_s = deadline_s - wall_clock_s()}, answer);
}

/// @returns whether it is solved
bool Auto::solve_by_states(const SolveRequest& request, Answer& answer) {
  constexpr int kMostRounds = 12;
  const ContactProblem& contact = *problem().contact();
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  if (between_ == nullptr) between_ = std::make_unique<Auto>(settings_, false);
  states_.guess(request.start);
  Vector start;
  if (request.start != nullptr) start = request.start->head(problem().size() - contact.rows.size());
  AutoReport report;
  int round = 0;
  for (bool are_right = false; !are_right;) {
    if (++round > kMostRounds || !states_.reduce()) return false;
    const auto left = std::shared_ptr<const ContactProblem>(std::shared_ptr<void>(), &states_.contacts());
    round == 1 ? between_->load_finite(Problem("", left)) : between_->update(Problem("", left));
    between_->solve({.start = start.size() > 0 ? &start : nullptr, .time_limit_s = deadline_s - wall_clock_s()}, part_);
    if (part_.claim != Claim::kSolved) return false;
    const Vector velocity = part_.velocity.size() > 0 ? Vector(part_.velocity) : states_.velocity_after(part_.z);
    are_right = states_.settle(part_.z, velocity);
    start = part_.z;
    report.add(part_.counters, "");
  }
  answer.z = states_.z();
  if (states_.holds()) {
    answer.velocity = states_.velocity();
  } else {
    ContactResidual residual(contact);
    const double limit = std::max(error_of(settings_), kClaimedQuadResidual);
    if (!residual.lcp || !(residual.rho(residual.at(answer.z)) <= limit)) return false;
  }
  answer.claim = Claim::kSolved;
  answer.impulses = Impulses::kAny;
  answer.counters = report.counters();
  answer.detail = part_.detail;
  if (round > 1) answer.detail += (answer.detail.empty() ? "" : "; ") + std::to_string(round) + " rounds of bounded rows";
  return true;
}

/// @param is_next_step its contacts are those of the next step
void Auto::load(const Problem& problem, bool is_next_step) {
  is_whole_ = may_remain_ = false;
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr) return bare_.load_finite(problem);
  v_ = contact->v;
  if (even_.has_value()) even_->load(problem);
  const bool strips = has_rows_to_strip(*contact);
  const bool is_coupled = couples_all(contact->inertia) && !strips;
  is_whole_ = is_coupled && !contact->has_offset() && !contact->is_soft();  // contacts that move nothing do not matter
  whole_.expect_idle(0);
  if (is_whole_) return load_whole(is_next_step);
  numbers_.find(*contact);
  const Index idle = std::count(numbers_.of_coordinate.begin(), numbers_.of_coordinate.end(), -1);
  is_whole_ = is_one_island(*contact, numbers_, idle) && (is_coupled || (!strips && !may_be_singular(*contact)));
  whole_.expect_idle(idle);
  may_remain_ = is_whole_ && !is_coupled;
  if (is_whole_) return load_whole(is_next_step);
  load_islands(*contact, is_next_step);
}

void Auto::load_whole(bool is_next_step) {
  remains_ = may_remain_ && nothing_approaches(*problem().contact(), v_);
  has_methods_ = !remains_;
  if (remains_) return;
  whole_.load(problem(), v_, {.after_guess = is_next_step});
}

void Auto::load_islands(const ContactProblem& contact, bool is_next_step) {
  numbers_.list(found_);
  falling_ = -1;
  for (Index c = 0; c < contact.nc(); ++c) {
    if (numbers_.of_contact[static_cast<std::size_t>(c)] < 0 && contact.offset(c) < 0) falling_ = c;
  }
  // The largest come last, and get what the others leave of the time.
  std::ranges::sort(found_, {}, [](const Island& island) {
    return std::pair(island.contacts.size(), island.contacts.front());
  });
  cutter_.load(problem());
  carries_.assign(contact.edges.size(), 0);
  u_.resize(v_.size());
  count_ = found_.size();
  while (islands_.size() < count_) {
    islands_.push_back(std::make_unique<IslandOfProblem>(shared_, later_, error_of(settings_)));
  }
  for (std::size_t k = 0; k < count_; ++k) {
    const bool is_small = count_ > 1 && found_[k].coordinates.size() <= kMaxInTurn;
    islands_[k]->load(cutter_, found_[k], v_, carries_, {.in_turn = is_small, .after_guess = is_next_step});
  }
}

void Auto::on_update(const Vector& v) {
  if (!v.allFinite() || has_rows_) return Solver::on_update(v);  // that of v refuses it, as load does
  v_ = v;
  if (even_.has_value()) even_->set_velocity(v);
  for (std::size_t k = 0; !is_whole_ && k < count_; ++k) islands_[k]->update(v_);
  if (!is_whole_) return;
  if (!has_methods_) return load_whole(false);
  remains_ = may_remain_ && nothing_approaches(*problem().contact(), v_);
  if (!remains_) whole_.update(v_);
}

void Auto::on_solve(const SolveRequest& request, Answer& answer) {
  if (has_rows_) return solve_rows(request, answer);
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  if (problem().contact() == nullptr) {
    bare_.solve(request, answer);
  } else if (!(request.time_limit_s > 0)) {
    answer.claim = Claim::kTimeLimit;
  } else if (is_whole_) {
    solve_whole(request, answer);
  } else if (falling_ >= 0) {
    answer.claim = Claim::kUnsolvable;
    answer.detail = "a contact that nothing moves has a negative offset";
    answer.farkas = Vector::Unit(problem().contact()->nc(), falling_);
  } else {
    solve_islands(request, answer);
  }
  const ContactProblem* const contact = problem().contact();
  if (contact != nullptr && settings_.error > kClaimedResidual &&
      !std::holds_alternative<BlockInertia>(contact->inertia)) {
    answer.detail += (answer.detail.empty() ? "" : "; ") + std::string(kErrorHasNoEffect);
  }
  if (answer.claim != Claim::kSolved) return;
  if (!std::isfinite(answer.z.sum()) && !answer.z.allFinite()) {
    answer.claim = Claim::kNumericalFailure;  // a slip is beyond double
    answer.detail = "z beyond double";
    answer.velocity.resize(0);
  } else if (contact != nullptr) {
    answer.impulses = Impulses::kAny;
    if (even_.has_value()) make_even(deadline_s, answer);
  }
}

void Auto::make_even(double deadline_s, Answer& answer) {
  const std::string why = even_->distribute(error_of(settings_), deadline_s, answer);
  if (answer.counters.factorizations >= 0) answer.counters.factorizations += even_->factorizations();
  if (why.empty()) {
    answer.impulses = Impulses::kEven;
    answer.velocity.resize(0);  // theirs is the same but for rounding
  }
  answer.detail += why.empty() ? "; even impulses" : "; impulses not even: " + why;
}

void Auto::solve_whole(const SolveRequest& request, Answer& answer) {
  AutoReport report;
  report.islands = 1;
  if (remains_) {
    report.at_rest = 1;
    answer.claim = Claim::kSolved;
    bound_slips(v_, answer.z);
    answer.velocity = v_;
  } else {
    whole_.solve(request.start, limits_of(request, settings_), answer, report);
  }
  answer.counters = report.counters();
  if (answer.claim == Claim::kSolved) return report.write_text(answer.detail);
  if (answer.claim == Claim::kUnsolvable) return;
  if (!rests(*problem().contact(), v_)) {
    const Index impulses = problem().contact()->nc() + cols(problem().contact()->D);
    if (answer.z.size() == problem().size() && answer.z.head(impulses).isZero(0)) bound_slips(v_, answer.z);
    return;
  }
  answer.velocity.resize(0);
  answer.claim = Claim::kSolved;
  answer.z = Vector::Zero(problem().size());
  bound_slips(v_, answer.z);
  answer.detail = "at rest to rounding";
}

/// Each island may take a share of the time that is left, half of it alike for all, half as they are likely to take.
void Auto::solve_islands(const SolveRequest& request, Answer& answer) {
  const AutoLimits limits = limits_of(request, settings_);
  const Vector* start = request.start != nullptr && request.start->size() == answer.z.size() ? request.start : nullptr;
  AutoReport report;
  report.islands = static_cast<Index>(count_);
  u_ = v_;
  double remaining = 0;
  const bool shares_time = !std::isinf(limits.deadline_s) && count_ > 1;
  for (std::size_t k = 0; shares_time && k < count_; ++k) remaining += islands_[k]->likely_work();
  const IslandOfProblem* failed = nullptr;
  for (std::size_t k = 0; k < count_; ++k) {
    IslandOfProblem& island = *islands_[k];
    AutoLimits own = limits;
    const double likely = shares_time ? island.likely_work() : 0;
    if (shares_time && likely < remaining) {
      const double now_s = wall_clock_s();
      const double alike = 1 / static_cast<double>(count_ - k);
      own.deadline_s = now_s + (limits.deadline_s - now_s) * (alike + likely / remaining) / 2;
    }
    remaining -= likely;
    const Claim claim = island.solve(start, own, answer.z, u_, report);
    if (claim == Claim::kSolved) continue;
    if (failed == nullptr || claim == Claim::kUnsolvable) failed = &island;
    if (claim == Claim::kUnsolvable) break;
  }
  answer.counters = report.counters();
  bound_slips(u_, answer.z);
  if (failed != nullptr) return give_up(*failed, answer);
  answer.claim = Claim::kSolved;
  bool has_velocity = true;
  for (std::size_t k = 0; k < count_; ++k) has_velocity = has_velocity && islands_[k]->gave_velocity();
  if (has_velocity) answer.velocity = u_;
  report.write_text(answer.detail);
}

void Auto::give_up(const IslandOfProblem& island, Answer& answer) const {
  answer.claim = island.answer().claim;
  if (answer.claim == Claim::kUnsolvable) answer.z.setZero();
  answer.detail = "island of " + std::to_string(island.contacts().size()) + " contacts: ";
  answer.detail += island.answer().detail.empty() ? to_string(answer.claim) : island.answer().detail;
  const Vector& proof = island.answer().farkas;
  if (answer.claim != Claim::kUnsolvable || proof.size() == 0) return;
  answer.farkas = Vector::Zero(problem().contact()->nc());
  for (Index k = 0; k < proof.size(); ++k) answer.farkas(island.contacts()[static_cast<std::size_t>(k)]) = proof(k);
}

/// lambda of the contacts that no answer includes: at least the slip under no friction, so that rounding leaves no
/// friction row below zero.
void Auto::bound_slips(const Vector& u, Vector& z) const {
  const ContactProblem& contact = *problem().contact();
  Index direction = 0;
  Index lambda = contact.nc() + cols(contact.D);
  for (std::size_t c = 0; c < contact.edges.size(); ++c) {
    const Index edges = contact.edges[c];
    if (edges == 0) continue;
    if (is_whole_ || carries_[c] == 0) {
      double slip = 0;
      for (Index t = 0; t < edges / 2 && u.size() > 0; ++t) {  // Eigen asserts on sparse columns of no rows
        slip = std::max(slip, std::visit(SlipBound{u, direction + t}, contact.D));
      }
      const auto contact_number = static_cast<Index>(c);
      for (const int tangent : {0, 1}) slip += std::abs(contact.tangential_offset(contact_number, tangent));
      z(lambda) = contact.offset_t.size() > 0 ? slip * (1 + 0x1p-50) : slip;  // the sum is rounded
    }
    direction += edges;
    ++lambda;
  }
}

}  // namespace

SolverDefinition lcpbench_solver_auto() {
  return define_solver<Auto, AutoSettings>(
      {.name = "auto",
       .summary = "recommended: methods take turns on each island of contacts and on a bare LCP; answers tested",
       .source = "this project; see the sources of its methods",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
