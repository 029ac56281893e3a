// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/pair.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/memory.h"
#include "collinea/base/parallel.h"
#include "collinea/dense/working_images.h"
#include "collinea/jobs/internal/fundamental_file.h"
#include "collinea/jobs/internal/given_pair.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/jobs/internal/pair_area.h"
#include "collinea/jobs/internal/pair_control.h"
#include "collinea/jobs/internal/pair_exterior.h"
#include "collinea/jobs/internal/pair_findings.h"
#include "collinea/jobs/internal/pair_map.h"
#include "collinea/jobs/internal/pair_orientation.h"
#include "collinea/jobs/internal/pair_surface.h"
#include "collinea/jobs/result_tables.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr int kLineEvery = 12;  // part of the rows between two lines of the check
constexpr int kCheckWidth_px = 2000;
// The left epipolar image above the right one's rows: side by side with lines through both.
ColourImage check_of(const EpipolarImages& images) {
  const int step = std::max((images.left.width + images.right.width) / kCheckWidth_px, 1);
  const int width = images.left.width / step + images.right.width / step, height = images.left.height / step;
  ColourImage check(std::max(width, 1), std::max(height, 1), 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool is_left = x < images.left.width / step;
      const GreyImage& from = is_left ? images.left : images.right;
      const std::uint8_t grey =
          from.at(std::min((is_left ? x : x - images.left.width / step) * step, from.width - 1), y * step);
      const bool is_line = y % std::max(height / kLineEvery, 1) == height / kLineEvery / 2;
      for (int c = 0; c < 3; ++c) check.at(x, y, c) = is_line ? std::uint8_t(c == 0 ? 255 : grey / 2) : grey;
    }
  return check;
}

Result<> write_epipolar(const EpipolarImages& images, const fs::path& folder, const Run& run) {
  std::array<Result<>, 3> written;
  parallel_for(run, written.size(), [&](std::size_t i) {
    written[i] = i == 0   ? write_png(folder / "epipolar_left.png", images.left)
                 : i == 1 ? write_png(folder / "epipolar_right.png", images.right)
                          : write_png(folder / "epipolar_check.png", check_of(images));
  });
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  for (Result<>& each : written)
    if (!each) return std::move(each);
  return {};
}

// Surface model and orthophoto: on the ground, or without control in the frame of the left camera with z towards it,
// once the base is in metres.
Result<std::optional<PairMap>> map_of(const PairFiles& pair, const ModelOfPair& model, const PairReport& report,
                                      const PairCloudSummary& cloud, std::optional<double> cell_m,
                                      const fs::path& folder, const Run& run) {
  if (!report.absolute && !report.has_base) return std::optional<PairMap>();
  const Similarity3 frame = map_from_model(report.absolute);
  const MappedPair mapped{pair.files, pair.cameras, {moved(Rigid3{}, frame), moved(model.right_from_left(), frame)}};
  const MappedCloud points{folder / "cloud.ply", report.absolute ? Similarity3{} : frame,
                           cloud.points,         cloud.distance_m,
                           cloud.pixel_m,        &cloud.matching_sigmas,
                           cloud.by_orientation};
  return map_pair(mapped, points, cell_m, folder, run);
}

double rms_row_px(const std::vector<LevelPoint>& points) {
  double squares = 0;
  for (const LevelPoint& point : points) squares += point.row_px * point.row_px;
  return points.empty() ? 0 : std::sqrt(squares / double(points.size()));
}

PairReport report_of(const PairFiles& pair, int shrink, const PairChainOptions& options) {
  const Camera left = shrunk(pair.cameras[0], shrink);
  PairReport report{.files = pair.files,
                    .cameras = pair.cameras,
                    .left_width_px = left.width_px,
                    .left_height_px = left.height_px,
                    .shrink = shrink,
                    .resampling = options.resampling,
                    .surface = options.surface};
  if (pair.film) report.pixel_um = 1e3 * pair.film->ideal.pixel_mm * shrink;
  if (pair.film)
    for (const ScanOrientation* scan : {&pair.film->left, &pair.film->right})
      report.scans.push_back({scan->marks, scan->misread(), 1e3 * scan->rms_mm(), 1e3 * scan->pixel_mm()});
  return report;
}

// The pair on the ground: by the orientation as given, or by what control there is.
struct OnGround {
  std::optional<PairControl> control;
  PairOrientationSigma sigma;
};

Result<OnGround> orient_on_ground(const PairFiles& pair, const ModelOfPair& model,
                                  const std::optional<GivenPair>& given, const PairChainOptions& options,
                                  PairReport& report) {
  if (given && given->is_metric) {
    report.absolute = given->ground_from_model();
    report.exterior = pair_exterior(given->poses, pair, true);
    COLLINEA_TRY(PairOrientationSigma sigma, PairOrientationSigma::of(model, given->poses));
    return OnGround{{}, std::move(sigma)};
  }
  std::optional<PairControl> control;
  if (options.control) {
    COLLINEA_TRY(control, read_pair_control(*options.control, pair, model.shrink, options.control_sigma_px));
    COLLINEA_TRY(report.absolute, oriented_with_rejection(*control, model, model.right_from_left(),
                                                          options.reject_control, options.control_alpha));
    report.control_names = control->used_names();
    COLLINEA_TRY(report.control, pair_control_report(*control, model, *report.absolute, options.control_alpha));
  }
  COLLINEA_TRY(const auto poses, exterior_poses(model, control, report.absolute));
  report.exterior = pair_exterior(poses, pair, report.is_metric());
  COLLINEA_TRY(PairOrientationSigma sigma, PairOrientationSigma::of(model, control, report.absolute));
  return OnGround{std::move(control), std::move(sigma)};
}

// Options that would not be looked at.
Result<> check(const PairChainOptions& options) {
  COLLINEA_TRY(validate(options));
  if (options.surface == PairSurface::kDense && options.levels != LevelOptions{})
    return fail(Errc::kBadInput, "options of the levels say nothing of the dense surface", {"surface"_option});
  if (options.reject_control && !options.control)
    return fail(Errc::kBadInput, "there is no control to be rejected", {"reject_control"_option, "control"_option});
  if (options.exterior &&
      (options.relative.start != RelativeOptions{}.start || options.relative.weights != RelativeOptions{}.weights))
    return fail(Errc::kBadInput, "nothing is estimated of an orientation that is given",
                {"exterior"_option, "start"_option, "weights"_option});
  return {};
}

Result<> write_tables(const PairReport& report, const fs::path& folder) {
  COLLINEA_TRY(write_result_tables(pair_tables(report), folder));
  COLLINEA_TRY(
      write_fundamental(report.cameras[0], report.cameras[1], report.relative->orientation.second_from_first, folder));
  return write_file(folder / "relative_geometry.svg", pair_shape_svg(*report.relative));
}

}  // namespace

Result<PairReport> orient_and_match(const fs::path& left, const fs::path& right, const fs::path& folder,
                                    const PairChainOptions& options, const Run& run) {
  COLLINEA_TRY(check(options));
  COLLINEA_TRY(make_out_folder(folder));
  std::optional<GivenPair> given;
  if (options.exterior) {
    COLLINEA_TRY(given, read_given_pair(left, right, options));
  }
  COLLINEA_TRY(const PairFiles pair, open_pair(left, right, folder, options, run));
  COLLINEA_TRY(const std::optional<PairArea> area, area_of(options, pair.cameras[0]));
  COLLINEA_TRY(const PairShrinks shrinks,
               shrinks_of(pair, options, area ? std::optional(area->pixels()) : std::nullopt));
  PairReport report = report_of(pair, shrinks.surface, options);
  report.is_given = given.has_value();
  report.has_base = options.base_m || (given && given->is_metric);
  COLLINEA_TRY(OrientedPair found, orient_pair(pair, shrinks, options, report, run, given));
  const double base = given ? given->base : options.base_m.value_or(1);
  COLLINEA_TRY(ModelOfPair model, model_of(found, report.orientations.back().orientation, base));
  if (area) {
    COLLINEA_TRY(model, cropped_to(*area, std::move(model)));
  }
  report.epipolar = model.epipolar;
  report.y_parallax_rms_px = rms_row_px(model.in_epipolar);
  report.relative = relative_report_of(report.orientations.back(), pair, options.relative,
                                       report.has_base ? std::optional(base) : std::nullopt, report.is_given);
  COLLINEA_TRY(const OnGround ground, orient_on_ground(pair, model, given, options, report));
  COLLINEA_TRY(write_tables(report, folder));
  EpipolarImages epipolar = epipolar_images(std::move(found.images), model, options.resampling, run);
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  COLLINEA_TRY(write_epipolar(epipolar, folder, run));
  COLLINEA_TRY(const PairCloudSummary cloud,
               write_surface(std::move(epipolar), pair, model, ground.sigma, options, folder, report, run));
  give_back_freed_memory();
  report.surface_points = cloud.points;
  report.median_sigma_px = cloud.median_sigma_px;
  report.median_sigma_z = cloud.median_sigma_z;
  COLLINEA_TRY(report.map, map_of(pair, model, report, cloud, options.cell_m, folder, run));
  report.findings =
      pair_findings(model, report, ground.control ? ground.control->used_left_px() : std::vector<Eigen::Vector2d>{},
                    options.wanted_sigma_z_m);
  COLLINEA_TRY(write_pair_report(report, folder));
  return report;
}

}  // namespace collinea
