#pragma once

#include <string>
#include <string_view>

#include "study/store/sqlite.h"

struct sqlite3;

// Rows of a store carry a checksum of all their other columns, in the column `checksum`, so that no bit of them can
// change unseen. Rows named by their content (`vectors`, `cell_groups`) need none. SQLite has no checksums of what it
// stores: of 400 random flips of one bit in a store of 135 kB, integrity_check found 27, and 67 others changed what
// queries gave.

namespace lcpbench::sqlite {

/// Adds the SQL function row_checksum(value, ...) to a connection: a 63-bit hash of the values with their types. Zeros
/// of both signs are equal, since SQLite does not keep the sign of every zero.
void add_row_checksum(sqlite3* connection);

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

}  // namespace lcpbench::sqlite
