// SPDX-License-Identifier: Apache-2.0
#include "collinea/store/internal/covariance_tables.h"

#include <cstdint>
#include <string>
#include <utility>

#include "collinea/base/packed.h"
#include "collinea/store/internal/project_store_state.h"
#include "collinea/store/internal/record_chunks.h"

namespace collinea {
namespace {

using sqlite::Database;

// A symmetric matrix: its lower triangle, row by row.
template <class Matrix>
void put_symmetric(Packer& packer, const Matrix& m) {
  for (Eigen::Index row = 0; row < m.rows(); ++row)
    for (Eigen::Index column = 0; column <= row; ++column) packer.put(m(row, column));
}
template <class Matrix>
void get_symmetric(Unpacker& unpacker, Matrix& m) {
  for (Eigen::Index row = 0; row < m.rows(); ++row)
    for (Eigen::Index column = 0; column <= row; ++column) {
      unpacker.get(m(row, column));
      m(column, row) = m(row, column);
    }
}

struct PointCovarianceRecord {
  static constexpr std::size_t kBytes = 6 * 8;
  using Value = Eigen::Matrix3d;
  static void put_one(Packer& packer, const Eigen::Matrix3d& covariance) { put_symmetric(packer, covariance); }
  static Value get_one(Unpacker& unpacker) {
    Eigen::Matrix3d covariance;
    get_symmetric(unpacker, covariance);
    return covariance;
  }
};

// Matrices of any size, by id.
template <class Matrices>
Result<> write_covariances(Database& db, const std::string& table, const Matrices& matrices) {
  COLLINEA_TRY(db.execute("DELETE FROM " + table));
  COLLINEA_TRY(auto insert, db.prepare("INSERT INTO " + table + " VALUES (?, ?, ?)"));
  for (const auto& [id, matrix] : matrices) {
    Packer packer;
    put_symmetric(packer, matrix);
    COLLINEA_TRY(insert.bind(id.value).bind(static_cast<std::int64_t>(matrix.rows())).bind_blob(packer.bytes()).run());
  }
  return {};
}

template <class Matrices>
Result<> read_covariances(Database& db, const std::string& table, Matrices& matrices) {
  constexpr std::int64_t kMostRows = 1000;
  using Matrix = typename Matrices::mapped_type;
  COLLINEA_TRY(auto select, db.prepare("SELECT id, size, data FROM " + table + " ORDER BY id"));
  while (true) {
    COLLINEA_TRY(const bool row, select.next());
    if (!row) return {};
    const std::int64_t size = select.integer(1);
    const bool fits = Matrix::RowsAtCompileTime == Eigen::Dynamic || size == Matrix::RowsAtCompileTime;
    if (size < 1 || size > kMostRows || !fits) return damaged("a covariance matrix");
    Matrix matrix(size, size);
    Unpacker unpacker(select.blob(2));
    get_symmetric(unpacker, matrix);
    if (!unpacker.done()) return damaged("a covariance matrix");
    matrices[{static_cast<std::uint32_t>(select.integer(0))}] = std::move(matrix);
  }
}

}  // namespace

Result<> write_covariance_tables(Database& db, const BlockCovariances& covariances) {
  COLLINEA_TRY(write_covariances(db, "pose_covariances", covariances.poses));
  COLLINEA_TRY(write_covariances(db, "camera_covariances", covariances.cameras));
  return write_chunks<PointCovarianceRecord>(db, "point_covariances", covariances.points);
}

Result<BlockCovariances> read_covariance_tables(Database& db) {
  BlockCovariances covariances;
  COLLINEA_TRY(read_covariances(db, "pose_covariances", covariances.poses));
  COLLINEA_TRY(read_covariances(db, "camera_covariances", covariances.cameras));
  if (Result<> read = read_chunks<PointCovarianceRecord>(
          db, "point_covariances", [&](const Eigen::Matrix3d& one) { covariances.points.push_back(one); });
      !read)
    return tl::unexpected(read.error());
  return covariances;
}

}  // namespace collinea
