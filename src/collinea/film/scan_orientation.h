// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/camera/film_fit.h"
#include "collinea/film/scan_marks.h"

namespace collinea {

/// The interior orientation of a scan by its marks.
struct ScanOrientation {
  FilmChoice choice;                           ///< of the transformation
  std::optional<FilmDeformation> deformation;  ///< nothing where the marks do not tell
  std::size_t marks = 0;                       ///< found and part of the calibration
  double mark_sigma_px = 0;                    ///< of a coordinate of a mark: its match in the scan and its calibration

  [[nodiscard]] const FilmTransformation& scan_from_film() const { return choice.fit.transformation; }
  [[nodiscard]] double pixel_mm() const;      ///< mean of both axes, in the middle of the film
  [[nodiscard]] double rms_mm() const;        ///< of the residuals of marks that were used, each coordinate
  [[nodiscard]] std::size_t misread() const;  ///< marks that were left out
};

/// Refuses options of scans where nothing says that the photographs are scans.
[[nodiscard]] Result<> check_film(const FilmScanOptions& options);

/// How the marks of these scans are looked for; the calibration is there. Errors: its file, a calibration without
/// marks, as mark_search().
[[nodiscard]] Result<MarkSearch> film_search(const FilmScanOptions& options, const std::filesystem::path& first_scan);

/// Reads a scan and orients it. Marks are found in it with pixels of at most 30 um: finer ones are reduced. Errors:
/// file, marks that are not found, as oriented_scan().
[[nodiscard]] Result<ScanOrientation> orient_scan(const std::filesystem::path& scan, const MarkSearch& search,
                                                  const Run& run);

/// All marks weigh alike: film and scanner move them by more than they are read badly. The transformation is affine:
/// that of one scan may be indistinguishable from a smaller one, but what a smaller one leaves in the scans of a block
/// adds up in its heights. Of three marks it is the smallest that the larger ones do not reject. Errors: marks that
/// determine none.
[[nodiscard]] Result<ScanOrientation> oriented_scan(const FilmCalibration& calibration, const ScanMarks& found);

}  // namespace collinea
