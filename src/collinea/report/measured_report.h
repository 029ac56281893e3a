// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/quality/marked_points.h"
#include "collinea/report/single_step.h"
#include "collinea/restitution/measured_figure.h"

namespace collinea {

/// Points that were measured in the images of a block, and figures of them.
struct MeasuredReport {
  struct Mark {
    std::string image;
    bool is_oriented = false;  ///< its image is, in the block
    BlockMarkTest test;
  };
  struct Point {
    std::string name;
    std::vector<Mark> marks;
    std::optional<Eigen::Vector3d> position;  ///< in the map, or the frame of the block; nothing: not determined [m]
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< there [m^2]
  };
  struct Figure {
    FigureKind kind{};
    std::vector<std::string> points;
    std::optional<MeasuredFigure> measured;
    std::string undetermined;  ///< the point because of which there is none
    std::string refused;       ///< why there is none of points that are there
  };
  std::string crs;  ///< of the map; empty: positions are in the frame of the block
  double sigma0 = 1;
  bool is_placed = true;  ///< false: nothing gives the block position and scale
  std::vector<Point> points;
  std::vector<Figure> figures;
};

/// Figures with their standard deviations, and why others have none; begins with an empty line.
[[nodiscard]] std::string figures_text(std::span<const MeasuredReport::Figure> figures);
/// figures.txt; none without figures.
[[nodiscard]] std::vector<NamedTable> figure_tables(std::span<const MeasuredReport::Figure> figures);
[[nodiscard]] std::string measured_text(const MeasuredReport& report);
/// points.txt (point, E, N, H or X, Y, Z, their sigmas and correlations, images), marks.txt (point, image, residuals,
/// redundancy, w, minimal detectable bias) and, where there are figures, figures.txt (figure, points, value, sigma).
[[nodiscard]] std::vector<NamedTable> measured_tables(const MeasuredReport& report);

}  // namespace collinea
