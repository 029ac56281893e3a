// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "collinea/base/packed.h"
#include "collinea/base/result.h"
#include "collinea/store/internal/project_store_state.h"
#include "collinea/store/sqlite.h"

namespace collinea {

// Vectors in blobs, and tables of many records of one size: (chunk, data) with many records a row.

inline void put(Packer& packer, const Eigen::Vector2d& v) {
  for (int i = 0; i < 2; ++i) packer.put(v[i]);
}
inline void put(Packer& packer, const Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) packer.put(v[i]);
}
inline void get(Unpacker& unpacker, Eigen::Vector2d& v) {
  for (int i = 0; i < 2; ++i) unpacker.get(v[i]);
}
inline void get(Unpacker& unpacker, Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) unpacker.get(v[i]);
}

/// Many records a row: far fewer and smaller rows than one each, and no blob grows with the block. put(chunk, bytes).
template <class Record, class Values, class Put>
Result<std::int64_t> for_each_chunk(const Values& values, Put&& put) {
  constexpr std::size_t kPerChunk = 16384;
  Packer packer;
  packer.reserve(std::min(kPerChunk, values.size()) * Record::kBytes);
  std::int64_t chunk = 0;
  const auto flush = [&]() -> Result<> {
    COLLINEA_TRY(put(chunk++, packer.bytes()));
    packer.clear();
    return {};
  };
  for (const auto& value : values) {
    Record::put_one(packer, value);
    if (packer.size() == kPerChunk * Record::kBytes) COLLINEA_TRY(flush());
  }
  if (packer.size() > 0) COLLINEA_TRY(flush());
  return chunk;
}

/// Replaces the records of a table.
template <class Record, class Values>
Result<> write_chunks(sqlite::Database& db, const std::string& table, const Values& values) {
  COLLINEA_TRY(db.execute("DELETE FROM " + table));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO " + table + " VALUES (?, ?)"));
  const auto put = [&](std::int64_t chunk, const std::string& bytes) {
    return insert.bind(chunk).bind_blob(bytes).run();
  };
  COLLINEA_TRY([[maybe_unused]] const auto chunks, for_each_chunk<Record>(values, put));
  return {};
}

/// The same; rows alone that differ are written.
template <class Record, class Values>
Result<> update_chunks(sqlite::Database& db, const std::string& table, const Values& values) {
  COLLINEA_TRY(auto replace, db.prepare("INSERT OR REPLACE INTO " + table + " VALUES (?, ?)"));
  const auto put = [&](std::int64_t chunk, const std::string& bytes) -> Result<> {
    COLLINEA_TRY(auto select, db.prepare("SELECT data FROM " + table + " WHERE chunk = ?"));
    COLLINEA_TRY(const bool there, select.bind(chunk).next());
    if (there && select.blob(0) == bytes) return {};
    return replace.bind(chunk).bind_blob(bytes).run();
  };
  COLLINEA_TRY(const auto chunks, for_each_chunk<Record>(values, put));
  COLLINEA_TRY(auto erase, db.prepare("DELETE FROM " + table + " WHERE chunk >= ?"));
  return erase.bind(chunks).run();
}

/// The records of a table, one after the other.
template <class Record>
class ChunkReader {
 public:
  static Result<ChunkReader> open(sqlite::Database& db, const std::string& table) {
    ChunkReader reader;
    reader.table_ = table;
    COLLINEA_TRY(reader.select_, db.prepare("SELECT data FROM " + table + " ORDER BY chunk"));
    COLLINEA_TRY(reader.advance());
    return reader;
  }
  [[nodiscard]] bool at_end() const { return !value_; }
  [[nodiscard]] const typename Record::Value& value() const { return *value_; }
  Result<> advance() {
    while (chunk_.left() == 0) {
      value_.reset();
      COLLINEA_TRY(const bool row, select_.next());
      if (!row) return {};
      const std::string_view blob = select_.blob(0);
      if (blob.size() % Record::kBytes != 0) return damaged(table_);
      chunk_ = Unpacker(blob);
    }
    value_ = Record::get_one(chunk_);
    return {};
  }

 private:
  std::string table_;
  sqlite::Statement select_;
  Unpacker chunk_{std::string_view()};  // of the row that the statement is at
  std::optional<typename Record::Value> value_;
};

template <class Record, class Take>
Result<> read_chunks(sqlite::Database& db, const std::string& table, Take&& take) {
  COLLINEA_TRY(auto reader, ChunkReader<Record>::open(db, table));
  while (!reader.at_end()) {
    take(reader.value());
    COLLINEA_TRY(reader.advance());
  }
  return {};
}

}  // namespace collinea
