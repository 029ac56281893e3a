// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/village.h"

#include <array>
#include <cmath>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/building.h"
#include "collinea/synthetic/internal/noise.h"

namespace collinea {
namespace {

std::vector<Road> make_roads(Random& random) {
  std::vector<Road> roads;
  const double first = random.uniform(0.15, 0.5);
  for (int i = 0; i < 2; ++i) {
    const double heading = first + i * random.uniform(1.2, 1.6);
    roads.push_back({std::cos(heading), std::sin(heading), random.uniform(-12, 12), random.uniform(4, 9),
                     random.uniform(110, 180), i == 0 ? 3.2 : 2.5});
  }
  return roads;
}

bool has_room(const Solid& s, const std::vector<Solid>& others, const std::vector<Road>& roads) {
  for (const Road& road : roads)
    if (std::abs(road.off_and_along(s.x, s.y).x()) < road.half_width_m + 2 + s.radius_m()) return false;
  for (const Solid& other : others)
    if (std::hypot(s.x - other.x, s.y - other.y) < s.radius_m() + other.radius_m() + 2) return false;
  return true;
}

std::vector<Solid> make_buildings(const CountryOptions& o, const Heightfield& terrain, const std::vector<Road>& roads,
                                  Random& random) {
  std::vector<Solid> houses, roof_parts;
  if (o.building_area_m2 <= 0) return houses;
  const Eigen::Vector2d size = o.built_high - o.built_low;
  const int wanted = int(std::lround(size.x() * size.y() / o.building_area_m2));
  for (int trial = 0; trial < 60 * wanted && int(houses.size()) < wanted; ++trial) {
    const double x = random.uniform(o.built_low.x(), o.built_high.x()),
                 y = random.uniform(o.built_low.y(), o.built_high.y());
    const Road& road = roads[random.below(std::uint32_t(roads.size()))];
    const double heading = std::atan2(road.sine, road.cosine) + random.uniform(-0.3, 0.3);
    Solid house = random_building(random, x, y, heading);
    if (!has_room(house, houses, roads)) continue;
    found(house, terrain);
    houses.push_back(house);
    roof_parts.push_back(on_roof(house, random));
  }
  houses.insert(houses.end(), roof_parts.begin(), roof_parts.end());
  return houses;
}

}  // namespace

Scene make_village(const CountryOptions& options) {
  Random random(options.seed, 101);
  const auto seed = std::uint32_t(random.bits());
  Heightfield terrain =
      terrain_of(options, [&](double x, double y) { return hill_height(x, y, options.relief_m, seed); });
  Ground ground;
  ground.seed = seed + 1000;
  ground.roads = make_roads(random);
  std::vector<Solid> buildings = make_buildings(options, terrain, ground.roads, random);
  return {std::move(terrain), std::move(ground), std::move(buildings),
          sunlight(options.sun_azimuth_deg, options.sun_elevation_deg)};
}

}  // namespace collinea
