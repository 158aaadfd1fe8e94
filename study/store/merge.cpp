#include "study/store/merge.h"

#include <cerrno>
#include <map>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sqlite3.h>
#include <unistd.h>

#include "core/error.h"
#include "study/store/file_lock.h"
#include "study/store/store.h"
#include "study/store/store_files.h"

namespace lcpbench {
namespace {

using sqlite::Statement;

constexpr std::size_t kConflictsShown = 20;

constexpr const char* kProblems = "problems";

struct Table {
  const char* name;
  std::vector<const char*> key;
  std::vector<const char*> content;  ///< what must agree where keys do; empty for what may differ
  const char* conflict_names;        ///< a query on m (merged) and i (input) that says in words which row it is
  const char* conflict = "0";        ///< what else two rows of one key cannot both say
  const char* join = "NOTHING";      ///< what is done with the row that is there
};

constexpr const char* kProblemInWords =
    "(SELECT s.name || ' seed ' || p.seed || ' trial ' || p.trial FROM problems p JOIN sets s ON s.id = p.set_id "
    "WHERE p.id = m.problem_id)";

constexpr const char* kCellInWords =
    "(SELECT s.name || ' seed ' || p.seed || ' trial ' || p.trial FROM problems p JOIN sets s ON s.id = p.set_id "
    "WHERE p.id = m.problem_id) || ', ' || (SELECT name || CASE settings WHEN '' THEN '' ELSE '{' || settings || '}' "
    "END FROM solvers "
    "WHERE id = m.solver_id) || CASE m.part WHEN 0 THEN '' ELSE ' part ' || m.part END";

std::vector<const char*> verdict_content() {
  std::vector<const char*> columns{"usable", "solved", "criterion", "farkas_checked", "worst_row"};
  for (const Metric& metric : kMetrics) {
    if (metric.stored && metric.value != &Errors::forward_velocity) columns.push_back(metric.name);
  }
  return columns;
}

/// Two stores that group the cells of a sweep on a problem differently differ in a row of `answers` that both have:
/// both have the part 0; where its groups agree, the lowest cell outside it is a part of both, and so on.
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
       {"settings", "all_settings"},
       "(SELECT name || ' ' || sweep FROM solvers WHERE id = m.solver_id) || ' cell ' || m.cell"},
      {kProblems,
       {"id"},
       {"set_id", "seed", "trial", "kind", "n", "ngc", "nc", "free_bodies", "hash", "theory"},
       "(SELECT name FROM sets WHERE id = m.set_id) || ' seed ' || m.seed || ' trial ' || m.trial"},
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
       // All else in the two rows is equal, so that the checksum of the input's row is that of both.
       "UPDATE SET forward_velocity = excluded.forward_velocity, checksum = excluded.checksum "
       "WHERE verdicts.forward_velocity IS NULL AND excluded.forward_velocity IS NOT NULL"},
      {"timings", {"problem_id", "solver_id", "part"}, {}, "''"},
      // Two proofs of one fact may differ, and what one time limit left open another may settle.
      {"certificates",
       {"problem_id"},
       {},
       kProblemInWords,
       "(m.certificate <> i.certificate AND 'open' NOT IN (m.certificate, i.certificate)) OR "
       "(m.velocity_unique = 1 AND i.velocity_unique = 1 AND m.velocity <> i.velocity)"},
      {"proofs", {"problem_id"}, {}, "''"},
      {"certificate_timings", {"problem_id"}, {}, "''"}};
  return all;
}

std::string joined(const std::vector<const char*>& columns, const char* form, const char* separator) {
  std::string text;
  for (const char* column : columns) text += (text.empty() ? "" : separator) + fmt::format(fmt::runtime(form), column);
  return text;
}

/// CROSS JOIN keeps the order of the tables: each row of the input is looked up among the merged ones. The other order
/// would read all merged rows for each input.
std::vector<std::string> find_conflicts(Store& store, const std::filesystem::path& input) {
  std::vector<std::string> conflicts;
  for (const Table& table : tables()) {
    std::string differ = joined(table.content, "m.{0} IS NOT i.{0}", " OR ");
    differ += (differ.empty() ? "" : " OR ") + std::string(table.conflict);
    Statement query(
        store.database(),
        fmt::format("SELECT {0} FROM input.{1} i CROSS JOIN main.{1} m USING ({2}) WHERE {3} LIMIT {4}",
                    table.conflict_names, table.name, joined(table.key, "{}", ", "), differ, kConflictsShown));
    while (query.step()) {
      conflicts.push_back(fmt::format("{}: {}: {}", input.string(), table.name, query.text(0)));
    }
    if (table.name != kProblems || conflicts.empty()) continue;
    // Answers to other data differ, too.
    conflicts = {conflicts.front() + " and maybe others: has other data than in the stores before it"};
    break;
  }
  return conflicts;
}

/// What the runs of all parts of one study have in common: by field of their provenance, its value and the store
/// that has it first.
using CommonOrigin = std::map<std::string, std::pair<nlohmann::json, std::string>>;

/// @throws InputError when a run of the store has another version or another plan than those before.
void compare_origin(Store& store, CommonOrigin& common) {
  for (const std::string& run : store.runs()) {
    const auto provenance = nlohmann::json::parse(run, nullptr, false);
    for (const char* field : {"lcpbench", "commit", "plan"}) {
      if (!provenance.is_object() || !provenance.contains(field)) continue;
      nlohmann::json value = provenance[field];
      if (value.is_object()) {
        for (const char* free : {"jobs", "budget_s", "description"}) value.erase(free);
      }
      const auto& [expected, file] = common.try_emplace(field, value, store.file().string()).first->second;
      if (value == expected) continue;
      throw InputError(fmt::format("{} and {} are not parts of one study, their runs differ in {}{}: "
                                   "nothing was merged; --mixed joins them",
                                   store.file().string(), file, field,
                                   nlohmann::json::diff(expected, value)[0]["path"].get<std::string>()));
    }
  }
}

/// Reads the whole input once, so that damage is reported under its name. @throws InputError
void check_input(const std::filesystem::path& input, const Waiting& waiting) {
  Store store = Store::open_for_reading(input);
  store.check(waiting);
  Statement claims(store.database(), "SELECT DISTINCT claim FROM answers");
  while (claims.step()) stored_claim(store.database(), claims.text(0));
}

/// What the input has certified and the store left open goes, so that the input's proof takes its place.
void make_way_for_proofs(Store& store) {
  for (const char* table : {"certificate_timings", "certificates"}) {
    store.database().execute(
        fmt::format("DELETE FROM main.{} WHERE problem_id IN (SELECT problem_id FROM input.certificates i "
                    "CROSS JOIN main.certificates m USING (problem_id) "
                    "WHERE m.certificate = 'open' AND i.certificate <> 'open')",
                    table));
  }
}

/// Adds the input's rows; or returns its conflicts and adds none. One transaction: what is compared is what is added,
/// also when another process writes the input. O(rows of the input x log(rows of the store)): every query goes through
/// the input and looks up the store.
std::vector<std::string> join(Store& store, const std::filesystem::path& input) {
  store.database().attach(input, "input");
  store.begin();
  std::vector<std::string> conflicts = find_conflicts(store, input);
  if (conflicts.empty()) {
    make_way_for_proofs(store);
    for (const Table& table : tables()) {
      // Rows of a key that is there agree, or may differ. Whatever else keeps a row out is an error.
      store.database().execute(
          fmt::format("INSERT INTO main.{0} SELECT * FROM input.{0} WHERE true ON CONFLICT ({1}) DO {2}",
                      table.name, joined(table.key, "{}", ", "), table.join));
    }
  }
  store.commit();
  store.database().execute("DETACH DATABASE input");
  return conflicts;
}

/// A draft whose writer dies is thrown away: it needs no journal, and reaches the disk once, at its end. Rows come in the
/// order of hashed ids and fall on pages everywhere, so that a cache of 256 MiB spares most writes.
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
    // What was written without waiting for the disk must be there before the name says so.
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
  if (exists) sources.insert(sources.begin(), out);
  CommonOrigin common;
  for (const std::filesystem::path& source : sources) {
    Store store = Store::open_for_reading(source);
    if (!mixed) compare_origin(store, common);
    take_notice(store.notice());
  }
  if (exists) {
    Store::open_for_writing(
        out, waiting);  // its end folds what a killed run left in the write-ahead log into the file itself
  }
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
    for (const std::filesystem::path& source : sources) {
      for (std::string& conflict : join(store, source)) outcome.conflicts.push_back(std::move(conflict));
    }
    outcome.cells = store.cell_count();
  }
  if (outcome.conflicts.empty()) draft.move_to(followed(out));
  return outcome;
}

}  // namespace lcpbench
