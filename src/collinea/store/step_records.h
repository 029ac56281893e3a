// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/result.h"
#include "collinea/block/differences.h"
#include "collinea/block/features.h"
#include "collinea/block/gauge.h"
#include "collinea/block/instrument_options.h"
#include "collinea/camera/calibration_choice.h"

namespace collinea {

// What each step leaves for those after it, for the report and for whoever asks: one struct a step, kept in the project
// database and read back as that struct. Plain values; images, cameras and points by their ids in the block, lengths in
// metres unless a member says otherwise. `kStep` is the name of the step; `fields` tells the members (packed_fields.h).
// A new record is its struct, and an entry in StepOutcome.

/// The interior orientation of a scan of film.
struct FilmScanRecord {
  std::string image, model;  ///< file; word of FilmModel
  std::uint64_t marks = 0, misread = 0;
  double rms_um = 0;  ///< of the residuals of marks, each coordinate, on the film
  double pixel_um = 0, rotation_deg = 0;
  std::optional<double> difference_ppm,
      shear_ppm;  ///< of the film: scale in x over scale in y, less 1; nothing: not told

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = FilmScanRecord;
    visit("image", &R::image);
    visit("model", &R::model);
    visit("marks", &R::marks);
    visit("misread", &R::misread);
    visit("rms_um", &R::rms_um);
    visit("pixel_um", &R::pixel_um);
    visit("rotation_deg", &R::rotation_deg);
    visit("difference_ppm", &R::difference_ppm);
    visit("shear_ppm", &R::shear_ppm);
  }
};

struct ImportRecord {
  static constexpr std::string_view kStep = "import";
  std::uint64_t images = 0, cameras = 0, positions = 0, control_points = 0, geodetic_observations = 0;
  std::optional<std::string> crs;    ///< of maps and control; nothing: no map
  std::vector<FilmScanRecord> film;  ///< of scans of film; their ideal images lie in film/
  std::vector<Finding> skipped;      ///< files that are no images, or of no use: the first subjects, and why
  std::vector<Finding> findings;

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = ImportRecord;
    visit("images", &R::images);
    visit("cameras", &R::cameras);
    visit("positions", &R::positions);
    visit("control_points", &R::control_points);
    visit("geodetic_observations", &R::geodetic_observations);
    visit("crs", &R::crs);
    visit("film", &R::film);
    visit("skipped", &R::skipped);
    visit("findings", &R::findings);
  }
};

struct DetectRecord {
  static constexpr std::string_view kStep = "detect";
  std::uint64_t images = 0;      ///< that could be read
  std::uint64_t features = 0;    ///< in all of them
  std::vector<Finding> skipped;  ///< images that could not be read

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = DetectRecord;
    visit("images", &R::images);
    visit("features", &R::features);
    visit("skipped", &R::skipped);
  }
};

/// How many pairs of images turned out to be what (PairGeometry).
struct PairCounts {
  std::uint64_t unrelated = 0, general = 0, planar = 0, rotation = 0;

  [[nodiscard]] std::uint64_t verified() const { return general + planar + rotation; }
  void add(PairGeometry geometry);
  template <class Visit>
  static void fields(Visit&& visit) {
    visit("unrelated", &PairCounts::unrelated);
    visit("general", &PairCounts::general);
    visit("planar", &PairCounts::planar);
    visit("rotation", &PairCounts::rotation);
  }
};

struct MatchRecord {
  static constexpr std::string_view kStep = "match";
  std::uint64_t pairs = 0;           ///< looked at
  std::uint64_t pairs_searched = 0;  ///< of these by their features, not only by tracks that they share
  std::uint64_t matches = 0;         ///< verified, of all pairs
  PairCounts pairs_by_geometry;

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = MatchRecord;
    visit("pairs", &R::pairs);
    visit("pairs_searched", &R::pairs_searched);
    visit("matches", &R::matches);
    visit("pairs_by_geometry", &R::pairs_by_geometry);
  }
};

/// East, north and height; nothing on an axis where nothing was measured.
using AxisValues = std::array<std::optional<double>, 3>;

/// The covariance of a position, as far as images and cameras make it, by given sigmas: sigma_scale^2 times it holds
/// sigma0.
struct PositionPrecision {
  Eigen::Vector3d position_in_world{0, 0, 0};
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();

  /// Along a direction of unit length.
  [[nodiscard]] double sigma_m(const Eigen::Vector3d& along, double sigma_scale) const {
    return std::sqrt(std::max(0.0, along.dot(covariance_m2 * along))) * sigma_scale;
  }
  template <class Visit>
  static void fields(Visit&& visit) {
    visit("position_in_world", &PositionPrecision::position_in_world);
    visit("covariance_m2", &PositionPrecision::covariance_m2);
  }
};

/// How cameras took part in the adjustment that gave the orientation.
struct CalibrationRecord {
  Calibration parameters = Calibration::kNone;  ///< none when no camera was calibrated
  /// Indices in Camera::params that were free, ascending, of each camera that was calibrated.
  std::map<CameraId, std::vector<std::uint32_t>> free;
  /// Standard deviations of Camera::params, sigma0 fixed; 0: fixed or not known. Of cameras whose covariance is known.
  std::map<CameraId, std::vector<double>> sigma;

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = CalibrationRecord;
    visit("parameters", &R::parameters);
    visit("free", &R::free);
    visit("sigma", &R::sigma);
  }
};

/// A block as it was found, near enough to be adjusted, and how it came about. Poses, cameras and points are in the
/// store; how good they are is known once they are adjusted.
struct OrientationRecord {
  static constexpr std::string_view kStep = "orient";
  std::uint64_t images = 0, oriented = 0, tie_points = 0;
  std::uint64_t observations = 0;                     ///< of tie points
  std::uint64_t gross_measurements = 0;               ///< of tie points, rejected
  double mean_reprojection_px = 0;                    ///< mean length of the residuals of tie points
  double pixel_size = 0;                              ///< median at the tie points [m, or units of the gauge]
  bool georeferenced = false;                         ///< false: a gauge without location on Earth
  bool metric = false;                                ///< lengths are in metres
  bool relative_heights = false;                      ///< georeferenced in plan, but nothing gave a height
  bool holds_given_poses = false;                     ///< poses are those of another program, not to be adjusted
  Gauge gauge;                                        ///< what fixes position, attitude and scale
  bool used_positions = false, used_control = false;  ///< they took part
  std::map<std::string, double> sigma_factors;    ///< what given sigmas were multiplied by, by word of ObservationGroup
  Eigen::Vector3d position_shift_m{0, 0, 0};      ///< by which positions were moved to where control puts the block
  InstrumentOptions instruments;                  ///< those that took part
  Calibration calibration = Calibration::kNone;   ///< parameters of cameras that were free; none: they stay as given
  std::vector<ImageId> not_oriented;              ///< in no part of the block
  std::vector<std::vector<ImageId>> other_parts;  ///< images that hang together, but not with the block
  std::vector<ControlId> used_for_datum;          ///< control that fixed where poses of another program lie
  std::vector<ControlId> excluded_control;        ///< found wrong, and not used
  std::vector<std::uint32_t> excluded_geodetic;   ///< the same: indices in Block::geodetic
  std::vector<ImageId> excluded_positions;        ///< would outweigh all others
  std::vector<Finding> findings;

  /// Ground size of a pixel; nothing without a scale.
  [[nodiscard]] std::optional<double> gsd_m() const { return metric ? std::optional(pixel_size) : std::nullopt; }

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = OrientationRecord;
    visit("images", &R::images);
    visit("oriented", &R::oriented);
    visit("tie_points", &R::tie_points);
    visit("observations", &R::observations);
    visit("gross_measurements", &R::gross_measurements);
    visit("mean_reprojection_px", &R::mean_reprojection_px);
    visit("pixel_in_units", &R::pixel_size);
    visit("georeferenced", &R::georeferenced);
    visit("metric", &R::metric);
    visit("relative_heights", &R::relative_heights);
    visit("holds_given_poses", &R::holds_given_poses);
    visit("gauge", &R::gauge);
    visit("used_positions", &R::used_positions);
    visit("used_control", &R::used_control);
    visit("sigma_factors", &R::sigma_factors);
    visit("position_shift_m", &R::position_shift_m);
    visit("instruments", &R::instruments);
    visit("calibration", &R::calibration);
    visit("not_oriented", &R::not_oriented);
    visit("other_parts", &R::other_parts);
    visit("used_for_datum", &R::used_for_datum);
    visit("excluded_control", &R::excluded_control);
    visit("excluded_geodetic", &R::excluded_geodetic);
    visit("excluded_positions", &R::excluded_positions);
    visit("findings", &R::findings);
  }
};

/// The adjustment that counts: what it found of poses, cameras and points is in the store with its covariances, and all
/// products derive from it.
struct AdjustmentRecord {
  static constexpr std::string_view kStep = "adjust";
  std::uint64_t images = 0, tie_points = 0;  ///< that took part
  std::uint64_t observations = 0;            ///< of tie points, that took part
  std::uint64_t mismatches = 0;              ///< measurements of tie points that were of others, rejected
  std::uint64_t rejected = 0;                ///< measurements that data snooping rejected
  double mean_reprojection_px = 0;           ///< mean length of the residuals of tie points
  double sigma0 = 0;
  std::int64_t redundancy = 0, unknowns = 0;
  std::int32_t rank_defect = 0;
  std::optional<AxisValues> control_rmse_m, check_rmse_m, position_rms_m;  ///< nothing: no such point took part
  std::map<std::string, double> sigma_factors;  ///< what given sigmas were multiplied by, by word of ObservationGroup
  InstrumentOptions instruments;                ///< those that took part
  bool refraction = false;                      ///< measurements were corrected for that of a standard atmosphere
  CalibrationRecord calibration;
  std::vector<ControlDifference> control;  ///< those that were excluded last
  std::vector<PositionDifference> positions;
  std::vector<GeodeticDifference> geodetic;
  std::vector<PositionPrecision> position_precision;      ///< at some of the tie points
  std::map<ImageId, Eigen::Vector3d> centre_sigma_m;      ///< of projection centres: east, north, up; with sigma0
  std::map<ImageId, Eigen::Vector3d> rotation_sigma_rad;  ///< of small turns about these axes; with sigma0
  std::vector<Finding> findings;

  /// What square roots of covariances by given sigmas are multiplied by: the rule of sigma_scale(Adjusted), whose
  /// module lies above.
  [[nodiscard]] double sigma_scale() const { return redundancy > 0 && sigma0 > 1e-9 ? sigma0 : 1; }

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = AdjustmentRecord;
    visit("images", &R::images);
    visit("tie_points", &R::tie_points);
    visit("observations", &R::observations);
    visit("mismatches", &R::mismatches);
    visit("rejected", &R::rejected);
    visit("mean_reprojection_px", &R::mean_reprojection_px);
    visit("sigma0", &R::sigma0);
    visit("redundancy", &R::redundancy);
    visit("unknowns", &R::unknowns);
    visit("rank_defect", &R::rank_defect);
    visit("control_rmse_m", &R::control_rmse_m);
    visit("check_rmse_m", &R::check_rmse_m);
    visit("position_rms_m", &R::position_rms_m);
    visit("sigma_factors", &R::sigma_factors);
    visit("instruments", &R::instruments);
    visit("refraction", &R::refraction);
    visit("calibration", &R::calibration);
    visit("control", &R::control);
    visit("positions", &R::positions);
    visit("geodetic", &R::geodetic);
    visit("position_precision", &R::position_precision);
    visit("centre_sigma_m", &R::centre_sigma_m);
    visit("rotation_sigma_rad", &R::rotation_sigma_rad);
    visit("findings", &R::findings);
  }
};

struct DensifyRecord {
  static constexpr std::string_view kStep = "densify";
  std::uint64_t depth_maps = 0, points = 0;
  std::vector<Finding> skipped;  ///< images without a depth map

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = DensifyRecord;
    visit("depth_maps", &R::depth_maps);
    visit("points", &R::points);
    visit("skipped", &R::skipped);
  }
};

/// The surface model. Where the step had nothing to make, `skipped_because` says why and all else is 0.
struct SurfaceRecord {
  static constexpr std::string_view kStep = "surface";
  std::optional<Finding> skipped_because;
  double cell_m = 0;
  std::int32_t width = 0, height = 0;                        ///< cells
  std::uint64_t points = 0, points_dropped = 0;              ///< dropped: not finite, or far from all others
  std::uint64_t measured_cells = 0, interpolated_cells = 0;  ///< the others are empty
  double lowest_m = 0, highest_m = 0;                        ///< of the measured cells
  double mean_sigma_m = 0, mean_sigma_relative_m = 0;        ///< quadratic means of the measured cells

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = SurfaceRecord;
    visit("skipped_because", &R::skipped_because);
    visit("cell_m", &R::cell_m);
    visit("width", &R::width);
    visit("height", &R::height);
    visit("points", &R::points);
    visit("points_dropped", &R::points_dropped);
    visit("measured_cells", &R::measured_cells);
    visit("interpolated_cells", &R::interpolated_cells);
    visit("lowest_m", &R::lowest_m);
    visit("highest_m", &R::highest_m);
    visit("mean_sigma_m", &R::mean_sigma_m);
    visit("mean_sigma_relative_m", &R::mean_sigma_relative_m);
  }
};

/// The terrain model; as SurfaceRecord.
struct TerrainRecord {
  static constexpr std::string_view kStep = "terrain";
  std::optional<Finding> skipped_because;
  double cell_m = 0;
  std::int32_t width = 0, height = 0;                      ///< cells
  std::uint64_t ground_cells = 0, interpolated_cells = 0;  ///< the others are empty
  std::uint64_t ground_points = 0;                         ///< of the cloud, that show the ground
  double coarse_cell_m = 0;                                ///< of the grid on which objects are told from the ground
  double lowest_m = 0, highest_m = 0;
  double mean_sigma_m = 0, mean_sigma_relative_m = 0;  ///< quadratic means of the ground cells
  double contour_m = 0;                                ///< interval; 0: no contours
  std::uint64_t contours = 0;                          ///< lines

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = TerrainRecord;
    visit("skipped_because", &R::skipped_because);
    visit("cell_m", &R::cell_m);
    visit("width", &R::width);
    visit("height", &R::height);
    visit("ground_cells", &R::ground_cells);
    visit("interpolated_cells", &R::interpolated_cells);
    visit("ground_points", &R::ground_points);
    visit("coarse_cell_m", &R::coarse_cell_m);
    visit("lowest_m", &R::lowest_m);
    visit("highest_m", &R::highest_m);
    visit("mean_sigma_m", &R::mean_sigma_m);
    visit("mean_sigma_relative_m", &R::mean_sigma_relative_m);
    visit("contour_m", &R::contour_m);
    visit("contours", &R::contours);
  }
};

/// Seamlines that the orthophoto was asked to follow.
struct GivenSeamlines {
  std::string file;
  std::uint64_t polygons = 0;

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("file", &GivenSeamlines::file);
    visit("polygons", &GivenSeamlines::polygons);
  }
};

/// The orthophoto; as SurfaceRecord.
struct OrthoRecord {
  static constexpr std::string_view kStep = "ortho";
  std::optional<Finding> skipped_because;
  double cell_m = 0;
  std::int32_t width = 0, height = 0;  ///< cells
  std::uint64_t painted_cells = 0, empty_cells = 0;
  std::uint64_t images_used = 0;
  double seam_length_m = 0;         ///< where both images see the position
  double seam_difference_grey = 0;  ///< mean over the seams: by how much the two images differ, after balancing
  double seam_step_grey = 0;        ///< root mean square over the seams: mean step between the two images of a pair
  std::optional<GivenSeamlines> seamlines;              ///< nothing: the seams were found
  std::map<ImageId, std::uint64_t> cells_not_followed;  ///< by images that a seamline names: cells they do not see
  std::vector<ImageId> sources;                         ///< of ortho_source.tif: its 1 is the first of them

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = OrthoRecord;
    visit("skipped_because", &R::skipped_because);
    visit("cell_m", &R::cell_m);
    visit("width", &R::width);
    visit("height", &R::height);
    visit("painted_cells", &R::painted_cells);
    visit("empty_cells", &R::empty_cells);
    visit("images_used", &R::images_used);
    visit("seam_length_m", &R::seam_length_m);
    visit("seam_difference_grey", &R::seam_difference_grey);
    visit("seam_step_grey", &R::seam_step_grey);
    visit("seamlines", &R::seamlines);
    visit("cells_not_followed", &R::cells_not_followed);
    visit("sources", &R::sources);
  }
};

/// A plane of the object, and the surface and orthophoto on it.
struct FrameRecord {
  std::string name;                                              ///< products/frames/NAME
  Eigen::Vector3d origin{0, 0, 0};                               ///< on the map; in the world where there is none
  Eigen::Vector3d right{0, 0, 0}, up{0, 0, 0}, normal{0, 0, 0};  ///< its axes, in the same
  double width_m = 0, height_m = 0, depth_m = 0;  ///< what it holds: along right, up, both ways along normal
  double area_m2 = 0, rms_m = 0;                  ///< of its points: what they cover, and their distances
  std::uint64_t points = 0;
  std::vector<ImageId> images;  ///< that see it from the front
  SurfaceRecord surface;
  OrthoRecord ortho;
  double contour_m = 0;        ///< interval of the lines of equal distance; 0: none
  std::uint64_t contours = 0;  ///< lines
  double scale = 0;            ///< of the drawing: 50 for 1:50

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = FrameRecord;
    visit("name", &R::name);
    visit("origin", &R::origin);
    visit("right", &R::right);
    visit("up", &R::up);
    visit("normal", &R::normal);
    visit("width_m", &R::width_m);
    visit("height_m", &R::height_m);
    visit("depth_m", &R::depth_m);
    visit("area_m2", &R::area_m2);
    visit("rms_m", &R::rms_m);
    visit("points", &R::points);
    visit("images", &R::images);
    visit("surface", &R::surface);
    visit("ortho", &R::ortho);
    visit("contour_m", &R::contour_m);
    visit("contours", &R::contours);
    visit("scale", &R::scale);
  }
};

/// The planes of the object beside the map.
struct FramesRecord {
  static constexpr std::string_view kStep = "frames";
  bool looked_for = false;  ///< false: the map shows it all
  bool metric = false;      ///< lengths are metres; else units of the block
  std::vector<FrameRecord> frames;

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("looked_for", &FramesRecord::looked_for);
    visit("metric", &FramesRecord::metric);
    visit("frames", &FramesRecord::frames);
  }
};

struct ReportRecord {
  static constexpr std::string_view kStep = "report";
  std::string file;  ///< below the project folder

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("file", &ReportRecord::file);
  }
};

/// The closed list of records.
using StepOutcome = std::variant<ImportRecord, DetectRecord, MatchRecord, OrientationRecord, AdjustmentRecord,
                                 DensifyRecord, SurfaceRecord, TerrainRecord, OrthoRecord, FramesRecord, ReportRecord>;

/// The name of the step that leaves such a record.
[[nodiscard]] std::string_view step_of(const StepOutcome& outcome);

/// Why the step made no product; nothing: it made them.
[[nodiscard]] std::optional<Finding> skipped_because(const StepOutcome& outcome);

/// The record as a byte string: its format, a fingerprint of its members, and these.
[[nodiscard]] std::string packed(const StepOutcome& outcome);

/// The record that packed() made of the outcome of `step`. Errors: kUnsupported when another version of the program
/// wrote it, whose records have other members; kBadFormat when the bytes are damaged, or there is no such step.
[[nodiscard]] Result<StepOutcome> unpacked_outcome(std::string_view step, std::string_view bytes);

}  // namespace collinea
