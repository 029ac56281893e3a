// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/file_text.h"
#include "collinea/cloud/ply.h"
#include "collinea/dense/stereo.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/io/text.h"
#include "collinea/jobs/internal/ground_table.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/jobs/internal/pair_findings.h"
#include "collinea/jobs/internal/pair_map.h"
#include "collinea/jobs/internal/pair_steps.h"
#include "collinea/math/median.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kControlSigma_m = 0.02;  // where none is stated
constexpr double kPartAround = 0.15;      // of the range of disparities, that semi-global matching looks at beyond it
constexpr int kLineEvery = 12;            // part of the rows between two lines of the check
constexpr int kCheckWidth_px = 2000;
constexpr FileText kPointsRemark =
    "homologous points; coordinates of the image files; y-parallax left by the relative orientation";

// The pair resampled so that homologous points lie in one row.
struct EpipolarImages {
  EpipolarPair cameras;
  GreyImage left, right;
  ColourImage colours;
  std::vector<LevelPoint> points;  // those of the orientation
};

Result<EpipolarImages> epipolar_images(const PairImages& images, const RelativeOrientation& orientation, double base,
                                       const std::vector<MatchedPoint>& points, const Run& run) {
  EpipolarImages made;
  Rigid3 right_from_left = orientation.second_from_first;
  right_from_left.translation *= base;
  COLLINEA_TRY(made.cameras, epipolar_pair(images.left_camera, Rigid3{}, images.right_camera, right_from_left));
  const EpipolarPair& cameras = made.cameras;
  made.left = resampled(images.left, images.left_camera, cameras.left_from_image, cameras.left, run);
  made.right = resampled(images.right, images.right_camera, cameras.right_from_image, cameras.right, run);
  made.colours = resampled(images.left_colours, images.left_camera, cameras.left_from_image, cameras.left, run);
  for (const MatchedPoint& point : points) {
    const Eigen::Vector2d left = in_epipolar(images.left_camera, cameras.left_from_image, cameras.left, point.left_px);
    const Eigen::Vector2d right =
        in_epipolar(images.right_camera, cameras.right_from_image, cameras.right, point.right_px);
    if (left.allFinite() && right.allFinite())
      made.points.push_back({left, left.x() - right.x(), right.y() - left.y(), point.ncc, orientation.sigma0});
  }
  return made;
}

double median_disparity(const std::vector<LevelPoint>& points) {
  std::vector<double> values;
  for (const LevelPoint& point : points) values.push_back(point.disparity_px);
  return values.empty() ? 0 : median(values);
}

Eigen::Vector3d point_of(const EpipolarPair& cameras, const LevelPoint& point) {
  const double depth = cameras.depth_at(point.disparity_px);
  return inverse(cameras.left_from_world) * (depth * normalized(cameras.left, point.left_px).homogeneous());
}

// The standard deviation of a depth by that of its disparity.
double sigma_z(const EpipolarPair& cameras, const LevelPoint& point) {
  const double depth = cameras.depth_at(point.disparity_px);
  return depth * depth / (cameras.left.focal_px() * cameras.base_m) * point.sigma_px;
}

std::vector<LevelPoint> points_of(const DisparityMap& map) {
  std::vector<LevelPoint> points;
  for (int y = 0; y < map.disparity.height; ++y)
    for (int x = 0; x < map.disparity.width; ++x)
      if (const float disparity = map.disparity.at(x, y); !std::isnan(disparity))
        points.push_back({{x + 0.5, y + 0.5}, disparity, 0, 1, map.sigma.at(x, y)});
  return points;
}

Result<std::vector<LevelPoint>> surface_of(const EpipolarImages& images, const RelativeOrientation& orientation,
                                           const PairChainOptions& options, PairReport& report, const Run& run) {
  const auto sigma = row_sigma(images.cameras, orientation, median_disparity(images.points));
  for (const LevelPoint& point : images.points)
    report.row_sigma_px = std::max(report.row_sigma_px, sigma(point.left_px));
  if (options.surface == PairSurface::kLevels) {
    COLLINEA_TRY(LevelSurface surface,
                 match_by_levels(images.left, images.right, images.points, sigma, options.levels, run));
    report.levels = std::move(surface.levels);
    return std::move(surface.points);
  }
  double low = images.points.front().disparity_px, high = low;
  for (const LevelPoint& point : images.points) {
    low = std::min(low, point.disparity_px);
    high = std::max(high, point.disparity_px);
  }
  const double around = kPartAround * (high - low) + 3;
  COLLINEA_TRY(const DisparityMap map,
               match_pair(images.left, images.right, {int(std::floor(low - around)), int(std::ceil(high + around))},
                          StereoOptions{}, run));
  return points_of(map);
}

// Control of the table, intersected in the model: where it is in the left image.
Result<std::vector<Eigen::Vector2d>> orient_absolutely(const fs::path& file, const PairImages& images,
                                                       const EpipolarPair& cameras,
                                                       const RelativeOrientation& orientation, double sigma_px,
                                                       PairReport& report) {
  const auto within = [&](Error error) { return std::move(error).within(file.string()); };
  COLLINEA_TRY(const GroundTable ground, read_ground_table(file, kControlSigma_m, false));
  std::array<std::vector<double>, 4> pixels;
  const char* const columns[] = {"x_left", "y_left", "x_right", "y_right"};
  for (std::size_t i = 0; i < 4; ++i) {
    COLLINEA_TRY(pixels[i], ground.table.numbers(columns[i], "px").map_error(within));
  }
  Rigid3 right_from_left = orientation.second_from_first;
  right_from_left.translation *= cameras.base_m;
  std::vector<AbsoluteControl> pairs;
  std::vector<Eigen::Vector2d> left_px;
  for (std::size_t i = 0; i < ground.points.size(); ++i) {
    const GroundTablePoint& point = ground.points[i];
    report.control_names.push_back(point.name);
    Eigen::Vector2d in_left(pixels[0][i], pixels[1][i]), in_right(pixels[2][i], pixels[3][i]);
    if (images.film) {
      const auto left = images.film->in_left(in_left), right = images.film->in_right(in_right);
      if (!left || !right)
        return fail(Errc::kBadInput, fmt::format("{}: point {} lies beyond the film", file.string(), point.name));
      in_left = *left;
      in_right = *right;
    }
    left_px.emplace_back(in_left / images.shrink);
    const double sigma = sigma_px / images.shrink;
    const std::array<SightLine, 2> lines = {
        SightLine{&images.left_camera, {}, left_px.back(), sigma, {}},
        SightLine{&images.right_camera, right_from_left, in_right / images.shrink, sigma, {}}};
    const auto met = intersect(lines);
    if (!met)
      return fail(Errc::kIllPosed, fmt::format("{}: the rays of point {} do not meet in front of the cameras",
                                               file.string(), point.name));
    AbsoluteControl pair{.in_model = met->point_in_world, .model_covariance = met->covariance};
    pair.has_plan = point.has_plan();
    pair.has_height = point.has_height();
    for (int k = 0; k < 3; ++k) {
      const bool is_known = std::isfinite(point.position[k]);
      pair.in_ground[k] = is_known ? point.position[k] : 0;
      pair.ground_covariance(k, k) = is_known ? point.sigma[k] * point.sigma[k] : 0;
    }
    pairs.push_back(pair);
  }
  COLLINEA_TRY(report.absolute, absolute_orientation(pairs).map_error(within));
  return left_px;
}

TextTable point_table(const std::vector<MatchedPoint>& points, const RelativeOrientation& orientation, int shrink) {
  TextTable table;
  table.remarks = {std::string(kPointsRemark)};
  table.columns = {{"point", ""},     {"x_left", "px"},     {"y_left", "px"}, {"x_right", "px"},
                   {"y_right", "px"}, {"y_parallax", "px"}, {"ncc", "1"}};
  std::size_t next = 0;
  for (const PairResidual& residual : orientation.residuals) {
    if (!residual.used) continue;
    const MatchedPoint& point = points[next++];
    table.rows.push_back({std::to_string(next), fixed(point.left_px.x() * shrink, 3),
                          fixed(point.left_px.y() * shrink, 3), fixed(point.right_px.x() * shrink, 3),
                          fixed(point.right_px.y() * shrink, 3), fixed(residual.y_parallax, 3), fixed(point.ncc, 3)});
  }
  return table;
}

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

// In the frame of the left camera, or with absolute orientation on the ground.
std::vector<CloudPoint> cloud_of(const EpipolarImages& images, const std::vector<LevelPoint>& points,
                                 const std::optional<AbsoluteOrientation>& absolute) {
  std::vector<CloudPoint> cloud;
  for (const LevelPoint& point : points) {
    CloudPoint made;
    made.position = point_of(images.cameras, point);
    if (!made.position.allFinite() || !(images.cameras.depth_at(point.disparity_px) > 0)) continue;
    double scale = 1;
    if (absolute) {
      made.position = absolute->ground_from_model * made.position;
      scale = absolute->ground_from_model.scale;
    }
    const int x = std::clamp(int(point.left_px.x()), 0, images.colours.width - 1);
    const int y = std::clamp(int(point.left_px.y()), 0, images.colours.height - 1);
    for (int c = 0; c < 3; ++c) made.colour[std::size_t(c)] = images.colours.at(x, y, c);
    made.sigma_m = float(scale * sigma_z(images.cameras, point));
    made.images = 2;
    cloud.push_back(made);
  }
  return cloud;
}

Result<> write_cloud(const fs::path& folder, const std::vector<CloudPoint>& cloud, bool is_on_ground) {
  COLLINEA_TRY(PlyWriter writer,
               PlyWriter::create(folder / "cloud.ply",
                                 is_on_ground ? std::string(kPairCloudComment) : std::string(kLeftCameraCloudComment)));
  writer.write(cloud);
  return writer.finish();
}

// Surface model and orthophoto: on the ground, or without control in the frame of the left camera with z towards it,
// once the base is in metres.
Result<std::optional<PairMap>> map_of(const PairImages& images, const EpipolarPair& cameras,
                                      const RelativeOrientation& orientation, const PairReport& report,
                                      std::vector<CloudPoint> cloud, std::optional<double> cell_m,
                                      const fs::path& folder, const Run& run) {
  if (!report.absolute && !report.has_base) return std::optional<PairMap>();
  Similarity3 ground_from_model{.rotation = Eigen::Quaterniond(0, 1, 0, 0)};  // half a turn about x
  if (report.absolute) ground_from_model = report.absolute->ground_from_model;
  Rigid3 right_from_left = orientation.second_from_first;
  right_from_left.translation *= cameras.base_m;
  const MappedPair pair{images.files,
                        images.file_cameras,
                        {moved(Rigid3{}, ground_from_model), moved(right_from_left, ground_from_model)}};
  std::vector<double> sizes_m;
  for (CloudPoint& point : cloud) {
    if (!report.absolute) point.position = ground_from_model * point.position;
    sizes_m.push_back((pair.cam_from_ground[0] * point.position).z() / images.left_camera.focal_px());
  }
  return map_pair(pair, cloud, sizes_m.empty() ? 1 : median(sizes_m), cell_m, folder, run);
}

void describe_points(const EpipolarImages& images, const std::vector<LevelPoint>& points, PairReport& report) {
  double squares = 0;
  for (const LevelPoint& point : images.points) squares += point.row_px * point.row_px;
  if (!images.points.empty()) report.y_parallax_rms_px = std::sqrt(squares / double(images.points.size()));
  std::vector<double> in_image, in_depth;
  for (const LevelPoint& point : points) {
    in_image.push_back(point.sigma_px);
    in_depth.push_back(sigma_z(images.cameras, point));
  }
  if (points.empty()) return;
  report.median_sigma_px = median(in_image);
  report.median_sigma_z = median(in_depth);
}

}  // namespace

Result<PairReport> orient_and_match(const fs::path& left, const fs::path& right, const fs::path& folder,
                                    const PairChainOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  if (options.surface == PairSurface::kDense && options.levels != LevelOptions{})
    return fail(Errc::kBadInput, "options of the levels say nothing of the dense surface", {"surface"_option});
  COLLINEA_TRY(make_out_folder(folder));
  COLLINEA_TRY(const PairImages images, read_pair(left, right, folder, options, run));
  PairReport report{.left_width_px = images.left.width,
                    .left_height_px = images.left.height,
                    .shrink = images.shrink,
                    .surface = options.surface,
                    .has_base = options.base_m.has_value()};
  if (images.film)
    for (const ScanOrientation* scan : {&images.film->left, &images.film->right})
      report.scans.push_back({scan->marks, scan->misread(), 1e3 * scan->rms_mm(), 1e3 * scan->pixel_mm()});
  COLLINEA_TRY(PairPoints found, find_pair_points(images.left, images.right, options.points, run));
  report.search = found.stages;
  std::vector<MatchedPoint> points = std::move(found.points);
  run.report("points", 1);
  COLLINEA_TRY(const PairOrientation first, oriented_by("ncc", points, images, options.relative, run.seed));
  report.orientations.push_back(first);
  if (options.refine) {
    points = refined(points, images, run);
    COLLINEA_TRY(const PairOrientation second, oriented_by("lsm", points, images, options.relative, run.seed));
    report.orientations.push_back(second);
  }
  const RelativeOrientation& orientation = report.orientations.back().orientation;
  COLLINEA_TRY(const EpipolarImages epipolar,
               epipolar_images(images, orientation, options.base_m.value_or(1), points, run));
  report.epipolar = epipolar.cameras;
  std::vector<Eigen::Vector2d> control_px;  // in the left image
  if (options.control) {
    COLLINEA_TRY(control_px, orient_absolutely(*options.control, images, epipolar.cameras, orientation,
                                               options.control_sigma_px, report));
  }
  COLLINEA_TRY(const std::vector<LevelPoint> surface, surface_of(epipolar, orientation, options, report, run));
  describe_points(epipolar, surface, report);
  COLLINEA_TRY(write_file(folder / "points.txt", text_of(point_table(points, orientation, images.shrink))));
  COLLINEA_TRY(write_png(folder / "epipolar_left.png", epipolar.left));
  COLLINEA_TRY(write_png(folder / "epipolar_right.png", epipolar.right));
  COLLINEA_TRY(write_png(folder / "epipolar_check.png", check_of(epipolar)));
  std::vector<CloudPoint> cloud = cloud_of(epipolar, surface, report.absolute);
  report.surface_points = cloud.size();
  COLLINEA_TRY(write_cloud(folder, cloud, report.absolute.has_value()));
  COLLINEA_TRY(report.map,
               map_of(images, epipolar.cameras, orientation, report, std::move(cloud), options.cell_m, folder, run));
  report.findings = pair_findings(images, points, report, control_px, options.wanted_sigma_z_m);
  COLLINEA_TRY(write_file(folder / "pair.txt", pair_text(report)));
  return report;
}

}  // namespace collinea
