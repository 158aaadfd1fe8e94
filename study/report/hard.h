#pragma once

#include <cstddef>
#include <string>

#include "study/summary/summary.h"

// What a store says of the hard cases, sets hard/<family>/<case>{dials}: one problem each.

namespace lcpbench::report {

/// What became of one case with one solver, from harmless to worst.
enum class HardOutcome {
  kNotRun,
  kRefused,            ///< outside what the solver takes
  kSolved,             ///< said solved, and is
  kRightlyUnsolvable,  ///< said to have no solution, and proven to have none
  kGaveUpUnsolvable,   ///< gave up on what has no solution
  kSolvedUnclaimed,    ///< the answer is right, the solver did not say so
  kUndecided,          ///< gave up, or said to have no solution, and nobody knows
  kMissed,             ///< gave up on what has a solution
  kWronglyUnsolvable,  ///< said to have no solution, has one
  kFalseClaim,         ///< said solved, and is not: wrong and silent
};

/// "solved", "missed", "false_claim", ...: the words of the tables. "" where it was not run.
const char* to_string(HardOutcome outcome);

/// The worse of what the cell's trials came to; a hard set has one.
HardOutcome hard_outcome(const Cell& cell);

/// What the formula of a hard case says of it: "no solution, by Farkas' lemma". "" for another set, and for a case that
/// this program does not know.
std::string hard_truth(const std::string& set);

/// The hard cases as text, in lines of `width` characters: for at most so many solvers, those that are right on the most
/// cases first, how many cases came to each outcome. "" without any.
std::string hard_text(const Summary& summary, int width, std::size_t solvers = static_cast<std::size_t>(-1));

/// Who said solved of which case and was wrong, and what the headings of hard_text() mean. "" without hard cases.
std::string hard_words(const Summary& summary, int width);

}  // namespace lcpbench::report
