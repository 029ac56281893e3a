// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/materials.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "collinea/synthetic/internal/noise.h"

namespace collinea {
namespace {

// The share of a pixel of this footprint that lies inside an edge, `inside_m` away from it.
float covered(double inside_m, double footprint_m) {
  return static_cast<float>(std::clamp(inside_m / footprint_m + 0.5, 0.0, 1.0));
}

// How much of a pattern of this period a pixel still shows: all with four pixels a period, nothing with two.
float resolved(double period_m, double footprint_m) {
  return smooth_step(2, 4, static_cast<float>(period_m / footprint_m));
}

Colour darkened(Colour colour, float factor) { return std::clamp(factor, 0.25f, 1.9f) * colour; }

// ---- ground

struct Field {
  std::uint32_t id = 0;
  double edge_m = 0;  // distance from the nearest border
};

// Voronoi cells of one random point in each square of a grid.
Field field_at(const Ground& ground, double x, double y) {
  const double u = x / ground.field_m, v = y / ground.field_m;
  const int column = floor_int(u), row = floor_int(v);
  double nearest = std::numeric_limits<double>::infinity(), second = nearest;
  Field field;
  for (int j = row - 1; j <= row + 1; ++j)
    for (int i = column - 1; i <= column + 1; ++i) {
      const std::uint32_t bits = lattice_bits(i, j, ground.seed);
      const double du = i + 0.15 + 0.7 * (bits & 0xffff) / 65536.0 - u,
                   dv = j + 0.15 + 0.7 * (bits >> 16) / 65536.0 - v;
      const double squared = du * du + dv * dv;
      if (squared < nearest) {
        second = nearest;
        nearest = squared;
        field.id = bits;
      } else if (squared < second) {
        second = squared;
      }
    }
  field.edge_m = 0.5 * (std::sqrt(second) - std::sqrt(nearest)) * ground.field_m;
  return field;
}

struct Crop {
  Colour colour, other;  // the two ends of its range
  float rows;            // contrast of its rows
};

constexpr std::array<Crop, 6> kCrops = {{
    {{0.10f, 0.15f, 0.05f}, {0.17f, 0.19f, 0.08f}, 0.0f},   // meadow
    {{0.34f, 0.27f, 0.13f}, {0.42f, 0.34f, 0.17f}, 0.12f},  // ripe grain
    {{0.20f, 0.14f, 0.09f}, {0.27f, 0.20f, 0.13f}, 0.25f},  // ploughed soil
    {{0.29f, 0.26f, 0.16f}, {0.20f, 0.21f, 0.10f}, 0.18f},  // stubble
    {{0.06f, 0.12f, 0.04f}, {0.13f, 0.17f, 0.06f}, 0.22f},  // green crop on soil
    {{0.14f, 0.17f, 0.07f}, {0.24f, 0.22f, 0.12f}, 0.0f},   // dry pasture
}};
constexpr Colour kVerge{0.12f, 0.15f, 0.06f};

Colour fields(const Ground& ground, double x, double y, double footprint_m) {
  const Field field = field_at(ground, x, y);
  const Crop& crop = kCrops[field.id % kCrops.size()];
  const Fractal patches{9.0, 4, 0.75f, ground.seed + 11}, detail{1.6, 7, 1.06f, ground.seed + 29};
  const float patch = patches(x, y, footprint_m), grain = detail(x, y, footprint_m);
  Colour colour = mix(crop.colour, crop.other, std::clamp(0.5f + 0.55f * patch, 0.0f, 1.0f));

  const double spacing_m = 0.55 + 0.06 * double((field.id >> 8) & 7);
  const float visible = crop.rows * resolved(spacing_m, footprint_m);
  if (visible > 0) {
    const double heading = double((field.id >> 12) & 63) * (std::numbers::pi / 64);
    const double across = x * std::cos(heading) + y * std::sin(heading) + 0.12 * patch;
    colour = darkened(colour, 1 + visible * float(std::sin(2 * std::numbers::pi * across / spacing_m)));
  }
  const float verge = 1 - smooth_step(0.25f, 0.6f, float(field.edge_m) + 0.15f * grain);
  return darkened(mix(colour, kVerge, verge), 1 + 0.27f * grain + 0.12f * patch);
}

Colour with_road(const Road& road, Colour beneath, double x, double y, double footprint_m, std::uint32_t seed) {
  const Eigen::Vector2d at = road.off_and_along(x, y);
  const double off = std::abs(at.x());
  if (off > road.half_width_m + 1.2) return beneath;
  const Fractal detail{3.2, 8, 0.98f, seed + 53};
  const float grain = detail(x, y, footprint_m);
  const float shoulder = covered(road.half_width_m + 0.7 + 0.3 * grain - off, footprint_m);
  const Colour gravel = darkened({0.30f, 0.28f, 0.24f}, 1 + 0.25f * grain);
  Colour colour = darkened({0.13f, 0.13f, 0.135f}, 1 + 0.2f * grain);
  const double along = at.y() - 6 * floor_int(at.y() / 6);  // dashes of 3 m every 6 m
  const float line = covered(0.07 - off, footprint_m) * covered(1.5 - std::abs(along - 3), footprint_m) +
                     covered(0.06 - std::abs(off - road.half_width_m + 0.25), footprint_m);
  colour = mix(colour, {0.62f, 0.62f, 0.60f}, std::min(line, 1.0f) * std::clamp(0.8f + 0.4f * grain, 0.3f, 1.0f));
  const float asphalt = covered(road.half_width_m - off, footprint_m);
  return mix(mix(beneath, gravel, shoulder), colour, asphalt);
}

// Brightness of the elements of a bond (tiles, bricks, slabs): every element its own, dark joints between.
struct Bond {
  double length_m, height_m, joint_m;
  float variation, joint_depth;
  std::uint32_t seed;

  [[nodiscard]] float operator()(double u, double v, double footprint_m) const {
    const float shown = resolved(std::min(length_m, height_m), footprint_m);
    if (shown <= 0) return 0;
    const int row = floor_int(v / height_m);
    const double shifted = u / length_m + 0.5 * (row & 1);
    const int column = floor_int(shifted);
    const double from_joint_u = (0.5 - std::abs(shifted - column - 0.5)) * length_m;
    const double from_joint_v = (0.5 - std::abs(v / height_m - row - 0.5)) * height_m;
    const float joint =
        covered(0.5 * joint_m - std::min(from_joint_u, from_joint_v), std::max(footprint_m, 0.25 * joint_m));
    return shown * ((1 - joint) * variation * lattice_value(column, row, seed) - joint * joint_depth);
  }
};

Colour paving(const Ground& ground, double x, double y, double footprint_m) {
  const Fractal detail{2.4, 9, 0.95f, ground.seed + 71};
  const Bond slabs{0.6, 0.4, 0.012, 0.22f, 0.4f, ground.seed + 5};
  const float grain = detail(x, y, footprint_m);
  return darkened({0.26f, 0.245f, 0.22f}, 1 + 0.2f * grain + slabs(x, y, footprint_m));
}

// Bare rock of two colours with dark cracks, earth between, and scrub.
Colour rocks(const Ground& ground, double x, double y, double footprint_m) {
  const Fractal beds{26.0, 4, 0.7f, ground.seed + 83}, detail{3.4, 8, 1.0f, ground.seed + 89};
  const Fractal cracks{4.5, 4, 0.8f, ground.seed + 97}, scrub{7.0, 5, 0.85f, ground.seed + 101};
  const float bed = beds(x, y, footprint_m), grain = detail(x, y, footprint_m);
  Colour colour = mix({0.31f, 0.29f, 0.25f}, {0.24f, 0.19f, 0.13f}, std::clamp(0.5f + 0.7f * bed, 0.0f, 1.0f));
  const float crack = 1 - smooth_step(0.04f, 0.16f, std::abs(cracks(x, y, footprint_m)));
  colour = darkened(colour, 1 + 0.26f * grain - 0.35f * crack);
  const float bush = smooth_step(0.35f, 0.6f, scrub(x, y, footprint_m) - 0.25f * bed);
  return mix(colour, darkened({0.09f, 0.11f, 0.05f}, 1 + 0.35f * grain), bush);
}

// ---- bodies

Colour leaves(const Solid& s, double u, double v, double footprint_m) {
  const Fractal clumps{1.4, 6, 0.95f, s.seed + 13};
  return darkened(s.roof_colour, 1 + 0.45f * clumps(u, v, footprint_m));
}

Colour tiles(const Solid& s, double u, double v, double footprint_m) {
  const Fractal weather{5.0, 8, 0.9f, s.seed + 3};
  const Bond bond{0.32, 0.42, 0.03, 0.24f, 0.28f, s.seed};
  const float ridge = covered(0.14 - v, footprint_m);
  const Colour tile = darkened(s.roof_colour, 1 + 0.2f * weather(u, v, footprint_m) + bond(u, v, footprint_m));
  return mix(tile, 0.6f * s.roof_colour, ridge);
}

Colour gravel_roof(const Solid& s, double u, double v, double footprint_m) {
  const Fractal grain{4.0, 8, 0.97f, s.seed + 7};
  const Bond sheets{4.8, 1.2, 0.1, 0.08f, 0.25f, s.seed + 1};
  const float rim =
      1 - covered(std::min(s.half_length_m - std::abs(u), s.half_width_m - std::abs(v)) - 0.3, footprint_m);
  const Colour roof = darkened(s.roof_colour, 1 + 0.24f * grain(u, v, footprint_m) + sheets(u, v, footprint_m));
  return mix(roof, {0.45f, 0.45f, 0.44f}, 0.8f * rim);
}

// A window as painted: frame, a cross of bars, panes that differ.
Colour window(const Solid& s, double u, double v, double half_u, double half_v, std::uint32_t id, double footprint_m) {
  const double frame_m = 0.07;
  const float bar =
      std::max(covered(0.03 - std::abs(u), footprint_m), covered(0.03 - std::abs(v - 0.2 * half_v), footprint_m));
  const float glass = covered(half_u - frame_m - std::abs(u), footprint_m) *
                      covered(half_v - frame_m - std::abs(v), footprint_m) * (1 - bar);
  const Fractal curtain{0.7, 7, 0.8f, s.seed + id};
  const float lights = 1 + 0.5f * curtain(u, v, footprint_m);
  const float tone = 0.05f + 0.11f * lattice_uniform(int(id & 0xff), 0, s.seed);
  return mix({0.55f, 0.54f, 0.5f}, darkened({tone, tone * 1.05f, tone * 1.15f}, lights), glass);
}

Colour house_wall(const Solid& s, int face, double u, double z, double footprint_m) {
  const Fractal stains{3.0, 9, 0.9f, s.seed + 17 + std::uint32_t(face)};
  const Colour wall = darkened(s.wall_colour, 1 + 0.2f * stains(u, z, footprint_m));
  const double above = z - s.bottom_m - 1.0, storey_m = 2.8, bay_m = 2.6;
  const int row = floor_int(above / storey_m), column = floor_int(u / bay_m);
  const double du = u - (column + 0.5) * bay_m, dv = above - (row + 0.55) * storey_m;
  const bool fits = z + 0.5 < s.eave_m && above > 0;
  const float inside = fits ? covered(0.55 - std::abs(du), footprint_m) * covered(0.7 - std::abs(dv), footprint_m) : 0;
  if (inside <= 0) return wall;
  const std::uint32_t id = lattice_bits(column, row, s.seed + std::uint32_t(face));
  return mix(wall, window(s, du, dv, 0.55, 0.7, id & 0xffff, footprint_m), inside);
}

Colour window_wall(const Solid& s, double u, double z, double footprint_m) {
  return window(s, u, z - 0.5 * (s.bottom_m + s.eave_m), s.half_length_m, 0.5 * (s.eave_m - s.bottom_m), s.seed & 0xff,
                footprint_m);
}

Colour masonry(const Solid& s, Finish finish, int face, double u, double v, double footprint_m) {
  const std::uint32_t seed = s.seed + 31 * std::uint32_t(face);
  const Fractal stains{2.6, 10, 0.93f, seed + 23};
  float tone = 1 + (finish == Finish::kPlaster ? 0.22f : 0.17f) * stains(u, v, footprint_m);
  if (finish == Finish::kBrick) tone += Bond{0.25, 0.077, 0.012, 0.2f, -0.35f, seed}(u, v, footprint_m);
  if (finish == Finish::kStone) tone += Bond{0.75, 0.38, 0.014, 0.16f, 0.35f, seed}(u, v, footprint_m);
  return darkened(face >= Solid::kRoof ? s.roof_colour : s.wall_colour, tone);
}

}  // namespace

double Road::slope_at(double along_m) const {
  const double rate = 2 * std::numbers::pi / wavelength_m;
  return amplitude_m * rate * std::cos(rate * along_m);
}

Eigen::Vector2d Road::off_and_along(double x, double y) const {
  const double u = cosine * x + sine * y, v = cosine * y - sine * x, rate = 2 * std::numbers::pi / wavelength_m;
  const double slope = slope_at(u);
  double off = v - offset_m - amplitude_m * std::sin(rate * u);
  if (repeat_m > 0) off -= repeat_m * floor_int(off / repeat_m + 0.5);
  return {off / std::sqrt(1 + slope * slope), u};
}

Eigen::Vector2d Road::position(double off_m, double along_m, int number) const {
  const double slope = slope_at(along_m);
  const double v = offset_m + amplitude_m * std::sin(2 * std::numbers::pi / wavelength_m * along_m) +
                   number * repeat_m + off_m * std::sqrt(1 + slope * slope);
  return {cosine * along_m - sine * v, sine * along_m + cosine * v};
}

Colour ground_albedo(const Ground& ground, double x, double y, double footprint_m) {
  if (ground.kind == Ground::Kind::kPaving) return paving(ground, x, y, footprint_m);
  const bool is_rock = ground.kind == Ground::Kind::kRocks;
  Colour colour = is_rock ? rocks(ground, x, y, footprint_m) : fields(ground, x, y, footprint_m);
  if (ground.district_m > 0) {
    const Fractal districts{ground.district_m, 5, 0.8f, ground.seed + 131};
    colour = darkened(colour, 1 + 0.35f * districts(x, y, footprint_m));
  }
  for (const Road& road : ground.roads) colour = with_road(road, colour, x, y, footprint_m, ground.seed);
  return colour;
}

Colour solid_albedo(const Solid& solid, int face, const Eigen::Vector3d& point, double footprint_m) {
  const Eigen::Vector2d at = face_coordinates(solid, face, point);
  const Finish finish = face >= Solid::kRoof ? solid.roof : solid.wall;
  switch (finish) {
    case Finish::kTiles:
      return tiles(solid, at.x(), at.y(), footprint_m);
    case Finish::kGravelRoof:
      return gravel_roof(solid, at.x(), at.y(), footprint_m);
    case Finish::kHouseWall:
      return house_wall(solid, face, at.x(), at.y(), footprint_m);
    case Finish::kLeaves:
      return leaves(solid, at.x(), at.y(), footprint_m);
    case Finish::kWindow:
      return window_wall(solid, at.x(), at.y(), footprint_m);
    default:
      return masonry(solid, finish, face, at.x(), at.y(), footprint_m);
  }
}

Colour mark_albedo(const Mark& mark, const Eigen::Vector3d& point, double footprint_m, Colour beneath) {
  const Eigen::Vector3d offset = point - mark.centre;
  const double u = mark.right.dot(offset), v = mark.up.dot(offset), w = mark.right.cross(mark.up).dot(offset);
  if (std::abs(w) > mark.half_size_m) return beneath;
  const double half = mark.half_size_m, board = 1.2 * half;
  const float on_board = covered(board - std::abs(u), footprint_m) * covered(board - std::abs(v), footprint_m);
  if (on_board <= 0) return beneath;
  const float right = covered(u, footprint_m), above = covered(v, footprint_m);
  const float quarters = right * above + (1 - right) * (1 - above);
  const float checker = covered(half - std::abs(u), footprint_m) * covered(half - std::abs(v), footprint_m);
  const Colour white{0.8f, 0.8f, 0.8f}, black{0.025f, 0.025f, 0.025f};
  return mix(beneath, mix(white, black, checker * quarters), on_board);
}

}  // namespace collinea
