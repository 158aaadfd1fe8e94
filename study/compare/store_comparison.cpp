#include "study/compare/store_comparison.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "core/error.h"
#include "core/suggestion.h"
#include "generators/glob.h"
#include "study/report/solver_comparison.h"
#include "study/output/json_output.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"

namespace lcpbench {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// One answer, as far as two stores are compared by it.
struct Entry {
  std::int64_t problem = 0;
  std::string hash;
  bool solved = false;
  bool false_claim = false;
  std::int64_t pivots = -1;
  double time_s = 0;
};

/// The answers of one solver to one set, by parameterisation, each list by problem.
using Entries = std::map<std::int64_t, std::vector<Entry>>;

Entries read_entries(Store& store, std::int64_t set, std::int64_t solver) {
  sqlite::Statement query(store.database(),
                          "SELECT j.cell, j.problem_id, p.hash, j.claim, j.verdict, a.pivots,"
                          " t.setup_cpu_s + t.solve_cpu_s"
                          " FROM judged_cells j JOIN answers a USING (problem_id, solver_id, part)"
                          " JOIN problems p ON p.id = j.problem_id"
                          " LEFT JOIN timings t USING (problem_id, solver_id, part)"
                          " WHERE j.set_id = ? AND j.solver_id = ? ORDER BY j.cell, j.problem_id");
  query.bind(1, set);
  query.bind(2, solver);
  Entries entries;
  while (query.step()) {
    const Claim claim = stored_claim(store.database(), query.text(3));
    const Verdict verdict = stored_verdict(store.database(), query.text(4));
    entries[query.integer(0)].push_back({.problem = query.integer(1),
                                         .hash = std::string(query.text(2)),
                                         .solved = verdict == Verdict::kSolved,
                                         .false_claim = verdict == Verdict::kWrong,
                                         .pivots = query.integer(5),
                                         .time_s = claim == Claim::kUnsupported ? kNone : query.real(6)});
  }
  return entries;
}

void count_pair(const Entry& a, const Entry& b, CellChange& change) {
  ++change.problems;
  change.solved_a += a.solved ? 1 : 0;
  change.solved_b += b.solved ? 1 : 0;
  change.lost += a.solved && !b.solved ? 1 : 0;
  change.gained += !a.solved && b.solved ? 1 : 0;
  change.false_a += a.false_claim ? 1 : 0;
  change.false_b += b.false_claim ? 1 : 0;
  change.false_gone += a.false_claim && !b.false_claim ? 1 : 0;
  change.false_new += !a.false_claim && b.false_claim ? 1 : 0;
  if (a.pivots >= 0 && b.pivots >= 0) {
    ++change.counted;
    change.pivots_a += a.pivots;
    change.pivots_b += b.pivots;
  }
}

struct PairedTimes {
  std::vector<double> a;
  std::vector<double> b;
};

double ratio_of_medians(const PairedTimes& times) { return spread(times.b).median / spread(times.a).median; }

void compare_times(const PairedTimes& times, bool with_interval, CellChange& change) {
  change.timed = static_cast<std::int64_t>(times.a.size());
  change.median_ratio = ratio_of_medians(times);
  if (with_interval) {
    change.time_ratio = ratio_of_sums(times.b, times.a);
    return;
  }
  change.time_ratio = {spread(times.b).mean / spread(times.a).mean, kNone, kNone};
}

/// Walks two lists in order of problems and pairs those with the same data.
void compare_entries(const std::vector<Entry>& a, const std::vector<Entry>& b, bool with_interval, CellChange& change) {
  PairedTimes times;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (a[i].problem != b[j].problem) {
      a[i].problem < b[j].problem ? ++i : ++j;
      continue;
    }
    const Entry& left = a[i++];
    const Entry& right = b[j++];
    if (left.hash != right.hash) {
      ++change.other_data;
      continue;
    }
    count_pair(left, right, change);
    if (!left.solved || !right.solved || std::isnan(left.time_s) || std::isnan(right.time_s)) continue;
    times.a.push_back(left.time_s);
    times.b.push_back(right.time_s);
  }
  const std::int64_t met_by_both = change.problems + change.other_data;
  change.only_in_a = std::ssize(a) - met_by_both;
  change.only_in_b = std::ssize(b) - met_by_both;
  change.solved_p = mcnemar_exact(change.lost, change.gained);
  change.false_p = mcnemar_exact(change.false_gone, change.false_new);
  compare_times(times, with_interval, change);
}

// --- who is compared with whom ---

std::string solver_text(const SolverRow& row) {
  return row.sweep.empty() ? row.text() : row.text() + " (sweep " + row.sweep + ")";
}

std::vector<StoredSolver> chosen_solvers(Store& store, const std::string& wanted) {
  std::vector<StoredSolver> solvers = store.solvers();
  if (wanted.empty()) return solvers;
  std::vector<std::string> known;
  for (const StoredSolver& solver : solvers) {
    if (solver.row.sweep.empty()) known.push_back(solver.row.text());
  }
  std::erase_if(solvers,
                [&](const StoredSolver& solver) { return !solver.row.sweep.empty() || solver.row.text() != wanted; });
  if (solvers.empty()) {
    throw InputError(fmt::format("{}: no solver '{}'{}; it has {}", store.file().string(), wanted,
                                 did_you_mean(wanted, known), fmt::join(known, ", ")));
  }
  return solvers;
}

using SolverPair = std::pair<StoredSolver, StoredSolver>;

struct Matching {
  std::vector<SolverPair> pairs;
  std::vector<StoredSolver> only_in_a;
  std::vector<StoredSolver> only_in_b;
};

/// Pairs solvers for which `same` holds and moves them out of both lists.
template <class Same>
void take_pairs(std::vector<StoredSolver>& a, std::vector<StoredSolver>& b, Same same, Matching& matching) {
  std::vector<StoredSolver> unmatched;
  for (StoredSolver& solver : a) {
    const auto partner =
        std::find_if(b.begin(), b.end(), [&](const StoredSolver& other) { return same(solver.row, other.row); });
    if (partner == b.end()) {
      unmatched.push_back(std::move(solver));
      continue;
    }
    matching.pairs.emplace_back(std::move(solver), std::move(*partner));
    b.erase(partner);
  }
  a = std::move(unmatched);
}

/// Equal rows first, then equal but for the version, then equal but for version and instruction-set level.
Matching match_solvers(std::vector<StoredSolver> a, std::vector<StoredSolver> b, bool by_name) {
  Matching matching;
  const auto same_name = [by_name](const SolverRow& x, const SolverRow& y) {
    return !by_name || (x.name == y.name && x.settings == y.settings && x.sweep == y.sweep);
  };
  const auto same_level = [&](const SolverRow& x, const SolverRow& y) { return same_name(x, y) && x.isa == y.isa; };
  const auto same_row = [&](const SolverRow& x, const SolverRow& y) {
    return same_level(x, y) && x.version == y.version && x.library == y.library;
  };
  take_pairs(a, b, same_row, matching);
  take_pairs(a, b, same_level, matching);
  take_pairs(a, b, same_name, matching);
  matching.only_in_a = std::move(a);
  matching.only_in_b = std::move(b);
  return matching;
}

/// The parameterisation of `solver` with these settings.
std::optional<std::size_t> find_cell(const StoredSolver& solver, const std::string& settings) {
  for (std::size_t cell = 0; cell < solver.cells.size(); ++cell) {
    if (solver.cells[cell].settings == settings) return cell;
  }
  return std::nullopt;
}

void compare_solver(const std::string& set, const SolverPair& solvers, const Entries& a, const Entries& b,
                    StoreComparison& comparison) {
  const bool is_sweep = !solvers.first.row.sweep.empty();
  for (const auto& [cell, entries] : a) {
    const auto number = static_cast<std::size_t>(cell);
    const auto partner =
        is_sweep ? find_cell(solvers.second, solvers.first.cells.at(number).settings) : std::optional<std::size_t>(0);
    const auto others = partner ? b.find(static_cast<std::int64_t>(*partner)) : b.end();
    if (others == b.end()) {
      comparison.missing.push_back(set + ": " + solver_text(solvers.first.cell(number)));
      continue;
    }
    CellChange change;
    change.set = set;
    change.a = solvers.first.cell(number);
    change.b = solvers.second.cell(*partner);
    compare_entries(entries, others->second, !is_sweep, change);
    comparison.cells.push_back(std::move(change));
  }
}

bool is_wanted(const std::string& set, const std::vector<std::string>& patterns) {
  return patterns.empty() || std::any_of(patterns.begin(), patterns.end(),
                                         [&set](const std::string& pattern) { return glob_matches(pattern, set); });
}

using SetIds = std::map<std::string, std::int64_t, bool (*)(const std::string&, const std::string&)>;

SetIds wanted_sets(Store& store, const std::vector<std::string>& patterns) {
  SetIds sets(natural_less);
  for (const auto& [id, name] : store.sets()) {
    if (is_wanted(name, patterns)) sets.emplace(name, id);
  }
  return sets;
}

/// A pattern that names no set of either store is a slip, not an empty comparison.
void check_patterns(Store& a, Store& b, const std::vector<std::string>& patterns) {
  for (const std::string& pattern : patterns) {
    if (!wanted_sets(a, {pattern}).empty() || !wanted_sets(b, {pattern}).empty()) continue;
    throw InputError(fmt::format("--set '{}': no such set in {} or {}", pattern, a.file().string(), b.file().string()));
  }
}

void list_unmatched(Store& store, const SetIds& sets, const std::vector<StoredSolver>& solvers,
                    std::vector<std::string>& list) {
  for (const auto& [set, id] : sets) {
    for (const StoredSolver& solver : solvers) {
      if (!read_entries(store, id, solver.id).empty()) list.push_back(set + ": " + solver_text(solver.row));
    }
  }
}

/// Holm's correction over the cells that `belongs` picks.
template <class Belongs>
void correct(std::vector<CellChange>& cells, Belongs belongs, double CellChange::*p, double CellChange::*corrected) {
  std::vector<CellChange*> family;
  std::vector<double> p_values;
  for (CellChange& cell : cells) {
    if (!belongs(cell)) continue;
    family.push_back(&cell);
    p_values.push_back(cell.*p);
  }
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < family.size(); ++i) family[i]->*corrected = adjusted[i];
}

void correct_all(std::vector<CellChange>& cells) {
  for (const bool swept : {false, true}) {
    const auto belongs = [swept](const CellChange& cell) { return cell.a.sweep.empty() != swept; };
    correct(cells, belongs, &CellChange::solved_p, &CellChange::solved_p_holm);
    correct(cells, belongs, &CellChange::false_p, &CellChange::false_p_holm);
  }
}

// --- as JSON ---

using Json = nlohmann::ordered_json;

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
  return json;
}

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

bool is_shown(const CellChange& cell) { return cell.a.sweep.empty() || change_words(cell) != "tie"; }

std::string unmatched_text(const std::vector<std::string>& list, const char* where) {
  std::string text;
  for (const std::string& entry : list) text += fmt::format("only in {}: {}\n", where, entry);
  return text;
}

std::int64_t sum_over(const std::vector<CellChange>& cells, std::int64_t CellChange::*count) {
  std::int64_t sum = 0;
  for (const CellChange& cell : cells) sum += cell.*count;
  return sum;
}

std::string left_out_text(const std::vector<CellChange>& cells) {
  const std::int64_t other_data = sum_over(cells, &CellChange::other_data);
  const std::int64_t one_sided = sum_over(cells, &CellChange::only_in_a) + sum_over(cells, &CellChange::only_in_b);
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

const char* to_string(Tendency tendency) {
  switch (tendency) {
    case Tendency::kTie: return "tie";
    case Tendency::kBetter: return "better";
    case Tendency::kWorse: return "worse";
    case Tendency::kUnknown: return "unknown";
  }
  return "unknown";
}

Tendency CellChange::solved() const {
  if (!(solved_p_holm < kSignificance)) return Tendency::kTie;
  return gained > lost ? Tendency::kBetter : Tendency::kWorse;
}

Tendency CellChange::false_claims() const {
  if (!(false_p_holm < kSignificance)) return Tendency::kTie;
  return false_gone > false_new ? Tendency::kBetter : Tendency::kWorse;
}

Tendency CellChange::time() const {
  if (std::isnan(time_ratio.low) || std::isnan(time_ratio.high)) return Tendency::kUnknown;
  if (is_tie_in_time(time_ratio)) return Tendency::kTie;
  return time_ratio.value < 1 ? Tendency::kBetter : Tendency::kWorse;
}

bool CellChange::regressed() const { return solved() == Tendency::kWorse || false_new > 0; }

bool StoreComparison::regressed() const {
  return std::any_of(cells.begin(), cells.end(), [](const CellChange& cell) { return cell.regressed(); });
}

bool StoreComparison::slower() const {
  return std::any_of(cells.begin(), cells.end(),
                     [](const CellChange& cell) { return cell.time() == Tendency::kWorse; });
}

StoreComparison compare_stores(Store& a, Store& b, const CompareOptions& options) {
  check_patterns(a, b, options.sets);
  const std::string& wanted_b = options.solver_b.empty() ? options.solver_a : options.solver_b;
  const bool by_name = options.solver_a.empty() || options.solver_a == wanted_b;
  const Matching matching = match_solvers(chosen_solvers(a, options.solver_a), chosen_solvers(b, wanted_b), by_name);
  const SetIds sets_a = wanted_sets(a, options.sets);
  const SetIds sets_b = wanted_sets(b, options.sets);
  StoreComparison comparison;
  for (const auto& [set, id] : sets_a) {
    const auto other = sets_b.find(set);
    for (const SolverPair& solvers : matching.pairs) {
      const Entries left = read_entries(a, id, solvers.first.id);
      const Entries right = other == sets_b.end() ? Entries() : read_entries(b, other->second, solvers.second.id);
      compare_solver(set, solvers, left, right, comparison);
      if (left.empty() && !right.empty()) comparison.added.push_back(set + ": " + solver_text(solvers.second.row));
    }
  }
  list_unmatched(a, sets_a, matching.only_in_a, comparison.missing);
  list_unmatched(b, sets_b, matching.only_in_b, comparison.added);
  if (sum_over(comparison.cells, &CellChange::problems) == 0) {
    throw InputError(
        fmt::format("{} and {}: no solver met the same problem in both", a.file().string(), b.file().string()));
  }
  correct_all(comparison.cells);
  return comparison;
}

Json comparison_document(const StoreComparison& comparison) {
  Json json{{"significance", kSignificance}, {"regressed", comparison.regressed()}, {"slower", comparison.slower()}};
  json["cells"] = Json::array();
  for (const CellChange& cell : comparison.cells) json["cells"].push_back(cell_json(cell));
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
  std::string note = left_out_text(comparison.cells);
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
  note += left_out_text(comparison.cells);
  note += unmatched_text(comparison.missing, "A") + unmatched_text(comparison.added, "B");
  note +=
      "p: exact McNemar test of the share solved, corrected by Holm's method for the number of cells; 5 %.\n"
      "time: ratio of summed times of the problems solved in both, with its bootstrap interval; a tie within 5 %.\n";
  return text + folded(note + total_text(comparison.cells) + conclusion_text(comparison), width);
}

}  // namespace lcpbench
