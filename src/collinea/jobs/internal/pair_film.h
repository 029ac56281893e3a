// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/film/ideal_image.h"
#include "collinea/film/scan_orientation.h"
#include "collinea/jobs/internal/pair_options.h"

namespace collinea {

/// The scans of a pair on film and the ideal images that they became, which the pair is worked on.
struct PairFilm {
  IdealImage ideal;
  ScanOrientation left, right;
  std::filesystem::path left_file, right_file;  ///< of the ideal images

  /// Where the ideal image shows what was measured in the scan [px]. Nothing beyond the horizon of a perspective.
  [[nodiscard]] std::optional<Eigen::Vector2d> in_left(const Eigen::Vector2d& scan_px) const;
  [[nodiscard]] std::optional<Eigen::Vector2d> in_right(const Eigen::Vector2d& scan_px) const;
};

/// Finds the marks of both scans, and writes film_left.jpg and film_right.jpg into the folder. Errors: the calibration,
/// files, marks that are not found, options that contradict it.
[[nodiscard]] Result<PairFilm> pair_film(const std::filesystem::path& left, const std::filesystem::path& right,
                                         const std::filesystem::path& folder, const PairChainOptions& options,
                                         const Run& run);

}  // namespace collinea
