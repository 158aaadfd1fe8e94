#include "study/store/sqlite.h"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <sqlite3.h>

#include "core/error.h"
#include "study/store/row_checksum.h"

namespace lcpbench::sqlite {
namespace {

constexpr int kBusyTimeoutMs = 10000;

/// The name of a file that SQLite reads as nothing else: no ":memory:", no URI, no nameless temporary database.
std::string plain_name(const std::filesystem::path& file) {
  return file.is_absolute() ? file.string() : "./" + file.string();
}

int open_flags(Mode mode) {
  switch (mode) {
    case Mode::kReadOnly: return SQLITE_OPEN_READONLY;
    case Mode::kReadWrite: return SQLITE_OPEN_READWRITE;
    case Mode::kInMemory: return SQLITE_OPEN_READWRITE | SQLITE_OPEN_MEMORY;
    case Mode::kReadWriteCreate: break;
  }
  return SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
}

/// Primary result codes of errors that a user can mend.
constexpr std::array kMendable{SQLITE_BUSY, SQLITE_LOCKED,   SQLITE_READONLY, SQLITE_IOERR, SQLITE_CORRUPT,
                               SQLITE_FULL, SQLITE_CANTOPEN, SQLITE_PERM,     SQLITE_NOTADB};

}  // namespace

Database::Database(const std::filesystem::path& file, Mode mode) : file_(file) {
  const int code =
      sqlite3_open_v2(plain_name(file).c_str(), &handle_, open_flags(mode) | SQLITE_OPEN_NOMUTEX, nullptr);
  if (code != SQLITE_OK) {
    sqlite3_close(handle_);
    handle_ = nullptr;
    fail(code);
  }
  sqlite3_extended_result_codes(handle_, 1);
  sqlite3_busy_timeout(handle_, kBusyTimeoutMs);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  // A store whose log is missing has lost rows: only its writer's good end may take the log away.
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  add_row_checksum(handle_);
}

Database::~Database() { sqlite3_close(handle_); }

void Database::fail(int code) const {
  const int primary = code & 0xff;
  if (code == SQLITE_READONLY_ROLLBACK) {
    throw InputError(file_.string() + ": its writer was killed and left " + file_.string() +
                     "-journal, which has to be rolled back first, but the store or its folder cannot be written");
  }
  if (primary == SQLITE_NOTADB) throw InputError(file_.string() + ": not an lcpbench store");
  const std::string cause = handle_ != nullptr ? sqlite3_errmsg(handle_) : sqlite3_errstr(code);
  // A file that is damaged can claim rows of any size, and a format that SQLite does not know.
  const bool damaged = primary == SQLITE_CORRUPT || primary == SQLITE_TOOBIG || cause == "unsupported file format";
  if (damaged) throw InputError(file_.string() + ": the store is damaged: " + cause);
  if (std::ranges::find(kMendable, primary) != kMendable.end()) throw InputError(file_.string() + ": " + cause);
  throw std::runtime_error(file_.string() + ": " + cause);
}

void Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

bool Database::execute_unless_locked(const std::string& sql) {
  sqlite3_busy_timeout(handle_, 0);
  const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
  sqlite3_busy_timeout(handle_, kBusyTimeoutMs);
  if ((code & 0xff) == SQLITE_BUSY) return false;
  if (code != SQLITE_OK) fail(code);
  return true;
}

std::int64_t Database::integer(const std::string& sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

std::vector<std::string> Database::texts(const std::string& sql) {
  Statement statement(*this, sql);
  std::vector<std::string> texts;
  while (statement.step()) texts.emplace_back(statement.text(0));
  return texts;
}

std::vector<std::string> Database::columns(std::string_view table) {
  return texts(fmt::format("SELECT name FROM pragma_table_info('{}') ORDER BY cid", table));
}

ReadSnapshot::ReadSnapshot(Database& database) {
  if (sqlite3_get_autocommit(database.handle()) == 0) return;
  database.execute("BEGIN");
  handle_ = database.handle();
}

ReadSnapshot::~ReadSnapshot() {
  // Nothing was written that an error could lose.
  if (handle_ != nullptr) sqlite3_exec(handle_, "COMMIT", nullptr, nullptr, nullptr);
}

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  check(sqlite3_prepare_v3(database.handle(), sql.data(), static_cast<int>(sql.size()), SQLITE_PREPARE_PERSISTENT,
                           &statement_, nullptr));
}

Statement::~Statement() { sqlite3_finalize(statement_); }

void Statement::check(int code) const {
  if (code != SQLITE_OK) database_.fail(code);
}

void Statement::bind_integer(int parameter, std::int64_t value) {
  check(sqlite3_bind_int64(statement_, parameter, value));
}

void Statement::bind(int parameter, double value) { check(sqlite3_bind_double(statement_, parameter, value)); }

void Statement::bind(int parameter, std::string_view text) {
  check(sqlite3_bind_text(statement_, parameter, text.data(), static_cast<int>(text.size()), SQLITE_STATIC));
}

void Statement::bind(int parameter, Blob blob) {
  check(
      sqlite3_bind_blob(statement_, parameter, blob.bytes.data(), static_cast<int>(blob.bytes.size()), SQLITE_STATIC));
}

void Statement::bind_row(const Statement& row) {
  for (int i = 0; i < row.columns(); ++i) {
    check(sqlite3_bind_value(statement_, i + 1, sqlite3_column_value(row.statement_, i)));
  }
}

void Statement::bind_null(int parameter) { check(sqlite3_bind_null(statement_, parameter)); }

bool Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) database_.fail(code);
  return false;
}

void Statement::reset() { sqlite3_reset(statement_); }

int Statement::columns() const { return sqlite3_column_count(statement_); }
bool Statement::is_null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_, column); }

double Statement::real(int column) const {
  return is_null(column) ? std::numeric_limits<double>::quiet_NaN() : sqlite3_column_double(statement_, column);
}

std::string_view Statement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_, column);
  if (text == nullptr) return {};
  return {reinterpret_cast<const char*>(text), static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

std::string_view Statement::blob(int column) const {
  const void* bytes = sqlite3_column_blob(statement_, column);
  if (bytes == nullptr) return {};
  return {static_cast<const char*>(bytes), static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

}  // namespace lcpbench::sqlite
