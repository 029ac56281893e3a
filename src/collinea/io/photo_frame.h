// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// What is known of the camera of a table of image coordinates. One rule for every table: coordinates in pixels have x
/// to the right and y down (column, row; the middle of the upper left pixel is 0.5, 0.5); coordinates in mm or um are
/// those of photographs, x to the right and y up.
struct PhotoOptions {
  std::optional<double> principal_distance;
  std::string principal_point = "0,0";

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PhotoOptions;
    visit(
        Field{"principal_distance", &O::principal_distance, "",
              "principal distance (calibrated focal length) of the photographs, in pixels where the image coordinates "
              "are, in mm otherwise",
              1e-6, 1e9});
    visit(Field{"principal_point", &O::principal_point, "",
                "x,y of the principal point, in the same unit and axes: pixels with y down, mm with y up"});
  }
};

/// Image coordinates as a table gives them and as cameras see them.
struct PhotoFrame {
  Camera camera;  ///< its pixels are the table's unit (px or mm); y down
  bool y_up = false;

  [[nodiscard]] Eigen::Vector2d pixel(const Eigen::Vector2d& in_table) const { return turned(in_table); }
  [[nodiscard]] Eigen::Vector2d in_table(const Eigen::Vector2d& pixel) const { return turned(pixel); }
  [[nodiscard]] std::string_view unit() const { return y_up ? "mm" : "px"; }

 private:
  [[nodiscard]] Eigen::Vector2d turned(const Eigen::Vector2d& xy) const { return {xy.x(), y_up ? -xy.y() : xy.y()}; }
};

/// The frame of coordinates in that unit: of pixels ("px" or none) or of a photograph (a length). Errors: no principal
/// distance, a principal point that is not two numbers, another unit.
[[nodiscard]] Result<PhotoFrame> photo_frame(const PhotoOptions& options, std::string_view unit);

}  // namespace collinea
