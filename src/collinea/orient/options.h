// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "collinea/base/options.h"
#include "collinea/orient/instrument_options.h"

namespace collinea {

/// What OrientOptions::calibration may be.
inline constexpr std::array<std::string_view, 5> kCalibrations = {"auto", "none", "focal", "focal_radial", "brown"};

/// What OrientOptions::mode may be.
inline constexpr std::array<std::string_view, 3> kOrientModes = {"auto", "incremental", "global"};

struct OrientOptions {
  std::string mode = "auto";
  std::string calibration = "auto";
  std::string additional = "none";
  double max_error_px = 3;
  double min_angle_deg = 1.5;
  int min_points = 15;
  double sigma_px = 0.5;
  bool use_positions = true;
  bool use_control = true;
  bool use_ground = true;
  bool remeasure = false;
  std::optional<std::string> orientation;
  bool refine_orientation = false;
  InstrumentOptions instruments;  ///< a group of their own

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = OrientOptions;
    visit(Field{"mode", &O::mode, "",
                "how the block begins: incremental (image after image), global (all at once, from image positions), "
                "auto (global from 300 images on when nearly all have positions)"});
    visit(
        Field{"calibration", &O::calibration, "",
              "camera parameters to find: auto (all of brown from three images on), none, focal, focal_radial, brown"});
    visit(Field{"additional", &O::additional, "",
                "additional parameters of every camera that is calibrated, on top of its model, found by the last "
                "adjustments and used by all that follows: none | polynomial | ebner | gruen | fourier"});
    visit(Field{"max_error_px", &O::max_error_px, "px", "largest residual of a tie point's image", 0.1});
    visit(Field{"min_angle_deg", &O::min_angle_deg, "deg", "smallest angle between two rays that fix a tie point", 0.01,
                90});
    visit(Field{"min_points", &O::min_points, "1", "fewest tie points that orient an image", 6});
    visit(Field{"sigma_px", &O::sigma_px, "px", "standard deviation of a tie point's image before adjustment", 1e-3});
    visit(Field{"use_positions", &O::use_positions, "", "use GNSS positions of the images as observations"});
    visit(Field{"use_control", &O::use_control, "", "use control points as observations"});
    visit(Field{"use_ground", &O::use_ground, "", "use what was measured between control points as observations"});
    visit(Field{"remeasure", &O::remeasure, "",
                "measure the images of the tie points once more, by least squares matching of the pictures: smaller "
                "errors on rendered pictures, little change on photographs; sigmas come out too small"});
    visit(
        Field{"orientation", &O::orientation, "",
              "take cameras and poses from another program: folder of a COLMAP model, Bundler's folder or bundle.out, "
              "or a table of omega, phi, kappa"});
    visit(Field{"refine_orientation", &O::refine_orientation, "",
                "adjust the orientation that was taken; otherwise it is held as it is"});
  }
};

}  // namespace collinea
