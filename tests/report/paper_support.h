#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "study/paper/records.h"
#include "study/report/decision.h"
#include "study/report/sql_functions.h"
#include "study/report/tables.h"
#include "study/summary/summary.h"

namespace lcpbench {

/// What one parameterisation is made to have done on a set's problems.
struct MadeCell {
  std::int64_t trials = 2000;
  std::int64_t criterion = 2000;
  std::int64_t unclaimed = 0;  ///< pass the criterion, not claimed solved
  std::int64_t solved = 2000;  ///< verdict, all claimed
  std::int64_t unsolvable = 0;
  std::int64_t wrong = 0;  ///< claimed solved
  std::int64_t refused = 0;
  double time_s = 1e-3;     ///< mean; sigma is half of it, the maximum ten times
  double violation = 1e-9;  ///< mean, likewise
};

/// Made outcomes are to problem `seed * kTrialsOfASeed + trial`.
inline constexpr std::uint32_t kTrialsOfASeed = 100'000;

/// A summary written by hand: known numbers in, so that what comes out can be worked out on paper. Even and odd trials
/// share every count equally.
class MadeSummary {
 public:
  /// One parameterisation of a swept solver, `sweep` as stores name it: "paper", "paper{test=tried}".
  void swept(const std::string& set, const std::string& solver, const std::string& sweep, const std::string& settings,
             const MadeCell& made) {
    add(set, {solver, settings, settings, "native", version, isa, sweep}, made);
  }

  /// Of what is added from here on.
  std::string isa = "baseline";
  std::string version = "1.0";

  /// A sweep of `count` parameterisations whose counts go in equal steps from the worst to the best.
  void grid(const std::string& set, const std::string& solver, const MadeCell& worst, const MadeCell& best,
            const std::string& sweep = "paper", int count = 3) {
    for (int i = 0; i < count; ++i) {
      const auto between = [i, count](std::int64_t from, std::int64_t to) {
        return from + (to - from) * i / (count - 1);
      };
      MadeCell cell = worst;
      cell.criterion = between(worst.criterion, best.criterion);
      cell.solved = between(worst.solved, best.solved);
      cell.wrong = between(worst.wrong, best.wrong);
      swept(set, solver, sweep, "tolerance=" + std::to_string(i), cell);
    }
  }

  /// The same with one share for worst, average and best, by both measures.
  void flat(const std::string& set, const std::string& solver, double share, const std::string& sweep = "paper",
            double time_s = 1e-3) {
    MadeCell cell;
    cell.solved = cell.criterion = static_cast<std::int64_t>(share * static_cast<double>(cell.trials));
    cell.time_s = time_s;
    grid(set, solver, cell, cell, sweep);
  }

  /// A solver at single settings; problem i is solved where `pattern` says so, over and over.
  void single(const std::string& set, const std::string& solver, const std::string& settings,
              const std::vector<bool>& pattern, std::int64_t trials = 200) {
    MadeCell made{.trials = trials, .criterion = 0, .solved = 0};
    std::vector<Outcome> outcomes;
    for (std::int64_t trial = 0; trial < trials; ++trial) {
      const bool solved = pattern[static_cast<std::size_t>(trial) % pattern.size()];
      made.solved += solved;
      Outcome& outcome = outcomes.emplace_back();
      outcome.problem = static_cast<std::uint32_t>(trial);
      if (solved) outcome.verdict = Verdict::kSolved;
    }
    made.criterion = made.solved;
    add(set, {solver, settings, settings, "native", "1.0", "baseline", ""}, made);
    summary.cells.back().outcomes = std::move(outcomes);
  }

  Summary summary;

 private:
  static Spread spread_of(std::int64_t count, double mean) { return {count, mean, mean / 2, 10 * mean, mean}; }

  void add(const std::string& set, const SolverRow& solver, const MadeCell& made) {
    Cell cell;
    cell.set = index_of(set);
    cell.solver = summary.solvers.size();
    summary.solvers.push_back(solver);
    cell.trials = made.trials;
    SetSummary& problems = summary.sets[cell.set];
    problems.problems = std::max(problems.problems, made.trials);
    const auto count = [&cell](Claim claim, Verdict verdict) -> std::int64_t& {
      return cell.counts[static_cast<std::size_t>(claim)][static_cast<std::size_t>(verdict)];
    };
    count(Claim::kSolved, Verdict::kSolved) = made.solved;
    count(Claim::kSolved, Verdict::kWrong) = made.wrong;
    count(Claim::kIterationLimit, Verdict::kUnsolvable) = made.unsolvable;
    count(Claim::kUnsupported, Verdict::kRefused) = made.refused;
    cell.solved = made.solved;
    cell.unsolvable_problems = made.unsolvable;
    if (made.refused > 0) cell.refusal = "no licence for this size";
    count(Claim::kIterationLimit, Verdict::kOpen) =
        made.trials - made.solved - made.wrong - made.unsolvable - made.refused;
    cell.criterion = made.criterion;
    cell.criterion_any = made.criterion + made.unclaimed;
    cell.all_time = spread_of(made.trials, made.time_s);
    cell.solved_time = spread_of(made.solved, made.time_s);
    cell.criterion_time = spread_of(made.criterion, made.time_s);
    cell.violation = spread_of(made.solved, made.violation);
    cell.criterion_violation = spread_of(made.criterion, made.violation);
    cell.criterion_any_time = spread_of(cell.criterion_any, made.time_s);
    cell.criterion_any_violation = spread_of(cell.criterion_any, made.violation);
    for (Part& half : cell.halves) {
      half = {.trials = made.trials / 2,
              .solved = made.solved / 2,
              .unsolvable_problems = made.unsolvable / 2,
              .criterion = made.criterion / 2,
              .criterion_any = cell.criterion_any / 2};
      half.all_time = spread_of(half.trials, made.time_s);
      half.solved_time = spread_of(half.solved, made.time_s);
      half.criterion_time = spread_of(half.criterion, made.time_s);
      half.violation = spread_of(half.solved, made.violation);
      half.criterion_violation = spread_of(half.criterion, made.violation);
    }
    summary.cells.push_back(std::move(cell));
  }

  std::size_t index_of(const std::string& set) {
    for (std::size_t i = 0; i < summary.sets.size(); ++i) {
      if (summary.sets[i].name == set) return i;
    }
    SetSummary made;
    made.name = set;
    made.contact = true;
    made.frictional = set.find("copositive") != std::string::npos;
    summary.sets.push_back(made);
    return summary.sets.size() - 1;
  }
};

/// The rows of a query on the paper's tables of a made summary. Outcomes become rows of the store's tables.
inline nlohmann::ordered_json ask(const Summary& summary, const std::string& sql) {
  MadeSummary example;  // tells the columns of tables without rows
  example.flat("paper/monotone/exp1", "lemke", 1);
  sqlite::Database database("made", sqlite::Mode::kInMemory);
  report::add_statistics_functions(database);
  const auto records_of = [](const Summary& made) {
    nlohmann::ordered_json records = paper::paper_records(made);
    records["cells"] = summary_json(made)["cells"];
    for (std::size_t i = 0; i < made.cells.size(); ++i) {
      records["cells"][i]["refusal"] = made.cells[i].refusal;
      records["cells"][i]["label"] = made.solvers[made.cells[i].solver].text();
    }
    return records;
  };
  const nlohmann::ordered_json all = records_of(summary);
  const nlohmann::ordered_json examples = records_of(example.summary);
  for (const auto& [name, records] : all.items()) report::fill_table(database, name, records, examples[name][0]);
  database.execute(
      "CREATE TABLE sets (id INTEGER PRIMARY KEY, name TEXT); CREATE TABLE problems (id INTEGER PRIMARY KEY, set_id, "
      "seed, "
      "trial, UNIQUE (set_id, seed, trial)); CREATE TABLE solvers (id INTEGER PRIMARY KEY, name, settings, library, "
      "version, isa, sweep); CREATE TABLE judged (problem_id, solver_id, claim, truth, verdict, PRIMARY KEY "
      "(problem_id, "
      "solver_id))");
  for (std::size_t i = 0; i < summary.sets.size(); ++i) {
    sqlite::Statement(database, "INSERT INTO sets VALUES (?, ?)").run(i, std::string_view(summary.sets[i].name));
  }
  for (std::size_t i = 0; i < summary.solvers.size(); ++i) {
    const SolverRow& row = summary.solvers[i];
    sqlite::Statement(database, "INSERT INTO solvers VALUES (?, ?, ?, ?, ?, ?, ?)")
        .run(i, std::string_view(row.name), std::string_view(row.settings), std::string_view(row.library),
             std::string_view(row.version), std::string_view(row.isa), std::string_view(row.sweep));
  }
  sqlite::Statement problem(database, "INSERT OR IGNORE INTO problems (set_id, seed, trial) VALUES (?, ?, ?)");
  sqlite::Statement answer(database,
                           "INSERT INTO judged SELECT id, ?, ?, 'unknown', ? FROM problems "
                           "WHERE set_id = ? AND seed = ? AND trial = ?");
  for (const Cell& cell : summary.cells) {
    for (const Outcome& outcome : cell.outcomes) {
      const std::uint32_t seed = outcome.problem / kTrialsOfASeed;
      const std::uint32_t trial = outcome.problem % kTrialsOfASeed;
      problem.run(cell.set, seed, trial);
      answer.run(cell.solver, std::string_view(outcome.refused() ? "unsupported" : "solved"),
                 std::string_view(outcome.solved() ? "solved" : "open"), cell.set, seed, trial);
    }
  }
  database.execute("CREATE TABLE pairs (\"set\", a, b, both_took, both_unsolvable, only_a, only_b)");
  report::Statistics statistics;
  for (std::size_t set = 0; set < summary.sets.size(); ++set) {
    std::vector<Cell> cells;
    std::size_t problems = 0;
    for (const Cell& cell : summary.cells) {
      if (cell.set != set) continue;
      cells.push_back(cell);
      for (const Outcome& outcome : cell.outcomes) problems = std::max<std::size_t>(problems, outcome.problem + 1);
    }
    const auto name = [&](const Cell& cell) { return summary.solvers[cell.solver].text(); };
    std::stable_sort(cells.begin(), cells.end(),
                     [&](const Cell& a, const Cell& b) { return natural_less(name(a), name(b)); });
    report::add_statistics(summary, problems, cells, statistics);
  }
  sqlite::Statement pair(database, "INSERT INTO pairs VALUES (?, ?, ?, ?, ?, ?, ?)");
  for (const report::PairStatistics& each : statistics.pairs) {
    pair.run(std::string_view(summary.sets[each.set].name), std::string_view(summary.solvers[each.a].text()),
             std::string_view(summary.solvers[each.b].text()), each.both_took, each.both_unsolvable, each.at[0].only_a,
             each.at[0].only_b);
  }
  database.execute(std::string(paper::kQueries));
  return report::records_of(report::run_query(database, "made", sql));
}

/// The rows of one of the report's tables, by a made summary alone.
inline nlohmann::ordered_json rows_of(const Summary& summary, const std::string& table) {
  for (const report::TableQuery& query : report::kTableQueries) {
    if (query.name == table) return ask(summary, std::string(query.sql));
  }
  throw std::logic_error("no table " + table);
}

}  // namespace lcpbench
