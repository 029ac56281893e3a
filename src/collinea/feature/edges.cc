// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/edges.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/feature/internal/edge_filters.h"
#include "collinea/feature/internal/link_edges.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Systematic errors where the filter is not what it stands for: rms over edges in all directions [px].
constexpr double kFacetModelPx = 0.02, kLaplacianModelPx = 0.012;
constexpr double kInPixel = 0.6;          // farthest a point may lie from the middle of its pixel, in x and y
constexpr double kNoiseTimes = 10;        // the amplitude `high`, in standard deviations of noise
constexpr double kLeastPart = 0.05;       // of the slope, for logarithms beside it
constexpr double kLeastNoiseGrey = 0.29;  // rounding

// What the points are found in: the slopes of the smoothed image, and what is needed beside.
struct Fields {
  FloatImage x, y;      // slopes [grey/px]
  FloatImage strength;  // their length
  FloatImage other;     // Laplacian, or the smoothed image of facets; else empty
  double offset_px = 0;
  SmoothedNoise noise;
  GradientMasks masks;
  double laplacian_noise = 0;  // standard deviation that unit noise has in it
};

double model_px(EdgeOperator of) {
  return of == EdgeOperator::kLog ? kLaplacianModelPx : of == EdgeOperator::kHaralick ? kFacetModelPx : 0;
}

double default_sigma(EdgeOperator of) {
  return of == EdgeOperator::kLog ? 2.0 : of == EdgeOperator::kHaralick ? 1.4 : 1.0;
}

FloatImage masked(const FloatImage& image, const EdgeMask& mask) {
  FloatImage out(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    const float* rows[] = {image.row(std::max(0, y - 1)), image.row(y), image.row(std::min(image.height - 1, y + 1))};
    float* to = out.row(y);
    for (std::size_t r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        const float weight = float(mask[3 * r + std::size_t(c)]);
        if (weight == 0) continue;
        for (int x = 1; x + 1 < image.width; ++x) to[x] += weight * rows[r][x + c - 1];
      }
    if (image.width > 1) {
      to[0] = to[1];
      to[image.width - 1] = to[image.width - 2];
    }
  }
  return out;
}

FloatImage facet_slope(const FloatImage& image, const Weights5& weights) {
  FloatImage out(image.width, image.height);
  for (int y = 2; y + 2 < image.height; ++y) {
    float* to = out.row(y);
    for (int p = 0; p < 25; ++p) {
      const float weight = float(weights[std::size_t(p)]);
      const float* from = image.row(y + p / 5 - 2) + p % 5 - 2;
      for (int x = 2; x + 2 < image.width; ++x) to[x] += weight * from[x];
    }
  }
  return out;
}

void add_strength(Fields& fields) {
  fields.strength = FloatImage(fields.x.width, fields.x.height);
  for (std::size_t i = 0; i < fields.x.data.size(); ++i)
    fields.strength.data[i] = std::sqrt(fields.x.data[i] * fields.x.data[i] + fields.y.data[i] * fields.y.data[i]);
}

double laplacian_noise(double sigma_px) {
  const std::vector<double> g = gaussian_kernel(sigma_px, 0), gg = gaussian_kernel(sigma_px, 2);
  double sum = 0;
  for (std::size_t i = 0; i < g.size(); ++i)
    for (std::size_t j = 0; j < g.size(); ++j) sum += std::pow(g[i] * gg[j] + gg[i] * g[j], 2);
  return std::sqrt(sum);
}

Fields fields_of(const FloatImage& image, EdgeOperator of, double sigma_px) {
  Fields fields{.noise = SmoothedNoise(sigma_px)};
  if (of == EdgeOperator::kLog) {
    const std::vector<double> g = gaussian_kernel(sigma_px, 0), gg = gaussian_kernel(sigma_px, 2),
                              slope = gaussian_kernel(sigma_px, 1);
    fields.x = separable(image, slope, g);
    fields.y = separable(image, g, slope);
    fields.other = separable(image, gg, g);
    const FloatImage down = separable(image, g, gg);
    for (std::size_t i = 0; i < down.data.size(); ++i) fields.other.data[i] += down.data[i];
    fields.laplacian_noise = laplacian_noise(sigma_px);
  } else if (of == EdgeOperator::kHaralick) {
    fields.other = smoothed(image, sigma_px);
    fields.x = facet_slope(fields.other, facet_weights()[1]);
    fields.y = facet_slope(fields.other, facet_weights()[2]);
  } else {
    const FloatImage smooth = smoothed(image, sigma_px);
    fields.masks = gradient_masks(of);
    fields.offset_px = fields.masks.offset_px;
    fields.x = masked(smooth, fields.masks.x);
    fields.y = masked(smooth, fields.masks.y);
  }
  add_strength(fields);
  return fields;
}

// Standard deviation of a slope when that of a grey value is 1.
double slope_noise(const Fields& fields, EdgeOperator of, double sigma_px) {
  if (of == EdgeOperator::kHaralick) return std::sqrt(fields.noise.covariance(facet_weights()[1]));
  if (of != EdgeOperator::kLog) return std::sqrt(fields.noise.variance(fields.masks.x));
  double g2 = 0, slope2 = 0;
  for (const double w : gaussian_kernel(sigma_px, 0)) g2 += w * w;
  for (const double w : gaussian_kernel(sigma_px, 1)) slope2 += w * w;
  return std::sqrt(g2 * slope2);
}

bool lies_in_pixel(const Vector2d& offset) { return offset.cwiseAbs().maxCoeff() <= kInPixel; }

Vector2d position(const Fields& fields, int x, int y, const Vector2d& offset) {
  return Vector2d(x + 0.5 + fields.offset_px, y + 0.5 + fields.offset_px) + offset;
}

// --- maxima of the slope
// ----------------------------------------------------------------------------------------------

bool is_maximum(const FloatImage& strength, int x, int y, const Vector2d& normal) {
  const Vector2d step = normal / normal.cwiseAbs().maxCoeff();
  const auto at = [&](double sign) { return bilinear(strength, x + 0.5 + sign * step.x(), y + 0.5 + sign * step.y()); };
  const float here = strength.at(x, y);
  return here >= at(1) && here > at(-1);
}

// The weights of the 5 x 5 pixels in the position, which is sum w_i log(amplitude_i).
Weights5 through_slopes(const EdgeMask& of_log, const Fields& fields, int x, int y, const Vector2d& normal) {
  Weights5 out{};
  for (int i = 0; i < 9; ++i) {
    const double strength = fields.strength.at(x + i % 3 - 1, y + i / 3 - 1);
    const double factor = of_log[std::size_t(i)] / std::max(kLeastPart * fields.strength.at(x, y), strength);
    for (int k = 0; k < 9; ++k)
      out[std::size_t(5 * (i / 3 + k / 3) + i % 3 + k % 3)] +=
          factor * (normal.x() * fields.masks.x[std::size_t(k)] + normal.y() * fields.masks.y[std::size_t(k)]);
  }
  return out;
}

std::optional<EdgePoint> slope_maximum(const Fields& fields, int x, int y) {
  const double here = fields.strength.at(x, y);
  const Vector2d normal = Vector2d(fields.x.at(x, y), fields.y.at(x, y)) / here;
  if (!is_maximum(fields.strength, x, y, normal)) return std::nullopt;
  const auto& fit = paraboloid_weights();
  std::array<double, 6> c{};
  for (int i = 0; i < 9; ++i) {
    const double value =
        std::log(std::max(kLeastPart * here, double(fields.strength.at(x + i % 3 - 1, y + i / 3 - 1))));
    for (std::size_t k = 0; k < 6; ++k) c[k] += fit[k][std::size_t(i)] * value;
  }
  // log a(t) = ... + slope t + curvature t^2 / 2 along the normal
  const double slope = c[1] * normal.x() + c[2] * normal.y();
  const double xx = normal.x() * normal.x(), xy = normal.x() * normal.y(), yy = normal.y() * normal.y();
  const double curvature = 2 * (c[3] * xx + c[4] * xy + c[5] * yy);
  if (!(curvature < 0)) return std::nullopt;
  const double t = -slope / curvature;
  if (!lies_in_pixel(t * normal)) return std::nullopt;
  EdgeMask of_log;
  for (std::size_t i = 0; i < 9; ++i)
    of_log[i] = -(fit[1][i] * normal.x() + fit[2][i] * normal.y() +
                  2 * t * (fit[3][i] * xx + fit[4][i] * xy + fit[5][i] * yy)) /
                curvature;
  const double variance = fields.noise.covariance(through_slopes(of_log, fields, x, y, normal));
  return EdgePoint{position(fields, x, y, t * normal), normal, here, std::sqrt(variance)};
}

// --- zero crossings
// ---------------------------------------------------------------------------------------------------

// By cubic convolution (Keys 1981); (u, v) from the middle of the pixel, at most one pixel.
double cubic_at(const FloatImage& image, int x, int y, const Vector2d& offset) {
  const double px = offset.x(), py = offset.y();
  const int x0 = x + int(std::floor(px)), y0 = y + int(std::floor(py));
  const auto weights = [](double t) {
    return std::array<double, 4>{(-t * t * t + 2 * t * t - t) / 2, (3 * t * t * t - 5 * t * t + 2) / 2,
                                 (-3 * t * t * t + 4 * t * t + t) / 2, (t * t * t - t * t) / 2};
  };
  const auto wx = weights(px - std::floor(px)), wy = weights(py - std::floor(py));
  double sum = 0;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      sum += wy[std::size_t(r)] * wx[std::size_t(c)] *
             image.at(std::clamp(x0 + c - 1, 0, image.width - 1), std::clamp(y0 + r - 1, 0, image.height - 1));
  return sum;
}

std::optional<EdgePoint> laplacian_zero(const Fields& fields, int x, int y) {
  const double here = fields.strength.at(x, y);
  const Vector2d normal = Vector2d(fields.x.at(x, y), fields.y.at(x, y)) / here;
  const auto value = [&](double t) { return cubic_at(fields.other, x, y, t * normal); };
  const double end = kInPixel / normal.cwiseAbs().maxCoeff();
  double low = -end, high = end, at_low = value(low), at_high = value(high);
  if (!(at_low > 0 && at_high < 0)) return std::nullopt;  // falls towards what is brighter
  double t = 0;
  for (int i = 0; i < 8; ++i) {
    t = i % 2 == 0 ? (low + high) / 2 : low + (high - low) * at_low / (at_low - at_high);
    const double v = value(t);
    (v > 0 ? low : high) = t;
    (v > 0 ? at_low : at_high) = v;
  }
  if (!lies_in_pixel(t * normal)) return std::nullopt;
  const double slope = (value(t + 0.5) - value(t - 0.5));
  if (!(slope < 0)) return std::nullopt;
  return EdgePoint{position(fields, x, y, t * normal), normal, here, -fields.laplacian_noise / slope};
}

std::optional<EdgePoint> facet_zero(const Fields& fields, int x, int y) {
  const double here = fields.strength.at(x, y);
  const Vector2d n = Vector2d(fields.x.at(x, y), fields.y.at(x, y)) / here;
  const auto& fit = facet_weights();
  // f(t) = ... + second t^2 + third t^3 along the gradient
  const std::array<double, 10> along{0,
                                     0,
                                     0,
                                     n.x() * n.x(),
                                     n.x() * n.y(),
                                     n.y() * n.y(),
                                     n.x() * n.x() * n.x(),
                                     n.x() * n.x() * n.y(),
                                     n.x() * n.y() * n.y(),
                                     n.y() * n.y() * n.y()};
  Weights5 of_second{}, of_third{};
  double second = 0, third = 0;
  for (std::size_t p = 0; p < 25; ++p) {
    for (std::size_t k = 3; k < 6; ++k) of_second[p] += along[k] * fit[k][p];
    for (std::size_t k = 6; k < 10; ++k) of_third[p] += along[k] * fit[k][p];
    const double grey = fields.other.at(x + int(p) % 5 - 2, y + int(p) / 5 - 2);
    second += of_second[p] * grey;
    third += of_third[p] * grey;
  }
  if (!(third < 0)) return std::nullopt;
  const double t = -second / (3 * third);
  if (!lies_in_pixel(t * n)) return std::nullopt;
  Weights5 of_t;
  for (std::size_t p = 0; p < 25; ++p) of_t[p] = -(of_second[p] + 3 * t * of_third[p]) / (3 * third);
  return EdgePoint{position(fields, x, y, t * n), n, here, std::sqrt(fields.noise.covariance(of_t))};
}

// --- the whole image
// --------------------------------------------------------------------------------------------------

// What the errors of two points of a vertical edge, one pixel apart, have in common, as a length.
double along_edge_px(const Fields& fields, EdgeOperator of, double sigma_px) {
  double correlation = 0;
  if (of == EdgeOperator::kLog) return sigma_px;  // exactly, of a Gaussian
  Weights5 weights{};
  if (of == EdgeOperator::kHaralick) {
    weights = facet_weights()[3];
  } else {
    for (int i = 0; i < 9; ++i)
      for (int k = 0; k < 9; ++k)
        weights[std::size_t(5 * (i / 3 + k / 3) + i % 3 + k % 3)] +=
            paraboloid_weights()[1][std::size_t(i)] * fields.masks.x[std::size_t(k)];
  }
  correlation = fields.noise.covariance(weights, 2) / fields.noise.covariance(weights);
  return correlation > 0 ? std::sqrt(-1 / std::log(correlation)) : 0.5;
}

void add_maps(const FloatImage& image, const Fields& fields, EdgeOperator of, double sigma_px, EdgeMap& map) {
  map.amplitude = fields.strength;
  map.direction_rad = FloatImage(image.width, image.height);
  for (std::size_t i = 0; i < fields.x.data.size(); ++i)
    map.direction_rad.data[i] = std::atan2(fields.y.data[i], fields.x.data[i]);
  const std::vector<EdgeMask> masks = edge_masks(of);
  if (masks.size() < 8) return;
  const FloatImage smooth = smoothed(image, sigma_px);
  std::fill(map.amplitude.data.begin(), map.amplitude.data.end(), 0.f);
  for (std::size_t m = 0; m < masks.size(); ++m) {
    const FloatImage response = masked(smooth, masks[m]);
    const auto direction = float(std::remainder(-std::numbers::pi / 2 - double(m) * std::numbers::pi / 4,
                                                2 * std::numbers::pi));  // the first increases upwards
    for (std::size_t i = 0; i < response.data.size(); ++i)
      if (const float amplitude = response.data[i] / float(compass_scale(of)); amplitude > map.amplitude.data[i]) {
        map.amplitude.data[i] = amplitude;
        map.direction_rad.data[i] = direction;
      }
  }
}

// The amplitude that this share of the pixels reaches; of large images of some of their rows.
double exceeded_by(const FloatImage& strength, double share) {
  if (share >= 1) return 0;
  std::vector<float> some;
  const int stride = std::min(strength.height, 1 + int(strength.data.size() / 2'000'000));
  for (int y = stride / 2; y < strength.height; y += stride)
    some.insert(some.end(), strength.row(y), strength.row(y) + strength.width);
  const auto at = some.begin() + std::ptrdiff_t((1 - share) * double(some.size() - 1));
  std::ranges::nth_element(some, at);
  return *at;
}

}  // namespace

FloatImage smoothed(const FloatImage& image, double sigma_px) {
  if (!(sigma_px > 0.05)) return image;
  const std::vector<double> g = gaussian_kernel(sigma_px, 0);
  return separable(image, g, g);
}

FloatImage as_float(const GreyImage& image) {
  FloatImage out(image.width, image.height);
  std::copy(image.data.begin(), image.data.end(), out.data.begin());
  return out;
}

double noise_of(const FloatImage& image) {
  std::vector<float> left;
  const std::size_t stride = 1 + image.data.size() / 2'000'000;
  for (int y = 1; y + 1 < image.height; y += int(stride))
    for (int x = 1; x + 1 < image.width; ++x) {
      const auto at = [&](int dx, int dy) { return image.at(x + dx, y + dy); };
      left.push_back(std::abs(at(-1, -1) + at(1, -1) + at(-1, 1) + at(1, 1) -
                              2 * (at(0, -1) + at(0, 1) + at(-1, 0) + at(1, 0)) + 4 * at(0, 0)));
    }
  if (left.empty()) return kLeastNoiseGrey;
  return std::max(kLeastNoiseGrey, double(median(left)) / (0.67449 * 6));
}

EdgeMap detect_edges(const FloatImage& image, const EdgeOptions& options) {
  EdgeMap map;
  const EdgeOperator of = options.edge_operator;
  const double sigma_px = of == EdgeOperator::kLog ? std::max(0.5, options.sigma_px.value_or(default_sigma(of)))
                                                   : options.sigma_px.value_or(default_sigma(of));
  map.noise_grey = options.noise_grey.value_or(noise_of(image));
  if (image.width < 7 || image.height < 7) {
    map.amplitude = map.direction_rad = FloatImage(image.width, image.height);
    return map;
  }
  const Fields fields = fields_of(image, of, sigma_px);
  const double noise = map.noise_grey * slope_noise(fields, of, sigma_px);
  const double by_image = std::max(kNoiseTimes * noise, exceeded_by(fields.strength, options.most_edges));
  map.high = options.high.value_or(options.low ? std::max(*options.low, by_image) : by_image);
  map.low = std::min(map.high, options.low.value_or(map.high / 2));
  map.along_px = along_edge_px(fields, of, sigma_px);
  std::vector<PixelEdge> found;
  const int border = 3 + int(std::ceil(2 * sigma_px));  // repeated borders bend edges
  for (int y = border; y < image.height - border; ++y)
    for (int x = border; x < image.width - border; ++x) {
      if (!(fields.strength.at(x, y) >= float(map.low)) || fields.strength.at(x, y) <= 0) continue;
      auto point = of == EdgeOperator::kLog        ? laplacian_zero(fields, x, y)
                   : of == EdgeOperator::kHaralick ? facet_zero(fields, x, y)
                                                   : slope_maximum(fields, x, y);
      if (!point) continue;
      point->sigma_px = std::hypot(point->sigma_px * map.noise_grey, model_px(of));
      found.push_back({x, y, *point});
    }
  link_edges(found, image.width, image.height, map.high, std::size_t(options.shortest), map);
  add_maps(image, fields, of, sigma_px, map);
  return map;
}

}  // namespace collinea
