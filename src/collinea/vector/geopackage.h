// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

enum class VectorKind { kPoint, kLine, kPolygon };

/// A field of a table; what kind of value it holds follows from the first alternative of VectorValue that is meant.
enum class VectorType { kReal, kInteger, kText };
struct VectorField {
  std::string name;  ///< with its unit: "sigma_h_m"
  VectorType type = VectorType::kReal;
};

/// Nothing (NULL), or a value; a number that is not finite counts as nothing.
using VectorValue = std::variant<std::monostate, double, std::int64_t, std::string>;

struct VectorRow {
  std::vector<Eigen::Vector3d> positions;                ///< one of a point; a polygon is closed by itself [m]
  std::vector<VectorValue> values;                       ///< one for each field
  std::vector<std::vector<Eigen::Vector3d>> holes = {};  ///< of a polygon, closed by themselves
};

struct VectorLayer {
  std::string name;
  VectorKind kind = VectorKind::kPoint;
  std::vector<VectorField> fields;
  std::vector<VectorRow> rows;
  bool flat = false;  ///< positions without heights
};

/// Writes the layers into one GeoPackage, atomically. `wkt`: of the CRS; empty: a local
/// frame. The same layers give the same bytes. By GDAL. Errors: not writable, GDAL without the format.
[[nodiscard]] Result<> write_geopackage(const std::filesystem::path& path, const std::vector<VectorLayer>& layers,
                                        const std::string& wkt);

}  // namespace collinea
