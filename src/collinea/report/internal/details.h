// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/block/differences.h"

namespace collinea {

// What is known of each image, control point and camera: one record and one set of words for report.json and
// adjustment.json. World frame, east, north, height; NaN or nothing: not known (null in JSON).

struct ImageDetail {
  ImageId image;
  std::size_t rays = 0;  ///< of tie points, that took part
  double rms_px = 0;     ///< of the lengths of their residuals
  Eigen::Vector3d centre_in_world = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::optional<Eigen::Vector3d> centre_sigma_m;
  std::optional<Eigen::Vector3d> rotation_sigma_deg;  ///< of small rotations about the axes of the world
  const PositionDifference* position = nullptr;       ///< where a receiver gave one
};

struct CameraDetail {
  CameraId camera;
  std::size_t images = 0, rays = 0;  ///< oriented images, and their rays of tie points
  double rms_px = 0;                 ///< of the lengths of their residuals
  const Camera* before = nullptr;    ///< where it is known
  std::vector<double> sigma;         ///< of Camera::params; 0: fixed; NaN, or none: not known
};

/// Sums of images over those of each camera with oriented images.
[[nodiscard]] std::map<CameraId, CameraDetail> by_camera(std::span<const ImageDetail> images, const Block& block);

[[nodiscard]] nlohmann::ordered_json json_of(const ImageDetail& image, const Block& block);
[[nodiscard]] nlohmann::ordered_json json_of(const CameraDetail& camera, const Block& block);
[[nodiscard]] nlohmann::ordered_json json_of(const ControlDifference& control, const Block& block);

}  // namespace collinea
