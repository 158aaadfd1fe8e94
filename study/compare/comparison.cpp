#include "study/compare/comparison.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "core/suggestion.h"
#include "generators/sets.h"
#include "study/output/columns.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/report/choice.h"
#include "study/report/sql_functions.h"
#include "study/report/tables.h"
#include "study/run/study.h"

namespace lcpbench {

namespace compare {
extern const std::string_view kTables, kChanges, kComparison;  // the queries beside this file, by CMake
}

namespace {

using Json = nlohmann::ordered_json;
using sqlite::Statement;
using SetNames = std::set<std::string, bool (*)(const std::string&, const std::string&)>;

/// As stores spell it, without settings that are the default; as it is where it names no solver of this program.
std::string canonical(const std::string& solver) {
  try {
    return solver_row(parse_spec(solver)).text();
  } catch (const InputError&) {  // of another version, or "start=last"
    return solver;
  }
}

/// @param asked_for  a solver at single settings, "name{settings}"; "": all solvers, sweeps included
std::vector<StoredSolver> chosen_solvers(Store& store, const std::string& asked_for) {
  std::vector<StoredSolver> solvers = store.solvers();
  const std::string wanted = canonical(asked_for);
  if (wanted.empty()) return solvers;
  std::vector<std::string> known;
  for (const StoredSolver& solver : solvers) {
    if (solver.row.sweep.empty()) known.push_back(solver.row.text());
  }
  std::erase_if(solvers,
                [&](const StoredSolver& solver) { return !solver.row.sweep.empty() || solver.row.text() != wanted; });
  if (solvers.empty()) {
    throw InputError(fmt::format("{}: no solver '{}'{}; it has {}", store.file().string(), wanted,
                                 did_you_mean(wanted, known),
                                 known.empty() ? "sweeps alone" : fmt::format("{}", fmt::join(known, ", "))));
  }
  return solvers;
}

/// The sets of either store that match a pattern; all if there are none. @throws InputError if a pattern matches none
SetNames wanted_sets(Store& a, Store& b, const std::vector<std::string>& patterns) {
  SetNames sets(natural_less);
  for (Store* store : {&a, &b}) {
    for (const auto& [id, name] : store->sets()) sets.insert(name);
  }
  for (const std::string& pattern : patterns) {
    if (std::any_of(sets.begin(), sets.end(), [&](const auto& set) { return glob_matches(pattern, set); })) continue;
    throw InputError(fmt::format("--set '{}': no such set in {} or {}", pattern, a.file().string(), b.file().string()));
  }
  std::erase_if(sets, [&](const std::string& set) {
    return !patterns.empty() && std::none_of(patterns.begin(), patterns.end(),
                                             [&](const std::string& pattern) { return glob_matches(pattern, set); });
  });
  return sets;
}

/// Two stores in the tables of study/compare/tables.sql.
class Comparer {
 public:
  Comparer(Store& a, Store& b, const CompareOptions& options) : made_("comparison", sqlite::Mode::kInMemory) {
    report::add_statistics_functions(made_);
    made_.execute(std::string(compare::kTables));
    const std::string& wanted_b = options.solver_b.empty() ? options.solver_a : options.solver_b;
    const bool by_name = options.solver_a.empty() || canonical(options.solver_a) == canonical(wanted_b);
    add_cells("a", a, chosen_solvers(a, options.solver_a), by_name);
    add_cells("b", b, chosen_solvers(b, wanted_b), by_name);
    // First equal cells are matched, then those that differ only in library and version, then also those of different
    // instruction-set levels. `place` matches the first free cell of A with the first of B, and so on.
    for (const char* same : {"kin, isa, version, library", "kin, isa", "kin"}) {
      made_.execute(fmt::format(
          "WITH free AS (SELECT rowid AS cell, *, ROW_NUMBER() OVER (PARTITION BY side, {0} ORDER BY rowid) AS place "
          "FROM cells WHERE rowid NOT IN (SELECT a FROM matched UNION SELECT b FROM matched)) "
          "INSERT INTO matched SELECT a.cell, b.cell FROM free a JOIN free b USING ({0}, place) "
          "WHERE a.side = 'a' AND b.side = 'b' ORDER BY a.cell",
          same));
    }
  }

  void add_set(const std::string& set) {
    made_.execute("DELETE FROM here");
    Statement(made_, "INSERT INTO here VALUES (?)").run(set);
    for (const auto& [store, cells] : sides_) add_answers(*store, set_id(set), cells);
    made_.execute(std::string(compare::kChanges));
  }

  void compare() { made_.execute(std::string(compare::kComparison)); }

  Json rows(const std::string& sql) { return report::records_of(report::run_query(made_, "compare", sql)); }

  /// "set: solver" for what this side has and the other has not, the parameterisations of a sweep as one.
  Json unmet(const char* side) {
    Json names = Json::array();
    for (const Json& row : rows(fmt::format(
             "SELECT \"set\" || ': ' || iif(sweep = '', name, solver || ' (sweep ' || sweep || ')') AS name FROM unmet "
             "JOIN cells ON cells.rowid = cell WHERE unmet.side = '{}' GROUP BY 1 ORDER BY MIN(unmet.rowid)",
             side))) {
      names.push_back(row["name"]);
    }
    return names;
  }

 private:
  /// Rows of the table `cells`, by the solver's id in its store and the number of its parameterisation.
  using Cells = std::map<std::pair<std::int64_t, std::uint32_t>, std::int64_t>;

  void add_cells(const char* side, Store& store, const std::vector<StoredSolver>& solvers, bool by_name) {
    Statement add(made_, "INSERT INTO cells VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
    Cells& cells = sides_.emplace_back(&store, Cells()).second;
    for (const StoredSolver& solver : solvers) {
      for (std::uint32_t number = 0; number < solver.cells.size(); ++number) {
        const SolverRow& row = solver.cells[number];
        // Two solvers that were named belong together, whatever their names.
        const std::string kin = by_name ? row.text() + " " + row.sweep : "";
        add.run(side, kin, row.name, row.settings, row.library, row.version, row.isa, row.sweep);
        cells[{solver.id, number}] = made_.integer("SELECT last_insert_rowid()");
      }
    }
  }

  void add_answers(Store& store, std::int64_t set, const Cells& cells) {
    Statement add(made_, "INSERT INTO answers VALUES (?, ?, ?, ?, ?, ?, ?)");
    // Problem ids follow from set, seed and trial: they are the same in every store.
    const auto add_one = [&](const StoredAnswer& answer) {
      const bool timed = answer.claim != Claim::kUnsupported;
      const double time_s = timed ? answer.times.setup_cpu_s + answer.times.solve_cpu_s : kNoNumber;
      for (const std::uint32_t number : answer.cells) {
        const auto cell = cells.find({answer.solver_id, number});
        if (cell == cells.end()) continue;
        add.run(cell->second, answer.problem_id, answer.hash, answer.verdict == Verdict::kSolved,
                answer.verdict == Verdict::kWrong, answer.counters.pivots, time_s);
      }
    };
    store.for_each_answer(add_one, set);
  }

  sqlite::Database made_;
  std::vector<std::pair<Store*, Cells>> sides_;
};

std::string number(double value) { return fmt::format("{:.3g}", value); }
std::string p_text(double p) { return p >= 1 ? "1" : fmt::format("{:.2g}", p); }

/// "39 -> 27" of a member with counts of both.
JsonCell change_of(const char* name) {
  return [name](const Json& cell) {
    const auto [a, b] = std::pair(cell[name]["a"].get<std::int64_t>(), cell[name]["b"].get<std::int64_t>());
    return a == b ? format_count(a) : format_count(a) + " -> " + format_count(b);
  };
}

std::string set_text(const Json& cell) {
  return cell["set"].is_null() ? "all sets" : cell["set"].get<std::string>();
}

std::string time_text(const Json& cell) {
  const Json& time = cell["time"];
  if (time["ratio"].is_null()) return "-";
  if (time["low"].is_null()) return number(time["ratio"].get<double>());
  return fmt::format("{} ({} .. {})", number(time["ratio"].get<double>()), number(time["low"].get<double>()),
                     number(time["high"].get<double>()));
}

const std::vector<JsonColumn>& columns() {
  using Align = TextTable::Align;
  static const std::vector<JsonColumn> columns{{{"set", Align::kLeft, 0, 12}, set_text},
                                               {{"solver", Align::kLeft, 0, 12}, field("solver")},
                                               {{"problems", Align::kRight, 2}, field("problems")},
                                               {{"solved"}, change_of("solved")},
                                               {{"lost", Align::kRight, 4}, field("solved/only_a")},
                                               {{"gained", Align::kRight, 4}, field("solved/only_b")},
                                               {{"p", Align::kRight, 3}, field("solved/p_holm", p_text)},
                                               {{"false claims", Align::kRight, 1}, change_of("false_claims")},
                                               {{"time B/A"}, time_text},
                                               {{"pivots", Align::kRight, 5}, change_of("pivots")},
                                               {{"B is", Align::kLeft, 0, 12}, field("change")}};
  return columns;
}

}  // namespace

Json compare_stores(Store& a, Store& b, const CompareOptions& options) {
  const SetNames sets = wanted_sets(a, b, options.sets);
  Comparer comparer(a, b, options);
  for (const std::string& set : sets) comparer.add_set(set);
  comparer.compare();
  const Json total = comparer.rows("SELECT * FROM conclusion")[0];
  if (total["met"] == 0) {
    throw InputError(
        fmt::format("{} and {}: no solver met the same problem in both", a.file().string(), b.file().string()));
  }
  Json cells = Json::array();
  Json solvers = Json::array();  // over all sets
  for (const Json& row : comparer.rows("SELECT * FROM compared")) {
    Json flat = Json::object();
    for (const auto& [name, value] : row.items()) {
      std::string path = "/" + name;  // "time.low" becomes `low` of `time`
      std::replace(path.begin(), path.end(), '.', '/');
      flat[path] = value;
    }
    Json& kept = (row["set"].is_null() ? solvers : cells).emplace_back(flat.unflatten());
    kept["regressed"] = row["regressed"] == 1;
    kept["solved"]["too_few"] = row["solved.too_few"] == 1;
  }
  return {{"significance", report::kSignificance},
          {"regressed", total["regressed"] == 1},
          {"slower", total["slower"] == 1},
          {"solvers", std::move(solvers)},
          {"cells", std::move(cells)},
          {"summary", total["summary"]},
          {"conclusion", total["conclusion"]},
          {"only_in_a", comparer.unmet("a")},
          {"only_in_b", comparer.unmet("b")}};
}

std::string comparison_text(const Json& comparison, int width, bool all) {
  std::string end;
  for (const auto& [key, store] : {std::pair("only_in_a", 'A'), std::pair("only_in_b", 'B')}) {
    const auto names = comparison[key].get<std::vector<std::string>>();
    if (names.empty()) continue;
    end += fmt::format("only in {}: {}\n", store,
                       all ? fmt::format("{}", fmt::join(names, "; ")) : counted_noun(names.size(), "cell"));
  }
  if (all) {
    end +=
        "p: exact McNemar test of the share solved, corrected by Holm's method for the number of cells; 5 %.\n"
        "time: geometric mean of the ratios on the problems solved in both, with its 95 % interval; a tie within 5 %, "
        "where the interval contains 1, or where as many problems may be faster as slower (sign test, corrected).\n";
  }
  for (const char* key : {"summary", "conclusion"}) end += printable(comparison[key].get<std::string>()) + "\n";

  std::vector<Json> shown;
  for (const char* part : {"solvers", "cells"}) {
    for (const Json& cell : comparison[part]) {
      if (cell["change"] != "tie" || (all && cell["a"]["sweep"] == "")) shown.push_back(cell);
    }
  }
  const auto rank = [](const Json& cell) { return std::pair(!cell["set"].is_null(), cell["gravity"].get<int>()); };
  std::stable_sort(shown.begin(), shown.end(), [&](const Json& x, const Json& y) { return rank(x) < rank(y); });
  const auto text = [&](std::size_t rows) {
    const Json first(std::vector<Json>(shown.begin(), shown.begin() + static_cast<std::ptrdiff_t>(rows)));
    const std::string more =
        rows < shown.size() ? fmt::format("and {} more changed: --long shows them\n", shown.size() - rows) : "";
    return (rows == 0 ? "" : table_text(columns(), first, width)) + more + folded(end, width);
  };
  constexpr std::size_t kLines = kAnswerLines - 3;  // the two stores' names and an empty line stand above
  return all ? text(shown.size()) : fitting_text(shown.size(), kLines, text);
}

}  // namespace lcpbench
