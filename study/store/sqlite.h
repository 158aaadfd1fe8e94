#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace lcpbench::sqlite {

enum class Mode { kReadOnly, kReadWrite, kReadWriteCreate, kInMemory };

/// One connection. Not thread-safe. The file's name is taken as it is: ":memory:" and "file:x" are files of these
/// names. Nothing that a file brings along (triggers, functions in its views) can do more than read and write tables,
/// and closing the connection leaves a write-ahead log where it is.
///
/// Errors that a user can mend (no database, damaged, full disk, no permission) are InputError naming the file; all
/// others are std::runtime_error.
class Database {
 public:
  Database(const std::filesystem::path& file, Mode mode);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Runs any number of statements without results.
  void execute(const std::string& sql);
  /// The same, without waiting: false, and nothing is done, when the lock of another connection is in the way.
  bool execute_unless_locked(const std::string& sql);
  /// The first column of the first row of a query that has one, as an integer.
  std::int64_t integer(const std::string& sql);
  /// The first column of all rows of a query, as texts.
  std::vector<std::string> texts(const std::string& sql);
  /// The names of a table's columns, in their order; none if there is no such table. @param table  free of quotes
  std::vector<std::string> columns(std::string_view table);

  const std::filesystem::path& file() const { return file_; }
  sqlite3* handle() const { return handle_; }
  /// Throws the exception that belongs to a result code.
  [[noreturn]] void fail(int code) const;

 private:
  std::filesystem::path file_;
  sqlite3* handle_ = nullptr;
};

/// While it lives, all queries of a connection see the database as it was at the first of them, whatever other
/// connections commit. Inside a transaction, which has that already, it does nothing. For reading only: at its end it
/// commits and ignores errors.
class ReadSnapshot {
 public:
  explicit ReadSnapshot(Database& database);
  ~ReadSnapshot();
  ReadSnapshot(const ReadSnapshot&) = delete;
  ReadSnapshot& operator=(const ReadSnapshot&) = delete;

 private:
  sqlite3* handle_ = nullptr;  // nullptr where a transaction was open
};

/// Bytes, as against text.
struct Blob {
  std::string_view bytes;
};

/// One prepared statement: bind, step, reset, again. Parameters and columns count from 1 and 0, as in SQLite.
class Statement {
 public:
  Statement(Database& database, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  template <std::integral Integer>
  void bind(int parameter, Integer value) {
    bind_integer(parameter, static_cast<std::int64_t>(value));
  }
  /// NaN becomes NULL.
  void bind(int parameter, double value);
  /// The text must live until the next reset.
  void bind(int parameter, std::string_view text);
  void bind(int parameter, Blob blob);
  /// nullopt becomes NULL.
  template <class Value>
  void bind(int parameter, const std::optional<Value>& value) {
    value ? bind(parameter, *value) : bind_null(parameter);
  }
  /// The parameters from the first on.
  template <class... Values>
  void bind_all(const Values&... values) {
    int parameter = 0;
    (bind(++parameter, values), ...);
  }

  /// The row of another statement, column by column.
  void bind_row(const Statement& row);

  /// True when there is a row.
  bool step();
  void reset();
  /// Runs a statement without rows, with these parameters, or those that are bound.
  template <class... Values>
  void run(const Values&... values) {
    bind_all(values...);
    step();
    reset();
  }

  /// Reads columns in their order: numbers, bool, std::string. @returns the column after them
  template <class... Targets>
  int read(int first_column, Targets&... targets) const {
    int column = first_column;
    (read_one(column++, targets), ...);
    return column;
  }
  bool is_null(int column) const;
  std::int64_t integer(int column) const;
  /// NULL becomes NaN.
  double real(int column) const;
  /// Valid until the next step or reset.
  std::string_view text(int column) const;
  std::string_view blob(int column) const;
  int columns() const;

 private:
  template <class Target>
  void read_one(int column, Target& target) const {
    if constexpr (std::is_same_v<Target, std::string>) {
      target = text(column);
    } else if constexpr (std::is_same_v<Target, double>) {
      target = real(column);
    } else {
      target = static_cast<Target>(integer(column));
    }
  }
  void check(int code) const;
  void bind_integer(int parameter, std::int64_t value);
  void bind_null(int parameter);

  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
};

}  // namespace lcpbench::sqlite
