// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "collinea/base/parallel.h"
#include "collinea/dense/working_images.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/number_rows.h"
#include "collinea/match/window_matching.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kMostPixels = 16e6;
Eigen::Matrix3d essential_of(const Rigid3& second_from_first) {
  return skew(second_from_first.translation) * second_from_first.rotation.toRotationMatrix();
}

constexpr double kFarthest_px = 2;  // that least squares matching may move a point
// Larger windows overlap those of neighbouring points: sigma 0 falls, errors of the orientation do not.
constexpr int kWindow_px = 15;
// What lenses and windows on curved surfaces add to the noise of matching: with it sigma 0 of three pairs of a wall was
// 0.69 to 1.12, without 1.1 to 1.9 (docs/theory/least-squares-matching.md).
constexpr double kBeyondNoise_px = 0.06;

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
                     sigma_px * point.sigma_px / images.left_camera.focal_px(),
                     sigma_px * point.sigma_px / images.right_camera.focal_px()});
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
  WindowOptions options;
  options.farthest_px = kFarthest_px;
  options.window_px = kWindow_px;
  std::vector<std::optional<MatchedPoint>> found(points.size());
  parallel_for(run, points.size(), [&](std::size_t i) {
    const auto match = match_window(images.left, points[i].left_px, images.right, {points[i].right_px}, options);
    if (match.outcome != WindowOutcome::kFound) return;
    const double noise_px = std::sqrt(match.covariance_px2.trace() / 2);
    found[i] =
        MatchedPoint{points[i].left_px, match.position_px, match.correlation, std::hypot(noise_px, kBeyondNoise_px)};
  });
  std::vector<MatchedPoint> kept;
  double weights = 0;
  for (const auto& each : found)
    if (each) {
      kept.push_back(*each);
      weights += 1 / (each->sigma_px * each->sigma_px);
    }
  // Sigma 0 is to be that of a point of mean weight.
  for (MatchedPoint& point : kept) point.sigma_px *= std::sqrt(weights / double(kept.size()));
  return kept;
}

Eigen::Vector2d in_epipolar(const Camera& image, const Eigen::Quaterniond& epipolar_from_image, const Camera& epipolar,
                            const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = epipolar_from_image * normalized(image, pixel).homogeneous();
  return project(epipolar, ray).value_or(Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
}

std::function<double(const Eigen::Vector2d&)> row_sigma(const EpipolarPair& epipolar,
                                                        const RelativeOrientation& orientation, double disparity_px) {
  constexpr double kStep = 1e-5;
  const Eigen::Matrix3d essential = essential_of(orientation.second_from_first);
  std::array<Eigen::Matrix3d, 5> changes;
  for (int i = 0; i < 5; ++i)
    changes[std::size_t(i)] = (essential_of(changed(orientation.second_from_first, kStep * Vector5::Unit(i))) -
                               essential_of(changed(orientation.second_from_first, -kStep * Vector5::Unit(i)))) /
                              (2 * kStep);
  const Matrix5 covariance = orientation.stated_covariance();
  return [=](const Eigen::Vector2d& left_px) {
    const Eigen::Vector2d right_px = left_px - Eigen::Vector2d(disparity_px, 0);
    const Eigen::Vector3d first =
        epipolar.left_from_image.conjugate() * normalized(epipolar.left, left_px).homogeneous();
    const Eigen::Vector3d second =
        epipolar.right_from_image.conjugate() * normalized(epipolar.right, right_px).homogeneous();
    const Eigen::Vector3d line = essential * (first / first.z());
    Vector5 by;
    for (int i = 0; i < 5; ++i)
      by[i] = (second / second.z()).dot(changes[std::size_t(i)] * (first / first.z())) / line.head<2>().norm();
    return epipolar.right.focal_px() * std::sqrt(std::max(by.dot(covariance * by), 0.0));
  };
}

}  // namespace collinea
