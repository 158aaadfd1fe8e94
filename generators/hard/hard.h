#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/settings.h"
#include "generators/column_major.h"
#include "generators/paper/paper.h"

// Problems that are hard for a reason, each by a formula with its dials: no random numbers, no trials, the same bits
// everywhere. Where the formula gives the answer too, the answer comes with it.

namespace lcpbench {

enum class HardKnown { kSolvable, kUnsolvable };

/// Whether the compared quantity is unique: z of a bare LCP, the post-impact velocity of a contact problem.
enum class HardUnique { kYes, kNo, kUnknown };

/// The known answer of a problem, from its formula, for the doubles as they are. Code that judges answers must not read
/// it, because it serves to check that code.
struct HardTruth {
  HardKnown known = HardKnown::kSolvable;
  HardUnique unique = HardUnique::kUnknown;
  std::string reason;            ///< why, in a few words
  std::vector<double> z;         ///< a solution; empty where no formula gives one or it is no double
  bool exact = true;             ///< z solves the problem without any rounding; else each entry is within a few ulps
  std::vector<double> velocity;  ///< v+ of that solution; contact problems with an exact z only, may be empty
  std::vector<double> farkas;    ///< a proof that there is no solution, exact; see study/evaluation/farkas.h
};

/// One problem in plain arrays.
struct HardCase {
  std::optional<PaperSample> contact;  ///< v, N, D, edges, mu and inertia; none: a bare LCP
  ColumnMajor<double> M;               ///< of a bare LCP
  std::vector<double> q;               ///< of a bare LCP
  HardTruth truth;

  /// Order of M.
  std::size_t size() const;
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
  Options (*changed)(std::string_view owner, const Options&) = nullptr;  ///< off their defaults, in declaration order

  /// The second part of the name.
  std::string family() const;
};

/// Every hard set, by family.
const std::vector<HardSet>& hard_sets();

/// The case that a set's text ("hard/contact/stack{k=4}") stands for; nullopt for sets that are not hard ones.
/// @throws InputError on bad options, and on text that is no spec.
std::optional<HardCase> hard_case(const std::string& text);

/// "solvable, one solution: M is positive definite", from the case's truth.
std::string truth_text(const HardCase& problem);

}  // namespace lcpbench
