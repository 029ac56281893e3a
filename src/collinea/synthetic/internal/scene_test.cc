// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collinea/math/random.h"
#include "collinea/synthetic/internal/facade_scene.h"
#include "collinea/synthetic/internal/noise.h"
#include "collinea/synthetic/internal/rocks.h"
#include "collinea/synthetic/internal/town.h"
#include "collinea/synthetic/internal/village.h"

namespace collinea {
namespace {

const Scene& village() {
  static const Scene scene = make_village({.low = {-60, -60},
                                           .high = {60, 60},
                                           .cell_m = 0.5,
                                           .building_area_m2 = 500,
                                           .built_low = {-50, -50},
                                           .built_high = {50, 50},
                                           .seed = 5});
  return scene;
}

const Scene& town() {
  static const Scene scene = make_town({.low = {-90, -90},
                                        .high = {90, 90},
                                        .cell_m = 0.5,
                                        .relief_m = 12,
                                        .building_area_m2 = 600,
                                        .built_low = {-80, -80},
                                        .built_high = {80, 80},
                                        .seed = 5});
  return scene;
}

const Scene& rocks() {
  static const Scene scene = make_rocks({.low = {-250, -250},
                                         .high = {250, 250},
                                         .cell_m = 0.5,
                                         .relief_m = 250,
                                         .building_area_m2 = 1500,
                                         .built_low = {-240, -240},
                                         .built_high = {240, 240},
                                         .seed = 5});
  return scene;
}

const Scene& facade() {
  static const Scene scene = make_facade_scene({});
  return scene;
}

Solid house(Solid::Shape shape) {
  Solid s;
  s.shape = shape;
  s.x = 3;
  s.y = -2;
  s.cosine = std::cos(0.4);
  s.sine = std::sin(0.4);
  s.half_length_m = 5;
  s.half_width_m = 3;
  s.bottom_m = -1;
  s.eave_m = 4;
  s.ridge_m = shape == Solid::Shape::kGable ? 6 : 4;
  return s;
}

// Positive outside, by the half spaces or the round surface that bound the body; near it the distance.
double outside(const Solid& s, const Eigen::Vector3d& p) {
  const double u = s.cosine * (p.x() - s.x) + s.sine * (p.y() - s.y),
               v = s.cosine * (p.y() - s.y) - s.sine * (p.x() - s.x);
  if (s.shape == Solid::Shape::kCrown) {
    const double r = s.half_length_m, h = (s.ridge_m - s.bottom_m) / 2;
    const Eigen::Vector3d q(u / r, v / r, (p.z() - s.bottom_m) / h - 1);
    return (q.norm() - 1) * q.norm() / Eigen::Vector3d(q.x() / r, q.y() / r, q.z() / h).norm();
  }
  double d = std::max(s.bottom_m - p.z(), p.z() - s.ridge_m);
  if (s.shape == Solid::Shape::kColumn) return std::max(d, std::hypot(u, v) - s.half_length_m);
  d = std::max({d, std::abs(u) - s.half_length_m, std::abs(v) - s.half_width_m});
  const double roof = s.ridge_m - (s.ridge_m - s.eave_m) * std::abs(v) / s.half_width_m;
  return std::max(d, p.z() - roof);
}

TEST(Solid, RaysEndWhereTheyEnterAndNormalsFaceThem) {
  Random random(1);
  for (const auto shape : {Solid::Shape::kBox, Solid::Shape::kGable, Solid::Shape::kColumn, Solid::Shape::kCrown}) {
    const Solid s = house(shape);
    int met = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      const Eigen::Vector3d from(random.uniform(-20, 20), random.uniform(-20, 20), random.uniform(7, 20));
      const Eigen::Vector3d to(random.uniform(-5, 10), random.uniform(-9, 5), random.uniform(-2, 5));
      const Eigen::Vector3d ray = (to - from).normalized();
      const auto hit = meet(s, from, ray);
      for (int i = 0; i <= 100; ++i)  // nothing is entered before, or at all
        ASSERT_GT(outside(s, from + (i / 100.0) * (hit ? hit->t : 60.0) * ray), -1e-9);
      if (!hit) continue;
      ++met;
      const Eigen::Vector3d p = from + hit->t * ray;
      EXPECT_NEAR(outside(s, p), 0, 1e-12);
      EXPECT_LT(normal_of(s, hit->face, p).dot(ray), 0);
      EXPECT_NEAR(outside(s, p + 1e-6 * normal_of(s, hit->face, p)), 1e-6, 5e-7);
    }
    EXPECT_GT(met, 300);
  }
}

TEST(Solid, TheTopIsWhatAPlumbLineMeets) {
  Random random(2);
  for (const auto shape : {Solid::Shape::kBox, Solid::Shape::kGable, Solid::Shape::kColumn, Solid::Shape::kCrown}) {
    const Solid s = house(shape);
    for (int trial = 0; trial < 300; ++trial) {
      const double x = random.uniform(-4, 10), y = random.uniform(-9, 5);
      const auto hit = meet(s, {x, y, 30}, {0, 0, -1});
      const auto top = top_at(s, x, y);
      ASSERT_EQ(hit.has_value(), top.has_value());
      if (hit) {
        EXPECT_NEAR(30 - hit->t, *top, 1e-12);
      }
    }
  }
}

// The grid that speeds up the search must lose nothing: compare with trying every body.
void expect_nothing_lost(const Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  Random random(6);
  int met = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto position = [&] {
      return Eigen::Vector3d(random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y()),
                             random.uniform(low.z(), high.z()));
    };
    Eigen::Vector3d from = position();
    from.z() = std::max(from.z(), scene.surface_height(from.x(), from.y()) + 0.1);
    const Eigen::Vector3d ray = (position() - from).normalized();
    double nearest = std::numeric_limits<double>::infinity();
    for (const Solid& solid : scene.solids())
      if (const auto hit = meet(solid, from, ray)) nearest = std::min(nearest, hit->t);
    const auto hit = scene.cast(from, ray);
    if (hit && hit->solid >= 0) {
      EXPECT_EQ(hit->distance_m, nearest);
      ++met;
    } else if (hit) {
      EXPECT_LT(hit->distance_m, nearest);
      EXPECT_NEAR(hit->point.z(), scene.terrain_height(hit->point.x(), hit->point.y()), 1e-9);
    } else if (std::isfinite(nearest)) {  // only outside the scene
      const Eigen::Vector3d p = from + nearest * ray;
      EXPECT_FALSE(p.x() > scene.terrain().west_m() && p.x() < scene.terrain().east_m() &&
                   p.y() > scene.terrain().south_m() && p.y() < scene.terrain().north_m());
    }
  }
  EXPECT_GT(met, 100);
}

TEST(Scene, TheGridLosesNoHouse) { expect_nothing_lost(village(), {-60, -60, -8}, {60, 60, 40}); }
TEST(Scene, TheGridLosesNoTree) { expect_nothing_lost(town(), {-90, -90, -12}, {90, 90, 40}); }
TEST(Scene, TheGridLosesNoHouseOnRocks) { expect_nothing_lost(rocks(), {-250, -250, -150}, {250, 250, 250}); }
TEST(Scene, TheGridLosesNoPieceOfAFacade) { expect_nothing_lost(facade(), {-12, -14, 0}, {12, 0.6, 12}); }

// A surface model made by plumb lines and one made by formula are the same, to rounding of some 100 m.
void expect_heights_of_plumb_lines(const Scene& scene, double reach_m, int least_on_bodies) {
  Random random(7);
  int on_bodies = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const double x = random.uniform(-reach_m, reach_m), y = random.uniform(-reach_m, reach_m);
    const auto hit = scene.cast({x, y, 300}, {0, 0, -1});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->point.z(), scene.surface_height(x, y), 1e-9);
    on_bodies += hit->solid >= 0;
  }
  EXPECT_GT(on_bodies, least_on_bodies);
}

TEST(Scene, SurfaceHeightIsWhatAPlumbLineMeets) {
  expect_heights_of_plumb_lines(village(), 55, 50);
  expect_heights_of_plumb_lines(town(), 80, 300);
  expect_heights_of_plumb_lines(rocks(), 240, 5);
}

// A tenth of the rocks is steeper than 45 degrees, half of it steeper than 20; the range is about what was asked for.
TEST(Rocks, AreSteepAndAsHighAsAsked) {
  const Heightfield& terrain = rocks().terrain();
  std::vector<double> slopes;
  for (double y = -249; y < 249; y += 2.3)
    for (double x = -249; x < 249; x += 2.3) {
      const Eigen::Vector3d n = terrain.normal(x, y);
      slopes.push_back(std::atan2(n.head<2>().norm(), n.z()) * 180 / std::numbers::pi);
    }
  std::sort(slopes.begin(), slopes.end());
  EXPECT_GT(slopes[slopes.size() * 9 / 10], 45);
  EXPECT_GT(slopes[slopes.size() / 2], 20);
  EXPECT_LT(slopes[slopes.size() / 2], 45);
  const double range_m = terrain.highest_m() - terrain.lowest_m();
  EXPECT_GT(range_m, 125);
  EXPECT_LT(range_m, 375);
}

// Differences over a distance d grow nearly as d: no wavelength is smooth. Between 1 and 64 m each doubling brings
// between 2^0.6 and 2^1.1 as much.
TEST(Rocks, AreRoughAtAllWavelengths) {
  const Heightfield& terrain = rocks().terrain();
  double before = 0;
  for (double d = 1; d <= 64; d *= 2) {
    // The second difference, which knows nothing of the slope of longer waves.
    double squares = 0;
    for (double y = -180; y < 180; y += 3.7)
      for (double x = -180; x < 180; x += 3.7)
        squares += std::pow(terrain.height(x - d, y) - 2 * terrain.height(x, y) + terrain.height(x + d, y), 2);
    if (before > 0) {
      const double exponent = 0.5 * std::log2(squares / before);
      EXPECT_GT(exponent, 0.6) << d;
      EXPECT_LT(exponent, 1.5) << d;
    }
    before = squares;
  }
}

// Streets stay clear of houses, and houses of each other: no middle of one lies in another.
TEST(Town, HousesStandBesideStreetsAndTreesBetween) {
  int houses = 0, crowns = 0;
  for (const Solid& s : town().solids()) {
    crowns += s.shape == Solid::Shape::kCrown;
    if (s.wall != Finish::kHouseWall) continue;
    ++houses;
    for (const Solid& other : town().solids())
      if (&other != &s && other.wall == Finish::kHouseWall) EXPECT_FALSE(top_at(other, s.x, s.y));
  }
  // One on 600 m2 of 160 x 160 m is wanted, 43, and 98 trees of five parts; streets take a third of the land.
  EXPECT_GT(houses, 20);
  EXPECT_GT(crowns, 5 * 20);
}

TEST(Scene, APointIsSeenFromWhereItsRayComes) {
  Random random(8);
  const Eigen::Vector3d eye(10, -20, 60);
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::Vector3d ray =
        (Eigen::Vector3d(random.uniform(-50, 50), random.uniform(-50, 50), 0) - eye).normalized();
    const auto hit = village().cast(eye, ray);
    ASSERT_TRUE(hit);
    EXPECT_TRUE(village().visible(hit->point, eye));
    EXPECT_FALSE(village().visible(hit->point + 0.01 * ray, eye));
  }
}

TEST(Scene, HousesCastShadowsAwayFromTheSun) {
  Solid tower = house(Solid::Shape::kBox);
  tower.eave_m = tower.ridge_m = 10;
  const Scene scene({-40, -40, 1, 81, 81, std::vector<float>(81 * 81, 0.0f)}, {}, {tower}, sunlight(180, 45));
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  EXPECT_FALSE(scene.in_sun({3, 6, 0}, up));   // north of it, 8 m from its middle: the shadow is 10 m long
  EXPECT_TRUE(scene.in_sun({3, -10, 0}, up));  // south
  EXPECT_TRUE(scene.in_sun({3, 13, 0}, up));   // beyond the shadow's end
  EXPECT_TRUE(scene.in_sun({3, -2, 10}, up));  // its own roof
  EXPECT_FALSE(scene.in_sun({3, -2, 5}, Eigen::Vector3d::UnitY()));  // turned away from the sun
}

TEST(Scene, AMarkIsPaintedWhereItLies) {
  Scene scene({-40, -40, 1, 81, 81, std::vector<float>(81 * 81, 0.0f)}, {}, {}, sunlight(180, 45));
  scene.add({{1.5, 2.5, 0}, {1, 0, 0}, {0, 1, 0}, 0.2});
  const auto brightness = [&](double x, double y) { return scene.albedo({{x, y, 0}, {0, 0, 1}, 1, -1, 0}, 0.01).g; };
  EXPECT_LT(brightness(1.6, 2.6), 0.05);
  EXPECT_LT(brightness(1.4, 2.4), 0.05);
  EXPECT_GT(brightness(1.4, 2.6), 0.7);
  EXPECT_GT(brightness(1.6, 2.4), 0.7);
  EXPECT_LT(brightness(1.6, 2.9), 0.6);
}

TEST(Noise, OctavesBelowThePixelVanish) {
  const Fractal fractal{1.0, 6, 1.0f, 9};
  EXPECT_EQ(fractal(3.3, 4.7, 1.0), 0);
  EXPECT_EQ(fractal(3.3, 4.7, 0.5), value_noise(3.3, 4.7, 9));
}

// Lattice values are uniform with variance 1/3; the mean square of the interpolation weights is (26/35)^2: 0.429.
TEST(Noise, HasItsStandardDeviation) {
  double sum = 0, squares = 0;
  constexpr int kSide = 300;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      const double v = value_noise(i * 0.73, j * 0.73, 4);
      sum += v;
      squares += v * v;
    }
  EXPECT_NEAR(sum / kSide / kSide, 0, 0.02);
  EXPECT_NEAR(std::sqrt(squares / kSide / kSide), 0.429, 0.01);
}

}  // namespace
}  // namespace collinea
