#include <string>

#include "core/error.h"
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
    case Truth::kUnknown: return "unknown";
    case Truth::kSolvable: return "solvable";
    case Truth::kUnsolvable: return "unsolvable";
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
  if (errors.solved && truth != Truth::kUnsolvable) return Verdict::kSolved;
  if (claim == Claim::kSolved) return Verdict::kWrong;
  if (truth == Truth::kUnsolvable) return Verdict::kUnsolvable;
  if (claim == Claim::kUnsupported) return Verdict::kRefused;
  return truth == Truth::kSolvable ? Verdict::kMissed : Verdict::kOpen;
}

}  // namespace lcpbench
