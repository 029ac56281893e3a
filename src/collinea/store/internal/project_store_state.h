// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <utility>

#include "collinea/base/result.h"
#include "collinea/store/sqlite.h"

namespace collinea {

/// The connection behind a ProjectStore; shared by its source files.
struct ProjectStoreState {
  std::filesystem::path folder;
  std::mutex mutex;
  sqlite::Database database;

  /// Runs work(database) under the lock; errors say which file.
  template <class Work>
  auto read(Work&& work) {
    const std::lock_guard lock(mutex);
    return work(database).map_error(
        [this](Error error) { return std::move(error).within((folder / "block.db").string()); });
  }
  /// The same, in one transaction: all of it or nothing.
  template <class Work>
  Result<> write(Work&& work) {
    return read([&](sqlite::Database& db) -> Result<> {
      COLLINEA_TRY(auto transaction, sqlite::Transaction::begin(db));
      if (Result<> done = work(db); !done) return done;
      return transaction.commit();
    });
  }
};

/// Rows of a database that do not fit together.
[[nodiscard]] inline tl::unexpected<Error> damaged(const std::string& what) {
  return fail(Errc::kBadFormat, "damaged: " + what);
}

}  // namespace collinea
