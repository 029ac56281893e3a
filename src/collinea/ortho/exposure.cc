// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/exposure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "collinea/base/median.h"
#include "collinea/base/parallel.h"

namespace collinea {
namespace {

using PairKey = std::pair<std::uint32_t, std::uint32_t>;
struct Common {
  const ColourSample *first, *second;
};
using Pairs = std::map<PairKey, std::vector<Common>>;

struct Ratio {  // log second / log first of one pair of pictures
  std::size_t first, second;
  double difference, weight;
};

constexpr std::size_t kFewest = 5;  // places that make a pair
constexpr std::size_t kMost = 400;  // more tell nothing new

Pairs pairs_of(std::span<const std::vector<ColourSample>> samples) {
  struct Seen {
    std::uint32_t place, picture;
    const ColourSample* sample;
  };
  std::vector<Seen> all;
  for (std::size_t i = 0; i < samples.size(); ++i)
    for (const ColourSample& s : samples[i]) all.push_back({s.place, std::uint32_t(i), &s});
  std::sort(all.begin(), all.end(),
            [](const Seen& a, const Seen& b) { return std::pair(a.place, a.picture) < std::pair(b.place, b.picture); });
  Pairs pairs;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].place == all[begin].place) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = i + 1; j < end; ++j) {
        auto& common = pairs[{all[i].picture, all[j].picture}];
        if (common.size() < kMost) common.push_back({all[i].sample, all[j].sample});
      }
    }
  }
  std::erase_if(pairs, [](const auto& pair) { return pair.second.size() < kFewest; });
  return pairs;
}

double difference(const Common& c, std::size_t channel) {
  return double(c.second->log_colour[channel]) - double(c.first->log_colour[channel]);
}

// Within a pair the gains are the same for all places, so what differs from the median ratio is the fall-off of the
// lens.
double falloff_of(const Pairs& pairs, std::span<const CameraId> cameras, CameraId camera, std::size_t channel) {
  std::vector<std::pair<double, double>>
      points;  // difference of r2, of the logarithm; both about the medians of their pair
  std::vector<double> radii, colours;
  for (const auto& [key, common] : pairs) {
    if (cameras[key.first] != camera || cameras[key.second] != camera) continue;
    radii.clear(), colours.clear();
    for (const Common& c : common) {
      radii.push_back(double(c.second->r2) - double(c.first->r2));
      colours.push_back(difference(c, channel));
    }
    const double radius = median(radii), colour = median(colours);
    for (const Common& c : common)
      points.emplace_back(double(c.second->r2) - double(c.first->r2) - radius, difference(c, channel) - colour);
  }
  double slope = 0;
  for (int round = 0; round < 8; ++round) {
    double xx = 1, xy = 0;  // a weak belief in a lens without fall-off
    for (const auto& [x, y] : points) {
      const double residual = std::abs(y - slope * x), weight = residual < 0.05 ? 1 : 0.05 / residual;
      xx += weight * x * x, xy += weight * x * y;
    }
    slope = xy / xx;
  }
  return std::clamp(-slope, -0.2, 1.0);
}

std::vector<Ratio> ratios_of(const Pairs& pairs, std::span<const double> falloff, std::size_t channel) {
  std::vector<Ratio> ratios;
  std::vector<double> differences;
  for (const auto& [key, common] : pairs) {
    differences.clear();
    for (const Common& c : common)
      differences.push_back(difference(c, channel) + falloff[key.second] * double(c.second->r2) -
                            falloff[key.first] * double(c.first->r2));
    ratios.push_back({key.first, key.second, median(differences), double(std::min<std::size_t>(common.size(), 100))});
  }
  return ratios;
}

// Normal equations (N + D) x = b of all ratios, applied without being formed: N is the weighted Laplacian of the pairs,
// D the pull towards 0.
struct Normals {
  const std::vector<Ratio>& ratios;
  const std::vector<double>& weights;
  std::vector<double> diagonal, pull, right;

  Normals(std::size_t size, const std::vector<Ratio>& r, const std::vector<double>& w)
      : ratios(r), weights(w), diagonal(size), pull(size), right(size) {
    for (std::size_t k = 0; k < ratios.size(); ++k) {
      diagonal[ratios[k].first] += weights[k], diagonal[ratios[k].second] += weights[k];
      right[ratios[k].first] -= weights[k] * ratios[k].difference;
      right[ratios[k].second] += weights[k] * ratios[k].difference;
    }
    for (std::size_t i = 0; i < size; ++i) {
      pull[i] = 0.002 * diagonal[i] + 1e-3;
      diagonal[i] += pull[i];
    }
  }
  [[nodiscard]] std::vector<double> times(const std::vector<double>& x) const {
    std::vector<double> y(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = pull[i] * x[i];
    for (std::size_t k = 0; k < ratios.size(); ++k) {
      const double flow = weights[k] * (x[ratios[k].second] - x[ratios[k].first]);
      y[ratios[k].first] -= flow, y[ratios[k].second] += flow;
    }
    return y;
  }
};

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

// Conjugate gradients, preconditioned by the diagonal.
std::vector<double> solve(const Normals& normals) {
  const std::size_t n = normals.right.size();
  std::vector<double> x(n), r = normals.right, z(n), p(n);
  double previous = 0;
  for (int step = 0; step < 2000; ++step) {
    for (std::size_t i = 0; i < n; ++i) z[i] = r[i] / normals.diagonal[i];
    const double now = dot(r, z);
    if (!(now > 1e-18 * double(n))) break;
    for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + (step == 0 ? 0 : now / previous) * p[i];
    const std::vector<double> q = normals.times(p);
    const double length = now / dot(p, q);
    for (std::size_t i = 0; i < n; ++i) x[i] += length * p[i], r[i] -= length * q[i];
    previous = now;
  }
  return x;
}

std::vector<double> log_brightness(std::size_t pictures, const std::vector<Ratio>& ratios) {
  constexpr double kLargest =
      0.05;  // a pair that contradicts its neighbours by more shows something that moved or shines
  std::vector<double> weights, x(pictures);
  for (const Ratio& ratio : ratios) weights.push_back(ratio.weight);
  for (int round = 0; round < 4; ++round) {
    x = solve(Normals(pictures, ratios, weights));
    for (std::size_t k = 0; k < ratios.size(); ++k) {
      const double residual = std::abs(x[ratios[k].second] - x[ratios[k].first] - ratios[k].difference);
      weights[k] = ratios[k].weight * (residual < kLargest ? 1 : kLargest / residual);
    }
  }
  return x;
}

std::optional<ColourSample> sample_at(const View& view, const ColourImage& picture, const Eigen::Vector3d& place) {
  const auto pixel = pixel_of(view, place);
  if (!pixel || !well_inside(view, *pixel)) return std::nullopt;
  ColourSample sample;
  sample.r2 = float(relative_radius2(view.camera, *pixel));
  for (int c = 0; c < 3; ++c) {
    const float value = bilinear(picture, pixel->x() * picture.width / view.camera.width_px,
                                 pixel->y() * picture.height / view.camera.height_px, c);
    if (value < 10 || value > 245) return std::nullopt;  // cut off, or nothing but noise
    sample.log_colour[std::size_t(c)] = std::log(value);
  }
  return sample;
}

}  // namespace

std::array<float, 3> factor_of(const Exposure& exposure, float relative_radius2) {
  std::array<float, 3> factor = exposure.gain;
  for (std::size_t c = 0; c < 3; ++c)
    if (exposure.falloff[c] != 0) factor[c] *= std::exp(exposure.falloff[c] * relative_radius2);
  return factor;
}

double relative_radius2(const Camera& camera, const Eigen::Vector2d& pixel) {
  const double half_width = camera.width_px / 2.0, half_height = camera.height_px / 2.0;
  const double x = pixel.x() - half_width, y = pixel.y() - half_height;
  return (x * x + y * y) / (half_width * half_width + half_height * half_height);
}

std::vector<Exposure> balance_exposures(std::span<const std::vector<ColourSample>> samples,
                                        std::span<const CameraId> cameras) {
  const std::size_t pictures = samples.size();
  std::vector<Exposure> exposures(pictures);
  const Pairs pairs = pairs_of(samples);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::map<CameraId, double> falloff_of_camera;
    for (const CameraId camera : cameras)
      if (!falloff_of_camera.contains(camera)) falloff_of_camera[camera] = falloff_of(pairs, cameras, camera, channel);
    std::vector<double> falloff;
    for (const CameraId camera : cameras) falloff.push_back(falloff_of_camera.at(camera));
    const std::vector<double> brightness = log_brightness(pictures, ratios_of(pairs, falloff, channel));
    for (std::size_t i = 0; i < pictures; ++i) {
      exposures[i].gain[channel] = float(std::exp(-std::clamp(brightness[i], -0.7, 0.7)));
      exposures[i].falloff[channel] = float(falloff[i]);
    }
  }
  return exposures;
}

Result<std::vector<Exposure>> exposures_of(const std::vector<View>& views,
                                           std::span<const Eigen::Vector3d> places_in_world, const PixelSource& pixels,
                                           const Run& run) {
  std::vector<std::vector<ColourSample>> samples(views.size());
  std::vector<Result<>> results(views.size());
  parallel_for(run, views.size(), [&](std::size_t i) {
    const auto picture = pixels(views[i].image, 8);
    if (!picture) {
      results[i] = tl::unexpected(picture.error());
      return;
    }
    for (std::size_t place = 0; place < places_in_world.size(); ++place) {
      auto sample = sample_at(views[i], *picture, places_in_world[place]);
      if (!sample) continue;
      sample->place = std::uint32_t(place);
      samples[i].push_back(*sample);
    }
  });
  if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
  for (auto& result : results)
    if (!result) return tl::unexpected(std::move(result).error());
  std::vector<CameraId> cameras;
  for (const View& view : views) cameras.push_back(view.camera_id);
  return balance_exposures(samples, cameras);
}

}  // namespace collinea
