#include "study/store/problem_writer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "study/store/row_checksum.h"
#include "study/store/schema.h"
#include "study/store/store_check.h"

namespace lcpbench {
namespace {

using sqlite::Database;
using sqlite::Statement;

/// @throws InputError when the store has another problem under this id: answers to both would be judged together.
void check_same_problem(Statement& stored, const ProblemRow& problem, const std::filesystem::path& file) {
  stored.bind_all(problem.id);
  if (stored.step() && stored.text(0) != problem.hash) {
    throw InputError(
        fmt::format("{}: trial {} of seed {} of set '{}' is another problem than when the store was begun: the set has "
                    "changed; use another store, or --fresh",
                    file.string(), problem.trial, problem.seed, stored.text(1)));
  }
  stored.reset();
}

/// Whether a query with two integer parameters finds a row. Leaves it reset.
bool is_present(Statement& query, std::int64_t first_key, std::int64_t second_key) {
  query.bind_all(first_key, second_key);
  const bool present = query.step();
  query.reset();
  return present;
}

/// Stores a group, the cells that gave the same answer, unless the store has it already. @returns its id
std::int64_t add_group(Statement& stored, Statement& insert, const std::vector<std::uint32_t>& cells) {
  const std::int64_t id = cell_group_id(cells);
  if (is_present(stored, id, static_cast<std::int64_t>(cells.front()))) return id;
  for (const std::uint32_t cell : cells) insert.run(id, cell);
  return id;
}

}  // namespace

ProblemWriter::ProblemWriter(Database& database)
    : database_(database),
      problem_(database,
               sqlite::insert_new("problems", "id, set_id, seed, trial, kind, n, ngc, nc, free_bodies, hash, theory")),
      stored_problem_(database, "SELECT p.hash, s.name FROM problems p JOIN sets s ON s.id = p.set_id WHERE p.id = ?"),
      vector_(database, "INSERT OR IGNORE INTO vectors (id, data) VALUES (?, ?)"),
      group_(database, "INSERT OR IGNORE INTO cell_groups (group_id, cell) VALUES (?, ?)"),
      stored_group_(database, "SELECT 1 FROM cell_groups WHERE group_id = ? AND cell = ?"),
      stored_answers_(database, "SELECT 1 FROM answers WHERE problem_id = ? AND solver_id = ? AND part = 0"),
      answer_(database, sqlite::insert_row("INSERT", "answers",
                                           "problem_id, solver_id, part, group_id, claim, z, velocity, farkas, "
                                           "iterations, pivots, factorizations, detail")),
      verdict_(database, sqlite::insert_row("INSERT", "verdicts",
                                            "problem_id, solver_id, part, usable, solved, criterion, farkas_checked, "
                                            "worst_row, " + metric_columns())),
      timing_(database, sqlite::insert_row("INSERT", "timings",
                                           "problem_id, solver_id, part, run_id, setup_wall_s, setup_cpu_s, "
                                           "solve_wall_s, solve_cpu_s, transport_s, verify_s, repeats")) {}

void ProblemWriter::add_answer(std::int64_t problem_id, std::int64_t run_id, const AnswerRow& row) {
  const std::uint32_t part = row.cells.front();  // key: the lowest cell that gave this answer
  const Counters& counters = row.counters;
  answer_.run(problem_id, row.solver_id, part, add_group(stored_group_, group_, row.cells), to_string(row.claim), row.z,
              row.velocity, row.farkas, counters.iterations, counters.pivots, counters.factorizations, row.detail);

  const Errors& errors = row.errors;
  // NULL: there is no worst row; -1: unresolved. See the schema.
  const auto worst_row =
      errors.worst.row < 0 && !errors.unresolved ? std::nullopt : std::optional(errors.worst.row);
  verdict_.bind_all(problem_id, row.solver_id, part, errors.usable, errors.solved, errors.criterion, row.farkas_checked,
                    worst_row);
  int parameter = 9;  // the first after the eight that are bound
  for (const Metric& metric : kMetrics) {
    if (metric.stored) verdict_.bind(parameter++, errors.*metric.value);
  }
  verdict_.run();

  const SolveTimes& times = row.times;
  if (std::isnan(times.solve_cpu_s)) return;  // nobody measured it: no row
  timing_.run(problem_id, row.solver_id, part, run_id, times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s,
              times.solve_cpu_s, times.transport_s, row.verify_s, times.repeats);
}

void ProblemWriter::add(const ProblemResult& result, std::int64_t run_id) {
  const ProblemRow& problem = result.problem;
  problem_.run(problem.id, problem.set_id, problem.seed, problem.trial, problem.kind, problem.n, problem.ngc,
               problem.nc, problem.free_bodies, problem.hash, problem.theory);
  check_same_problem(stored_problem_, problem, database_.file());

  for (const auto& [id, bytes] : result.vectors) vector_.run(id, sqlite::Blob{bytes});

  // Answers are added for solvers that had none before this call: the cells of two calls could overlap.
  std::vector<std::int64_t> present;
  for (const AnswerRow& row : result.answers) {
    if (is_present(stored_answers_, problem.id, row.solver_id)) present.push_back(row.solver_id);
  }
  for (const AnswerRow& row : result.answers) {
    if (std::find(present.begin(), present.end(), row.solver_id) == present.end()) {
      add_answer(problem.id, run_id, row);
    }
  }
}

}  // namespace lcpbench
