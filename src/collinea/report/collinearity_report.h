// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "collinea/geodesy/refraction_k.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// Image coordinates of geodetic points in images of known orientation.
struct CollinearityReport {
  struct Row {
    std::string image, point;
    double latitude_deg = 0, longitude_deg = 0, ellipsoidal_m = 0, undulation_m = 0;  ///< of the point
    double distance_m = 0;
    Eigen::Vector2d xy, sigma;   ///< straight, y up; sigma by those of point and orientation
    ImageRefraction refraction;  ///< zero where none was asked for
    /// By latitude, longitude (rad) and h (m) of the centre, omega, phi, kappa (rad) against east, north, up, latitude,
    /// longitude and h of the point.
    Eigen::Matrix<double, 2, 9> by;
  };
  std::optional<RefractionModel> refraction;
  std::string unit = "mm";
  std::vector<Row> rows;
  std::vector<std::pair<std::string, std::string>> behind;  ///< image, point
};
[[nodiscard]] std::string collinearity_text(const CollinearityReport& report);
/// image_points, derivatives.
[[nodiscard]] std::vector<NamedTable> collinearity_tables(const CollinearityReport& report);

/// Refraction of measured image points by both formulas, and corrected coordinates.
struct RefractionReport {
  struct Row {
    std::string point;
    RefractionHeights heights;
    ImageRefraction by_coefficient, by_atmosphere;  ///< in the axes of the table
    Eigen::Vector2d corrected, sigma_corrected;     ///< by the one that was asked for
  };
  std::string unit = "mm";
  RefractionModel model;
  std::vector<Row> rows;
};
[[nodiscard]] std::string refraction_text(const RefractionReport& report);
/// refraction.
[[nodiscard]] std::vector<NamedTable> refraction_tables(const RefractionReport& report);

}  // namespace collinea
