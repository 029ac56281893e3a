// SPDX-License-Identifier: Apache-2.0
#pragma once

// A strip of images with known truth, for tests of models that are formed from images.

#include <map>
#include <string>

#include "collinea/block/block.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea::testing {

inline constexpr double kSigmaPx = 0.4;

// A strip of nadir photographs with 60 % forward overlap, over four full control points.
struct Strip {
  Block block;
  std::map<std::string, Eigen::Vector3d> truth;
};

inline Strip strip(std::uint64_t seed, int images = 4, double noise_px = kSigmaPx) {
  Random world(11), noise(seed, 3);
  Strip made;
  const double height_m = 1000, base_m = 600;
  made.block.cameras[CameraId{1}] = ideal_camera(1000, 1500, 1500);
  std::map<ImageId, Rigid3> poses;
  for (int i = 0; i < images; ++i) {
    const ImageId id{static_cast<std::uint32_t>(i + 1)};
    made.block.images[id] = Image{"i" + std::to_string(i), CameraId{1}, "", {}, {}, 1};
    const Eigen::Vector3d turn(0.02 * world.normal(), 0.02 * world.normal(), 0.02 * world.normal());
    const Eigen::Quaterniond rotation = rotation_by(turn) * Eigen::Quaterniond(0, 1, 0, 0);
    const Eigen::Vector3d centre(base_m * i, 5 * world.normal(), height_m + 5 * world.normal());
    poses[id] = {rotation, -(rotation * centre)};
    made.truth["i" + std::to_string(i)] = centre;
  }
  const auto measure = [&](const Eigen::Vector3d& point, auto&& add) {
    for (const auto& [id, pose] : poses) {
      const auto pixel = project(made.block.camera_of(id), pose * point);
      const double du = noise.normal(), dv = noise.normal();
      if (pixel && inside(made.block.camera_of(id), *pixel)) add(id, *pixel + noise_px * Eigen::Vector2d(du, dv));
    }
  };
  for (std::uint32_t n = 0; n < 12 * static_cast<std::uint32_t>(images); ++n) {
    const double x = base_m * int(n / 12) + 60 * world.normal(), y = -650 + 1300 * (n % 12) / 11.0;
    const Eigen::Vector3d point(x, y, 60 * world.normal());
    made.truth[std::to_string(n)] = point;
    measure(point, [&](ImageId id, const Eigen::Vector2d& pixel) {
      made.block.observations.push_back({id, PointId{n}, 0, pixel, kSigmaPx});
    });
  }
  for (std::uint32_t n = 0; n < 4; ++n) {
    ControlPoint control;
    control.name = "C" + std::to_string(n);
    control.position_in_world = Eigen::Vector3d(n % 2 ? base_m * (images - 1) : 0, n < 2 ? -600 : 600, 10.0 * n);
    control.sigma_m.setZero();
    made.truth[control.name] = control.position_in_world;
    made.block.control[ControlId{n}] = control;
    measure(control.position_in_world, [&](ImageId id, const Eigen::Vector2d& pixel) {
      made.block.control_observations.push_back({ControlId{n}, id, pixel, kSigmaPx});
    });
  }
  return made;
}

}  // namespace collinea::testing
