// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/words.h"
#include "collinea/surface/height_point.h"

namespace collinea {

/// A height between points; NaN: nothing there, or its standard deviation is not known.
struct InterpolatedHeight {
  double height_m = std::numeric_limits<double>::quiet_NaN(), sigma_m = height_m;
};

/// A surface through or near points. at() may be called from several threads at once.
class HeightInterpolation {
 public:
  virtual ~HeightInterpolation() = default;
  [[nodiscard]] virtual InterpolatedHeight at(const Eigen::Vector2d& on_map) const = 0;
};

/// Linear within the triangles of Delaunay. The sigma is that of the points alone: it does not know what the surface
/// does between them. Nothing outside the hull and in triangles with a side longer than `longest_m`. Error: fewer than
/// three points, or all on a line.
[[nodiscard]] Result<std::unique_ptr<HeightInterpolation>> triangulated(
    std::span<const HeightPoint> points, double longest_m = std::numeric_limits<double>::infinity());

/// The plane by least squares through the nearest points, each weighted by its sigma and by 1 / (1 + (d / m)^2), d its
/// distance and m the median one of them. The sigma is that of the plane at the position, by the scatter about it.
/// Nothing where the nearest points lie on a line. Error: fewer points than that.
[[nodiscard]] Result<std::unique_ptr<HeightInterpolation>> local_planes(std::span<const HeightPoint> points,
                                                                        int nearest = 12);

/// How alike heights are at a distance h: covariance signal_m2 rho(h / range_m), with noise of single points.
///     exponential: rho = exp(-h/a)    gaussian: rho = exp(-(h/a)^2)    spherical: rho = 1 - 1.5 h/a + 0.5 (h/a)^3
enum class CovarianceModel { kExponential, kGaussian, kSpherical };
inline constexpr Word<CovarianceModel> kCovarianceModelWords[] = {{CovarianceModel::kExponential, "exponential"},
                                                                  {CovarianceModel::kGaussian, "gaussian"},
                                                                  {CovarianceModel::kSpherical, "spherical"}};
[[nodiscard]] constexpr std::span<const Word<CovarianceModel>> words(CovarianceModel) { return kCovarianceModelWords; }

struct HeightCovariance {
  CovarianceModel model = CovarianceModel::kExponential;
  double signal_m2 = 1, range_m = 1;
  double noise_m2 = 0;  ///< beyond the sigmas of the points

  [[nodiscard]] double at(double distance_m) const;  ///< of the signal
};

/// A class of distances of an empirical variogram: half the mean square of the differences of two heights.
struct VariogramClass {
  double distance_m = 0, half_square_m2 = 0;
  std::size_t pairs = 0;
};

struct FittedCovariance {
  HeightCovariance covariance;
  Eigen::Vector3d trend = Eigen::Vector3d::Zero();  ///< height in the middle, rise to the east, rise to the north
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  std::vector<VariogramClass> variogram;  ///< of the points less their trend
};

/// The covariance of heights less the plane that fits them best: variogram in 15 classes up to a third of the extent
/// (Matheron 1963), for each model the range with the least squares weighted by pairs over the squared value (Cressie
/// 1985), from where likelihood decides (Vecchia 1988, given the nearest points): the most likely of the three models,
/// or `model`. The points' own sigmas are no part of the noise. Error: fewer than 30 points, or all on a line.
[[nodiscard]] Result<FittedCovariance> fit_covariance(std::span<const HeightPoint> points,
                                                      std::optional<CovarianceModel> model = {});

/// Least squares collocation (Moritz 1972), which is kriging with an unknown mean of each neighbourhood (ordinary
/// kriging): the signal at a position from the nearest points, filtered from their noise, with its standard deviation.
[[nodiscard]] Result<std::unique_ptr<HeightInterpolation>> collocation(std::span<const HeightPoint> points,
                                                                       const FittedCovariance& fitted,
                                                                       int nearest = 24);

/// Bicubic splines on squares of `spacing_m`, by least squares of the points (weights by sigma, equal where one has
/// none); where points are missing the second differences of the coefficients are held small. The sigma is by the
/// scatter of the points; not known with more than 2500 coefficients. Error: fewer than 16 points, more than 250,000
/// coefficients.
[[nodiscard]] Result<std::unique_ptr<HeightInterpolation>> bicubic_splines(std::span<const HeightPoint> points,
                                                                           double spacing_m);

}  // namespace collinea
