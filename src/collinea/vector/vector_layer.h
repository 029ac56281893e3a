// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

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

/// How QGIS draws a layer when it is opened: one symbol for all of it, and the text of a field beside each.
struct VectorStyle {
  std::array<std::uint8_t, 3> colour{};  ///< red, green, blue: of lines, outlines and points
  double width_mm = 0.3;                 ///< of lines and outlines
  double size_mm = 2;                    ///< of points
  std::uint8_t fill_opacity = 40;        ///< of polygons, of 255
  std::string label = {};                ///< the field; empty: none
};

struct VectorLayer {
  std::string name;
  VectorKind kind = VectorKind::kPoint;
  std::vector<VectorField> fields;
  std::vector<VectorRow> rows;
  bool flat = false;             ///< positions without heights
  std::string description = {};  ///< what it shows, for people
  std::optional<VectorStyle> style = {};
  bool indexed = true;  ///< by position, for whoever looks at a part of it; takes as long as writing the rows
};

}  // namespace collinea
