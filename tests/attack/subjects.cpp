#include "tests/attack/subjects.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/registry.h"
#include "native/lcpbench.h"
#include "study/evaluation/friction_model.h"
#include "tests/attack/forgers.h"

namespace lcpbench::attack {
namespace {

constexpr const char* kCertify = "certify";
constexpr const char* kReader = "reader";
constexpr std::string_view kEmbedded = "embedded:";

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// The problem with its contacts at another velocity before the impact.
Problem at_another_velocity(const ContactProblem& contact) {
  ContactProblem other = contact;
  other.v = Vector(-2 * contact.v.reverse());
  return {"another-velocity", std::move(other)};
}

void solve(Solver& solver, const Target& target, double time_limit_s, Answer& answer) {
  const ContactProblem* contact = target.problem.contact();
  SolveRequest request{.time_limit_s = time_limit_s};
  if (target.approach == Approach::kUpdate && contact != nullptr) {
    solver.load(at_another_velocity(*contact));
    solver.solve(request, answer);
    if (answer.claim == Claim::kUnsupported) return;  // update() wants a problem that was taken
    solver.update(contact->v);
    solver.solve(request, answer);
    return;
  }
  solver.load(target.problem);
  Vector start(target.problem.size());
  for (Index i = 0; i < start.size(); ++i) start(i) = i % 3 == 0 ? 1e6 : i % 3 == 1 ? 0 : -0x1p-40;
  if (target.approach == Approach::kStart) request.start = &start;
  solver.solve(request, answer);
}

using Friction = Judge::Friction;

/// Why the answer contradicts what is exactly true, or what it is otherwise.
Outcome classify(Target& target, const Answer& answer, Friction friction, std::string& detail);

class SolverSubject final : public Subject {
 public:
  explicit SolverSubject(std::string name) : name_(std::move(name)), solver_(make_solver(parse_spec(name_))) {
    const Spec spec = parse_spec(name_);
    friction_ = find_solver(spec.name).definition.friction(spec.options);
  }

  Outcome meet(Target& target, double time_limit_s, std::string& detail) override {
    solve(*solver_, target, time_limit_s, answer_);
    const Outcome outcome = classify(target, answer_, friction_model(friction_, target.problem), detail);
    if (!contradiction(outcome)) return outcome;
    const auto fresh = make_solver(parse_spec(name_));
    Answer again;
    solve(*fresh, target, time_limit_s, again);
    if (again.claim == answer_.claim) return outcome;
    detail += std::string("; a fresh solver claims ") + lcpbench::to_string(again.claim);
    return Outcome::kDiffersAgain;
  }

 private:
  std::string name_;
  Friction friction_ = Friction::kPyramid;
  std::unique_ptr<Solver> solver_;
  Answer answer_;
};

Outcome classify(Target& target, const Answer& answer, Friction friction, std::string& detail) {
  detail = std::string(to_string(target.approach)) + ": " + lcpbench::to_string(answer.claim) +
           (answer.detail.empty() ? "" : " (" + answer.detail + ")");
  if (answer.claim == Claim::kUnsupported) return Outcome::kRefused;
  const bool round = friction != Friction::kPyramid;
  const bool solves = target.judge.solves(answer.z, friction);
  detail += round ? ", by the cone's measure" : ", measure " + number(target.judge.measure());
  const bool moves_so =
      answer.velocity.size() == 0 || !solves || target.judge.velocity_holds(answer.z, answer.velocity);
  // The truth is that of the pyramid.
  const bool solvable = !round && target.truth.truth == Truth::kSolvable;
  const bool unsolvable = !round && target.truth.truth == Truth::kUnsolvable;
  const bool witness = answer.farkas.size() > 0 && disproves(target.problem, answer.farkas);
  target.passes = target.passes || (!round && solves);
  if (answer.claim == Claim::kSolved && !solves) return Outcome::kFalseSolved;
  if (answer.claim == Claim::kSolved && !moves_so) return Outcome::kFalseVelocity;
  if (answer.claim == Claim::kUnsolvable && solvable) return Outcome::kFalseUnsolvable;
  const bool shows_vector = answer.claim != Claim::kUnsolvable || answer.farkas.size() > 0;
  if (answer.detail.find("proven") != std::string::npos && shows_vector && !witness) return Outcome::kFalseProven;
  Errors errors = target.evaluator.errors(answer);
  measure_friction(friction, target.problem, answer, errors);
  if (errors.unresolved) {
    target.unresolved = target.unresolved || answer.claim == Claim::kSolved;
    return Outcome::kUnresolved;
  }
  if (errors.solved != (solves && moves_so)) {
    detail += std::string("; the evaluation says ") + (errors.solved ? "solved" : "not solved") + ", rho " +
              number(errors.velocity_residual_relative) + ", eta " + number(errors.backward_row_norm);
    return Outcome::kOtherVerdict;
  }
  const Truth known = target.evaluator.truth();
  if ((known == Truth::kSolvable && unsolvable) || (known == Truth::kUnsolvable && solvable)) {
    detail += "; the evaluation takes another truth for proven";
    return Outcome::kOtherVerdict;
  }
  if (answer.farkas.size() > 0 && target.evaluator.check_farkas(answer.farkas) != witness) {
    detail += "; the evaluation judges the proof otherwise";
    return Outcome::kOtherVerdict;
  }
  if (answer.claim == Claim::kSolved) return unsolvable ? Outcome::kNearlySolved : Outcome::kSolved;
  if (answer.claim == Claim::kUnsolvable) return witness ? Outcome::kUnsolvable : Outcome::kUnsolvableNoProof;
  return solvable ? Outcome::kMissed : Outcome::kOpen;
}

/// The solver as a simulator embeds it. Its velocity belongs to the answer.
class EmbeddedSubject final : public Subject {
 public:
  explicit EmbeddedSubject(std::string_view spec) : solver_(spec) {}

  Outcome meet(Target& target, double time_limit_s, std::string& detail) override {
    const ContactProblem* contact = target.problem.contact();
    if (contact == nullptr) return Outcome::kRefused;
    try {
      const bool updates = target.approach == Approach::kUpdate;
      solver_.load(updates ? *at_another_velocity(*contact).contact() : *contact);
      solver_.solve(time_limit_s);
      if (updates) {
        solver_.set_velocity(contact->v);
        solver_.solve(time_limit_s);
      }
    } catch (const InputError&) {
      return Outcome::kRefused;
    }
    Answer answer = solver_.answer();
    if (answer.claim == Claim::kSolved) answer.velocity = solver_.velocity();
    const Outcome outcome = classify(target, answer, Friction::kPyramid, detail);
    const bool passed = outcome == Outcome::kSolved || outcome == Outcome::kNearlySolved;
    if (!passed || contact->ngc() == 0) return outcome;
    const Index k = contact->nc() % contact->ngc();
    answer.velocity(k) += target.judge.beyond_velocity(answer.z)(k);
    if (!target.evaluator.errors(answer).solved) return outcome;
    detail += "; the evaluation lets a wrong velocity pass, " + number(answer.velocity(k)) + " in coordinate " +
              std::to_string(k);
    return Outcome::kOtherVerdict;
  }

 private:
  ContactSolver solver_;
};

/// Readers take bounds of 1e20 and more as none.
bool has_bounds_meant_as_none(const Problem& problem) {
  if (problem.contact() != nullptr || !problem.lcp().is_mixed()) return false;
  const auto is_meant = [](double bound) { return std::isfinite(bound) && std::abs(bound) >= 1e20; };
  const LcpBounds& bounds = problem.lcp().bounds;
  return std::any_of(bounds.lower.begin(), bounds.lower.end(), is_meant) ||
         std::any_of(bounds.upper.begin(), bounds.upper.end(), is_meant);
}

/// A problem that is valid without rounding has to be read from its own file.
class ReaderSubject final : public Subject {
 public:
  Outcome meet(Target& target, double, std::string& detail) override {
    try {
      const Problem read = parse_problem_json(problem_json(target.problem), "the file");
      const bool may_differ = has_bounds_meant_as_none(target.problem);
      if (may_differ || problem_hash(read) == problem_hash(target.problem)) return Outcome::kSolved;
      detail = "another problem is read";
    } catch (const InputError& error) {
      detail = error.what();
      const ContactProblem* contact = target.problem.contact();
      // That G is definite is decided in double there.
      if (contact != nullptr && !std::holds_alternative<FactoredInertia>(contact->inertia)) {
        const auto* given = std::get_if<InverseInertia>(&contact->inertia);
        if (given == nullptr || !positive_semidefinite(exact(given->Ginv))) return Outcome::kRefused;
      }
    }
    return Outcome::kFalseRefusal;
  }
};

Integers integers(const ExactVector& vector) {
  Integers result;
  for (const std::string& text : vector.numerators) result.emplace_back(text);
  return result;
}

class CertifySubject final : public Subject {
 public:
  Outcome meet(Target& target, double time_limit_s, std::string& detail) override {
    Certifier certifier({.time_limit_s = time_limit_s});
    const Certificate certificate = certifier.certify(target.problem);
    detail = std::string(lcpbench::to_string(certificate.kind)) + " by " + lcpbench::to_string(certificate.proof);
    const bool solvable = target.truth.truth == Truth::kSolvable;
    const bool unsolvable = target.truth.truth == Truth::kUnsolvable;
    switch (certificate.kind) {
      case CertificateKind::kOpen: return solvable ? Outcome::kMissed : Outcome::kOpen;
      case CertificateKind::kUnsolvable: return solvable ? Outcome::kFalseCertificate : Outcome::kUnsolvable;
      case CertificateKind::kSolution: break;
    }
    if (unsolvable) return Outcome::kFalseCertificate;
    if (certificate.z.size() > 0) {
      Answer rounded;
      rounded.claim = Claim::kSolved;
      rounded.z = certificate.z;
      if (certificate.velocity.size() > 0) rounded.velocity = certificate.velocity;
      const Outcome outcome = classify(target, rounded, Friction::kPyramid, detail);
      // An exact solution may have no neighbour in doubles that solves the problem.
      if (outcome == Outcome::kOtherVerdict) return outcome;
    }
    if (certificate.proof != ProofKind::kExactBasis) return Outcome::kSolved;
    const Integer denominator(certificate.exact_z.denominator.empty() ? "1" : certificate.exact_z.denominator);
    const bool holds = target.judge.is_exact_solution(integers(certificate.exact_z), denominator);
    return holds ? Outcome::kSolved : Outcome::kFalseCertificate;
  }
};

}  // namespace

const char* to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::kSolved: return "solved";
    case Outcome::kNearlySolved: return "nearly_solved";
    case Outcome::kUnsolvable: return "unsolvable";
    case Outcome::kNearlyUnsolvable: return "nearly_unsolvable";
    case Outcome::kUnsolvableNoProof: return "unsolvable_no_proof";
    case Outcome::kMissed: return "missed";
    case Outcome::kOpen: return "open";
    case Outcome::kRefused: return "refused";
    case Outcome::kUnresolved: return "unresolved";
    case Outcome::kFalseSolved: return "false_solved";
    case Outcome::kFalseVelocity: return "false_velocity";
    case Outcome::kFalseUnsolvable: return "false_unsolvable";
    case Outcome::kFalseProven: return "false_proven";
    case Outcome::kFalseCertificate: return "false_certificate";
    case Outcome::kFalseRefusal: return "false_refusal";
    case Outcome::kOtherVerdict: return "other_verdict";
    case Outcome::kDiffersAgain: return "differs_again";
    case Outcome::kCrashed: return "crashed";
  }
  return "";
}

const char* to_string(Approach approach) {
  switch (approach) {
    case Approach::kLoad: return "load";
    case Approach::kUpdate: return "update";
    case Approach::kStart: return "start";
  }
  return "";
}

namespace {

/// The name of a native solver with cone=true if it has that setting, and its tolerances, if asked for, at their
/// largest values. "": it has none of these settings. `error` is no tolerance: it asks for a claim by another limit.
std::string with_settings(const SolverDefinition& solver, bool loose) {
  Spec spec{solver.name, {}};
  bool any = false;
  for (const SettingInfo& setting : solver.settings()) {
    const bool tolerance = setting.name == "accept_residual" || setting.name == "tolerance";
    if (setting.name == "cone") spec.options.emplace_back("cone", "true");
    any = any || (!loose && setting.name == "cone");
    if (!loose || !tolerance) continue;
    const std::string end = setting.range.substr(setting.range.find(", ") + 2);
    spec.options.emplace_back(setting.name, end.starts_with("inf") ? "1e300" : end.substr(0, end.size() - 1));
    any = true;
  }
  return any ? spec.text() : "";
}

/// The names of a native solver in each arithmetic but that of its default.
std::vector<std::string> in_other_precisions(const SolverDefinition& solver) {
  std::vector<std::string> names;
  for (const SettingInfo& setting : solver.settings()) {
    if (setting.name != "precision") continue;
    std::istringstream choices(setting.range);
    for (std::string choice; std::getline(choices, choice, '|');) {
      if (choice != setting.default_value) names.push_back(Spec{solver.name, {{setting.name, choice}}}.text());
    }
  }
  return names;
}

}  // namespace

std::vector<std::string> subject_names() {
  std::vector<std::string> names;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (!solver.native()) continue;
    names.push_back(solver.definition.name);
    if (std::string round = with_settings(solver.definition, false); !round.empty()) names.push_back(round);
  }
  names.emplace_back("cone_ipm{cone=true,slip=none}");  // the convex model
  names.emplace_back(kCertify);
  names.emplace_back(kReader);
  return names;
}

std::vector<std::string> sampled_subject_names() {
  std::vector<std::string> names;
  for (const NativeSolver& solver : native_solvers()) names.push_back(std::string(kEmbedded) + solver.name);
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (!solver.native()) continue;
    if (std::string loose = with_settings(solver.definition, true); !loose.empty()) names.push_back(loose);
    for (std::string& name : in_other_precisions(solver.definition)) names.push_back(std::move(name));
  }
  for (std::string& name : forger_names()) names.push_back(std::move(name));
  return names;
}

std::unique_ptr<Subject> make_subject(const std::string& name) {
  if (auto forger = make_forger(name)) return forger;
  if (name == kCertify) return std::make_unique<CertifySubject>();
  if (name == kReader) return std::make_unique<ReaderSubject>();
  if (name.starts_with(kEmbedded)) {
    return std::make_unique<EmbeddedSubject>(std::string_view(name).substr(kEmbedded.size()));
  }
  return std::make_unique<SolverSubject>(name);
}

}  // namespace lcpbench::attack
