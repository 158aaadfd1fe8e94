#include "study/store.h"

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
constexpr std::int64_t kFormatVersion = 1;

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

void check_format(Database& database) {
  if (database.integer("PRAGMA application_id") != kApplicationId) {
    throw InputError(describe(database.file(), "not an lcpbench store"));
  }
  const std::int64_t version = database.integer("PRAGMA user_version");
  if (version != kFormatVersion) {
    throw InputError(fmt::format("{}: store format {}, this lcpbench reads format {}", database.file().string(),
                                 version, kFormatVersion));
  }
}

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
        answer(database, insert_into("answers",
                                     "problem_id, solver_id, claim, z, velocity, farkas, iterations, pivots, "
                                     "factorizations, detail",
                                     10)),
        verdict(database,
                insert_into("verdicts",
                            std::string("problem_id, solver_id, usable, solved, criterion, farkas_checked, ") +
                                kErrorColumnNames,
                            6 + static_cast<int>(kErrorColumns.size()))),
        timing(database,
               insert_into("timings", std::string("problem_id, solver_id, run_id, ") + kTimeColumnNames, 10)) {}

  Statement problem;
  Statement stored_problem;
  Statement vector;
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
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) throw InputError(describe(file, "no such store"));
  auto data = std::make_unique<Data>(file, Mode::kReadOnly);
  check_format(data->database);
  return Store(std::move(data));
}

void Store::remove(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return;
  const FileLock lock(file);
  {
    Database database(file, Mode::kReadOnly);
    if (!is_blank(database)) check_format(database);
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

std::int64_t Store::add_solver(const SolverRow& solver) {
  const std::int64_t id = solver.id();
  Statement insert(data_->database, insert_into("solvers", std::string("id, ") + kSolverColumnNames, 8));
  insert.bind(1, id);
  int parameter = 2;
  for (const auto column : kSolverColumns) insert.bind(parameter++, solver.*column);
  insert.run();
  Statement stored(data_->database, fmt::format("SELECT {} FROM solvers WHERE id = ?", kSolverColumnNames));
  stored.bind(1, id);
  stored.step();
  if (read_solver(stored, 0) != solver) {
    throw InputError(fmt::format("{}: the store knows '{}' with other defaults; use another store, or --fresh",
                                 file().string(), solver.text()));
  }
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

  for (const CellRow& cell : result.cells) {
    Statement& answer = writers.answer;
    answer.bind(1, problem.id);
    answer.bind(2, cell.solver_id);
    answer.bind(3, std::string_view(to_string(cell.claim)));
    bind_id(answer, 4, cell.z);
    bind_id(answer, 5, cell.velocity);
    bind_id(answer, 6, cell.farkas);
    answer.bind(7, cell.counters.iterations);
    answer.bind(8, cell.counters.pivots);
    answer.bind(9, cell.counters.factorizations);
    answer.bind(10, cell.detail);
    answer.run();

    Statement& verdict = writers.verdict;
    verdict.bind(1, problem.id);
    verdict.bind(2, cell.solver_id);
    verdict.bind(3, as_integer(cell.errors.usable));
    verdict.bind(4, as_integer(cell.errors.solved));
    verdict.bind(5, as_integer(cell.errors.criterion));
    verdict.bind(6, as_integer(cell.farkas_checked));
    int parameter = 7;
    for (const auto column : kErrorColumns) verdict.bind(parameter++, cell.errors.*column);
    verdict.run();

    Statement& timing = writers.timing;
    timing.bind(1, problem.id);
    timing.bind(2, cell.solver_id);
    timing.bind(3, data_->run);
    parameter = 4;
    for (const auto column : kTimeColumns) timing.bind(parameter++, cell.times.*column);
    timing.bind(parameter++, cell.verify_s);
    timing.bind(parameter, static_cast<std::int64_t>(cell.times.repeats));
    timing.run();
  }
}

std::vector<std::int64_t> Store::done(std::int64_t problem_id) {
  if (data_->done == nullptr) {
    data_->done =
        std::make_unique<Statement>(data_->database, "SELECT solver_id FROM answers WHERE problem_id = ? ORDER BY 1");
  }
  data_->done->bind(1, problem_id);
  std::vector<std::int64_t> solvers;
  while (data_->done->step()) solvers.push_back(data_->done->integer(0));
  data_->done->reset();
  return solvers;
}

std::int64_t Store::cell_count() { return data_->database.integer("SELECT COUNT(*) FROM answers"); }

std::vector<std::pair<std::int64_t, std::string>> Store::sets() {
  Statement query(data_->database, "SELECT id, name FROM sets ORDER BY name");
  std::vector<std::pair<std::int64_t, std::string>> rows;
  while (query.step()) rows.emplace_back(query.integer(0), query.text(1));
  return rows;
}

std::vector<StoredSolver> Store::solvers() {
  Statement query(data_->database, fmt::format("SELECT id, {0} FROM solvers ORDER BY {0}, id", kSolverColumnNames));
  std::vector<StoredSolver> rows;
  while (query.step()) rows.push_back({query.integer(0), read_solver(query, 1)});
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

void Store::for_each_cell(const std::function<void(const StoredCell&)>& visit) {
  Statement query(
      data_->database,
      fmt::format("SELECT j.problem_id, j.solver_id, j.set_id, j.seed, j.trial, j.n, j.claim, j.truth, j.verdict, "
                  "v.usable, v.solved, v.criterion, {}, {} FROM judged j "
                  "JOIN verdicts v USING (problem_id, solver_id) JOIN timings t USING (problem_id, solver_id) "
                  "ORDER BY j.problem_id, j.solver_id",
                  kErrorColumnNames, kTimeColumnNames));
  StoredCell cell;
  while (query.step()) {
    cell.problem_id = query.integer(0);
    cell.solver_id = query.integer(1);
    cell.set_id = query.integer(2);
    cell.seed = static_cast<std::uint64_t>(query.integer(3));
    cell.trial = query.integer(4);
    cell.n = query.integer(5);
    cell.claim = stored_claim(data_->database, query.text(6));
    cell.truth = parse_truth(query.text(7));
    cell.verdict = stored_verdict(data_->database, query.text(8));
    cell.errors.usable = query.integer(9) != 0;
    cell.errors.solved = query.integer(10) != 0;
    cell.errors.criterion = query.integer(11) != 0;
    int column = 12;
    for (const auto error : kErrorColumns) cell.errors.*error = query.real(column++);
    for (const auto time : kTimeColumns) cell.times.*time = query.real(column++);
    cell.verify_s = query.real(column++);
    cell.times.repeats = static_cast<int>(query.integer(column));
    visit(cell);
  }
}

std::optional<Answer> Store::answer(std::int64_t problem_id, std::int64_t solver_id) {
  Statement query(
      data_->database,
      "SELECT claim, iterations, pivots, factorizations, detail, z.data, velocity.data, farkas.data "
      "FROM answers a LEFT JOIN vectors z ON z.id = a.z LEFT JOIN vectors velocity ON velocity.id = a.velocity "
      "LEFT JOIN vectors farkas ON farkas.id = a.farkas WHERE problem_id = ? AND solver_id = ?");
  query.bind(1, problem_id);
  query.bind(2, solver_id);
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
