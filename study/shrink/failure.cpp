#include "study/shrink/failure.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "core/quad.h"
#include "study/output/explanation.h"
#include "study/run/open_solver.h"
#include "study/run/study.h"
#include "study/stability/physical_answer.h"

namespace lcpbench {
namespace {

constexpr const char* kCertificate = "certificate";
/// Where both answers of a difference are this accurate at first, they must stay so: else a search would end at two
/// inaccurate answers to one motion.
constexpr double kAccurate = 1e-8;

/// The velocity after the impact that z implies; of a bare LCP w, which is made of velocities where it comes from
/// contacts.
Vector motion(const Problem& problem, const Answer& answer) {
  if (problem.contact() != nullptr) {
    Answer impulses;
    impulses.z = answer.z;
    return PhysicalAnswers(problem).of(impulses);
  }
  const Lcp& lcp = problem.lcp();
  Vector w(lcp.size());
  for (Index i = 0; i < lcp.size(); ++i) {
    Quad sum = lcp.q(i);
    for (Index j = 0; j < lcp.size(); ++j) sum += Quad{lcp.M(i, j)} * Quad{answer.z(j)};
    w(i) = to_double(sum);
  }
  return w;
}

/// Which of two limits strikes first may depend on the machine's load.
bool same_claim(Claim a, Claim b) {
  const auto limit = [](Claim claim) { return claim == Claim::kTimeLimit || claim == Claim::kIterationLimit; };
  return a == b || (limit(a) && limit(b));
}

bool is_solvable_truth(Truth truth) { return truth == Truth::kSolvable || truth == Truth::kAnswered; }

}  // namespace

const char* to_string(FailureKind kind) {
  constexpr const char* kNames[] = {"wrong", "missed", "differs"};
  return kNames[static_cast<std::size_t>(kind)];
}

FailureTest::FailureTest(FailureOptions options)
    : options_(std::move(options)), certifier_({.time_limit_s = std::min(options_.time_limit_s, 2.0)}) {
  options_.solver = canonical_solver_spec(options_.solver);
  opened_[options_.solver.text()] = open_solver(options_.solver);
  if (!options_.against || *options_.against == kCertificate) return;
  const Spec against = canonical_solver_spec(parse_spec(*options_.against));
  if (against.text() == options_.solver.text()) {
    throw InputError(fmt::format("--against '{}': the same as --solver", *options_.against));
  }
  options_.against = against.text();
  opened_[against.text()] = open_solver(against);
}

FailureTest::Seen FailureTest::see(const Problem& problem, const Spec& spec, Judge& judge) {
  std::unique_ptr<TimedSolver>& solver = opened_[spec.text()];
  if (solver == nullptr) solver = open_solver(spec);
  TimedAnswer timed;
  solver->run(problem, {.time_limit_s = options_.time_limit_s}, timed);
  Seen seen{.answer = std::move(timed.answer)};
  seen.model = friction_model(solver_row(spec).friction, problem);
  seen.errors = judge.judgement(judge.judge(seen.answer, seen.model)).errors;
  return seen;
}

void FailureTest::require_taken(const Spec& spec, const Seen& seen) const {
  if (seen.answer.claim != Claim::kUnsupported) return;
  throw InputError(fmt::format("solver '{}' does not take the problem: {}", spec.text(), seen.answer.detail));
}

/// By what the judge knows; else by the answer of `auto`; else by a certificate.
FailureTest::Settled FailureTest::truth(const Problem& problem, Judge& judge) {
  const bool is_theory = judge.findings().has(Evidence::kTheory);
  const char* const because = is_theory ? "by theory" : "by exact arithmetic or a verified answer";
  if (judge.findings().truth() != Truth::kUnknown) return {judge.findings().truth(), because};
  if (!settled_) settled_ = settle(problem, judge);
  return *settled_;
}

FailureTest::Settled FailureTest::settle(const Problem& problem, Judge& judge) {
  if (options_.solver.name != "auto") see(problem, {"auto", {}}, judge);
  if (judge.findings().truth() != Truth::kUnknown) return {judge.findings().truth(), "auto solves it"};
  return certified(problem);
}

FailureTest::Settled FailureTest::certified(const Problem& problem) {
  switch (certifier_.certify(problem).kind) {
    case CertificateKind::kSolution: return {Truth::kSolvable, "by exact arithmetic"};
    case CertificateKind::kUnsolvable: return {Truth::kUnsolvable, "by exact arithmetic"};
    case CertificateKind::kOpen: break;
  }
  return {};
}

bool FailureTest::is_solvable(const Problem& problem, const Seen& seen, Judge& judge) {
  return seen.model == FrictionModel::kPyramid && is_solvable_truth(truth(problem, judge).truth);
}

bool FailureTest::is_wrong(const Problem& problem, const Seen& seen, Judge& judge) {
  const Claim claim = seen.answer.claim;
  if (claim == Claim::kSolved) {
    const Verdict judged = verdict(claim, seen.errors, judge.findings().truth());
    words_ = fmt::format("{} {}", options_.solver.text(),
                         why_not_solved(problem, {claim, judged, seen.errors, seen.answer.detail,
                                                  why_without_errors(seen.answer, problem.size()), "",
                                                  judge.findings().truth(), seen.model}));
    return judged == Verdict::kWrong;
  }
  if (claim != Claim::kUnsolvable || seen.model != FrictionModel::kPyramid) return false;
  Settled known = truth(problem, judge);
  if (known.truth == Truth::kAnswered) known = certified(problem);  // no proof, only an answer within the tolerance
  if (known.truth != Truth::kSolvable) return false;
  words_ = fmt::format("{} says that there is no solution, and there is one: {}", options_.solver.text(),
                       known.because);
  return true;
}

bool FailureTest::is_missed(const Problem& problem, const Seen& seen, Judge& judge) {
  const Claim claim = seen.answer.claim;
  if (claim == Claim::kCrashed) {
    words_ = fmt::format("{} crashes: {}", options_.solver.text(), seen.answer.detail);
    return true;
  }
  if (seen.errors.solved || claim == Claim::kUnsupported || seen.model != FrictionModel::kPyramid) return false;
  const Settled known = truth(problem, judge);
  if (!is_solvable_truth(known.truth)) return false;
  words_ = fmt::format("{} ends with {} and does not solve the problem, which {} solution: {}",
                       options_.solver.text(), to_string(claim),
                       known.truth == Truth::kSolvable ? "has a" : "nearly has a", known.because);
  return true;
}

bool FailureTest::is_different(const Problem& problem, const Seen& seen, Judge& judge, const std::string& other) {
  if (!seen.errors.solved) return false;
  Seen second;
  if (other == kCertificate) {
    const Certificate certificate = certifier_.certify(problem);
    if (certificate.kind != CertificateKind::kSolution || certificate.z.size() != problem.size()) return false;
    second.answer.z = certificate.z;
    second.errors.solved = true;
    second.errors.velocity_residual_relative = second.errors.backward_row_norm = 0;
  } else {
    second = see(problem, parse_spec(other), judge);
  }
  seen_accuracy_ = std::max(seen.errors.measure(), second.errors.measure());
  if (!second.errors.solved || second.model != seen.model || !(seen_accuracy_ <= accuracy_)) return false;
  const double difference = (motion(problem, seen.answer) - motion(problem, second.answer)).lpNorm<Eigen::Infinity>();
  words_ = fmt::format("{} and {} both solve it, and their {} differ by {:.3g}{}", options_.solver.text(),
                       other == kCertificate ? "the certificate" : other,
                       problem.contact() != nullptr ? "velocities after the impact" : "complements w", difference,
                       problem.contact() != nullptr ? " (m/s, rad/s)" : "");
  return difference >= options_.speed;
}

bool FailureTest::finds_other(const Problem& problem, const Seen& seen, Judge& judge) {
  if (options_.against && *options_.against != kCertificate) {
    const Spec against = parse_spec(*options_.against);
    require_taken(against, see(problem, against, judge));
  }
  if (!seen.errors.solved) return false;
  std::vector<std::string> others{"auto", kCertificate};
  for (const RegisteredSolver& solver : registered_solvers()) {
    const bool takes =
        solver.native() && runs_unasked(solver) && why_not(solver.definition.capabilities, problem).empty();
    if (takes && solver.definition.name != "auto") others.push_back(solver.definition.name);
  }
  if (options_.against) others = {*options_.against};
  for (const std::string& other : others) {
    if (other == options_.solver.text() || !is_different(problem, seen, judge, other)) continue;
    other_ = other;
    if (seen_accuracy_ <= kAccurate) accuracy_ = kAccurate;
    return true;
  }
  return false;
}

bool FailureTest::begin(const Problem& problem) {
  Judge judge(problem, bounded_certifier_);
  const Seen seen = see(problem, options_.solver, judge);
  require_taken(options_.solver, seen);
  const auto asked = [&](FailureKind kind) { return options_.kind.value_or(kind) == kind; };
  bool failed = false;
  for (const FailureKind kind : {FailureKind::kWrong, FailureKind::kMissed, FailureKind::kDiffers}) {
    if (failed || !asked(kind)) continue;
    kind_ = kind;
    failed = kind == FailureKind::kWrong    ? is_wrong(problem, seen, judge)
             : kind == FailureKind::kMissed ? is_missed(problem, seen, judge)
                                            : finds_other(problem, seen, judge);
  }
  claim_ = seen.answer.claim;
  solvable_ = failed && is_solvable(problem, seen, judge);
  if (!failed) {
    words_ = fmt::format("{} ends with {}, and the answer {}", options_.solver.text(), to_string(*claim_),
                         seen.errors.solved ? "solves the problem" : "does not solve the problem");
    if (asked(FailureKind::kMissed) && !seen.errors.solved && seen.model == FrictionModel::kPyramid) {
      const Truth known = truth(problem, judge).truth;
      if (known == Truth::kUnsolvable) words_ += "; it has no solution";
      if (known == Truth::kNearly) words_ += "; it has no exact solution";
      if (known == Truth::kUnknown) words_ += "; whether it has a solution is not known";
    }
  }
  return failed;
}

bool FailureTest::fails(const Problem& problem) {
  settled_.reset();
  Judge judge(problem, bounded_certifier_);
  const Seen seen = see(problem, options_.solver, judge);
  if (!same_claim(seen.answer.claim, *claim_)) return false;
  const bool failed = kind_ == FailureKind::kWrong    ? is_wrong(problem, seen, judge)
                      : kind_ == FailureKind::kMissed ? is_missed(problem, seen, judge)
                                                      : is_different(problem, seen, judge, other_);
  return failed && (!solvable_ || is_solvable(problem, seen, judge));
}

}  // namespace lcpbench
