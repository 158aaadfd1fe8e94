#include "study/store/row_checksum.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <exception>
#include <limits>

#include <fmt/format.h>
#include <sqlite3.h>

#include "study/store/vector_codec.h"

namespace lcpbench::sqlite {
namespace {

void row_checksum(sqlite3_context* context, int count, sqlite3_value** values) {
  try {
    RowCopy& row = *static_cast<RowCopy*>(sqlite3_user_data(context));
    row.clear();
    for (int i = 0; i < count; ++i) row.append(values[i]);
    sqlite3_result_int64(context, content_id(row.bytes()));
  } catch (const std::exception&) {
    sqlite3_result_error_nomem(context);
  }
}

void forget(void* row) { delete static_cast<RowCopy*>(row); }

constexpr const char* kRowPointer = "RowCopy";

/// copy_row(pointer to a RowCopy, value, ...), of which the first value is an integer: the result.
void copy_row(sqlite3_context* context, int count, sqlite3_value** values) {
  auto* row = static_cast<RowCopy*>(sqlite3_value_pointer(values[0], kRowPointer));
  if (row == nullptr) return sqlite3_result_null(context);
  try {
    row->clear();
    for (int i = 1; i < count; ++i) row->append(values[i]);
    sqlite3_result_int64(context, row->integer(0));
  } catch (const std::exception&) {
    sqlite3_result_error_nomem(context);
  }
}

}  // namespace

void RowCopy::clear() {
  size_ = 0;
  places_.clear();
}

void RowCopy::append(sqlite3_value* value) {
  places_.push_back(size_);
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

void RowCopy::append(char type, std::uint64_t value) {
  std::array<char, kValue> bytes{type};
  for (unsigned i = 0; i < 8; ++i) bytes[i + 1] = static_cast<char>((value >> (8 * i)) & 0xff);
  append(bytes.data(), bytes.size());
}

void RowCopy::append(const void* data, std::size_t size) {
  if (bytes_.size() < size_ + size) bytes_.resize(2 * (size_ + size) + 256);
  if (size > 0) std::memcpy(bytes_.data() + size_, data, size);
  size_ += size;
}

std::uint64_t RowCopy::value(int column) const {
  if (is_null(column)) return 0;
  const char* bytes = bytes_.data() + places_[static_cast<std::size_t>(column)] + 1;
  std::uint64_t value = 0;
  for (unsigned i = 0; i < 8; ++i) value |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  return value;
}

double RowCopy::real(int column) const {
  switch (type(column)) {
    case 'r': return std::bit_cast<double>(value(column));
    case 'i': return static_cast<double>(integer(column));
    default: return std::numeric_limits<double>::quiet_NaN();
  }
}

std::string_view RowCopy::text(int column) const {
  if (type(column) != 't') return {};
  return bytes().substr(places_[static_cast<std::size_t>(column)] + kValue, value(column));
}

bool RowCopy::is_as_written() const {
  return content_id({bytes_.data(), places_.back()}) == checksum();
}

std::string copying_query(Database& database, std::string_view table, std::string_view from) {
  return fmt::format("SELECT copy_row(?2, {}) FROM {}", fmt::join(database.columns(table), ", "), from);
}

void bind_copy(Statement& query, RowCopy& row) {
  sqlite3_bind_pointer(query.handle(), 2, &row, kRowPointer, nullptr);
}

void add_row_functions(sqlite3* connection) {
  sqlite3_create_function_v2(connection, "row_checksum", -1, SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_DIRECTONLY,
                             new RowCopy, row_checksum, nullptr, nullptr, forget);
  sqlite3_create_function_v2(connection, "copy_row", -1, SQLITE_UTF8 | SQLITE_DIRECTONLY, nullptr, copy_row, nullptr,
                             nullptr, nullptr);
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
