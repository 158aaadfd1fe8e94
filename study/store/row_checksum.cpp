#include "study/store/row_checksum.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <exception>
#include <memory>

#include <fmt/format.h>
#include <sqlite3.h>

#include "study/store/vector_codec.h"

namespace lcpbench::sqlite {
namespace {

void append_number(std::string& bytes, char type, std::uint64_t value) {
  std::array<char, 9> text{type};
  for (unsigned i = 0; i < 8; ++i) text[i + 1] = static_cast<char>((value >> (8 * i)) & 0xff);
  bytes.append(text.data(), text.size());
}

void append_bytes(std::string& bytes, char type, const void* data, int size) {
  append_number(bytes, type, static_cast<std::uint64_t>(size));
  if (size > 0) bytes.append(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

void append_value(std::string& bytes, sqlite3_value* value) {
  switch (sqlite3_value_type(value)) {
    case SQLITE_INTEGER: return append_number(bytes, 'i', static_cast<std::uint64_t>(sqlite3_value_int64(value)));
    case SQLITE_FLOAT:  // -0.0 + 0.0 is 0.0
      return append_number(bytes, 'r', std::bit_cast<std::uint64_t>(sqlite3_value_double(value) + 0.0));
    case SQLITE_TEXT: {
      const unsigned char* const text = sqlite3_value_text(value);
      return append_bytes(bytes, 't', text, sqlite3_value_bytes(value));
    }
    case SQLITE_BLOB: {
      const void* const blob = sqlite3_value_blob(value);
      return append_bytes(bytes, 'b', blob, sqlite3_value_bytes(value));
    }
    default: bytes.push_back('n');
  }
}

void row_checksum(sqlite3_context* context, int count, sqlite3_value** values) {
  try {
    std::string& bytes = *static_cast<std::string*>(sqlite3_user_data(context));
    bytes.clear();
    for (int i = 0; i < count; ++i) append_value(bytes, values[i]);
    sqlite3_result_int64(context, content_id(bytes));
  } catch (const std::exception&) {
    sqlite3_result_error_nomem(context);
  }
}

void forget_buffer(void* buffer) { delete static_cast<std::string*>(buffer); }

}  // namespace

void add_row_checksum(sqlite3* connection) {
  auto buffer = std::make_unique<std::string>();
  sqlite3_create_function_v2(connection, "row_checksum", -1, SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_DIRECTONLY,
                             buffer.release(), row_checksum, nullptr, nullptr, forget_buffer);
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
  Statement columns(database, fmt::format("SELECT name FROM pragma_table_info('{}')", table));
  std::string values;
  while (columns.step()) {
    const std::string_view column = columns.text(0);
    if (column == "checksum") continue;
    values += fmt::format("{}{}", values.empty() ? "" : ", ", column == changed ? value : column);
  }
  return fmt::format("row_checksum({})", values);
}

bool has_its_checksum(const Statement& row, std::string& buffer) {
  buffer.clear();
  const int checksum = row.columns() - 1;
  // No other thread uses the connection, so that the values of a row can be read like those of a function.
  for (int i = 0; i < checksum; ++i) append_value(buffer, sqlite3_column_value(row.handle(), i));
  return content_id(buffer) == row.integer(checksum);
}

}  // namespace lcpbench::sqlite
