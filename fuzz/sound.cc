// SPDX-License-Identifier: Apache-2.0
#include "sound.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/result.h"

namespace collinea::fuzz {
namespace {

void check_images(const Block& block) {
  for (const auto& [id, camera] : block.cameras) {
    COLLINEA_CHECK(camera.width_px >= 0 && camera.height_px >= 0);
    COLLINEA_CHECK(std::ranges::all_of(camera.params, [](double value) { return std::isfinite(value); }));
  }
  for (const auto& [id, image] : block.images) COLLINEA_CHECK(block.cameras.contains(image.camera));
  for (const auto& [id, pose] : oriented_images(block)) {
    COLLINEA_CHECK(block.images.contains(id));
    COLLINEA_CHECK(pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1) < 1e-6);
  }
}

void check_points(const Block& block) {
  for (const auto& [id, point] : block.points) COLLINEA_CHECK(point.position_in_world.allFinite());
  for (const auto& [id, point] : block.control) COLLINEA_CHECK(point.position_in_world.allFinite());
  for (const Observation& seen : block.observations) {
    COLLINEA_CHECK(block.images.contains(seen.image) && seen.pixel.allFinite());
    COLLINEA_CHECK(seen.sigma_px > 0 && std::isfinite(seen.sigma_px));
  }
  for (const ControlObservation& seen : block.control_observations) {
    COLLINEA_CHECK(block.images.contains(seen.image) && block.control.contains(seen.point));
    COLLINEA_CHECK(seen.pixel.allFinite() && seen.sigma_px > 0 && std::isfinite(seen.sigma_px));
  }
  for (const GeodeticObservation& one : block.geodetic) {
    COLLINEA_CHECK(block.control.contains(one.from) && block.control.contains(one.to));
    COLLINEA_CHECK(std::isfinite(one.value) && one.sigma > 0);
  }
}

}  // namespace

void check_sound(const Block& block) {
  check_images(block);
  check_points(block);
}

}  // namespace collinea::fuzz
