// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "collinea/orient/space_resection.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// A resection of one image or more, or of a station in the plane, and what its points say of it.
struct ResectionReport {
  struct Image {
    std::string name;
    std::size_t points = 0;
    std::vector<Estimate> exterior;                ///< X, Y, Z, omega, phi, kappa; of a station X, Y, orientation
    Eigen::MatrixXd covariance;                    ///< of it, in its units; empty without
    std::vector<Estimate> interior;                ///< by the direct linear transformation
    std::vector<Estimate> elements;                ///< its parameters
    std::vector<std::vector<Estimate>> solutions;  ///< all poses of three points
    std::optional<PoseConditioning> conditioning;
    std::optional<DangerCylinder> danger;  ///< in the plane: the circle
    double robust_scale = 0;               ///< of the least median of squares; 0 where it was not asked for
    bool is_determined = true;             ///< a pose follows from what was given
  };
  struct Mark {
    std::string image, point;
    Eigen::Vector2d misfit, redundancy, w;  ///< in the table's axes; w by VarianceTest::factor()
    bool is_rejected = false;
  };
  struct Point {
    std::string name;
    Eigen::Vector3d position, sigma;
  };
  std::string method;  ///< in words, for a line
  std::string unit;    ///< of the misfits: px, mm or mgon
  bool is_station = false;
  std::vector<Image> images;
  std::vector<Mark> marks;
  std::vector<Point> tie_points;
  VarianceTest variance;
};

[[nodiscard]] std::string resection_text(const ResectionReport& report);
/// orientation, correlations (of one image), residuals, points.
[[nodiscard]] std::vector<NamedTable> resection_tables(const ResectionReport& report);

}  // namespace collinea
