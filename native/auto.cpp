#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/answer_storage.h"
#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/auto/island_solver.h"
#include "native/auto/islands.h"
#include "native/auto/lcp_ladder.h"
#include "native/auto/report.h"
#include "native/auto/settings.h"

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{
    .guarantees = "contact problems with positive definite G and mu >= 0, barring ties; frictionless ones of any rank",
    .warm_start = true,
    .obeys_time_limit = true,
    .allocation_free = true};

/// What a user should call: chooses the method by the problem, solves what belongs together, and hands out only what
/// was tested. See docs/auto.md.
///
/// Contacts: islands one by one, each without the contacts that cannot be pressed; without friction by `active_set`, or
/// `velocity_ipm` where it is a large scene; with friction by `contact_lemke`. Bare LCPs: LcpLadder. Each of these
/// climbs from double to 113 bits as far as the test of its answer, made from the data, asks for.
///
/// kSolved: every part passed; kUnsolvable: some part was proven to have no solution (`farkas` is then a proof for the
/// whole where there is one for the part); else the claim of the first part that failed, and z = 0. `detail` says what
/// was left out, which methods ran and the highest rung. Returns the velocity where all methods gave one.
/// SolveRequest::start: as the methods use it, the last answer being of use to all.
///
/// Nothing is allocated in solve() but where capabilities() of the loaded object says so, for large scenes, and where a
/// method gave up on contacts and another is tried (contact_lemke after active_set).
class Auto final : public Solver {
 public:
  explicit Auto(const AutoSettings& settings) : settings_(settings), lcp_(settings.max_pivots) {}
  const Capabilities& capabilities() const override { return capabilities_; }

 private:
  void on_load(const Problem& problem) override;
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  Solver* whole_solver(const ContactProblem& contact);
  void load_islands(const ContactProblem& contact);
  IslandSolver& island(std::size_t k) { return *islands_[k]; }
  void note_memory();
  void solve_whole(const SolveRequest& request, Answer& answer);
  void solve_by_contact_lemke(SolveRequest request, double begin_s, AutoReport& report, Answer& answer);
  void solve_islands(const SolveRequest& request, Answer& answer);
  void give_up(Claim claim, const IslandSolver& island, Answer& answer);
  void bound_slips(Vector& z) const;
  void write_velocity(Answer& answer);
  std::string& text_of(Answer& answer);

  AutoSettings settings_;
  Capabilities capabilities_ = kCapabilities;
  LcpLadder lcp_;

  // One island that is the whole problem goes to its solver as it is.
  Solver* whole_ = nullptr;
  std::unique_ptr<ActiveSet> active_set_;
  std::unique_ptr<ContactLemke> contact_lemke_;

  std::unique_ptr<ProblemCutter> cutter_;
  std::vector<std::unique_ptr<IslandSolver>> islands_;  // kept for the next problem
  std::size_t island_count_ = 0;
  Index idle_ = 0;             // contacts without any nonzero entry: in no island
  std::vector<char> carries_;  // per contact: its lambda is in its island's answer
  Vector u_, v_;
  Vector velocity_;  // storage for that of the answer
  std::string text_;
};

void Auto::on_load(const Problem& problem) {
  capabilities_.allocation_free = true;
  text_.reserve(AutoReport::kLongestText);
  whole_ = nullptr;
  island_count_ = 0;
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr) return lcp_.load(problem);
  whole_ = whole_solver(*contact);
  v_ = contact->v;
  if (whole_ != nullptr) return whole_->load(problem);
  load_islands(*contact);
}

/// The solver that takes the whole problem as it is, where it can be told at once that there is nothing to split or to
/// strip; else nullptr.
Solver* Auto::whole_solver(const ContactProblem& contact) {
  if (!couples_all(contact.inertia)) return nullptr;
  if (!contact.frictional()) {
    if (active_set_ == nullptr) {
      active_set_ = std::make_unique<ActiveSet>(ActiveSetSettings{.max_iterations = settings_.max_pivots});
    }
    return active_set_.get();
  }
  bool any_friction = false;
  for (Index c = 0; c < contact.nc(); ++c) any_friction = any_friction || contact.mu(c) > 0;
  if (!any_friction) return nullptr;
  if (contact_lemke_ == nullptr) {
    contact_lemke_ = std::make_unique<ContactLemke>(ContactLemkeSettings{.max_pivots = settings_.max_pivots});
  }
  return contact_lemke_.get();
}

void Auto::load_islands(const ContactProblem& contact) {
  std::vector<Island> found = find_islands(contact);
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
  cutter_ = std::make_unique<ProblemCutter>(contact);
  carries_.assign(contact.edges.size(), 0);
  u_.resize(v_.size());
  island_count_ = found.size();
  idle_ = contact.nc();
  for (const Island& part : found) idle_ -= static_cast<Index>(part.contacts.size());
  while (islands_.size() < island_count_) islands_.push_back(std::make_unique<IslandSolver>(settings_));
  for (std::size_t k = 0; k < island_count_; ++k) island(k).load(*cutter_, std::move(found[k]), v_, carries_);
  note_memory();
}

void Auto::note_memory() {
  for (std::size_t k = 0; k < island_count_; ++k) {
    if (!island(k).allocation_free()) capabilities_.allocation_free = false;
  }
}

void Auto::on_update(const Vector& v) {
  if (!v.allFinite()) return Solver::on_update(v);  // refuses it, as load does
  v_ = v;
  if (whole_ != nullptr) return whole_->update(v);
  for (std::size_t k = 0; k < island_count_; ++k) island(k).update(v_);
  note_memory();
}

void Auto::on_solve(const SolveRequest& request, Answer& answer) {
  if (problem().contact() == nullptr) {
    const char* text = "";
    lcp_.solve(request, answer, text);
    text_of(answer).assign(text);
  } else if (!(request.time_limit_s > 0)) {
    answer.claim = Claim::kTimeLimit;
  } else if (whole_ != nullptr) {
    solve_whole(request, answer);
  } else {
    solve_islands(request, answer);
  }
}

/// answer.detail, with room for the longest text.
std::string& Auto::text_of(Answer& answer) {
  if (answer.detail.capacity() < AutoReport::kLongestText) answer.detail.swap(text_);
  return answer.detail;
}

void Auto::solve_whole(const SolveRequest& request, Answer& answer) {
  AutoReport report;
  report.islands = 1;
  report.contacts = problem().contact()->nc();
  const double begin_s = std::isinf(request.time_limit_s) ? 0 : wall_clock_s();
  whole_->solve(request, answer);
  report.add(answer.counters, answer.detail);
  (whole_ == active_set_.get() ? report.active_set : report.contact_lemke) = 1;
  const bool gave_up =
      answer.claim == Claim::kNumericalFailure || (answer.claim == Claim::kIterationLimit && settings_.max_pivots == 0);
  if (gave_up && whole_ == active_set_.get()) solve_by_contact_lemke(request, begin_s, report, answer);
  answer.counters = report.counters();
  if (answer.claim == Claim::kSolved) report.write_text(text_of(answer));  // else its own words say why
}

/// Where the active set does not get there. Allocates.
void Auto::solve_by_contact_lemke(SolveRequest request, double begin_s, AutoReport& report, Answer& answer) {
  answer.z.setZero();
  if (!std::isinf(request.time_limit_s)) request.time_limit_s -= wall_clock_s() - begin_s;
  if (!(request.time_limit_s > 0)) {
    answer.claim = Claim::kTimeLimit;
    return;
  }
  const std::int64_t pivots = settings_.max_pivots > 0 ? settings_.max_pivots - report.counters().pivots : 0;
  if (settings_.max_pivots > 0 && pivots <= 0) {
    answer.claim = Claim::kIterationLimit;
    return;
  }
  ContactProblem now = *problem().contact();
  now.v = v_;
  ContactLemke solver(ContactLemkeSettings{.max_pivots = pivots});
  solver.load(Problem(problem().name(), std::move(now)));
  request.start = nullptr;
  solver.solve(request, answer);
  ++report.contact_lemke;
  report.add(answer.counters, answer.detail);
}

void Auto::solve_islands(const SolveRequest& request, Answer& answer) {
  AutoLimits limits{.deadline_s = request.time_limit_s, .max_pivots = settings_.max_pivots};
  if (!std::isinf(limits.deadline_s)) limits.deadline_s += wall_clock_s();
  const Vector* start = request.start != nullptr && request.start->size() == answer.z.size() ? request.start : nullptr;
  AutoReport report;
  report.islands = static_cast<Index>(island_count_);
  report.contacts = problem().contact()->nc();
  report.left_out = idle_;
  u_ = v_;
  velocity_.swap(cleared_vectors().velocity);  // the islands' solvers put theirs there
  for (std::size_t k = 0; k < island_count_; ++k) {
    const Claim claim = island(k).solve(start, limits, answer.z, u_, report);
    answer.counters = report.counters();
    if (claim != Claim::kSolved) return give_up(claim, island(k), answer);
  }
  answer.counters = report.counters();
  answer.claim = Claim::kSolved;
  bound_slips(answer.z);
  write_velocity(answer);
  report.write_text(text_of(answer));
}

void Auto::give_up(Claim claim, const IslandSolver& island, Answer& answer) {
  answer.claim = claim;
  answer.z.setZero();
  std::string& text = text_of(answer);
  text.assign("island of ");
  text += std::to_string(island.contacts().size());
  text += " contacts: ";
  text += claim == Claim::kTimeLimit || claim == Claim::kIterationLimit ? to_string(claim) : island.answer().detail;
  if (island.answer().claim == Claim::kUnsupported) answer.z.resize(0);
  const Vector& proof = island.answer().farkas;
  if (claim != Claim::kUnsolvable || proof.size() == 0) return;
  Vector& farkas = cleared_vectors().farkas;
  farkas.setZero(problem().contact()->nc());
  for (Index k = 0; k < proof.size(); ++k) farkas(island.contacts()[static_cast<std::size_t>(k)]) = proof(k);
  answer.farkas.swap(farkas);
}

/// lambda of the contacts that no answer includes: the slip under no friction.
void Auto::bound_slips(Vector& z) const {
  const ContactProblem& contact = *problem().contact();
  const ContactLayout& layout = cutter_->layout();
  for (Index k = 0; k < layout.cones; ++k) {
    const auto c = static_cast<std::size_t>(layout.cone_contact[static_cast<std::size_t>(k)]);
    if (carries_[c] != 0) continue;
    double slip = 0;
    for (Index t = 0; t < contact.edges[c] / 2; ++t) {
      const double speed =
          std::visit([&](const auto& D) { return D.col(layout.friction_begin[c] + t).dot(u_); }, contact.D);
      slip = std::max(slip, std::abs(speed));
    }
    z(layout.lambda_offset() + k) = slip;
  }
}

void Auto::write_velocity(Answer& answer) {
  for (std::size_t k = 0; k < island_count_; ++k) {
    if (!islands_[k]->gave_velocity()) return;
  }
  velocity_ = u_;
  answer.velocity.swap(velocity_);
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
