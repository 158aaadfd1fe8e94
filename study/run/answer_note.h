#pragma once

#include <string>

#include "core/solver.h"

namespace lcpbench {

/// Why an answer to a problem of n unknowns has no errors, in one clause; "" when its z is finite and has n entries. An
/// answer without z is worth a word only where the solver claims to have solved, or says nothing else.
inline std::string why_without_errors(const Answer& answer, Index n) {
  if (answer.z.size() == 0 && n > 0) {
    return answer.claim == Claim::kSolved || answer.detail.empty() ? "no z returned" : "";
  }
  if (answer.z.size() != n) {
    return "z has " + std::to_string(answer.z.size()) + " entries, expected " + std::to_string(n);
  }
  return answer.z.allFinite() ? "" : "z is not finite";
}

}  // namespace lcpbench
