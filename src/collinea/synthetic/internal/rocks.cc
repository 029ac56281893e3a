// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/rocks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/building.h"
#include "collinea/synthetic/internal/noise.h"

namespace collinea {
namespace {

// Octaves of halved spacing. An octave's slopes are kPersistence / 0.5 of those of the one before: nearly alike, so
// that the ground is as steep under a stone as over a mountain.
constexpr double kCoarsest_m = 600, kFinest_m = 1, kShare = 0.45, kPersistence = 0.48;
// Strata: beds by turns soft and hard, whose slopes are 1 - kBench and 1 + kBench of what the erosion left.
constexpr double kBed_m = 18, kBench = 0.65, kBedWave_m = 90, kBedShift_m = 7;

constexpr double kDistrict_m = 420;  // size of the largest parts of brighter and darker rock

double rock_height(double x, double y, double relief_m, std::uint32_t seed) {
  double sum = 0, amplitude = kShare * relief_m, u = x, v = y;
  for (double spacing_m = kCoarsest_m; spacing_m > kFinest_m; spacing_m /= 2, amplitude *= kPersistence) {
    sum += amplitude * smooth_noise(u / spacing_m, v / spacing_m, ++seed);
    const double turned = 0.8 * u - 0.6 * v;
    v = 0.6 * u + 0.8 * v;
    u = turned;
  }
  const double bed = sum + kBedShift_m * smooth_noise(x / kBedWave_m, y / kBedWave_m, seed + 1);
  const double rate = 2 * std::numbers::pi / kBed_m;
  return sum + kBench * std::min(1.0, relief_m / kBed_m) * std::sin(rate * bed) / rate;
}

std::vector<Solid> few_houses(const CountryOptions& o, const Heightfield& terrain, Random& random) {
  std::vector<Solid> houses;
  if (o.building_area_m2 <= 0) return houses;
  const Eigen::Vector2d size = o.built_high - o.built_low;
  const int wanted = int(std::lround(size.x() * size.y() / o.building_area_m2));
  for (int trial = 0; trial < 20 * wanted && int(houses.size()) < wanted; ++trial) {
    const double x = random.uniform(o.built_low.x(), o.built_high.x()),
                 y = random.uniform(o.built_low.y(), o.built_high.y());
    Solid house = random_building(random, x, y, random.uniform(0, std::numbers::pi));
    const bool has_room = std::none_of(houses.begin(), houses.end(), [&](const Solid& other) {
      return std::hypot(x - other.x, y - other.y) < house.radius_m() + other.radius_m() + 2;
    });
    if (!has_room) continue;
    found(house, terrain);
    houses.push_back(house);
  }
  return houses;
}

}  // namespace

Scene make_rocks(const CountryOptions& options) {
  Random random(options.seed, 103);
  const auto seed = std::uint32_t(random.bits());
  Heightfield terrain =
      terrain_of(options, [&](double x, double y) { return rock_height(x, y, options.relief_m, seed); });
  Ground ground;
  ground.kind = Ground::Kind::kRocks;
  ground.seed = seed + 1000;
  ground.district_m = kDistrict_m;
  std::vector<Solid> houses = few_houses(options, terrain, random);
  return {std::move(terrain), std::move(ground), std::move(houses),
          sunlight(options.sun_azimuth_deg, options.sun_elevation_deg)};
}

}  // namespace collinea
