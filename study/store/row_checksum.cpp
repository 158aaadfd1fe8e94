#include "study/store/row_checksum.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <sqlite3.h>

#include "study/store/vector_codec.h"

namespace lcpbench::sqlite {
namespace {

/// What a checksum is taken of: of each value its type, a number, and bytes where it has some. Keeps its memory.
class RowBytes {
 public:
  void clear() { size_ = 0; }
  std::string_view text() const { return {bytes_.data(), size_}; }

  void append(sqlite3_value* value) {
    const int type = sqlite3_value_type(value);
    switch (type) {
      case SQLITE_INTEGER: return append('i', static_cast<std::uint64_t>(sqlite3_value_int64(value)));
      case SQLITE_FLOAT:  // -0.0 + 0.0 is 0.0
        return append('r', std::bit_cast<std::uint64_t>(sqlite3_value_double(value) + 0.0));
      case SQLITE_NULL: return append("n", 1);
      default: break;
    }
    // The value of a text or blob, before its size.
    const void* const data = type == SQLITE_TEXT ? sqlite3_value_text(value) : sqlite3_value_blob(value);
    const auto size = static_cast<std::size_t>(sqlite3_value_bytes(value));
    append(type == SQLITE_TEXT ? 't' : 'b', size);
    append(data, size);
  }

 private:
  void append(char type, std::uint64_t value) {
    std::array<char, 9> bytes{type};
    for (unsigned i = 0; i < 8; ++i) bytes[i + 1] = static_cast<char>((value >> (8 * i)) & 0xff);
    append(bytes.data(), bytes.size());
  }
  void append(const void* data, std::size_t size) {
    if (bytes_.size() < size_ + size) bytes_.resize(2 * (size_ + size) + 256);
    if (size > 0) std::memcpy(bytes_.data() + size_, data, size);
    size_ += size;
  }

  std::vector<char> bytes_;
  std::size_t size_ = 0;
};

void row_checksum(sqlite3_context* context, int count, sqlite3_value** values) {
  try {
    RowBytes& bytes = *static_cast<RowBytes*>(sqlite3_user_data(context));
    bytes.clear();
    for (int i = 0; i < count; ++i) bytes.append(values[i]);
    sqlite3_result_int64(context, content_id(bytes.text()));
  } catch (const std::exception&) {
    sqlite3_result_error_nomem(context);
  }
}

void forget_bytes(void* bytes) { delete static_cast<RowBytes*>(bytes); }

}  // namespace

void add_row_checksum(sqlite3* connection) {
  auto bytes = std::make_unique<RowBytes>();
  sqlite3_create_function_v2(connection, "row_checksum", -1, SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_DIRECTONLY,
                             bytes.release(), row_checksum, nullptr, nullptr, forget_bytes);
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

bool has_its_checksum(const Statement& row) {
  thread_local RowBytes bytes;
  bytes.clear();
  const int checksum = row.columns() - 1;
  // No other thread uses the connection, so that the values of a row can be read like those of a function.
  for (int i = 0; i < checksum; ++i) bytes.append(sqlite3_column_value(row.handle(), i));
  return content_id(bytes.text()) == row.integer(checksum);
}

}  // namespace lcpbench::sqlite
