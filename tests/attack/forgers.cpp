#include "tests/attack/forgers.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

#include "core/answer/cone_friction.h"
#include "core/registry.h"
#include "generators/random.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench::attack {
namespace {

using Friction = Judge::Friction;

constexpr const char* kForgedAnswer = "forged-answer";
constexpr const char* kForgedVelocity = "forged-velocity";

/// How close to the bound both sides are. The diagonal entries of M and G* are right to about 2^-30, near singular ones
/// have been seen to be off by 2^-24.
constexpr double kClosest = 0x1p-22;

/// Steps t of which the first passes and the second does not, next to each other. None where all pass.
std::vector<double> bound_of(const std::function<bool(double)>& passes) {
  double inside = 0, outside = 1e-25;
  while (passes(outside)) {
    inside = outside;
    outside *= 30;
    if (outside > 1e40) return {};
  }
  while (outside > inside * (1 + kClosest)) {
    const double middle = inside > 0 ? std::sqrt(inside * outside) : outside * 1e-3;
    if (middle < 1e-60 || middle <= inside || middle >= outside) break;
    (passes(middle) ? inside : outside) = middle;
  }
  return {inside, outside};
}

class Forger : public Subject {
 public:
  Outcome meet(Target& target, double time_limit_s, std::string& detail) override {
    chance_.seed(stream_id(target.problem.name()));
    Answer answer;
    if (!start(target, time_limit_s, answer)) return Outcome::kRefused;
    const auto moved = [&](double t) {
      Answer forged = answer;
      move(forged, t);
      return forged;
    };
    const auto passes = [&](double t) { return holds(target, moved(t)); };
    if (!passes(0)) return Outcome::kRefused;
    std::vector<double> steps = bound_of(passes);
    if (steps.empty()) return Outcome::kRefused;
    for (const double factor : {0.5, 0.9, 1.1, 2.0}) steps.push_back(factor * steps[1]);
    bool unresolved = false;
    for (const double t : steps) {
      const Answer forged = moved(t);
      Errors errors = target.evaluator.errors(forged);
      measure_friction(friction_, target.problem, forged, errors);
      unresolved = unresolved || errors.unresolved;
      if (errors.unresolved || errors.solved == passes(t)) continue;
      char text[200];
      std::snprintf(text, sizeof text, "model %d, step %.17g: the evaluation says %s, rho %.17g, eta %.17g, velocity %.17g",
                    static_cast<int>(friction_), t, errors.solved ? "solved" : "not solved",
                    errors.velocity_residual_relative, errors.backward_row_norm, errors.returned_velocity_error);
      detail = text;
      return Outcome::kOtherVerdict;
    }
    target.unresolved = target.unresolved || unresolved;
    return unresolved ? Outcome::kUnresolved : Outcome::kSolved;
  }

 protected:
  /// A right answer, and how move() changes it. @returns whether there is one
  virtual bool start(Target& target, double time_limit_s, Answer& answer) = 0;
  virtual void move(Answer& answer, double t) const = 0;
  virtual bool holds(const Target& target, const Answer& answer) const = 0;

  Index below(Index count) { return static_cast<Index>(chance_() % static_cast<std::uint64_t>(count)); }
  double sign() { return below(2) == 0 ? 1 : -1; }
  /// An exact solution that is known, or by the solver of that friction, or no impulses.
  static Answer solution(const Target& target, double time_limit_s, Friction friction) {
    if (friction == Friction::kPyramid && target.truth.z.size() > 0) {
      Answer known;
      known.z = target.truth.z;
      known.claim = Claim::kSolved;
      return known;
    }
    constexpr const char* kSolvers[] = {"contact_lemke", "cone_ipm{cone=true}", "cone_ipm{cone=true,slip=none}"};
    const bool bare = target.problem.contact() == nullptr;
    const auto solver = make_solver(parse_spec(bare ? "lemke" : kSolvers[static_cast<std::size_t>(friction)]));
    Answer answer;
    solver->load(target.problem);
    solver->solve({.time_limit_s = time_limit_s}, answer);
    if (answer.claim != Claim::kSolved || answer.z.size() != target.problem.size()) {
      answer.z = Vector::Zero(target.problem.size());
    }
    answer.claim = Claim::kSolved;
    answer.velocity.resize(0);
    answer.farkas.resize(0);
    return answer;
  }

  Friction friction_ = Friction::kPyramid;

 private:
  std::mt19937_64 chance_;
};

/// Moves one entry, all by shares of their own, or a few by as much.
class AnswerForger final : public Forger {
 protected:
  bool start(Target& target, double time_limit_s, Answer& answer) override {
    const ContactProblem* contact = target.problem.contact();
    friction_ = Friction::kPyramid;
    if (contact != nullptr && contact->frictional() && is_round(*contact)) friction_ = static_cast<Friction>(below(3));
    answer = solution(target, time_limit_s, friction_);
    const Index n = answer.z.size();
    if (n == 0) return false;
    way_ = Vector::Zero(n);
    const Index kind = below(4);
    if (kind <= 1) way_(below(n)) = sign();
    for (Index i = 0; kind == 2 && i < n; ++i) way_(i) = sign() * answer.z(i);
    for (Index i = 0; kind == 3 && i < n; ++i) way_(i) = static_cast<double>(below(5) - 2);
    return !way_.isZero(0);
  }
  void move(Answer& answer, double t) const override { answer.z = Vector(answer.z + t * way_); }
  bool holds(const Target& target, const Answer& answer) const override {
    return target.judge.solves(answer.z, friction_);
  }

 private:
  /// The exact judge knows contacts of four edges.
  static bool is_round(const ContactProblem& contact) {
    const auto has_few = [](int edges) { return edges == 0 || edges == 4; };
    return std::all_of(contact.edges.begin(), contact.edges.end(), has_few) && why_no_cone(contact).empty();
  }

  Vector way_;
};

/// Moves a coordinate of the velocity, or all.
class VelocityForger final : public Forger {
 protected:
  bool start(Target& target, double time_limit_s, Answer& answer) override {
    if (target.problem.contact() == nullptr || target.problem.contact()->ngc() == 0) return false;
    answer = solution(target, time_limit_s, friction_);
    if (!target.judge.solves(answer.z)) return false;
    answer.velocity = target.judge.velocity(answer.z);
    const Index ngc = answer.velocity.size();
    way_ = Vector::Zero(ngc);
    if (below(3) > 0) {
      way_(below(ngc)) = sign();
    } else {
      for (double& value : way_) value = static_cast<double>(below(5) - 2);
    }
    return answer.velocity.allFinite() && !way_.isZero(0);
  }
  void move(Answer& answer, double t) const override { answer.velocity = Vector(answer.velocity + t * way_); }
  bool holds(const Target& target, const Answer& answer) const override {
    return target.judge.velocity_holds(answer.z, answer.velocity);
  }

 private:
  Vector way_;
};

}  // namespace

std::vector<std::string> forger_names() { return {kForgedAnswer, kForgedVelocity}; }

std::unique_ptr<Subject> make_forger(const std::string& name) {
  if (name == kForgedAnswer) return std::make_unique<AnswerForger>();
  if (name == kForgedVelocity) return std::make_unique<VelocityForger>();
  return nullptr;
}

}  // namespace lcpbench::attack
