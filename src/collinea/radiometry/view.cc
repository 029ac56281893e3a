// SPDX-License-Identifier: Apache-2.0
#include "collinea/radiometry/view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

// The flattest line of sight through the border of the image: within a convex image none is flatter.
// Infinite where one does not rise, or where the lens folds back.
double most_run_per_rise_of(const View& view) {
  constexpr int kPerSide = 16;
  constexpr double kSlack = 1.05;  // for the map, which is not quite the world, and what lies between the lines
  double most = 0;
  for (int i = 0; i < 4 * kPerSide; ++i) {
    const double along = double(i % kPerSide) / kPerSide;
    const double x[] = {along, 1, 1 - along, 0}, y[] = {0, along, 1, 1 - along};
    const Eigen::Vector2d pixel(x[i / kPerSide] * view.camera.width_px, y[i / kPerSide] * view.camera.height_px);
    const Eigen::Vector3d ray_in_cam = collinea::ray_in_cam(view.camera, pixel);
    const auto seen_at = project(view.camera, ray_in_cam);
    const Eigen::Vector3d ray = view.rotation.transpose() * ray_in_cam;
    if (!seen_at || (*seen_at - pixel).norm() > 1 || !(ray.z() < 0)) return std::numeric_limits<double>::infinity();
    most = std::max(most, std::hypot(ray.x(), ray.y()) / -ray.z());
  }
  return kSlack * most;
}

}  // namespace

std::vector<View> views_of(const Block& block, const LocalFrame* frame) {
  std::vector<View> views;
  for (const auto& [id, cam_from_world] : oriented_images(block)) {
    View view;
    view.image = id;
    view.camera_id = block.images.at(id).camera;
    view.camera = block.camera_of(id);
    view.cam_from_world = cam_from_world;
    view.bend = block.images.at(id).bend;
    view.rotation = cam_from_world.rotation.toRotationMatrix();
    view.centre_in_world = centre_of(cam_from_world);
    view.most_run_per_rise = most_run_per_rise_of(view);
    view.centre_in_map = frame ? frame->map_from_local(view.centre_in_world) : view.centre_in_world;
    views.push_back(std::move(view));
  }
  return views;
}

float cost_of(const View& view, const Eigen::Vector3d& point_in_world, double cell_m) {
  const Eigen::Vector3d up = view.centre_in_world - point_in_world;
  const auto pixel = pixel_of(view, point_in_world);
  if (!pixel || !(up.z() > 0)) return 2 * kUseless;
  const Camera& camera = view.camera;
  const double obliquity = (up.x() * up.x() + up.y() * up.y()) / (up.z() * up.z());
  const double half_width = camera.width_px / 2.0, half_height = camera.height_px / 2.0;
  const double x = pixel->x() - half_width, y = pixel->y() - half_height;
  const double off_centre = (x * x + y * y) / (half_width * half_width + half_height * half_height);
  const double rim = 0.08 * std::min(half_width, half_height);
  const double to_border = std::min(half_width - std::abs(x), half_height - std::abs(y));
  const double border = std::max(0.0, 1 - to_border / rim);
  const double pixel_m = up.norm() / camera.focal_px();
  const double coarse = std::max(0.0, std::log2(pixel_m / cell_m));
  return float(std::min(obliquity + 0.1 * off_centre + 2 * border + 0.5 * coarse, double(kUseless)));
}

bool looks_down(const Block& block) {
  std::size_t down = 0;
  for (const auto& [id, cam_from_world] : oriented_images(block))
    down += (cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ()).z() < -0.5;
  return down > 0 && 2 * down >= count_oriented(block);
}

}  // namespace collinea
