// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/internal/fundamental.h"
#include "collinea/epipolar/internal/homography.h"
#include "collinea/epipolar/internal/two_view_problems.h"
#include "collinea/epipolar/p3p.h"
#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using namespace scene;

constexpr int kWorlds = 500;

template <std::size_t N, class PointOf>
SampledPairs<N> sample_of(const Rigid3& motion, Random& random, PointOf point) {
  const PointPairs pairs = pairs_of(motion, int(N), 0, random, point);
  std::array<int, N> all;
  for (std::size_t i = 0; i < N; ++i) all[i] = int(i);
  return {pairs, all};
}

// The nearest of several answers; the tolerance of a single world is loose because worlds near a critical configuration
// amplify rounding (1e-16) by the slope of a 10th-degree polynomial; the median is at rounding level.
struct Distances {
  std::vector<double> all;
  void add(double d) { all.push_back(d); }
  double quantile(double q) {
    std::sort(all.begin(), all.end());
    return all[static_cast<std::size_t>(q * static_cast<double>(all.size() - 1))];
  }
};

TEST(FivePoint, TruthIsAmongTheAnswers) {
  Random random(11);
  Distances distances;
  for (int world = 0; world < kWorlds; ++world) {
    const Rigid3 motion = random_motion(random);
    const auto sample = sample_of<5>(motion, random, random_point);
    double nearest = 9;
    for (const Eigen::Matrix3d& e : five_point(sample.first, sample.second))
      nearest = std::min(nearest, distance_up_to_scale(e, essential_matrix(motion)));
    distances.add(nearest);
  }
  EXPECT_LT(distances.quantile(0.5), 1e-11);
  EXPECT_LT(distances.quantile(0.99), 1e-6);
}

TEST(FivePoint, EveryAnswerIsEssentialAndFitsThePairs) {
  Random random(12);
  Distances fit, essential;
  for (int world = 0; world < kWorlds; ++world) {
    const auto sample = sample_of<5>(random_motion(random), random, random_point);
    for (const Eigen::Matrix3d& e : five_point(sample.first, sample.second)) {
      EXPECT_NEAR(e.norm(), std::sqrt(2.0), 1e-12);
      double worst = 0;
      for (std::size_t i = 0; i < 5; ++i)
        worst = std::max(worst, std::abs(sample.second[i].homogeneous().dot(e * sample.first[i].homogeneous())));
      fit.add(worst);
      essential.add((2 * e * e.transpose() * e - (e * e.transpose()).trace() * e).norm());
    }
  }
  EXPECT_LT(fit.quantile(1), 1e-12);
  EXPECT_LT(essential.quantile(0.5), 1e-11);
  EXPECT_LT(essential.quantile(0.99), 1e-6);
}

TEST(FivePoint, WorksOnAPlane) {
  Random random(13);
  Distances distances;
  for (int world = 0; world < 200; ++world) {
    const Rigid3 motion = random_motion(random);
    const auto sample = sample_of<5>(motion, random, random_point_on_plane);
    double nearest = 9;
    for (const Eigen::Matrix3d& e : five_point(sample.first, sample.second))
      nearest = std::min(nearest, distance_up_to_scale(e, essential_matrix(motion)));
    distances.add(nearest);
  }
  EXPECT_LT(distances.quantile(0.95), 1e-6);
}

TEST(FivePoint, RepeatedPairsAndLinesHaveNoAnswer) {
  Random random(14);
  const Rigid3 motion = random_motion(random);
  auto repeated = sample_of<5>(motion, random, random_point);
  repeated.first[3] = repeated.first[1];
  repeated.second[3] = repeated.second[1];
  EXPECT_TRUE(five_point(repeated.first, repeated.second).empty());
  const auto on_line = sample_of<5>(motion, random, [](Random& r) {
    const double s = r.uniform(-1, 1);
    return Eigen::Vector3d(s, 0.3 * s, 5);
  });
  EXPECT_TRUE(five_point(on_line.first, on_line.second).empty());
}

TEST(Motions, OneOfTheFourIsTheTruthAndLiesInFront) {
  Random random(15);
  for (int world = 0; world < 100; ++world) {
    const Rigid3 motion = random_motion(random);
    const PointPairs pairs = pairs_of(motion, 20, 0, random, random_point);
    const auto found = in_front(motions(essential_matrix(motion)), pairs, everyone(pairs), 1e-6);
    ASSERT_TRUE(found);
    EXPECT_LT(angle_between(found->rotation, motion.rotation), 1e-10);
    EXPECT_LT((found->translation - motion.translation).norm(), 1e-10);
  }
}

TEST(Meeting, DepthsAndAngleOfAKnownTriangle) {
  // Base 1 along x; the point 2 in front of both, seen under 2 atan(0.25).
  const Rigid3 motion{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  const RayMeeting at = meeting(motion, {0.25, 0}, {-0.25, 0});
  EXPECT_NEAR(at.depth_first, 2, 1e-14);
  EXPECT_NEAR(at.depth_second, 2, 1e-14);
  EXPECT_NEAR(at.angle_rad, 2 * std::atan(0.25), 1e-14);
  EXPECT_LT(meeting(motion, {-0.25, 0}, {0.25, 0}).depth_first, 0);
  EXPECT_TRUE(std::isinf(meeting(motion, {0.1, 0}, {0.1, 0}).depth_first));
}

TEST(SevenPoint, TruthIsAmongTheAnswersAndAllHaveRankTwo) {
  Random random(21);
  Distances distances, determinants;
  for (int world = 0; world < kWorlds; ++world) {
    const Rigid3 motion = random_motion(random);
    const auto sample = sample_of<7>(motion, random, random_point);
    double nearest = 9;
    for (const Eigen::Matrix3d& f : seven_point(sample.first, sample.second)) {
      nearest = std::min(nearest, distance_up_to_scale(f, essential_matrix(motion)));
      determinants.add(std::abs(f.determinant()));
    }
    distances.add(nearest);
  }
  EXPECT_LT(distances.quantile(0.5), 1e-11);
  EXPECT_LT(distances.quantile(0.99), 1e-6);
  EXPECT_LT(determinants.quantile(0.99), 1e-12);
}

TEST(SevenPoint, RepeatedPairsHaveNoAnswer) {
  Random random(22);
  auto sample = sample_of<7>(random_motion(random), random, random_point);
  sample.first[6] = sample.first[0];
  sample.second[6] = sample.second[0];
  EXPECT_TRUE(seven_point(sample.first, sample.second).empty());
}

TEST(EightPoint, FindsTheExactMatrixAndRefusesPlanesAndTooFew) {
  Random random(23);
  const Rigid3 motion = random_motion(random);
  const PointPairs pairs = pairs_of(motion, 30, 0, random, random_point);
  const std::vector<int> all = everyone(pairs);
  const auto found = eight_point(pairs, all);
  ASSERT_TRUE(found);
  EXPECT_LT(distance_up_to_scale(*found, essential_matrix(motion)), 1e-7);  // square root of rounding: normal equations
  EXPECT_FALSE(eight_point(pairs, std::span(all).first(7)));
  const PointPairs flat = pairs_of(motion, 30, 0, random, random_point_on_plane);
  EXPECT_FALSE(eight_point(flat, everyone(flat)));
}

TEST(FourPoint, FindsTheExactHomography) {
  Random random(31);
  Distances distances;
  for (int world = 0; world < kWorlds; ++world) {
    const auto sample = sample_of<4>(random_motion(random), random, random_point_on_plane);
    const auto h = four_point(sample.first, sample.second);
    if (!h) continue;  // three nearly on a line
    double worst = 0;
    for (std::size_t i = 0; i < 4; ++i)
      worst = std::max(worst, ((*h * sample.first[i].homogeneous()).hnormalized() - sample.second[i]).norm());
    distances.add(worst);
  }
  ASSERT_GT(distances.all.size(), 490u);
  EXPECT_LT(distances.quantile(0.9), 1e-12);
  EXPECT_LT(distances.quantile(1), 1e-8);
}

TEST(FourPoint, LinesAndSwappedSidesHaveNoAnswer) {
  const std::array<Eigen::Vector2d, 4> square = {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}, {0, 1}};
  const std::array<Eigen::Vector2d, 4> with_line = {Eigen::Vector2d(0, 0), {1, 0}, {2, 0}, {0, 1}};
  const std::array<Eigen::Vector2d, 4> repeated = {Eigen::Vector2d(0, 0), {1, 0}, {1, 0}, {0, 1}};
  const std::array<Eigen::Vector2d, 4> swapped = {Eigen::Vector2d(0, 0), {1, 1}, {1, 0}, {0, 1}};
  EXPECT_TRUE(four_point(square, square));
  EXPECT_FALSE(four_point(square, with_line));
  EXPECT_FALSE(four_point(with_line, square));
  EXPECT_FALSE(four_point(repeated, square));
  EXPECT_FALSE(four_point(square, swapped));
}

TEST(P3p, TruthIsAmongTheAnswersAndAllSeeThePoints) {
  Random random(41);
  Distances rotations, centres, angles;
  for (int world = 0; world < 2000; ++world) {
    const Rigid3 truth{rotation_by(random_vector(random, 2)), random_vector(random, 30)};
    std::array<Eigen::Vector3d, 3> rays, points;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d in_cam = random_point(random) * 10;
      rays[i] = in_cam.normalized();
      points[i] = inverse(truth) * in_cam;
    }
    double rotation = 9, centre = 9;
    for (const Rigid3& pose : p3p(rays, points)) {
      for (std::size_t i = 0; i < 3; ++i) angles.add(angle_between_vectors(pose * points[i], rays[i]));
      const double error = angle_between(pose.rotation, truth.rotation);
      if (error > rotation) continue;
      rotation = error;
      centre = (centre_of(pose) - centre_of(truth)).norm();
    }
    rotations.add(rotation);
    centres.add(centre);
  }
  EXPECT_LT(rotations.quantile(0.5), 1e-12);
  EXPECT_LT(rotations.quantile(0.99), 1e-8);
  EXPECT_LT(centres.quantile(0.99), 1e-6);
  EXPECT_LT(rotations.quantile(0.999), 1e-3);
  EXPECT_LT(angles.quantile(0.99), 1e-10);
}

TEST(P3p, PointsOnALineOrRepeatedHaveNoAnswer) {
  const std::array<Eigen::Vector3d, 3> rays = {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.1, 0, 1).normalized(),
                                               Eigen::Vector3d(0, 0.1, 1).normalized()};
  EXPECT_TRUE(p3p(rays, {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(2, 4, 6)}).empty());
  EXPECT_TRUE(p3p(rays, {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(2, 4, 6)}).empty());
  EXPECT_TRUE(
      p3p({rays[0], rays[0], rays[1]}, {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 3, 0), Eigen::Vector3d(2, 4, 6)})
          .empty());
}

TEST(PlanarMotions, OneIsTheTruth) {
  Random random(51);
  for (int world = 0; world < 200; ++world) {
    const Rigid3 motion = random_motion(random);
    const auto sample = sample_of<4>(motion, random, random_point_on_plane);
    const auto h = four_point(sample.first, sample.second);
    if (!h) continue;
    const PointPairs pairs = pairs_of(motion, 20, 0, random, random_point_on_plane);
    double nearest = 9;
    for (const PlanarMotion& m : planar_motions(*h, pairs, everyone(pairs)))
      nearest = std::min(nearest, angle_between(m.second_from_first.rotation, motion.rotation) +
                                      (m.second_from_first.translation - motion.translation).norm());
    EXPECT_LT(nearest, 1e-6);
  }
}

TEST(PlanarMotions, ARotationHasNone) {
  Random random(52);
  const Eigen::Matrix3d rotation = rotation_by({0.1, -0.2, 0.05}).toRotationMatrix();
  const PointPairs pairs = pairs_of({Eigen::Quaterniond(rotation), {0, 0, 0}}, 20, 0, random, random_point);
  EXPECT_TRUE(planar_motions(rotation, pairs, everyone(pairs)).empty());
  EXPECT_LT(angle_between(nearest_rotation(-3 * rotation), Eigen::Quaterniond(rotation)), 1e-12);
}

}  // namespace
}  // namespace collinea
