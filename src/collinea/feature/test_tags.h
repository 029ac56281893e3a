// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "collinea/feature/edges.h"
#include "collinea/feature/tag_family.h"
#include "collinea/feature/test_shapes.h"

// Rendered tags with known corners, for tests: cells are sampled finely, blurred and averaged over pixels, without the
// model by which tags are measured.
namespace collinea {

struct TagScene {
  TagFamily family = TagFamily::kApriltag36h11;
  int id = 0;
  Eigen::Vector2d at = {};
  double side_px = 40;
  double rotation_rad = 0;
  double tilt_rad = 0, tilt_towards_rad = 0;  ///< of the tag, seen from a distance of eight sides
  double blur_px = 0.6;
  double ground_cells = 1;  ///< light about the tag; beyond it all is of half the light
  TagBits damaged = 0;      ///< cells of the code that are inverted

  /// From positions on the tag (-0.5 .. 0.5) to pixels.
  [[nodiscard]] Eigen::Matrix3d image_from_tag() const {
    const Eigen::Vector3d axis(std::cos(tilt_towards_rad), std::sin(tilt_towards_rad), 0);
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(tilt_rad, axis) * Eigen::AngleAxisd(rotation_rad, Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    constexpr double kDistance = 8;
    Eigen::Matrix3d plane;
    plane << turn.col(0), turn.col(1), Eigen::Vector3d(0, 0, kDistance);
    Eigen::Matrix3d camera;
    camera << side_px * kDistance, 0, at.x(), 0, side_px * kDistance, at.y(), 0, 0, 1;
    return camera * plane;
  }
  [[nodiscard]] Eigen::Vector2d position(double u, double v) const {
    return (image_from_tag() * Eigen::Vector3d(u, v, 1)).hnormalized();
  }
  [[nodiscard]] std::array<Eigen::Vector2d, 4> corners() const {
    return {position(-0.5, -0.5), position(0.5, -0.5), position(0.5, 0.5), position(-0.5, 0.5)};
  }
  /// Light at a position of the tag; nothing of it is blurred.
  [[nodiscard]] double light(const Eigen::Vector2d& q) const {
    const TagCodes& codes = tag_codes(family);
    const int n = codes.side + 2;
    const Eigen::Vector2d cell = n * (q + Eigen::Vector2d::Constant(0.5));
    const double out = std::max((q.cwiseAbs().maxCoeff() - 0.5) * n, 0.0);
    if (out > 0) return out <= ground_cells ? 1 : 0.5;
    const int x = int(std::floor(cell.x())) - 1, y = int(std::floor(cell.y())) - 1;
    if (x < 0 || y < 0 || x >= codes.side || y >= codes.side) return 0;
    const TagBits bits = codes.bits[std::size_t(id)] ^ damaged;
    return double(bits >> (codes.side * codes.side - 1 - y * codes.side - x) & 1);
  }
};

/// Draws a tag into an image of light from 0 to 1, where it and its ground lie.
inline void draw_tag(FloatImage& image, const TagScene& scene, int fine = 8) {
  const double reach = scene.side_px * 1.1 + 6;
  const int x0 = std::max(0, int(scene.at.x() - reach)), x1 = std::min(image.width, int(scene.at.x() + reach));
  const int y0 = std::max(0, int(scene.at.y() - reach)), y1 = std::min(image.height, int(scene.at.y() + reach));
  FloatImage sampled((x1 - x0) * fine, (y1 - y0) * fine);
  const Eigen::Matrix3d tag_from_image = scene.image_from_tag().inverse();
  for (int y = 0; y < sampled.height; ++y)
    for (int x = 0; x < sampled.width; ++x)
      sampled.at(x, y) = float(scene.light(
          (tag_from_image * Eigen::Vector3d(x0 + (x + 0.5) / fine, y0 + (y + 0.5) / fine, 1)).hnormalized()));
  sampled = smoothed(sampled, scene.blur_px * fine);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      float sum = 0;
      for (int s = 0; s < fine * fine; ++s) sum += sampled.at((x - x0) * fine + s % fine, (y - y0) * fine + s / fine);
      image.at(x, y) = sum / float(fine * fine);
    }
}

/// An image of one tag in its middle, greys from dark to dark + contrast, with noise.
inline FloatImage image_of_tag(const TagScene& scene, int width, int height, double noise_grey = 0,
                               std::uint64_t seed = 1, double dark = 40, double contrast = 160) {
  FloatImage image(width, height, 1, 0.5f);
  draw_tag(image, scene);
  for (float& grey : image.data) grey = float(dark + contrast * grey);
  return noise_grey > 0 ? with_noise(std::move(image), noise_grey, seed) : image;
}

}  // namespace collinea
