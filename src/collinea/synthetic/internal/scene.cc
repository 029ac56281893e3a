// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/base/result.h"
#include "collinea/synthetic/internal/cell_walk.h"

namespace collinea {
namespace {

constexpr int kMostCells = 16;   // along a side of a square of the index
constexpr double kSquare_m = 8;  // side that squares have with large cells: about that of a house
constexpr double kOnSurface_m = 1e-3;

// The part [start, end] of a line inside one pair of parallel planes.
void clip(double origin, double direction, double low, double high, double& start, double& end) {
  if (direction == 0) {
    if (origin < low || origin > high) end = -1;
    return;
  }
  const double a = (low - origin) / direction, b = (high - origin) / direction;
  start = std::max(start, std::min(a, b));
  end = std::min(end, std::max(a, b));
}

}  // namespace

Light sunlight(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180, elevation = elevation_deg * std::numbers::pi / 180;
  Light light;
  light.to_sun = {std::sin(azimuth) * std::cos(elevation), std::cos(azimuth) * std::cos(elevation),
                  std::sin(elevation)};
  return light;
}

Scene::Scene(Heightfield terrain, Ground ground, std::vector<Solid> solids, Light light)
    : terrain_(std::move(terrain)), ground_(std::move(ground)), solids_(std::move(solids)), light_(light) {
  cells_per_square_ = std::clamp(int(kSquare_m / terrain_.cell_m()), 1, kMostCells);
  square_m_ = cells_per_square_ * terrain_.cell_m();
  columns_ = (terrain_.cells_x() + cells_per_square_ - 1) / cells_per_square_;
  rows_ = (terrain_.cells_y() + cells_per_square_ - 1) / cells_per_square_;
  find_squares();
}

// Calls visit(index) for every square that a disc may touch.
template <class Visit>
void Scene::for_squares(double x, double y, double radius_m, Visit&& visit) {
  const double u = (x - terrain_.west_m()) / square_m_, v = (y - terrain_.south_m()) / square_m_,
               r = radius_m / square_m_;
  for (int row = std::max(0, floor_int(v - r)); row <= std::min(rows_ - 1, floor_int(v + r)); ++row)
    for (int column = std::max(0, floor_int(u - r)); column <= std::min(columns_ - 1, floor_int(u + r)); ++column)
      visit(std::size_t(row) * std::size_t(columns_) + std::size_t(column));
}

void Scene::find_squares() {
  std::vector<std::vector<Listed>> lists(std::size_t(columns_) * std::size_t(rows_));
  const double half_diagonal_m = square_m_ * std::numbers::sqrt2 / 2;
  for (int i = 0; i < int(solids_.size()); ++i) {
    const Solid& solid = solids_[std::size_t(i)];
    // One float step apart, so that rounding never hides a bottom or a top.
    const Listed entry{i, std::nextafter(float(solid.bottom_m), -1e30f),
                       std::nextafter(float(std::max(solid.ridge_m, solid.eave_m)), 1e30f)};
    for_squares(solid.x, solid.y, solid.radius_m(), [&](std::size_t square) {
      const double x = terrain_.west_m() + (double(square % std::size_t(columns_)) + 0.5) * square_m_ - solid.x;
      const double y = terrain_.south_m() + (double(square / std::size_t(columns_)) + 0.5) * square_m_ - solid.y;
      const double u = solid.cosine * x + solid.sine * y, v = solid.cosine * y - solid.sine * x;
      const double half_width_m = solid.is_round() ? solid.half_length_m : solid.half_width_m;
      if (std::abs(u) <= solid.half_length_m + half_diagonal_m && std::abs(v) <= half_width_m + half_diagonal_m)
        lists[square].push_back(entry);
    });
  }
  highest_solid_m_ = -std::numeric_limits<double>::infinity();
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      const auto& list = lists[squares_.size()];
      Square square{};
      square.highest_solid_m = -std::numeric_limits<float>::infinity();
      for (const Listed& entry : list) square.highest_solid_m = std::max(square.highest_solid_m, entry.top_m);
      square.highest_ground_m =
          float(terrain_.highest(column * cells_per_square_, row * cells_per_square_, cells_per_square_));
      square.highest_m = std::max(square.highest_ground_m, square.highest_solid_m);
      square.first_solid = int(listed_.size());
      square.solids = int(list.size());
      square.marks = -1;
      listed_.insert(listed_.end(), list.begin(), list.end());
      squares_.push_back(square);
      highest_solid_m_ = std::max(highest_solid_m_, double(square.highest_solid_m));
    }
  highest_m_ = std::max(highest_solid_m_, terrain_.highest_m());
}

void Scene::add(const Mark& mark) {
  marks_.push_back(mark);
  for_squares(mark.centre.x(), mark.centre.y(), 2 * mark.half_size_m, [&](std::size_t index) {
    Square& square = squares_[index];
    if (square.marks < 0) {
      square.marks = int(mark_lists_.size());
      mark_lists_.emplace_back();
    }
    mark_lists_[std::size_t(square.marks)].push_back(int(marks_.size()) - 1);
  });
}

const Scene::Square& Scene::square_at(double x, double y) const {
  const int column = std::clamp(floor_int((x - terrain_.west_m()) / square_m_), 0, columns_ - 1);
  const int row = std::clamp(floor_int((y - terrain_.south_m()) / square_m_), 0, rows_ - 1);
  return squares_[std::size_t(row) * std::size_t(columns_) + std::size_t(column)];
}

Scene::Candidate Scene::nearest_solid(const Square& square, const Eigen::Vector3d& origin,
                                      const Eigen::Vector3d& direction, double t, double leave) const {
  Candidate best;
  if (square.solids == 0) return best;
  const double a = origin.z() + t * direction.z(), b = origin.z() + leave * direction.z();
  const double low = std::min(a, b), high = std::max(a, b);
  for (int i = 0; i < square.solids; ++i) {
    const Listed& entry = listed_[std::size_t(square.first_solid + i)];
    if (entry.top_m < low || entry.bottom_m > high) continue;
    if (const auto hit = meet(solids_[std::size_t(entry.solid)], origin, direction); hit && hit->t < best.t)
      best = {hit->t, entry.solid, hit->face};
  }
  return best;
}

std::optional<Hit> Scene::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  double start = 0, end = std::numeric_limits<double>::infinity();
  clip(origin.x(), direction.x(), terrain_.west_m(), terrain_.east_m(), start, end);
  clip(origin.y(), direction.y(), terrain_.south_m(), terrain_.north_m(), start, end);
  clip(origin.z(), direction.z(), terrain_.lowest_m() - 1, highest_m_ + 1, start, end);
  if (!(start < end)) return std::nullopt;

  const double scale = 1 / square_m_;
  CellWalk walk((origin.x() - terrain_.west_m()) * scale, (origin.y() - terrain_.south_m()) * scale,
                direction.x() * scale, direction.y() * scale, start, columns_, rows_);
  for (double t = start;;) {
    const double leave = std::min(walk.exit(), end);
    const Square& square = squares_[std::size_t(walk.row()) * std::size_t(columns_) + std::size_t(walk.column())];
    const double lowest = origin.z() + (direction.z() < 0 ? leave : t) * direction.z();
    if (lowest <= square.highest_m) {
      Candidate best = nearest_solid(square, origin, direction, t, leave);
      if (lowest <= square.highest_ground_m) {
        const double below = direction.z() < 0 ? (square.highest_ground_m - origin.z()) / direction.z() : t;
        const double from = std::max(t, below - kOnSurface_m), to = std::min(leave, best.t);
        if (const auto ground = from < to ? terrain_.meet(origin, direction, from, to) : std::nullopt)
          best = {*ground, -1, 0};
      }
      // A body met beyond this square will be found again there, unless something else comes before it.
      if (best.t <= leave) {
        Hit hit{origin + best.t * direction, {}, best.t, best.solid, best.face};
        hit.normal = best.solid < 0 ? terrain_.normal(hit.point.x(), hit.point.y())
                                    : normal_of(solids_[std::size_t(best.solid)], best.face, hit.point);
        return hit;
      }
    }
    if (leave >= end || !walk.advance()) return std::nullopt;
    t = leave;
  }
}

bool Scene::visible(const Eigen::Vector3d& point, const Eigen::Vector3d& eye) const {
  const double distance_m = (point - eye).norm();
  const auto hit = cast(eye, (point - eye) / distance_m);
  return !hit || hit->distance_m > distance_m - kOnSurface_m;
}

bool Scene::in_sun(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
  const Eigen::Vector3d& direction = light_.to_sun;
  if (normal.dot(direction) <= 0) return false;
  const Eigen::Vector3d origin = point + 1e-6 * normal;  // just off the face it lies on
  double start = 0, end = std::numeric_limits<double>::infinity();
  clip(origin.x(), direction.x(), terrain_.west_m(), terrain_.east_m(), start, end);
  clip(origin.y(), direction.y(), terrain_.south_m(), terrain_.north_m(), start, end);
  clip(origin.z(), direction.z(), terrain_.lowest_m() - 1, highest_solid_m_, start, end);
  if (!(start < end)) return true;
  const double scale = 1 / square_m_;
  CellWalk walk((origin.x() - terrain_.west_m()) * scale, (origin.y() - terrain_.south_m()) * scale,
                direction.x() * scale, direction.y() * scale, start, columns_, rows_);
  for (double t = start;;) {
    const double leave = std::min(walk.exit(), end);
    const Square& square = squares_[std::size_t(walk.row()) * std::size_t(columns_) + std::size_t(walk.column())];
    if (origin.z() + t * direction.z() <= square.highest_solid_m &&
        nearest_solid(square, origin, direction, t, leave).solid >= 0)
      return false;
    if (leave >= end) return true;
    t = leave;
    if (!walk.advance()) return true;
  }
}

double Scene::surface_height(double x, double y) const {
  double height = terrain_height(x, y);
  const Square& square = square_at(x, y);
  for (int i = 0; i < square.solids; ++i)
    if (const auto top = top_at(solids_[std::size_t(listed_[std::size_t(square.first_solid + i)].solid)], x, y))
      height = std::max(height, *top);
  return height;
}

Colour Scene::albedo(const Hit& hit, double footprint_m) const {
  Colour colour = hit.solid < 0 ? ground_albedo(ground_, hit.point.x(), hit.point.y(), footprint_m)
                                : solid_albedo(solids_[std::size_t(hit.solid)], hit.face, hit.point, footprint_m);
  if (const int list = square_at(hit.point.x(), hit.point.y()).marks; list >= 0)
    for (int i : mark_lists_[std::size_t(list)])
      colour = mark_albedo(marks_[std::size_t(i)], hit.point, footprint_m, colour);
  return colour;
}

Colour Scene::shaded(const Hit& hit, double footprint_m, bool sunlit) const {
  const float towards_sky = 0.6f + 0.4f * float(hit.normal.z());
  const float towards_sun = sunlit ? std::max(0.0f, float(hit.normal.dot(light_.to_sun))) : 0.0f;
  const Colour light = light_.sky * towards_sky * light_.sky_colour + light_.sun * towards_sun * light_.sun_colour;
  return albedo(hit, footprint_m) * light;
}

}  // namespace collinea
