// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/base/parallel.h"
#include "collinea/dense/working_images.h"
#include "collinea/epipolar/epipolar_lines.h"
#include "collinea/io/number_rows.h"
#include "collinea/match/least_squares_matching.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kMostPixels = 16e6;
constexpr double kFarthest_px = 2;  // that least squares matching may move a point

Result<Camera> camera_of(const fs::path& file, const PairChainOptions& options) {
  COLLINEA_TRY(const ImageHeader header, read_image_header(file));
  Camera camera = ideal_camera(*options.principal_distance_px, header.width_px, header.height_px);
  if (options.principal_point_px) {
    const auto point = parse_numbers(*options.principal_point_px);
    if (!point || point->size() != 2)
      return fail(Errc::kBadInput, "the principal point is not two numbers with a comma between",
                  {"principal_point_px"_option});
    camera.params[Camera::kCx] = (*point)[0];
    camera.params[Camera::kCy] = (*point)[1];
  }
  return camera;
}

}  // namespace

Result<PairImages> read_pair(const fs::path& left, const fs::path& right, const fs::path& folder,
                             const PairChainOptions& options, const Run& run) {
  PairImages images;
  COLLINEA_TRY(check_film(options.film));
  if (options.film.calibration) {
    COLLINEA_TRY(images.film, pair_film(left, right, folder, options, run));
    images.files = {images.film->left_file, images.film->right_file};
    images.file_cameras.fill(images.film->ideal.camera);
  } else {
    if (!options.principal_distance_px)
      return fail(Errc::kBadInput, "nothing says the principal distance of the images",
                  {"principal_distance_px"_option, "film"_option});
    images.files = {left, right};
    COLLINEA_TRY(images.file_cameras[0], camera_of(left, options));
    COLLINEA_TRY(images.file_cameras[1], camera_of(right, options));
  }
  const auto& [left_camera, right_camera] = images.file_cameras;
  if (options.resolution) {
    images.shrink = static_cast<int>(*options.resolution);
  } else {
    const double pixels = std::max(double(left_camera.width_px) * left_camera.height_px,
                                   double(right_camera.width_px) * right_camera.height_px);
    while (pixels / (double(images.shrink) * images.shrink) > kMostPixels) images.shrink *= 2;
  }
  images.left_camera = shrunk(left_camera, images.shrink);
  images.right_camera = shrunk(right_camera, images.shrink);
  COLLINEA_TRY(images.left, read_grey(images.files[0], images.shrink));
  COLLINEA_TRY(images.right, read_grey(images.files[1], images.shrink));
  COLLINEA_TRY(images.left_colours, read_colour(images.files[0], images.shrink));
  return images;
}

std::vector<PairPoint> normalised(const std::vector<MatchedPoint>& points, const PairImages& images, double sigma_px) {
  std::vector<PairPoint> pairs;
  for (const MatchedPoint& point : points)
    pairs.push_back({normalized(images.left_camera, point.left_px), normalized(images.right_camera, point.right_px),
                     sigma_px / images.left_camera.focal_px(), sigma_px / images.right_camera.focal_px()});
  return pairs;
}

Result<PairOrientation> oriented_by(const std::string& by, std::vector<MatchedPoint>& points, const PairImages& images,
                                    const RelativeOptions& options, std::uint64_t seed) {
  PairOrientation made{.by = by, .points = points.size()};
  COLLINEA_TRY(made.orientation, relative_orientation(normalised(points, images, 1), options, seed));
  made.rejected = made.orientation.rejected.size();
  made.sigma0_px = made.orientation.sigma0;
  std::vector<MatchedPoint> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (made.orientation.residuals[i].used) kept.push_back(points[i]);
  points = std::move(kept);
  return made;
}

std::vector<MatchedPoint> refined(const std::vector<MatchedPoint>& points, const PairImages& images, const Run& run) {
  std::vector<std::optional<MatchedPoint>> found(points.size());
  parallel_for(run, points.size(), [&](std::size_t i) {
    const auto patch = cut_patch(images.left, 1, points[i].left_px);
    const auto other = cut_patch(images.right, 1, points[i].right_px);
    if (!patch || !other) return;
    const auto window = ReferenceWindow::of(*patch, points[i].left_px);
    if (!window) return;
    const auto match = window->find(*other, {points[i].right_px, Eigen::Matrix2d::Identity()}, kFarthest_px);
    if (match) found[i] = MatchedPoint{points[i].left_px, match->placement.position_px, match->correlation};
  });
  std::vector<MatchedPoint> kept;
  for (const auto& each : found)
    if (each) kept.push_back(*each);
  return kept;
}

Eigen::Vector2d in_epipolar(const Camera& image, const Eigen::Quaterniond& epipolar_from_image, const Camera& epipolar,
                            const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = epipolar_from_image * normalized(image, pixel).homogeneous();
  return project(epipolar, ray).value_or(Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
}

std::function<double(const Eigen::Vector2d&)> row_sigma(const EpipolarPair& epipolar,
                                                        const RelativeOrientation& orientation, double disparity_px) {
  return [=, lines = EpipolarLines(orientation.second_from_first, orientation.stated_covariance())](
             const Eigen::Vector2d& left_px) {
    const Eigen::Vector2d right_px = left_px - Eigen::Vector2d(disparity_px, 0);
    const Eigen::Vector3d first =
        epipolar.left_from_image.conjugate() * normalized(epipolar.left, left_px).homogeneous();
    const Eigen::Vector3d second =
        epipolar.right_from_image.conjugate() * normalized(epipolar.right, right_px).homogeneous();
    return epipolar.right.focal_px() * lines.sigma(first.hnormalized(), second.hnormalized());
  };
}

}  // namespace collinea
