#include "study/store/store_check.h"

#include <array>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "study/evaluation/evaluation.h"
#include "study/store/row_checksum.h"
#include "study/store/schema.h"
#include "study/store/totals.h"
#include "study/store/vector_codec.h"

namespace lcpbench {
namespace {

using sqlite::Database;
using sqlite::Statement;

constexpr std::int64_t kApplicationId = 0x4c43'5042;  // "LCPB", in the header of the file

std::string damage(const Database& database, const std::string& what) {
  return fmt::format("{}: the store is damaged: {}", database.file().string(), what);
}

/// A statement without comments, and with one blank in place of several and of line ends.
std::string without_comments(std::string_view sql) {
  std::string text;
  bool quoted = false;
  for (std::size_t at = 0; at < sql.size(); ++at) {
    if (!quoted && sql.substr(at).starts_with("--")) at = sql.find('\n', at);
    if (at == std::string_view::npos) break;
    const char c = sql[at];
    if (c == '\'') quoted = !quoted;
    const bool blank = !quoted && (c == ' ' || c == '\n');
    if (!blank || !text.ends_with(' ')) text += blank ? ' ' : c;
  }
  return text;
}

/// Text of all tables, indices, views and triggers, by kind and name.
using Objects = std::map<std::pair<std::string, std::string>, std::string>;

Objects objects_of(Database& database) {
  Statement query(database, "SELECT type, name, tbl_name || ': ' || IFNULL(sql, '') FROM sqlite_master");
  Objects objects;
  while (query.step()) {
    objects.emplace(std::pair(std::string(query.text(0)), std::string(query.text(1))), without_comments(query.text(2)));
  }
  return objects;
}

const Objects& objects_of_a_store() {
  static const Objects objects = [] {
    Database made("", sqlite::Mode::kInMemory);
    made.execute(store_schema());
    return objects_of(made);
  }();
  return objects;
}

void check_schema(Database& database) {
  const Objects objects = objects_of(database);
  for (const auto& [object, text] : objects_of_a_store()) {
    const auto found = objects.find(object);
    if (found != objects.end() && found->second == text) continue;
    throw InputError(damage(database, fmt::format("{} {} is missing or altered", object.first, object.second)));
  }
  for (const auto& [object, text] : objects) {
    if (objects_of_a_store().contains(object)) continue;
    throw InputError(fmt::format("{}: has the {} '{}', which no store has: it is not used", database.file().string(),
                                 object.first, object.second));
  }
}

std::vector<std::string> tables_with_checksums(Database& database) {
  return database.texts(
      "SELECT m.name FROM sqlite_master m JOIN pragma_table_info(m.name) c "
      "WHERE m.type = 'table' AND c.name = 'checksum' ORDER BY m.name");
}

/// The key of a row in words, as SQL: 'problem_id=' || problem_id || ', part=' || part
std::string key_in_words(Database& database, const std::string& table) {
  const std::vector<std::string> words = database.texts(
      "SELECT name || '='' || ' || name FROM pragma_table_info('" + table + "') WHERE pk > 0 ORDER BY pk");
  return fmt::format("'{}", fmt::join(words, " || ', "));
}

/// The first row that is not what was written, in words; "" for none.
std::string changed_row(Database& database, const std::string& table) {
  Statement query(database, fmt::format("SELECT {} FROM {} WHERE checksum IS NOT {} LIMIT 1",
                                        key_in_words(database, table), table, sqlite::row_checksum_of(database, table)));
  return query.step() ? std::string(query.text(0)) : "";
}

std::string changed_vector(Database& database) {
  Statement query(database, "SELECT id, data FROM vectors");
  while (query.step()) {
    if (content_id(query.blob(1)) != query.integer(0)) return fmt::format("id={}", query.integer(0));
  }
  return "";
}

std::string changed_group(Database& database) {
  Statement query(database, "SELECT group_id, cell FROM cell_groups ORDER BY group_id, cell");
  std::int64_t group = 0;
  std::vector<std::uint32_t> cells;
  const auto changed = [&] { return !cells.empty() && cell_group_id(cells) != group; };
  while (query.step()) {
    if (query.integer(0) != group) {
      if (changed()) break;
      group = query.integer(0);
      cells.clear();
    }
    const std::int64_t cell = query.integer(1);
    if (cell < 0 || cell > std::numeric_limits<std::uint32_t>::max()) return fmt::format("group_id={}", group);
    cells.push_back(static_cast<std::uint32_t>(cell));
  }
  return changed() ? fmt::format("group_id={}", group) : "";
}

/// @param find  names the first row of the table that is not what was written
template <class Find>
void check_table(const Database& database, const std::string& table, Find find) {
  std::string row;
  try {
    row = find();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{} (table {})", error.what(), table));
  }
  if (!row.empty()) {
    throw InputError(damage(database, fmt::format("table {}, row {}: not what was written", table, row)));
  }
}

/// Checks that no row refers to one that is missing, and that each answer has a verdict, each certificate a timing and,
/// if it is not open, a proof. For two tables whose rows correspond one to one, references and equal numbers suffice.
void check_relations(Database& database) {
  Statement dangling(database, "PRAGMA foreign_key_check");
  if (dangling.step()) {
    throw InputError(damage(database, fmt::format("table {}: a row belongs to no row of table {}", dangling.text(0),
                                                  dangling.text(2))));
  }
  Statement incomplete(database,
                       "SELECT 'answers', 'verdicts' WHERE (SELECT COUNT(*) FROM answers) <> "
                       "(SELECT COUNT(*) FROM verdicts) "
                       "UNION ALL SELECT 'certificates', 'certificate_timings' WHERE (SELECT COUNT(*) FROM certificates) "
                       "<> (SELECT COUNT(*) FROM certificate_timings) "
                       "UNION ALL SELECT 'certificates', 'proofs' FROM certificates c LEFT JOIN proofs p "
                       "USING (problem_id) WHERE (c.certificate <> 'open') <> (p.problem_id IS NOT NULL) LIMIT 1");
  if (!incomplete.step()) return;
  throw InputError(damage(database, fmt::format("table {}: a row is not matched by table {}", incomplete.text(0),
                                                incomplete.text(1))));
}

/// The structure of the file: pages, order of keys, types, indices, whose entries quick_check would not compare with
/// their tables.
void check_structure(Database& database) {
  Statement query(database, "PRAGMA integrity_check(1)");
  if (!query.step() || query.text(0) == "ok") return;
  std::string finding(query.text(0));
  finding.erase(0, finding.rfind('\n') + 1);  // the lines before it name the database only
  throw InputError(damage(database, finding));
}

}  // namespace

std::int64_t key_id(std::initializer_list<std::string_view> parts) {
  std::string key;
  for (const std::string_view part : parts) {
    key += part;
    key += '\0';
  }
  return content_id(key);
}

std::int64_t cell_group_id(const std::vector<std::uint32_t>& cells) {
  std::string key;
  for (const std::uint32_t cell : cells) fmt::format_to(std::back_inserter(key), "{},", cell);
  return key_id({"group", key});
}

bool is_blank(Database& database) { return database.integer("SELECT COUNT(*) FROM sqlite_master") == 0; }

bool begins_as_store(const std::filesystem::path& file) {
  constexpr std::string_view kBegin{"SQLite format 3\0", 16};  // see https://www.sqlite.org/fileformat2.html
  constexpr std::size_t kApplicationIdAt = 68;
  std::array<char, kApplicationIdAt + 4> header{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(header.data(), header.size()) || !std::string_view(header.data(), 16).starts_with(kBegin)) return false;
  std::int64_t application = 0;
  for (std::size_t i = kApplicationIdAt; i < header.size(); ++i) {
    application = application << 8 | static_cast<unsigned char>(header.at(i));
  }
  return application == kApplicationId;
}

void initialise(Database& database) {
  database.execute("BEGIN IMMEDIATE");
  database.execute(store_schema());
  count_totals(database);
  database.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, kVerdictVersion));
  database.execute("COMMIT");
}

void check_application(Database& database) {
  if (database.integer("PRAGMA application_id") != kApplicationId) {
    throw InputError(database.file().string() + ": not an lcpbench store");
  }
}

void check_format(Database& database) {
  check_application(database);
  const std::int64_t version = database.integer("PRAGMA user_version");
  if (version != kVerdictVersion) {
    throw InputError(
        fmt::format("{}: store format {}, this lcpbench reads format {} alone: verdicts have other columns or mean "
                    "something else there; use another store (`run --fresh` replaces it)",
                    database.file().string(), version, kVerdictVersion));
  }
  check_schema(database);
}

void check_content(Database& database) {
  const sqlite::ReadSnapshot snapshot(database);  // another process may be writing
  for (const std::string& table : tables_with_checksums(database)) {
    check_table(database, table, [&] { return changed_row(database, table); });
  }
  check_table(database, "cell_groups", [&] { return changed_group(database); });
  check_table(database, "vectors", [&] { return changed_vector(database); });
  check_totals(database);
  check_structure(database);
  check_relations(database);
}

}  // namespace lcpbench
