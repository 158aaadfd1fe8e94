#include "study/store/merge.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <system_error>
#include <unordered_set>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sqlite3.h>
#include <unistd.h>

#include "core/error.h"
#include "study/store/store_check.h"
#include "study/store/store_files.h"

namespace lcpbench {
namespace {

using sqlite::Statement;

constexpr std::size_t kConflictsShown = 20;  // of each table of an input
constexpr std::ptrdiff_t kInputsAtOnce = 250;  // each takes up to three of the 1024 files that a process may open

constexpr const char* kProblems = "problems";
constexpr const char* kCertificates = "certificates";
constexpr const char* kCertificateTimings = "certificate_timings";

/// How the rows of one table are joined. In SQL, m is the row of the merged store and i that of the input.
struct Table {
  const char* name;
  std::vector<const char*> key;      ///< the first columns, at most three integers
  std::vector<const char*> content;  ///< columns in which two rows of one key must agree
  std::string conflict_names;        ///< an expression that names the row for the user
  const char* conflict = "0";        ///< a condition under which two rows of one key contradict each other, too
  const char* join = "";             ///< an upsert's UPDATE where they do not contradict; "" keeps the first row
};

const std::string kProblemInWords =
    "(SELECT printf('%s seed %u trial %d', s.name, p.seed, p.trial) FROM problems p JOIN sets s ON s.id = p.set_id "
    "WHERE p.id = m.problem_id)";

const std::string kCellInWords =
    kProblemInWords + " || ', ' || (SELECT name || CASE settings WHEN '' THEN '' ELSE '{' || settings || '}' "
    "END FROM solvers "
    "WHERE id = m.solver_id) || CASE m.part WHEN 0 THEN '' ELSE ' part ' || m.part END";

std::vector<const char*> verdict_content() {
  std::vector<const char*> columns{"usable", "solved", "criterion", "farkas_checked", "worst_row"};
  for (const Metric& metric : kMetrics) {
    if (metric.stored && metric.value != &Errors::forward_velocity) columns.push_back(metric.name);
  }
  return columns;
}

/// All tables with data, in the order in which they are joined: rows after those that they refer to, and timings of
/// certificates after the certificates, which decide whose are kept.
///
/// If two stores group the cells of a sweep on one problem differently, they have a row of `answers` with one key and
/// two group_ids. For a part is named by the lowest cell of its group: both have part 0, and if the groups of the first
/// parts agree, the lowest remaining cell names the next part in both.
const std::vector<Table>& tables() {
  static const std::vector<Table> all{
      {"runs", {"id"}, {}, "''"},
      {"sets", {"id"}, {"name"}, "m.name"},
      {"solvers",
       {"id"},
       {"name", "settings", "all_settings", "library", "version", "isa", "sweep", "cells"},
       "m.name"},
      {"parameterisations",
       {"solver_id", "cell"},
       {"settings", "all_settings", "friction"},
       "(SELECT name || ' ' || sweep FROM solvers WHERE id = m.solver_id) || ' cell ' || m.cell"},
      {kProblems,
       {"id"},
       {"set_id", "seed", "trial", "kind", "n", "ngc", "nc", "free_bodies", "hash", "theory", "notes"},
       "printf('%s seed %u trial %d', (SELECT name FROM sets WHERE id = m.set_id), m.seed, m.trial)"},
      {"vectors", {"id"}, {"data"}, "m.id"},
      {"cell_groups", {"group_id", "cell"}, {}, "''"},
      {"answers",
       {"problem_id", "solver_id", "part"},
       {"group_id", "claim", "z", "velocity", "farkas", "iterations", "pivots", "factorizations"},
       kCellInWords},
      {"verdicts",
       {"problem_id", "solver_id", "part"},
       verdict_content(),
       kCellInWords,
       "m.forward_velocity <> i.forward_velocity",  // NULL where the problem was not certified
       // All other columns are equal: the row becomes that of the input, and takes its checksum.
       "UPDATE SET forward_velocity = excluded.forward_velocity, checksum = excluded.checksum "
       "WHERE verdicts.forward_velocity IS NULL AND excluded.forward_velocity IS NOT NULL"},
      {"timings", {"problem_id", "solver_id", "part"}, {}, "''"},
      // Proofs of one fact may differ, and a longer time limit may settle what is open: neither is a conflict.
      {kCertificates,
       {"problem_id"},
       {},
       kProblemInWords,
       "(m.certificate <> i.certificate AND 'open' NOT IN (m.certificate, i.certificate)) OR "
       "m.velocity_unique <> i.velocity_unique OR "
       "(m.velocity_unique = 1 AND i.velocity_unique = 1 AND m.velocity <> i.velocity)",
       "UPDATE SET (certificate, proof, velocity, velocity_unique, least_violation_m_per_s, proof_margin, detail, "
       "checksum) = (excluded.certificate, excluded.proof, excluded.velocity, excluded.velocity_unique, "
       "excluded.least_violation_m_per_s, excluded.proof_margin, excluded.detail, excluded.checksum) "
       "WHERE certificates.certificate = 'open' AND excluded.certificate <> 'open'"},
      {"proofs", {"problem_id"}, {}, "''"},
      {kCertificateTimings,
       {"problem_id"},
       {},
       "''",
       "0",
       "UPDATE SET (seconds, time_limit_s, checksum) = (excluded.seconds, excluded.time_limit_s, excluded.checksum)"}};
  return all;
}

/// The names of columns with `separator` between them. @param form  fmt's format of one; "?" leaves the name out
template <class Columns>
std::string joined(const Columns& columns, const char* form, const char* separator) {
  std::string text;
  for (const auto& column : columns) text += (text.empty() ? "" : separator) + fmt::format(fmt::runtime(form), column);
  return text;
}

/// Fields of the provenance in which the runs of all parts of one study agree, each with its value and the first store
/// that has it.
using CommonOrigin = std::map<std::string, std::pair<nlohmann::json, std::string>>;

/// @throws InputError when a run of the store has another version or another plan than those before; `mixed`: when its
/// plan has another bound of the verdict.
void compare_origin(Store& store, bool mixed, CommonOrigin& common) {
  for (const std::string& run : store.runs()) {
    const auto provenance = nlohmann::json::parse(run, nullptr, false);
    for (const char* field : {"lcpbench", "commit", "plan"}) {
      if (!provenance.is_object() || !provenance.contains(field)) continue;
      nlohmann::json value = provenance[field];
      if (value.is_object()) {
        for (const char* free : {"jobs", "budget_s", "description"}) value.erase(free);
        if (mixed) value = {{"solved_at", value.value("solved_at", nlohmann::json())}};
      } else if (mixed) {
        continue;
      }
      const auto& [expected, file] = common.try_emplace(field, value, store.file().string()).first->second;
      if (value == expected) continue;
      throw InputError(fmt::format("{} and {} are not parts of one study, their runs differ in {}{}: "
                                   "nothing was merged{}",
                                   store.file().string(), file, field,
                                   nlohmann::json::diff(expected, value)[0]["path"].get<std::string>(),
                                   mixed ? "" : "; --mixed joins them"));
    }
  }
}

/// Reads the whole input once, so that damage is reported under its name. @throws InputError
void check_input(const std::filesystem::path& input, const Waiting& waiting) {
  read_ahead(input);
  Store store = Store::open_for_reading(input);
  store.check(waiting);
  for (const std::string& claim : store.database().texts("SELECT DISTINCT claim FROM answers")) {
    stored_claim(store.database(), claim);
  }
}

/// An input, read as it was when it was opened, also while another process writes it.
struct Input {
  explicit Input(const std::filesystem::path& file) : database(file, sqlite::Mode::kReadOnly), snapshot(database) {
    check_format(database);
    database.execute("PRAGMA cache_size = 16");  // pages: it is read once, in the order of its rows
  }

  sqlite::Database database;
  sqlite::ReadSnapshot snapshot;
  bool has_other_problems = false;  ///< a problem's data differ from the stores before: no further conflict is sought
  std::unordered_set<std::int64_t> proven;  ///< problems that this input certifies and the stores before it left open
  std::size_t conflicts = 0;  ///< their number in the present table
};

using Inputs = std::deque<Input>;

/// The rows of one table in all inputs, in the order of their keys; those of one key in the order of the inputs.
class RowsByKey {
 public:
  RowsByKey(Inputs& inputs, const Table& table) : key_columns_(table.key.size()) {
    for (Input& input : inputs) {
      rows_.emplace_back(input.database,
                         fmt::format("SELECT * FROM {} ORDER BY {}", table.name, joined(table.key, "{}", ", ")));
      advance(rows_.size() - 1);
    }
  }

  bool has_row() const { return !next_.empty(); }
  std::size_t input() const { return next_.top().second; }
  const Statement& row() const { return rows_[input()]; }
  void next() {
    const std::size_t input = this->input();
    next_.pop();
    advance(input);
  }

 private:
  using Place = std::pair<std::array<std::int64_t, 3>, std::size_t>;  ///< key, number of the input

  void advance(std::size_t input) {
    if (!rows_[input].step()) return;
    Place place{{}, input};
    for (std::size_t i = 0; i < key_columns_; ++i) place.first.at(i) = rows_[input].integer(static_cast<int>(i));
    next_.push(place);
  }

  std::size_t key_columns_;  ///< the first columns of the table
  std::deque<Statement> rows_;
  std::priority_queue<Place, std::vector<Place>, std::greater<>> next_;  ///< each input's next row
};

/// Adds rows to one table of a store.
class TableWriter {
 public:
  TableWriter(sqlite::Database& store, const Table& table)
      : store_(store),
        columns_(store.columns(table.name)),
        add_(store, insertion(table, "NOTHING")),
        join_(store, insertion(table, *table.join == '\0' ? "NOTHING" : table.join)),
        contradict_(store, contradiction(table)) {}

  /// Each @returns whether the table was changed.
  bool add_new(const Statement& row) { return run(add_, row); }
  bool join(const Statement& row) { return run(join_, row); }

  /// The row in words, where it contradicts that of its key in the table.
  std::optional<std::string> contradiction_by(const Statement& row) {
    contradict_.bind_row(row);
    std::optional<std::string> words;
    if (contradict_.step()) words = contradict_.text(0);
    contradict_.reset();
    return words;
  }

 private:
  /// @param join  the action if the key is there. A row that breaks another rule of the table is an error.
  std::string insertion(const Table& table, const char* join) const {
    return fmt::format("INSERT INTO {} VALUES ({}) ON CONFLICT ({}) DO {}", table.name, joined(columns_, "?", ", "),
                       joined(table.key, "{}", ", "), join);
  }

  std::string contradiction(const Table& table) const {
    std::string differ = joined(table.content, "m.{0} IS NOT i.{0}", " OR ");
    differ += (differ.empty() ? "" : " OR ") + std::string(table.conflict);
    return fmt::format("SELECT {} FROM (SELECT {}) i CROSS JOIN {} m USING ({}) WHERE {}", table.conflict_names,
                       joined(columns_, "? AS {}", ", "), table.name, joined(table.key, "{}", ", "), differ);
  }

  bool run(Statement& statement, const Statement& row) {
    statement.bind_row(row);
    statement.run();
    return sqlite3_changes(store_.handle()) > 0;
  }

  sqlite::Database& store_;
  std::vector<std::string> columns_;
  Statement add_;
  Statement join_;
  Statement contradict_;
};

/// Adds the rows of one table of all inputs, and appends to `conflicts` which contradict one that is there.
void join_table(sqlite::Database& store, Inputs& inputs, const Table& table, std::vector<std::string>& conflicts) {
  TableWriter writer(store, table);
  const std::string name = table.name;
  for (RowsByKey rows(inputs, table); rows.has_row(); rows.next()) {
    if (writer.add_new(rows.row())) continue;
    Input& input = inputs[rows.input()];
    if (input.has_other_problems) continue;
    if (const std::optional<std::string> words = writer.contradiction_by(rows.row())) {
      input.has_other_problems = name == kProblems;
      if (input.conflicts++ >= kConflictsShown) continue;
      conflicts.push_back(fmt::format("{}: {}: {}", input.database.file().string(), name, *words));
      if (!input.has_other_problems) continue;
      conflicts.back() += " and maybe others: has other data than in the stores before it";
      continue;
    }
    const std::int64_t id = rows.row().integer(0);
    if (name == kCertificateTimings && !input.proven.contains(id)) continue;
    if (writer.join(rows.row()) && name == kCertificates) input.proven.insert(id);
  }
  for (Input& input : inputs) {
    const std::size_t found = std::exchange(input.conflicts, 0);
    if (found <= kConflictsShown) continue;
    conflicts.push_back(fmt::format("{}: {}: {} more", input.database.file().string(), name, found - kConflictsShown));
  }
}

/// Adds the rows of all sources to a store without any. @returns their conflicts; if there are any, the store is of no
/// use.
///
/// Rows are added in the order of their keys: ids are hashes, and the rows of one source after another would fall on
/// pages everywhere. O(rows x log(kInputsAtOnce)), and one pass through the store for each kInputsAtOnce sources.
std::vector<std::string> join(sqlite::Database& store, const std::vector<std::filesystem::path>& sources) {
  std::vector<std::string> conflicts;
  store.execute("BEGIN");
  for (auto source = sources.begin(); source != sources.end();) {
    const auto end = source + std::min<std::ptrdiff_t>(kInputsAtOnce, sources.end() - source);
    std::for_each(source, end, read_ahead);
    Inputs inputs;
    while (source != end) inputs.emplace_back(*source++);
    for (const Table& table : tables()) join_table(store, inputs, table, conflicts);
  }
  store.execute("COMMIT");
  return conflicts;
}

/// A draft whose writer dies is thrown away: it needs no journal, and reaches the disk once, at its end.
void write_as_draft(sqlite::Database& draft) {
  sqlite3_db_config(draft.handle(), SQLITE_DBCONFIG_DEFENSIVE, 0, nullptr);  // which forbids to have no journal
  draft.execute("PRAGMA synchronous = OFF; PRAGMA cache_size = -262144; PRAGMA journal_mode = OFF");
}

/// A file that is deleted again unless it was moved away.
class Draft {
 public:
  explicit Draft(std::filesystem::path file) : file_(std::move(file)) { Store::remove(file_); }
  ~Draft() {
    std::error_code ignored;
    for (const char* suffix : {"-wal", "-shm", "-journal", ""}) {  // a log without its file would block the next merge
      std::filesystem::remove(file_.string() + suffix, ignored);
    }
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  const std::filesystem::path& file() const { return file_; }
  void move_to(const std::filesystem::path& target) {
    if (has_log(file_)) throw InputError(file_.string() + ": another process reads it");
    // It was written without waiting for the disk, and must be on it before it gets the name.
    const int descriptor = open(file_.c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_on_disk = descriptor >= 0 && fsync(descriptor) == 0;
    std::error_code error(is_on_disk ? 0 : errno, std::generic_category());
    if (descriptor >= 0) close(descriptor);
    if (!error) std::filesystem::rename(file_, target, error);
    if (error) throw InputError(fmt::format("{}: {}", target.string(), error.message()));
  }

 private:
  std::filesystem::path file_;
};

}  // namespace

MergeOutcome merge_stores(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs,
                          const Waiting& waiting, bool mixed) {
  std::vector<std::filesystem::path> sources = inputs;
  MergeOutcome outcome;
  const auto take_notice = [&outcome](std::string notice) {
    if (!notice.empty()) outcome.notices.push_back(std::move(notice));
  };
  std::error_code ignored;
  const bool exists = std::filesystem::exists(out, ignored);
  for (const std::filesystem::path& source : inputs) {
    if (exists && std::filesystem::equivalent(source, out, ignored)) {
      throw InputError(out.string() + ": a store is not merged with itself; name it once");
    }
  }
  if (exists) sources.insert(sources.begin(), out);
  CommonOrigin common;
  for (const std::filesystem::path& source : sources) {
    Store store = Store::open_for_reading(source);
    compare_origin(store, mixed, common);
    take_notice(store.notice());
  }
  // When it is closed, the rows that a killed run left in the write-ahead log move to the file itself.
  if (exists) Store::open_for_writing(out, waiting);
  for (const std::filesystem::path& source : inputs) check_input(source, waiting);
  const FileLock lock(out);
  if (!exists && std::filesystem::exists(out, ignored)) {
    throw InputError(out.string() + ": another process made this store in the meantime; merge again");
  }
  if (exists && has_log(out)) throw InputError(out.string() + ": another process reads it");
  if (!exists) remove_side_files(out);  // of a store that is gone: they would be taken for the merged one's
  Draft draft(side_file(out, ".merging"));
  {
    Store store = Store::open_for_writing(draft.file());
    write_as_draft(store.database());
    outcome.conflicts = join(store.database(), sources);
    outcome.cells = store.cell_count();
  }
  if (outcome.conflicts.empty()) draft.move_to(followed(out));
  return outcome;
}

}  // namespace lcpbench
