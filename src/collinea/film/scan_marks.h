// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/camera/film_calibration.h"
#include "collinea/camera/mark_readings.h"
#include "collinea/feature/learnt_mark.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// How marks are looked for in scans.
struct ScanMarkOptions {
  MarkKind mark_kind = MarkKind::kCross;
  std::optional<std::string> mark_at = {};
  int turned_deg = 0;
  double search_mm = 4;

  friend bool operator==(const ScanMarkOptions&, const ScanMarkOptions&) = default;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ScanMarkOptions;
    visit(Field{"mark_kind", &O::mark_kind, "", "what marks look like of which the calibration does not say it"});
    visit(Field{"mark_at", &O::mark_at, "",
                "column,row of a mark in the first scan, of several with a semicolon between: marks of its kind are "
                "looked for by "
                "its likeness, turned by quarters where it has one side"});
    visit(Field{"turned_deg", &O::turned_deg, "deg",
                "by how much the film lies turned in the scans, clockwise: 0, 90, 180 or 270", 0, 270});
    visit(
        Field{"search_mm", &O::search_mm, "mm", "how far from the predicted positions marks are looked for", 0.1, 50});
  }
};

/// Photographs that are scans of film.
struct FilmScanOptions {
  std::optional<std::filesystem::path> calibration = {};  ///< nothing: they are none
  std::optional<double> pixel_um = {};
  ScanMarkOptions marks = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = FilmScanOptions;
    visit(
        Field{"film", &O::calibration, "",
              "calibration of a film camera: the photographs are scans of its film. Their marks are found, and each is "
              "brought to the ideal image of the camera; control is measured in pixels of the scans"}
            .leads_to(PathKind::kFile));
    visit(Field{"film_pixel_um", &O::pixel_um, "um",
                "size of a pixel of the scans, by which marks are looked for; nothing: the film fills the scan", 0.1,
                1000});
    visit(Part{&O::marks});
  }
};

/// Marks of one scan.
struct ScanMarks {
  std::string image;
  std::vector<MarkReading> marks;
  double least_correlation = 1;
};

/// How all marks of some scans are looked for.
struct MarkSearch {
  FilmCalibration calibration;
  std::optional<double> pixel_mm = {};
  ScanMarkOptions options = {};
  std::vector<LearntMark> learnt = {};  ///< the marks that were pointed to
};

/// The search, with the mark learnt from `first_scan` where one was pointed to. Errors: options, nothing that
/// could be a mark.
[[nodiscard]] Result<MarkSearch> mark_search(const FilmCalibration& calibration, std::optional<double> pixel_mm,
                                             const ScanMarkOptions& options, const std::filesystem::path& first_scan);

/// The marks of one scan. Errors: fewer than three found where the calibration has them.
[[nodiscard]] Result<ScanMarks> find_marks(const GreyImage& scan, const std::string& name, const MarkSearch& search,
                                           const Run& run);

/// Whether marks are to be found in it: a folder, or a file that is an image by its name.
[[nodiscard]] bool is_scan(const std::filesystem::path& path);

/// The marks of a scan, or of all scans of a folder in the order of their names. Errors: no scan, one that cannot be
/// read, fewer than three marks found in one.
[[nodiscard]] Result<std::vector<ScanMarks>> find_scan_marks(const std::filesystem::path& path,
                                                             const FilmCalibration& calibration,
                                                             std::optional<double> pixel_mm,
                                                             const ScanMarkOptions& options, const Run& run);

}  // namespace collinea
