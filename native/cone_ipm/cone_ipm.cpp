#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/answer/contact_residual.h"
#include "core/registry.h"
#include "core/round_cone.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"
#include "native/cone_ipm/cone_island.h"
#include "native/contacts/problem_cutter.h"

namespace lcpbench {
namespace {

/// Of an island: its matrices are dense.
constexpr std::size_t kMostCoordinates = 3000;

/// The residual in double up to which an answer is claimed, relative to the scale, unless the tolerance is larger.
constexpr double kAcceptedResidual = 1e-8;

struct ConeIpmSettings {
  bool cone = false;
  ConeIsland::Slip slip = ConeIsland::Slip::kNewton;
  double tolerance = 1e-10;
  double error = 0;
  std::int64_t max_iterations = 2000;

  void visit(auto&& field) {
    using Slip = ConeIsland::Slip;
    field("cone", cone,
          "solve contacts with friction with the round cone, which is another problem; false: refuse them");
    field("slip", slip, Choices<Slip>{{{"newton", Slip::kNewton}, {"rounds", Slip::kRounds}, {"none", Slip::kNone}}},
          "newton: the slip speed is an unknown of each step, and rounds follow where that fails; rounds: it is held "
          "in one convex problem after the other; none: it is left out, which is the convex relaxation, another model "
          "that the answer is then judged by");
    field("tolerance", tolerance, RealRange{.min = 0},
          "stop when the residual of the cone's conditions is at most this times the scale of the island");
    field("error", error, RealRange{.min = 0},
          "[m/s] stop, and claim solved, when the residual is at most this, if that asks for less than tolerance does");
    field("max_iterations", max_iterations, IntegerRange{.min = 0},
          "Newton steps of each island, those with predictor and corrector among them");
  }

  bool convex() const { return cone && slip == ConeIsland::Slip::kNone; }
  FrictionModel friction_model() const {
    return convex() ? FrictionModel::kConvex : cone ? FrictionModel::kCone : FrictionModel::kPyramid;
  }
};

/// Solves contacts with the round Coulomb cone, island by island, by ConeIsland.
///
/// kSolved: the residual of the cone's conditions, recomputed from the impulses in double, is at most 1e-8, or the
/// tolerance, on every island, and AnswerTest has passed too, or with friction or compliance ContactResidual. That the iteration converges
/// is not proven with friction.
class ConeIpm final : public Solver {
 public:
  explicit ConeIpm(const ConeIpmSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override;

 private:
  struct Part {
    Island island;
    ContactProblem problem;
    Vector v;
    ConeIsland method;
  };

  void on_load(const Problem& problem) override;
  bool approaches() const;
  bool by_cone() const { return problem().contact()->frictional() || problem().contact()->is_soft(); }
  void load_islands(const Problem& problem);
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  Claim solve(Part& part, double deadline_s, Counters& counters);
  void take_velocity(Part& part) const;
  void write(Part& part, Answer& answer);

  ConeIpmSettings settings_;
  std::string refusal_;
  ContactLayout layout_;
  Vector v_;
  std::vector<std::unique_ptr<Part>> parts_;
  bool islands_are_loaded_ = false;       // parts_ are there
  bool idle_contact_penetrates_ = false;  // a contact that moves nothing, of a negative offset
  AnswerTest test_;                       // of hard contacts without friction
  std::optional<ContactResidual> exact_;  // of others
  ContactResidual::Point point_;          // by exact_
};

void ConeIpm::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  parts_.clear();
  refusal_.clear();
  islands_are_loaded_ = false;
  exact_.reset();
  idle_contact_penetrates_ = false;
  if (contact.frictional()) refusal_ = why_no_round_cone(contact);
  if (!refusal_.empty()) return;
  layout_ = contact_layout(contact);
  v_ = contact.v;
  if (!by_cone()) test_.load(problem);
  if (approaches()) load_islands(problem);
}

/// Whether some contact does: where none does, no impulse is the answer. In the convex model what slides must lift off.
bool ConeIpm::approaches() const {
  const ContactProblem& contact = *problem().contact();
  if (settings_.convex() && contact.frictional()) return true;
  for (Index i = 0; i < contact.nc(); ++i) {
    if (!(dot_column(contact.N, i, v_) + contact.offset(i) >= 0)) return true;
  }
  return false;
}

void ConeIpm::load_islands(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  if (by_cone()) {
    exact_.emplace(contact).set_velocity(v_);
    if (exact_->lcp) {  // the first test takes all memory, and finds M_ii
      exact_->take(Vector::Ones(layout_.size()), point_);
      exact_->rho(point_, settings_.friction_model());
    }
  }
  ProblemCutter cutter;
  cutter.load(problem);
  std::vector<char> moves(static_cast<std::size_t>(layout_.nc), 0);
  for (Island& island : find_islands(contact)) {
    if (const auto size = island.coordinates.size(); size > kMostCoordinates) {
      refusal_ = "an island of " + std::to_string(size) + " coordinates: takes " + std::to_string(kMostCoordinates);
      return;
    }
    auto part = std::make_unique<Part>();
    cutter.cut(island.contacts, island.coordinates, v_, true, part->problem);
    part->v = part->problem.v;
    part->method.load(part->problem);
    for (const Index i : island.contacts) moves[static_cast<std::size_t>(i)] = 1;
    part->island = std::move(island);
    parts_.push_back(std::move(part));
  }
  for (Index i = 0; i < layout_.nc; ++i) {
    if (moves[static_cast<std::size_t>(i)] == 0 && contact.offset(i) < 0) idle_contact_penetrates_ = true;
  }
  islands_are_loaded_ = true;
}

void ConeIpm::take_velocity(Part& part) const {
  for (std::size_t i = 0; i < part.island.coordinates.size(); ++i) {
    part.v(static_cast<Index>(i)) = v_(part.island.coordinates[i]);
  }
  part.method.set_velocity(part.problem, part.v);
}

void ConeIpm::on_update(const Vector& v) {
  if (!refusal_.empty() || !v.allFinite()) return Solver::on_update(v);
  v_ = v;
  for (const auto& part : parts_) take_velocity(*part);
  if (!by_cone()) test_.set_velocity(v);
  if (exact_) exact_->set_velocity(v);
  if (!islands_are_loaded_ && approaches()) load_islands(problem());
}

Claim ConeIpm::solve(Part& part, double deadline_s, Counters& counters) {
  using Stop = ConeIsland::Stop;
  using Slip = ConeIsland::Slip;
  part.method.start();
  // Without friction AnswerTest asks for the accuracy of all native solvers.
  const double allowed = by_cone() ? settings_.error / part.method.speed() : 0.0;
  // Neither test passes more than kClaimedResidual.
  const double tolerance = std::max(std::min(settings_.tolerance, kClaimedResidual / 2), allowed);
  const double accepted = std::max(kAcceptedResidual, tolerance);
  const ConeLimits limits{.tolerance = tolerance,
                          .accepted = accepted,
                          .max_iterations = settings_.max_iterations,
                          .deadline_s = deadline_s};
  Stop stop = part.method.solve(settings_.slip, limits, counters);
  if (settings_.slip == Slip::kNewton && !(part.method.residual() <= accepted)) {
    stop = part.method.solve(Slip::kRounds, limits, counters);
  }
  if (part.method.residual() <= accepted) return Claim::kSolved;
  if (stop == Stop::kTimeLimit) return Claim::kTimeLimit;
  return counters.iterations >= limits.max_iterations ? Claim::kIterationLimit : Claim::kNumericalFailure;
}

/// The island's impulses, and its velocity under them; part.v is v before and after. @pre solve(part); answer.velocity
/// is v_, and answer.z zero where nothing is written
void ConeIpm::write(Part& part, Answer& answer) {
  for (std::size_t k = 0; k < part.island.contacts.size(); ++k) {
    const Index contact = part.island.contacts[k];
    const Eigen::Vector3d impulse = part.method.impulse(static_cast<Index>(k));
    answer.z(contact) = impulse(0);
    const auto c = static_cast<std::size_t>(contact);
    if (layout_.lambda[c] < 0) continue;
    const Index begin = layout_.friction_begin[c];
    share_among_directions(impulse(1), impulse(2),
                           answer.z.segment(layout_.friction_offset() + begin, layout_.friction_begin[c + 1] - begin));
  }
  part.method.add_velocity_change(part.problem, part.v);
  for (std::size_t i = 0; i < part.island.coordinates.size(); ++i) {
    answer.velocity(part.island.coordinates[i]) = part.v(static_cast<Index>(i));
  }
  take_velocity(part);
}

void ConeIpm::on_solve(const SolveRequest& request, Answer& answer) {
  answer.counters = {.iterations = 0, .pivots = -1, .factorizations = 0};
  if (!refusal_.empty()) {
    answer.claim = Claim::kUnsupported;
    answer.detail = refusal_;
    return;
  }
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  answer.velocity = v_;
  answer.claim = idle_contact_penetrates_ ? Claim::kNumericalFailure : Claim::kSolved;
  double worst = 0;
  for (const auto& part : parts_) {
    Counters own{.iterations = 0, .pivots = -1, .factorizations = 0};
    const Claim claim = solve(*part, deadline_s, own);
    answer.counters.iterations += own.iterations;
    answer.counters.factorizations += own.factorizations;
    if (claim != Claim::kSolved) answer.claim = claim;
    worst = std::max(worst, part->method.residual());
    write(*part, answer);
  }
  const bool frictional = layout_.cones > 0;
  if (frictional) complete_slip_bounds(*problem().contact(), layout_, answer.velocity, answer.z);
  std::array<char, 80> text{};
  const int length = std::snprintf(text.data(), text.size(), "%sresidual %.1e",
                                   !frictional          ? ""
                                   : settings_.convex() ? "another problem: the convex model of friction; "
                                                        : "another problem: the round friction cone; ",
                                   worst);
  answer.detail.assign(text.data(), static_cast<std::size_t>(length));
  if (!by_cone()) answer.velocity.resize(0);  // no test bounds its rounding
  if (answer.claim != Claim::kSolved) return;
  if (!by_cone()) {
    test_.settle(answer, deadline_s);
  } else if (islands_are_loaded_) {
    if (exact_->lcp && answer.z.allFinite()) {
      exact_->take(answer.z, point_);
      for (Index i = 0; i < answer.velocity.size(); ++i) {
        answer.velocity(i) = to_double(point_.u[static_cast<std::size_t>(i)]);
      }
      if (exact_->rho(point_, settings_.friction_model(), settings_.error) <= kClaimedResidual) return;
    }
    answer.claim = Claim::kNumericalFailure;
  }
}

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .frictionless_only = true,
    .friction_setting = "cone=true",
    .guarantees = "frictionless contact problems with a strictly feasible velocity; with friction none",
    .obeys_time_limit = true,
    .allocation_free = true};

constexpr Capabilities with_friction() {
  Capabilities capabilities = kCapabilities;
  capabilities.frictionless_only = false;
  capabilities.compliance = true;
  return capabilities;
}

constexpr Capabilities kConeCapabilities = with_friction();

const Capabilities& ConeIpm::capabilities() const { return settings_.cone ? kConeCapabilities : kCapabilities; }

}  // namespace

SolverDefinition lcpbench_solver_cone_ipm() {
  return define_solver<ConeIpm, ConeIpmSettings>(
      {.name = "cone_ipm",
       .summary = "interior point in velocity space with the round friction cone, island by island, if cone=true",
       .source =
           "Acary, Armand, Nguyen, Shpakovych 2024, Second-order cone programming for frictional contact mechanics",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
