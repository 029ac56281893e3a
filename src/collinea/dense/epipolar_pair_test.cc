// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/epipolar_pair.h"
#include "collinea/dense/stereo.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/dense/internal/pinhole.h"
#include "collinea/dense/internal/test_scene.h"

namespace collinea {
namespace {

Camera with_distortion() {
  Camera camera = ideal_camera(400, 400, 320);
  camera.params[Camera::kK1] = -0.05;
  camera.params[Camera::kCx] += 7;
  return camera;
}

EpipolarPair pair_of(const Block& block, std::uint32_t a, std::uint32_t b) {
  const auto pair = epipolar_pair(block.camera_of(ImageId{a}), pose_of(block, ImageId{a}), block.camera_of(ImageId{b}),
                                  pose_of(block, ImageId{b}));
  EXPECT_TRUE(pair) << pair.error().message;
  return *pair;
}

TEST(EpipolarPair, PointsLieInTheSameRowAndDisparityTellsTheirDepth) {
  const test::Scene scene = test::Scene::of_four({}, with_distortion());
  for (const auto& [a, b] : {std::pair{0u, 1u}, {1u, 0u}, {0u, 3u}, {2u, 3u}}) {
    const EpipolarPair pair = pair_of(scene.block, a, b);
    const dense::Pinhole left(pair.left), right(pair.right);
    for (const auto& [id, point] : scene.block.points) {
      const Eigen::Vector3d in_left = pair.left_from_world * point.position_in_world;
      const Eigen::Vector3d in_right =
          pair.right_from_image * (pose_of(scene.block, ImageId{b}) * point.position_in_world);
      const Eigen::Vector2d p = left.project(in_left), q = right.project(in_right);
      EXPECT_NEAR(p.y(), q.y(), 1e-9);
      EXPECT_NEAR(p.x() - q.x(), pair.disparity_at(in_left.z()), 1e-9);
      EXPECT_NEAR(pair.depth_at(p.x() - q.x()), in_left.z(), 1e-9);
    }
  }
}

TEST(EpipolarPair, KeepsTheSizeOfPixels) {
  const test::Scene scene = test::Scene::of_four({}, with_distortion());
  const EpipolarPair pair = pair_of(scene.block, 0, 1);
  EXPECT_NEAR(pair.left.focal_px(), 400, 10);
  EXPECT_NEAR(pair.base_m, 2, 1e-9);
}

TEST(EpipolarPair, CamerasThatLookAtEachOtherHaveNone) {
  const Camera camera = ideal_camera(200, 200, 160);
  const Rigid3 here, ahead{Eigen::Quaterniond::Identity(), {0, 0, -3}},
      beside{Eigen::Quaterniond::Identity(), {-3, 0, 0}};
  EXPECT_TRUE(epipolar_pair(camera, here, camera, beside));
  for (const Rigid3& other : {here, ahead}) {
    const auto pair = epipolar_pair(camera, here, camera, other);
    ASSERT_FALSE(pair);
    EXPECT_EQ(pair.error().code, Errc::kIllPosed);
  }
  const Rigid3 back{Eigen::Quaterniond(Eigen::AngleAxisd(3.1, Eigen::Vector3d::UnitY())), {-3, 0, 0}};
  EXPECT_FALSE(epipolar_pair(camera, here, camera, back));
}

TEST(EpipolarPair, TheRangeHoldsEveryTiePoint) {
  const test::Scene scene = test::Scene::of_four({.roof = 1.5}, with_distortion());
  const EpipolarPair pair = pair_of(scene.block, 0, 1);
  std::vector<Eigen::Vector3d> points;
  for (const auto& [id, point] : scene.block.points) points.push_back(point.position_in_world);
  const auto range = range_of(pair, points);
  ASSERT_TRUE(range);
  for (const Eigen::Vector3d& point : points) {
    const double disparity = pair.disparity_at((pair.left_from_world * point).z());
    EXPECT_GE(disparity, range->low);
    EXPECT_LE(disparity, range->high);
  }
  EXPECT_FALSE(range_of(pair, std::span(points).first(7)));
}

// From images to the cloud: a slope and a block on it, both lenses distorted.
TEST(EpipolarPair, TheCloudLiesOnTheSurface) {
  const test::Scene scene = test::Scene::of_four({.roof = 1.5, .noise = 2}, with_distortion());
  const EpipolarPair pair = pair_of(scene.block, 0, 1);
  const auto image = [&](std::uint32_t id) { return *scene.pixels()(ImageId{id}, 1); };
  const GreyImage left = resampled(image(0), with_distortion(), pair.left_from_image, pair.left, {});
  const GreyImage right = resampled(image(1), with_distortion(), pair.right_from_image, pair.right, {});
  std::vector<Eigen::Vector3d> points;
  for (const auto& [id, point] : scene.block.points) points.push_back(point.position_in_world);
  const auto range = range_of(pair, points);
  ASSERT_TRUE(range);
  const auto map = match_pair(left, right, *range, {}, {});
  ASSERT_TRUE(map) << map.error().message;
  const auto cloud = cloud_of(pair, *map, {});
  ASSERT_GT(cloud.size(), 40'000u);
  double squares = 0, relative = 0;
  int good = 0, up = 0;
  for (const FusedPoint& point : cloud) {
    const Eigen::Vector3d& p = point.position_in_world;
    const bool on_roof = std::abs(p.x()) < 1 && std::abs(p.y()) < 0.8;
    const double off = p.z() - (on_roof ? 1.5 : 0.1 * p.x());
    if (std::abs(off) > 0.2) continue;
    ++good;
    up += point.normal_in_world.z() > 0.8f;
    squares += off * off;
    relative += std::pow(off / point.sigma, 2);
  }
  EXPECT_GT(good, 0.97 * double(cloud.size()));
  EXPECT_GT(up, 0.9 * good);
  // a tenth of a pixel of disparity: z^2 / (f b) = 12.5 cm a pixel
  EXPECT_LT(std::sqrt(squares / good), 0.0125 * 1.5);
  EXPECT_LT(std::sqrt(relative / good), 1.4);
}

}  // namespace
}  // namespace collinea
