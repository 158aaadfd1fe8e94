#include <string>

#include "core/error.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kSolved: return "solved";
    case Verdict::kCriterionOnly: return "criterion_only";
    case Verdict::kWrong: return "wrong";
    case Verdict::kUnsolvable: return "unsolvable";
    case Verdict::kMissed: return "missed";
    case Verdict::kOpen: return "open";
  }
  return "unknown";
}

Verdict parse_verdict(std::string_view text) {
  for (const Verdict verdict : kAllVerdicts) {
    if (text == to_string(verdict)) return verdict;
  }
  throw InputError("unknown verdict '" + std::string(text) + "'");
}

Verdict verdict(Claim claim, const Errors& errors, Truth truth) {
  if (truth == Truth::kUnsolvable) return Verdict::kUnsolvable;
  if (errors.solved) return Verdict::kSolved;
  if (errors.criterion) return Verdict::kCriterionOnly;
  if (claim == Claim::kSolved) return Verdict::kWrong;
  return truth == Truth::kSolvable ? Verdict::kMissed : Verdict::kOpen;
}

bool false_claim(Claim claim, Verdict verdict) {
  return claim == Claim::kSolved && (verdict == Verdict::kWrong || verdict == Verdict::kUnsolvable);
}

}  // namespace lcpbench
