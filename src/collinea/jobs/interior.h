// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/camera/film_gallery.h"
#include "collinea/camera/film_transformation.h"
#include "collinea/film/scan_marks.h"
#include "collinea/report/interior_report.h"

namespace collinea {

struct InteriorOptions {
  std::optional<std::filesystem::path> calibration = {};
  std::optional<FilmCameraType> gallery = {};
  std::optional<std::filesystem::path> drawing = {};
  std::optional<FilmModel> model = {};
  std::optional<double> sigma = {};
  std::optional<double> pixel_um = {}, dpi = {};
  std::optional<std::string> principal_point_px = {};
  std::optional<std::filesystem::path> points = {};
  double point_sigma = 0.3;
  bool keep_misread = false;
  std::optional<std::filesystem::path> out = {};
  ScanMarkOptions scans = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = InteriorOptions;
    visit(Field{"calibration", &O::calibration, "",
                "calibration of the camera: marks, principal distance and point, lens"}
              .leads_to(PathKind::kFile));
    visit(Field{"gallery", &O::gallery, "",
                "common camera whose nominal marks take the place of a calibration, or of its marks"});
    visit(Field{"drawing", &O::drawing, "",
                "SVG file: the marks of the calibration or of the type as they are looked for, of neither those of all "
                "types; it needs no measurements"}
              .leads_to(PathKind::kOutput));
    visit(Field{"model", &O::model, "", "transformation between film and scan"}.or_auto(
        "the smallest that the larger ones do not reject"));
    visit(
        Field{"sigma", &O::sigma, "",
              "standard deviation of a reading of a mark, in the unit of the table, nothing: found from the residuals; "
              "without marks of the pixel of the principal point",
              1e-9, 1e6});
    visit(Field{"pixel_um", &O::pixel_um, "um", "size of a pixel of the scan, as the scanner states it", 0.1, 1000});
    visit(Field{"dpi", &O::dpi, "1/inch", "the same as resolution: 25400 um / dpi", 10, 1e6});
    visit(Field{"principal_point_px", &O::principal_point_px, "",
                "column,row of the principal point: an orientation without marks, by the size of a pixel"});
    visit(Field{"points", &O::points, "",
                "table of points to bring to the film: point x y, with image and sigma where there are; points in mm "
                "of scans in "
                "pixels are brought from the film to the scan"}
              .leads_to(PathKind::kFile));
    visit(Field{"point_sigma", &O::point_sigma, "", "standard deviation of these points where the table gives none", 0,
                1e6});
    visit(Field{"keep_misread", &O::keep_misread, "", "leave no mark out, however much it contradicts the others"});
    visit(Field{"out", &O::out, "", "folder for the tables of parameters, residuals and points"}.leads_to(
        PathKind::kFolder));
    visit(Group{"scans", &O::scans});
  }
};

/// The interior orientation of photographs from a table of measured marks (image mark x y [sigma]; coordinates in px,
/// or in mm or um with y up; the same mark again is another reading of it), from
/// the marks found in a scan or a folder of scans, or by --principal-point-px without one (an
/// empty path). With a drawing and neither measurements nor a principal point the marks are drawn, nothing else.
/// Errors: files, columns, no calibration, marks that determine nothing.
[[nodiscard]] Result<InteriorReport> interior_orientation(const std::filesystem::path& measurements,
                                                          const InteriorOptions& options, const Run& run);

}  // namespace collinea
