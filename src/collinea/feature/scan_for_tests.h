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

/// A scan that shows the marks of the calibration as the transformation has them, each on a square of `reach_mm` to all
/// sides; elsewhere the background.
inline GreyImage rendered_scan(const FilmCalibration& calibration, const FilmTransformation& truth, int width,
                               int height, const ScanLook& look, double reach_mm, Random& random) {
  GreyImage scan(width, height, 1, std::uint8_t(look.background));
  for (const CalibratedMark& mark : calibration.marks) {
    const Eigen::Vector2d middle = truth.pixel_of(mark.film_mm);
    const int half = int(reach_mm * truth.by_film(mark.film_mm).col(0).norm());
    const int left = int(middle.x()) - half, top = int(middle.y()) - half;
    FloatImage part(2 * half + 1, 2 * half + 1), noise(2 * half + 1, 2 * half + 1);
    // The axis of the mark looks to the inside, in eighths of a turn.
    const double inwards =
        std::round(std::atan2(-mark.film_mm.y(), -mark.film_mm.x()) / (std::numbers::pi / 4)) * (std::numbers::pi / 4);
    const bool has_axis = mark.kind == MarkKind::kCorner || mark.kind == MarkKind::kNotch;
    const double c = has_axis ? std::cos(inwards) : 1, s = has_axis ? std::sin(inwards) : 0;
    // The inverse of the truth, linear about the mark: exact for an affine film.
    const Eigen::Matrix2d film_by_pixel = truth.by_film(mark.film_mm).inverse();
    constexpr int kFiner = 10;
    for (int y = 0; y < part.height; ++y)
      for (int x = 0; x < part.width; ++x) {
        noise.at(x, y) = float(random.normal());
        double sum = 0;
        for (int k = 0; k < kFiner * kFiner; ++k) {
          // A lattice that is turned: edges along rows and columns cross it at 100 positions of a pixel, not at ten.
          const double i = k % kFiner + 0.5, j = k / kFiner + 0.5;
          const Eigen::Vector2d at(left + x + (i + (j - kFiner / 2.0) / kFiner) / kFiner,
                                   top + y + (j - (i - kFiner / 2.0) / kFiner) / kFiner);
          const Eigen::Vector2d film = film_by_pixel * (at - middle);
          sum += mark_brightness(mark.kind.value_or(MarkKind::kCross), c * film.x() + s * film.y(),
                                 -s * film.x() + c * film.y(), calibration.mark_size_mm, calibration.line_mm);
        }
        part.at(x, y) = float(sum / (kFiner * kFiner));
      }
    part = smoothed(part, look.blur_px);
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
