#include "study/store.h"

#include <algorithm>
#include <array>
#include <system_error>

#include <fmt/format.h>

#include "core/error.h"
#include "study/file_lock.h"
#include "study/schema.h"
#include "study/vector_codec.h"

namespace lcpbench {
namespace {

using sqlite::Database;
using sqlite::Mode;
using sqlite::Statement;

constexpr std::int64_t kApplicationId = 0x4c43'5042;  // "LCPB", in the header of the file
/// Rises with what a verdict means, too: answers judged by two definitions must not meet in one store.
constexpr std::int64_t kFormatVersion = 4;

std::int64_t key_id(std::initializer_list<std::string_view> parts) {
  std::string key;
  for (const std::string_view part : parts) {
    key += part;
    key += '\0';
  }
  return content_id(key);
}

std::string describe(const std::filesystem::path& file, const char* what) { return file.string() + ": " + what; }

/// True when the file holds nothing yet: also one whose process was killed before its first commit.
bool is_blank(Database& database) { return database.integer("SELECT COUNT(*) FROM sqlite_master") == 0; }

void check_application(Database& database) {
  if (database.integer("PRAGMA application_id") != kApplicationId) {
    throw InputError(describe(database.file(), "not an lcpbench store"));
  }
}

void check_format(Database& database) {
  check_application(database);
  const std::int64_t version = database.integer("PRAGMA user_version");
  if (version != kFormatVersion) {
    throw InputError(
        fmt::format("{}: store format {}, this lcpbench reads format {} alone: verdicts mean something else there; use "
                    "another store (`run --fresh` replaces it)",
                    database.file().string(), version, kFormatVersion));
  }
}

/// What is no file at all would be told by SQLite in words that name no cause.
void refuse_folder(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) throw InputError(describe(file, "is a folder, expected a store"));
}

/// Makes a blank file a store, whole or not at all.
void initialise(Database& database) {
  database.execute("BEGIN IMMEDIATE");
  database.execute(kStoreSchema);
  database.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, kFormatVersion));
  database.execute("COMMIT");
}

Truth parse_truth(std::string_view text) {
  if (text == "solvable") return Truth::kSolvable;
  return text == "unsolvable" ? Truth::kUnsolvable : Truth::kUnknown;
}

constexpr std::array kErrorColumns{&Errors::velocity_residual_m_per_s,
                                   &Errors::velocity_residual_relative,
                                   &Errors::natural_residual,
                                   &Errors::backward_componentwise,
                                   &Errors::backward_row_norm,
                                   &Errors::forward_velocity,
                                   &Errors::violation_m_per_s,
                                   &Errors::work_gain_j,
                                   &Errors::complementarity_j,
                                   &Errors::cone_violation,
                                   &Errors::min_z};

constexpr const char* kErrorColumnNames =
    "velocity_residual_m_per_s, velocity_residual_relative, natural_residual, backward_componentwise, "
    "backward_row_norm, forward_velocity, violation_m_per_s, work_gain_j, complementarity_j, cone_violation, min_z";

constexpr std::array kTimeColumns{&SolveTimes::setup_wall_s, &SolveTimes::setup_cpu_s, &SolveTimes::solve_wall_s,
                                  &SolveTimes::solve_cpu_s, &SolveTimes::transport_s};

constexpr const char* kTimeColumnNames =
    "setup_wall_s, setup_cpu_s, solve_wall_s, solve_cpu_s, transport_s, verify_s, repeats";

constexpr std::array kSolverColumns{&SolverRow::name,    &SolverRow::settings, &SolverRow::all_settings,
                                    &SolverRow::library, &SolverRow::version,  &SolverRow::isa,
                                    &SolverRow::sweep};

constexpr const char* kSolverColumnNames = "name, settings, all_settings, library, version, isa, sweep";

constexpr std::array kCellColumns{&Parameterisation::settings, &Parameterisation::all_settings};

SolverRow read_solver(const Statement& row, int column) {
  SolverRow solver;
  for (const auto field : kSolverColumns) solver.*field = row.text(column++);
  return solver;
}

std::string insert_into(const char* table, const std::string& columns, int count) {
  std::string marks = "?";
  for (int i = 1; i < count; ++i) marks += ",?";
  return fmt::format("INSERT OR IGNORE INTO {} ({}) VALUES ({})", table, columns, marks);
}

struct Writers {
  explicit Writers(Database& database)
      : problem(database, insert_into("problems", "id, set_id, seed, trial, kind, n, ngc, nc, hash, theory", 10)),
        stored_problem(database, "SELECT p.hash, s.name FROM problems p JOIN sets s ON s.id = p.set_id WHERE p.id = ?"),
        vector(database, insert_into("vectors", "id, data", 2)),
        group(database, insert_into("cell_groups", "group_id, cell", 2)),
        stored_group(database, "SELECT 1 FROM cell_groups WHERE group_id = ? AND cell = ?"),
        stored_answers(database, "SELECT 1 FROM answers WHERE problem_id = ? AND solver_id = ? AND part = 0"),
        answer(database, insert_into("answers",
                                     "problem_id, solver_id, part, group_id, claim, z, velocity, farkas, iterations, "
                                     "pivots, factorizations, detail",
                                     12)),
        verdict(database,
                insert_into(
                    "verdicts",
                    std::string("problem_id, solver_id, part, usable, solved, criterion, farkas_checked, worst_row, ") +
                        kErrorColumnNames,
                    8 + static_cast<int>(kErrorColumns.size()))),
        timing(database,
               insert_into("timings", std::string("problem_id, solver_id, part, run_id, ") + kTimeColumnNames, 11)) {}

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
std::int64_t add_group(Writers& writers, const std::vector<std::uint32_t>& cells) {
  std::string key;
  for (const std::uint32_t cell : cells) key += fmt::format("{},", cell);
  const std::int64_t id = key_id({"group", key});
  if (is_present(writers.stored_group, id, static_cast<std::int64_t>(cells.front()))) return id;
  for (const std::uint32_t cell : cells) {
    writers.group.bind(1, id);
    writers.group.bind(2, static_cast<std::int64_t>(cell));
    writers.group.run();
  }
  return id;
}

void bind_key(Statement& statement, std::int64_t problem_id, const AnswerRow& row) {
  statement.bind(1, problem_id);
  statement.bind(2, row.solver_id);
  statement.bind(3, static_cast<std::int64_t>(row.cells.front()));
}

void add_answer(Writers& writers, std::int64_t problem_id, std::int64_t run_id, const AnswerRow& row) {
  Statement& answer = writers.answer;
  bind_key(answer, problem_id, row);
  answer.bind(4, add_group(writers, row.cells));
  answer.bind(5, std::string_view(to_string(row.claim)));
  bind_id(answer, 6, row.z);
  bind_id(answer, 7, row.velocity);
  bind_id(answer, 8, row.farkas);
  answer.bind(9, row.counters.iterations);
  answer.bind(10, row.counters.pivots);
  answer.bind(11, row.counters.factorizations);
  answer.bind(12, row.detail);
  answer.run();

  Statement& verdict = writers.verdict;
  bind_key(verdict, problem_id, row);
  verdict.bind(4, as_integer(row.errors.usable));
  verdict.bind(5, as_integer(row.errors.solved));
  verdict.bind(6, as_integer(row.errors.criterion));
  verdict.bind(7, as_integer(row.farkas_checked));
  bind_id(verdict, 8, row.errors.worst.row < 0 ? std::nullopt : std::optional<std::int64_t>(row.errors.worst.row));
  int parameter = 9;
  for (const auto column : kErrorColumns) verdict.bind(parameter++, row.errors.*column);
  verdict.run();

  Statement& timing = writers.timing;
  bind_key(timing, problem_id, row);
  timing.bind(4, run_id);
  parameter = 5;
  for (const auto column : kTimeColumns) timing.bind(parameter++, row.times.*column);
  timing.bind(parameter++, row.verify_s);
  timing.bind(parameter, static_cast<std::int64_t>(row.times.repeats));
  timing.run();
}

std::vector<Parameterisation> read_cells(Database& database, std::int64_t solver_id) {
  Statement query(database, "SELECT settings, all_settings FROM parameterisations WHERE solver_id = ? ORDER BY cell");
  query.bind(1, solver_id);
  std::vector<Parameterisation> cells;
  while (query.step()) cells.push_back({std::string(query.text(0)), std::string(query.text(1))});
  return cells;
}

/// Answers of two solvers, or over two grids, under one id would be taken for answers of one.
void check_same_solver(Database& database, const SolverRow& solver, const std::vector<Parameterisation>& cells) {
  Statement stored(database, fmt::format("SELECT {}, cells FROM solvers WHERE id = ?", kSolverColumnNames));
  stored.bind(1, solver.id());
  stored.step();
  const char* difference = nullptr;
  if (read_solver(stored, 0) != solver) {
    difference = "defaults";
  } else if (stored.integer(static_cast<int>(kSolverColumns.size())) != static_cast<std::int64_t>(cells.size()) ||
             read_cells(database, solver.id()) != cells) {
    difference = solver.sweep.empty() ? "defaults" : "grid values";
  }
  if (difference == nullptr) return;
  throw InputError(fmt::format("{}: the store knows {}'{}' with other {}; use another store, or --fresh",
                               database.file().string(), solver.sweep.empty() ? "" : "sweep '" + solver.sweep + "' of ",
                               solver.text(), difference));
}

/// What `read` makes of the store's content; its complaints get the store's name.
template <class Read>
auto from_store(const Database& store, Read read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw InputError(describe(store.file(), error.what()));
  }
}

}  // namespace

Claim stored_claim(const Database& store, std::string_view word) {
  return from_store(store, [&] { return parse_claim(word); });
}

Verdict stored_verdict(const Database& store, std::string_view word) {
  return from_store(store, [&] { return parse_verdict(word); });
}

std::int64_t SolverRow::id() const { return key_id({"solver", name, settings, library, version, isa, sweep}); }
std::string SolverRow::text() const { return settings.empty() ? name : name + "{" + settings + "}"; }

std::int64_t set_id(const std::string& set_name) { return key_id({"set", set_name}); }

std::int64_t ProblemResult::cells() const {
  std::int64_t total = 0;
  for (const AnswerRow& answer : answers) total += static_cast<std::int64_t>(answer.cells.size());
  return total;
}

SolverRow StoredSolver::cell(std::size_t number) const {
  SolverRow single = row;
  single.settings = cells.at(number).settings;
  single.all_settings = cells.at(number).all_settings;
  return single;
}

std::int64_t problem_id(const std::string& set_name, std::uint64_t seed, std::int64_t trial) {
  return key_id({"problem", set_name, std::to_string(seed), std::to_string(trial)});
}

struct Store::Data {
  Data(const std::filesystem::path& file, Mode mode) : database(file, mode) {}

  std::unique_ptr<FileLock> lock;  // first in, last out: the database is closed before the lock ends
  Database database;
  std::unique_ptr<Writers> writers;
  std::unique_ptr<Statement> done;
  std::int64_t run = 0;
};

Store::Store(std::unique_ptr<Data> data) : data_(std::move(data)) {}
Store::Store(Store&&) noexcept = default;

Store::~Store() {
  if (data_ == nullptr || data_->writers == nullptr) return;
  data_->writers.reset();
  data_->done.reset();
  // A store at rest is one plain file, readable also from a read-only folder. It stays in WAL mode when someone reads
  // it.
  try {
    data_->database.execute("PRAGMA journal_mode = DELETE");
  } catch (const std::exception&) {
    return;
  }
}

Store Store::open_for_writing(const std::filesystem::path& file) {
  refuse_folder(file);
  auto lock = std::make_unique<FileLock>(file);
  auto data = std::make_unique<Data>(file, Mode::kReadWriteCreate);
  data->lock = std::move(lock);
  Database& database = data->database;
  const bool blank = is_blank(database);
  if (!blank) check_format(database);
  database.execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL");
  if (blank) initialise(database);
  data->writers = std::make_unique<Writers>(database);
  return Store(std::move(data));
}

Store Store::open_for_reading(const std::filesystem::path& file) {
  refuse_folder(file);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) throw InputError(describe(file, "no such store"));
  auto data = std::make_unique<Data>(file, Mode::kReadOnly);
  check_format(data->database);
  return Store(std::move(data));
}

void Store::remove(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return;
  refuse_folder(file);
  const FileLock lock(file);
  {
    Database database(file, Mode::kReadOnly);
    if (!is_blank(database)) check_application(database);
  }
  for (const char* suffix : {"-wal", "-shm", ""}) std::filesystem::remove(file.string() + suffix);
}

void Store::begin() { data_->database.execute("BEGIN IMMEDIATE"); }
void Store::commit() { data_->database.execute("COMMIT"); }

void Store::add_run(const std::string& started, const std::string& provenance) {
  data_->run = key_id({"run", started, provenance});
  Statement insert(data_->database, "INSERT OR IGNORE INTO runs (id, started, provenance) VALUES (?, ?, ?)");
  insert.bind(1, data_->run);
  insert.bind(2, started);
  insert.bind(3, provenance);
  insert.run();
}

std::int64_t Store::add_set(const std::string& name) {
  const std::int64_t id = set_id(name);
  Statement insert(data_->database, "INSERT OR IGNORE INTO sets (id, name) VALUES (?, ?)");
  insert.bind(1, id);
  insert.bind(2, name);
  insert.run();
  return id;
}

std::int64_t Store::add_solver(const SolverRow& solver, const std::vector<Parameterisation>& sweep) {
  const std::int64_t id = solver.id();
  const std::vector<Parameterisation> cells =
      sweep.empty() ? std::vector<Parameterisation>{{solver.settings, solver.all_settings}} : sweep;
  Statement insert(data_->database, insert_into("solvers", std::string("id, ") + kSolverColumnNames + ", cells", 9));
  insert.bind(1, id);
  int parameter = 2;
  for (const auto column : kSolverColumns) insert.bind(parameter++, solver.*column);
  insert.bind(parameter, static_cast<std::int64_t>(cells.size()));
  insert.run();
  Statement insert_cell(data_->database,
                        insert_into("parameterisations", "solver_id, cell, settings, all_settings", 4));
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    insert_cell.bind(1, id);
    insert_cell.bind(2, static_cast<std::int64_t>(cell));
    parameter = 3;
    for (const auto column : kCellColumns) insert_cell.bind(parameter++, cells[cell].*column);
    insert_cell.run();
  }
  check_same_solver(data_->database, solver, cells);
  return id;
}

void Store::add(const ProblemResult& result) {
  Writers& writers = *data_->writers;
  const ProblemRow& problem = result.problem;
  writers.problem.bind(1, problem.id);
  writers.problem.bind(2, problem.set_id);
  writers.problem.bind(3, static_cast<std::int64_t>(problem.seed));
  writers.problem.bind(4, problem.trial);
  writers.problem.bind(5, problem.kind);
  writers.problem.bind(6, problem.n);
  writers.problem.bind(7, problem.ngc);
  writers.problem.bind(8, problem.nc);
  writers.problem.bind(9, problem.hash);
  writers.problem.bind(10, problem.theory);
  writers.problem.run();
  check_same_problem(writers.stored_problem, problem, file());

  for (const auto& [id, bytes] : result.vectors) {
    writers.vector.bind(1, id);
    writers.vector.bind_blob(2, bytes);
    writers.vector.run();
  }

  // All answers of a solver to a problem come from one sitting: parts of two could overlap.
  std::vector<std::int64_t> present;
  for (const AnswerRow& row : result.answers) {
    if (is_present(writers.stored_answers, problem.id, row.solver_id)) present.push_back(row.solver_id);
  }
  for (const AnswerRow& row : result.answers) {
    if (std::find(present.begin(), present.end(), row.solver_id) == present.end()) {
      add_answer(writers, problem.id, data_->run, row);
    }
  }
}

std::vector<std::int64_t> Store::done(std::int64_t problem_id) {
  if (data_->done == nullptr) {
    data_->done = std::make_unique<Statement>(
        data_->database, "SELECT solver_id FROM answers WHERE problem_id = ? AND part = 0 ORDER BY 1");
  }
  data_->done->bind(1, problem_id);
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
    const std::int64_t id = query.integer(0);
    rows.push_back({id, read_solver(query, 1), read_cells(data_->database, id)});
  }
  return rows;
}

std::vector<std::string> Store::runs() {
  Statement query(data_->database, "SELECT provenance FROM runs ORDER BY started, id");
  std::vector<std::string> rows;
  while (query.step()) rows.emplace_back(query.text(0));
  return rows;
}

void Store::for_each_problem(const std::function<void(const ProblemRow&)>& visit) {
  Statement query(
      data_->database,
      "SELECT id, set_id, seed, trial, kind, n, ngc, nc, hash, theory FROM problems ORDER BY set_id, seed, trial");
  ProblemRow row;
  while (query.step()) {
    row.id = query.integer(0);
    row.set_id = query.integer(1);
    row.seed = static_cast<std::uint64_t>(query.integer(2));
    row.trial = query.integer(3);
    row.kind = query.text(4);
    row.n = query.integer(5);
    row.ngc = query.integer(6);
    row.nc = query.integer(7);
    row.hash = query.text(8);
    row.theory = query.text(9);
    visit(row);
  }
}

void Store::for_each_answer(const std::function<void(const StoredAnswer&)>& visit) {
  Statement query(
      data_->database,
      fmt::format(
          "SELECT j.problem_id, j.solver_id, j.part, j.cells, j.set_id, j.seed, j.trial, j.n, j.claim, j.truth, "
          "j.verdict, v.usable, v.solved, v.criterion, v.worst_row, {}, {} FROM judged j "
          "JOIN verdicts v USING (problem_id, solver_id, part) "
          "JOIN timings t USING (problem_id, solver_id, part) ORDER BY j.problem_id, j.solver_id, j.part",
          kErrorColumnNames, kTimeColumnNames));
  StoredAnswer row;
  while (query.step()) {
    row.problem_id = query.integer(0);
    row.solver_id = query.integer(1);
    row.part = query.integer(2);
    row.cells = query.integer(3);
    row.set_id = query.integer(4);
    row.seed = static_cast<std::uint64_t>(query.integer(5));
    row.trial = query.integer(6);
    row.n = query.integer(7);
    row.claim = stored_claim(data_->database, query.text(8));
    row.truth = parse_truth(query.text(9));
    row.verdict = stored_verdict(data_->database, query.text(10));
    row.errors.usable = query.integer(11) != 0;
    row.errors.solved = query.integer(12) != 0;
    row.errors.criterion = query.integer(13) != 0;
    row.errors.worst = {.row = query.is_null(14) ? -1 : query.integer(14)};
    int column = 15;
    for (const auto error : kErrorColumns) row.errors.*error = query.real(column++);
    for (const auto time : kTimeColumns) row.times.*time = query.real(column++);
    row.verify_s = query.real(column++);
    row.times.repeats = static_cast<int>(query.integer(column));
    visit(row);
  }
}

std::optional<Answer> Store::answer(std::int64_t problem_id, std::int64_t solver_id, std::uint32_t cell) {
  Statement query(data_->database,
                  "SELECT claim, iterations, pivots, factorizations, detail, z.data, velocity.data, farkas.data "
                  "FROM answers a JOIN cell_groups g ON g.group_id = a.group_id AND g.cell = ? "
                  "LEFT JOIN vectors z ON z.id = a.z LEFT JOIN vectors velocity ON velocity.id = a.velocity "
                  "LEFT JOIN vectors farkas ON farkas.id = a.farkas WHERE problem_id = ? AND solver_id = ?");
  query.bind(1, static_cast<std::int64_t>(cell));
  query.bind(2, problem_id);
  query.bind(3, solver_id);
  if (!query.step()) return std::nullopt;
  Answer answer;
  answer.claim = stored_claim(data_->database, query.text(0));
  answer.counters = {query.integer(1), query.integer(2), query.integer(3)};
  answer.detail = query.text(4);
  Vector* const vectors[] = {&answer.z, &answer.velocity, &answer.farkas};
  for (int i = 0; i < 3; ++i) {
    if (!query.is_null(5 + i)) {
      *vectors[i] = from_store(data_->database, [&] { return decode_vector(query.blob(5 + i)); });
    }
  }
  return answer;
}

const std::filesystem::path& Store::file() const { return data_->database.file(); }
sqlite::Database& Store::database() { return data_->database; }

}  // namespace lcpbench
