// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/camera/camera.h"

namespace collinea {

/// Corresponding image points of two images: undistorted image coordinates (X/Z, Y/Z) of pair i in x1[i], y1[i]
/// (first) and x2[i], y2[i] (second). The focal lengths turn distances between them into pixels; in images of a
/// fisheye these are times scale1[i], scale2[i], which are empty otherwise.
struct PointPairs {
  std::vector<double> x1, y1, x2, y2;
  std::vector<double> scale1, scale2;
  double focal_first_px = 1, focal_second_px = 1;

  [[nodiscard]] int size() const { return static_cast<int>(x1.size()); }
  [[nodiscard]] Eigen::Vector2d first(int i) const {
    const auto k = static_cast<std::size_t>(i);
    return {x1[k], y1[k]};
  }
  [[nodiscard]] Eigen::Vector2d second(int i) const {
    const auto k = static_cast<std::size_t>(i);
    return {x2[k], y2[k]};
  }
  void reserve(std::size_t count) {
    for (auto* values : {&x1, &y1, &x2, &y2}) values->reserve(count);
  }
  void add(const Eigen::Vector2d& in_first, const Eigen::Vector2d& in_second) {
    x1.push_back(in_first.x());
    y1.push_back(in_first.y());
    x2.push_back(in_second.x());
    y2.push_back(in_second.y());
  }
  /// The pair of two pixels, with their scales if one of the cameras is a fisheye.
  void add(const Camera& camera_first, const Eigen::Vector2d& pixel_first, const Camera& camera_second,
           const Eigen::Vector2d& pixel_second) {
    const Eigen::Vector2d in_first = normalized(camera_first, pixel_first);
    const Eigen::Vector2d in_second = normalized(camera_second, pixel_second);
    add(in_first, in_second);
    if (!is_fisheye(camera_first.model) && !is_fisheye(camera_second.model)) return;
    scale1.push_back(pixels_per_unit(camera_first, in_first) / camera_first.focal_px());
    scale2.push_back(pixels_per_unit(camera_second, in_second) / camera_second.focal_px());
  }
  /// The squared lengths of a pixel of pair i in units of its coordinates.
  [[nodiscard]] Eigen::Vector2d squared_pixels(int i) const {
    const auto k = static_cast<std::size_t>(i);
    const double p1 = 1 / (focal_first_px * focal_first_px), p2 = 1 / (focal_second_px * focal_second_px);
    return scale1.empty() ? Eigen::Vector2d(p1, p2)
                          : Eigen::Vector2d(p1 / (scale1[k] * scale1[k]), p2 / (scale2[k] * scale2[k]));
  }
};

}  // namespace collinea
