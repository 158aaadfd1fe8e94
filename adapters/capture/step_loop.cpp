#include "adapters/capture/step_loop.h"

#include <utility>

#include "adapters/capture/problem.h"
#include "adapters/worker/worker_client.h"
#include "core/registry.h"

namespace lcpbench::capture {
namespace {

std::unique_ptr<TimedSolver> open_worker(const Spec& spec) {
  return worker_solver(worker_executable(find_solver(spec.name)), canonical_solver_spec(spec));
}

StepProblem step_of(const Snapshot& snapshot, double h) {
  StepProblem step;
  step.contacts = contacts_of(snapshot);
  step.force_change.resize(static_cast<Index>(6 * snapshot.bodies.size()));
  Index at = 0;
  for (const BodyState& body : snapshot.bodies) {
    step.force_change.segment<3>(at) = body.linear_change;
    step.force_change.segment<3>(at + 3) = body.angular_change;
    at += 6;
  }
  for (const ContactState& contact : snapshot.contacts) {
    step.gaps.push_back(contact.gap);
    step.ids.push_back(contact_id(contact.id));
  }
  step.h = h;
  return step;
}

Vector velocity_of(const StepProblem& step) {
  if (const auto* problem = std::get_if<ContactProblem>(&step.contacts)) return problem->v;
  const std::vector<RigidBody>& bodies = std::get<RigidScene>(step.contacts).bodies;
  Vector velocity(static_cast<Index>(6 * bodies.size()));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    velocity.segment<6>(static_cast<Index>(6 * i)) << bodies[i].linear_velocity, bodies[i].angular_velocity;
  }
  return velocity;
}

}  // namespace

StepLoop::StepLoop(const std::string& spec, Use use, double step_length)
    : name_(use == Use::kSolved ? spec : stepper_label(parse_spec(spec))), use_(use), h_(step_length) {
  const Spec solved{"exact", {{"solver", spec}, {"warm", "false"}, {"project", "false"}}};
  stepper_ = make_stepper(use == Use::kSolved ? solved : parse_spec(spec), open_worker);
}

Eigen::VectorXd StepLoop::operator()(Snapshot& snapshot) {
  const StepProblem step = step_of(snapshot, h_);
  const double start = thread_cpu_clock_s();
  stepper_->step(step, answer_);
  cpu_s_ = thread_cpu_clock_s() - start + answer_.elsewhere_s;
  claim_ = snapshot.contacts.empty() && snapshot.rows.empty() ? "none" : to_string(answer_.claim);
  const bool answered = answer_.velocity.size() > 0 && (use_ == Use::kReplay || answer_.claim == Claim::kSolved);
  if (answered) {
    snapshot.correction = answer_.correction;
    snapshot.substeps = answer_.substeps;
    return answer_.velocity;
  }
  if (answer_.claim == Claim::kUnsupported) {
    failure_ = "refused: " + (answer_.detail.empty() ? name_ + " does not take it" : answer_.detail);
  } else {
    failure_ = name_ + " did not solve it: " + claim_;
    if (!answer_.detail.empty()) failure_ += ", " + answer_.detail;
  }
  return velocity_of(step);
}

}  // namespace lcpbench::capture
