#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/registry.h"
#include "study/run/plan.h"
#include "study/run/study.h"

namespace lcpbench {

/// The value of an answer in a comparison, by its claim and verdict alone; docs/howto/validate.md has the table.
enum class Standing {
  kRight,   ///< verified as a solution; or said to be unsolvable, which a checked proof confirms
  kWrong,   ///< a false claim
  kSilent,  ///< neither: it gave up, or missed a solution
};

Standing standing(Claim claim, Verdict verdict);

enum class PairOutcome { kAgree, kNativeWrong, kReferenceWrong, kBothWrong, kUndecided };

inline constexpr std::array kAllOutcomes{PairOutcome::kAgree, PairOutcome::kNativeWrong, PairOutcome::kReferenceWrong,
                                         PairOutcome::kBothWrong, PairOutcome::kUndecided};

/// "agree", "native_wrong", "reference_wrong", "both_wrong", "undecided".
const char* to_string(PairOutcome outcome);

/// @param same_velocity  false if both are right and the velocity is unique, but their velocities differ
PairOutcome compare_standings(Standing native, Standing reference, bool same_velocity);

/// How often one of our solvers and one reference came out each way on the problems of one set that neither refused.
struct PairCounts {
  std::string set;
  std::string native;
  std::string reference;
  std::array<std::int64_t, kAllOutcomes.size()> counts{};

  std::int64_t count(PairOutcome outcome) const { return counts[static_cast<std::size_t>(outcome)]; }
  void add(PairOutcome outcome) { ++counts[static_cast<std::size_t>(outcome)]; }
  std::int64_t compared() const;
  /// Ours made a false claim, whatever the reference did.
  bool ours_wrong() const;
};

/// One problem on which two solvers neither agree nor are silent.
struct Disagreement {
  std::size_t set = 0;  ///< of the study
  std::int64_t trial = 0;
  std::string native;
  std::string reference;
  PairOutcome outcome = PairOutcome::kUndecided;
};

struct Validation {
  std::vector<PairCounts> pairs;  ///< in the study's order of sets and solvers; pairs that never met are left out
  std::vector<Disagreement> disagreements;  ///< by set, trial, native, reference

  bool ours_wrong() const;
};

/// Adds up the pairs that are the same, under the names of the first of them; `set` is empty.
std::vector<PairCounts> summed(const std::vector<PairCounts>& pairs,
                               const std::function<bool(const PairCounts&, const PairCounts&)>& same);

/// The pairs over all sets: `set` is empty.
std::vector<PairCounts> over_all_sets(const std::vector<PairCounts>& pairs);

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

/// Compares all answers of a study that the store holds: each of ours with each reference, and with the truth where
/// theory, a certificate or a checked proof tells it. Velocities are compared where they are unique
/// (study/validate/velocity_agreement.h). Memory: the answers to one problem, and the disagreements.
Validation validate(const Study& study, Store& store);

}  // namespace lcpbench
