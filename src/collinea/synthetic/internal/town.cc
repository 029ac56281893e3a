// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/town.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/building.h"
#include "collinea/synthetic/internal/noise.h"

namespace collinea {
namespace {

constexpr double kGarden_m = 13;      // mean size of a garden
constexpr double kDistrict_m = 260;   // size of the largest parts of brighter and darker land
constexpr double kTreeArea_m2 = 260;  // land for one tree
constexpr double kSquare_m = 32;      // of the index: above the diameters of two halls and the space between
constexpr int kTrialsPerHouse = 12;
constexpr int kLobes = 4;  // of a crown, beside its middle

// Bodies by where they stand.
class Plan {
 public:
  void add(const Solid& solid) {
    squares_[square_of(solid.x, solid.y)].push_back({solid.x, solid.y, solid.radius_m()});
  }
  // Whether a disc keeps that distance from the circles round all bodies.
  [[nodiscard]] bool is_free(double x, double y, double radius_m, double distance_m) const {
    const auto [column, row] = square_of(x, y);
    for (int j = row - 1; j <= row + 1; ++j)
      for (int i = column - 1; i <= column + 1; ++i) {
        const auto found = squares_.find({i, j});
        if (found == squares_.end()) continue;
        for (const Disc& disc : found->second)
          if (std::hypot(x - disc.x, y - disc.y) < radius_m + disc.radius_m + distance_m) return false;
      }
    return true;
  }

 private:
  struct Disc {
    double x, y, radius_m;
  };
  static std::pair<int, int> square_of(double x, double y) {
    return {floor_int(x / kSquare_m), floor_int(y / kSquare_m)};
  }

  std::map<std::pair<int, int>, std::vector<Disc>> squares_;
};

// Two families of streets that cross, each of parallel ones.
std::vector<Road> make_streets(Random& random) {
  std::vector<Road> streets;
  const double first = random.uniform(0.15, 0.5);
  for (int i = 0; i < 2; ++i) {
    const double heading = first + i * random.uniform(1.45, 1.7);
    Road street{std::cos(heading),    std::sin(heading),        random.uniform(-12, 12),
                random.uniform(3, 7), random.uniform(280, 400), i == 0 ? 3.6 : 2.9};
    street.repeat_m = i == 0 ? random.uniform(58, 70) : random.uniform(95, 120);
    streets.push_back(street);
  }
  return streets;
}

bool is_off_streets(const std::vector<Road>& streets, double x, double y, double distance_m) {
  return std::all_of(streets.begin(), streets.end(), [&](const Road& street) {
    return std::abs(street.off_and_along(x, y).x()) > street.half_width_m + distance_m;
  });
}

// A house beside a street, its front along it.
Solid street_house(const CountryOptions& o, const std::vector<Road>& streets, Random& random) {
  const Road& street = streets[random.below(std::uint32_t(streets.size()))];
  const double x = random.uniform(o.built_low.x(), o.built_high.x()),
               y = random.uniform(o.built_low.y(), o.built_high.y());
  const double along = street.off_and_along(x, y).y();
  Solid house =
      random_building(random, x, y, std::atan2(street.sine, street.cosine) + std::atan(street.slope_at(along)));
  const double off = street.half_width_m + random.uniform(2, 5) + house.half_width_m;
  const double v = street.cosine * y - street.sine * x;
  const int number = floor_int((v - street.offset_m) / street.repeat_m + 0.5);
  const Eigen::Vector2d at = street.position(random.uniform() < 0.5 ? off : -off, along, number);
  house.x = at.x();
  house.y = at.y();
  return house;
}

std::vector<Solid> make_houses(const CountryOptions& o, const Heightfield& terrain, const std::vector<Road>& streets,
                               Plan& plan, Random& random) {
  std::vector<Solid> houses, roof_parts;
  if (o.building_area_m2 <= 0) return houses;
  const Eigen::Vector2d size = o.built_high - o.built_low;
  const int wanted = int(std::lround(size.x() * size.y() / o.building_area_m2));
  for (int trial = 0; trial < kTrialsPerHouse * wanted && int(houses.size()) < wanted; ++trial) {
    Solid house = street_house(o, streets, random);
    // Circles about long houses in a row would leave gaps: 0.8 of them may touch.
    const double radius_m = 0.8 * house.radius_m();
    if (!is_off_streets(streets, house.x, house.y, house.half_width_m + 1) ||
        !plan.is_free(house.x, house.y, radius_m, 0))
      continue;
    found(house, terrain);
    plan.add(house);
    houses.push_back(house);
    roof_parts.push_back(on_roof(house, random));
  }
  houses.insert(houses.end(), roof_parts.begin(), roof_parts.end());
  return houses;
}

// A crown of some ellipsoids that overlap, from a metre above the ground.
void plant(double x, double y, double radius_m, double ground_m, Random& random, std::vector<Solid>& bodies) {
  Solid crown;
  crown.shape = Solid::Shape::kCrown;
  crown.roof = Finish::kLeaves;
  const float green = float(random.uniform(0.8, 1.3));
  crown.roof_colour = green * Colour{0.075f, 0.115f, 0.045f};
  const double height_m = radius_m * random.uniform(1.5, 2.3);
  const double turn = random.uniform(0, 2 * std::numbers::pi);
  for (int i = 0; i <= kLobes; ++i) {
    const double size = i == 0 ? 0.75 : random.uniform(0.4, 0.55), away = i == 0 ? 0 : (1 - size) * radius_m;
    const double azimuth = turn + 2 * std::numbers::pi * i / kLobes + random.uniform(-0.4, 0.4);
    crown.x = x + away * std::cos(azimuth);
    crown.y = y + away * std::sin(azimuth);
    crown.half_length_m = crown.half_width_m = size * radius_m;
    crown.bottom_m = ground_m + 1 + (i == 0 ? 0.1 : random.uniform(0, 0.45)) * height_m;
    crown.eave_m = crown.ridge_m = crown.bottom_m + (i == 0 ? 0.9 : 0.55) * height_m;
    crown.seed = std::uint32_t(random.bits());
    bodies.push_back(crown);
  }
}

void make_trees(const CountryOptions& o, const Heightfield& terrain, const std::vector<Road>& streets, const Plan& plan,
                Random& random, std::vector<Solid>& bodies) {
  const Eigen::Vector2d size = o.built_high - o.built_low;
  const int wanted = int(std::lround(size.x() * size.y() / kTreeArea_m2));
  for (int trial = 0; trial < wanted; ++trial) {
    const double x = random.uniform(o.built_low.x(), o.built_high.x()),
                 y = random.uniform(o.built_low.y(), o.built_high.y()), radius_m = random.uniform(1.2, 3.8);
    if (is_off_streets(streets, x, y, 0.5) && plan.is_free(x, y, radius_m, -1))
      plant(x, y, radius_m, terrain.height(x, y), random, bodies);
  }
}

}  // namespace

Scene make_town(const CountryOptions& options) {
  Random random(options.seed, 102);
  const auto seed = std::uint32_t(random.bits());
  Heightfield terrain =
      terrain_of(options, [&](double x, double y) { return hill_height(x, y, options.relief_m, seed); });
  Ground ground;
  ground.seed = seed + 1000;
  ground.district_m = kDistrict_m;
  ground.field_m = kGarden_m;
  ground.roads = make_streets(random);
  Plan plan;
  std::vector<Solid> bodies = make_houses(options, terrain, ground.roads, plan, random);
  make_trees(options, terrain, ground.roads, plan, random, bodies);
  return {std::move(terrain), std::move(ground), std::move(bodies),
          sunlight(options.sun_azimuth_deg, options.sun_elevation_deg)};
}

}  // namespace collinea
