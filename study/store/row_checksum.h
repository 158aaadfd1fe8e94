#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "study/store/sqlite.h"

struct sqlite3;
struct sqlite3_value;

// Rows of a store carry a checksum of all their other columns, in the column `checksum`, so that no bit of them can
// change unseen. Rows named by their content (`vectors`, `cell_groups`) need none. SQLite has no checksums of what it
// stores: of 400 random flips of one bit in a store of 135 kB, integrity_check found 27, and 67 others changed what
// queries gave.

namespace lcpbench::sqlite {

/// Adds the SQL function row_checksum(value, ...) to a connection: a 63-bit hash of the values with their types. Zeros
/// of both signs are equal, since SQLite does not keep the sign of every zero. And copy_row(), see copying_query().
void add_row_functions(sqlite3* connection);

/// "VERB INTO table (columns, checksum) VALUES (?1, ..., row_checksum(?1, ...))".
/// @param verb  "INSERT" for a row that is not there yet, "INSERT OR REPLACE", "INSERT OR IGNORE"; the last one also
/// drops a row that breaks a rule of its table, such as a time that is not a number
/// @param columns  all columns of the table but `checksum`, in the table's order, with commas between them
/// @pre each parameter is bound in its column's type (1.0, not 1, for REAL): the checksum is of the value that was
/// bound
std::string insert_row(std::string_view verb, std::string_view table, std::string_view columns);
/// The same for a row that may be there already, and then stays.
std::string insert_new(std::string_view table, std::string_view columns);

/// "row_checksum(a, b, ...)" over the columns of a table, with `value` in the place of the column `changed`.
std::string row_checksum_of(Database& database, std::string_view table, std::string_view changed = "",
                            std::string_view value = "");

/// A copy of a row: its values with their types, of which the checksum is taken. It keeps its memory from row to row.
/// See also read_columns().
class RowCopy {
 public:
  void clear();
  void append(sqlite3_value* value);
  std::string_view bytes() const { return {bytes_.data(), size_}; }
  int columns() const { return static_cast<int>(places_.size()); }

  // Of a column, without conversions: integer() of an integer or null, real() of a real, text() of a text.
  bool is_null(int column) const { return type(column) == 'n'; }
  std::int64_t integer(int column) const { return static_cast<std::int64_t>(value(column)); }
  double real(int column) const;
  std::string_view text(int column) const;

  // Of a row whose last column is its checksum.
  std::int64_t checksum() const { return integer(columns() - 1); }
  bool is_as_written() const;

 private:
  static constexpr std::size_t kValue = 9;  // bytes: its type, and a number or a size
  void append(char type, std::uint64_t value);
  void append(const void* data, std::size_t size);
  char type(int column) const { return bytes_[places_[static_cast<std::size_t>(column)]]; }
  std::uint64_t value(int column) const;

  std::vector<char> bytes_;
  std::vector<std::size_t> places_;  ///< of the columns
  std::size_t size_ = 0;
};

/// A query of which each step copies a whole row of a table to the RowCopy that bind_copy() bound. One call for the row
/// instead of one for each column, twice, for the checksum and for its value, saves a quarter of the time of a report.
/// @param from  "table ORDER BY ...", with ?1 as a parameter. SQLite must not have to sort: the order is that of a key.
std::string copying_query(Database& database, std::string_view table, std::string_view from);
void bind_copy(Statement& query, RowCopy& row);

}  // namespace lcpbench::sqlite
