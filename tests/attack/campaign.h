#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tests/attack/problems.h"
#include "tests/attack/subjects.h"

namespace lcpbench::attack {

struct CampaignOptions {
  Family family = Family::kLcp;
  std::uint64_t seed = 1;
  std::uint64_t problems = 1000;
  std::uint64_t first = 0;  ///< index of the first problem
  int jobs = 1;
  std::vector<std::string> subjects;
  std::size_t sampled_from = std::numeric_limits<std::size_t>::max();  ///< these subjects meet one problem in kSampled
  double time_limit_s = 1;    ///< asked of the solvers
  double hard_limit_s = 20;   ///< after which a subject counts as hung and its process is ended
  std::filesystem::path out;  ///< where problems of contradictions are written; "": nowhere
  int files_per_class = 12;   ///< at most, for each subject and outcome
  std::function<std::unique_ptr<Subject>(const std::string&)> make = make_subject;
};

/// Counts of a campaign, by kind, subject and outcome.
struct Tally {
  std::vector<std::string> kinds;
  std::vector<std::string> subjects;
  std::vector<std::uint64_t> counts;      ///< (kind, subject, outcome)
  std::vector<std::uint64_t> truths;      ///< (kind, truth), see kTruthNames
  std::vector<double> slowest_s;          ///< by subject
  std::vector<std::uint64_t> slowest_at;  ///< by subject: the problem's index

  std::uint64_t count(std::size_t kind, std::size_t subject, Outcome outcome) const;
  std::uint64_t count(std::size_t subject, Outcome outcome) const;
  std::uint64_t contradictions() const;
  /// Problems by truth, over all kinds.
  std::uint64_t truth(std::size_t truth) const;
};

/// Of the unsolvable ones: shown by doubles (bare LCPs), and nearly solvable (contacts), where some answer passes.
/// Unresolved: the evaluation could not resolve the inertia.
inline constexpr std::size_t kTruths = 6;
inline constexpr const char* kTruthNames[kTruths] = {"solvable", "unsolvable", "shown_by_doubles",
                                                     "unknown",  "nearly",     "unresolved"};

/// Runs every subject on every problem. Each job is a process of its own: one that dies or hangs is counted, its
/// problem kept, and the run goes on behind it.
Tally run_campaign(const CampaignOptions& options);

}  // namespace lcpbench::attack
