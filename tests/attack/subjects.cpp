#include "tests/attack/subjects.h"

#include <cstdio>
#include <exception>

#include "core/registry.h"

namespace lcpbench::attack {
namespace {

constexpr const char* kCertify = "certify";

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

class SolverSubject final : public Subject {
 public:
  explicit SolverSubject(std::string name) : name_(std::move(name)), solver_(make_solver(parse_spec(name_))) {}

  Outcome meet(Target& target, double time_limit_s, std::string& detail) override {
    solve(*solver_, target, time_limit_s, answer_);
    const Outcome outcome = classify(target, answer_, detail);
    if (outcome != Outcome::kBeyondDoubles && !contradiction(outcome)) return outcome;
    const auto fresh = make_solver(parse_spec(name_));
    Answer again;
    solve(*fresh, target, time_limit_s, again);
    if (again.claim == answer_.claim) return outcome;
    detail += std::string("; a fresh solver claims ") + lcpbench::to_string(again.claim);
    return Outcome::kDiffersAgain;
  }

 private:
  static Outcome classify(Target& target, const Answer& answer, std::string& detail);

  std::string name_;
  std::unique_ptr<Solver> solver_;
  Answer answer_;
};

Outcome SolverSubject::classify(Target& target, const Answer& answer, std::string& detail) {
  detail = std::string(to_string(target.approach)) + ": " + lcpbench::to_string(answer.claim) +
           (answer.detail.empty() ? "" : " (" + answer.detail + ")");
  if (answer.claim == Claim::kUnsupported) return Outcome::kRefused;
  const bool solves = target.judge.solves(answer.z);
  detail += ", measure " + number(target.judge.measure());
  const bool solvable = target.truth.truth == Truth::kSolvable;
  const bool unsolvable = target.truth.truth == Truth::kUnsolvable;
  const bool witness = answer.farkas.size() > 0 && disproves(target.problem, answer.farkas);
  if (answer.claim == Claim::kSolved && !solves) return Outcome::kFalseSolved;
  if (answer.claim == Claim::kSolved && unsolvable) {
    const bool excused = target.problem.contact() == nullptr && !target.truth.shown_by_doubles;
    return excused ? Outcome::kBeyondDoubles : Outcome::kDisproved;
  }
  if (answer.claim == Claim::kUnsolvable && solvable) return Outcome::kFalseUnsolvable;
  const bool shows_vector = answer.claim != Claim::kUnsolvable || answer.farkas.size() > 0;
  if (answer.detail.find("proven") != std::string::npos && shows_vector && !witness) return Outcome::kFalseProven;
  const Errors errors = target.evaluator.errors(answer);
  if (errors.solved != solves) {
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
  if (answer.claim == Claim::kSolved) return Outcome::kSolved;
  if (answer.claim == Claim::kUnsolvable) return witness ? Outcome::kUnsolvable : Outcome::kUnsolvableNoProof;
  return solvable ? Outcome::kMissed : Outcome::kOpen;
}

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
    if (certificate.proof != ProofKind::kExactBasis && certificate.proof != ProofKind::kEnumeration) {
      return Outcome::kSolved;
    }
    const Integer denominator(certificate.exact_z.denominator.empty() ? "1" : certificate.exact_z.denominator);
    const bool holds = target.judge.is_exact_solution(integers(certificate.exact_z), denominator);
    return holds ? Outcome::kSolved : Outcome::kFalseCertificate;
  }
};

}  // namespace

const char* to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::kSolved: return "solved";
    case Outcome::kUnsolvable: return "unsolvable";
    case Outcome::kUnsolvableNoProof: return "unsolvable_no_proof";
    case Outcome::kMissed: return "missed";
    case Outcome::kOpen: return "open";
    case Outcome::kRefused: return "refused";
    case Outcome::kBeyondDoubles: return "beyond_doubles";
    case Outcome::kFalseSolved: return "false_solved";
    case Outcome::kDisproved: return "disproved";
    case Outcome::kFalseUnsolvable: return "false_unsolvable";
    case Outcome::kFalseProven: return "false_proven";
    case Outcome::kFalseCertificate: return "false_certificate";
    case Outcome::kOtherVerdict: return "other_verdict";
    case Outcome::kDiffersAgain: return "differs_again";
    case Outcome::kCrashed: return "crashed";
    case Outcome::kHung: return "hung";
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

std::vector<std::string> subject_names() {
  std::vector<std::string> names;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (solver.native()) names.push_back(solver.definition.name);
  }
  names.emplace_back(kCertify);
  return names;
}

std::unique_ptr<Subject> make_subject(const std::string& name) {
  if (name == kCertify) return std::make_unique<CertifySubject>();
  return std::make_unique<SolverSubject>(name);
}

}  // namespace lcpbench::attack
