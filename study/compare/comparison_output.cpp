#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "study/compare/store_comparison.h"
#include "study/output/json_output.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/report/choice.h"

namespace lcpbench {

using report::kSignificance;

namespace {

using Json = nlohmann::ordered_json;

// --- as text ---

std::string change_text(std::int64_t before, std::int64_t after) {
  return before == after ? format_count(before) : format_count(before) + " -> " + format_count(after);
}

std::string p_text(double p) { return p >= 1 ? "1" : fmt::format("{:.2g}", p); }

std::string time_text(const CellChange& cell) {
  if (std::isnan(cell.time_ratio.value)) return "-";
  if (std::isnan(cell.time_ratio.low)) return fmt::format("{:.3g}", cell.time_ratio.value);
  return fmt::format("{:.3g} ({:.3g} .. {:.3g})", cell.time_ratio.value, cell.time_ratio.low, cell.time_ratio.high);
}

std::string name_text(const CellChange& cell) {
  std::string text = solver_text(cell.a);
  if (solver_text(cell.b) != text) text += " -> " + solver_text(cell.b);
  if (cell.a.version != cell.b.version) text += " [" + cell.a.version + " -> " + cell.b.version + "]";
  if (cell.a.isa != cell.b.isa) text += " [" + cell.a.isa + " -> " + cell.b.isa + "]";
  return text;
}

/// What changed, in words; "tie" for nothing.
std::string change_words(const CellChange& cell) {
  std::string words;
  const auto say = [&words](const std::string& word) { words += (words.empty() ? "" : ", ") + word; };
  if (cell.solved() == Tendency::kBetter) say("solves more");
  if (cell.solved() == Tendency::kWorse) say("SOLVES FEWER");
  if (cell.false_new > 0) say(fmt::format("{} NEW FALSE CLAIM{}", cell.false_new, cell.false_new > 1 ? "S" : ""));
  if (cell.false_claims() == Tendency::kBetter) say("fewer false claims");
  if (cell.time() == Tendency::kBetter) say("faster");
  if (cell.time() == Tendency::kWorse) say("slower");
  return words.empty() ? "tie" : words;
}

Json solver_json(const SolverRow& row) {
  return {{"solver", row.name},     {"settings", row.settings}, {"library", row.library},
          {"version", row.version}, {"isa", row.isa},           {"sweep", row.sweep}};
}

Json cell_json(const CellChange& cell) {
  Json json{{"set", cell.set}, {"a", solver_json(cell.a)}, {"b", solver_json(cell.b)}, {"problems", cell.problems}};
  json["left_out"] = {{"other_data", cell.other_data}, {"only_in_a", cell.only_in_a}, {"only_in_b", cell.only_in_b}};
  json["solved"] = {{"a", cell.solved_a},
                    {"b", cell.solved_b},
                    {"only_a", cell.lost},
                    {"only_b", cell.gained},
                    {"p", cell.solved_p},
                    {"p_holm", cell.solved_p_holm},
                    {"b_is", to_string(cell.solved())}};
  json["false_claims"] = {{"a", cell.false_a},
                          {"b", cell.false_b},
                          {"only_a", cell.false_gone},
                          {"only_b", cell.false_new},
                          {"p", cell.false_p},
                          {"p_holm", cell.false_p_holm},
                          {"b_is", to_string(cell.false_claims())}};
  json["time"] = {{"problems", cell.timed},
                  {"ratio", json_number(cell.time_ratio.value)},
                  {"low", json_number(cell.time_ratio.low)},
                  {"high", json_number(cell.time_ratio.high)},
                  {"median_ratio", json_number(cell.median_ratio)},
                  {"b_is", to_string(cell.time())}};
  json["pivots"] = {{"problems", cell.counted}, {"a", cell.pivots_a}, {"b", cell.pivots_b}};
  json["regressed"] = cell.regressed();
  json["change"] = change_words(cell);
  return json;
}

bool is_shown(const CellChange& cell) { return cell.a.sweep.empty() || change_words(cell) != "tie"; }

std::string unmatched_text(const std::vector<std::string>& list, const char* where) {
  std::string text;
  for (const std::string& entry : list) text += fmt::format("only in {}: {}\n", where, entry);
  return text;
}

std::string left_out_text(const StoreComparison& comparison) {
  const std::int64_t other_data = comparison.sum(&CellChange::other_data);
  const std::int64_t one_sided = comparison.sum(&CellChange::only_in_a) + comparison.sum(&CellChange::only_in_b);
  std::string text;
  if (other_data > 0) {
    text += fmt::format("left out: {} answers to problems whose data differ between the stores\n",
                        format_count(other_data));
  }
  if (one_sided > 0) text += fmt::format("left out: {} answers that only one store has\n", format_count(one_sided));
  return text;
}

std::string total_text(const std::vector<CellChange>& cells) {
  const auto count = [&cells](const std::function<bool(const CellChange&)>& holds) {
    return std::count_if(cells.begin(), cells.end(), holds);
  };
  return fmt::format("{} cells. Solved: {} better, {} worse. New false claims: in {}. Time: {} faster, {} slower.\n",
                     format_count(std::ssize(cells)),
                     count([](const CellChange& c) { return c.solved() == Tendency::kBetter; }),
                     count([](const CellChange& c) { return c.solved() == Tendency::kWorse; }),
                     count([](const CellChange& c) { return c.false_new > 0; }),
                     count([](const CellChange& c) { return c.time() == Tendency::kBetter; }),
                     count([](const CellChange& c) { return c.time() == Tendency::kWorse; }));
}

std::string conclusion_text(const StoreComparison& comparison) {
  if (comparison.regressed())
    return "B is worse: it solves significantly fewer problems in some, or makes new false claims.\n";
  if (comparison.slower()) return "B is no less reliable, and significantly slower in some.\n";
  const bool any = std::any_of(comparison.cells.begin(), comparison.cells.end(),
                               [](const CellChange& cell) { return change_words(cell) != "tie"; });
  return any ? "B is neither less reliable nor slower, and better in some.\n" : "B is a tie with A.\n";
}

constexpr std::size_t kLinesOfAnswer = kAnswerLines - 3;  // the names of the stores stand above it

/// The gravest first: new false claims, fewer solved, slower, then what got better.
int gravity(const CellChange& cell) {
  if (cell.false_new > 0) return 0;
  if (cell.solved() == Tendency::kWorse) return 1;
  return cell.time() == Tendency::kWorse ? 2 : 3;
}

TextTable change_table() {
  using Align = TextTable::Align;
  return TextTable({{"set", Align::kLeft, 0, 12},
                    {"solver", Align::kLeft, 0, 12},
                    {"problems", Align::kRight, 2},
                    {"solved"},
                    {"lost", Align::kRight, 4},
                    {"gained", Align::kRight, 4},
                    {"p", Align::kRight, 3},
                    {"false claims", Align::kRight, 1},
                    {"time B/A"},
                    {"pivots", Align::kRight, 5},
                    {"B is", Align::kLeft, 0, 12}});
}

void add_row(const CellChange& cell, TextTable& table) {
  table.add_row({cell.set, name_text(cell), format_count(cell.problems), change_text(cell.solved_a, cell.solved_b),
                 format_count(cell.lost), format_count(cell.gained), p_text(cell.solved_p_holm),
                 change_text(cell.false_a, cell.false_b), time_text(cell),
                 cell.counted > 0 ? change_text(cell.pivots_a, cell.pivots_b) : "-", change_words(cell)});
}

}  // namespace

Json comparison_document(const StoreComparison& comparison) {
  Json json{{"significance", kSignificance}, {"regressed", comparison.regressed()}, {"slower", comparison.slower()}};
  json["cells"] = Json::array();
  for (const CellChange& cell : comparison.cells) json["cells"].push_back(cell_json(cell));
  std::string conclusion = conclusion_text(comparison);
  conclusion.pop_back();
  json["conclusion"] = conclusion;
  json["only_in_a"] = comparison.missing;
  json["only_in_b"] = comparison.added;
  return json;
}

std::string comparison_answer(const StoreComparison& comparison, int width) {
  std::vector<const CellChange*> changed;
  for (const CellChange& cell : comparison.cells) {
    if (change_words(cell) != "tie") changed.push_back(&cell);
  }
  std::stable_sort(changed.begin(), changed.end(),
                   [](const CellChange* a, const CellChange* b) { return gravity(*a) < gravity(*b); });
  std::string note = left_out_text(comparison);
  const auto unmatched = [&note](const std::vector<std::string>& list, const char* where) {
    if (!list.empty()) note += fmt::format("only in {}: {}\n", where, counted_noun(list.size(), "cell"));
  };
  unmatched(comparison.missing, "A");
  unmatched(comparison.added, "B");
  const std::string end = folded(note + total_text(comparison.cells) + conclusion_text(comparison), width);
  return fitting_text(changed.size(), kLinesOfAnswer, [&](std::size_t rows) {
    TextTable table = change_table();
    for (std::size_t i = 0; i < rows; ++i) add_row(*changed[i], table);
    const std::string more =
        rows < changed.size() ? fmt::format("and {} more changed: --long shows them\n", changed.size() - rows) : "";
    return (table.empty() ? "" : table.text(width)) + more + end;
  });
}

std::string comparison_text(const StoreComparison& comparison, int width) {
  TextTable table = change_table();
  std::int64_t hidden = 0;
  for (const CellChange& cell : comparison.cells) {
    if (is_shown(cell)) add_row(cell, table);
    hidden += is_shown(cell) ? 0 : 1;
  }
  std::string text = table.text(width) + "\n";
  std::string note;
  if (hidden > 0) note += fmt::format("{} parameterisations of sweeps did not change and are not shown\n", hidden);
  note += left_out_text(comparison);
  note += unmatched_text(comparison.missing, "A") + unmatched_text(comparison.added, "B");
  note +=
      "p: exact McNemar test of the share solved, corrected by Holm's method for the number of cells; 5 %.\n"
      "time: ratio of summed times of the problems solved in both, with its 95 % interval; a tie within 5 %.\n";
  return text + folded(note + total_text(comparison.cells) + conclusion_text(comparison), width);
}

}  // namespace lcpbench
