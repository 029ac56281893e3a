// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "collinea/synthetic/internal/colour.h"
#include "collinea/synthetic/internal/heightfield.h"
#include "collinea/synthetic/internal/materials.h"
#include "collinea/synthetic/internal/solid.h"

namespace collinea {

/// One sun and an even sky.
struct Light {
  Eigen::Vector3d to_sun{0, 0, 1};  ///< unit vector
  float sun = 0.95f, sky = 0.38f;   ///< light on a surface that faces it
  Colour sun_colour{1.0f, 0.97f, 0.9f}, sky_colour{0.85f, 0.95f, 1.1f};
};

/// Light from an azimuth (clockwise from north = y) and an elevation.
[[nodiscard]] Light sunlight(double azimuth_deg, double elevation_deg);

/// Where a ray meets the scene.
struct Hit {
  Eigen::Vector3d point;   ///< [m]
  Eigen::Vector3d normal;  ///< unit, outward
  double distance_m = 0;   ///< from the ray's origin
  int solid = -1;          ///< index of the body; -1: the terrain
  int face = 0;            ///< Solid::Face
};

/// A world with known geometry: a bilinear terrain with upright convex bodies on it, all matte, with textures fixed in
/// object space. Rays meet it in closed form, to rounding error. World frame: metric, z up.
class Scene {
 public:
  Scene(Heightfield terrain, Ground ground, std::vector<Solid> solids, Light light);

  /// Paints a survey mark on the surfaces it touches.
  void add(const Mark& mark);

  /// The first surface a ray meets; nothing when it leaves the scene, or when it starts outside and misses it.
  /// `direction` is a unit vector; origins below the surface are meaningless.
  [[nodiscard]] std::optional<Hit> cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// True when nothing lies between a point of a surface and `eye`. Points within 1 mm of a surface count as on it.
  [[nodiscard]] bool visible(const Eigen::Vector3d& point, const Eigen::Vector3d& eye) const;

  /// True when the sun shines on the surface; bodies cast shadows, the terrain does not.
  [[nodiscard]] bool in_sun(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

  [[nodiscard]] double terrain_height(double x, double y) const { return terrain_.height(x, y); }
  /// The highest surface over a position: what a digital surface model should show.
  [[nodiscard]] double surface_height(double x, double y) const;

  /// Reflectance at a hit, averaged over about `footprint_m`.
  [[nodiscard]] Colour albedo(const Hit& hit, double footprint_m) const;
  /// Reflectance in the light of sun and sky.
  [[nodiscard]] Colour shaded(const Hit& hit, double footprint_m, bool sunlit) const;
  [[nodiscard]] Colour sky() const { return {0.55f, 0.68f, 0.85f}; }

  [[nodiscard]] const Heightfield& terrain() const { return terrain_; }
  [[nodiscard]] const std::vector<Solid>& solids() const { return solids_; }
  [[nodiscard]] const Light& light() const { return light_; }
  [[nodiscard]] double highest_m() const { return highest_m_; }

 private:
  /// A square of several terrain cells: what may be met inside it.
  struct Square {
    float highest_m, highest_ground_m, highest_solid_m;
    int first_solid, solids;  ///< a range of listed_
    int marks;                ///< index into mark_lists_; -1: none
  };
  struct Listed {
    int solid;
    float bottom_m, top_m;
  };
  struct Candidate {
    double t = std::numeric_limits<double>::infinity();
    int solid = -1, face = 0;
  };

  void find_squares();
  template <class Visit>
  void for_squares(double x, double y, double radius_m, Visit&& visit);
  [[nodiscard]] const Square& square_at(double x, double y) const;
  /// Among the bodies of a square that reach into the heights the ray has there, from parameter `t` to `leave`.
  [[nodiscard]] Candidate nearest_solid(const Square& square, const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction, double t, double leave) const;

  Heightfield terrain_;
  Ground ground_;
  std::vector<Solid> solids_;
  std::vector<Mark> marks_;
  Light light_;
  double square_m_ = 1, highest_m_ = 0, highest_solid_m_ = 0;
  int cells_per_square_ = 1, columns_ = 1, rows_ = 1;
  std::vector<Square> squares_;
  std::vector<Listed> listed_;
  std::vector<std::vector<int>> mark_lists_;
};

}  // namespace collinea
