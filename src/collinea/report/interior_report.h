// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/camera/film_calibration.h"
#include "collinea/camera/film_fit.h"
#include "collinea/camera/mark_readings.h"
#include "collinea/io/text_table.h"

namespace collinea {

/// The interior orientation of photographs, as found from their marks.
struct InteriorReport {
  struct Image {
    std::string name;        ///< empty: a table without images
    bool has_marks = true;   ///< false: by principal point and size of a pixel
    FilmChoice orientation;  ///< tests only where the model was chosen
    ReadMarks readings;
    std::optional<double> least_correlation = {};  ///< of marks found in the scan with their drawing
    std::optional<FilmDeformation> deformation;
    std::vector<std::string> unknown, missing;  ///< marks that the calibration has not; that were not measured
  };
  FilmCalibration calibration;
  std::string unit = "px";        ///< of what was measured
  bool sigmas_are_known = false;  ///< they were given; else sigma0 stands for them
  std::vector<Image> images;
  /// Points on the film and corrected for the lens, from the principal point.
  struct Point {
    std::string image, point;
    Eigen::Vector2d film_mm, corrected_mm;
    Eigen::Matrix2d covariance;  ///< of both [mm^2]
  };
  std::vector<Point> points;
  /// Points of the film as the scan shows them.
  struct ScanPoint {
    std::string image, point;
    Eigen::Vector2d film_mm, pixel;
    Eigen::Matrix2d covariance;  ///< of the pixel [px^2]
  };
  std::vector<ScanPoint> scan_points;
  std::vector<Finding> findings;
};

/// Residuals that no film and no reading of marks explains: more than a tenth of a millimetre on the film, or three
/// times the standard deviations that were given.
[[nodiscard]] bool contradicts_itself(const InteriorReport& report, const InteriorReport::Image& image);

/// For a terminal: parameters, residuals, tests, deformation of every image.
[[nodiscard]] std::string interior_text(const InteriorReport& report);

[[nodiscard]] TextTable parameter_table(const InteriorReport& report);
/// image parameter_1 parameter_2 covariance; the rotation in rad, each pair once.
[[nodiscard]] TextTable covariance_table(const InteriorReport& report);
/// image smaller larger statistic chance, of the tests by which models were chosen.
[[nodiscard]] TextTable model_test_table(const InteriorReport& report);
/// image quantity value sigma unit.
[[nodiscard]] TextTable deformation_table(const InteriorReport& report);
/// image point x[px] y[px] sigma_x[px] sigma_y[px] correlation x_film[mm] y_film[mm]
[[nodiscard]] TextTable scan_point_table(const InteriorReport& report);
[[nodiscard]] TextTable residual_table(const InteriorReport& report);
/// image point x[mm] y[mm] sigma_x[mm] sigma_y[mm] correlation x_film[mm] y_film[mm]; x, y corrected for the lens, from
/// the principal point.
[[nodiscard]] TextTable point_table(const InteriorReport& report);

}  // namespace collinea
