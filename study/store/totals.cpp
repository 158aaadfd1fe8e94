#include "study/store/totals.h"

#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"

namespace lcpbench {
namespace {

using sqlite::Database;
using sqlite::Statement;

constexpr std::int64_t kModulus = std::int64_t{1} << 62;  // a sum of two remainders fits in 64 bits

struct Counted {
  std::string table;
  std::string term;  ///< the column that is summed: `checksum`, or an id that is a hash of the content
};

std::vector<Counted> counted_tables(Database& database) {
  Statement query(database,
                  "SELECT m.name, c.name FROM sqlite_master m JOIN pragma_table_info(m.name) c WHERE m.type = 'table' "
                  "AND c.name = CASE m.name WHEN 'vectors' THEN 'id' WHEN 'cell_groups' THEN 'group_id' "
                  "ELSE 'checksum' END ORDER BY m.name");
  std::vector<Counted> tables;
  while (query.step()) tables.push_back({std::string(query.text(0)), std::string(query.text(1))});
  return tables;
}

/// A query for the number of rows and the sum modulo kModulus. The low 31 bits and those above are summed apart, as a
/// SUM that exceeds 64 bits is an error.
std::string totals_of(const Counted& counted) {
  return fmt::format(
      "SELECT COUNT(*), IFNULL((SUM({0} & {1}) + ((SUM({0} >> 31) & {1}) << 31)) & {2}, 0) FROM {3}",
      counted.term, (std::int64_t{1} << 31) - 1, kModulus - 1, counted.table);
}

}  // namespace

void count_totals(Database& database) {
  for (const Counted& counted : counted_tables(database)) {
    database.execute(fmt::format("INSERT OR REPLACE INTO totals (name, row_count, digest) SELECT '{}', * FROM ({})",
                                 counted.table, totals_of(counted)));
  }
}

void keep_totals(Database& database) {
  database.execute("PRAGMA recursive_triggers = ON");  // without it, replacing a row fires no DELETE trigger
  for (const Counted& counted : counted_tables(database)) {
    const auto count = [&](const char* event, const char* rows, const std::string& difference) {
      database.execute(fmt::format(
          "CREATE TEMP TRIGGER {0}_{1} AFTER {0} ON main.{1} BEGIN UPDATE totals SET row_count = row_count + {2}, "
          "digest = (digest + {3}) & {4} WHERE name = '{1}'; END",
          event, counted.table, rows, difference, kModulus - 1));
    };
    const std::string added = fmt::format("(NEW.{} & {})", counted.term, kModulus - 1);
    const std::string removed = fmt::format("(OLD.{} & {})", counted.term, kModulus - 1);
    count("INSERT", "1", added);
    count("DELETE", "-1", "-" + removed);
    count("UPDATE", "0", added + " - " + removed);
  }
}

void check_totals(Database& database) {
  for (const Counted& counted : counted_tables(database)) {
    Statement kept(database, "SELECT row_count, digest FROM totals WHERE name = ?");
    kept.bind_all(std::string_view(counted.table));
    const bool known = kept.step();
    Statement found(database, totals_of(counted));
    found.step();
    if (known && found.integer(0) == kept.integer(0) && found.integer(1) == kept.integer(1)) continue;
    throw InputError(fmt::format("{}: the store is damaged: table {}: its {} rows are not the {} that were written",
                                 database.file().string(), counted.table, found.integer(0),
                                 known ? fmt::to_string(kept.integer(0)) : "rows"));
  }
}

}  // namespace lcpbench
