// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/village.h"

#include <array>
#include <cmath>
#include <numbers>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/noise.h"

namespace collinea {
namespace {

// Value noise with continuous second derivatives: hills without creases.
double smooth_noise(double x, double y, std::uint32_t seed) {
  const auto ease = [](double t) { return t * t * t * (t * (6 * t - 15) + 10); };
  const int ix = floor_int(x), iy = floor_int(y);
  const double u = ease(x - ix), v = ease(y - iy);
  const auto at = [&](int i, int j) { return double(lattice_value(ix + i, iy + j, seed)); };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

double hill_height(double x, double y, double relief_m, std::uint32_t seed) {
  struct Octave {
    double spacing_m, share;
  };
  constexpr std::array<Octave, 5> kOctaves = {{{130, 0.62}, {55, 0.22}, {22, 0.07}, {8, 0.015}, {1.7, 0.006}}};
  double sum = 0, u = x, v = y;
  for (std::size_t i = 0; i < kOctaves.size(); ++i) {
    sum +=
        kOctaves[i].share * smooth_noise(u / kOctaves[i].spacing_m, v / kOctaves[i].spacing_m, seed + std::uint32_t(i));
    const double turned = 0.8 * u - 0.6 * v;
    v = 0.6 * u + 0.8 * v;
    u = turned;
  }
  return relief_m * sum;
}

Heightfield make_hills(const VillageOptions& o, std::uint32_t seed) {
  const int width = int(std::ceil((o.high.x() - o.low.x()) / o.cell_m)) + 2;
  const int height = int(std::ceil((o.high.y() - o.low.y()) / o.cell_m)) + 2;
  const double datum = hill_height(0, 0, o.relief_m, seed);
  std::vector<float> heights;
  heights.reserve(std::size_t(width) * std::size_t(height));
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column)
      heights.push_back(
          float(hill_height(o.low.x() + column * o.cell_m, o.low.y() + row * o.cell_m, o.relief_m, seed) - datum));
  return {o.low.x(), o.low.y(), o.cell_m, width, height, std::move(heights)};
}

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

constexpr std::array<Colour, 4> kTileColours = {
    {{0.36f, 0.13f, 0.08f}, {0.27f, 0.11f, 0.08f}, {0.16f, 0.15f, 0.16f}, {0.32f, 0.19f, 0.11f}}};
constexpr std::array<Colour, 4> kWallColours = {
    {{0.58f, 0.55f, 0.48f}, {0.52f, 0.42f, 0.28f}, {0.45f, 0.45f, 0.44f}, {0.55f, 0.36f, 0.28f}}};

Solid random_building(Random& random, double x, double y, double heading) {
  Solid s;
  s.x = x;
  s.y = y;
  s.cosine = std::cos(heading);
  s.sine = std::sin(heading);
  s.seed = std::uint32_t(random.bits());
  s.wall = Finish::kHouseWall;
  s.wall_colour = kWallColours[random.below(4)];
  if (random.uniform() < 0.68) {
    s.shape = Solid::Shape::kGable;
    s.half_length_m = random.uniform(4.5, 8);
    s.half_width_m = random.uniform(3.5, 5);
    s.eave_m = random.uniform(3, 6.5);
    s.ridge_m = s.eave_m + s.half_width_m * random.uniform(0.6, 1.0);
    s.roof = Finish::kTiles;
    s.roof_colour = kTileColours[random.below(4)];
  } else {
    s.half_length_m = random.uniform(6, 11);
    s.half_width_m = random.uniform(4.5, 7);
    s.eave_m = s.ridge_m = random.uniform(4, 13.5);
    s.roof = Finish::kGravelRoof;
    const float grey = float(random.uniform(0.2, 0.36));
    s.roof_colour = {grey, grey * 0.98f, grey * 0.94f};
  }
  return s;
}

// Sets a building on the terrain: its walls reach into the ground, heights count from the highest ground it touches.
void found(Solid& s, const Heightfield& terrain) {
  double low = 1e30, high = -1e30;
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j) {
      const double u = i * s.half_length_m / 2, v = j * s.half_width_m / 2;
      const double z = terrain.height(s.x + s.cosine * u - s.sine * v, s.y + s.sine * u + s.cosine * v);
      low = std::min(low, z);
      high = std::max(high, z);
    }
  s.bottom_m = low - 1;
  s.eave_m += high;
  s.ridge_m += high;
}

// A chimney through a gabled roof, or a plant room on a flat one.
Solid on_roof(const Solid& house, Random& random) {
  const bool gable = house.shape == Solid::Shape::kGable;
  const double u = random.uniform(-0.6, 0.6) * house.half_length_m;
  const double v = (gable ? random.uniform(0.15, 0.4) : random.uniform(-0.5, 0.5)) * house.half_width_m;
  Solid s = house;
  s.shape = Solid::Shape::kBox;
  s.x = house.x + house.cosine * u - house.sine * v;
  s.y = house.y + house.sine * u + house.cosine * v;
  s.half_length_m = gable ? 0.4 : random.uniform(0.8, 2.0);
  s.half_width_m = gable ? 0.3 : random.uniform(0.8, 1.6);
  s.bottom_m = house.eave_m - 0.5;
  s.eave_m = s.ridge_m = gable ? house.ridge_m + random.uniform(0.4, 1.0) : house.eave_m + random.uniform(0.8, 2.2);
  s.wall = gable ? Finish::kBrick : Finish::kPlaster;
  s.roof = Finish::kPlaster;
  s.wall_colour = gable ? Colour{0.3f, 0.14f, 0.1f} : Colour{0.5f, 0.5f, 0.5f};
  s.roof_colour = gable ? Colour{0.2f, 0.18f, 0.17f} : Colour{0.4f, 0.42f, 0.44f};
  s.seed = std::uint32_t(random.bits());
  return s;
}

bool has_room(const Solid& s, const std::vector<Solid>& others, const std::vector<Road>& roads) {
  for (const Road& road : roads)
    if (std::abs(road.off_and_along(s.x, s.y).x()) < road.half_width_m + 2 + s.radius_m()) return false;
  for (const Solid& other : others)
    if (std::hypot(s.x - other.x, s.y - other.y) < s.radius_m() + other.radius_m() + 2) return false;
  return true;
}

std::vector<Solid> make_buildings(const VillageOptions& o, const Heightfield& terrain, const std::vector<Road>& roads,
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

Scene make_village(const VillageOptions& options) {
  Random random(options.seed, 101);
  const auto seed = std::uint32_t(random.bits());
  Heightfield terrain = make_hills(options, seed);
  Ground ground;
  ground.seed = seed + 1000;
  ground.roads = make_roads(random);
  std::vector<Solid> buildings = make_buildings(options, terrain, ground.roads, random);
  return {std::move(terrain), std::move(ground), std::move(buildings),
          sunlight(options.sun_azimuth_deg, options.sun_elevation_deg)};
}

}  // namespace collinea
