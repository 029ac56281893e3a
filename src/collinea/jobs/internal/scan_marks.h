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

namespace collinea {

/// How marks are looked for in scans.
struct ScanMarkOptions {
  MarkKind mark_kind = MarkKind::kCross;
  std::optional<std::string> mark_at = {};
  int turned_deg = 0;
  double search_mm = 4;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ScanMarkOptions;
    visit(Field{"mark_kind", &O::mark_kind, "", "what marks look like of which the calibration does not say it"});
    visit(Field{"mark_at", &O::mark_at, "",
                "column,row of a mark in the first scan: the others are looked for by its likeness"});
    visit(Field{"turned_deg", &O::turned_deg, "deg",
                "by how much the film lies turned in the scans, clockwise: 0, 90, 180 or 270", 0, 270});
    visit(
        Field{"search_mm", &O::search_mm, "mm", "how far from the predicted positions marks are looked for", 0.1, 50});
  }
};

/// Marks of one scan.
struct ScanMarks {
  std::string image;
  std::vector<MarkReading> marks;
  double least_correlation = 1;
};

/// Whether marks are to be found in it: a folder, or a file that is an image by its name.
[[nodiscard]] bool is_scan(const std::filesystem::path& path);

/// The marks of a scan, or of all scans of a folder in the order of their names. Errors: no scan, one that cannot be
/// read, fewer than three marks found in one.
[[nodiscard]] Result<std::vector<ScanMarks>> find_scan_marks(const std::filesystem::path& path,
                                                             const FilmCalibration& calibration,
                                                             std::optional<double> pixel_mm,
                                                             const ScanMarkOptions& options, const Run& run);

}  // namespace collinea
