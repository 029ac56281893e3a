// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/camera/camera.h"
#include "collinea/geometry/rigid3.h"

namespace collinea::colmap {

// COLMAP's files as they are, before and after they become a Block.

constexpr std::uint64_t kNoPoint = ~std::uint64_t{0};
constexpr int kFullOpencv = 6;

struct ModelName {
  std::string_view name;
  std::size_t params;
};
/// Indexed by COLMAP's model number.
constexpr std::array<ModelName, 11> kModels = {{{"SIMPLE_PINHOLE", 3},
                                                {"PINHOLE", 4},
                                                {"SIMPLE_RADIAL", 4},
                                                {"RADIAL", 5},
                                                {"OPENCV", 8},
                                                {"OPENCV_FISHEYE", 8},
                                                {"FULL_OPENCV", 12},
                                                {"FOV", 5},
                                                {"SIMPLE_RADIAL_FISHEYE", 4},
                                                {"RADIAL_FISHEYE", 5},
                                                {"THIN_PRISM_FISHEYE", 12}}};

struct CameraRow {
  std::uint64_t id = 0;
  int model = kFullOpencv;
  std::uint64_t width_px = 0, height_px = 0;
  std::vector<double> params;
};

struct SeenPoint {
  Eigen::Vector2d pixel;
  std::uint64_t point = kNoPoint;
};

struct ImageRow {
  std::uint64_t id = 0, camera = 0;
  Rigid3 cam_from_world;
  std::string name;
  std::vector<SeenPoint> seen;
};

struct TrackElement {
  std::uint64_t image = 0, index = 0;  ///< index into ImageRow::seen
};

struct PointRow {
  std::uint64_t id = 0;
  Eigen::Vector3d position;
  std::array<std::uint8_t, 3> colour{};
  double error_px = 0;  ///< mean length of its residuals
  std::vector<TrackElement> track;
};

struct Model {
  std::vector<CameraRow> cameras;
  std::vector<ImageRow> images;
  std::vector<PointRow> points;
};

[[nodiscard]] std::string cameras_text(const Model& model);
[[nodiscard]] std::string images_text(const Model& model);
[[nodiscard]] std::string points_text(const Model& model);
[[nodiscard]] std::string cameras_binary(const Model& model);
[[nodiscard]] std::string images_binary(const Model& model);
[[nodiscard]] std::string points_binary(const Model& model);

// Errors name the line, or say that the file is truncated.
[[nodiscard]] Result<std::vector<CameraRow>> parse_cameras_text(std::string_view text);
[[nodiscard]] Result<std::vector<ImageRow>> parse_images_text(std::string_view text);
[[nodiscard]] Result<std::vector<PointRow>> parse_points_text(std::string_view text);
[[nodiscard]] Result<std::vector<CameraRow>> parse_cameras_binary(std::string_view bytes);
[[nodiscard]] Result<std::vector<ImageRow>> parse_images_binary(std::string_view bytes);
[[nodiscard]] Result<std::vector<PointRow>> parse_points_binary(std::string_view bytes);

}  // namespace collinea::colmap
