#include "study/store/store.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <sqlite3.h>

#include "core/error.h"
#include "study/store/answer_scan.h"
#include "study/store/row_checksum.h"
#include "study/store/schema.h"
#include "study/store/store_check.h"
#include "study/store/store_files.h"
#include "study/store/totals.h"
#include "study/store/vector_codec.h"

namespace lcpbench {
namespace {

using sqlite::Database;
using sqlite::Mode;
using sqlite::Statement;

constexpr const char* kSolverColumnNames = "name, settings, all_settings, library, version, isa, sweep";

/// @returns the column after them
int read_solver(const Statement& row, int column, SolverRow& solver) {
  return row.read(column, solver.name, solver.settings, solver.all_settings, solver.library, solver.version, solver.isa,
                  solver.sweep);
}

std::vector<SolverRow> read_cells(Database& database, std::int64_t solver_id, const SolverRow& solver) {
  Statement query(database,
                  "SELECT settings, all_settings, friction FROM parameterisations WHERE solver_id = ? ORDER BY cell");
  query.bind_all(solver_id);
  std::vector<SolverRow> cells;
  while (query.step()) {
    SolverRow& cell = cells.emplace_back(solver);
    query.read(0, cell.settings, cell.all_settings);
    cell.friction = friction_model_of(query.text(2));
  }
  return cells;
}

/// Answers of two solvers, or over two grids, under one id would be taken for answers of one.
void check_same_solver(Database& database, const SolverRow& solver, const std::vector<SolverRow>& cells) {
  Statement stored(database, fmt::format("SELECT {}, cells FROM solvers WHERE id = ?", kSolverColumnNames));
  stored.bind_all(solver.id());
  stored.step();
  SolverRow known;
  const int next_column = read_solver(stored, 0, known);
  known.friction = solver.friction;  // which the cells have
  const char* difference = nullptr;
  if (known != solver) {
    difference = "defaults";
  } else if (stored.integer(next_column) != std::ssize(cells) || read_cells(database, solver.id(), solver) != cells) {
    difference = solver.sweep.empty() ? "defaults" : "grid values";
  }
  if (difference == nullptr) return;
  throw InputError(fmt::format("{}: the store knows {}'{}' with other {}; use another store, or --fresh",
                               database.file().string(), solver.sweep.empty() ? "" : "sweep '" + solver.sweep + "' of ",
                               solver.text(), difference));
}

/// Returns the result of `read`, and puts the store's name into the message of its InputError. The message quotes the
/// store's content, which may have any length in a damaged store.
template <class Read>
auto from_store(const Database& store, Read read) {
  try {
    return read();
  } catch (const InputError& error) {
    constexpr std::size_t kShown = 200;
    const std::string complaint = error.what();
    throw InputError(store.file().string() + ": " + complaint.substr(0, kShown) +
                     (complaint.size() > kShown ? "..." : ""));
  }
}

}  // namespace

Claim stored_claim(const Database& store, std::string_view word) {
  return from_store(store, [&] { return parse_claim(word); });
}

std::int64_t SolverRow::id() const { return key_id({"solver", name, settings, library, version, isa, sweep}); }
std::string SolverRow::text() const { return settings.empty() ? name : name + "{" + settings + "}"; }

std::int64_t set_id(const std::string& set_name) { return key_id({"set", set_name}); }

std::int64_t ProblemResult::cells() const {
  std::int64_t total = 0;
  for (const AnswerRow& answer : answers) total += static_cast<std::int64_t>(answer.cells.size());
  return total;
}

std::int64_t problem_id(const std::string& set_name, std::uint64_t seed, std::int64_t trial) {
  return key_id({"problem", set_name, std::to_string(seed), std::to_string(trial)});
}

namespace {

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

/// Writes problems and the answers to them into a store, with statements that are prepared once.
class ProblemWriter {
 public:
  explicit ProblemWriter(Database& database)
      : database_(database),
        problem_(database, sqlite::insert_new("problems", "id, set_id, seed, trial, kind, n, ngc, nc, free_bodies, "
                                                          "hash, theory, notes")),
        stored_problem_(database,
                        "SELECT p.hash, s.name FROM problems p JOIN sets s ON s.id = p.set_id WHERE p.id = ?"),
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

  /// Store::add. @param run_id  the run that the timings belong to
  void add(const ProblemResult& result, std::int64_t run_id) {
    const ProblemRow& problem = result.problem;
    problem_.run(problem.id, problem.set_id, problem.seed, problem.trial, problem.kind, problem.n, problem.ngc,
                 problem.nc, problem.free_bodies, problem.hash, problem.theory, problem.notes);
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

 private:
  void add_answer(std::int64_t problem_id, std::int64_t run_id, const AnswerRow& row) {
    const std::uint32_t part = row.cells.front();  // key: the lowest cell that gave this answer
    const Counters& counters = row.counters;
    answer_.run(problem_id, row.solver_id, part, add_group(stored_group_, group_, row.cells), to_string(row.claim),
                row.z, row.velocity, row.farkas, counters.iterations, counters.pivots, counters.factorizations,
                row.detail);

    const Errors& errors = row.errors;
    // NULL: there is no worst row; -1: unresolved. See the schema.
    const auto worst_row = errors.worst.row < 0 && !errors.unresolved ? std::nullopt : std::optional(errors.worst.row);
    verdict_.bind_all(problem_id, row.solver_id, part, errors.usable, errors.solved, errors.criterion,
                      row.farkas_checked, worst_row);
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

  Database& database_;
  Statement problem_;
  Statement stored_problem_;
  Statement vector_;
  Statement group_;
  Statement stored_group_;
  Statement stored_answers_;  ///< asks for part 0, which every solver that ran has
  Statement answer_;
  Statement verdict_;
  Statement timing_;
};

struct Store::Data {
  Data(const std::filesystem::path& file, Mode mode) : database(file, mode) {}

  std::unique_ptr<FileLock> lock;  // first in, last out: the database is closed before the lock ends
  Database database;
  std::unique_ptr<ProblemWriter> writer;
  std::unique_ptr<Statement> done;
  std::int64_t run = 0;
  std::string notice;
};

namespace {

/// A writer that was killed leaves its row in the table `writing`, and its last rows in the write-ahead log, which
/// SQLite takes up to the first transaction that is not what was written.
/// @param log  there was a log before the store was opened
/// @returns what to tell the user, "" for nothing
std::string lost_rows(Database& database, bool log) {
  Statement mode(database, "PRAGMA journal_mode");
  if (!mode.step() || mode.text(0) != "wal") return "";
  Statement writer(database, "SELECT since FROM writing");
  if (!writer.step()) return "";
  return fmt::format("{0}: the writer that opened it at {1} never closed it{2}: its last rows may be missing",
                     database.file().string(), writer.text(0),
                     log ? "" : fmt::format(", and {}-wal is not beside the store", database.file().string()));
}

void check_all(Database& database, const Waiting& waiting) {
  std::error_code ignored;
  const bool is_large = std::filesystem::file_size(database.file(), ignored) >= waiting.tell_bytes;
  if (is_large && waiting.tell) waiting.tell("reading and checking every row of " + database.file().string());
  check_content(database);
}

/// From now on the store can be read while it is written. The change itself needs a moment without readers.
void begin_log(Database& database, const Waiting& waiting) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kRetryAfter = std::chrono::milliseconds(50);
  const Clock::time_point begin = Clock::now();
  bool told = false;
  // In short tries, since nobody can begin to read while SQLite itself waits.
  while (!database.execute_unless_locked("PRAGMA journal_mode = WAL")) {
    const auto waited = Clock::now() - begin;
    if (waited >= waiting.reader_patience) {
      throw InputError(
          fmt::format("{}: another process has been reading this store for {} s; try again when it has ended",
                      database.file().string(), std::chrono::round<std::chrono::seconds>(waited).count()));
    }
    if (!told && waiting.tell && waited >= waiting.tell_after) {
      waiting.tell(fmt::format("waiting for another process that reads {}", database.file().string()));
      told = true;
    }
    std::this_thread::sleep_for(kRetryAfter);
  }
}

void mark_as_being_written(Database& database) {
  database.execute("INSERT OR REPLACE INTO writing (id, since) VALUES (1, strftime('%Y-%m-%dT%H:%M:%SZ', 'now'))");
}

}  // namespace

Store::Store(std::unique_ptr<Data> data) : data_(std::move(data)) {}
Store::Store(Store&&) noexcept = default;

Store::~Store() {
  if (data_ == nullptr || data_->writer == nullptr) return;
  data_->writer.reset();
  data_->done.reset();
  // A store at rest is one plain file, readable also from a read-only folder. It stays in WAL mode when someone reads
  // it.
  try {
    if (sqlite3_get_autocommit(data_->database.handle()) == 0) data_->database.execute("ROLLBACK");
    data_->database.execute("DELETE FROM writing");
    data_->database.execute("PRAGMA journal_mode = DELETE");
  } catch (const std::exception&) {
    return;
  }
}

Store Store::open_for_writing(const std::filesystem::path& file, const Waiting& waiting) {
  refuse_folder(file);
  std::error_code ignored;
  if (has_log(file) && (!std::filesystem::exists(file, ignored) || std::filesystem::file_size(file, ignored) == 0)) {
    throw InputError(side_file(file, "-wal").string() + " holds rows of a store that is not here; move one of the two");
  }
  auto lock = std::make_unique<FileLock>(file);
  refuse_other_names(file);
  const bool log = has_log(file);
  auto data = std::make_unique<Data>(file, Mode::kReadWriteCreate);
  data->lock = std::move(lock);
  Database& database = data->database;
  database.execute("PRAGMA synchronous = NORMAL");
  if (is_blank(database)) {
    initialise(database);
  } else {
    check_format(database);
    data->notice = lost_rows(database, log);
    check_all(database, waiting);
  }
  begin_log(database, waiting);
  mark_as_being_written(database);
  database.execute("PRAGMA wal_checkpoint(PASSIVE)");  // the file itself, without its log, says that it is written
  keep_totals(database);
  data->writer = std::make_unique<ProblemWriter>(database);
  return Store(std::move(data));
}

Store Store::open_for_reading(const std::filesystem::path& file) {
  refuse_folder(file);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) throw InputError(file.string() + ": no such store");
  roll_back_journal(file);
  const bool log = has_log(file);
  const bool written = FileLock::is_held(file);
  auto data = std::make_unique<Data>(file, Mode::kReadOnly);
  if (is_blank(data->database)) throw InputError(file.string() + ": is empty: no run has kept anything in it");
  check_format(data->database);
  if (!written) data->notice = lost_rows(data->database, log);
  return Store(std::move(data));
}

void Store::remove(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return;
  refuse_folder(file);
  const FileLock lock(file);
  if (!begins_as_store(file)) {
    roll_back_journal(file);
    Database database(file, Mode::kReadOnly);
    if (!is_blank(database)) check_application(database);
  }
  remove_side_files(file);  // first: side files without a store would be taken for those of the next one
  std::filesystem::remove(followed(file));
}

const std::string& Store::notice() const { return data_->notice; }
void Store::check(const Waiting& waiting) { check_all(data_->database, waiting); }

void Store::begin() { data_->database.execute("BEGIN IMMEDIATE"); }
void Store::commit() { data_->database.execute("COMMIT"); }

void Store::add_run(const std::string& started, const std::string& provenance) {
  data_->run = key_id({"run", started, provenance});
  Statement(data_->database, sqlite::insert_new("runs", "id, started, provenance"))
      .run(data_->run, started, provenance);
}

std::int64_t Store::add_set(const std::string& name) {
  const std::int64_t id = set_id(name);
  Statement(data_->database, sqlite::insert_new("sets", "id, name")).run(id, name);
  return id;
}

std::int64_t Store::add_solver(const SolverRow& solver, const std::vector<SolverRow>& sweep) {
  const std::int64_t id = solver.id();
  const std::vector<SolverRow> cells = sweep.empty() ? std::vector<SolverRow>{solver} : sweep;
  Statement insert(data_->database,
                   sqlite::insert_new("solvers", std::string("id, ") + kSolverColumnNames + ", cells"));
  insert.run(id, solver.name, solver.settings, solver.all_settings, solver.library, solver.version, solver.isa,
             solver.sweep, cells.size());
  Statement insert_cell(data_->database,
                        sqlite::insert_new("parameterisations", "solver_id, cell, settings, all_settings, friction"));
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    insert_cell.run(id, cell, cells[cell].settings, cells[cell].all_settings,
                    to_string(cells[cell].friction));
  }
  check_same_solver(data_->database, solver, cells);
  return id;
}

void Store::add(const ProblemResult& result) { data_->writer->add(result, data_->run); }

std::vector<std::int64_t> Store::done(std::int64_t problem_id) {
  if (data_->done == nullptr) {
    data_->done = std::make_unique<Statement>(
        data_->database, "SELECT solver_id FROM answers WHERE problem_id = ? AND part = 0 ORDER BY 1");
  }
  data_->done->bind_all(problem_id);
  std::vector<std::int64_t> solvers;
  while (data_->done->step()) solvers.push_back(data_->done->integer(0));
  data_->done->reset();
  return solvers;
}

std::int64_t Store::cell_count() {
  return data_->database.integer(
      "SELECT IFNULL(SUM(s.cells), 0) FROM answers a JOIN solvers s ON s.id = a.solver_id WHERE a.part = 0");
}

std::vector<std::pair<std::int64_t, std::string>> Store::sets() {
  Statement query(data_->database, "SELECT id, name FROM sets ORDER BY name");
  std::vector<std::pair<std::int64_t, std::string>> rows;
  while (query.step()) rows.emplace_back(query.integer(0), query.text(1));
  return rows;
}

std::vector<StoredSolver> Store::solvers() {
  Statement query(data_->database, fmt::format("SELECT id, {0} FROM solvers ORDER BY {0}, id", kSolverColumnNames));
  std::vector<StoredSolver> rows;
  while (query.step()) {
    StoredSolver& solver = rows.emplace_back();
    solver.id = query.integer(0);
    read_solver(query, 1, solver.row);
    solver.cells = read_cells(data_->database, solver.id, solver.row);
    if (solver.row.sweep.empty() && !solver.cells.empty()) solver.row.friction = solver.cells.front().friction;
  }
  return rows;
}

std::vector<std::string> Store::runs() {
  return data_->database.texts("SELECT provenance FROM runs WHERE started <> '' ORDER BY started, id");
}

void Store::for_each_answer(const std::function<void(const StoredAnswer&)>& visit,
                            const std::optional<std::int64_t>& set_id) {
  AnswerScan(*this).read(set_id, [&](const AnsweredProblem& problem) {
    for (const StoredAnswer& answer : problem.answers) visit(answer);
  });
}

std::optional<Answer> Store::answer(std::int64_t problem_id, std::int64_t solver_id, std::uint32_t cell) {
  Statement query(data_->database,
                  "SELECT claim, iterations, pivots, factorizations, detail, a.z, z.data, a.velocity, velocity.data, "
                  "a.farkas, farkas.data FROM answers a "
                  "JOIN cell_groups g ON g.group_id = a.group_id AND g.cell = ? "
                  "LEFT JOIN vectors z ON z.id = a.z LEFT JOIN vectors velocity ON velocity.id = a.velocity "
                  "LEFT JOIN vectors farkas ON farkas.id = a.farkas WHERE problem_id = ? AND solver_id = ?");
  query.bind_all(cell, problem_id, solver_id);
  if (!query.step()) return std::nullopt;
  Answer answer;
  answer.claim = stored_claim(data_->database, query.text(0));
  answer.counters = {query.integer(1), query.integer(2), query.integer(3)};
  answer.detail = query.text(4);
  int column = 5;
  for (Vector* vector : {&answer.z, &answer.velocity, &answer.farkas}) {
    const int id = column++;
    const std::string_view data = query.blob(column++);
    if (query.is_null(id)) continue;
    if (content_id(data) != query.integer(id)) {
      throw InputError(fmt::format("{}: the store is damaged: table vectors, row id={}: not what was written",
                                   file().string(), query.integer(id)));
    }
    *vector = from_store(data_->database, [&] { return decode_vector(data); });
  }
  return answer;
}

const std::filesystem::path& Store::file() const { return data_->database.file(); }
sqlite::Database& Store::database() { return data_->database; }

}  // namespace lcpbench
