#include <algorithm>
#include <cmath>

#include "study/evaluation/evaluation.h"

namespace lcpbench {

const char* to_string(Verdict verdict) {
  constexpr const char* kNames[] = {"solved", "wrong", "unsolvable", "refused", "missed", "open"};
  return kNames[static_cast<std::size_t>(verdict)];
}

const char* to_string(Truth truth) {
  constexpr const char* kNames[] = {"unknown", "solvable", "unsolvable", "nearly", "unknown"};
  return kNames[static_cast<std::size_t>(truth)];
}

void Findings::add(const Judgement& judgement) {
  if (judgement.proof_holds) add_proof(Evidence::kValidProof, judgement.errors.proof_margin);
  if (judgement.errors.solved) add(Evidence::kSolvedAnswer);
}

void Findings::add_proof(Evidence evidence, double margin) {
  if (!std::isnan(margin)) evidence = margin > kSolvedBackwardError ? Evidence::kClearProof : Evidence::kCloseProof;
  add(evidence);
}

Truth Findings::truth() const {
  for (const TruthRule& rule : kTruthRules) {
    if (has(rule.evidence) && has(rule.also.value_or(rule.evidence))) return rule.truth;
  }
  return Truth::kUnknown;
}

Verdict verdict(Claim claim, const Errors& errors, Truth truth) {
  const auto fits = [&](const VerdictRule& rule) {
    return (errors.solved || !rule.passes) && (errors.unresolved || !rule.unresolved) &&
           claim == rule.claim.value_or(claim) && truth == rule.truth.value_or(truth) && truth != rule.truth_is_not;
  };
  return std::find_if(kVerdictRules.begin(), kVerdictRules.end(), fits)->verdict;  // the last line fits all
}

}  // namespace lcpbench
