// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/refraction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "collinea/block/world_frame.h"
#include "collinea/geodesy/refraction.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

// Farther from the nadir layers are no longer flat: at 75 degrees the curvature of the Earth changes the path through
// the lowest 10 km by one per cent.
constexpr double kWidest_rad = 75 * std::numbers::pi / 180;

struct Station {
  const Camera* camera;
  Rigid3 cam_from_world;
  Eigen::Vector3d down_in_cam;
  double height_m;
};

double height_of(const LocalFrame& frame, const Eigen::Vector3d& position) {
  return frame.geographic_from_local(position).z();
}

// The pixel without the bend of its ray; nothing where the formula does not hold.
std::optional<Eigen::Vector2d> straight(const Station& station, const Eigen::Vector2d& pixel, double point_height_m) {
  const Eigen::Vector3d ray = ray_in_cam(*station.camera, pixel);
  const double angle = std::acos(std::clamp(ray.dot(station.down_in_cam), -1.0, 1.0));
  if (!(angle < kWidest_rad) || !(point_height_m < station.height_m)) return std::nullopt;
  const double bend = refraction_rad(station.height_m, point_height_m) * std::tan(angle);
  const Eigen::Vector3d axis = ray.cross(station.down_in_cam);
  const double sine = axis.norm();
  if (!(sine > 0)) return pixel;
  return project(*station.camera, rotation_by(bend / sine * axis) * ray);
}

std::map<ImageId, Station> stations_of(const Block& block, const LocalFrame& frame) {
  std::map<ImageId, Station> stations;
  for (const auto& [id, pose] : oriented_images(block)) {
    const Eigen::Vector3d centre = centre_of(pose), position = frame.geographic_from_local(centre);
    const Eigen::Vector3d below = frame.local_from_geographic({position.x(), position.y(), position.z() - 1000});
    stations[id] = {&block.camera_of(id), pose, pose.rotation * (below - centre).normalized(), position.z()};
  }
  return stations;
}

double largest_at_corners_px(const Station& station, double ground_height_m) {
  const RayBend bend{station.down_in_cam, refraction_rad(station.height_m, ground_height_m)};
  double largest = 0;
  for (const double x : {0.0, 1.0})
    for (const double y : {0.0, 1.0}) {
      const Eigen::Vector2d corner(x * station.camera->width_px, y * station.camera->height_px);
      const auto seen = project(*station.camera, bend.bent(ray_in_cam(*station.camera, corner)));
      if (seen) largest = std::max(largest, (*seen - corner).norm());
    }
  return largest;
}

}  // namespace

double largest_refraction_px(const Block& block) {
  const auto frame = world_frame(block);
  if (!frame || !*frame || block.points.empty()) return 0;
  double height_m = 0, largest = 0;
  for (const auto& [id, point] : block.points)
    height_m += height_of(**frame, point.position_in_world) / static_cast<double>(block.points.size());
  for (const auto& [id, station] : stations_of(block, **frame))
    largest = std::max(largest, largest_at_corners_px(station, height_m));
  return largest;
}

Result<Refracted> correct_refraction(Block& block) {
  COLLINEA_TRY(const auto frame, world_frame(block));
  if (!frame)
    return fail(Errc::kBadInput,
                "refraction needs heights above the sea: this block has no location on Earth (no GPS, no CRS)");
  const std::map<ImageId, Station> stations = stations_of(block, *frame);
  Refracted result;
  const auto correct = [&](ImageId image, double point_height_m, Eigen::Vector2d& pixel) {
    const auto station = stations.find(image);
    if (station == stations.end()) return;
    const auto moved = straight(station->second, pixel, point_height_m);
    if (!moved) {
      ++result.left;
      return;
    }
    ++result.corrected;
    result.largest_px = std::max(result.largest_px, (*moved - pixel).norm());
    pixel = *moved;
  };
  double sum = 0;
  std::map<PointId, double> heights;
  for (const auto& [id, point] : block.points) sum += heights[id] = height_of(*frame, point.position_in_world);
  for (Observation& seen : block.observations)
    if (const auto height = heights.find(seen.point); height != heights.end())
      correct(seen.image, height->second, seen.pixel);
  // A control point without coordinates lies as high as the others do.
  const double usual = heights.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / double(heights.size());
  for (ControlObservation& seen : block.control_observations) {
    const ControlPoint& point = block.control.at(seen.point);
    const double height = point.position_in_world.allFinite() ? height_of(*frame, point.position_in_world) : usual;
    correct(seen.image, height, seen.pixel);
  }
  if (!heights.empty())
    for (const auto& [id, station] : stations)
      block.images.at(id).bend = {station.down_in_cam, refraction_rad(station.height_m, usual)};
  return result;
}

}  // namespace collinea
