#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/islands.h"
#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test/contact_solvability.h"
#include "native/auto/attempts.h"
#include "native/auto/lanes.h"
#include "native/auto/lcp_ladder.h"
#include "native/auto/methods.h"
#include "native/auto/report.h"
#include "native/auto/rest.h"
#include "native/auto/settings.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{
    .guarantees = "contact problems with positive definite G and mu >= 0, barring ties; frictionless ones of any rank",
    .warm_start = true,
    .obeys_time_limit = true};

/// What a user should call: chooses the method by the problem, solves what belongs together, and hands out only what
/// was tested. See docs/reference/solvers/auto.md.
///
/// Contacts: islands one by one, each without the contacts that cannot be pressed; without friction by `active_set`, or
/// `psor` or `velocity_ipm` where it is a large scene; with friction by `contact_lemke` and `friction_ipm`, or `psor`
/// where it is a large pile; each followed by another method where it gives up (plan_for). Bare LCPs: LcpLadder. Dense
/// methods raise their precision from double to 113 bits until the answer passes its test.
///
/// kSolved: every part passed; kUnsolvable: some part was proven to have no solution (`farkas` is then a proof for the
/// whole where there is one for the part); else the claim of the first part that failed, and z = 0. `detail` says what
/// was left out, which methods ran and the highest rung. Returns the velocity where all methods gave one.
/// SolveRequest::start: as the methods use it, the last answer being of use to all.
///
/// solve() allocates only where friction_ipm, velocity_ipm or psor has to follow a method that gave up: it is loaded
/// then; where no method solves a problem that is one island; and where it makes threads. As that may happen,
/// `allocation_free` is not promised.
class Auto final : public Solver {
 public:
  explicit Auto(const AutoSettings& settings) : settings_(settings), lcp_(settings.max_pivots) {}
  const Capabilities& capabilities() const override { return kCapabilities; }

 private:
  void on_load(const Problem& problem) override { load(problem, false); }
  void on_update(const Vector& v) override;
  void on_change(const Problem& problem) override { load(problem, true); }
  void on_solve(const SolveRequest& request, Answer& answer) override;

  static bool has_rows_to_strip(const ContactProblem& contact);
  bool is_one_small_island(const ContactProblem& contact, Index idle) const;
  void load(const Problem& problem, bool to_hold);
  void load_whole(bool to_hold);
  void load_islands(const ContactProblem& contact, bool to_hold);
  void find_falling(const ContactProblem& contact, const std::vector<Island>& islands);
  AutoLimits limits_of(const SolveRequest& request) const;
  void solve_whole(const SolveRequest& request, Answer& answer);
  void solve_islands(const SolveRequest& request, Answer& answer);
  void give_up(Claim claim, Answer& answer) const;
  bool nothing_approaches() const;
  void remain_at_rest(AutoReport& report, Answer& answer) const;
  bool whole_rests() const;
  void bound_slips(const Vector& u, Vector& z) const;

  AutoSettings settings_;
  LcpLadder lcp_;

  SharedMethods shared_;
  bool is_whole_ = false;     // one island that is the whole problem: goes to its methods as it is
  bool may_remain_ = false;   // then it gets no method while nothing approaches
  bool remains_ = false;      // so it is now
  bool has_methods_ = false;  // whole_ is loaded
  Attempts whole_{settings_, shared_, Attempts::Scope::kWhole};

  IslandNumbers numbers_;  // where the inertia does not tell that there is one island
  IslandLanes islands_{settings_, shared_};
  Index idle_ = 0;      // contacts without any nonzero entry: in no island
  Index falling_ = -1;  // one of them whose offset is negative: no impulse helps it
  Vector v_;
};

/// @param to_hold the contacts are those of the next step
void Auto::load(const Problem& problem, bool to_hold) {
  is_whole_ = may_remain_ = false;
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr) return lcp_.load(problem);
  v_ = contact->v;
  is_whole_ = couples_all(contact->inertia) && !has_rows_to_strip(*contact);
  whole_.expect_idle(0);
  if (is_whole_) return load_whole(to_hold);
  numbers_.find(*contact);
  const Index idle = std::count(numbers_.of_coordinate.begin(), numbers_.of_coordinate.end(), -1);
  is_whole_ = is_one_small_island(*contact, idle);
  whole_.expect_idle(idle);
  may_remain_ = is_whole_ && settings_.leave_out;
  if (is_whole_) return load_whole(to_hold);
  load_islands(*contact, to_hold);
}

/// Whether friction has rows, but no impulse: they may be left out.
bool Auto::has_rows_to_strip(const ContactProblem& contact) {
  return contact.frictional() && !(contact.mu.array() > 0).any();
}

/// Whether there is nothing to split, little that no contact moves, and nothing to leave out as long as anything
/// approaches. What cutting a problem out of itself costs is a third of the time of a few contacts.
/// @pre numbers_ are those of the problem @param idle coordinates that no contact moves
bool Auto::is_one_small_island(const ContactProblem& contact, Index idle) const {
  if (numbers_.count != 1 || has_rows_to_strip(contact) || ContactSolvability::is_asked(contact)) return false;
  if (settings_.leave_out && contact.nc() >= settings_.leave_out_from) return false;
  const auto is_in = [](Index island) { return island == 0; };
  return 2 * idle <= contact.ngc() && std::all_of(numbers_.of_contact.begin(), numbers_.of_contact.end(), is_in);
}

void Auto::load_whole(bool to_hold) {
  remains_ = may_remain_ && nothing_approaches();
  has_methods_ = !remains_;
  if (remains_) return;
  if (to_hold) return whole_.load_to_hold(problem(), v_);
  whole_.load(problem(), v_);
}

/// Whether z = 0 solves the whole problem as it is.
bool Auto::nothing_approaches() const {
  const ContactProblem& contact = *problem().contact();
  double fastest = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    fastest = max_or_infinity(fastest, -(dot_column(contact.N, c, v_) + contact.offset(c)));
  }
  return !(fastest > 0);
}

void Auto::load_islands(const ContactProblem& contact, bool to_hold) {
  std::vector<Island> found = numbers_.islands();
  if (!settings_.islands && found.size() > 1) {
    Island all;
    for (const Island& part : found) {
      all.contacts.insert(all.contacts.end(), part.contacts.begin(), part.contacts.end());
      all.coordinates.insert(all.coordinates.end(), part.coordinates.begin(), part.coordinates.end());
    }
    std::sort(all.contacts.begin(), all.contacts.end());
    std::sort(all.coordinates.begin(), all.coordinates.end());
    found.assign(1, std::move(all));
  }
  idle_ = contact.nc();
  for (const Island& part : found) idle_ -= static_cast<Index>(part.contacts.size());
  find_falling(contact, found);
  islands_.load(problem(), std::move(found), v_, to_hold);
}

void Auto::find_falling(const ContactProblem& contact, const std::vector<Island>& islands) {
  falling_ = -1;
  if (!contact.has_offset() || idle_ == 0) return;
  std::vector<char> is_idle(contact.edges.size(), 1);
  for (const Island& part : islands) {
    for (const Index c : part.contacts) is_idle[static_cast<std::size_t>(c)] = 0;
  }
  for (Index c = 0; c < contact.nc(); ++c) {
    if (is_idle[static_cast<std::size_t>(c)] != 0 && contact.b(c) < 0) falling_ = c;
  }
}

void Auto::on_update(const Vector& v) {
  if (!v.allFinite()) return Solver::on_update(v);  // refuses it, as load does
  v_ = v;
  if (!is_whole_) return islands_.update(v_);
  if (!has_methods_) return load_whole(false);
  remains_ = may_remain_ && nothing_approaches();
  if (!remains_) whole_.update(v_);
}

void Auto::on_solve(const SolveRequest& request, Answer& answer) {
  if (problem().contact() == nullptr) {
    const char* text = "";
    lcp_.solve(request, answer, text);
    answer.detail = text;
  } else if (!(request.time_limit_s > 0)) {
    answer.claim = Claim::kTimeLimit;
  } else if (is_whole_) {
    solve_whole(request, answer);
  } else if (falling_ >= 0) {
    answer.claim = Claim::kUnsolvable;
    answer.detail = "a contact that nothing moves has a negative offset";
    answer.farkas.setZero(problem().contact()->nc());
    answer.farkas(falling_) = 1;
  } else {
    solve_islands(request, answer);
  }
}

void Auto::solve_whole(const SolveRequest& request, Answer& answer) {
  AutoReport report;
  report.islands = 1;
  report.contacts = problem().contact()->nc();
  if (remains_) return remain_at_rest(report, answer);
  const AutoLimits limits = limits_of(request);
  whole_.solve(request, limits, answer, report);
  answer.counters = report.counters();
  if (gave_up(answer.claim, limits, report) && whole_rests()) {
    answer.velocity.resize(0);
    answer.claim = Claim::kSolved;
    answer.z.setZero(problem().size());
    bound_slips(v_, answer.z);
    answer.detail = "at rest to rounding";
    return;
  }
  if (answer.claim == Claim::kSolved) return report.write_text(answer.detail);
  // The words of the method say why it failed, but nothing of its last iterate is an answer.
  answer.velocity.resize(0);
  answer.z.resize(problem().size());
  answer.z.setZero();
}

void Auto::remain_at_rest(AutoReport& report, Answer& answer) const {
  report.at_rest = 1;
  report.left_out = report.contacts;
  answer.counters = report.counters();
  answer.claim = Claim::kSolved;
  bound_slips(v_, answer.z);
  answer.velocity = v_;
  report.write_text(answer.detail);
}

/// Whether z = 0 solves the whole problem, where no method does.
bool Auto::whole_rests() const {
  const ContactLayout layout = contact_layout(*problem().contact());
  RestTest test(*problem().contact(), layout, v_);
  for (Index c = 0; c < layout.nc; ++c) test.add(c);
  return test.passes();
}

AutoLimits Auto::limits_of(const SolveRequest& request) const {
  AutoLimits limits{.deadline_s = request.time_limit_s,
                    .max_pivots = settings_.max_pivots,
                    .error = settings_.error > 0 ? std::max(settings_.error, kLeastError) : 0};
  if (!std::isinf(limits.deadline_s)) limits.deadline_s += wall_clock_s();
  return limits;
}

void Auto::solve_islands(const SolveRequest& request, Answer& answer) {
  const AutoLimits limits = limits_of(request);
  const Vector* start = request.start != nullptr && request.start->size() == answer.z.size() ? request.start : nullptr;
  AutoReport report;
  report.islands = static_cast<Index>(islands_.count());
  report.contacts = problem().contact()->nc();
  report.left_out = idle_;
  const Claim claim = islands_.solve(v_, start, limits, answer.z, report);
  answer.counters = report.counters();
  if (claim != Claim::kSolved) return give_up(claim, answer);
  answer.claim = Claim::kSolved;
  bound_slips(islands_.velocity(), answer.z);
  if (islands_.all_gave_velocity()) answer.velocity = islands_.velocity();
  report.write_text(answer.detail);
}

void Auto::give_up(Claim claim, Answer& answer) const {
  const IslandSolver& island = islands_.failed();
  answer.claim = claim;
  answer.z.setZero();
  std::string& text = answer.detail;
  text = "island of ";
  text += std::to_string(island.contacts().size());
  text += " contacts: ";
  text += claim == Claim::kTimeLimit || claim == Claim::kIterationLimit ? to_string(claim) : island.answer().detail;
  if (island.answer().claim == Claim::kUnsupported) answer.z.resize(0);
  const Vector& proof = island.answer().farkas;
  if (claim != Claim::kUnsolvable || proof.size() == 0) return;
  answer.farkas.resize(problem().contact()->nc());
  answer.farkas.setZero();
  for (Index k = 0; k < proof.size(); ++k) answer.farkas(island.contacts()[static_cast<std::size_t>(k)]) = proof(k);
}

/// At least |column'v|, by what the rounding of the sum may take from it.
struct SlipBound {
  const Vector& v;
  Index column;

  double operator()(const Matrix& matrix) const {
    const auto of_column = matrix.col(column);
    return of(of_column.dot(v), of_column.cwiseAbs().dot(v.cwiseAbs()), v.size());
  }
  double operator()(const SparseMatrix& matrix) const {
    double sum = 0, magnitudes = 0;
    Index terms = 0;
    for (SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry, ++terms) {
      const double product = entry.value() * v(entry.row());
      sum += product;
      magnitudes += std::abs(product);
    }
    return of(sum, magnitudes, terms);
  }
  static double of(double sum, double magnitudes, Index terms) {
    return std::abs(sum) + static_cast<double>(terms + 3) * 0x1p-53 * magnitudes;
  }
};

/// lambda of the contacts that no answer includes: at least the slip under no friction, so that rounding leaves no
/// friction row below zero.
void Auto::bound_slips(const Vector& u, Vector& z) const {
  const ContactProblem& contact = *problem().contact();
  Index direction = 0;
  Index lambda = contact.nc() + cols(contact.D);
  for (std::size_t c = 0; c < contact.edges.size(); ++c) {
    const Index edges = contact.edges[c];
    if (edges == 0) continue;
    if (is_whole_ || !islands_.carries(c)) {
      double slip = 0;
      for (Index t = 0; t < edges / 2 && u.size() > 0; ++t) {  // Eigen asserts on sparse columns of no rows
        slip = std::max(slip, std::visit(SlipBound{u, direction + t}, contact.D));
      }
      z(lambda) = slip;
    }
    direction += edges;
    ++lambda;
  }
}

}  // namespace

SolverDefinition lcpbench_solver_auto() {
  return define_solver<Auto, AutoSettings>(
      {.name = "auto",
       .summary =
           "what to call: islands one by one, only what presses, the method by class and size, every answer tested",
       .source = "this project; its methods name theirs",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
