#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/settings.h"
#include "generators/column_major.h"
#include "generators/paper/paper.h"

// Problems that are hard for a known reason. Each is given by a formula with parameters (dials). There are no random
// numbers and no trials, and the bits are the same everywhere. If the formula also gives the answer, the case has it.

namespace lcpbench {

enum class HardKnown { kSolvable, kUnsolvable };

/// Whether the compared quantity is unique: z of a bare LCP, the post-impact velocity of a contact problem.
enum class HardUnique { kYes, kNo, kUnknown };

/// The known answer of a problem. It follows from the formula, and holds for the doubles of the problem as they are.
/// Code that judges answers must not read it, because tests check that code with it.
struct HardTruth {
  HardKnown known = HardKnown::kSolvable;
  HardUnique unique = HardUnique::kUnknown;
  std::string reason;            ///< why, in a few words
  std::vector<double> z;         ///< a solution; empty if no formula gives one, or doubles cannot hold it
  bool exact = true;             ///< z solves the problem without any rounding; else each entry is within a few ulps
  std::vector<double> velocity{};  ///< v+ of that solution; contact problems with an exact z only, may be empty
  std::vector<double> farkas{};    ///< a proof that there is no solution, exact; see core/answer/farkas.h
};

/// One problem in plain arrays.
struct HardCase {
  std::optional<PaperSample> contact;  ///< v, N, D, edges, mu and inertia; none: a bare LCP
  ColumnMajor<double> M;               ///< of a bare LCP
  std::vector<double> q;               ///< of a bare LCP
  HardTruth truth;
};

/// A formula with its dials.
struct HardSet {
  std::string name;     ///< hard/<family>/<case>
  std::string size;     ///< in words
  std::string summary;  ///< what it is
  std::string hard;     ///< why it is hard
  std::string source;

  std::vector<SettingInfo> (*options)() = nullptr;
  HardCase (*make)(std::string_view owner, const Options&) = nullptr;    ///< throws InputError on bad options
  Options (*changed)(std::string_view owner, const Options&) = nullptr;  ///< those off their defaults, in order
};

/// Every hard set, by family.
const std::vector<HardSet>& hard_sets();

/// The case that a set's text ("hard/contact/stack{k=4}") names; nullopt if no hard set has this name.
/// @throws InputError on bad options, and on text that is no spec.
std::optional<HardCase> hard_case(const std::string& text);

/// "solvable, one solution: M is positive definite", from the case's truth.
std::string truth_text(const HardCase& problem);

}  // namespace lcpbench
