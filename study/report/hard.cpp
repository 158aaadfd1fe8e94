#include "study/report/hard.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>

#include "core/error.h"
#include "generators/hard/hard.h"
#include "study/report/solver_comparison.h"

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kPrefix = "hard/";

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

const HardSet* find_hard_set(const std::string& name) {
  const auto& sets = hard_sets();
  const auto found = std::find_if(sets.begin(), sets.end(), [&](const HardSet& set) { return set.name == name; });
  return found == sets.end() ? nullptr : &*found;
}

/// A store may come from another version, whose sets and dials this program does not know.
std::string formula_truth(const std::string& set) {
  try {
    const std::optional<HardCase> problem = hard_case(set);
    return problem ? truth_text(*problem) : "";
  } catch (const InputError&) {
    return "";
  }
}

Spec spec_of(const std::string& set) {
  try {
    return parse_spec(set);
  } catch (const InputError&) {
    return {set, {}};
  }
}

std::vector<std::size_t> hard_solvers(const Summary& summary) {
  std::vector<std::size_t> solvers;
  for (const Cell& cell : summary.cells) {
    if (!is_hard_set(summary.sets[cell.set].name) || !summary.solvers[cell.solver].sweep.empty()) continue;
    solvers.push_back(cell.solver);
  }
  std::sort(solvers.begin(), solvers.end());
  solvers.erase(std::unique(solvers.begin(), solvers.end()), solvers.end());
  return solvers;
}

std::vector<HardCaseRow> hard_rows(const Summary& summary, const std::vector<std::size_t>& solvers) {
  std::vector<HardCaseRow> rows;
  std::vector<std::size_t> row_of_set(summary.sets.size());
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    const std::string& name = summary.sets[set].name;
    if (!is_hard_set(name)) continue;
    row_of_set[set] = rows.size();
    rows.push_back({set, spec_of(name), formula_truth(name), std::vector<HardCaseCell>(solvers.size())});
  }
  for (const Cell& cell : summary.cells) {
    if (!is_hard_set(summary.sets[cell.set].name) || !summary.solvers[cell.solver].sweep.empty()) continue;
    const auto column = std::lower_bound(solvers.begin(), solvers.end(), cell.solver) - solvers.begin();
    rows[row_of_set[cell.set]].cells[static_cast<std::size_t>(column)] = {hard_outcome(cell), &cell};
  }
  return rows;
}

/// The value of a dial in a row that has no other dial off its default.
std::optional<std::string> value_along(const Spec& spec, const SettingInfo& dial) {
  if (spec.options.empty()) return dial.default_value;
  if (spec.options.size() > 1 || spec.options.front().first != dial.name) return std::nullopt;
  return spec.options.front().second;
}

double rank_of(const std::string& value, const SettingInfo& dial) {
  if (dial.type == "choice") return static_cast<double>(("|" + dial.range + "|").find("|" + value + "|"));
  return std::strtod(value.c_str(), nullptr);
}

HardDial rows_along(const std::string& set, const SettingInfo& dial, const std::vector<HardCaseRow>& rows) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (rows[row].spec.name != set) continue;
    if (const auto value = value_along(rows[row].spec, dial)) order.emplace_back(rank_of(*value, dial), row);
  }
  std::sort(order.begin(), order.end());
  HardDial result{set, dial.name, dial.help, {}, {}};
  for (const auto& [rank, row] : order) {
    result.values.push_back(*value_along(rows[row].spec, dial));
    result.rows.push_back(row);
  }
  return result;
}

std::vector<HardDial> hard_dials(const std::vector<HardCaseRow>& rows) {
  std::vector<HardDial> dials;
  std::set<std::string> seen;
  for (const HardCaseRow& row : rows) {
    const HardSet* set = seen.insert(row.spec.name).second ? find_hard_set(row.spec.name) : nullptr;
    if (set == nullptr) continue;
    for (const SettingInfo& dial : set->options()) {
      HardDial along = rows_along(set->name, dial, rows);
      if (along.rows.size() > 1) dials.push_back(std::move(along));
    }
  }
  return dials;
}

std::string truth_word(const Summary& summary, const HardCaseRow& row) {
  for (const HardCaseCell& cell : row.cells) {
    if (cell.cell != nullptr && cell.cell->unsolvable_problems > 0) return "unsolvable";
  }
  return summary.sets[row.set].all_solvable ? "solvable" : "unknown";
}

Json case_record(const Summary& summary, const HardStudy& study, const HardCaseRow& row, std::size_t column) {
  const HardCaseCell& cell = row.cells[column];
  const auto claim = [&]() -> std::string {
    for (const Claim each : kAllClaims) {
      if (cell.cell->count(each) > 0) return to_string(each);
    }
    return "";
  };
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  return {{"set", summary.sets[row.set].name},
          {"solver", solver_label(summary, study.solvers[column])},
          {"claim", claim()},
          {"outcome", to_string(cell.outcome)},
          {"error_measure", cell.cell->error_measure},
          {"error", cell.cell->error_count > 0 ? number(cell.cell->error_max) : Json()},
          {"median_time_s", number(cell.cell->median_time.value)}};
}

/// One case with a column for each solver.
Json matrix_record(const Summary& summary, const HardStudy& study, const HardCaseRow& row) {
  Json record{{"set", summary.sets[row.set].name},
              {"n", summary.sets[row.set].largest_n},
              {"by_formula", row.truth},
              {"truth", truth_word(summary, row)}};
  for (std::size_t column = 0; column < study.solvers.size(); ++column) {
    record[solver_label(summary, study.solvers[column])] = to_string(row.cells[column].outcome);
  }
  return record;
}

std::string joined(const std::string& list, const std::string& value) {
  return list.empty() ? value : list + " " + value;
}

Json dial_record(const Summary& summary, const HardStudy& study, const HardDial& dial, std::size_t column) {
  std::string right;
  std::string not_right;
  std::string refused;
  HardOutcome worst = HardOutcome::kNotRun;
  for (std::size_t i = 0; i < dial.rows.size(); ++i) {
    const HardOutcome outcome = study.rows[dial.rows[i]].cells[column].outcome;
    if (outcome == HardOutcome::kNotRun) continue;
    std::string& list = outcome == HardOutcome::kRefused ? refused : is_right(outcome) ? right : not_right;
    list = joined(list, dial.values[i]);
    worst = std::max(worst, outcome);
  }
  return {
      {"set", dial.set},          {"dial", dial.dial},      {"solver", solver_label(summary, study.solvers[column])},
      {"right", right},           {"not_right", not_right}, {"refused", refused},
      {"worst", to_string(worst)}};
}

}  // namespace

const char* to_string(HardOutcome outcome) {
  switch (outcome) {
    case HardOutcome::kNotRun: return "";
    case HardOutcome::kRefused: return "refused";
    case HardOutcome::kSolved: return "solved";
    case HardOutcome::kRightlyUnsolvable: return "rightly_unsolvable";
    case HardOutcome::kGaveUpUnsolvable: return "gave_up_unsolvable";
    case HardOutcome::kSolvedUnclaimed: return "solved_unclaimed";
    case HardOutcome::kUndecided: return "undecided";
    case HardOutcome::kMissed: return "missed";
    case HardOutcome::kWronglyUnsolvable: return "wrongly_unsolvable";
    case HardOutcome::kFalseClaim: return "false_claim";
  }
  return "";
}

bool is_right(HardOutcome outcome) {
  return outcome == HardOutcome::kSolved || outcome == HardOutcome::kRightlyUnsolvable;
}

HardOutcome hard_outcome(const Cell& cell) {
  HardOutcome worst = HardOutcome::kNotRun;
  for (const Claim claim : kAllClaims) {
    for (const Verdict verdict : kAllVerdicts) {
      if (cell.count(claim, verdict) > 0) worst = std::max(worst, outcome_of(claim, verdict));
    }
  }
  return worst;
}

bool is_hard_set(std::string_view name) { return name.substr(0, kPrefix.size()) == kPrefix; }

bool has_only_hard_sets(const Summary& summary) {
  return !summary.sets.empty() && std::all_of(summary.sets.begin(), summary.sets.end(),
                                              [](const SetSummary& set) { return is_hard_set(set.name); });
}

std::string hard_family(const std::string& name) {
  const std::size_t begin = kPrefix.size();
  return name.substr(begin, name.find('/', begin) - begin);
}

HardStudy hard_study(const Summary& summary) {
  HardStudy study;
  study.solvers = hard_solvers(summary);
  study.rows = hard_rows(summary, study.solvers);
  study.dials = hard_dials(study.rows);
  return study;
}

Json hard_tables(const Summary& summary, const HardStudy& study) {
  Json cases = Json::array();
  Json matrix = Json::array();
  for (const HardCaseRow& row : study.rows) {
    matrix.push_back(matrix_record(summary, study, row));
    for (std::size_t column = 0; column < study.solvers.size(); ++column) {
      if (row.cells[column].cell != nullptr) cases.push_back(case_record(summary, study, row, column));
    }
  }
  Json dials = Json::array();
  for (const HardDial& dial : study.dials) {
    for (std::size_t column = 0; column < study.solvers.size(); ++column) {
      dials.push_back(dial_record(summary, study, dial, column));
    }
  }
  return {{"hard_matrix", matrix}, {"hard_cases", cases}, {"hard_dials", dials}};
}

}  // namespace lcpbench::report
