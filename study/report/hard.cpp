#include "study/report/hard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "core/error.h"
#include "generators/hard/hard.h"
#include "study/output/text_table.h"
#include "study/report/page.h"
#include "study/report/text.h"

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

/// How the page and the terminal speak of an outcome.
struct OutcomeWords {
  const char* name;  ///< in tables
  const char* sign;  ///< in the page's tables, with its class and meaning
  const char* cls;
  const char* meaning;
  const char* heading;  ///< of its column in the page, and on the terminal
  const char* short_heading;
  int rank;  ///< see TextTable::Column
};

/// In the order of the enum.
constexpr OutcomeWords kWords[] = {
    {"", "", "zero", "", "", "", 0},
    {"refused", "", "zero", "blank: outside what the solver takes", "Refused", "refused", 6},
    {"solved", "✓", "good", "said solved, and is", "Solved", "solved", 0},
    {"rightly_unsolvable", "∅", "good", "said to have no solution, and proven to have none", "Rightly unsolvable",
     "no sol.", 1},
    {"gave_up_unsolvable", "∅?", "zero", "gave up; it is proven to have no solution", "Gave up, unsolvable", "gave up",
     4},
    {"solved_unclaimed", "(✓)", "zero", "the answer is right, the solver did not say so", "Right, not claimed",
     "unsaid", 5},
    {"undecided", "?", "zero", "not solved, and not known whether it can be", "Undecided", "unknown", 3},
    {"missed", "–", "zero", "gave up; it can be solved", "Missed", "missed", 0},
    {"wrongly_unsolvable", "∅!", "bad", "said to have no solution; it has one", "Wrongly unsolvable", "denied", 2},
    {"false_claim", "✗", "bad", "said solved, and is not: wrong and silent", "Wrong and silent", "WRONG", 0}};

const OutcomeWords& words_of(HardOutcome outcome) { return kWords[static_cast<std::size_t>(outcome)]; }

constexpr std::array kShown{HardOutcome::kSolved,           HardOutcome::kRightlyUnsolvable,
                            HardOutcome::kFalseClaim,       HardOutcome::kWronglyUnsolvable,
                            HardOutcome::kMissed,           HardOutcome::kSolvedUnclaimed,
                            HardOutcome::kGaveUpUnsolvable, HardOutcome::kUndecided,
                            HardOutcome::kRefused};

std::string sign_html(HardOutcome outcome) {
  return fmt::format("<span class=\"{}\">{}</span>", words_of(outcome).cls, words_of(outcome).sign);
}

std::string sign_cell(const HardCaseCell& cell) {
  return fmt::format("<td class=\"{}\">{}</td>", words_of(cell.outcome).cls, words_of(cell.outcome).sign);
}

std::string legend() {
  std::string items;
  for (const HardOutcome outcome : kShown) {
    const OutcomeWords& words = words_of(outcome);
    if (*words.sign != '\0') items += sign_html(outcome) + " " + words.meaning + "; ";
  }
  return "<p class=\"note\">" + items + words_of(HardOutcome::kRefused).meaning + ".</p>\n";
}

/// How many cases came to each outcome with one solver.
std::array<std::int64_t, kShown.size()> totals(const HardStudy& study, std::size_t column) {
  std::array<std::int64_t, kShown.size()> counts{};
  for (const HardCaseRow& row : study.rows) {
    const auto place = std::find(kShown.begin(), kShown.end(), row.cells[column].outcome);
    if (place != kShown.end()) ++counts[static_cast<std::size_t>(place - kShown.begin())];
  }
  return counts;
}

std::string totals_table(const Summary& summary, const HardStudy& study) {
  std::vector<Column> columns{{"Solver"}};
  for (const HardOutcome outcome : kShown) columns.push_back({words_of(outcome).heading, true});
  std::string table = table_head("cells", columns);
  for (std::size_t column = 0; column < study.solvers.size(); ++column) {
    table += "<tr><th scope=\"row\">" + code(solver_label(summary, study.solvers[column])) + "</th>";
    const auto counts = totals(study, column);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const char* cls = counts[i] == 0 ? "zero" : words_of(kShown[i]).cls;
      table += number_cell(static_cast<double>(counts[i]), fmt::format("<span class=\"{}\">{}</span>", cls, counts[i]));
    }
    table += "</tr>\n";
  }
  return table + kTableEnd;
}

std::string case_rows(const Summary& summary, const HardStudy& study, const std::string& family) {
  std::string rows;
  for (const HardCaseRow& row : study.rows) {
    const std::string& name = summary.sets[row.set].name;
    if (hard_family(name) != family) continue;
    rows += "<tr><th scope=\"row\">" + code(name) + "<small>" + escape(row.truth) + "</small></th>";
    for (const HardCaseCell& cell : row.cells) rows += sign_cell(cell);
    rows += "</tr>\n";
  }
  return rows;
}

std::vector<std::string> families(const Summary& summary, const HardStudy& study) {
  std::vector<std::string> names;
  for (const HardCaseRow& row : study.rows) {
    const std::string family = hard_family(summary.sets[row.set].name);
    if (std::find(names.begin(), names.end(), family) == names.end()) names.push_back(family);
  }
  return names;
}

std::string family_table(const Summary& summary, const HardStudy& study, const std::string& family) {
  std::vector<Column> columns{{"Case"}};
  for (const std::size_t solver : study.solvers) columns.push_back({code(solver_label(summary, solver))});
  return "<details><summary>" + escape(family) + "</summary>" + table_head("cases", columns) +
         case_rows(summary, study, family) + kTableEnd + "</details>\n";
}

bool right_or_refused_along(const HardStudy& study, const HardDial& dial, std::size_t column) {
  return std::all_of(dial.rows.begin(), dial.rows.end(), [&](std::size_t row) {
    const HardOutcome outcome = study.rows[row].cells[column].outcome;
    return is_right(outcome) || outcome == HardOutcome::kRefused || outcome == HardOutcome::kNotRun;
  });
}

std::string dial_row(const Summary& summary, const HardStudy& study, const HardDial& dial, std::size_t column) {
  std::string row = "<tr><th scope=\"row\">" + code(solver_label(summary, study.solvers[column])) + "</th>";
  for (const std::size_t index : dial.rows) row += sign_cell(study.rows[index].cells[column]);
  return row + "</tr>\n";
}

std::string dial_table(const Summary& summary, const HardStudy& study, const HardDial& dial) {
  std::string rows;
  for (std::size_t column = 0; column < study.solvers.size(); ++column) {
    if (!right_or_refused_along(study, dial, column)) rows += dial_row(summary, study, dial, column);
  }
  const std::string title = code(dial.set) + ", " + code(dial.dial) + "<small> " + escape(dial.help) + "</small>";
  if (rows.empty()) return "<p>" + title + ": no solver that takes it breaks.</p>\n";
  std::vector<Column> columns{{"Breaks"}};
  for (const std::string& value : dial.values) columns.push_back({code(value)});
  return table_head("", columns, title) + rows + kTableEnd;
}

/// Every false claim, "solver: case, case".
std::string false_claims_text(const Summary& summary, const HardStudy& study) {
  std::string text;
  for (std::size_t column = 0; column < study.solvers.size(); ++column) {
    std::string cases;
    for (const HardCaseRow& row : study.rows) {
      if (row.cells[column].outcome != HardOutcome::kFalseClaim) continue;
      cases += (cases.empty() ? "" : ", ") + mended(summary.sets[row.set].name.substr(std::string("hard/").size()));
    }
    if (!cases.empty()) text += "  " + mended(solver_label(summary, study.solvers[column])) + ": " + cases + "\n";
  }
  return text;
}

}  // namespace

const char* to_string(HardOutcome outcome) { return words_of(outcome).name; }

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

std::string hard_section(const Report& report) {
  const Summary& summary = report.summary;
  const HardStudy study = hard_study(summary);
  if (study.empty()) return "";
  std::string section =
      "<section id=\"hard\"><h2>Hard cases</h2>\n<p>One problem each, by a formula with dials; what each is, why it is "
      "hard and where it comes from: <code>lcpbench sets 'hard/*'</code>. Under its name stands what the formula says "
      "of it, which no verdict depends on.</p>\n" +
      legend() + totals_table(summary, study);
  for (const std::string& family : families(summary, study)) section += family_table(summary, study, family);
  if (!study.dials.empty()) {
    section +=
        "<h3>Where each solver breaks</h3>\n<p>Cases that differ in one dial alone; solvers that are right at every "
        "value they take are left out.</p>\n<details><summary>The dials, one table each</summary>\n";
    for (const HardDial& dial : study.dials) section += dial_table(summary, study, dial);
    section += "</details>\n";
  }
  return section + "</section>\n";
}

std::string hard_text(const Summary& summary, int width) {
  const HardStudy study = hard_study(summary);
  if (study.empty()) return "";
  std::vector<TextTable::Column> columns{
      {counted(static_cast<std::int64_t>(study.rows.size()), "hard case"), TextTable::Align::kLeft}};
  for (const HardOutcome outcome : kShown) {
    columns.push_back({words_of(outcome).short_heading, TextTable::Align::kRight, words_of(outcome).rank});
  }
  TextTable table(columns);
  for (std::size_t column = 0; column < study.solvers.size(); ++column) {
    std::vector<std::string> row{solver_label(summary, study.solvers[column])};
    for (const std::int64_t count : totals(study, column)) row.push_back(std::to_string(count));
    table.add_row(std::move(row));
  }
  const std::string claims = false_claims_text(summary, study);
  return table.text(width) +
         folded(
             (claims.empty() ? "no solver said solved what is not\n" : "said solved, and is not:\n" + claims) +
                 "no sol.: rightly said to have no solution. WRONG: said solved, and is not. denied: said to have no "
                 "solution, has one. unsaid: right, but not claimed. gave up: on what has no solution.\n",
             width);
}

}  // namespace lcpbench::report
