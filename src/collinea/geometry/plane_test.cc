// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/plane.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

TEST(FramedPlane, IsSeenUprightFromTheFront) {
  const FramedPlane south = framed_plane({1, 2, 3}, -Vector3d::UnitY());  // seen from the south
  EXPECT_LT((south.world_from_plane.col(0) - Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((south.world_from_plane.col(1) - Vector3d::UnitZ()).norm(), 1e-12);
  const FramedPlane level = framed_plane({0, 0, 0}, Vector3d(0.05, 0, 1));
  EXPECT_GT(level.world_from_plane(1, 1), 0.99);
  for (const Vector3d& normal : {Vector3d(1, 2, 0.5), Vector3d(0, 0, 1), Vector3d(0, 1, 0), Vector3d(0, 0.1, -1)})
    for (const Vector3d& up : {Vector3d(0, 0, 1), Vector3d(0, -1, 0.01), Vector3d(0, 1, 0)}) {
      const FramedPlane plane = framed_plane({5, 6, 7}, normal, up);
      EXPECT_LT((plane.world_from_plane.transpose() * plane.world_from_plane - Eigen::Matrix3d::Identity()).norm(),
                1e-12);
      EXPECT_GT(plane.world_from_plane.determinant(), 0);
      EXPECT_LT((plane.world_from_plane.col(2) - normal.normalized()).norm(), 1e-12);
      EXPECT_LT((plane.in_plane(Vector3d(5, 6, 7) + 2 * plane.world_from_plane.col(0)) - Vector3d(2, 0, 0)).norm(),
                1e-12);
    }
}

TEST(FitPlane, PointsOnALineGiveNone) {
  std::vector<Vector3d> points = {{0, 0, 0}, {1, 1, 1}};
  EXPECT_FALSE(fit_plane(points));
  points.emplace_back(2, 2, 2);
  EXPECT_FALSE(fit_plane(points));
  EXPECT_FALSE(find_plane(points, 0.1, 1));
  EXPECT_FALSE(find_plane(std::vector<Vector3d>(50, Vector3d(1, 2, 3)), 0.1, 1));
  points.emplace_back(2, 0, 2);
  const auto fit = fit_plane(points);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(std::abs(fit->normal.dot(Vector3d(1, 0, -1).normalized())), 1, 1e-12);
  EXPECT_LT(fit->rms_m, 1e-12);
}

// A wall with 30 % of its points in windows, before it a hedge: the wall, to what its noise allows.
TEST(FindPlane, TheLargestPlaneIsFoundAmongOthers) {
  Random random(5);
  const Vector3d normal = Vector3d(0.3, -1, 0.02).normalized();
  const FramedPlane wall = framed_plane({10, 20, 5}, normal);
  std::vector<Vector3d> points;
  for (int i = 0; i < 6000; ++i) {
    const double depth = i % 10 < 3 ? -0.25 : 0.005 * random.normal();
    points.push_back(wall.origin_in_world +
                     wall.world_from_plane * Vector3d(12 * random.uniform(), 8 * random.uniform(), depth));
  }
  for (int i = 0; i < 4000; ++i)
    points.push_back(Vector3d(10 + 12 * random.uniform(), 14 + 3 * random.uniform(), 5 + 2 * random.uniform()));
  const auto fit = find_plane(points, 0.02, 1);
  ASSERT_TRUE(fit);
  EXPECT_GT(std::abs(fit->normal.dot(normal)), 1 - 1e-7);
  EXPECT_LT(std::abs(normal.dot(fit->middle - wall.origin_in_world)), 1e-3);
  EXPECT_NEAR(fit->rms_m, 0.005, 0.001);
  EXPECT_GT(fit->points.size(), 4100u);
  std::vector<Vector3d> fog;
  for (int i = 0; i < 3000; ++i) fog.emplace_back(random.uniform(), random.uniform(), random.uniform());
  EXPECT_FALSE(find_plane(fog, 0.005, 1));
}

}  // namespace
}  // namespace collinea
