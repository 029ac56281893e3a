// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/orient/space_resection.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// A resection of one image or more, or of a station in the plane, and what its points say of it.
struct ResectionReport {
  enum class Kind { kCollinearity, kLinear, kDlt, kPlane, kStation };
  /// A projection matrix taken apart, (x, y, 1) ~ K (R X + t) with R of omega, phi and kappa in the axes of the table:
  /// of pixels x right, y down, z forward; of photographs x right, y up, z backwards with K(0,0), K(1,1) = -c.
  struct MatrixParts {
    Eigen::Matrix3d calibration, rotation;
    Eigen::Vector3d translation;                        ///< [m]
    Eigen::Vector3d centre;                             ///< M (C, 1) = 0
    Eigen::Vector3d axis;                               ///< ray of the principal point, of unit length
    Eigen::Matrix3d sigma_calibration, sigma_rotation;  ///< of the elements; 0 of those that are fixed
    Eigen::Vector3d sigma_translation, sigma_centre, sigma_axis;
  };
  struct Image {
    std::string name;
    std::size_t points = 0;
    std::vector<Estimate> exterior;                ///< X, Y, Z, omega, phi, kappa; of a station X, Y, orientation
    Eigen::MatrixXd covariance;                    ///< of it, in its units; empty without
    std::vector<Estimate> interior;                ///< by the direct linear transformation
    Eigen::MatrixXd joint_covariance;              ///< of exterior and interior together; empty without interior
    std::vector<Estimate> elements;                ///< its parameters
    Eigen::MatrixXd element_covariance;            ///< of them
    std::optional<MatrixParts> parts;              ///< by the direct linear transformation in space
    std::vector<std::vector<Estimate>> solutions;  ///< all poses of three points
    std::optional<PoseConditioning> conditioning;
    std::optional<DangerCylinder> danger;  ///< in the plane: the circle
    struct Control {
      std::string name;
      Eigen::Vector3d position;
    };
    std::vector<Control> control;                       ///< through which it goes, as far as it does
    Eigen::Vector3d station = Eigen::Vector3d::Zero();  ///< projection centre, or station in the plane
    std::vector<Eigen::Vector3d> open_stations;         ///< an arc of the circle on which no direction tells where
    double robust_scale = 0;    ///< of the least median of squares; 0 where it was not asked for
    bool is_determined = true;  ///< a pose follows from what was given
  };
  struct Mark {
    std::string image, point;
    Eigen::Vector2d misfit, redundancy, w;  ///< in the table's axes; w by VarianceTest::factor()
    bool is_rejected = false;
    /// Direct linear transformation in space: the unit direction of the measured ray from the projection centre.
    std::optional<Eigen::Vector3d> ray = {};
  };
  struct Point {
    std::string name;
    Eigen::Vector3d position, sigma;
  };
  Kind kind = Kind::kCollinearity;
  int iterations = 0;
  std::string unit;  ///< of the misfits: px, mm or mgon
  std::vector<Image> images;
  std::vector<Mark> marks;
  std::vector<Point> tie_points;
  VarianceTest variance;
  std::vector<Finding> findings;

  [[nodiscard]] bool is_station() const { return kind == Kind::kStation; }
};

[[nodiscard]] std::string resection_text(const ResectionReport& report);
/// The danger circle or cylinder of each image with its control and the projection centre, seen along the axis of the
/// cylinder and across it: an SVG; "" where the control of none lies in a way that gives a circle.
[[nodiscard]] std::string danger_svg(const ResectionReport& report);
/// orientation, residuals; of one image correlations; tie points; of a matrix its elements and their correlations, the
/// interior orientation, the matrix taken apart, rays.
[[nodiscard]] std::vector<NamedTable> resection_tables(const ResectionReport& report);

}  // namespace collinea
