// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/options.h"
#include "collinea/camera/film_calibration.h"
#include "collinea/synthetic/internal/film_scan.h"
#include "collinea/synthetic/survey.h"

namespace collinea {

/// A block taken on film with an aerial camera (153 mm, 23 x 23 cm) and scanned.
struct FilmOptions {
  bool film = false;
  double photo_scale = 8000, scan_um = 42;
  MarkKind corner_mark = MarkKind::kCross, side_mark = MarkKind::kDot;
  ScanWear wear = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = FilmOptions;
    visit(Field{"film", &O::film, "",
                "scans of film from an aerial camera (153 mm, 23 x 23 cm, eight fiducial marks) and its calibration; "
                "aerial only. Size and lens of a digital camera, and the noise of its image, are not used"});
    visit(Field{"photo_scale", &O::photo_scale, "1", "scale number of the film: flying height over focal length", 200,
                60000});
    visit(Field{"scan_um", &O::scan_um, "um", "size of a pixel of the scan", 5, 500});
    visit(Field{"corner_mark", &O::corner_mark, "", "kind of the marks in the corners"});
    visit(Field{"side_mark", &O::side_mark, "", "kind of the marks in the middle of the sides"});
    visit(Part{&O::wear});
  }
};

/// The world with the camera of the film, and what became of each photograph.
struct FilmTruth {
  /// The camera has pixels of the scan's size on undeformed film, and the image size of the calibration; measurements
  /// of control are in such pixels.
  Truth truth;
  FilmCalibration calibration;
  double pixel_mm = 0;
  ScanWear wear;
  std::map<ImageId, FilmScan> scans;
};

/// Errors: as make_survey; an overlap or strips that were not given are those of film (0.6, 0.3, no cross strips).
[[nodiscard]] Result<FilmTruth> make_film_survey(const SurveyOptions& survey, const FilmOptions& film, const Run& run);

/// The scan of a photograph, grey. Memory: a byte a pixel, and 300 rows of light. Error: stopped.
[[nodiscard]] Result<GreyImage> render_scan(const FilmTruth& film, ImageId image, const Run& run);

/// Where the scan shows what the camera of the truth has at `pixel`: refraction, deformation of the film, scanner.
[[nodiscard]] Eigen::Vector2d scan_pixel_of(const FilmTruth& film, ImageId image, const Eigen::Vector2d& pixel);

/// Makes the survey and writes it as simulate() does for photographs, but:
///   images/IMG_0001.jpg ...   scans, grey, without header
///   film_calibration.txt      the camera's
///   control.csv               measured in pixels of the scans
///   truth/scans.csv           image, then the affine transformation of the film to the scan: column, row [px] of the
///                             origin, rotation [rad], scale_x, scale_y [px/mm], shear; on top of it comes local
///                             deformation
///   truth/deformation/IMG_0001.csv ...   that, on a grid of 5 mm: position on the film, displacement before the affine
///                             transformation, x right and y up [mm]
///   truth/fiducials.csv       image, mark, where it lies in the scan [px]
[[nodiscard]] Result<> simulate(const SurveyOptions& survey, const FilmOptions& film,
                                const std::filesystem::path& folder, const Run& run);

}  // namespace collinea
