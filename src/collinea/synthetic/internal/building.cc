// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/building.h"

#include <array>
#include <cmath>

namespace collinea {
namespace {

constexpr std::array<Colour, 4> kTileColours = {
    {{0.36f, 0.13f, 0.08f}, {0.27f, 0.11f, 0.08f}, {0.16f, 0.15f, 0.16f}, {0.32f, 0.19f, 0.11f}}};
constexpr std::array<Colour, 4> kWallColours = {
    {{0.58f, 0.55f, 0.48f}, {0.52f, 0.42f, 0.28f}, {0.45f, 0.45f, 0.44f}, {0.55f, 0.36f, 0.28f}}};

}  // namespace

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

}  // namespace collinea
