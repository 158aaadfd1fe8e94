#include "study/report/hard.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "generators/hard/hard.h"
#include "study/output/text_table.h"
#include "study/report/sets.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

HardOutcome outcome_of(Claim claim, Verdict verdict) {
  if (claim == Claim::kUnsupported) return HardOutcome::kRefused;
  const bool claims_none = claim == Claim::kUnsolvable;
  switch (verdict) {
    case Verdict::kSolved: return claim == Claim::kSolved ? HardOutcome::kSolved : HardOutcome::kSolvedUnclaimed;
    case Verdict::kUnsolvable: return claims_none ? HardOutcome::kRightlyUnsolvable : HardOutcome::kGaveUpUnsolvable;
    case Verdict::kMissed: return claims_none ? HardOutcome::kWronglyUnsolvable : HardOutcome::kMissed;
    case Verdict::kWrong: return HardOutcome::kFalseClaim;
    case Verdict::kRefused: return HardOutcome::kRefused;
    case Verdict::kOpen: break;
  }
  return HardOutcome::kUndecided;
}

struct OutcomeWords {
  const char* name;     ///< in tables
  const char* heading;  ///< on the terminal
  int rank;             ///< see TextTable::Column
};

/// In the order of the enum.
constexpr std::array<OutcomeWords, 10> kWords{{{"", "", 0},
                                               {"refused", "refused", 6},
                                               {"solved", "solved", 0},
                                               {"rightly_unsolvable", "no sol.", 1},
                                               {"gave_up_unsolvable", "gave up", 4},
                                               {"solved_unclaimed", "unsaid", 5},
                                               {"undecided", "unknown", 3},
                                               {"missed", "missed", 0},
                                               {"wrongly_unsolvable", "denied", 2},
                                               {"false_claim", "WRONG", 0}}};

const OutcomeWords& words_of(HardOutcome outcome) { return kWords[static_cast<std::size_t>(outcome)]; }

constexpr std::array kShown{HardOutcome::kSolved,           HardOutcome::kRightlyUnsolvable,
                            HardOutcome::kFalseClaim,       HardOutcome::kWronglyUnsolvable,
                            HardOutcome::kMissed,           HardOutcome::kSolvedUnclaimed,
                            HardOutcome::kGaveUpUnsolvable, HardOutcome::kUndecided,
                            HardOutcome::kRefused};

/// One solver on the hard cases.
struct Tally {
  std::size_t solver = 0;
  std::map<HardOutcome, std::int64_t> counts;

  std::int64_t right() const {
    const auto count = [this](HardOutcome outcome) { return counts.contains(outcome) ? counts.at(outcome) : 0; };
    return count(HardOutcome::kSolved) + count(HardOutcome::kRightlyUnsolvable);
  }
};

/// Calls visit(cell) for the cells of hard cases at single settings.
template <class Visit>
void for_each_hard_cell(const Summary& summary, Visit visit) {
  for (const Cell& cell : summary.cells) {
    if (is_hard_set(summary.sets[cell.set].name) && summary.solvers[cell.solver].sweep.empty()) visit(cell);
  }
}

std::vector<Tally> tallies(const Summary& summary) {
  std::map<std::size_t, Tally> by_solver;
  for_each_hard_cell(summary, [&](const Cell& cell) {
    by_solver[cell.solver].solver = cell.solver;
    ++by_solver[cell.solver].counts[hard_outcome(cell)];
  });
  std::vector<Tally> tallies;
  for (auto& [solver, tally] : by_solver) tallies.push_back(std::move(tally));
  std::stable_sort(tallies.begin(), tallies.end(),
                   [](const Tally& a, const Tally& b) { return a.right() > b.right(); });
  return tallies;
}

}  // namespace

const char* to_string(HardOutcome outcome) { return words_of(outcome).name; }

HardOutcome hard_outcome(const Cell& cell) {
  HardOutcome worst = HardOutcome::kNotRun;
  for (const Claim claim : kAllClaims) {
    for (const Verdict verdict : kAllVerdicts) {
      if (cell.count(claim, verdict) > 0) worst = std::max(worst, outcome_of(claim, verdict));
    }
  }
  return worst;
}

std::string hard_truth(const std::string& set) {
  if (!is_hard_set(set)) return "";
  try {
    const std::optional<HardCase> problem = hard_case(set);
    return problem ? truth_text(*problem) : "";
  } catch (const InputError&) {  // a store may come from another version, with sets and dials of its own
    return "";
  }
}

std::string hard_text(const Summary& summary, int width, std::size_t solvers) {
  const auto cases = std::count_if(summary.sets.begin(), summary.sets.end(),
                                   [](const SetSummary& set) { return is_hard_set(set.name); });
  std::vector<TextTable::Column> columns{{counted(cases, "hard case"), TextTable::Align::kLeft}};
  for (const HardOutcome outcome : kShown) {
    columns.push_back({words_of(outcome).heading, TextTable::Align::kRight, words_of(outcome).rank});
  }
  TextTable table(columns);
  const std::vector<Tally> all = tallies(summary);
  for (std::size_t i = 0; i < std::min(solvers, all.size()); ++i) {
    std::vector<std::string> row{solver_label(summary, all[i].solver)};
    for (const HardOutcome outcome : kShown) {
      row.push_back(std::to_string(all[i].counts.contains(outcome) ? all[i].counts.at(outcome) : 0));
    }
    table.add_row(std::move(row));
  }
  if (table.empty()) return "";
  const std::string more =
      all.size() > solvers ? fmt::format("and {} more solvers: --long shows them\n", all.size() - solvers) : "";
  return table.text(width) + more;
}

std::string hard_words(const Summary& summary, int width) {
  std::map<std::size_t, std::string> wrong;
  bool any = false;
  for_each_hard_cell(summary, [&](const Cell& cell) {
    any = true;
    if (hard_outcome(cell) != HardOutcome::kFalseClaim) return;
    std::string& cases = wrong[cell.solver];
    cases += (cases.empty() ? "" : ", ") + mended(summary.sets[cell.set].name.substr(std::string("hard/").size()));
  });
  if (!any) return "";
  std::string text = wrong.empty() ? "no solver said solved what is not\n" : "said solved, and is not:\n";
  for (const auto& [solver, cases] : wrong) text += "  " + mended(solver_label(summary, solver)) + ": " + cases + "\n";
  return folded(text +
                    "no sol.: rightly said to have no solution. WRONG: said solved, and is not. denied: said to have no "
                    "solution, has one. unsaid: right, but not claimed. gave up: on what has no solution.\n",
                width);
}

}  // namespace lcpbench::report
