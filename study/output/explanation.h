#pragma once

#include <string>
#include <vector>

#include "core/friction_model.h"
#include "core/problem.h"
#include "study/evaluation/evaluation.h"
#include "study/output/json_output.h"

namespace lcpbench {

/// {"name", "kind", "n", "ngc", "nc", "edges", "rows"}, as every document about single problems has it: the last four
/// null for a bare LCP. A problem without a name is called `unnamed`.
Json problem_summary_json(const Problem& problem, const std::string& unnamed);

/// Why an answer to a problem of n unknowns has no errors, in one clause; "" when its z is finite and has n entries.
/// Also "" for an answer without z whose detail says why, unless it claims to be solved.
std::string why_without_errors(const Answer& answer, Index n);

/// What Truth::kNearly says of a problem: "proven to have no exact solution, but ...".
/// @param least_violation_m_per_s  by which every answer violates some contact; NaN: not known
/// @param has_rows  the problem has bounded rows, which may be violated instead, angles in rad/s
std::string nearly_words(double least_violation_m_per_s, bool has_rows = false);
/// A note on the captured answers of an engine that by design softens contacts, corrects penetration or stops early;
/// "" for any other engine. @param engine  as scenes files and sets name it, in any case: "ODE", "mujoco", "ode-auto"
std::string soft_engine_words(std::string engine);

/// One answer, its verdict, and what the verdict rests on.
struct JudgedAnswer {
  Claim claim = Claim::kNumericalFailure;
  Verdict verdict = Verdict::kOpen;
  Errors errors;
  std::string detail;         ///< the solver's own words
  std::string unusable;       ///< why_without_errors() of the answer
  std::string truth_because;  ///< how the problem's truth is known: "proof by enumeration"; "" where it is not
  Truth truth = Truth::kUnknown;
  FrictionModel model = FrictionModel::kPyramid;  ///< that the errors are measured by
  std::vector<std::string> contact_names;         ///< one for each contact, or none
  const Vector* z = nullptr;                      ///< the answer itself; nullptr: nothing is said of its rounding
};

/// Why the verdict is not "solved", as a sentence without its subject: "said solved, but contact 1 still approaches at
/// 1 m/s: error 1, relative to the 1 m/s that no impulses leave in its island; the limit is 1e-4." "" for solved.
///
/// Contacts, their friction directions and rows of the LCP are counted from 0, as in files and arrays.
std::string why_not_solved(const Problem& problem, const JudgedAnswer& answer);

}  // namespace lcpbench
