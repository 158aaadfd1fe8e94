// What a step costs that follows another one: cold, load and solve by an object that knows of no step before; changed,
// update(problem) and solve from the last answer, matched by the ids of the contacts; same, update(v) and solve from
// the last answer, for steps in which only the velocity is new. Each of the first two gets a copy of the problem that
// was made just before, as if an engine had written it. CSV, medians of thread CPU time. The parts of changed (match,
// update, solve) are timed in rounds of their own, because reading the clock takes about 0.2 us. Not a test;
// results/native/README.md has its command.
//
//   warm_steps ROUNDS stack HEIGHT STEPS SOLVER...   a stack of cubes at rest that is disturbed a little in each step
//   warm_steps ROUNDS FILE.scenes SOLVER...          the steps of a file, which should follow each other
//
// wrong: steps of the second column that are not verified. held: of these, steps in which `detail` says so.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/scenes_file.h"
#include "core/registry.h"
#include "core/timed_solve.h"
#include "core/warm_start.h"
#include "study/evaluation/evaluation.h"
#include "study/measure/box_stacks.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

struct Step {
  Problem problem;
  std::vector<ContactId> ids;
};

/// Cubes that lie a little askew, each step otherwise: contacts, normals and inertia change with the velocity.
Step tilted_stack(int height, int step) {
  const testing::BoxStacks shape{.height = height, .fresh = 0.2};
  RigidScene scene = testing::box_stacks(shape);
  const Vector v = testing::falling_velocity(shape, step);
  Step result;
  long number = 1000L * height * step;
  const auto shake = [&] {
    Eigen::Vector3d shaken;
    for (double& entry : shaken) entry = 1e-3 * testing::disturbance(++number);
    return shaken;
  };
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    RigidBody& body = scene.bodies[b];
    body.linear_velocity = v.segment<3>(6 * static_cast<Index>(b));
    body.angular_velocity = v.segment<3>(6 * static_cast<Index>(b) + 3);
    body.position += shake();
    const Eigen::Vector3d axis = shake();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
    const Eigen::Matrix3d inertia = turn * Eigen::Vector3d(0.15, 0.17, 0.18).asDiagonal() * turn.transpose();
    body.inertia = 0.5 * (inertia + inertia.transpose());
  }
  for (std::size_t c = 0; c < scene.contacts.size(); ++c) {
    RigidContact& contact = scene.contacts[c];
    contact.point += shake();
    contact.normal = (Eigen::Vector3d::UnitZ() + shake()).normalized();
    contact.tangent = (contact.tangent - contact.tangent.dot(contact.normal) * contact.normal).normalized();
    result.ids.push_back(static_cast<ContactId>(c));
  }
  result.problem = Problem("stack", scene);
  return result;
}

std::vector<Step> steps_of_file(const std::string& name) {
  const ScenesFile file(name);
  std::vector<Step> steps;
  for (std::size_t k = 0; k < file.count(); ++k) {
    const SceneStep step = file.read(k);
    Step next{.problem = step.problem, .ids = {}};
    if (step.problem.contact()->nc() == 0) continue;
    for (const std::string& id : step.contact_ids) next.ids.push_back(contact_id(id));
    steps.push_back(std::move(next));
  }
  return steps;
}

double us_since(double begin) { return 1e6 * (thread_cpu_clock_s() - begin); }

/// The same contacts as in the first step, with the velocity of another: nothing where it has other coordinates.
bool is_same_size(const Step& first, const Step& other) {
  return first.problem.contact()->ngc() == other.problem.contact()->ngc();
}

Problem copy_of(const Problem& problem) { return {problem.name(), ContactProblem(*problem.contact())}; }

/// A solver that goes from step to step, from the last answer.
class WarmSteps {
 public:
  WarmSteps(const std::string& spec, const Step& first)
      : solver_(make_solver(parse_spec(spec))), layout_(contact_layout(*first.problem.contact())) {
    solver_->load(first.problem);
    solver_->solve({}, answer_);
  }

  void match(const Step& before, const Step& now, const Problem& problem) {
    match_.find(before.ids, now.ids);
    ContactLayout layout = contact_layout(*problem.contact());
    matched_start(answer_.z, layout_, match_, layout, start_);
    layout_ = std::move(layout);
  }
  void update(const Problem& problem) { solver_->update(problem); }
  void solve() { solver_->solve({.start = &start_}, answer_); }
  const Answer& answer() const { return answer_; }

 private:
  std::unique_ptr<Solver> solver_;
  ContactLayout layout_;
  ContactMatch match_;
  Vector start_;
  Answer answer_;
};

struct Measured {
  std::vector<double> cold, match, update, solve, changed, ratio;
  int held = 0;
  int wrong = 0;
  double difference = 0;  ///< largest difference of velocities between cold and changed, relative to that before
};

/// The parts of a step from the last answer, one after the other.
void measure_parts(const std::string& spec, const std::vector<Step>& steps, int rounds, Measured& measured) {
  for (int round = 0; round < rounds; ++round) {
    WarmSteps warm(spec, steps.front());
    for (std::size_t k = 1; k < steps.size(); ++k) {
      const Problem problem = copy_of(steps[k].problem);
      double begin = thread_cpu_clock_s();
      const auto part = [&begin](std::vector<double>& to) {
        to.push_back(us_since(begin));
        begin = thread_cpu_clock_s();
      };
      warm.match(steps[k - 1], steps[k], problem);
      part(measured.match);
      warm.update(problem);
      part(measured.update);
      warm.solve();
      part(measured.solve);
    }
  }
}

void measure_changed(const std::string& spec, const std::vector<Step>& steps, int rounds, Measured& measured) {
  std::vector<std::vector<double>> cold(steps.size()), changed(steps.size());
  for (int round = 0; round < rounds; ++round) {
    const auto fresh = make_solver(parse_spec(spec));
    Answer cold_answer;
    WarmSteps warm(spec, steps.front());
    for (std::size_t k = 1; k < steps.size(); ++k) {
      const Problem written = copy_of(steps[k].problem);
      double begin = thread_cpu_clock_s();
      fresh->load(written);
      fresh->solve({}, cold_answer);
      cold[k].push_back(us_since(begin));
      const Problem problem = copy_of(steps[k].problem);
      begin = thread_cpu_clock_s();
      warm.match(steps[k - 1], steps[k], problem);
      warm.update(problem);
      warm.solve();
      changed[k].push_back(us_since(begin));
      if (round > 0) continue;
      const Answer& answer = warm.answer();
      if (!Evaluator(problem).errors(answer).solved) ++measured.wrong;
      if (answer.detail.find("held_contacts") != std::string::npos) ++measured.held;
      const ContactProblem& contact = *problem.contact();
      if (answer.claim != Claim::kSolved || cold_answer.claim != Claim::kSolved) continue;
      const Vector difference = post_impact_velocity(contact, answer.z) - post_impact_velocity(contact, cold_answer.z);
      measured.difference =
          std::max(measured.difference, difference.lpNorm<Eigen::Infinity>() / contact.v.lpNorm<Eigen::Infinity>());
    }
  }
  for (std::size_t k = 1; k < steps.size(); ++k) {
    measured.cold.push_back(spread(cold[k]).median);
    measured.changed.push_back(spread(changed[k]).median);
    measured.ratio.push_back(std::log(measured.cold.back() / measured.changed.back()));
  }
}

/// The contacts of the first step with the velocities of all.
double measure_same(const std::string& spec, const std::vector<Step>& steps, int rounds) {
  std::vector<double> times;
  for (int round = 0; round < rounds; ++round) {
    const auto solver = make_solver(parse_spec(spec));
    Answer answer;
    Vector start;
    solver->load(steps.front().problem);
    solver->solve({}, answer);
    for (std::size_t k = 1; k < steps.size(); ++k) {
      if (!is_same_size(steps.front(), steps[k])) continue;
      start = answer.z;
      const double begin = thread_cpu_clock_s();
      solver->update(steps[k].problem.contact()->v);
      solver->solve({.start = &start}, answer);
      times.push_back(us_since(begin));
    }
  }
  return spread(times).median;
}

void measure(const std::string& name, const std::vector<Step>& steps, const std::string& spec, int rounds) {
  Measured measured;
  measure_changed(spec, steps, rounds, measured);
  measure_parts(spec, steps, rounds, measured);
  double contacts = 0;
  double ratio = 0;
  for (const Step& step : steps) contacts += static_cast<double>(step.problem.contact()->nc());
  for (const double part : measured.ratio) ratio += part;
  const double count = static_cast<double>(measured.ratio.size());
  const double cold_us = spread(measured.cold).median;
  const double changed_us = spread(measured.changed).median;
  std::printf("%s,\"%s\",%.0f,%ld,%zu,%d,%.1f,%.1f,%.1f,%.1f,%.1f,%.2f,%.2f,%.1f,%d,%d,%.1e\n", name.c_str(),
              spec.c_str(), contacts / static_cast<double>(steps.size()),
              static_cast<long>(steps.front().problem.contact()->ngc()), steps.size() - 1, rounds, cold_us,
              spread(measured.match).median, spread(measured.update).median, spread(measured.solve).median, changed_us,
              cold_us / changed_us, std::exp(ratio / count), measure_same(spec, steps, rounds), measured.held,
              measured.wrong, measured.difference);
  std::fflush(stdout);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  using namespace lcpbench;
  const bool is_stack = argc > 2 && std::string_view(argv[2]) == "stack";
  const int first = is_stack ? 5 : 3;
  if (argc <= first) {
    std::fputs("usage: warm_steps ROUNDS stack HEIGHT STEPS SOLVER... | warm_steps ROUNDS FILE.scenes SOLVER...\n",
               stderr);
    return 2;
  }
  std::vector<Step> steps;
  if (is_stack) {
    for (int k = 0; k <= std::max(1, std::atoi(argv[4])); ++k) steps.push_back(tilted_stack(std::atoi(argv[3]), k));
  } else {
    steps = steps_of_file(argv[2]);
  }
  if (steps.size() < 2) {
    std::fputs("warm_steps: fewer than two steps with contacts\n", stderr);
    return 2;
  }
  std::puts(
      "scene,solver,contacts,coordinates,steps,rounds,cold_us,match_us,update_us,solve_us,changed_us,cold_over_changed,"
      "geometric_mean,same_us,held,wrong,velocity_difference");
  for (int k = first; k < argc; ++k)
    measure(is_stack ? "stack" : argv[2], steps, argv[k], std::max(1, std::atoi(argv[1])));
}
