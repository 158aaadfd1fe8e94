#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/registry.h"
#include "study/output/json_output.h"
#include "study/run/plan.h"
#include "study/run/study.h"

namespace lcpbench {

/// Rows of study/validate/validate.sql: how often one of our solvers (`native`) and a `reference` came out each way on
/// the problems that neither refused: `agree`, `native_wrong`, `reference_wrong`, `both_wrong`, `undecided`.
struct Validation {
  Json pairs;          ///< by set; pairs that never met are left out
  Json over_sets;      ///< over all sets
  Json totals;         ///< each of ours with all of its references together
  Json disagreements;  ///< pairs with a wrong answer or different velocities, by problem; `place` is that of the set

  /// Ours made a false claim, whatever the reference did.
  bool ours_wrong() const;
};

/// The reference that stands for what is known of a problem without any solver.
inline constexpr const char* kTruthReference = "truth";

/// Whether the method is ours: native, or ours over a library's linear algebra.
bool is_ours(const RegisteredSolver& solver);

/// What a validation runs.
/// @param asked  solvers that are compared, each on every problem: ours with the references among them, or with all
///   references that run unasked where there is none; references alone with all of ours. References that need more than
///   10 ms for most problems, and were not asked for, run on every 5th to 50th problem, 20 of each set at least.
/// @param sets  none: every solver meets every other on `trials` small rigid scenes, most on problems of the paper too
Plan validation_plan(const std::vector<Spec>& asked, const std::vector<std::string>& sets, std::int64_t trials);

/// The study of such a plan. @throws as resolve()
Study validation_study(const Plan& plan);

/// Compares all answers of its solvers to its problems that the store holds: each of ours with each reference, and with
/// the truth where theory, a certificate or a checked proof tells it. Velocities are compared where they are unique
/// (study/validate/velocity_agreement.h). Leaves temporary tables behind; once for each connection.
Validation validate(const Study& study, Store& store);

}  // namespace lcpbench
