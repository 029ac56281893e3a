// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>

#include "collinea/adjust/calibration.h"
#include "collinea/base/options.h"
#include "collinea/camera/additional.h"
#include "collinea/orient/instrument_options.h"

namespace collinea {

/// What OrientOptions::calibration may be.
inline constexpr std::array kOrientCalibrations = {Calibration::kNone, Calibration::kFocal, Calibration::kFocalRadial,
                                                   Calibration::kBrown};

/// How a block begins.
enum class OrientMode { kAuto, kIncremental, kGlobal };
inline constexpr Word<OrientMode> kOrientModeWords[] = {
    {OrientMode::kAuto, "auto", "global from 300 images on when nearly all have positions"},
    {OrientMode::kIncremental, "incremental", "image after image"},
    {OrientMode::kGlobal, "global", "all at once, from image positions"}};
[[nodiscard]] constexpr std::span<const Word<OrientMode>> words(OrientMode) { return kOrientModeWords; }

struct OrientOptions {
  OrientMode mode = OrientMode::kAuto;
  std::optional<Calibration> calibration;
  AdditionalSet additional = AdditionalSet::kNone;
  double max_error_px = 3;
  double min_angle_deg = 1.5;
  int min_points = 15;
  double sigma_px = 0.5;
  bool use_positions = true;
  bool use_control = true;
  bool use_geodetic = true;
  bool remeasure = false;
  std::optional<std::filesystem::path> orientation;
  bool refine_orientation = false;
  InstrumentOptions instruments;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = OrientOptions;
    visit(Field{"mode", &O::mode, "", "how the block begins"});
    visit(Field{"calibration", &O::calibration, "", "camera parameters to find"}
              .or_auto("all of brown from three images on")
              .one_of(kOrientCalibrations));
    visit(Field{"additional", &O::additional, "",
                "additional parameters of every camera that is calibrated, on top of its model, found by the last "
                "adjustments and used by all that follows"});
    visit(Field{"max_error_px", &O::max_error_px, "px", "largest residual of a tie point's image", 0.1});
    visit(Field{"min_angle_deg", &O::min_angle_deg, "deg", "smallest angle between two rays that fix a tie point", 0.01,
                90});
    visit(Field{"min_points", &O::min_points, "1", "fewest tie points that orient an image", 6});
    visit(Field{"sigma_px", &O::sigma_px, "px", "standard deviation of a tie point's image before adjustment", 1e-3});
    visit(Field{"use_positions", &O::use_positions, "", "use GNSS positions of the images as observations"});
    visit(Field{"use_control", &O::use_control, "", "use control points as observations"});
    visit(Field{"use_geodetic", &O::use_geodetic, "", "use what was measured between control points as observations"});
    visit(Field{"remeasure", &O::remeasure, "",
                "measure tie points whose windows share no pixels once more, by least squares matching: "
                "smaller errors on rendered images, little change on photographs"});
    visit(Field{"orientation", &O::orientation, "",
                "take cameras and poses from another program: folder of a COLMAP model, Bundler's folder or "
                "bundle.out, or a table of omega, phi, kappa"}
              .leads_to(PathKind::kFileOrFolder));
    visit(Field{"refine_orientation", &O::refine_orientation, "",
                "adjust the orientation that was taken; otherwise it stays as it is"});
    visit(Group{"instruments", &O::instruments});
  }
};

}  // namespace collinea
