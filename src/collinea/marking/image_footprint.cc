// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/image_footprint.h"

#include <cmath>

namespace collinea {

std::optional<std::vector<Eigen::Vector3d>> image_footprint(const Camera& camera, const Rigid3& cam_from_world,
                                                            double height_in_world) {
  constexpr int kParts = 4;         // of a side
  constexpr double kFarthest = 10;  // distance over height
  const Eigen::Vector3d centre = centre_of(cam_from_world);
  const Eigen::Vector2d corners[] = {
      {0, 0}, {camera.width_px, 0}, {camera.width_px, camera.height_px}, {0, camera.height_px}};
  const double height = centre.z() - height_in_world;
  std::vector<Eigen::Vector3d> outline;
  for (int side = 0; side < 4; ++side)
    for (int part = 0; part < kParts; ++part) {
      const double t = double(part) / kParts;
      const Eigen::Vector2d pixel = (1 - t) * corners[side] + t * corners[(side + 1) % 4];
      const Eigen::Vector3d ray = cam_from_world.rotation.conjugate() * ray_in_cam(camera, pixel);
      const double distance = -height / ray.z();  // along the unit vector
      if (!(distance > 0) || !(distance < kFarthest * std::abs(height))) return std::nullopt;
      outline.push_back(centre + distance * ray);
    }
  return outline;
}

std::optional<std::array<Eigen::Vector3d, 4>> corner_rays(const Camera& camera, const Rigid3& cam_from_world) {
  constexpr double kLeastCosine = 0.05;  // flatter ones reach the depth of one beyond all that can be shown
  const double width = camera.width_px, height = camera.height_px;
  const Eigen::Vector2d corners[] = {{0, 0}, {width, 0}, {width, height}, {0, height}};
  std::array<Eigen::Vector3d, 4> rays;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d in_cam = ray_in_cam(camera, corners[i]);
    if (!(in_cam.z() > kLeastCosine)) return std::nullopt;
    rays[i] = cam_from_world.rotation.conjugate() * Eigen::Vector3d(in_cam / in_cam.z());
  }
  return rays;
}

}  // namespace collinea
