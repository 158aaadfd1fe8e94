#include <algorithm>

#include "study/evaluation/evaluation.h"

namespace lcpbench {

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kSolved: return "solved";
    case Verdict::kWrong: return "wrong";
    case Verdict::kUnsolvable: return "unsolvable";
    case Verdict::kRefused: return "refused";
    case Verdict::kMissed: return "missed";
    case Verdict::kOpen: return "open";
  }
  return "unknown";
}

const char* to_string(Truth truth) {
  switch (truth) {
    case Truth::kUnknown:
    case Truth::kAnswered: return "unknown";
    case Truth::kSolvable: return "solvable";
    case Truth::kUnsolvable: return "unsolvable";
    case Truth::kNearly: return "nearly";
  }
  return "unknown";
}

void Findings::add(const Judgement& judgement) {
  if (judgement.proof_holds) add(Evidence::kValidProof);
  if (judgement.errors.solved) add(Evidence::kSolvedAnswer);
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
