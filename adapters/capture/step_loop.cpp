#include "adapters/capture/solver_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "adapters/capture/problem.h"
#include "adapters/worker/worker_client.h"
#include "core/registry.h"

namespace lcpbench::capture {
namespace {

constexpr double kTimeLimitS = 60;
/// Positions are projected as engines do: so deep a contact is left alone [m], and of more this share goes in a step.
constexpr double kAllowedDepth = 1e-4;
constexpr double kCorrectedShare = 0.2;

std::unique_ptr<TimedSolver> opened(const Spec& spec) {
  const RegisteredSolver& solver = find_solver(spec.name);
  if (solver.in_process()) return in_process(make_solver(spec));
  return worker_solver(worker_executable(solver), canonical_solver_spec(spec));
}

/// N'u of a contact problem.
Vector along_normals(const ContactProblem& contact, const Vector& u) {
  return std::visit([&](const auto& N) { return Vector(N.transpose() * u); }, contact.N);
}

}  // namespace

SolverLoop::SolverLoop(const std::string& spec, Use use, double step_length)
    : name_(spec), use_(use), h_(step_length), solver_(opened(parse_spec(spec))) {}

/// @returns whether there is an answer to move on with
bool SolverLoop::solve(const Problem& problem) {
  solver_->run(problem, {.time_limit_s = kTimeLimitS}, timed_);
  const Answer& answer = timed_.answer;
  if (use_ == Use::kSolved) return answer.claim == Claim::kSolved;
  return answer.z.size() == problem.size() && answer.z.allFinite();
}

Eigen::VectorXd SolverLoop::operator()(Snapshot& snapshot) {
  const Problem problem = problem_of(snapshot);
  const ContactProblem& contact = *problem.contact();
  claim_ = "none";
  if (contact.nc() == 0) return contact.v;
  const bool solved = solve(problem);
  const Answer& answer = timed_.answer;
  claim_ = to_string(answer.claim);
  if (!solved) {
    if (answer.claim == Claim::kUnsupported) {
      failure_ = name_ + " does not take it: " + (answer.detail.empty() ? claim_ : answer.detail);
    } else {
      failure_ = name_ + " did not solve it: " + claim_;
      if (!answer.detail.empty()) failure_ += ", " + answer.detail;
    }
    return contact.v;
  }
  const bool whole = answer.velocity.size() == contact.ngc() && answer.velocity.allFinite();
  Eigen::VectorXd velocity = whole ? Vector(answer.velocity) : post_impact_velocity(contact, answer.z);
  if (use_ == Use::kReplay) correct(snapshot, velocity);
  return velocity;
}

/// The smallest change of positions, in the metric of the inertia, that takes a share of each penetration back and
/// opens none: a problem without friction, in metres, for the same solver. Without an answer nothing is corrected.
void SolverLoop::correct(Snapshot& snapshot, const Eigen::VectorXd& velocity) {
  double deepest = 0;
  for (const ContactState& contact : snapshot.contacts) deepest = std::max(deepest, -contact.gap);
  if (deepest <= kAllowedDepth) return;
  Snapshot displaced = snapshot;
  for (BodyState& body : displaced.bodies) {
    body.linear_velocity.setZero();
    body.angular_velocity.setZero();
  }
  for (BlockState& block : displaced.blocks) block.velocity.setZero();
  const Vector approach = along_normals(*problem_of(snapshot).contact(), velocity);
  for (std::size_t i = 0; i < displaced.contacts.size(); ++i) {
    ContactState& contact = displaced.contacts[i];
    contact.edges = 0;
    contact.offset = contact.gap > 0 ? std::max(0.0, contact.gap + h_ * approach(static_cast<Index>(i)))
                                     : kCorrectedShare * std::min(0.0, contact.gap + kAllowedDepth);
  }
  const Problem problem = problem_of(displaced);
  if (!solve(problem)) return;
  snapshot.correction = post_impact_velocity(*problem.contact(), timed_.answer.z);
  // What cannot be corrected, as a body in a gap that is too narrow, must not be thrown out.
  const double farthest = along_normals(*problem.contact(), snapshot.correction).lpNorm<Eigen::Infinity>();
  if (farthest > deepest) snapshot.correction *= deepest / farthest;
}

}  // namespace lcpbench::capture
