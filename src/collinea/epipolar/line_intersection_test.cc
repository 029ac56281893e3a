// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/line_intersection.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Segment {
  Vector3d from, to;
  [[nodiscard]] Vector3d direction() const { return (to - from).normalized(); }
};

// Cameras side by side that look roughly along z.
Rigid3 camera(double x, double y = 0) {
  const Eigen::Quaterniond rotation = rotation_by({0.05 * y, -0.1 * x, 0.03});
  return {rotation, -(rotation * Vector3d(x, y, 0))};
}

Vector2d seen(const Rigid3& cam, const Vector3d& point) { return (cam * point).hnormalized(); }

// The image of a segment with errors of theta and r: `sigma` at both of its ends.
ImageLine image_of(const Segment& segment, const Rigid3& cam, double sigma, Random* random = nullptr) {
  const Vector2d a = seen(cam, segment.from), b = seen(cam, segment.to), along = (b - a).normalized();
  ImageLine line{.cam_from_world = cam};
  const Vector2d normal(along.y(), -along.x());
  line.theta_rad = std::atan2(normal.y(), normal.x());
  line.r = normal.dot(a);
  line.middle = (a + b) / 2;
  Matrix2d by;
  by << along.dot(a), -1, along.dot(b), -1;
  const Matrix2d root = sigma * by.inverse();
  line.covariance = root * root.transpose();
  if (random) {
    const double first = random->normal(), second = random->normal();
    const Vector2d error = root * Vector2d(first, second);
    line.theta_rad += error[0];
    line.r += error[1];
  }
  return line;
}

// Estimate less truth in the parameters of the covariance.
Vector4d error_of(const SpaceLine& line, const Segment& truth) {
  Vector3d d = truth.direction();
  if (d.dot(line.direction) < 0) d = -d;
  const Vector3d at = truth.from + d * (line.point - truth.from).dot(line.direction) / d.dot(line.direction);
  Vector4d error;
  error << line.across.transpose() * (line.point - at), line.across.transpose() * (-d / d.dot(line.direction));
  return error;
}

Segment random_segment(Random& random) {
  const Vector3d from(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(4, 7));
  const double angle = random.uniform(0.4, 2.7);
  return {from, from + Vector3d(std::cos(angle), std::sin(angle), random.uniform(-0.7, 0.7))};
}

TEST(LineIntersection, ExactImagesGiveTheLine) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Segment truth = random_segment(random);
    for (const int count : {2, 3}) {
      std::vector<ImageLine> lines;
      for (const double x : {0.0, 1.0, 0.4})
        if (int(lines.size()) < count) lines.push_back(image_of(truth, camera(x, x == 0.4 ? 0.8 : 0), 1e-4));
      const auto found = intersect_lines(lines);
      ASSERT_TRUE(found);
      EXPECT_LT(found->direction.cross(truth.direction()).norm(), 1e-9);
      EXPECT_LT((found->point - truth.from).cross(truth.direction()).norm(), 1e-9);
      EXPECT_EQ(found->redundancy, 2 * count - 4);
      EXPECT_NEAR(found->squares, 0, 1e-12);
      // The ends come back by their rays.
      const double at = found->nearest_to(lines[0].cam_from_world, seen(lines[0].cam_from_world, truth.from));
      EXPECT_LT((found->at(at) - truth.from).norm(), 1e-9);
    }
  }
}

// e' C^-1 e is chi-squared with four degrees of freedom: its mean over n trials is 4 with standard deviation
// sqrt(8 / n). v' P v of three images has two: sqrt(4 / n).
void expect_true_covariances(int count, double sigma_rad, double sigma_m) {
  constexpr int kTrials = 1500;
  Random random(7, static_cast<std::uint64_t>(count));
  double sum = 0, squares = 0, at_end = 0;
  int trials = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Segment truth = random_segment(random);
    std::vector<ImageLine> lines;
    for (int k = 0; k < count; ++k) {
      const Rigid3 cam = camera(0.8 * k, k == 2 ? 0.9 : 0.1 * k);
      ImageLine line = image_of(truth, cam, 2e-4, &random);
      Vector6 error;
      for (int m = 0; m < 6; ++m) error[m] = (m < 3 ? sigma_rad : sigma_m) * random.normal();
      // The pose as it is believed: turned about the axes of the world and shifted.
      line.cam_from_world.rotation = cam.rotation * rotation_by(-error.head<3>());
      line.cam_from_world.translation = -(line.cam_from_world.rotation * (centre_of(cam) + error.tail<3>()));
      line.pose_covariance.diagonal() << Vector3d::Constant(sigma_rad * sigma_rad),
          Vector3d::Constant(sigma_m * sigma_m);
      lines.push_back(line);
    }
    const auto found = intersect_lines(lines);
    if (!found) continue;
    ++trials;
    const Vector4d error = error_of(*found, truth);
    sum += error.dot(found->covariance.ldlt().solve(error));
    squares += found->squares;
    const Vector2d off = error.head<2>() + 0.5 * error.tail<2>();
    at_end += off.dot(found->covariance_at(0.5).ldlt().solve(off));
  }
  EXPECT_GT(trials, kTrials * 0.97);
  EXPECT_NEAR(sum / trials, 4, 4 * std::sqrt(8.0 / trials));
  EXPECT_NEAR(at_end / trials, 2, 4 * std::sqrt(4.0 / trials));
  const double redundancy = 2 * count - 4;
  EXPECT_NEAR(squares / trials, redundancy, 4 * std::sqrt(2 * redundancy / trials) + 1e-9);
}

TEST(LineIntersection, CovarianceOfTwoImagesMatchesTheRealErrors) { expect_true_covariances(2, 0, 0); }
TEST(LineIntersection, CovarianceOfThreeImagesMatchesTheRealErrors) { expect_true_covariances(3, 0, 0); }
TEST(LineIntersection, ErrorsOfOrientationsCountAsWhatTheyAre) { expect_true_covariances(3, 2e-4, 1e-3); }

// A line in an epipolar plane is seen in one plane of rays by both images; near it the covariance grows, and then there
// is none.
TEST(LineIntersection, ALineInAnEpipolarPlaneHasNone) {
  const Rigid3 left, right{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  double before = 0;
  for (const double degrees : {60.0, 20.0, 5.0, 0.05, 0.0}) {
    const double angle = degrees * M_PI / 180;
    const Segment segment{{-0.5, 0.3, 5}, Vector3d(-0.5, 0.3, 5) + Vector3d(std::cos(angle), std::sin(angle), 0)};
    const std::vector<ImageLine> lines = {image_of(segment, left, 1e-4), image_of(segment, right, 1e-4)};
    const auto found = intersect_lines(lines);
    EXPECT_EQ(found.has_value(), degrees > 1) << degrees;
    if (!found) continue;
    const double sigma = std::sqrt(found->covariance_at(0).trace());
    EXPECT_GT(sigma, before);
    before = sigma;
    EXPECT_GT(found->angle_rad, 5 * found->angle_sigma_rad);
  }
}

TEST(LineIntersection, WhatCannotBeMetIsNone) {
  const Segment segment{{0, -0.5, 5}, {0.2, 0.5, 5}};
  const ImageLine one = image_of(segment, camera(0), 1e-4);
  EXPECT_FALSE(intersect_lines(std::vector{one}));
  EXPECT_FALSE(intersect_lines(std::vector{one, one}));  // the same position
  // Disparity of the wrong sign: behind the cameras.
  const Segment behind{{0, -0.5, -5}, {0.2, 0.5, -5}};
  EXPECT_FALSE(intersect_lines(std::vector{image_of(behind, camera(0), 1e-4), image_of(behind, camera(1), 1e-4)}));
}

TEST(LineIntersection, PixelsAreThoseOfTheirCamera) {
  const Vector2d a(310.5, 120.25), b(400, 500), along = (b - a).normalized(), normal(along.y(), -along.x());
  const double focal = 800;
  const Vector2d centre(320, 240);
  const Matrix2d covariance{{1e-6, 2e-5}, {2e-5, 4e-3}};
  const ImageLine line =
      image_line({}, focal, centre, {std::atan2(normal.y(), normal.x()), normal.dot(a), covariance, (a + b) / 2});
  for (const Vector2d& p : {a, b}) {
    const Vector2d xy = (p - centre) / focal;
    EXPECT_NEAR(xy.x() * std::cos(line.theta_rad) + xy.y() * std::sin(line.theta_rad), line.r, 1e-12);
    // The variance of the distance of a point is the same one, in other units.
    const Vector2d by_px(along.dot(p), -1), by(along.dot(xy), -1);
    EXPECT_NEAR(by.dot(line.covariance * by) * focal * focal / by_px.dot(covariance * by_px), 1, 1e-9);
  }
}

}  // namespace
}  // namespace collinea
