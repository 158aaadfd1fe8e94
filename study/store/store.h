#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/timed_solve.h"
#include "study/evaluation/friction_model.h"
#include "study/store/sqlite.h"

namespace lcpbench {

/// A solver with its settings, as a store knows it.
struct SolverRow {
  std::string name;
  std::string settings;      ///< those off their defaults, "key=value,key=value"
  std::string all_settings;  ///< every one
  std::string library;       ///< "native" or the library's name
  std::string version;
  std::string isa;  ///< instruction-set level of native code, "" for libraries
  /// "" where the solver was asked for by itself; else the grid it was run over, or is a cell of, with what the swept
  /// solver has off its defaults: "paper", "paper{engine=kernel}". A sweep is timed without repeats, so it is a solver
  /// of its own.
  std::string sweep;
  /// The model of friction that it solves; for a sweep, see its cells.
  FrictionModel friction = FrictionModel::kPyramid;

  /// Depends on every field but all_settings and friction.
  std::int64_t id() const;
  /// "name" or "name{settings}".
  std::string text() const;
  bool operator==(const SolverRow&) const = default;
};

/// One problem of a set. Ids are functions of the natural keys, see study/store/schema.h.
struct ProblemRow {
  std::int64_t id = 0;
  std::int64_t set_id = 0;
  std::uint64_t seed = 0;
  std::int64_t trial = 0;
  std::string kind;
  std::int64_t n = 0;
  std::int64_t ngc = 0;
  std::int64_t nc = 0;
  bool free_bodies = false;  ///< G couples no joints: that of free bodies
  std::string hash;
  std::string theory;  ///< "solvable" or ""
  std::string notes = "[]";  ///< TimeStep::notes, a JSON array
};

std::int64_t set_id(const std::string& set_name);
std::int64_t problem_id(const std::string& set_name, std::uint64_t seed, std::int64_t trial);

/// What one solver answered to one problem, judged by itself.
struct AnswerRow {
  std::int64_t solver_id = 0;
  std::vector<std::uint32_t> cells{0};  ///< parameterisations that gave this answer, ascending
  Claim claim = Claim::kNumericalFailure;
  std::optional<std::int64_t> z;  ///< ids among ProblemResult::vectors
  std::optional<std::int64_t> velocity;
  std::optional<std::int64_t> farkas;
  Counters counters;
  std::string detail;
  Errors errors;
  bool farkas_checked = false;
  SolveTimes times;  ///< of one cell: their mean
  double verify_s = 0;
};

/// One problem and some solvers' answers to it, those of a solver all together: what the runner hands over at a time.
struct ProblemResult {
  ProblemRow problem;
  std::vector<std::pair<std::int64_t, std::string>> vectors;  ///< content id and encoded vector
  std::vector<AnswerRow> answers;

  /// Number of parameterisations that answered.
  std::int64_t cells() const;
};

struct StoredSolver {
  std::int64_t id = 0;
  SolverRow row;                 ///< of a sweep: what its cells share
  std::vector<SolverRow> cells;  ///< one, the same row, unless it is a sweep
};

/// A finished answer, with the verdict that all answers to its problem together give.
struct StoredAnswer {
  std::int64_t problem_id = 0;
  std::int64_t solver_id = 0;
  std::int64_t part = 0;                 ///< lowest of its cells
  std::span<const std::uint32_t> cells;  ///< parameterisations that gave it, ascending; valid while the scan lives
  std::uint32_t group = 0;               ///< their place among AnswerScan::groups()
  std::int64_t set_id = 0;
  std::uint64_t seed = 0;
  std::int64_t trial = 0;
  std::string hash;  ///< of the problem's data
  Claim claim = Claim::kNumericalFailure;
  Counters counters;
  std::string detail;
  Truth truth = Truth::kUnknown;
  Verdict verdict = Verdict::kOpen;
  Errors errors;
  SolveTimes times;
  double verify_s = 0;
};

/// The meaning of a word in a store. @throws InputError that names the store for any other word.
Claim stored_claim(const sqlite::Database& store, std::string_view word);

/// How long a store waits for others, and how it tells the user about work that takes long.
struct Waiting {
  std::function<void(const std::string&)> tell;  ///< takes one line of text; none: nothing is said
  std::chrono::milliseconds tell_after{1000};    ///< a wait for readers that takes less goes without a word
  std::uintmax_t tell_bytes = 64'000'000;        ///< a smaller store is checked without a word
  std::chrono::milliseconds reader_patience{std::chrono::minutes(5)};
};

/// A study's store: one SQLite file in WAL mode, written in whole transactions. What is committed survives the end of
/// the process at any moment. Not thread-safe: one thread writes.
class Store {
 public:
  /// Opens a store for writing, or makes it, and checks its rows. Holds a lock on it: a second process is refused, and
  /// so is a file with several names (hard links), of which one alone has the log beside it. Waits for those that read
  /// a store at rest: it can be read while it is written, but they began before.
  /// @throws InputError when the file is no store, of another format, damaged, in use, or cannot be written.
  static Store open_for_writing(const std::filesystem::path& file, const Waiting& waiting = {});

  /// Opens an existing store for reading, also while another process writes it under the same name. What a killed
  /// writer left is brought in order first. The rows are not checked, see check(). @throws InputError as above.
  static Store open_for_reading(const std::filesystem::path& file);

  /// Deletes a store of whatever format, damaged or not, with its side files. Nothing happens when there is none.
  /// @throws InputError when the file is no store, or in use.
  static void remove(const std::filesystem::path& file);

  ~Store();
  Store(Store&&) noexcept;
  Store& operator=(Store&&) = delete;

  void begin();
  void commit();

  /// Adds a run (its provenance, JSON); later timings belong to it. A row with an empty `started` records the cost of a
  /// run that has ended, see study/run/shards.h.
  void add_run(const std::string& started, const std::string& provenance);
  std::int64_t add_set(const std::string& name);
  /// @param cells  of a sweep, each like `solver` but for its settings and friction; none: `solver` is the one cell
  /// @throws InputError when the store knows the solver with other defaults, or the sweep with another grid.
  std::int64_t add_solver(const SolverRow& solver, const std::vector<SolverRow>& cells = {});
  /// Adds a problem with the answers of some solvers; a solver whose answers to it are there already keeps those.
  /// @throws InputError when the store has other data for the problem (its hash differs): its set has changed.
  void add(const ProblemResult& result);

  /// The solvers whose answers to a problem are there.
  std::vector<std::int64_t> done(std::int64_t problem_id);

  /// Number of answers, one for each problem, solver and parameterisation.
  std::int64_t cell_count();
  std::vector<std::pair<std::int64_t, std::string>> sets();
  std::vector<StoredSolver> solvers();
  /// Provenance of every run, JSON texts, oldest first.
  std::vector<std::string> runs();
  /// Every distinct answer, or every one to the problems of a set, in order of problem, solver, part, as AnswerScan
  /// reads them.
  void for_each_answer(const std::function<void(const StoredAnswer&)>& visit,
                       const std::optional<std::int64_t>& set_id = std::nullopt);
  /// The answer of one parameterisation as the solver gave it, bit for bit; nullopt when there is none.
  std::optional<Answer> answer(std::int64_t problem_id, std::int64_t solver_id, std::uint32_t cell = 0);

  /// Reads every row and checks that it is what was written. @throws InputError that names file, table and row.
  void check(const Waiting& waiting = {});
  /// One line for the user: rows that the store has lost before it was opened. "" for none.
  const std::string& notice() const;

  const std::filesystem::path& file() const;
  /// For queries of reports, and for merging.
  sqlite::Database& database();

 private:
  struct Data;
  explicit Store(std::unique_ptr<Data> data);
  std::unique_ptr<Data> data_;
};

}  // namespace lcpbench
