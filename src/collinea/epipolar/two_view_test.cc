// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/two_view.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using namespace scene;

Camera lens() {
  Camera camera = ideal_camera(2000, 3000, 2000);
  camera.params[Camera::kK1] = -0.05;
  camera.params[Camera::kK2] = 0.01;
  return camera;
}

// Two images and their matches; the first `good` matches are right, the others join random pixels.
struct MatchedImages {
  std::vector<Keypoint> first, second;
  std::vector<Match> matches;
  std::size_t good = 0;

  void add(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    matches.push_back({static_cast<std::uint32_t>(first.size()), static_cast<std::uint32_t>(second.size())});
    first.push_back({static_cast<float>(a.x()), static_cast<float>(a.y())});
    second.push_back({static_cast<float>(b.x()), static_cast<float>(b.y())});
  }
  [[nodiscard]] std::size_t right_ones(const ImagePair& pair) const {
    return static_cast<std::size_t>(
        std::count_if(pair.matches.begin(), pair.matches.end(), [&](const Match& m) { return m.first < good; }));
  }
};

Eigen::Vector2d random_pixel(Random& random) { return {random.uniform(0, 3000), random.uniform(0, 2000)}; }

template <class PointOf>
MatchedImages matched_images(const Camera& camera, const Rigid3& second_from_first, int good, int bad, double sigma_px,
                             Random& random, PointOf point) {
  MatchedImages result;
  while (static_cast<int>(result.first.size()) < good) {
    const Eigen::Vector3d x = point(random);
    const auto a = project(camera, x), b = project(camera, second_from_first * x);
    if (!a || !b || !inside(camera, *a) || !inside(camera, *b)) continue;
    result.add(*a + noise(random, sigma_px), *b + noise(random, sigma_px));
  }
  result.good = result.first.size();
  for (int i = 0; i < bad; ++i) result.add(random_pixel(random), random_pixel(random));
  return result;
}

ImagePair verified(const Camera& camera, const MatchedImages& p, std::uint64_t seed = 1) {
  return verify(camera, p.first, camera, p.second, p.matches, {}, seed);
}

void expect_motion(const ImagePair& pair, const Rigid3& truth, double tolerance_rad) {
  EXPECT_LT(angle_between(pair.second_from_first.rotation, truth.rotation), tolerance_rad);
  EXPECT_LT(angle_between_vectors(pair.second_from_first.translation, truth.translation), 5 * tolerance_rad);
}

TEST(Verify, FindsTheMotionAmongManyOutliers) {
  Random random(1);
  for (const double share : {0.0, 0.5, 0.7}) {
    const Rigid3 truth = random_motion(random);
    const int good = 150, bad = static_cast<int>(good * share / (1 - share));
    const MatchedImages p = matched_images(lens(), truth, good, bad, 0.5, random, random_point);
    const ImagePair pair = verified(lens(), p);
    EXPECT_EQ(pair.geometry, PairGeometry::kGeneral);
    EXPECT_EQ(pair.putative, good + bad);
    EXPECT_GE(p.right_ones(pair), 147u);
    EXPECT_LE(pair.matches.size(), 152u + 0.02 * bad);
    expect_motion(pair, truth, 0.004);
    EXPECT_TRUE(std::is_sorted(pair.matches.begin(), pair.matches.end()));
    EXPECT_GT(pair.median_parallax_rad, 0.03);
  }
}

TEST(Verify, PerfectPairIsFoundToFloatPrecision) {
  Random random(2);
  const Rigid3 truth = random_motion(random);
  const ImagePair pair = verified(lens(), matched_images(lens(), truth, 200, 0, 0, random, random_point));
  EXPECT_EQ(pair.matches.size(), 200u);
  expect_motion(pair, truth, 1e-6);  // keypoints are floats: 1e-4 px of 2000
}

TEST(Verify, PlaneIsRecognisedAndOneOfItsMotionsGiven) {
  Random random(3);
  for (int k = 0; k < 5; ++k) {
    const Rigid3 truth = random_motion(random);
    const MatchedImages p = matched_images(lens(), truth, 200, 100, 0.5, random, random_point_on_plane);
    const ImagePair pair = verified(lens(), p);
    EXPECT_EQ(pair.geometry, PairGeometry::kPlanar);
    EXPECT_GE(p.right_ones(pair), 195u);
    EXPECT_NEAR(pair.second_from_first.translation.norm(), 1, 1e-9);
  }
}

TEST(Verify, PlaneWithSomethingOnItHasTheRightMotion) {
  Random random(4);
  for (int k = 0; k < 5; ++k) {
    const Rigid3 truth = random_motion(random);
    const MatchedImages p = matched_images(lens(), truth, 200, 60, 0.5, random, [](Random& r) {
      return r.uniform() < 0.9 ? random_point_on_plane(r) : random_point(r);
    });
    const ImagePair pair = verified(lens(), p);
    EXPECT_NE(pair.geometry, PairGeometry::kNone);
    EXPECT_NE(pair.geometry, PairGeometry::kRotation);
    expect_motion(pair, truth, 0.01);
  }
}

TEST(Verify, PureRotationIsRecognised) {
  Random random(5);
  for (int k = 0; k < 5; ++k) {
    const Rigid3 rotation{rotation_by(random_vector(random, 0.2)), {0, 0, 0}};
    const MatchedImages p = matched_images(lens(), rotation, 200, 100, 0.5, random, random_point);
    const ImagePair pair = verified(lens(), p);
    EXPECT_EQ(pair.geometry, PairGeometry::kRotation);
    EXPECT_GE(p.right_ones(pair), 190u);
    EXPECT_LT(angle_between(pair.second_from_first.rotation, rotation.rotation), 1e-3);
    EXPECT_EQ(pair.second_from_first.translation.norm(), 0);
    EXPECT_LT(pair.median_parallax_rad, 1e-3);
  }
}

TEST(Verify, PureRotationIsRecognisedThroughAWrongFocalLength) {
  Random random(6);
  const Rigid3 rotation{rotation_by({0.02, 0.2, 0.01}), {0, 0, 0}};
  const MatchedImages p = matched_images(lens(), rotation, 200, 50, 0.5, random, random_point);
  Camera wrong = lens();
  wrong.params[Camera::kF] *= 1.08;
  wrong.prior.sigma_f_px = 0.08 * wrong.focal_px();
  EXPECT_EQ(verified(wrong, p).geometry, PairGeometry::kRotation);
}

TEST(Verify, PureRotationIsRecognisedThroughALensNotYetCalibrated) {
  Random random(13);
  const Rigid3 rotation{rotation_by({0.02, 0.2, 0.01}), {0, 0, 0}};
  const MatchedImages p = matched_images(lens(), rotation, 200, 50, 0.5, random, random_point);
  Camera first_guess = ideal_camera(2000 * 1.05, 3000, 2000);
  first_guess.prior.sigma_f_px = 0.05 * first_guess.focal_px();
  EXPECT_EQ(verified(first_guess, p).geometry, PairGeometry::kRotation);
}

// An image with few pixels: what a lens may feign is a share of its width, not a number of pixels.
Camera small_camera() {
  Camera camera = ideal_camera(533, 336, 256);
  camera.prior.sigma_f_px = 0.05 * camera.focal_px();
  return camera;
}

TEST(Verify, AFlightOverFlatGroundWithSmallImagesIsNoRotation) {
  Random random(17);
  for (int k = 0; k < 5; ++k) {
    const Rigid3 truth{rotation_by(random_vector(random, 0.02)), {0.05, -0.35, 0.02}};
    const MatchedImages p = matched_images(small_camera(), truth, 300, 0, 0.3, random, [](Random& r) {
      const double depth = r.uniform() < 0.7 ? 5 : r.uniform(4.7, 5);  // houses on flat ground
      return Eigen::Vector3d(r.uniform(-0.35, 0.35) * depth, r.uniform(-0.35, 0.35) * depth, depth);
    });
    EXPECT_NE(verified(small_camera(), p).geometry, PairGeometry::kRotation) << k;
  }
}

TEST(Verify, PureRotationOfSmallImagesIsRecognisedThroughALensNotYetCalibrated) {
  Random random(18);
  for (int k = 0; k < 5; ++k) {
    const Rigid3 rotation{rotation_by({0.02, 0.1, 0.01}), {0, 0, 0}};
    Camera truth = small_camera();
    truth.params[Camera::kF] *= 0.97;
    truth.params[Camera::kK1] = -0.05;
    truth.params[Camera::kK2] = 0.01;
    const MatchedImages p = matched_images(truth, rotation, 200, 0, 0.3, random, random_point);
    EXPECT_EQ(verified(small_camera(), p).geometry, PairGeometry::kRotation) << k;
  }
}

TEST(Verify, RandomMatchesAreRefused) {
  Random random(7);
  for (const int count : {20, 60, 300, 1500})
    EXPECT_EQ(verified(lens(), matched_images(lens(), {}, 0, count, 0, random, random_point)).geometry,
              PairGeometry::kNone)
        << count;
}

TEST(Verify, WatermarkIsRefusedButNotWhatLiesBehindIt) {
  Random random(8);
  MatchedImages mark;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d at(random.uniform(2500, 2900), random.uniform(1800, 1950));
    mark.add(at, at + noise(random, 0.2));
  }
  EXPECT_EQ(verified(lens(), mark).geometry, PairGeometry::kNone);

  const Rigid3 truth = random_motion(random);
  MatchedImages both = matched_images(lens(), truth, 40, 0, 0.5, random, random_point);
  for (std::size_t i = 0; i < 300; ++i) {
    const Eigen::Vector2d at(random.uniform(2500, 2900), random.uniform(1800, 1950));
    both.add(at, at + noise(random, 0.2));
  }
  const ImagePair pair = verified(lens(), both);
  EXPECT_EQ(pair.geometry, PairGeometry::kGeneral);
  EXPECT_GE(both.right_ones(pair), 38u);
  EXPECT_LE(pair.matches.size(), 45u);
}

// A camera that does not turn fits every mark: its essential matrix takes it for something far away. And the geometry
// of no motion at all would fit the mark and much else by chance.
TEST(Verify, DateBurntIntoTheImageIsNoMatch) {
  Random random(17);
  for (const Rigid3& motion : {Rigid3{rotation_by({0, 0, 0}), {-1, 0, 0}}, Rigid3{rotation_by({0, 0, 0}), {0, 0.1, -1}},
                               Rigid3{rotation_by({0.02, 0.2, 0.01}), {0, 0, 0}}, random_motion(random)})
    for (const int marks : {8, 40, 120}) {
      MatchedImages p = matched_images(lens(), motion, 200, 60, 0.5, random, random_point);
      const std::size_t scene = p.first.size();
      for (int i = 0; i < marks; ++i) {
        const Eigen::Vector2d at(random.uniform(100, 600), random.uniform(1850, 1950));
        p.add(at, at + noise(random, 0.3));
      }
      const ImagePair pair = verified(lens(), p);
      EXPECT_EQ(pair.geometry, motion.translation.norm() > 0 ? PairGeometry::kGeneral : PairGeometry::kRotation);
      EXPECT_GE(p.right_ones(pair), 190u);
      for (const Match& m : pair.matches) EXPECT_LT(m.first, scene) << marks << " marks";
    }
}

// Ahead of a camera that moves forward, what is far away hardly moves.
TEST(Verify, WhatHardlyMovesBecauseItIsFarAwayStays) {
  Random random(18);
  const Rigid3 ahead{rotation_by({0, 0, 0}), {0, 0, -1}};
  const MatchedImages p = matched_images(lens(), ahead, 400, 50, 0.3, random, [](Random& r) {
    const double depth = std::exp(r.uniform(1, 8));
    return Eigen::Vector3d(r.uniform(-0.6, 0.6) * depth, r.uniform(-0.4, 0.4) * depth, depth);
  });
  std::size_t still = 0;
  for (std::size_t i = 0; i < p.good; ++i)
    still += std::hypot(p.first[i].x - p.second[i].x, p.first[i].y - p.second[i].y) < 1.5;
  EXPECT_GT(still, 50u);
  EXPECT_GE(p.right_ones(verified(lens(), p)), 390u);
}

TEST(Verify, LinesRepeatedPointsAndTooFewHaveNoGeometry) {
  Random random(9);
  const Rigid3 truth = random_motion(random);
  const auto on_line = [](Random& r) {
    const double s = r.uniform(-1, 1);
    return Eigen::Vector3d(s, 0.3 * s, 5);
  };
  EXPECT_EQ(verified(lens(), matched_images(lens(), truth, 100, 0, 0, random, on_line)).geometry, PairGeometry::kNone);
  EXPECT_EQ(verified(lens(), matched_images(lens(), truth, 100, 0, 0.5, random, on_line)).geometry,
            PairGeometry::kNone);
  MatchedImages repeated;
  for (int i = 0; i < 100; ++i) repeated.add({700, 800}, {900, 750});
  EXPECT_EQ(verified(lens(), repeated).geometry, PairGeometry::kNone);
  EXPECT_EQ(verified(lens(), matched_images(lens(), truth, 14, 0, 0, random, random_point)).geometry,
            PairGeometry::kNone);
  EXPECT_EQ(verified(lens(), {}).geometry, PairGeometry::kNone);
}

TEST(Verify, AssumedFocalLengthKeepsTheMatchesAndFindsTheMotion) {
  Random random(10);
  for (const double factor : {0.6, 1.0, 1.5}) {
    const Rigid3 truth = random_motion(random);
    const MatchedImages p = matched_images(lens(), truth, 200, 200, 0.5, random, random_point);
    Camera assumed = lens();
    assumed.params[Camera::kF] *= factor;
    assumed.prior.sigma_f_px = 0.4 * assumed.focal_px();
    const ImagePair pair = verified(assumed, p);
    EXPECT_EQ(pair.geometry, PairGeometry::kGeneral) << factor;
    EXPECT_GE(p.right_ones(pair), 190u) << factor;
    EXPECT_LT(angle_between(pair.second_from_first.rotation, truth.rotation), 0.1) << factor;
  }
}

TEST(Verify, FocalLengthOfTheExifTenPercentOffIsGoodEnough) {
  Random random(11);
  for (const double factor : {0.9, 1.1}) {
    const Rigid3 truth = random_motion(random);
    const MatchedImages p = matched_images(lens(), truth, 200, 100, 0.5, random, random_point);
    Camera off = lens();
    off.params[Camera::kF] *= factor;
    off.prior.sigma_f_px = 0.05 * off.focal_px();
    const ImagePair pair = verified(off, p);
    EXPECT_EQ(pair.geometry, PairGeometry::kGeneral) << factor;
    EXPECT_GE(p.right_ones(pair), 150u) << factor;
    EXPECT_LT(angle_between(pair.second_from_first.rotation, truth.rotation), 0.05) << factor;
  }
}

TEST(Verify, FlatSceneThroughAWrongFocalLengthKeepsItsMatches) {
  Random random(16);
  for (const double factor : {0.93, 1.07}) {
    const Rigid3 truth{rotation_by({0.03, 0.05, 0.2}), {-1, 0.1, 0.05}};
    const MatchedImages p = matched_images(lens(), truth, 300, 100, 0.5, random, [](Random& r) {
      const double depth = r.uniform() < 0.7 ? 5 : r.uniform(4.8, 5);  // houses on flat ground
      return Eigen::Vector3d(r.uniform(-0.7, 0.7) * depth, r.uniform(-0.5, 0.5) * depth, depth);
    });
    Camera off = ideal_camera(2000 * factor, 3000, 2000);
    off.prior.sigma_f_px = 0.05 * off.focal_px();
    const ImagePair pair = verified(off, p);
    EXPECT_NE(pair.geometry, PairGeometry::kNone) << factor;
    EXPECT_NE(pair.geometry, PairGeometry::kRotation) << factor;
    EXPECT_GE(p.right_ones(pair), 270u) << factor;
    EXPECT_LT(angle_between(pair.second_from_first.rotation, truth.rotation), 0.06) << factor;
  }
}

TEST(Verify, SameSeedSameBits) {
  Random random(12);
  const MatchedImages p = matched_images(lens(), random_motion(random), 150, 150, 0.5, random, random_point);
  const ImagePair a = verified(lens(), p, 3), b = verified(lens(), p, 3);
  EXPECT_EQ(a.matches, b.matches);
  EXPECT_EQ(a.second_from_first.translation, b.second_from_first.translation);
  EXPECT_EQ(a.median_parallax_rad, b.median_parallax_rad);
}

}  // namespace
}  // namespace collinea
