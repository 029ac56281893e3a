// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small blocks with known truth, for the tests of this module only.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "collinea/adjust/bundle.h"
#include "collinea/adjust/geodetic_model.h"
#include "collinea/block/block.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea::testing {

struct TestBlockOptions {
  int rows = 3, columns = 4;  ///< images, in strips
  int points = 200;
  double height_m = 60, spacing_m = 15, relief_m = 8;
  double sigma_px = 0;          ///< noise added to every measurement; 1 is written as sigma when 0
  double position_sigma_m = 0;  ///< 0: no GNSS positions
  int control = 0;              ///< control points, every third one a check point
  double control_sigma_m = 0.01;
  double tilt_rad = 0.15, rotation_rad = 3.1;  ///< of every image; of every second strip
  std::uint64_t seed = 1;
};

inline Eigen::Vector3d normal3(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

/// Least squares without any loss, to the last step.
inline AdjustOptions plain(Calibration calibration = Calibration::kNone) {
  AdjustOptions options;
  options.calibration = calibration;
  options.loss = options.position_loss = Loss::kNone;
  options.relative_cost_change = 1e-12;
  options.parameter_change = 1e-13;
  options.step_sigmas = 0;
  return options;
}

inline double largest_centre_error(const Adjusted& adjusted, const Block& truth) {
  double largest = 0;
  for (const auto& [id, pose] : adjusted.cam_from_world)
    largest = std::max(largest, (centre_of(pose) - centre_of(pose_of(truth, id))).norm());
  return largest;
}

/// The camera of the test blocks: 24 x 18 megapixel-ish field, mild barrel distortion.
inline Camera test_camera() {
  Camera camera = ideal_camera(1500, 2000, 1500);
  camera.params[Camera::kCx] += 6;
  camera.params[Camera::kCy] -= 4;
  camera.params[Camera::kK1] = -0.05;
  camera.params[Camera::kK2] = 0.02;
  camera.params[Camera::kK3] = -0.002;
  camera.params[Camera::kP1] = 4e-4;
  camera.params[Camera::kP2] = -3e-4;
  camera.prior.sigma_f_px = 50;
  camera.name = "test";
  return camera;
}

/// Looking down, turned about all axes a little, every second strip flown back.
inline Rigid3 test_pose(const TestBlockOptions& o, int row, int column, Random& random) {
  const Eigen::Vector3d centre(column * o.spacing_m + random.normal(), row * o.spacing_m * 1.3 + random.normal(),
                               o.height_m + 3 * random.normal());
  const Eigen::Quaterniond down(0, 1, 0, 0);
  const Eigen::Quaterniond rotation =
      rotation_by(o.tilt_rad * normal3(random) + Eigen::Vector3d(0, 0, row % 2 * o.rotation_rad));
  const Eigen::Quaterniond cam_from_world = (rotation * down).normalized();
  return {cam_from_world, -(cam_from_world * centre)};
}

inline Eigen::Vector3d ground(const TestBlockOptions& o, Random& random) {
  const double width = (o.columns - 1) * o.spacing_m, depth = (o.rows - 1) * o.spacing_m * 1.3;
  const double x = random.uniform(-15, width + 15), y = random.uniform(-15, depth + 15);
  return {x, y, o.relief_m * (std::sin(x / 9) + std::cos(y / 7)) + random.normal()};
}

/// Exact poses, points and camera with measurements that have the noise asked for.
inline Block test_block(const TestBlockOptions& o = {}) {
  Random random(o.seed);
  Block block;
  const CameraId camera{1};
  block.cameras[camera] = test_camera();
  for (int i = 0; i < o.rows * o.columns; ++i) {
    const ImageId id{static_cast<std::uint32_t>(10 + i)};
    const Rigid3 pose = test_pose(o, i / o.columns, i % o.columns, random);
    set_pose(block, id, pose);
    Image image{"IMG_" + std::to_string(i) + ".jpg", camera, "", {}, {}, 1};
    if (o.position_sigma_m > 0)
      image.position = PositionPrior{centre_of(pose) + o.position_sigma_m * normal3(random),
                                     Eigen::Vector3d::Constant(o.position_sigma_m)};
    block.images[id] = image;
  }
  const double sigma = o.sigma_px > 0 ? o.sigma_px : 1;
  const auto measure = [&](const Eigen::Vector3d& point, auto&& add) {
    for (const auto& [id, pose] : oriented_images(block)) {
      const auto pixel = project(block.camera_of(id), pose * point);
      if (!pixel || !inside(block.camera_of(id), *pixel)) continue;
      const double du = random.normal(), dv = random.normal();
      add(id, Eigen::Vector2d(*pixel + o.sigma_px * Eigen::Vector2d(du, dv)));
    }
  };
  for (int i = 0; i < o.points; ++i) {
    const PointId id{static_cast<std::uint32_t>(100 + 2 * i)};
    block.points[id].position_in_world = ground(o, random);
    measure(block.points[id].position_in_world, [&](ImageId image, const Eigen::Vector2d& pixel) {
      block.observations.push_back({image, id, 0, pixel, sigma});
    });
  }
  for (int i = 0; i < o.control; ++i) {
    const ControlId id{static_cast<std::uint32_t>(i)};
    const Eigen::Vector3d truth = ground(o, random);
    ControlPoint point;
    point.name = "gcp" + std::to_string(i);
    point.role = i % 3 == 2 ? ControlRole::kCheck : ControlRole::kControl;
    point.position_in_world = truth + (o.sigma_px > 0 ? o.control_sigma_m : 0) * normal3(random);
    point.position_in_map = point.position_in_world + Eigen::Vector3d(500000, 5000000, 0);
    point.sigma_m = Eigen::Vector3d::Constant(o.control_sigma_m);
    block.control[id] = point;
    measure(truth, [&](ImageId image, const Eigen::Vector2d& pixel) {
      block.control_observations.push_back({id, image, pixel, sigma});
    });
  }
  return block;
}

/// The block with its unknowns moved off the truth.
inline Block disturbed(Block block, double rotation_rad, double move_m, std::uint64_t seed = 9) {
  Random random(seed);
  for (auto [id, pose] : oriented_images(block)) {
    const Eigen::Vector3d centre = centre_of(pose) + move_m * normal3(random);
    const Eigen::Quaterniond rotation = (rotation_by(rotation_rad * normal3(random)) * pose.rotation).normalized();
    pose = {rotation, -(rotation * centre)};
    set_pose(block, id, pose);
  }
  for (auto& [id, point] : block.points) point.position_in_world += move_m * normal3(random);
  return block;
}

/// A block whose control points have no coordinates, and where they truly are.
struct Marked {
  Block block;
  std::map<ControlId, Eigen::Vector3d> truth;

  void measure(GeodeticKind kind, std::uint32_t from, std::uint32_t to, double sigma, Random* random = nullptr) {
    GeodeticObservation one{.kind = kind, .from = {from}, .to = {to}, .sigma = sigma};
    one.value = geodetic_model(one, truth.at(one.from), truth.at(one.to), 0, {}).computed;
    if (random) one.value += sigma * random->normal();
    block.geodetic.push_back(one);
  }
};

/// `move`: brings the true points to where they shall be; no images are measured where they were.
inline Marked marked(TestBlockOptions options, int points = 9,
                     const std::function<void(std::vector<Eigen::Vector3d>&)>& move = {}) {
  const double sigma_px = options.sigma_px;
  options.sigma_px = 0;  // exact coordinates; the noise comes after
  options.control = points;
  Marked made{test_block(options), {}};
  Random random(options.seed, 5);
  std::vector<Eigen::Vector3d> positions;
  for (const auto& [id, point] : made.block.control) positions.push_back(point.position_in_world);
  if (move) {
    move(positions);
    made.block.control_observations.clear();
  }
  for (auto& [id, point] : made.block.control) {
    made.truth[id] = point.position_in_world = positions[id.value];
    point.role = ControlRole::kControl;
    point.sigma_m.setConstant(std::numeric_limits<double>::infinity());
    if (!move) continue;
    for (const auto& [image, pose] : oriented_images(made.block))
      if (const auto pixel = project(made.block.camera_of(image), pose * point.position_in_world);
          pixel && inside(made.block.camera_of(image), *pixel))
        made.block.control_observations.push_back({id, image, *pixel, 1});
  }
  const auto spoil = [&](auto& seen) {
    const double du = random.normal(), dv = random.normal();
    seen.pixel += sigma_px * Eigen::Vector2d(du, dv);
    if (sigma_px > 0) seen.sigma_px = sigma_px;
  };
  for (Observation& seen : made.block.observations) spoil(seen);
  for (ControlObservation& seen : made.block.control_observations) spoil(seen);
  return made;
}

/// New measurements of the same exact world: pixels 0.5 px, positions 2 cm, f 50 px.
inline Block measured_anew(Block block, AdjustScope& scope, std::uint64_t seed) {
  Random random(seed, 77);
  for (Observation& observation : block.observations) {
    const double du = random.normal(), dv = random.normal();
    observation.pixel += 0.5 * Eigen::Vector2d(du, dv);
    observation.sigma_px = 0.5;
  }
  for (auto& [id, image] : block.images)
    image.position =
        PositionPrior{centre_of(pose_of(block, id)) + 0.02 * normal3(random), Eigen::Vector3d::Constant(0.02)};
  scope.first_cameras = block.cameras;
  scope.first_cameras.begin()->second.params[Camera::kF] += 50 * random.normal();
  return block;
}

}  // namespace collinea::testing
