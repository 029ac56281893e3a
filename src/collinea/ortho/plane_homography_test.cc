// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/plane_homography.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "collinea/math/random.h"
#include "collinea/ortho/rectify.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A camera before a wall: plane frame x right, y up, z to the viewer.
struct Wall {
  Camera camera = ideal_camera(1500, 2000, 1400);
  Vector3d centre{3, 1.5, 9};
  Eigen::Matrix3d cam_from_plane_axes;

  explicit Wall(bool distorted = true) {
    if (distorted) {
      camera.params[Camera::kCx] += 12;
      camera.params[Camera::kK1] = -0.08;
      camera.params[Camera::kK2] = 0.03;
      camera.params[Camera::kP1] = 0.001;
    }
    const Vector3d forward = (Vector3d(6, 4, 0) - centre).normalized();
    const Vector3d right = forward.cross(Vector3d::UnitY()).normalized();
    cam_from_plane_axes << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  }
  [[nodiscard]] Vector2d pixel(const Vector3d& in_plane) const {
    return project(camera, cam_from_plane_axes * (in_plane - centre)).value();
  }
  [[nodiscard]] PlanePoint point(const std::string& name, double x, double y) const {
    return {name, pixel({x, y, 0}), {x, y}};
  }
  [[nodiscard]] std::vector<PlanePoint> corners() const {
    return {point("a", 2, 1), point("b", 9, 1.5), point("c", 10, 7), point("d", 3, 6)};
  }
};

Vector2d position_of(const PlaneHomography& homography, const Camera& camera, const Vector2d& pixel) {
  return (homography.matrix().inverse() * normalized(camera, pixel).homogeneous()).hnormalized();
}

TEST(PlaneHomography, ExactPointsGiveTheExactProjection) {
  const Wall wall;
  for (const bool more : {false, true}) {
    auto points = wall.corners();
    if (more)
      for (int i = 0; i < 6; ++i) points.push_back(wall.point("e", 1 + 1.4 * i, 1 + (i * i) % 6));
    const auto fit = PlaneHomography::fit(wall.camera, points);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_EQ(fit->redundancy(), more ? 12 : 0);
    EXPECT_LT(fit->sigma0(), 1e-6);
    for (const Vector2d& position : {Vector2d(0, 0), Vector2d(6, 3), Vector2d(12, 9)})
      EXPECT_LT((position_of(*fit, wall.camera, wall.pixel({position.x(), position.y(), 0})) - position).norm(), 1e-8);
    EXPECT_LT((centre_over_plane(fit->matrix()) - wall.centre).norm(), 1e-7);
  }
}

// The focal length is not needed for the plane; its perspective tells it, and with it where the camera stood.
TEST(PlaneHomography, PerspectiveTellsTheFocalLength) {
  const Wall wall(false);
  const Camera guessed = ideal_camera(2000, 2000, 1400);
  const auto fit = PlaneHomography::fit(guessed, wall.corners());
  ASSERT_TRUE(fit) << fit.error().message;
  const auto focal = fit->focal();
  ASSERT_TRUE(focal);
  EXPECT_NEAR(focal->times * 2000, 1500, 1e-4);
  EXPECT_LT((centre_over_plane(fit->matrix(), focal->times) - wall.centre).norm(), 1e-6);
}

TEST(PlaneHomography, AFrontalViewDoesNotTellTheFocalLength) {
  const Camera camera = ideal_camera(1500, 2000, 1400);
  std::vector<PlanePoint> points;
  for (const Vector2d& position : {Vector2d(0, 0), Vector2d(4, 0), Vector2d(4, 3), Vector2d(0, 3)})
    points.push_back({"p", {600 + 200 * position.x(), 1000 - 200 * position.y()}, position});
  const auto fit = PlaneHomography::fit(camera, points);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_FALSE(fit->focal());
}

// The error of a position is what its covariance says: e' C^-1 e has mean 2 and standard deviation 2, the squared
// residuals their redundancy; four standard deviations of the means are granted. Both coordinates carry errors.
TEST(PlaneHomography, CovarianceMatchesTheRealErrors) {
  const Wall wall;
  constexpr int kTrials = 1500;
  const std::vector<Vector2d> positions = {{6, 4}, {1, 8}};
  std::vector<double> squared(positions.size(), 0);
  double residuals = 0, focal_squared = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Random random(3, std::uint64_t(trial));
    std::vector<PlanePoint> points;
    for (int i = 0; i < 12; ++i) {
      PlanePoint p = wall.point("p", 1 + 3 * (i % 4), 1 + 3 * (i / 4));
      p.sigma_px = i % 2 ? 0.5 : 1.5;
      p.sigma_m = i % 3 ? 0.002 : 0.01;
      p.pixel += p.sigma_px * Vector2d(random.normal(), random.normal());
      p.on_plane_m += p.sigma_m * Vector2d(random.normal(), random.normal());
      points.push_back(p);
    }
    const auto fit = PlaneHomography::fit(wall.camera, points);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_EQ(fit->redundancy(), 16);
    residuals += fit->sigma0() * fit->sigma0();
    const auto focal = fit->focal();
    ASSERT_TRUE(focal);
    focal_squared += std::pow((focal->times - 1) / focal->sigma, 2);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Vector2d e =
          position_of(*fit, wall.camera, wall.pixel({positions[i].x(), positions[i].y(), 0})) - positions[i];
      squared[i] += e.dot(fit->covariance_at(positions[i]).inverse() * e);
    }
  }
  for (const double sum : squared) EXPECT_NEAR(sum / kTrials, 2, 4 * 2 / std::sqrt(kTrials));
  EXPECT_NEAR(residuals / kTrials, 1, 4 * std::sqrt(2.0 / 16 / kTrials));
  EXPECT_NEAR(focal_squared / kTrials, 1, 4 * std::sqrt(2.0 / kTrials) + 0.05);  // of a square root: not quite normal
}

// Of the error e of one coordinate its residual shows v = r e, and the squares of all residuals add up to r e^2 = e v,
// whatever its redundancy r: to a fiftieth, since 12 px bend the projection by about a hundredth.
TEST(PlaneHomography, AWrongPointShows) {
  constexpr double kWrong_px = 12;
  const Wall wall;
  auto points = wall.corners();
  for (int i = 0; i < 4; ++i) points.push_back(wall.point("e" + std::to_string(i), 2 + 2 * i, 2 + i));
  points[5].pixel.x() += kWrong_px;
  const auto fit = PlaneHomography::fit(wall.camera, points);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_TRUE(fit->residuals_too_large());
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LE(fit->residuals()[i].in_sigmas, fit->residuals()[5].in_sigmas) << i;
    squares += fit->residuals()[i].px.squaredNorm();
  }
  const double shown_px = fit->residuals()[5].px.x();
  EXPECT_GT(shown_px, kWrong_px / 2);  // half of the sixteen coordinates are redundant
  EXPECT_NEAR(shown_px, squares / kWrong_px, 0.02 * kWrong_px);
}

// Its perspective hangs on its height alone: 5 cm are 8 px there, so the scale at its ends is known to a tenth, and a
// position between them to a few decimetres.
TEST(PlaneHomography, ANarrowStripIsEnough) {
  const Wall wall;
  const std::vector<PlanePoint> strip = {wall.point("a", 2, 3), wall.point("b", 9, 3), wall.point("c", 9, 3.05),
                                         wall.point("d", 2, 3.05)};
  const auto fit = PlaneHomography::fit(wall.camera, strip);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_LT((position_of(*fit, wall.camera, wall.pixel({5, 3.02, 0})) - Vector2d(5, 3.02)).norm(), 1e-7);
  EXPECT_GT(std::sqrt(fit->covariance_at({5, 3.02}).trace()), 0.1);
  EXPECT_LT(std::sqrt(fit->covariance_at({5, 3.02}).trace()), 0.5);
}

TEST(PlaneHomography, WhatGivesNoPlaneIsStatedInWords) {
  const Wall wall;
  const auto why = [&](const std::vector<PlanePoint>& points) -> std::string {
    const auto fit = PlaneHomography::fit(wall.camera, points);
    if (fit) return "";
    EXPECT_TRUE(fit.error().code == Errc::kIllPosed || fit.error().code == Errc::kBadInput);
    return fit.error().message;
  };
  const auto good = wall.corners();
  EXPECT_EQ(why(good), "");
  EXPECT_NE(why({good[0], good[1], good[2]}).find("four"), std::string::npos);
  std::vector<PlanePoint> line;
  for (int i = 0; i < 6; ++i) line.push_back(wall.point("l", 2 + i, 1 + 0.5 * i));
  EXPECT_NE(why(line).find("line"), std::string::npos);
  line.push_back(wall.point("aside", 3, 6));
  EXPECT_NE(why(line).find("line"), std::string::npos);  // all but one
  EXPECT_NE(why({good[0], good[0], good[0], good[0]}).find("line"), std::string::npos);
  auto exchanged = good;
  std::swap(exchanged[0].pixel, exchanged[1].pixel);
  EXPECT_NE(why(exchanged).find("exchanged"), std::string::npos);
  auto mirrored = good;
  for (PlanePoint& p : mirrored) p.on_plane_m.x() = -p.on_plane_m.x();
  EXPECT_NE(why(mirrored).find("other way"), std::string::npos);
  auto senseless = good;
  senseless[2].sigma_px = 0;
  EXPECT_NE(why(senseless).find("point c"), std::string::npos);
  senseless = good;
  senseless[1].pixel.x() = std::nan("");
  EXPECT_NE(why(senseless).find("point b"), std::string::npos);
}

// A point before the plane is shown where the line of sight through it meets the plane.
TEST(PlaneView, DepthShiftsAPositionAsStated) {
  const Wall wall;
  const auto fit = PlaneHomography::fit(wall.camera, wall.corners());
  ASSERT_TRUE(fit);
  const PlaneView view{ImageId{0}, wall.camera, fit->matrix(), centre_over_plane(fit->matrix())};
  for (const Vector2d& position : {Vector2d(3, 1.5), Vector2d(8, 2), Vector2d(5, 7)}) {
    constexpr double kDepth = 1e-4;
    const Vector2d shown = position_of(*fit, wall.camera, wall.pixel({position.x(), position.y(), kDepth}));
    EXPECT_NEAR((shown - position).norm() / kDepth, *shift_per_depth(view, position), 1e-4);
  }
  const double step = 1e-4, size_m = pixel_size_m(view, {6, 4});
  const Vector2d a = wall.pixel({6, 4, 0}), right = wall.pixel({6 + step, 4, 0}), up = wall.pixel({6, 4 + step, 0});
  Eigen::Matrix2d pixels;
  pixels << right - a, up - a;
  EXPECT_NEAR(1 / size_m, std::sqrt(std::abs(pixels.determinant())) / step, 0.06 / size_m);  // the lens is left out
  EXPECT_FALSE(pixel_of(view, {6, -400}).has_value());
  EXPECT_TRUE(std::isinf(pixel_size_m(view, {6, -400})));
}

// Franco 8: depths that shift a point of a plane rectification by 1 mm at image scale, at 100 mm from the nadir point
// of a vertical photograph: dZ = drho c mb / rho.
TEST(PlaneView, LargestDepthsOfFranco) {
  constexpr double kScales[] = {1000, 2000, 5000, 10000, 25000};
  const struct { double c_mm, depths_m[5]; } table[] = {{150, {1.5, 3, 7.5, 15, 37.5}}, {300, {3, 6, 15, 30, 75}}};
  for (const auto& row : table)
    for (std::size_t i = 0; i < 5; ++i) {
      const double height_m = 1e-3 * row.c_mm * kScales[i], radius_m = 0.1 * kScales[i];
      const PlaneView view{ImageId{0}, ideal_camera(1000, 1000, 1000), Eigen::Matrix3d::Identity(),
                           Eigen::Vector3d(0, 0, height_m)};
      EXPECT_NEAR(1e-3 * kScales[i] / *shift_per_depth(view, {radius_m, 0}), row.depths_m[i], 1e-9);
    }
}

}  // namespace
}  // namespace collinea
