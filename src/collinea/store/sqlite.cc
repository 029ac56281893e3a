// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/sqlite.h"

#include <sqlite3.h>

namespace collinea::sqlite {
namespace {

tl::unexpected<Error> failure(sqlite3* database, int code) {
  const std::string reason = database ? sqlite3_errmsg(database) : sqlite3_errstr(code);
  switch (code & 0xff) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
      return fail(Errc::kBadFormat, "damaged, or not a database: " + reason);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return fail(Errc::kBadInput, "in use by another program");
    case SQLITE_FULL:
      return fail(Errc::kBadInput, "the disk is full");
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return fail(Errc::kBadInput, "cannot be written: " + reason);
    case SQLITE_CANTOPEN:
      return fail(Errc::kNotFound, "cannot be opened: " + reason);
    default:
      return fail(Errc::kBadFormat, reason);
  }
}

}  // namespace

void Statement::Finalise::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

void Statement::note(int code) {
  if (code != SQLITE_OK && error_ == SQLITE_OK) error_ = code;
}

Statement& Statement::bind(std::int64_t value) {
  note(sqlite3_bind_int64(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind(double value) {
  note(sqlite3_bind_double(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind_text(std::string_view text) {
  const char* data = text.data() ? text.data() : "";
  note(sqlite3_bind_text64(statement_.get(), ++bound_, data, text.size(), SQLITE_STATIC, SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind_blob(std::string_view bytes) {
  const char* data = bytes.data() ? bytes.data() : "";  // a null pointer would store NULL
  note(sqlite3_bind_blob64(statement_.get(), ++bound_, data, bytes.size(), SQLITE_STATIC));
  return *this;
}

Statement& Statement::bind_null() {
  note(sqlite3_bind_null(statement_.get(), ++bound_));
  return *this;
}

Result<bool> Statement::next() {
  sqlite3* database = sqlite3_db_handle(statement_.get());
  if (error_ != SQLITE_OK) return failure(database, error_);
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return failure(database, code);
}

Result<> Statement::run() {
  const Result<bool> row = next();
  sqlite3_reset(statement_.get());
  bound_ = 0;
  if (!row) return tl::unexpected(row.error());
  return {};
}

int Statement::columns() const { return sqlite3_column_count(statement_.get()); }

bool Statement::is_null(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }

double Statement::real(int column) const { return sqlite3_column_double(statement_.get(), column); }

std::string Statement::text(int column) const {
  const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return data ? std::string(data, std::size_t(sqlite3_column_bytes(statement_.get(), column))) : std::string();
}

std::string_view Statement::blob(int column) const {
  const auto* data = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
  return data ? std::string_view(data, std::size_t(sqlite3_column_bytes(statement_.get(), column)))
              : std::string_view();
}

void Database::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Result<Database> Database::open(const std::filesystem::path& path, std::chrono::milliseconds patience) {
  sqlite3* raw = nullptr;
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  const int code = sqlite3_open_v2(path.c_str(), &raw, flags, nullptr);
  Database database;
  database.database_.reset(raw);  // also a failed open leaves a handle, with the reason in it
  if (code != SQLITE_OK) return failure(raw, code);
  sqlite3_busy_timeout(raw, static_cast<int>(patience.count()));
  return database;
}

Result<Database> Database::open_read_only(const std::filesystem::path& path) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string())
    if (c == '%' || c == '?' || c == '#') {
      constexpr std::string_view kHex = "0123456789ABCDEF";
      uri += {'%', kHex[static_cast<unsigned char>(c) / 16], kHex[static_cast<unsigned char>(c) % 16]};
    } else {
      uri += c;
    }
  std::error_code none;
  const auto journal = std::filesystem::file_size(path.string() + "-wal", none);
  uri += !none && journal > 0 ? "?mode=ro" : "?immutable=1";  // an empty journal needs no lock file
  sqlite3* raw = nullptr;
  const int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
  const int code = sqlite3_open_v2(uri.c_str(), &raw, flags, nullptr);
  Database database;
  database.database_.reset(raw);
  if (code != SQLITE_OK) return failure(raw, code);
  sqlite3_busy_timeout(raw, static_cast<int>(kPatience.count()));
  return database;
}

Result<> Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return failure(database_.get(), code);
  return {};
}

Result<Statement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* raw = nullptr;
  const int code = sqlite3_prepare_v2(database_.get(), sql.data(), int(sql.size()), &raw, nullptr);
  if (code != SQLITE_OK) return failure(database_.get(), code);
  Statement statement;
  statement.statement_.reset(raw);
  return statement;
}

Result<std::int64_t> Database::integer(std::string_view sql) {
  COLLINEA_TRY(Statement statement, prepare(sql));
  COLLINEA_TRY(const bool row, statement.next());
  return row ? statement.integer(0) : 0;
}

Result<Transaction> Transaction::begin(Database& database) {
  COLLINEA_TRY(database.execute("BEGIN IMMEDIATE"));
  return Transaction(database);
}

Result<Transaction> Transaction::begin_reading(Database& database) {
  COLLINEA_TRY(database.execute("BEGIN"));
  return Transaction(database);
}

Result<> Transaction::commit() {
  auto committed = database_->execute("COMMIT");
  if (committed) database_ = nullptr;
  return committed;
}

Transaction::~Transaction() {
  if (database_) (void)database_->execute("ROLLBACK");
}

}  // namespace collinea::sqlite
