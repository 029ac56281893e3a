// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/base/memory.h"
#include "collinea/base/parallel.h"
#include "collinea/dense/working_images.h"
#include "collinea/epipolar/epipolar_lines.h"
#include "collinea/io/colmap.h"
#include "collinea/io/number_rows.h"
#include "collinea/match/window_matching.h"
#include "collinea/project/fitted_camera.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr double kMostSearchPixels = 16e6;  // where points are looked for: correlation finds them there as well
// On which the surface is found where nothing is asked: what takes less than three minutes and 2 GiB on two cores.
constexpr double kMostPixels = 256e6, kMostDensePixels = 64e6;
constexpr int kMostShrink = 8;

// Images in work, with what matching takes besides; both images in colour for an orthophoto of their resolution.
double peak_bytes(double pixels, PairSurface surface) {
  constexpr double kBesides = 600e6;
  return kBesides + pixels * (surface == PairSurface::kDense ? 6 : 3);
}

constexpr double kReadBytes = 5;  // a pixel of whole images where an area is worked on: two in grey, one in colour

constexpr double kFarthest_px = 2;  // that least squares matching may move a point
// Larger windows overlap those of neighbouring points: sigma 0 falls, errors of the orientation do not.
constexpr int kWindow_px = 15;
// What lenses and windows on curved surfaces add to the noise of matching: with it sigma 0 of three pairs of a wall was
// 0.69 to 1.12, without 1.1 to 1.9 (docs/theory/least-squares-matching.md).
constexpr double kBeyondNoise_px = 0.06;

// Cameras of a file, as large as the images.
Result<std::array<Camera, 2>> cameras_of_file(const PairChainOptions& options,
                                              const std::array<ImageHeader, 2>& headers,
                                              const std::array<fs::path, 2>& files) {
  COLLINEA_TRY(const std::vector<Camera> known, read_colmap_cameras(*options.camera));
  if (known.size() > 2)
    return fail(Errc::kBadInput,
                fmt::format("{}: {} cameras; a pair has one or two", options.camera->string(), known.size()),
                {"camera"_option});
  std::array<Camera, 2> cameras;
  for (std::size_t i = 0; i < 2; ++i) {
    const Camera& camera = known[std::min(i, known.size() - 1)];
    COLLINEA_TRY(cameras[i], fitted_to(camera, headers[i].width_px, headers[i].height_px, files[i].string()));
  }
  return cameras;
}

// Ideal cameras by the principal distance.
Result<std::array<Camera, 2>> cameras_by_options(const PairChainOptions& options,
                                                 const std::array<ImageHeader, 2>& headers) {
  std::array<Camera, 2> cameras;
  for (std::size_t i = 0; i < 2; ++i)
    cameras[i] = ideal_camera(*options.principal_distance_px, headers[i].width_px, headers[i].height_px);
  if (!options.principal_point_px) return cameras;
  const auto point = parse_numbers(*options.principal_point_px);
  if (!point || point->size() != 2)
    return fail(Errc::kBadInput, "the principal point is not two numbers with a comma between",
                {"principal_point_px"_option});
  for (Camera& camera : cameras) {
    camera.params[Camera::kCx] = (*point)[0];
    camera.params[Camera::kCy] = (*point)[1];
  }
  return cameras;
}

}  // namespace

double PairFiles::pixels() const {
  return std::max(double(cameras[0].width_px) * cameras[0].height_px,
                  double(cameras[1].width_px) * cameras[1].height_px);
}

Rigid3 ModelOfPair::right_from_left() const {
  Rigid3 right_from_left = orientation.second_from_first;
  right_from_left.translation *= epipolar.base_m;
  return right_from_left;
}

Result<PairFiles> open_pair(const fs::path& left, const fs::path& right, const fs::path& folder,
                            const PairChainOptions& options, const Run& run) {
  PairFiles pair;
  COLLINEA_TRY(check_film(options.film));
  if (options.film.calibration) {
    COLLINEA_TRY(pair.film, pair_film(left, right, folder, options, run));
    pair.files = {pair.film->left_file, pair.film->right_file};
    pair.cameras.fill(pair.film->ideal.camera);
    return pair;
  }
  if (options.camera && (options.principal_distance_px || options.principal_point_px))
    return fail(Errc::kBadInput, "the camera file states principal distance and principal point",
                {"camera"_option, "principal_distance_px"_option, "principal_point_px"_option});
  if (!options.camera && !options.principal_distance_px)
    return fail(Errc::kBadInput, "nothing says the principal distance of the images",
                {"principal_distance_px"_option, "camera"_option, "film"_option});
  pair.files = {left, right};
  std::array<ImageHeader, 2> headers;
  for (std::size_t i = 0; i < 2; ++i) {
    COLLINEA_TRY(headers[i], read_image_header(pair.files[i]));
  }
  COLLINEA_TRY(pair.cameras,
               options.camera ? cameras_of_file(options, headers, pair.files) : cameras_by_options(options, headers));
  return pair;
}

Result<PairShrinks> shrinks_of(const PairFiles& pair, const PairChainOptions& options, std::optional<double> area_px) {
  const double pixels = area_px.value_or(pair.pixels());
  const auto reduced_to = [](double all, double most) {
    int shrink = 1;
    while (shrink < kMostShrink && all / (double(shrink) * shrink) > most) shrink *= 2;
    return shrink;
  };
  const double usual = options.surface == PairSurface::kDense ? kMostDensePixels : kMostPixels;
  PairShrinks shrinks;
  shrinks.surface = options.resolution ? static_cast<int>(*options.resolution) : reduced_to(pixels, usual);
  shrinks.search = std::max(shrinks.surface, reduced_to(pair.pixels(), kMostSearchPixels));
  const double reduction = double(shrinks.surface) * shrinks.surface;
  const double need =
      peak_bytes(pixels / reduction, options.surface) + (area_px ? kReadBytes * pair.pixels() / reduction : 0);
  if (const double have = double(usable_memory()); have > 0 && need > have)
    return fail(Errc::kBadInput,
                fmt::format("at this resolution the pair takes some {:.1f} GB of memory; the machine has {:.1f}",
                            need / 1e9, have / 1e9),
                {"resolution"_option});
  return shrinks;
}

Result<PairImages> read_pair(const PairFiles& pair, int shrink, const Run& run) {
  PairImages images{.shrink = shrink};
  images.left_camera = shrunk(pair.cameras[0], shrink);
  images.right_camera = shrunk(pair.cameras[1], shrink);
  std::array<Result<GreyImage>, 2> read;
  parallel_for(run, 2, [&](std::size_t i) { read[i] = read_grey(pair.files[i], shrink); });
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  COLLINEA_TRY(images.left, std::move(read[0]));
  COLLINEA_TRY(images.right, std::move(read[1]));
  return images;
}

std::vector<PairPoint> normalised(const std::vector<MatchedPoint>& points, const Camera& left, const Camera& right,
                                  double sigma_px) {
  std::vector<PairPoint> pairs;
  for (const MatchedPoint& point : points)
    pairs.push_back({normalized(left, point.left_px), normalized(right, point.right_px),
                     sigma_px * point.sigma_px / left.focal_px(), sigma_px * point.sigma_px / right.focal_px()});
  return pairs;
}

Result<PairOrientation> oriented_by(const std::string& by, std::vector<MatchedPoint>& points, const PairImages& images,
                                    const RelativeOptions& options, std::uint64_t seed,
                                    const std::optional<GivenPair>& given) {
  PairOrientation made{.by = by, .points = points.size(), .matched = points};
  const std::vector<PairPoint> pairs = normalised(points, images.left_camera, images.right_camera, 1);
  COLLINEA_TRY(made.orientation, given ? given_orientation(pairs, given->second_from_first, given->covariance, options)
                                       : relative_orientation(pairs, options, seed));
  if (given && 2 * made.orientation.in_front < made.orientation.used)
    return fail(
        Errc::kIllPosed,
        fmt::format("the exterior orientation has {} of {} homologous points in front of both images: it is not "
                    "that of these photographs",
                    made.orientation.in_front, made.orientation.used),
        {"exterior"_option});
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
