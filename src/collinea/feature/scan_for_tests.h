// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/camera/film_calibration.h"
#include "collinea/camera/film_transformation.h"
#include "collinea/math/random.h"
#include "collinea/raster/raster.h"
#include "collinea/synthetic/fiducial_look.h"

namespace collinea {

/// How a scan of a photograph with fiducial marks is rendered. For tests and benchmarks.
struct ScanLook {
  double blur_px = 1;          ///< of lens, film and scanner
  double grain = 6;            ///< standard deviation of grey values
  double grain_blur_px = 0.7;  ///< by which neighbours are correlated
  double mark = 200, background = 50;
  double mark_rotation_rad = 0;  ///< standard deviation of the rotation of each mark on the film
};

inline FloatImage smoothed(const FloatImage& in, double sigma) {
  const int reach = int(std::ceil(4 * sigma));
  std::vector<double> kernel;
  double weights = 0;
  for (int k = -reach; k <= reach; ++k) {
    kernel.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    weights += kernel.back();
  }
  FloatImage out = in;
  for (const bool along : {true, false}) {
    const FloatImage from = out;
    for (int y = 0; y < in.height; ++y)
      for (int x = 0; x < in.width; ++x) {
        double sum = 0;
        for (int k = -reach; k <= reach; ++k)
          sum += kernel[std::size_t(k + reach)] * double(from.at(std::clamp(along ? x + k : x, 0, in.width - 1),
                                                                 std::clamp(along ? y : y + k, 0, in.height - 1)));
        out.at(x, y) = float(sum / weights);
      }
  }
  return out;
}

/// Light of a mark on cells of a third of a pixel, `cells` in a row about `middle`. Film and scan are related linearly
/// about the mark, which is exact for an affine film; the mark itself may be turned on the film.
inline FloatImage mark_on_cells(const CalibratedMark& mark, const FilmCalibration& calibration,
                                const Eigen::Matrix2d& film_by_pixel, const Eigen::Vector2d& upper_left_from_mark,
                                int cells, int cells_per_px, double turned_rad) {
  // The axis of the mark looks to the inside, in eighths of a turn.
  const double inwards =
      std::round(std::atan2(-mark.film_mm.y(), -mark.film_mm.x()) / (std::numbers::pi / 4)) * (std::numbers::pi / 4);
  const bool has_axis = mark.kind == MarkKind::kCorner || mark.kind == MarkKind::kNotch;
  const double axis = (has_axis ? inwards : 0) + turned_rad, c = std::cos(axis), s = std::sin(axis);
  const auto brightness = [&](double x, double y) {
    const Eigen::Vector2d film = film_by_pixel * (upper_left_from_mark + Eigen::Vector2d(x, y) / cells_per_px);
    return mark_brightness(mark.kind.value_or(MarkKind::kCross), c * film.x() + s * film.y(),
                           -s * film.x() + c * film.y(), calibration.mark_size_mm, calibration.line_mm);
  };
  constexpr int kFiner = 10;
  FloatImage light(cells, cells);
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      // Lines are some pixels wide: cells whose corners and middle agree lie within or without.
      const double corners = brightness(x, y) + brightness(x + 1, y) + brightness(x, y + 1) + brightness(x + 1, y + 1);
      const double middle = brightness(x + 0.5, y + 0.5);
      if (corners == 4 * middle) {
        light.at(x, y) = float(middle);
        continue;
      }
      double sum = 0;
      for (int k = 0; k < kFiner * kFiner; ++k) {
        // A lattice that is turned: edges along rows and columns cross it at 100 positions of a cell, not at ten.
        const double i = k % kFiner + 0.5, j = k / kFiner + 0.5;
        sum +=
            brightness(x + (i + (j - kFiner / 2.0) / kFiner) / kFiner, y + (j - (i - kFiner / 2.0) / kFiner) / kFiner);
      }
      light.at(x, y) = float(sum / (kFiner * kFiner));
    }
  return light;
}

/// Means of squares of cells.
inline FloatImage pixels_of_cells(const FloatImage& cells, int cells_per_px) {
  FloatImage out(cells.width / cells_per_px, cells.height / cells_per_px);
  for (int y = 0; y < cells.height; ++y)
    for (int x = 0; x < cells.width; ++x)
      out.at(x / cells_per_px, y / cells_per_px) += cells.at(x, y) / float(cells_per_px * cells_per_px);
  return out;
}

/// A scan that shows the marks of the calibration as the transformation has them, each on a square of `reach_mm` to all
/// sides; elsewhere the background. The blur is that of the light, before the pixels gather it: a blur of the pixels
/// themselves would be a staircase, which shifts edges along rows and columns by some hundredths of a pixel.
inline GreyImage rendered_scan(const FilmCalibration& calibration, const FilmTransformation& truth, int width,
                               int height, const ScanLook& look, double reach_mm, Random& random) {
  constexpr int kCells = 3;  // of a pixel
  GreyImage scan(width, height, 1, std::uint8_t(look.background));
  for (const CalibratedMark& mark : calibration.marks) {
    const Eigen::Vector2d middle = truth.pixel_of(mark.film_mm);
    const int half = int(reach_mm * truth.by_film(mark.film_mm).col(0).norm());
    const int left = int(middle.x()) - half, top = int(middle.y()) - half;
    FloatImage noise(2 * half + 1, 2 * half + 1);
    for (float& value : noise.data) value = float(random.normal());
    const double turned = look.mark_rotation_rad > 0 ? look.mark_rotation_rad * random.normal() : 0;
    const FloatImage light = mark_on_cells(mark, calibration, truth.by_film(mark.film_mm).inverse(),
                                           Eigen::Vector2d(left, top) - middle, kCells * noise.width, kCells, turned);
    const FloatImage part = pixels_of_cells(smoothed(light, kCells * look.blur_px), kCells);
    noise = smoothed(noise, look.grain_blur_px);
    const double gain = look.grain * 2 * std::sqrt(std::numbers::pi) * look.grain_blur_px;
    for (int y = std::max(0, -top); y < part.height && top + y < height; ++y)
      for (int x = std::max(0, -left); x < part.width && left + x < width; ++x)
        scan.at(left + x, top + y) =
            std::uint8_t(std::clamp(look.background + (look.mark - look.background) * double(part.at(x, y)) +
                                        gain * double(noise.at(x, y)) + 0.5,
                                    0.0, 255.0));
  }
  return scan;
}

}  // namespace collinea
