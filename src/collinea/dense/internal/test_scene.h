// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <memory>

#include "collinea/dense/depth_map.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea::test {

/// A small world for the tests of this module: a sloping ground with a flat-roofed block on it and a blank disc, seen
/// by cameras that look down from 10 m. Geometry and texture are exact functions, so every depth is known exactly.
struct Scene {
  double slope = 0.1;       // ground: z = slope x
  double roof = 0;          // height of the block on |x| < 1, |y| < 0.8 [m]; 0: none
  double blank_radius = 0;  // of the disc around (-1, 0) without texture [m]
  double noise = 0;         // standard deviation of grey values
  Block block;

  static double wave(double x, double y) {
    double sum = 0;
    for (const double k : {1.7, 3.1, 5.3, 9.7, 17.3, 29.1})
      sum += std::sin(k * x + 1.3 * std::sin(0.7 * k * y + k)) + std::sin(0.9 * k * y + 1.1 * std::sin(0.8 * k * x));
    return sum;
  }

  double grey(double x, double y, bool on_roof) const {
    if (!on_roof && std::hypot(x + 1, y) < blank_radius) return 190;
    return (on_roof ? 150 : 110) + 10 * wave(on_roof ? x + 7 : x, on_roof ? y - 3 : y);
  }

  struct Hit {
    double t;  // camera + t direction
    bool on_roof;
  };
  Hit cast(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
    Hit hit{(slope * from.x() - from.z()) / (direction.z() - slope * direction.x()), false};
    if (roof > 0) {
      const double t = (roof - from.z()) / direction.z();
      const Eigen::Vector3d p = from + t * direction;
      if (std::abs(p.x()) < 1 && std::abs(p.y()) < 0.8) hit = {t, true};
    }
    return hit;
  }

  void add_camera(double x, double y, double kappa_rad, const Camera& camera) {
    const ImageId id{std::uint32_t(block.images.size())};
    Eigen::Matrix3d down;
    down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    const Eigen::Quaterniond rotation =
        rotation_by({0, 0, kappa_rad}) * rotation_by({0.02, -0.03, 0}) * Eigen::Quaterniond(down);
    block.cameras[CameraId{0}] = camera;
    block.images[id] = Image{"image" + std::to_string(id.value), CameraId{0}, {}, {}, {}, 1};
    set_pose(block, id, {rotation, -(rotation * Eigen::Vector3d(x, y, 10))});
  }

  /// True tie points, evenly spread.
  void add_ties(double spacing_m = 0.6) {
    std::uint32_t n = 0;
    for (double x = -6; x <= 6; x += spacing_m)
      for (double y = -6; y <= 6; y += spacing_m, ++n) {
        const bool on_roof = roof > 0 && std::abs(x) < 1 && std::abs(y) < 0.8;
        const Eigen::Vector3d point(x, y, on_roof ? roof : slope * x);
        std::vector<Observation> rays;
        for (const auto& [id, pose] : oriented_images(block))
          if (const auto pixel = project(block.camera_of(id), pose * point);
              pixel && inside(block.camera_of(id), *pixel))
            rays.push_back({id, PointId{n}, 0, *pixel, 0.5});
        if (rays.size() < 2) continue;
        block.points[PointId{n}] = {point, {}};
        block.observations.insert(block.observations.end(), rays.begin(), rays.end());
      }
  }

  /// The camera of the scene's images: 10 m above ground a pixel is 5 cm.
  static Camera camera() { return ideal_camera(200, 200, 160); }

  /// Three images in a row, 2 m apart, and one beside.
  static Scene of_four(Scene scene, const Camera& camera = Scene::camera()) {
    scene.add_camera(0, 0, 0, camera);
    scene.add_camera(2, 0, 0, camera);
    scene.add_camera(-2, 0.2, 0, camera);
    scene.add_camera(0.2, 1.8, 0, camera);
    scene.add_ties();
    return scene;
  }

  PixelSource pixels() const {
    return [this](ImageId id, int) -> Result<GreyImage> {
      const Camera& camera = block.camera_of(id);
      const Rigid3 world_from_cam = inverse(pose_of(block, id));
      GreyImage image(camera.width_px, camera.height_px);
      Random random(7, id.value);
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
          const Eigen::Vector2d n = normalized(camera, {x + 0.5, y + 0.5});
          const Eigen::Vector3d direction = world_from_cam.rotation * Eigen::Vector3d(n.x(), n.y(), 1);
          const Hit hit = cast(world_from_cam.translation, direction);
          const Eigen::Vector3d p = world_from_cam.translation + hit.t * direction;
          image.at(x, y) =
              std::uint8_t(std::clamp(grey(p.x(), p.y(), hit.on_roof) + noise * random.normal(), 0.0, 255.0));
        }
      return image;
    };
  }

  /// The truth at a pixel of a depth map.
  struct Truth {
    double depth;
    Eigen::Vector3d point_in_world;
    bool on_roof;
  };
  Truth truth(ImageId id, const Camera& camera, int x, int y) const {
    const Rigid3 world_from_cam = inverse(pose_of(block, id));
    const Eigen::Vector2d n = normalized(camera, {x + 0.5, y + 0.5});
    const Eigen::Vector3d direction = world_from_cam.rotation * Eigen::Vector3d(n.x(), n.y(), 1);
    const Hit hit = cast(world_from_cam.translation, direction);
    return {hit.t, world_from_cam.translation + hit.t * direction, hit.on_roof};
  }
};

}  // namespace collinea::test
