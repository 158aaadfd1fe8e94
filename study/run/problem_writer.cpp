#include "study/run/problem_writer.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "study/store/row_checksum.h"
#include "study/store/store_check.h"
#include "study/store/store_columns.h"

namespace lcpbench {
namespace {

using sqlite::Database;
using sqlite::Statement;

std::string insert_new(const char* table, const std::string& columns) {
  return sqlite::insert_row("INSERT OR IGNORE", table, columns);
}

/// For rows that are not there yet. IGNORE would also drop a row that breaks a rule of its table, such as a time that
/// is not a number.
std::string insert_into(const char* table, const std::string& columns) {
  return sqlite::insert_row("INSERT", table, columns);
}

void bind_id(Statement& statement, int parameter, const std::optional<std::int64_t>& id) {
  if (id) {
    statement.bind(parameter, *id);
  } else {
    statement.bind_null(parameter);
  }
}

/// Answers to two problems under one id would be judged as answers to one: what is stored must be what was solved.
void check_same_problem(Statement& stored, const ProblemRow& problem, const std::filesystem::path& file) {
  stored.bind(1, problem.id);
  if (stored.step() && stored.text(0) != problem.hash) {
    throw InputError(
        fmt::format("{}: trial {} of seed {} of set '{}' is another problem than when the store was begun: the set has "
                    "changed; use "
                    "another store, or --fresh",
                    file.string(), problem.trial, problem.seed, stored.text(1)));
  }
  stored.reset();
}

std::int64_t as_integer(bool value) { return value ? 1 : 0; }

bool is_present(Statement& query, std::int64_t first_key, std::int64_t second_key) {
  query.bind(1, first_key);
  query.bind(2, second_key);
  const bool present = query.step();
  query.reset();
  return present;
}

/// Most groups are met again and again.
std::int64_t add_group(Statement& stored, Statement& insert, const std::vector<std::uint32_t>& cells) {
  const std::int64_t id = cell_group_id(cells);
  if (is_present(stored, id, static_cast<std::int64_t>(cells.front()))) return id;
  for (const std::uint32_t cell : cells) {
    insert.bind(1, id);
    insert.bind(2, static_cast<std::int64_t>(cell));
    insert.run();
  }
  return id;
}

void bind_key(Statement& statement, std::int64_t problem_id, const AnswerRow& row) {
  statement.bind(1, problem_id);
  statement.bind(2, row.solver_id);
  statement.bind(3, static_cast<std::int64_t>(row.cells.front()));
}

}  // namespace

struct ProblemWriter::Statements {
  explicit Statements(Database& database)
      : problem(database, insert_new("problems", "id, set_id, seed, trial, kind, n, ngc, nc, hash, theory")),
        stored_problem(database, "SELECT p.hash, s.name FROM problems p JOIN sets s ON s.id = p.set_id WHERE p.id = ?"),
        vector(database, "INSERT OR IGNORE INTO vectors (id, data) VALUES (?, ?)"),
        group(database, "INSERT OR IGNORE INTO cell_groups (group_id, cell) VALUES (?, ?)"),
        stored_group(database, "SELECT 1 FROM cell_groups WHERE group_id = ? AND cell = ?"),
        stored_answers(database, "SELECT 1 FROM answers WHERE problem_id = ? AND solver_id = ? AND part = 0"),
        answer(database, insert_into("answers",
                                     "problem_id, solver_id, part, group_id, claim, z, velocity, farkas, iterations, "
                                     "pivots, factorizations, detail")),
        verdict(database,
                insert_into("verdicts",
                            std::string("problem_id, solver_id, part, usable, solved, criterion, farkas_checked, "
                                        "worst_row, ") +
                                kErrorColumnNames)),
        timing(database,
               insert_into("timings", std::string("problem_id, solver_id, part, run_id, ") + kTimeColumnNames)) {}

  void add_answer(std::int64_t problem_id, std::int64_t run_id, const AnswerRow& row);

  Statement problem;
  Statement stored_problem;
  Statement vector;
  Statement group;
  Statement stored_group;
  Statement stored_answers;
  Statement answer;
  Statement verdict;
  Statement timing;
};

void ProblemWriter::Statements::add_answer(std::int64_t problem_id, std::int64_t run_id, const AnswerRow& row) {
  bind_key(answer, problem_id, row);
  answer.bind(4, add_group(stored_group, group, row.cells));
  answer.bind(5, std::string_view(to_string(row.claim)));
  bind_id(answer, 6, row.z);
  bind_id(answer, 7, row.velocity);
  bind_id(answer, 8, row.farkas);
  answer.bind(9, row.counters.iterations);
  answer.bind(10, row.counters.pivots);
  answer.bind(11, row.counters.factorizations);
  answer.bind(12, row.detail);
  answer.run();

  bind_key(verdict, problem_id, row);
  verdict.bind(4, as_integer(row.errors.usable));
  verdict.bind(5, as_integer(row.errors.solved));
  verdict.bind(6, as_integer(row.errors.criterion));
  verdict.bind(7, as_integer(row.farkas_checked));
  bind_id(verdict, 8, row.errors.worst.row < 0 ? std::nullopt : std::optional<std::int64_t>(row.errors.worst.row));
  int parameter = 9;
  for (const auto column : kErrorColumns) verdict.bind(parameter++, row.errors.*column);
  verdict.run();

  bind_key(timing, problem_id, row);
  timing.bind(4, run_id);
  parameter = 5;
  for (const auto column : kTimeColumns) timing.bind(parameter++, row.times.*column);
  timing.bind(parameter++, row.verify_s);
  timing.bind(parameter, static_cast<std::int64_t>(row.times.repeats));
  timing.run();
}

ProblemWriter::ProblemWriter(Database& database)
    : database_(database), statements_(std::make_unique<Statements>(database)) {}
ProblemWriter::~ProblemWriter() = default;

void ProblemWriter::add(const ProblemResult& result, std::int64_t run_id) {
  Statements& to = *statements_;
  const ProblemRow& problem = result.problem;
  to.problem.bind(1, problem.id);
  to.problem.bind(2, problem.set_id);
  to.problem.bind(3, static_cast<std::int64_t>(problem.seed));
  to.problem.bind(4, problem.trial);
  to.problem.bind(5, problem.kind);
  to.problem.bind(6, problem.n);
  to.problem.bind(7, problem.ngc);
  to.problem.bind(8, problem.nc);
  to.problem.bind(9, problem.hash);
  to.problem.bind(10, problem.theory);
  to.problem.run();
  check_same_problem(to.stored_problem, problem, database_.file());

  for (const auto& [id, bytes] : result.vectors) {
    to.vector.bind(1, id);
    to.vector.bind_blob(2, bytes);
    to.vector.run();
  }

  // All answers of a solver to a problem come from one sitting: parts of two could overlap.
  std::vector<std::int64_t> present;
  for (const AnswerRow& row : result.answers) {
    if (is_present(to.stored_answers, problem.id, row.solver_id)) present.push_back(row.solver_id);
  }
  for (const AnswerRow& row : result.answers) {
    if (std::find(present.begin(), present.end(), row.solver_id) == present.end()) {
      to.add_answer(problem.id, run_id, row);
    }
  }
}

}  // namespace lcpbench
