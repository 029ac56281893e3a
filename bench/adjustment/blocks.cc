// SPDX-License-Identifier: Apache-2.0
#include "blocks.h"

#include <cmath>
#include <numbers>

#include "collinea/geometry/rotation.h"

namespace collinea::bench {
namespace {

constexpr double kImageSigma_px = 0.5, kControlSigma_m = 0.01, kPositionSigma_m = 0.03;

Camera camera_of(double focal_px, int width_px, int height_px, Random& random) {
  Camera camera = ideal_camera(focal_px * (1 + 0.01 * random.normal()), width_px, height_px);
  camera.params[Camera::kCx] += 8 * random.normal();
  camera.params[Camera::kCy] += 8 * random.normal();
  camera.params[Camera::kK1] = -0.05 + 0.01 * random.normal();
  camera.params[Camera::kK2] = 0.02;
  camera.params[Camera::kK3] = -0.002;
  camera.params[Camera::kP1] = 4e-4 * random.normal();
  camera.params[Camera::kP2] = 4e-4 * random.normal();
  camera.prior.sigma_f_px = 0.03 * focal_px;
  camera.name = "simulated";
  return camera;
}

// A camera at `centre` whose axis is `forward` and whose columns run along `right` as nearly as that allows.
Rigid3 looking(const Eigen::Vector3d& centre, const Eigen::Vector3d& forward, const Eigen::Vector3d& right,
               double tilt_rad, Random& random) {
  Eigen::Matrix3d rows;
  rows.row(2) = forward.normalized();
  rows.row(0) = (right - right.dot(forward.normalized()) * forward.normalized()).normalized();
  rows.row(1) = rows.row(2).cross(rows.row(0));
  const Eigen::Quaterniond rotated = (rotation_by(tilt_rad * normal3(random)) * Eigen::Quaterniond(rows)).normalized();
  return {rotated, -(rotated * centre)};
}

class Builder {
 public:
  explicit Builder(std::uint64_t seed) : random(seed) {}

  void add_image(const Rigid3& pose, bool positions) {
    const ImageId id{static_cast<std::uint32_t>(1 + block.images.size())};
    set_pose(block, id, pose);
    Image image{"IMG_" + std::to_string(id.value) + ".jpg", CameraId{1}, "", {}, {}, 1};
    if (positions) image.position = PositionPrior{centre_of(pose), Eigen::Vector3d::Constant(kPositionSigma_m)};
    block.images[id] = image;
  }
  void add_point(const Eigen::Vector3d& position) {
    const PointId id{static_cast<std::uint32_t>(1 + block.points.size())};
    std::vector<Observation> seen;
    for (const auto& [image, pose] : oriented_images(block))
      if (const auto pixel = seen_in(image, pose, position)) seen.push_back({image, id, 0, *pixel, kImageSigma_px});
    if (seen.size() < 2) return;
    block.points[id].position_in_world = position;
    block.observations.insert(block.observations.end(), seen.begin(), seen.end());
  }
  void add_control(const Eigen::Vector3d& position) {
    const ControlId id{static_cast<std::uint32_t>(1 + block.control.size())};
    block.control[id] = {"gcp" + std::to_string(id.value), ControlRole::kControl, position, position,
                         Eigen::Vector3d::Constant(kControlSigma_m)};
    for (const auto& [image, pose] : oriented_images(block))
      if (const auto pixel = seen_in(image, pose, position))
        block.control_observations.push_back({id, image, *pixel, kImageSigma_px});
  }

  Block block;
  Random random;

 private:
  [[nodiscard]] std::optional<Eigen::Vector2d> seen_in(ImageId image, const Rigid3& pose,
                                                       const Eigen::Vector3d& position) const {
    const auto pixel = project(block.camera_of(image), pose * position);
    return pixel && inside(block.camera_of(image), *pixel) ? pixel : std::nullopt;
  }
};

double relief(double x, double y) { return 6 * (std::sin(x / 17) + std::cos(y / 13)); }

Block cross_strips(const BlockSize& size, std::uint64_t seed) {
  Builder b(seed);
  b.block.cameras[{1}] = camera_of(1500, 2000, 1500, b.random);
  constexpr double kAlong = 20, kAcross = 30, kHeight = 60;
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  for (int strip = 0; strip < 3; ++strip)
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d centre = Eigen::Vector3d(kAlong * i, kAcross * strip, kHeight) + normal3(b.random);
      b.add_image(looking(centre, down, Eigen::Vector3d::UnitX() * (strip % 2 ? -1 : 1), 0.05, b.random), true);
    }
  for (int strip = 0; strip < 2; ++strip)
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d centre = Eigen::Vector3d(20 + 60 * strip, kAlong * i, 1.15 * kHeight) + normal3(b.random);
      b.add_image(looking(centre, down, Eigen::Vector3d::UnitY() * (strip % 2 ? -1 : 1), 0.05, b.random), true);
    }
  const auto ground = [&] {
    const double x = b.random.uniform(-15, 115), y = b.random.uniform(-15, 75);
    return Eigen::Vector3d(x, y, relief(x, y) + b.random.normal());
  };
  for (int i = 0; i < size.points; ++i) b.add_point(ground());
  for (int i = 0; i < size.control; ++i) b.add_control(ground());
  return b.block;
}

Block ring(const BlockSize& size, std::uint64_t seed) {
  Builder b(seed);
  b.block.cameras[{1}] = camera_of(1500, 2000, 1500, b.random);
  for (int level = 0; level < 2; ++level)
    for (int i = 0; i < 14; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.5 * level) / 14;
      const Eigen::Vector3d centre =
          Eigen::Vector3d(18 * std::cos(angle), 18 * std::sin(angle), 2 + 5 * level) + 0.3 * normal3(b.random);
      const Eigen::Vector3d side = i % 2 ? Eigen::Vector3d(-std::sin(angle), std::cos(angle), 0)
                                         : Eigen::Vector3d::UnitZ();  // every other one upright
      b.add_image(looking(centre, Eigen::Vector3d(0, 0, 3) - centre, side, 0.05, b.random), false);
    }
  const auto object = [&] {
    return Eigen::Vector3d(b.random.uniform(-5, 5), b.random.uniform(-5, 5), b.random.uniform(0, 6));
  };
  for (int i = 0; i < size.points; ++i) b.add_point(object());
  for (int i = 0; i < size.control; ++i) b.add_control(object());
  return b.block;
}

Block corridor(const BlockSize& size, std::uint64_t seed) {
  Builder b(seed);
  b.block.cameras[{1}] = camera_of(1500, 2000, 1500, b.random);
  const auto road = [](double s, double side) {  // a bow of 200 m radius
    const double angle = s / 200;
    return Eigen::Vector2d((200 + side) * std::sin(angle), 200 - (200 + side) * std::cos(angle));
  };
  for (int strip = 0; strip < 2; ++strip)
    for (int i = 0; i < 13; ++i) {
      const double s = 20.0 * i, angle = s / 200;
      const Eigen::Vector2d position = road(s, strip ? 15 : -15);
      const Eigen::Vector3d centre = Eigen::Vector3d(position.x(), position.y(), strip ? 66 : 60) + normal3(b.random);
      const Eigen::Vector3d along(std::cos(angle), std::sin(angle), 0);
      b.add_image(looking(centre, -Eigen::Vector3d::UnitZ(), along * (strip ? -1 : 1), 0.05, b.random), true);
    }
  const auto ground = [&](double s) {
    const Eigen::Vector2d position = road(s, b.random.uniform(-35, 35));
    return Eigen::Vector3d(position.x(), position.y(), relief(position.x(), position.y()) + b.random.normal());
  };
  for (int i = 0; i < size.points; ++i) b.add_point(ground(b.random.uniform(-10, 250)));
  for (int i = 0; i < size.control; ++i)
    b.add_control(ground(i % 2 ? b.random.uniform(0, 40) : b.random.uniform(200, 240)));
  return b.block;
}

}  // namespace

Eigen::Vector3d normal3(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

Block exact_block(Layout layout, const BlockSize& size, std::uint64_t seed) {
  if (layout == Layout::kCrossStrips) return cross_strips(size, seed);
  return layout == Layout::kRing ? ring(size, seed) : corridor(size, seed);
}

Block large_exact_block(int rows, int columns, int points) {
  Random random(1);
  Block block;
  block.cameras[{1}] = camera_of(3000, 4000, 3000, random);
  constexpr double kAlong = 25, kAcross = 40, kHeight = 100;
  for (int i = 0; i < rows * columns; ++i) {
    const int row = i / columns, column = i % columns;
    const Eigen::Vector3d centre(kAlong * column + random.normal(), kAcross * row + random.normal(),
                                 kHeight + 3 * random.normal());
    const Eigen::Vector3d right = Eigen::Vector3d::UnitX() * (row % 2 ? -1 : 1);
    const ImageId id{static_cast<std::uint32_t>(1 + i)};
    set_pose(block, id, looking(centre, -Eigen::Vector3d::UnitZ(), right, 0.03, random));
    block.images[id] = {"IMG_" + std::to_string(i) + ".jpg", CameraId{1}, "", {}, {}, 1};
    block.images[id].position =
        PositionPrior{centre_of(pose_of(block, id)), Eigen::Vector3d::Constant(kPositionSigma_m)};
  }
  for (std::uint32_t p = 1; block.points.size() < static_cast<std::size_t>(points); ++p) {
    const double x = random.uniform(-40, kAlong * columns + 15), y = random.uniform(-40, kAcross * rows);
    const Eigen::Vector3d position(x, y, relief(x, y));
    const PointId id{p};
    const std::size_t before = block.observations.size();
    const int at_row = static_cast<int>(y / kAcross), at_column = static_cast<int>(x / kAlong);
    for (int row = std::max(0, at_row - 2); row <= std::min(rows - 1, at_row + 3); ++row)
      for (int column = std::max(0, at_column - 4); column <= std::min(columns - 1, at_column + 5); ++column) {
        const ImageId image{static_cast<std::uint32_t>(1 + row * columns + column)};
        const auto pixel = project(block.cameras.at({1}), pose_of(block, image) * position);
        if (pixel && inside(block.cameras.at({1}), *pixel) && random.uniform() < 0.5)
          block.observations.push_back({image, id, 0, *pixel, kImageSigma_px});
      }
    if (block.observations.size() < before + 2)
      block.observations.resize(before);
    else
      block.points[id].position_in_world = position;
  }
  return block;
}

Measured measured(const Block& exact, std::uint64_t seed) {
  Random random(seed, 77);
  Measured made{exact, {}};
  const auto by_two = [&] {
    const double u = random.normal(), v = random.normal();
    return Eigen::Vector2d(u, v);
  };
  for (Observation& seen : made.block.observations) seen.pixel += seen.sigma_px * by_two();
  for (ControlObservation& seen : made.block.control_observations) seen.pixel += seen.sigma_px * by_two();
  for (auto& [id, control] : made.block.control)
    control.position_in_world += normal3(random).cwiseProduct(control.sigma_m);
  for (auto& [id, image] : made.block.images)
    if (image.position) image.position->position_in_world += normal3(random).cwiseProduct(image.position->sigma_m);
  made.scope.first_cameras = exact.cameras;
  for (auto& [id, camera] : made.scope.first_cameras) {
    const CameraSigmas sigmas = calibration_sigmas(Calibration::kBrownAffinity, camera);
    for (std::size_t k = 0; k < sigmas.size(); ++k) camera.params[k] += sigmas[k] * random.normal();
  }
  for (auto& [id, camera] : made.block.cameras) camera.params[Camera::kF] *= 1 + 0.002 * random.normal();
  for (auto [id, pose] : oriented_images(made.block)) {
    const Eigen::Vector3d centre = centre_of(pose) + 0.1 * normal3(random);
    pose.rotation = (rotation_by(0.002 * normal3(random)) * pose.rotation).normalized();
    pose.translation = -(pose.rotation * centre);
    set_pose(made.block, id, pose);
  }
  for (auto& [id, point] : made.block.points) point.position_in_world += 0.1 * normal3(random);
  return made;
}

ExamineOptions exact_options(Calibration calibration) {
  ExamineOptions options{.adjust = {.calibration = calibration, .loss = Loss::kNone, .position_loss = Loss::kNone}};
  options.adjust.relative_cost_change = options.adjust.parameter_change = 1e-13;
  options.adjust.step_sigmas = 1e-3;
  return options;
}

}  // namespace collinea::bench
