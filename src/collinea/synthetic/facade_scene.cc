// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/facade_scene.h"
#include "collinea/synthetic/internal/noise.h"

namespace collinea {
namespace {

// Puts the wall together from boxes given by their corners.
class Mason {
 public:
  explicit Mason(std::uint32_t seed) : seed_(seed) {}

  Solid& box(double x0, double x1, double y0, double y1, double z0, double z1, Finish finish, Colour colour) {
    Solid s;
    s.x = (x0 + x1) / 2;
    s.y = (y0 + y1) / 2;
    s.half_length_m = (x1 - x0) / 2;
    s.half_width_m = (y1 - y0) / 2;
    s.bottom_m = z0;
    s.eave_m = s.ridge_m = z1;
    s.wall = s.roof = finish;
    s.wall_colour = s.roof_colour = colour;
    s.seed = seed_ + 977 * std::uint32_t(solids_.size());
    solids_.push_back(s);
    return solids_.back();
  }
  void column(double x, double y, double radius_m, double z0, double z1, Colour colour) {
    Solid& s = box(x - radius_m, x + radius_m, y - radius_m, y + radius_m, z0, z1, Finish::kPlaster, colour);
    s.shape = Solid::Shape::kColumn;
    s.half_length_m = s.half_width_m = radius_m;
  }
  std::vector<Solid> take() { return std::move(solids_); }

 private:
  std::uint32_t seed_;
  std::vector<Solid> solids_;
};

constexpr Colour kStoneColour{0.47f, 0.43f, 0.36f};
constexpr Colour kTrimColour{0.56f, 0.54f, 0.49f};
constexpr Colour kBrickColour{0.36f, 0.17f, 0.11f};
constexpr double kThickness_m = 0.5, kRecess_m = 0.28;

struct Opening {
  double x0, x1, z0, z1;
};

// The window of one bay and storey: mostly a recessed pane, sometimes closed shutters.
void fill_opening(Mason& mason, const Opening& o, Random& random) {
  if (random.uniform() < 0.2) {
    const auto green = float(random.uniform(0.12, 0.25));
    mason.box(o.x0, o.x1, random.uniform(0.05, 0.12), kThickness_m, o.z0, o.z1, Finish::kPlaster, {0.1f, green, 0.12f});
  } else {
    Solid& pane = mason.box(o.x0, o.x1, kRecess_m, kThickness_m, o.z0, o.z1, Finish::kWindow, kTrimColour);
    pane.roof = Finish::kPlaster;
  }
  mason.box(o.x0 - 0.1, o.x1 + 0.1, -0.12, 0.1, o.z0 - 0.12, o.z0, Finish::kPlaster, kTrimColour);  // sill
}

void balcony(Mason& mason, double x0, double x1, double z) {
  mason.box(x0, x1, -0.95, 0.05, z - 0.18, z, Finish::kPlaster, kTrimColour);
  mason.box(x0, x1, -0.95, -0.87, z + 0.85, z + 0.95, Finish::kPlaster, kTrimColour);
  for (double x = x0 + 0.06; x < x1; x += 0.24) mason.column(x, -0.91, 0.045, z, z + 0.85, kTrimColour);
}

void storey(Mason& mason, const FacadeScene& o, int level, Random& random) {
  const double floor_m = level * o.storey_m, top_m = floor_m + o.storey_m, bay_m = o.width_m / o.bays;
  const Finish finish = level == 0 ? Finish::kStone : level == 1 ? Finish::kBrick : Finish::kPlaster;
  const Colour colour = level == 0 ? kStoneColour : level == 1 ? kBrickColour : Colour{0.55f, 0.46f, 0.32f};
  const double sill_m = floor_m + 0.95, lintel_m = top_m - 0.7, half_window_m = 0.3 * bay_m;
  const double left = -o.width_m / 2, right = o.width_m / 2;
  mason.box(left, right, 0, kThickness_m, floor_m, sill_m, finish, colour);
  mason.box(left, right, 0, kThickness_m, lintel_m, top_m, finish, colour);
  for (int i = 0; i < o.bays; ++i) {
    const double x0 = left + i * bay_m, middle = x0 + bay_m / 2;
    mason.box(i == 0 ? left : x0 - bay_m / 2 + half_window_m, middle - half_window_m, 0, kThickness_m, sill_m, lintel_m,
              finish, colour);
    fill_opening(mason, {middle - half_window_m, middle + half_window_m, sill_m, lintel_m}, random);
    if (level == 1 && (i % 3) == 1) balcony(mason, middle - 0.45 * bay_m, middle + 0.45 * bay_m, floor_m + 0.3);
  }
  mason.box(right - bay_m / 2 + half_window_m, right, 0, kThickness_m, sill_m, lintel_m, finish, colour);
  const double out_m = level + 1 == o.storeys ? 0.45 : 0.2;  // the cornice above
  mason.box(left, right, -out_m, kThickness_m, top_m - 0.16, top_m + 0.1, Finish::kPlaster, kTrimColour);
}

Heightfield yard(const FacadeScene& o, std::uint32_t seed) {
  const double west_m = -o.width_m / 2 - 14, south_m = -o.yard_m;
  const int width = int((o.width_m + 28) / o.cell_m) + 1, height = int((o.yard_m + 4) / o.cell_m) + 1;
  std::vector<float> heights;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const double x = west_m + column * o.cell_m, y = south_m + row * o.cell_m;
      heights.push_back(float(0.02 * y + 0.04 * value_noise(x / 4, y / 4, seed)));
    }
  return {west_m, south_m, o.cell_m, width, height, std::move(heights)};
}

}  // namespace

Scene make_facade_scene(const FacadeScene& o) {
  Random random(o.seed, 202);
  Mason mason(std::uint32_t(random.bits()));
  const double left = -o.width_m / 2, right = o.width_m / 2, top_m = o.storeys * o.storey_m;
  mason.box(left, right, 0, kThickness_m, -2, 0, Finish::kStone, kStoneColour);
  for (int level = 0; level < o.storeys; ++level) storey(mason, o, level, random);
  mason.box(left - 3, left, -1.4, 1, -2, top_m + 1.2, Finish::kBrick, {0.42f, 0.24f, 0.16f});  // a tower beside it
  mason.box(right, right + 2.5, 0.4, 1, -2, top_m - 2, Finish::kPlaster, {0.5f, 0.47f, 0.42f});
  const double bay_m = o.width_m / o.bays;
  for (int i = 1; i < o.bays; i += 2) mason.column(left + i * bay_m, -0.32, 0.2, -1, o.storey_m - 0.16, kStoneColour);
  for (int step = 0; step < 3; ++step)
    mason.box(-bay_m, bay_m, -1.6 + 0.4 * step, 0, -1, 0.16 * (step + 1), Finish::kStone, kTrimColour);
  Ground ground;
  ground.kind = Ground::Kind::kPaving;
  ground.seed = std::uint32_t(random.bits());
  return {yard(o, ground.seed), ground, mason.take(), sunlight(o.sun_azimuth_deg, o.sun_elevation_deg)};
}

}  // namespace collinea
