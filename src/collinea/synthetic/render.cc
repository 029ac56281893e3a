// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/render.h"

#include <array>
#include <cmath>

#include "collinea/base/parallel.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr int kBandRows = 16;
constexpr std::uint32_t kSky = ~std::uint32_t{0}, kNothing = kSky - 1;

// What a pixel shows, so that neighbours that show different things are recognised.
std::uint32_t key_of(const Hit& hit, bool sunlit) {
  return (std::uint32_t(hit.solid + 1) << 5) | (std::uint32_t(hit.face) << 1) | std::uint32_t(sunlit);
}

// Light that reaches the sensor before the lens blurs it, and what each pixel shows.
struct Exposed {
  Raster<Colour> light;
  Raster<std::uint32_t> key;
};

class Photographer {
 public:
  Photographer(const Truth& truth, ImageId image, const PixelRays& rays, int width, RowRange rows)
      : scene_(truth.scene),
        rays_(rays),
        focal_px_(rays.focal_px()),
        first_row_(rows.first),
        world_from_cam_(pose_of(truth.block, image).rotation.conjugate().toRotationMatrix()),
        centre_(centre_of(pose_of(truth.block, image))),
        exposed_{Raster<Colour>(width, rows.count), Raster<std::uint32_t>(width, rows.count)} {}

  void expose_row(int row) {
    Colour* light = exposed_.light.row(row);
    std::uint32_t* key = exposed_.key.row(row);
    for (int column = 0; column < exposed_.light.width; ++column)
      light[column] = look(rays_.direction(column, first_row_ + row, 0, 0), &key[column]);
  }

  // Takes the mean of 3 x 3 rays in pixels that touch something else.
  void refine_row(int row) {
    Colour* light = exposed_.light.row(row);
    for (int column = 0; column < exposed_.light.width; ++column) {
      if (!on_edge(column, row)) continue;
      Colour sum;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
          sum = sum + look(rays_.direction(column, first_row_ + row, i / 3.0, j / 3.0), nullptr);
      light[column] = (1.0f / 9) * sum;
    }
  }

  [[nodiscard]] Raster<Colour> take_light() && { return std::move(exposed_.light); }

 private:
  [[nodiscard]] Colour look(const Eigen::Vector3d& direction_in_cam, std::uint32_t* key) const {
    if (direction_in_cam.z() == 0) {
      if (key) *key = kNothing;
      return {};
    }
    const double length = direction_in_cam.norm();
    const Eigen::Vector3d ray = world_from_cam_ * (direction_in_cam / length);
    const auto hit = scene_.cast(centre_, ray);
    if (!hit) {
      if (key) *key = kSky;
      return scene_.sky();
    }
    const bool sunlit = scene_.in_sun(hit->point, hit->normal);
    if (key) *key = key_of(*hit, sunlit);
    const double depth_m = hit->distance_m / length, slant = std::max(0.1, std::abs(hit->normal.dot(ray)));
    return scene_.shaded(*hit, depth_m / focal_px_ / std::sqrt(slant), sunlit);
  }

  [[nodiscard]] bool on_edge(int column, int row) const {
    const auto& key = exposed_.key;
    const std::uint32_t own = key.at(column, row);
    return own != key.at(std::max(column - 1, 0), row) || own != key.at(std::min(column + 1, key.width - 1), row) ||
           own != key.at(column, std::max(row - 1, 0)) || own != key.at(column, std::min(row + 1, key.height - 1));
  }

  const Scene& scene_;
  const PixelRays& rays_;
  double focal_px_;
  int first_row_;
  Eigen::Matrix3d world_from_cam_;
  Eigen::Vector3d centre_;
  Exposed exposed_;
};

template <class Work>
void for_rows_in_bands(int rows, const Run& run, const Work& work) {
  const std::size_t bands = std::size_t((rows + kBandRows - 1) / kBandRows);
  parallel_for(run, bands, [&](std::size_t band) {
    const int first = int(band) * kBandRows;
    for (int row = first; row < std::min(first + kBandRows, rows); ++row) work(row);
  });
}

std::uint8_t rounded(float grey) { return std::uint8_t(std::clamp(grey + 0.5f, 0.0f, 255.0f)); }

void write_row(const std::vector<Colour>& light, int row, const Truth& truth, const std::array<double, 3>& gain,
               const Camera& camera, Random random, std::uint8_t* out) {
  const float noise = float(truth.optics.noise_grey);
  const double cx = camera.params[Camera::kCx], cy = camera.params[Camera::kCy], dy = row + 0.5 - cy;
  const double corner =
      0.25 * (double(camera.width_px) * camera.width_px + double(camera.height_px) * camera.height_px);
  for (std::size_t x = 0; x < light.size(); ++x) {
    const double dx = double(x) + 0.5 - cx;
    const double falloff = 1 - truth.optics.vignetting * (dx * dx + dy * dy) / corner;
    const float grain = noise * quick_normal(random);
    out[3 * x] = rounded(tone(float(gain[0] * falloff) * light[x].r) + grain);
    out[3 * x + 1] = rounded(tone(float(gain[1] * falloff) * light[x].g) + grain);
    out[3 * x + 2] = rounded(tone(float(gain[2] * falloff) * light[x].b) + grain);
  }
}

constexpr int kToneSteps = 4096;

// Knots evenly spread in light.
std::array<float, kToneSteps + 2> tone_table() {
  std::array<float, kToneSteps + 2> table;
  for (int i = 0; i < kToneSteps + 2; ++i)
    table[std::size_t(i)] = float(255 * std::pow(std::min(1.0, double(i) / kToneSteps), 1 / 2.2));
  return table;
}

}  // namespace

std::vector<float> gaussian_weights(double sigma_px) {
  const int radius = sigma_px > 0 ? int(std::ceil(3 * sigma_px)) : 0;
  std::vector<float> weights;
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) sum += std::exp(-0.5 * i * i / std::max(1e-9, sigma_px * sigma_px));
  for (int i = -radius; i <= radius; ++i)
    weights.push_back(float(std::exp(-0.5 * i * i / std::max(1e-9, sigma_px * sigma_px)) / sum));
  return weights;
}

void blur_row(const Raster<Colour>& light, int row, const std::vector<float>& weights, std::vector<Colour>& vertical,
              std::vector<Colour>& out) {
  const int radius = int(weights.size()) / 2, width = light.width;
  vertical.assign(std::size_t(width + 2 * radius), Colour{});
  for (int j = -radius; j <= radius; ++j) {
    const Colour* source = light.row(std::clamp(row + j, 0, light.height - 1));
    const float weight = weights[std::size_t(j + radius)];
    for (int x = 0; x < width; ++x)
      vertical[std::size_t(x + radius)] = vertical[std::size_t(x + radius)] + weight * source[x];
  }
  for (int x = 0; x < radius; ++x) {
    vertical[std::size_t(x)] = vertical[std::size_t(radius)];
    vertical[std::size_t(width + radius + x)] = vertical[std::size_t(width + radius - 1)];
  }
  out.assign(std::size_t(width), Colour{});
  for (int x = 0; x < width; ++x)
    for (int i = 0; i <= 2 * radius; ++i)
      out[std::size_t(x)] = out[std::size_t(x)] + weights[std::size_t(i)] * vertical[std::size_t(x + i)];
}

float quick_normal(Random& random) {
  const std::uint64_t bits = random.bits();
  const int sum = int(bits & 0xffff) + int((bits >> 16) & 0xffff) + int((bits >> 32) & 0xffff) + int(bits >> 48);
  return float(sum - 131070) * (1.7320508f / 65536);
}

float tone(float light) {
  static const std::array<float, kToneSteps + 2> table = tone_table();
  const float at = std::clamp(light, 0.0f, 1.0f) * kToneSteps;
  const auto i = std::size_t(at);
  return table[i] + (at - float(i)) * (table[i + 1] - table[i]);
}

RayTable::RayTable(const Camera& camera, const Run& run)
    : camera_(camera), directions_(2 * std::size_t(camera.width_px) * std::size_t(camera.height_px)) {
  const std::size_t width = std::size_t(camera.width_px);
  parallel_for(run, std::size_t(camera.height_px), [&](std::size_t row) {
    float* out = directions_.data() + 2 * row * width;
    for (std::size_t column = 0; column < width; ++column) {
      const Eigen::Vector2d direction = normalized(camera_, {double(column) + 0.5, double(row) + 0.5});
      out[2 * column] = float(direction.x());
      out[2 * column + 1] = float(direction.y());
    }
  });
}

Eigen::Vector3d RayTable::direction(int column, int row, double dx, double dy) const {
  const std::size_t width = std::size_t(camera_.width_px);
  const float* own = directions_.data() + 2 * (std::size_t(row) * width + std::size_t(column));
  Eigen::Vector3d direction(own[0], own[1], 1);
  if (dx != 0) {
    const float* side = column + 1 < camera_.width_px ? own + 2 : own - 2;
    const double share = side > own ? dx : -dx;
    direction.x() += share * (side[0] - own[0]);
    direction.y() += share * (side[1] - own[1]);
  }
  if (dy != 0) {
    const float* side = row + 1 < camera_.height_px ? own + 2 * width : own - 2 * width;
    const double share = side > own ? dy : -dy;
    direction.x() += share * (side[0] - own[0]);
    direction.y() += share * (side[1] - own[1]);
  }
  return direction;
}

Raster<Colour> exposed_light(const Truth& truth, ImageId image, const PixelRays& rays, int width, RowRange rows,
                             const Run& run) {
  Photographer photographer(truth, image, rays, width, rows);
  for_rows_in_bands(rows.count, run, [&](int row) { photographer.expose_row(row); });
  for_rows_in_bands(rows.count, run, [&](int row) { photographer.refine_row(row); });
  return std::move(photographer).take_light();
}

Result<ColourImage> render(const Truth& truth, ImageId image, const RayTable& rays, const Run& run) {
  const Camera& camera = rays.camera();
  const Raster<Colour> light = exposed_light(truth, image, rays, camera.width_px, {0, camera.height_px}, run);
  ColourImage raster(camera.width_px, camera.height_px, 3);
  const std::vector<float> weights = gaussian_weights(truth.optics.blur_px);
  std::array<double, 3> gain;
  gain.fill(truth.exposure.at(image));
  if (const auto white = truth.white.find(image); white != truth.white.end())
    for (std::size_t c = 0; c < 3; ++c) gain[c] *= white->second[c];
  for_rows_in_bands(camera.height_px, run, [&](int row) {
    thread_local std::vector<Colour> vertical, blurred;
    blur_row(light, row, weights, vertical, blurred);
    const std::uint64_t item = (std::uint64_t{image.value} + 1) * 100000 + std::uint64_t(row);
    write_row(blurred, row, truth, gain, camera, Random(truth.seed, item), raster.row(row));
  });
  if (run.stopped()) return fail(Errc::kCancelled, "rendering was stopped");
  return raster;
}

}  // namespace collinea
