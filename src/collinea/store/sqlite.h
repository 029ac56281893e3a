// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "collinea/base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace collinea::sqlite {

/// How long another program's writing is waited for.
inline constexpr std::chrono::milliseconds kPatience{10'000};

/// A compiled SQL statement. Parameters are bound in order, from the first again after each run.
class Statement {
 public:
  Statement& bind(std::int64_t value);
  Statement& bind(std::uint32_t value) { return bind(std::int64_t{value}); }
  Statement& bind(int value) { return bind(std::int64_t{value}); }
  Statement& bind(double value);
  Statement& bind_text(std::string_view text);   ///< must live until run() or next()
  Statement& bind_blob(std::string_view bytes);  ///< must live until run() or next()
  Statement& bind_null();

  Result<> run();       ///< for statements without rows; ready for new parameters afterwards
  Result<bool> next();  ///< true: there is a row to read columns from

  [[nodiscard]] int columns() const;
  [[nodiscard]] bool is_null(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] std::string_view blob(int column) const;  ///< until the next step; numbers and texts as text

 private:
  friend class Database;
  struct Finalise {
    void operator()(sqlite3_stmt* statement) const;
  };
  void note(int code);  // the first binding error is reported by run() or next()

  std::unique_ptr<sqlite3_stmt, Finalise> statement_;
  int bound_ = 0;
  int error_ = 0;
};

/// One connection. Not thread-safe: its owner locks.
class Database {
 public:
  /// Opens or creates; the file is looked at only by the first statement.
  static Result<Database> open(const std::filesystem::path& path, std::chrono::milliseconds patience = kPatience);
  /// For reading only, without any file made beside it. What another program has not yet moved from its journal into
  /// the file is seen when that journal can be read.
  static Result<Database> open_read_only(const std::filesystem::path& path);

  Result<> execute(const std::string& sql);  ///< one or more statements, no parameters
  Result<Statement> prepare(std::string_view sql);
  Result<std::int64_t> integer(std::string_view sql);  ///< the first column of the first row

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  std::unique_ptr<sqlite3, Close> database_;
};

/// Everything between begin and commit happens, or nothing does: rolled back when not committed.
class Transaction {
 public:
  static Result<Transaction> begin(Database& database);          ///< for writing
  static Result<Transaction> begin_reading(Database& database);  ///< all reads see the same state of the file
  Result<> commit();

  Transaction(Transaction&& other) noexcept : database_(other.database_) { other.database_ = nullptr; }
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();

 private:
  explicit Transaction(Database& database) : database_(&database) {}
  Database* database_;
};

}  // namespace collinea::sqlite
