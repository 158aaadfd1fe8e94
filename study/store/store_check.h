#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "study/store/sqlite.h"

// Whether a file is a store that can be trusted.

namespace lcpbench {

/// True when the file holds nothing yet: also one whose process was killed before its first commit.
bool is_blank(sqlite::Database& database);

/// True when the file begins as a store of whatever format does. It may be damaged behind that: SQLite, which is not
/// asked, reads nothing of a file that is shorter than its header says.
bool begins_as_store(const std::filesystem::path& file);

/// Makes a blank file a store, whole or not at all.
void initialise(sqlite::Database& database);

/// @throws InputError when the file is no store, of whatever format.
void check_application(sqlite::Database& database);

/// @throws InputError when the file is no store of this format, or its tables, indices and views are not those of a
/// store: a foreign trigger or view could change what is read and written.
void check_format(sqlite::Database& database);

/// Reads the whole store: each row has the content that was written (see study/store/row_checksum.h), each row that was
/// written is there (see study/store/totals.h), rows that belong together are there together, and the file's structure
/// is sound. @throws InputError that names the file, the table and the row.
void check_content(sqlite::Database& database);

/// The id of a group of cells: a hash of their numbers, ascending.
std::int64_t cell_group_id(const std::vector<std::uint32_t>& cells);

/// The id of a key that has several parts.
std::int64_t key_id(std::initializer_list<std::string_view> parts);

}  // namespace lcpbench
