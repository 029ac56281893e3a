// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/epipolar_pair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/pinhole.h"
#include "collinea/raster/cubic.h"
#include "collinea/raster/cubic_row.h"

namespace collinea {
namespace {

constexpr double kSteepest = 0.26;  // sine of the least angle between a ray and the base: 15 degrees
constexpr std::size_t kFewestPoints = 8;
constexpr double kGrossest = 0.005, kMargin = 0.3, kLeastFarther = 0.1, kLeastNearer = 0.8;
constexpr double kLargestGrowth = 4;  // of the number of pixels

// The rectangle that an image fills on the plane z = 1 of a turned camera; nothing when parts of it are beside or
// behind that camera.
struct Extent {
  double x0 = std::numeric_limits<double>::max(), x1 = -x0, y0 = x0, y1 = -x0;
};

std::optional<Extent> extent_of(const Camera& camera, const Eigen::Quaterniond& rotated_from_camera) {
  constexpr int kSteps = 32;  // along each side
  Extent extent;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      if (i % kSteps && j % kSteps) continue;  // the border alone
      const Eigen::Vector2d pixel(double(camera.width_px) * i / kSteps, double(camera.height_px) * j / kSteps);
      const Eigen::Vector3d ray = rotated_from_camera * ray_in_cam(camera, pixel);
      if (!(std::hypot(ray.y(), ray.z()) > kSteepest && ray.z() > kSteepest)) return std::nullopt;
      const double x = ray.x() / ray.z(), y = ray.y() / ray.z();
      extent.x0 = std::min(extent.x0, x), extent.x1 = std::max(extent.x1, x);
      extent.y0 = std::min(extent.y0, y), extent.y1 = std::max(extent.y1, y);
    }
  return extent;
}

// The focal length with which the middle of an image keeps its area: a plane turned by an angle spreads it by
// 1 / cos^3.
double focal_for(const Camera& camera, const Eigen::Quaterniond& rotated_from_camera) {
  const Eigen::Vector2d middle(camera.width_px / 2.0, camera.height_px / 2.0);
  return camera.focal_px() * std::pow((rotated_from_camera * ray_in_cam(camera, middle)).z(), 1.5);
}

Camera camera_over(const Extent& extent, double y0, double y1, double focal_px) {
  Camera camera =
      ideal_camera(focal_px, int(std::ceil((extent.x1 - extent.x0) * focal_px)), int(std::ceil((y1 - y0) * focal_px)));
  camera.params[Camera::kCx] = -extent.x0 * focal_px;
  camera.params[Camera::kCy] = -y0 * focal_px;
  return camera;
}

// Normals of a raster of points from the differences of their neighbours.
class Normals {
 public:
  Normals(const EpipolarPair& pair, const FloatImage& disparity) : pair_(pair), disparity_(disparity) {}

  // In the frame of the left camera, towards it; zero where a neighbour is missing or beyond an edge.
  [[nodiscard]] Eigen::Vector3d at(int x, int y) const {
    const auto across = step(x, y, 1, 0), down = step(x, y, 0, 1);
    if (!across || !down) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d normal = down->cross(*across);
    return normal.norm() > 0 ? Eigen::Vector3d(normal.normalized()) : Eigen::Vector3d::Zero();
  }

  [[nodiscard]] Eigen::Vector3d point(int x, int y) const {
    const dense::Pinhole pinhole(pair_.left);
    return pinhole.ray(x + 0.5, y + 0.5) * pair_.depth_at(disparity_.at(x, y));
  }

 private:
  static constexpr int kReach = 2;           // pixels: noise of single disparities would tilt normals too much
  static constexpr float kSteepestStep = 3;  // disparities between the two ends that still are one surface

  [[nodiscard]] std::optional<Eigen::Vector3d> step(int x, int y, int dx, int dy) const {
    const int ax = x - kReach * dx, ay = y - kReach * dy, bx = x + kReach * dx, by = y + kReach * dy;
    if (ax < 0 || ay < 0 || bx >= disparity_.width || by >= disparity_.height) return std::nullopt;
    if (!(std::abs(disparity_.at(ax, ay) - disparity_.at(bx, by)) <= kSteepestStep)) return std::nullopt;
    return point(bx, by) - point(ax, ay);
  }

  const EpipolarPair& pair_;
  const FloatImage& disparity_;
};

template <int kChannels>
void linear_row(const Raster<std::uint8_t>& image, const float* x, const float* y, int count, std::uint8_t* out) {
  for (int i = 0; i < count; ++i)
    for (int c = 0; c < kChannels; ++c) *out++ = linear<kChannels>(image, x[i], y[i], c);
}

}  // namespace

double EpipolarPair::disparity_at(double depth_m) const {
  return left.params[Camera::kCx] - right.params[Camera::kCx] + left.focal_px() * base_m / depth_m;
}

double EpipolarPair::depth_at(double disparity_px) const {
  return left.focal_px() * base_m / (disparity_px - left.params[Camera::kCx] + right.params[Camera::kCx]);
}

Result<EpipolarPair> epipolar_pair(const Camera& left, const Rigid3& left_from_world, const Camera& right,
                                   const Rigid3& right_from_world) {
  const Eigen::Vector3d base = centre_of(right_from_world) - centre_of(left_from_world);
  const Eigen::Vector3d forward = left_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ() +
                                  right_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  if (!(base.norm() > 0)) return fail(Errc::kIllPosed, "the photographs were taken from the same position");
  const Eigen::Vector3d x = base.normalized();
  const Eigen::Vector3d across = forward - x * x.dot(forward);
  if (!(across.norm() > kSteepest * forward.norm()) || !(forward.norm() > kSteepest))
    return fail(Errc::kIllPosed, "the photographs look along the line between them, or away from each other");
  Eigen::Matrix3d pair_from_world;
  pair_from_world.row(0) = x;
  pair_from_world.row(2) = across.normalized();
  pair_from_world.row(1) = across.normalized().cross(x);
  EpipolarPair pair;
  pair.base_m = base.norm();
  pair.left_from_world.rotation = Eigen::Quaterniond(pair_from_world).normalized();
  pair.left_from_world.translation = -(pair.left_from_world.rotation * centre_of(left_from_world));
  pair.left_from_image = pair.left_from_world.rotation * left_from_world.rotation.conjugate();
  pair.right_from_image = pair.left_from_world.rotation * right_from_world.rotation.conjugate();
  const auto own = extent_of(left, pair.left_from_image), other = extent_of(right, pair.right_from_image);
  if (!own || !other)
    return fail(Errc::kIllPosed, "a photograph looks along the line between the two, in a part of it at least");
  const double y0 = std::max(own->y0, other->y0), y1 = std::min(own->y1, other->y1);
  if (!(y1 > y0)) return fail(Errc::kIllPosed, "the photographs have nothing in common");
  const double focal = (focal_for(left, pair.left_from_image) + focal_for(right, pair.right_from_image)) / 2;
  pair.left = camera_over(*own, y0, y1, focal);
  pair.right = camera_over(*other, y0, y1, focal);
  const auto pixels = [](const Camera& camera) { return double(camera.width_px) * camera.height_px; };
  if (pixels(pair.left) > kLargestGrowth * pixels(left) || pixels(pair.right) > kLargestGrowth * pixels(right))
    return fail(Errc::kIllPosed, "the photographs are turned too far from each other to be brought side by side");
  return pair;
}

EpipolarPair epipolar_pair(double focal_px, double base_m, int left_width_px, int right_width_px, int height_px) {
  EpipolarPair pair;
  pair.left = ideal_camera(focal_px, left_width_px, height_px);
  pair.right = ideal_camera(focal_px, right_width_px, height_px);
  pair.right.params[Camera::kCx] = pair.left.params[Camera::kCx];
  pair.base_m = base_m;
  return pair;
}

ResamplingLattice::ResamplingLattice(const Camera& camera_of_image, const Eigen::Quaterniond& camera_from_image,
                                     const Camera& camera, const Run& run, const RayBend& bend)
    : columns_(std::size_t((camera.width_px - 1) / kStep_px + 2)) {
  const std::size_t rows = std::size_t((camera.height_px - 1) / kStep_px + 2);
  const Eigen::Quaterniond image_from_camera = camera_from_image.conjugate();
  const dense::Pinhole pinhole(camera);
  nodes_.resize(columns_ * rows);
  parallel_for(run, rows, [&](std::size_t j) {
    for (std::size_t i = 0; i < columns_; ++i) {
      const Eigen::Vector3d ray =
          image_from_camera * pinhole.ray(double(i) * kStep_px + 0.5, double(j) * kStep_px + 0.5);
      const auto pixel = project(camera_of_image, bend.bent(ray));
      nodes_[j * columns_ + i] =
          pixel ? Eigen::Vector2f((*pixel - Eigen::Vector2d(0.5, 0.5)).cast<float>()) : Eigen::Vector2f(NAN, NAN);
    }
  });
}

Raster<std::uint8_t> resampled(const Raster<std::uint8_t>& image, const Camera& camera_of_image,
                               const Eigen::Quaterniond& camera_from_image, const Camera& camera, const Run& run,
                               const RayBend& bend, Interpolation interpolation) {
  const ResamplingLattice lattice(camera_of_image, camera_from_image, camera, run, bend);
  Raster<std::uint8_t> result(camera.width_px, camera.height_px, image.channels);
  const auto row_of = interpolation == Interpolation::kBicubic ? cubic_row
                      : image.channels == 1                    ? linear_row<1>
                                                               : linear_row<3>;
  parallel_for(run, std::size_t(result.height), [&](std::size_t row) {
    thread_local std::vector<float> x, y;
    x.resize(std::size_t(result.width));
    y.resize(std::size_t(result.width));
    for (int column = 0; column < result.width; ++column) {
      const Eigen::Vector2f at = lattice.sample_of(column, int(row));
      x[std::size_t(column)] = at.x();
      y[std::size_t(column)] = at.y();
    }
    row_of(image, x.data(), y.data(), result.width, result.row(int(row)));
  });
  return result;
}

std::optional<DisparityRange> range_of(const EpipolarPair& pair, std::span<const Eigen::Vector3d> points_in_world) {
  const dense::Pinhole left(pair.left), right(pair.right);
  std::vector<double> inverse_depths;
  for (const Eigen::Vector3d& point : points_in_world) {
    const Eigen::Vector3d in_left = pair.left_from_world * point;
    if (!(in_left.z() > 0)) continue;
    const Eigen::Vector3d in_right = in_left - Eigen::Vector3d(pair.base_m, 0, 0);
    if (inside(pair.left, left.project(in_left)) && inside(pair.right, right.project(in_right)))
      inverse_depths.push_back(1 / in_left.z());
  }
  if (inverse_depths.size() < kFewestPoints) return std::nullopt;
  std::sort(inverse_depths.begin(), inverse_depths.end());
  const auto cut = std::size_t(kGrossest * double(inverse_depths.size() - 1) + 0.5);
  const double low = inverse_depths[cut], high = inverse_depths[inverse_depths.size() - 1 - cut];
  const double reach = kMargin * (high - low);
  const double farthest = std::max(low - std::max(reach, kLeastFarther * high), 0.0);
  const double nearest = high + std::max(reach, kLeastNearer * high);
  const double infinity = pair.left.params[Camera::kCx] - pair.right.params[Camera::kCx];
  const double px = pair.left.focal_px() * pair.base_m;
  return DisparityRange{int(std::floor(infinity + px * farthest)), int(std::ceil(infinity + px * nearest))};
}

std::vector<FusedPoint> cloud_of(const EpipolarPair& pair, const DisparityMap& map, const ColourImage& colours) {
  const Normals normals(pair, map.disparity);
  const Rigid3 world_from_left = inverse(pair.left_from_world);
  std::vector<FusedPoint> cloud;
  for (int y = 0; y < map.disparity.height; ++y)
    for (int x = 0; x < map.disparity.width; ++x) {
      const float disparity = map.disparity.at(x, y);
      if (std::isnan(disparity) || std::isnan(map.sigma.at(x, y))) continue;
      const double depth = pair.depth_at(disparity);
      if (!(depth > 0 && std::isfinite(depth))) continue;
      const Eigen::Vector3d point = normals.point(x, y);
      FusedPoint fused;
      fused.position_in_world = world_from_left * point;
      fused.normal_in_world = (world_from_left.rotation * normals.at(x, y)).cast<float>();
      if (!colours.empty()) fused.colour = {colours.at(x, y, 0), colours.at(x, y, 1), colours.at(x, y, 2)};
      // z = f b / d:  sigma_z = z^2 / (f b) sigma_d, and along the ray as much more as the ray is longer
      fused.sigma = float(depth * point.norm() / (pair.left.focal_px() * pair.base_m)) * map.sigma.at(x, y);
      fused.images = 2;
      cloud.push_back(fused);
    }
  return cloud;
}

}  // namespace collinea
