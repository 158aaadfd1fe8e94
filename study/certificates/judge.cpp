#include "study/certificates/judge.h"

#include <exception>
#include <utility>

#include "core/same_bits.h"
#include "core/timed_solve.h"
#include "study/certificates/certify_store.h"

namespace lcpbench {

std::optional<Certificate> BoundedCertifier::certify(const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  const Index rows = contact != nullptr ? contact->nc() + contact->rows.size() : problem.size();
  if (rows > kMostRows || (contact != nullptr && contact->ngc() > kMostCoordinates)) return std::nullopt;
  if (certifier_ == nullptr) certifier_ = std::make_unique<Certifier>(CertifyOptions{.most_work = kMostWork});
  return certify(problem, *certifier_);
}

std::optional<Certificate> BoundedCertifier::certify_longer(const Problem& problem) {
  Certifier certifier(CertifyOptions{.most_work = 10 * kMostWork});
  return certify(problem, certifier);
}

std::optional<Certificate> BoundedCertifier::certify(const Problem& problem, Certifier& certifier) {
  try {
    Certificate certificate = certifier.certify(problem);
    if (certificate.kind != CertificateKind::kOpen) return certificate;
  } catch (const std::exception&) {  // data that are not finite, memory: nothing is proven
  }
  return std::nullopt;
}

Judge::Judge(const Problem& problem, BoundedCertifier& certifier, std::optional<double> solved_at)
    : problem_(problem), certifier_(certifier), solved_at_(solved_at), evaluator_(problem) {
  if (evaluator_.truth() == Truth::kSolvable) findings_.add(Evidence::kTheory);
}

std::size_t Judge::judge(const Answer& answer, FrictionModel model) {
  const std::size_t number = find_or_judge(answer, model);
  const bool denies =
      (answer.claim == Claim::kUnsolvable || answer.farkas.size() > 0) && !judgement(number).proof_holds;
  if (denies && !settled_ && !findings_.has(Evidence::kTheory)) settle(certifier_.certify(problem_));
  return number;
}

void Judge::settle_few_unknowns() {
  const bool is_open = problem_.size() <= Certifier::kFewUnknowns && findings_.truth() == Truth::kUnknown;
  if (is_open) settle(certifier_.certify_longer(problem_));
}

Judgement Judge::judge_alone(const Answer& answer, FrictionModel model) {
  const double start = thread_cpu_clock_s();
  Judgement judgement = evaluator_.judge(answer);
  measure_friction(model, problem_, answer, judgement.errors);
  if (solved_at_) judgement.errors.decide(*solved_at_);
  judgement.verify_s = thread_cpu_clock_s() - start;
  return judgement;
}

std::size_t Judge::find_or_judge(const Answer& answer, FrictionModel model) {
  const bool is_refusal = answer.claim == Claim::kUnsupported;
  for (std::size_t number = 0; number < distinct_.size(); ++number) {
    const Distinct& known = distinct_[number];
    if (known.model == model && known.is_refusal == is_refusal && same_bits(known.z, answer.z) &&
        same_bits(known.velocity, answer.velocity) && same_bits(known.farkas, answer.farkas)) {
      return number;
    }
  }
  distinct_.push_back({answer.z, answer.velocity, answer.farkas, model, is_refusal, judge_alone(answer, model)});
  if (model == FrictionModel::kPyramid) findings_.add(distinct_.back().judgement);
  return distinct_.size() - 1;
}

void Judge::settle(std::optional<Certificate> certificate) {
  settled_ = true;
  certificate_ = std::move(certificate);
  if (!certificate_) return;
  if (certificate_->kind == CertificateKind::kUnsolvable) {
    findings_.add_proof(Evidence::kCertifiedUnsolvable, proof_margin(problem_, *certificate_));
  } else {
    findings_.add(Evidence::kCertifiedSolution);
  }
}

}  // namespace lcpbench
