// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/words.h"
#include "collinea/dense/epipolar_pair.h"
#include "collinea/dense/level_matching.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/geometry/absolute_orientation.h"
#include "collinea/io/text_table.h"
#include "collinea/match/pair_points.h"
#include "collinea/report/absolute_report.h"
#include "collinea/report/relative_report.h"

namespace collinea {

/// How the surface of a pair is found.
enum class PairSurface { kLevels, kDense };
inline constexpr Word<PairSurface> kPairSurfaceWords[] = {
    {PairSurface::kLevels, "levels", "interest points of falling threshold, each level guided by the last (Karfis)"},
    {PairSurface::kDense, "dense", "every pixel, by semi-global matching"}};
[[nodiscard]] constexpr std::span<const Word<PairSurface>> words(PairSurface) { return kPairSurfaceWords; }

/// A relative orientation on the way.
struct PairOrientation {
  std::string by;  ///< "ncc", "lsm": what measured its points
  std::size_t points = 0, rejected = 0;
  RelativeOrientation orientation;
  double sigma0_px = 0;
  int shrink = 1;                     ///< of the images, against the files
  std::vector<MatchedPoint> matched;  ///< all points, in pixels of the images; as the residuals of the orientation
};

/// The interior orientation of a scan of film.
struct PairScan {
  std::size_t marks = 0, misread = 0;
  double rms_um = 0, pixel_um = 0;  ///< of the residuals of marks on the film; size of a pixel
};

/// The exterior orientation of an image.
struct PairExterior {
  std::string image;
  std::vector<Estimate> elements;  ///< X, Y, Z, omega, phi, kappa
  /// Of the elements; zero: exact.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// Surface model and orthophoto.
struct PairMap {
  double cell_m = 0;
  int width = 0, height = 0;
  std::uint64_t measured_cells = 0, interpolated_cells = 0, painted_cells = 0;
  double mean_sigma_m = 0;           ///< of measured heights
  double mean_sigma_relative_m = 0;  ///< of them by matching alone
};

/// What was done with a pair, stage by stage.
struct PairReport {
  std::array<std::filesystem::path, 2> files;  ///< that were worked on, of film its ideal images
  std::array<Camera, 2> cameras;               ///< of them
  int left_width_px = 0, left_height_px = 0;   ///< of the images as they were worked on
  int shrink = 1;                              ///< against the files
  std::vector<PairScan> scans;                 ///< left and right; empty when the images are not of film
  std::vector<PairPointStage> search;
  bool is_given = false;  ///< the orientation: points are only compared with it
  std::vector<PairOrientation> orientations;
  std::optional<RelativeReport> relative;  ///< the last one with all its points, in pixels of the files
  std::array<PairExterior, 2> exterior;    ///< on the ground or in the model (x right, y up, z backwards)
  EpipolarPair epipolar;
  std::optional<double> pixel_um;  ///< of the images as they were worked on, where the film says its size
  Interpolation resampling = Interpolation::kBicubic;
  double y_parallax_rms_px = 0;  ///< of the homologous points in the epipolar images
  double row_sigma_px = 0;       ///< of the epipolar lines by the orientation, the largest at a point
  PairSurface surface = PairSurface::kLevels;
  std::vector<LevelCount> levels;
  std::size_t surface_points = 0;
  double median_sigma_px = 0;  ///< of their disparities
  double median_sigma_z = 0;   ///< of their depths, in metres or bases
  bool has_base = false;       ///< the base is in metres
  std::optional<AbsoluteOrientation> absolute;
  std::vector<std::string> control_names;  ///< of what is used, in the order of its residuals
  std::optional<AbsoluteReport> control;   ///< absolute, of the model as `relative` has it, with tests of all points
  std::optional<PairMap> map;
  std::vector<Finding> findings;

  /// Depths are in metres, or can be said in them.
  [[nodiscard]] bool is_metric() const { return has_base || absolute.has_value(); }
  [[nodiscard]] double median_sigma_z_m() const {
    return absolute ? median_sigma_z * absolute->ground_from_model.scale : median_sigma_z;
  }
};

/// For a terminal and as a file.
[[nodiscard]] std::string pair_text(const PairReport& report);
/// The same figures for programs: units in the names, null where something is not known.
[[nodiscard]] std::string pair_json(const PairReport& report);
/// Writes FOLDER/pair.txt, FOLDER/pair.json and FOLDER/pair.html (one file with its pictures, no network needed) beside
/// the products that the page shows. A picture that cannot be read is a finding of the page. Errors: disk.
[[nodiscard]] Result<> write_pair_report(const PairReport& report, const std::filesystem::path& folder);
/// Homologous points (points.txt), those that were rejected on the way (rejected.txt), parameters, correlations and
/// residuals of the relative orientation and its model, both exterior orientations, and with control those of the
/// absolute orientation.
[[nodiscard]] std::vector<NamedTable> pair_tables(const PairReport& report);

}  // namespace collinea
