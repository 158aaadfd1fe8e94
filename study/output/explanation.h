#pragma once

#include <string>

#include "core/problem.h"
#include "study/evaluation/evaluation.h"
#include "study/output/json_output.h"

namespace lcpbench {

/// {"name", "kind", "n", "ngc", "nc", "edges"}, as every document about single problems has it: the last three null for
/// a bare LCP. A problem without a name is called `unnamed`.
Json problem_summary_json(const Problem& problem, const std::string& unnamed);

/// Why an answer to a problem of n unknowns has no errors, in one clause; "" when its z is finite and has n entries. An
/// answer without z is worth a word only where the solver claims to have solved, or says nothing else.
std::string why_without_errors(const Answer& answer, Index n);

/// What Truth::kNearly says of a problem, as a clause. @param least_violation_m_per_s  NaN: not known
std::string nearly_words(double least_violation_m_per_s);
/// Stands beside answers of an engine that solves other contacts on purpose; "" for any other engine of a scenes file.
std::string soft_engine_words(std::string engine);

/// One answer, its verdict, and what the verdict rests on.
struct JudgedAnswer {
  Claim claim = Claim::kNumericalFailure;
  Verdict verdict = Verdict::kOpen;
  Errors errors;
  std::string detail;         ///< the solver's own words
  std::string unusable;       ///< why its z is none; "" when there is one
  std::string truth_because;  ///< how the problem's truth is known: "proof by enumeration"; "" where it is not
  Truth truth = Truth::kUnknown;
};

/// Why the verdict is not solved, as a sentence without its subject: "said solved, but contact 2 (row 1) still
/// approaches at 1 m/s: residual 1 relative to its island's scale of 1 m/s; the limit is 1e-4." "" for solved.
///
/// Contacts and their friction directions are counted from 1, rows of the LCP from 0.
std::string why_not_solved(const Problem& problem, const JudgedAnswer& answer);

}  // namespace lcpbench
