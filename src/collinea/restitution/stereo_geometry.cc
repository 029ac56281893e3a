// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/stereo_geometry.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const Vector2d kNothing = Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());

Vector3d ray_of(const Camera& epipolar, double x, double y) {
  return {(x - epipolar.params[Camera::kCx]) / epipolar.focal_px(),
          (y - epipolar.params[Camera::kCy]) / epipolar.focal_px(), 1};
}

// Exact.
Vector2d pixel_at(const Camera& camera, const Eigen::Quaterniond& epipolar_from_image, const Camera& epipolar, double x,
                  double y) {
  return project(camera, epipolar_from_image.conjugate() * ray_of(epipolar, x, y)).value_or(kNothing);
}

Result<> check(const Block& block, ImageId image) {
  if (!block.images.contains(image)) return fail(Errc::kNotFound, "there is no such image");
  if (!is_oriented(block, image))
    return fail(Errc::kIllPosed, "image " + block.images.at(image).file + " is not oriented");
  return {};
}

Eigen::Matrix<double, 10, 1> terms_of(const Vector3d& u) {
  Eigen::Matrix<double, 10, 1> terms;
  terms << 1, u.x(), u.y(), u.z(), u.x() * u.x(), u.x() * u.y(), u.x() * u.z(), u.y() * u.y(), u.y() * u.z(),
      u.z() * u.z();
  return terms;
}

}  // namespace

Result<StereoGeometry> StereoGeometry::of(const Block& block, ImageId one, ImageId other) {
  for (const ImageId image : {one, other}) COLLINEA_TRY(check(block, image));
  if (one == other) return fail(Errc::kBadInput, "a pair has two photographs");
  const auto pair_of = [&](ImageId left, ImageId right) {
    return epipolar_pair(block.camera_of(left), pose_of(block, left), block.camera_of(right), pose_of(block, right));
  };
  // Of the image rows of both, which way they run along the base.
  const Vector3d base = centre_of(pose_of(block, other)) - centre_of(pose_of(block, one));
  double along = 0;
  for (const ImageId image : {one, other})
    along += (pose_of(block, image).rotation.conjugate() * Vector3d::UnitX()).dot(base);
  const auto [left, right] = along >= 0 ? std::pair(one, other) : std::pair(other, one);
  COLLINEA_TRY(EpipolarPair pair, pair_of(left, right));
  return StereoGeometry{left, right, std::move(pair)};
}

std::optional<Vector3d> StereoGeometry::position_in_world(const StereoMark& mark) const {
  const double depth = pair.depth_at(mark.parallax);
  if (!(depth > 0) || !std::isfinite(depth)) return std::nullopt;
  return inverse(pair.left_from_world) * (depth * ray_of(pair.left, mark.x, mark.y));
}

std::optional<StereoMark> StereoGeometry::mark_at(const Vector3d& position_in_world) const {
  const Vector3d in_left = pair.left_from_world * position_in_world;
  if (!(in_left.z() > 0)) return std::nullopt;
  const double f = pair.left.focal_px();
  return StereoMark{f * in_left.x() / in_left.z() + pair.left.params[Camera::kCx],
                    f * in_left.y() / in_left.z() + pair.left.params[Camera::kCy], pair.disparity_at(in_left.z())};
}

std::optional<std::array<Vector2d, 2>> StereoGeometry::pixels_of(const Block& block, const StereoMark& mark) const {
  const Camera &left_camera = block.camera_of(left), &right_camera = block.camera_of(right);
  const Vector2d in_left = pixel_at(left_camera, pair.left_from_image, pair.left, mark.x, mark.y);
  const Vector2d in_right = pixel_at(right_camera, pair.right_from_image, pair.right, mark.x - mark.parallax, mark.y);
  const bool both =
      in_left.allFinite() && in_right.allFinite() && inside(left_camera, in_left) && inside(right_camera, in_right);
  return both ? std::optional(std::array{in_left, in_right}) : std::nullopt;
}

Vector2d PixelLattice::at(double x, double y) const {
  const double u = x / step_px, v = y / step_px;
  if (!(u >= 0 && v >= 0 && u <= columns - 1 && v <= rows - 1)) return kNothing;
  const int i = std::min(int(u), columns - 2), j = std::min(int(v), rows - 2);
  const auto node = [&](int column, int row) {
    return nodes[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
  };
  const double a = u - i, b = v - j;
  return (1 - b) * ((1 - a) * node(i, j) + a * node(i + 1, j)) +
         b * ((1 - a) * node(i, j + 1) + a * node(i + 1, j + 1));
}

Result<PixelLattice> pixel_lattice(const Camera& camera_of_image, const Eigen::Quaterniond& epipolar_from_image,
                                   const Camera& epipolar) {
  const auto exact = [&](double x, double y) { return pixel_at(camera_of_image, epipolar_from_image, epipolar, x, y); };
  PixelLattice lattice;
  for (lattice.step_px = 64; lattice.step_px >= 8; lattice.step_px /= 2) {
    const int step = lattice.step_px;
    lattice.columns = (epipolar.width_px + step - 1) / step + 1;
    lattice.rows = (epipolar.height_px + step - 1) / step + 1;
    lattice.nodes.clear();
    for (int j = 0; j < lattice.rows; ++j)
      for (int i = 0; i < lattice.columns; ++i) lattice.nodes.push_back(exact(double(i) * step, double(j) * step));
    lattice.error_px = 0;
    // Of a bilinear function the second differences are largest between nodes.
    for (int j = 0; j < 2 * lattice.rows - 1; ++j)
      for (int i = (j + 1) % 2; i < 2 * lattice.columns - 1; i += 1 + (j + 1) % 2) {
        const double x = i * step / 2.0, y = j * step / 2.0;
        const Vector2d truth = exact(x, y);
        if (!truth.allFinite() || !inside(camera_of_image, truth)) continue;
        const double error = (lattice.at(x, y) - truth).norm();
        if (std::isfinite(error)) lattice.error_px = std::max(lattice.error_px, error);
      }
    if (lattice.error_px <= kLatticeError_px) return lattice;
  }
  return fail(Errc::kUnsupported, "the lens bends the photograph too much to be shown in epipolar geometry");
}

Vector3d MapPolynomial::at(const Vector3d& position_in_world) const {
  return coefficients * terms_of((position_in_world - origin) / scale_m);
}

MapPolynomial map_polynomial(const LocalFrame* frame, const Vector3d& origin, double reach_m) {
  constexpr int kSteps = 2;  // to either side
  MapPolynomial map{.origin = origin, .scale_m = reach_m};
  std::vector<Vector3d> at, on_map;
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j)
      for (int k = -kSteps; k <= kSteps; ++k) {
        at.emplace_back(Vector3d(i, j, k) / kSteps);
        on_map.emplace_back(origin + reach_m * at.back());
      }
  if (frame) frame->map_from_local(on_map);
  // About a middle: six digits before the point would take from those behind it.
  const Vector3d middle = on_map[on_map.size() / 2];
  Eigen::MatrixXd design(Eigen::Index(at.size()), 10), values(Eigen::Index(at.size()), 3);
  for (std::size_t i = 0; i < at.size(); ++i) {
    design.row(Eigen::Index(i)) = terms_of(at[i]).transpose();
    values.row(Eigen::Index(i)) = (on_map[i] - middle).transpose();
  }
  map.coefficients = design.householderQr().solve(values).transpose();
  map.coefficients.col(0) += middle;
  return map;
}

}  // namespace collinea
