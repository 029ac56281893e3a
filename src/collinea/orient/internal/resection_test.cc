// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/resection.h"

#include <gtest/gtest.h>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using namespace scene;

Camera lens() {
  Camera camera = ideal_camera(2000, 3000, 2000);
  camera.params[Camera::kK1] = -0.08;
  camera.params[Camera::kK2] = 0.02;
  camera.params[Camera::kP1] = 4e-4;
  return camera;
}

struct Seen {
  Rigid3 cam_from_world;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> points;
};

// World 1 km from its origin, as surveys have it; wrong pixels after the good ones.
Seen seen_by(const Camera& camera, int good, int bad, double sigma_px, Random& random) {
  Seen world;
  world.cam_from_world = {rotation_by(random_vector(random, 2)), random_vector(random, 1000)};
  while (static_cast<int>(world.pixels.size()) < good + bad) {
    const Eigen::Vector3d in_cam = random_point(random) * 10;
    const auto pixel = project(camera, in_cam);
    if (!pixel || !inside(camera, *pixel)) continue;
    const bool wrong = static_cast<int>(world.pixels.size()) >= good;
    world.points.push_back(inverse(world.cam_from_world) * in_cam);
    world.pixels.push_back(wrong ? Eigen::Vector2d(random.uniform(0, 3000), random.uniform(0, 2000))
                                 : Eigen::Vector2d(*pixel + noise(random, sigma_px)));
  }
  return world;
}

TEST(Resect, FindsTheExactPose) {
  Random random(1);
  for (int k = 0; k < 20; ++k) {
    const Seen world = seen_by(lens(), 30, 0, 0, random);
    const auto found = resect(lens(), world.pixels, world.points, {}, 1);
    ASSERT_TRUE(found);
    EXPECT_LT(angle_between(found->cam_from_world.rotation, world.cam_from_world.rotation), 1e-9);
    EXPECT_LT((centre_of(found->cam_from_world) - centre_of(world.cam_from_world)).norm(), 1e-6);
    EXPECT_EQ(found->inliers, 30);
    EXPECT_LT(found->rms_px, 1e-6);
  }
}

TEST(Resect, SeventyPercentOutliersDoNoHarm) {
  Random random(2);
  for (int k = 0; k < 15; ++k) {
    const Seen world = seen_by(lens(), 90, 210, 0.5, random);
    const auto found = resect(lens(), world.pixels, world.points, {}, static_cast<std::uint64_t>(k));
    ASSERT_TRUE(found);
    EXPECT_LT(angle_between(found->cam_from_world.rotation, world.cam_from_world.rotation), 1e-3);
    EXPECT_LT((centre_of(found->cam_from_world) - centre_of(world.cam_from_world)).norm(), 0.05);  // 50 m away
    for (int i = 0; i < 90; ++i) EXPECT_EQ(found->inlier[static_cast<std::size_t>(i)], 1);
    EXPECT_LE(found->inliers, 93);
    EXPECT_NEAR(found->rms_px, 0.5 * std::sqrt(2), 0.2);
  }
}

TEST(Resect, ErrorsGrowWithTheNoise) {
  const auto mean_error = [](double sigma_px) {
    Random random(3);
    double sum = 0;
    for (int k = 0; k < 30; ++k) {
      const Seen world = seen_by(lens(), 100, 0, sigma_px, random);
      sum += (centre_of(resect(lens(), world.pixels, world.points, {}, 1)->cam_from_world) -
              centre_of(world.cam_from_world))
                 .norm();
    }
    return sum / 30;
  };
  EXPECT_NEAR(mean_error(0.4) / mean_error(0.2), 2, 0.2);
}

TEST(Resect, SameSeedSameBits) {
  Random random(4);
  const Seen world = seen_by(lens(), 60, 60, 0.5, random);
  const auto a = resect(lens(), world.pixels, world.points, {}, 5),
             b = resect(lens(), world.pixels, world.points, {}, 5);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->cam_from_world.translation, b->cam_from_world.translation);
  EXPECT_EQ(a->inlier, b->inlier);
}

TEST(Resect, LinesFewPointsAndNonsenseHaveNoAnswer) {
  Random random(5);
  Seen world = seen_by(lens(), 40, 0, 0, random);
  EXPECT_FALSE(resect(lens(), std::span(world.pixels).first(3), std::span(world.points).first(3), {}, 1));
  EXPECT_FALSE(resect(lens(), {}, {}, {}, 1));
  const Seen wrong = seen_by(lens(), 0, 200, 0, random);
  EXPECT_FALSE(resect(lens(), wrong.pixels, wrong.points, {}, 1));
  for (std::size_t i = 0; i < world.points.size(); ++i) {
    const double s = static_cast<double>(i) / 10;
    const Eigen::Vector3d in_cam(s - 2, 0.2 * s, 20 + s);
    world.points[i] = inverse(world.cam_from_world) * in_cam;
    world.pixels[i] = *project(lens(), in_cam);
  }
  EXPECT_FALSE(resect(lens(), world.pixels, world.points, {}, 1));
  const Seen one = seen_by(lens(), 1, 0, 0, random);
  EXPECT_FALSE(resect(lens(), std::vector<Eigen::Vector2d>(40, one.pixels[0]),
                      std::vector<Eigen::Vector3d>(40, one.points[0]), {}, 1));
}

TEST(ResectWithFocal, FindsTheFocalLength) {
  Random random(6);
  for (const double factor : {0.55, 0.8, 1.0, 1.3, 1.9}) {
    const Seen world = seen_by(lens(), 100, 60, 0.3, random);
    Camera guessed = lens();
    guessed.params[Camera::kF] /= factor;
    const auto found = resect_with_focal(guessed, world.pixels, world.points, {}, 1);
    ASSERT_TRUE(found) << factor;
    EXPECT_NEAR(found->camera.focal_px(), 2000, 10) << factor;
    EXPECT_GE(found->inliers, 98) << factor;
    EXPECT_LT(angle_between(found->cam_from_world.rotation, world.cam_from_world.rotation), 3e-3) << factor;
  }
}

// Every wrong point is off by so many pixels, less than what a lens that is known badly may leave.
Seen off_by(double size_px, int good, int bad, Random& random) {
  Seen world = seen_by(lens(), good + bad, 0, 0.5, random);
  for (int i = good; i < good + bad; ++i) {
    const double angle = random.uniform(0, 6.283);
    world.pixels[static_cast<std::size_t>(i)] += size_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  return world;
}

// By a limit of a tenth of the width those that are 150 px off count as right and bend the pose; by the errors that the
// others show they do not. The pose of 22 points is known to a few centimetres at 30 to 80 m.
TEST(Resect, WithoutALimitFortyFivePercentWrongDoNoHarm) {
  const ResectOptions loose{.max_error_px = 300, .min_inliers = 4, .min_inlier_ratio = 0.5};
  double bent_m = 0;
  for (const RobustStart start : {RobustStart::kTruncated, RobustStart::kLeastMedian, RobustStart::kL1})
    for (const double size_px : {30.0, 150.0, 1000.0}) {
      Random random(11);
      for (int k = 0; k < 10; ++k) {
        const Seen world = off_by(size_px, 22, 18, random);
        ResectOptions options = loose;
        options.start = start;
        const auto found = resect(lens(), world.pixels, world.points, options, 1);
        ASSERT_TRUE(found) << word_of(start) << " " << size_px;
        const double off_m = (centre_of(found->cam_from_world) - centre_of(world.cam_from_world)).norm();
        if (start == RobustStart::kTruncated) {
          bent_m = std::max(bent_m, off_m);
          continue;
        }
        EXPECT_LT(off_m, 0.3) << word_of(start) << " " << size_px;
        for (std::size_t i = 22; i < 40; ++i) EXPECT_FALSE(found->inlier[i]) << word_of(start) << " " << size_px;
      }
    }
  EXPECT_GT(bent_m, 0.5);
}

TEST(Resect, WithoutALimitAFewOfFewPointsMayBeWrong) {
  Random random(12);
  for (int k = 0; k < 10; ++k) {
    const Seen world = off_by(80, 7, 2, random);
    const auto found =
        resect(lens(), world.pixels, world.points,
               {.max_error_px = 300, .min_inliers = 4, .min_inlier_ratio = 0.5, .start = RobustStart::kLeastMedian}, 1);
    ASSERT_TRUE(found);
    EXPECT_LT((centre_of(found->cam_from_world) - centre_of(world.cam_from_world)).norm(), 1);
    EXPECT_FALSE(found->inlier[7] || found->inlier[8]);
  }
}

TEST(Resect, WithoutALimitPointsOnALineAreNoAnswer) {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 12; ++i) {
    points.emplace_back(i - 5, 0.5 * (i - 5), 30);
    pixels.push_back(*project(lens(), points.back()));
  }
  for (const RobustStart start : {RobustStart::kLeastMedian, RobustStart::kL1})
    EXPECT_FALSE(resect(lens(), pixels, points, {.min_inliers = 4, .start = start}, 1)) << word_of(start);
}

}  // namespace
}  // namespace collinea
