// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/space_resection.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector3d random_vector(Random& random, double size) {
  return {size * random.normal(), size * random.normal(), size * random.normal()};
}

// An image or two from 100 m above ground of 40 m width and some relief.
struct Scene {
  Camera camera = ideal_camera(4000, 4000, 3000);
  std::vector<Rigid3> poses;
  std::vector<ResectionMark> marks;
  std::vector<ResectionPoint> points;
  std::vector<Vector3d> truth;

  Scene(std::uint64_t seed, int count, double sigma_px, double sigma_m, int images = 1, int ties = 0) {
    Random random(seed);
    for (int a = 0; a < images; ++a) {
      const Rigid3 pose{cam_from_world({6 * random.normal(), 6 * random.normal(), 60 * random.normal()}), {0, 0, 0}};
      const Vector3d centre = Vector3d(40 * a, 0, 100) + random_vector(random, 3);
      poses.push_back({pose.rotation, -(pose.rotation * centre)});
    }
    for (int i = 0; i < count + ties; ++i) {
      truth.push_back({20 * random.normal(), 15 * random.normal(), 4 * random.normal()});
      const bool is_tie = i >= count;
      points.push_back({is_tie ? Vector3d::Zero() : Vector3d(truth.back() + random_vector(random, sigma_m)),
                        Vector3d::Constant(is_tie ? std::numeric_limits<double>::infinity() : sigma_m)});
      for (int a = 0; a < images; ++a) {
        const Vector2d pixel = *project(camera, poses[std::size_t(a)] * truth.back());
        marks.push_back({std::size_t(a), std::size_t(i),
                         pixel + std::max(sigma_px, 0.0) * Vector2d(random.normal(), random.normal()),
                         sigma_px > 0 ? sigma_px : 1});
      }
    }
  }
  [[nodiscard]] std::vector<Rigid3> disturbed() const {
    std::vector<Rigid3> out = poses;
    for (Rigid3& pose : out) pose = Rigid3{rotation_by({0.02, -0.03, 0.05}), {1, -2, 3}} * pose;
    return out;
  }
  [[nodiscard]] Eigen::VectorXd error_of(const SpaceResection& found) const {
    Eigen::VectorXd error(6 * static_cast<Eigen::Index>(poses.size()));
    for (std::size_t a = 0; a < poses.size(); ++a)
      error.segment<6>(6 * static_cast<Eigen::Index>(a))
          << rotation_vector(found.cam_from_world[a].rotation.conjugate() * poses[a].rotation),
          centre_of(found.cam_from_world[a]) - centre_of(poses[a]);
    return error;
  }
};

TEST(SpaceResection, ExactPointsGiveTheTruth) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Scene scene(seed, 4 + int(seed % 4), 0, 0);
    const auto found = space_resection(scene.camera, scene.disturbed(), scene.marks, scene.points);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(scene.error_of(*found).norm(), 1e-6);
    EXPECT_LT(found->sigma0, 1e-6);
    EXPECT_EQ(found->redundancy, 2 * int(scene.marks.size()) - 6);
  }
}

struct Trial {
  double chi2 = 0, squares = 0, w = 0, point_w = 0;
  int inside = 0;
};

Trial trials(int seeds, int count, double sigma_m, int images, int ties, double bound) {
  Trial sum;
  for (int seed = 0; seed < seeds; ++seed) {
    const Scene scene(static_cast<std::uint64_t>(seed), count, 0.7, sigma_m, images, ties);
    const auto found = space_resection(scene.camera, scene.disturbed(), scene.marks, scene.points);
    EXPECT_TRUE(found) << found.error().message;
    if (!found) continue;
    const Eigen::VectorXd error = scene.error_of(*found);
    const double chi2 = error.dot(found->covariance.ldlt().solve(error));
    sum.chi2 += chi2 / double(error.size()) / seeds;
    sum.inside += chi2 < bound;
    sum.squares += found->sigma0 * found->sigma0 / seeds;
    for (const MarkTest& test : found->marks) sum.w += test.w.squaredNorm() / (2 * double(found->marks.size())) / seeds;
    for (int i = 0; i < count; ++i) sum.point_w += found->point_w[std::size_t(i)].squaredNorm() / (3 * count) / seeds;
    double redundancy = 0;
    for (const MarkTest& test : found->marks) redundancy += test.redundancy.sum();
    if (sigma_m == 0) EXPECT_NEAR(redundancy, found->redundancy, 1e-6);
  }
  return sum;
}

// 400 seeds: the mean of chi2/6 has a standard deviation of 0.029.
// All triples of points on a circle have one danger cylinder; stations on it, within, on its axis and outside are none
// the worse determined. Coordinates of a map: the cost stops falling where their last digits do.
TEST(SpaceResection, PointsOnACircleGiveTheTruthFromAnyStation) {
  const Camera camera = ideal_camera(4000, 4000, 3000);
  const Vector3d middle(512'345.5, 5'203'456.25, 130);
  for (const double distance : {0.0, 40.0, 100.0, 200.0, 270.0, 299.99, 300.0, 335.0, 450.0, 600.0})
    for (int turn = 0; turn < 12; ++turn) {
      const double at = 0.5 * turn;
      const Rigid3 level{cam_from_world({0.02 * turn, -0.05, at}), {0, 0, 0}};
      const Vector3d centre = middle + Vector3d(distance * std::cos(at), distance * std::sin(at), 900);
      const Rigid3 pose{level.rotation, -(level.rotation * centre)};
      std::vector<ResectionMark> marks;
      std::vector<ResectionPoint> points;
      for (std::size_t i = 0; i < 5; ++i) {
        const double angle = 1.1 * double(i) + 0.2;
        points.push_back({middle + 300 * Vector3d(std::cos(angle), std::sin(angle), 0), Vector3d::Zero()});
        marks.push_back({0, i, *project(camera, pose * points.back().in_world), 0.25});
      }
      for (const double off : {1.0, 30.0}) {
        const Vector3d aside = centre + off * Vector3d(1, -0.5, 0.7);
        const Eigen::Quaterniond turned = level.rotation * rotation_by({0.001 * off, 0.0005 * off, -0.001 * off});
        const auto found = space_resection(camera, std::array{Rigid3{turned, -(turned * aside)}}, marks, points);
        ASSERT_TRUE(found) << distance << " m, " << turn << ": " << found.error().message;
        // Rounding of map coordinates is some nanometres, 1e-8 px; the pose is 1e4 times as uncertain as a pixel there.
        EXPECT_LT((centre_of(found->cam_from_world[0]) - centre).norm(), 1e-3) << distance << " m, " << turn;
      }
    }
}

TEST(SpaceResection, CovarianceMatchesTheRealErrorsWithExactControl) {
  const Trial sum = trials(400, 8, 0, 1, 0, 12.592);
  EXPECT_NEAR(sum.chi2, 1, 0.1);
  EXPECT_NEAR(sum.squares, 1, 0.08);
  EXPECT_NEAR(sum.w, 1, 0.08);
  EXPECT_NEAR(sum.inside / 400.0, 0.95, 0.025);
}

TEST(SpaceResection, CovarianceMatchesTheRealErrorsWithErrorsOfControl) {
  const Trial sum = trials(400, 8, 0.03, 1, 0, 12.592);
  EXPECT_NEAR(sum.chi2, 1, 0.1);
  EXPECT_NEAR(sum.squares, 1, 0.08);
  EXPECT_NEAR(sum.w, 1, 0.08);
  EXPECT_NEAR(sum.point_w, 1, 0.08);
  EXPECT_NEAR(sum.inside / 400.0, 0.95, 0.025);
}

// Two images at once, with common control and tie points (Casella): 12 unknowns, correlated by what they share.
TEST(SpaceResection, CovarianceMatchesTheRealErrorsOfTwoImagesAtOnce) {
  const Trial sum = trials(300, 5, 0.03, 2, 6, 21.026);
  EXPECT_NEAR(sum.chi2, 1, 0.1);
  EXPECT_NEAR(sum.squares, 1, 0.08);
  EXPECT_NEAR(sum.w, 1, 0.08);
  EXPECT_NEAR(sum.inside / 300.0, 0.95, 0.03);
}

TEST(SpaceResection, CommonControlMakesTwoImagesMorePreciseThanOneByOne) {
  const Scene scene(3, 4, 0.7, 0.05, 2, 8);
  const auto both = space_resection(scene.camera, scene.disturbed(), scene.marks, scene.points);
  std::vector<ResectionMark> first;
  for (const ResectionMark& mark : scene.marks)
    if (mark.image == 0 && mark.point < 4) first.push_back(mark);
  const auto single = space_resection(scene.camera, std::vector<Rigid3>{scene.disturbed()[0]}, first, scene.points);
  ASSERT_TRUE(both && single);
  EXPECT_LT(both->covariance(3, 3), single->covariance(3, 3));
}

// The derivatives of the equations: by the cost of a disturbed pose against the normal matrix.
TEST(SpaceResection, NormalMatrixIsTheSecondDerivativeOfTheCost) {
  const Scene scene(5, 6, 0, 0);
  const auto found = space_resection(scene.camera, scene.disturbed(), scene.marks, scene.points);
  ASSERT_TRUE(found);
  const Eigen::MatrixXd normal = found->covariance.inverse();
  Random random(1);
  for (int k = 0; k < 20; ++k) {
    Vector6 step;
    for (int i = 0; i < 6; ++i) step[i] = random.normal() * (i < 3 ? 1e-5 : 1e-3);
    const Rigid3& pose = scene.poses[0];
    const Eigen::Quaterniond rotation = pose.rotation * rotation_by(-step.head<3>());
    const Rigid3 moved{rotation, -(rotation * (centre_of(pose) + step.tail<3>()))};
    double cost = 0;
    for (const ResectionMark& mark : scene.marks)
      cost += (*project(scene.camera, moved * scene.truth[mark.point]) - mark.pixel).squaredNorm();
    EXPECT_NEAR(cost / step.dot(normal * step), 1, 1e-2);
  }
}

TEST(PoseStarts, ThreePointsGiveAllSolutionsAndOneIsTrue) {
  int several = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Scene scene(seed, 3, 0, 0);
    std::vector<Vector2d> pixels;
    for (const ResectionMark& mark : scene.marks) pixels.push_back(mark.pixel);
    const auto starts = pose_starts(scene.camera, pixels, scene.truth, 1);
    ASSERT_FALSE(starts.empty());
    several += starts.size() > 1;
    double nearest = 1e9;
    for (const PoseStart& start : starts)
      nearest = std::min(nearest, (centre_of(start.cam_from_world) - centre_of(scene.poses[0])).norm());
    EXPECT_LT(nearest, 1e-3);
  }
  EXPECT_GT(several, 10);
}

// Mussio D.8 counts C(20, 6) minimal systems for ten points; three points at a time are 120 of them.
TEST(PoseStarts, LeastMedianStandsWrongPoints) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Scene scene(seed, 10, 0.5, 0);
    std::vector<Vector2d> pixels;
    for (const ResectionMark& mark : scene.marks) pixels.push_back(mark.pixel);
    for (const int wrong : {1, 4, 6}) pixels[std::size_t(wrong)] += Vector2d(150, -80 * wrong);
    const auto starts = pose_starts(scene.camera, pixels, scene.truth, 1);
    ASSERT_FALSE(starts.empty());
    EXPECT_LT((centre_of(starts[0].cam_from_world) - centre_of(scene.poses[0])).norm(), 1.5);
    EXPECT_LT(starts[0].scale_px, 5);
  }
}

// Poses are left before all of their errors are known: those that stay have the scale that all errors give, best first,
// and more triples, of which the first ones are the same, find none that is worse. Rounding of some thousand pixels is
// 1e-11 of errors of half a pixel.
TEST(PoseStarts, AreTheBestOfAllTriples) {
  constexpr int kPoints = 300;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Scene scene(seed, kPoints, 0.5, 0);
    std::vector<Vector2d> pixels;
    for (const ResectionMark& mark : scene.marks) pixels.push_back(mark.pixel);
    Random random(seed);
    for (int k = 0; k < 90; ++k)
      pixels[random.below(kPoints)] += Vector2d(random.uniform(-300, 300), random.uniform(-300, 300));
    std::vector<std::vector<double>> scales;
    for (const std::size_t most : {10, 100, 500}) {
      auto& found = scales.emplace_back();
      for (const PoseStart& start : pose_starts(scene.camera, pixels, scene.truth, 1, most)) {
        std::vector<double> errors;
        for (int i = 0; i < kPoints; ++i) {
          const auto seen = project(scene.camera, start.cam_from_world * scene.truth[std::size_t(i)]);
          errors.push_back(seen ? (*seen - pixels[std::size_t(i)]).norm() : 1e9);
        }
        std::sort(errors.begin(), errors.end());
        EXPECT_NEAR(start.scale_px, 0.8493 * (1 + 5.0 / (kPoints - 3)) * errors[kPoints / 2 + 1],
                    1e-9 * start.scale_px);
        found.push_back(start.scale_px);
      }
      ASSERT_EQ(found.size(), std::size_t{4});
      EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
    }
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LE(scales[1][k], scales[0][k]);
      EXPECT_LE(scales[2][k], scales[1][k]);
    }
  }
}

// Three points and a centre on the right cylinder over their circle leave the pose open; near it the ratio falls.
TEST(DangerCylinder, IsNamedByConditioningAndDistance) {
  const Camera camera = ideal_camera(4000, 4000, 3000);
  std::vector<ResectionPoint> points;
  std::vector<Vector3d> positions;
  for (const double angle : {0.3, 2.2, 4.4}) {
    positions.push_back({30 * std::cos(angle), 30 * std::sin(angle), 0});
    points.push_back({positions.back(), Vector3d::Zero()});
  }
  double before = 0;
  for (const double off : {0.0, 0.3, 3.0, 15.0}) {
    const Vector3d centre(30 + off, 0, 100);
    Eigen::Matrix3d rows;
    rows << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    const Eigen::Quaterniond rotation(rows);
    const Rigid3 pose{rotation, -(rotation * centre)};
    std::vector<ResectionMark> marks;
    for (std::size_t i = 0; i < 3; ++i) marks.push_back({0, i, *project(camera, pose * positions[i]), 1});
    const auto cylinder = danger_cylinder(positions, centre);
    ASSERT_TRUE(cylinder);
    EXPECT_NEAR(cylinder->centre_off_m, off, 1e-9);
    EXPECT_NEAR(cylinder->radius_m, 30, 1e-9);
    const auto found = space_resection(camera, std::vector<Rigid3>{pose}, marks, points);
    EXPECT_EQ(bool(found), off > 0);
    if (!found) continue;
    EXPECT_GT(found->conditioning[0].ratio, before);
    before = found->conditioning[0].ratio;
  }
}

TEST(SpaceResection, TooLittleIsRefused) {
  Scene scene(1, 2, 0, 0);
  EXPECT_FALSE(space_resection(scene.camera, scene.poses, scene.marks, scene.points));
  Scene line(1, 6, 0, 0);
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    line.points[i].in_world = Vector3d(3 * double(i), double(i), 0);
    line.marks[i].pixel = *project(line.camera, line.poses[0] * line.points[i].in_world);
  }
  EXPECT_FALSE(space_resection(line.camera, line.poses, line.marks, line.points));
  Scene ties(1, 0, 0, 0, 2, 12);  // a pair without control has no datum
  EXPECT_FALSE(space_resection(ties.camera, ties.poses, ties.marks, ties.points));
  EXPECT_TRUE(pose_starts(scene.camera, {}, {}, 1).empty());
}

}  // namespace
}  // namespace collinea
