// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collinea/geometry/rotation.h"
#include "collinea/report/adjustment_report.h"
#include "collinea/vector/vector_layer.h"

namespace collinea {

/// What was adjusted, in the coordinates of the map (of the world frame where that has no location on Earth). Standard
/// deviations and covariances hold sigma0; NaN: not known. East, north, height.
struct ProductImage {
  ImageId image;
  Eigen::Vector3d centre_m;
  OmegaPhiKappa angles;                ///< to the axes of the map at this position
  Eigen::Quaterniond cam_from_map;     ///< the same, w >= 0; the camera's axes: right, down, forward
  Eigen::Matrix3d covariance_m2;       ///< of the centre
  Eigen::Vector3d sigma_rotation_deg;  ///< of small turns about x, y, z of the world
  Eigen::Vector3d sigma_angles_deg;
};
struct ProductPoint {
  PointId point;
  Eigen::Vector3d position_m, in_world_m;
  Eigen::Matrix3d covariance_m2;  ///< east, north, height
  Eigen::Vector3d sigma_in_world_m;
  int images = 0;
};
struct ProductControl {
  const ControlDifference* difference;  ///< of the report
  Eigen::Vector3d position_m;           ///< adjusted; NaN: its rays do not meet
  Eigen::Matrix3d covariance_m2;
};
struct AdjustmentProducts {
  std::string crs, wkt;  ///< empty: a local frame
  std::vector<ProductImage> images;
  std::vector<ProductPoint> points;
  std::vector<ProductControl> control;
};

/// Errors: a CRS that PROJ does not know. Refers to the report.
[[nodiscard]] Result<AdjustmentProducts> products_of(const AdjustmentReport& report);

/// Tables for people and programs.
[[nodiscard]] std::string poses_csv(const AdjustmentReport& report, const AdjustmentProducts& products);
[[nodiscard]] std::string points_csv(const AdjustmentProducts& products);
[[nodiscard]] std::string control_csv(const AdjustmentReport& report, const AdjustmentProducts& products);
/// Images, points, control and cameras as one JSON object; points as rows under their column names.
[[nodiscard]] std::string products_json(const AdjustmentReport& report, const AdjustmentProducts& products);
/// Layers images, tie_points and control of a GeoPackage, with styles for QGIS, and `more` behind them.
[[nodiscard]] Result<> write_products(const AdjustmentReport& report, const AdjustmentProducts& products,
                                      std::vector<VectorLayer> more, const std::filesystem::path& geopackage);

/// Error ellipses and height bars over the block: of points on the ground, and of projection centres.
[[nodiscard]] std::string precision_section(const AdjustmentReport& report, const AdjustmentProducts& products);

}  // namespace collinea
