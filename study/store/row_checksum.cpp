#include "study/store/row_checksum.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <exception>

#include <fmt/format.h>
#include <sqlite3.h>

#include "study/store/vector_codec.h"

namespace lcpbench::sqlite {
namespace {

void append(std::string& bytes, char type, std::uint64_t value) {
  bytes += type;
  for (unsigned i = 0; i < 8; ++i) bytes += static_cast<char>((value >> (8 * i)) & 0xff);
}

void append(std::string& bytes, sqlite3_value* value) {
  const int type = sqlite3_value_type(value);
  switch (type) {
    case SQLITE_INTEGER: return append(bytes, 'i', static_cast<std::uint64_t>(sqlite3_value_int64(value)));
    case SQLITE_FLOAT:  // -0.0 + 0.0 is 0.0
      return append(bytes, 'r', std::bit_cast<std::uint64_t>(sqlite3_value_double(value) + 0.0));
    case SQLITE_NULL: bytes += 'n'; return;
    default: break;
  }
  // The value of a text or blob, before its size.
  const void* const data = type == SQLITE_TEXT ? sqlite3_value_text(value) : sqlite3_value_blob(value);
  const auto size = static_cast<std::size_t>(sqlite3_value_bytes(value));
  append(bytes, type == SQLITE_TEXT ? 't' : 'b', size);
  if (size > 0) bytes.append(static_cast<const char*>(data), size);
}

void row_checksum(sqlite3_context* context, int count, sqlite3_value** values) {
  static thread_local std::string bytes;  // keeps its memory from row to row
  try {
    bytes.clear();
    for (int i = 0; i < count; ++i) append(bytes, values[i]);
    sqlite3_result_int64(context, content_id(bytes));
  } catch (const std::exception&) {
    sqlite3_result_error_nomem(context);
  }
}

}  // namespace

void add_row_checksum(sqlite3* connection) {
  sqlite3_create_function_v2(connection, "row_checksum", -1, SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_DIRECTONLY,
                             nullptr, row_checksum, nullptr, nullptr, nullptr);
}

std::string insert_row(std::string_view verb, std::string_view table, std::string_view columns) {
  std::string marks = "?1";
  for (std::ptrdiff_t i = 0; i < std::count(columns.begin(), columns.end(), ','); ++i) {
    marks += fmt::format(", ?{}", i + 2);
  }
  return fmt::format("{} INTO {} ({}, checksum) VALUES ({}, row_checksum({}))", verb, table, columns, marks, marks);
}

std::string insert_new(std::string_view table, std::string_view columns) {
  return insert_row("INSERT OR IGNORE", table, columns);
}

std::string row_checksum_of(Database& database, std::string_view table, std::string_view changed,
                            std::string_view value) {
  std::vector<std::string> columns = database.columns(table);
  std::erase(columns, "checksum");
  std::replace(columns.begin(), columns.end(), std::string(changed), std::string(value));
  return fmt::format("row_checksum({})", fmt::join(columns, ", "));
}

}  // namespace lcpbench::sqlite
