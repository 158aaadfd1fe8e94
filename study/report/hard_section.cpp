#include "study/report/hard_section.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "study/report/solver_comparison.h"
#include "study/report/hard.h"
#include "study/report/html_table.h"
#include "study/report/text.h"
#include "study/output/text_table.h"

namespace lcpbench::report {

namespace {

struct Sign {
  const char* text;
  const char* cls;
  const char* meaning;
};

Sign sign_of(HardOutcome outcome) {
  switch (outcome) {
    case HardOutcome::kNotRun: return {"", "zero", ""};
    case HardOutcome::kRefused: return {"", "zero", "blank: outside what the solver takes"};
    case HardOutcome::kSolved: return {"✓", "good", "said solved, and is"};
    case HardOutcome::kRightlyUnsolvable: return {"∅", "good", "said to have no solution, and proven to have none"};
    case HardOutcome::kGaveUpUnsolvable: return {"∅?", "zero", "gave up; it is proven to have no solution"};
    case HardOutcome::kSolvedUnclaimed: return {"(✓)", "zero", "the answer is right, the solver did not say so"};
    case HardOutcome::kUndecided: return {"?", "zero", "not solved, and not known whether it can be"};
    case HardOutcome::kMissed: return {"–", "zero", "gave up; it can be solved"};
    case HardOutcome::kWronglyUnsolvable: return {"∅!", "bad", "said to have no solution; it has one"};
    case HardOutcome::kFalseClaim: return {"✗", "bad", "said solved, and is not: wrong and silent"};
  }
  return {"", "", ""};
}

constexpr std::array kShown{HardOutcome::kSolved,           HardOutcome::kRightlyUnsolvable,
                            HardOutcome::kFalseClaim,       HardOutcome::kWronglyUnsolvable,
                            HardOutcome::kMissed,           HardOutcome::kSolvedUnclaimed,
                            HardOutcome::kGaveUpUnsolvable, HardOutcome::kUndecided,
                            HardOutcome::kRefused};

std::string sign_html(HardOutcome outcome) {
  const Sign sign = sign_of(outcome);
  return fmt::format("<span class=\"{}\">{}</span>", sign.cls, sign.text);
}

std::string sign_cell(const HardCaseCell& cell) {
  const Sign sign = sign_of(cell.outcome);
  return fmt::format("<td class=\"{}\">{}</td>", sign.cls, sign.text);
}

std::string legend() {
  std::string items;
  for (const HardOutcome outcome : kShown) {
    const Sign sign = sign_of(outcome);
    if (sign.text[0] != '\0') items += sign_html(outcome) + " " + sign.meaning + "; ";
  }
  return "<p class=\"note\">" + items + sign_of(HardOutcome::kRefused).meaning + ".</p>\n";
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

constexpr std::array<const char*, kShown.size()> kTotalHeadings{
    "Solved", "Rightly unsolvable", "Wrong and silent",    "Wrongly unsolvable",
    "Missed", "Right, not claimed", "Gave up, unsolvable", "Undecided",
    "Refused"};

std::string totals_table(const Summary& summary, const HardStudy& study) {
  std::vector<Column> columns{{"Solver", false}};
  for (const char* heading : kTotalHeadings) columns.push_back({heading, true});
  std::string table = table_head("cells", columns);
  for (std::size_t column = 0; column < study.solvers.size(); ++column) {
    table += "<tr><th scope=\"row\">" + code(solver_label(summary, study.solvers[column])) + "</th>";
    const auto counts = totals(study, column);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const char* cls = counts[i] == 0 ? "zero" : sign_of(kShown[i]).cls;
      table += number_cell(static_cast<double>(counts[i]), fmt::format("<span class=\"{}\">{}</span>", cls, counts[i]));
    }
    table += "</tr>\n";
  }
  return table + kTableEnd;
}

std::string solver_headings(const Summary& summary, const HardStudy& study) {
  std::string headings;
  for (const std::size_t solver : study.solvers) {
    headings += "<th scope=\"col\">" + code(solver_label(summary, solver)) + "</th>";
  }
  return headings;
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
  return "<details><summary>" + escape(family) +
         "</summary><div class=\"scroll\" tabindex=\"0\"><table class=\"cases\"><thead><tr><th "
         "scope=\"col\">Case</th>" +
         solver_headings(summary, study) + "</tr></thead><tbody>\n" + case_rows(summary, study, family) + kTableEnd +
         "</details>\n";
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
  std::string head = "<div class=\"scroll\" tabindex=\"0\"><table><caption>" + title +
                     "</caption><thead><tr><th scope=\"col\">Breaks</th>";
  for (const std::string& value : dial.values) head += "<th scope=\"col\">" + code(value) + "</th>";
  return head + "</tr></thead><tbody>\n" + rows + kTableEnd;
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

std::string hard_section(const Summary& summary) {
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

std::string hard_navigation(const Summary& summary) {
  const bool any = std::any_of(summary.sets.begin(), summary.sets.end(),
                               [](const SetSummary& set) { return is_hard_set(set.name); });
  return any ? "<a href=\"#hard\">Hard cases</a>" : "";
}

std::string hard_text(const Summary& summary, int width) {
  const HardStudy study = hard_study(summary);
  if (study.empty()) return "";
  constexpr std::array<const char*, kShown.size()> kHeadings{"solved", "no sol.", "WRONG",   "denied", "missed",
                                                             "unsaid", "gave up", "unknown", "refused"};
  std::vector<TextTable::Column> columns{
      {counted(static_cast<std::int64_t>(study.rows.size()), "hard case"), TextTable::Align::kLeft}};
  constexpr std::array<int, kShown.size()> kRanks{0, 1, 0, 2, 0, 5, 4, 3, 6};  // see TextTable::Column
  for (std::size_t i = 0; i < kHeadings.size(); ++i) {
    columns.push_back({kHeadings[i], TextTable::Align::kRight, kRanks[i]});
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
