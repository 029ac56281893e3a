// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/multi_image_matching.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/match/internal/test_textures.h"
#include "collinea/match/internal/window_equations.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPixel_m = 0.02;  // of the texture, about that of the images
constexpr int kImage_px = 240;

// A painted plane that leans, seen by cameras around it.
class PaintedPlane {
 public:
  using Paint = std::function<double(const Vector2d&)>;

  PaintedPlane(std::size_t cameras, const Paint& paint, double noise_grey, std::uint64_t seed, double base_m = 16)
      : camera_(ideal_camera(2000, kImage_px, kImage_px)) {
    camera_.params[Camera::kK1] = -0.05;
    for (std::size_t i = 0; i < cameras; ++i) {
      const double angle = 2.1 * double(i);
      const Vector3d centre(i == 0 ? 0.3 : base_m * std::cos(angle), i == 0 ? 0.2 : base_m * std::sin(angle), 40);
      const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI, Vector3d::UnitX()));  // z down, x east
      const Vector3d axis = -centre.normalized();
      const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d(0, 0, -1), axis);
      Rigid3 pose;
      pose.rotation = (turn * Eigen::AngleAxisd(0.15 * double(i), Vector3d::UnitZ()) * down).conjugate().normalized();
      pose.translation = -(pose.rotation * centre);
      poses_.push_back(pose);
    }
    for (std::size_t i = 0; i < cameras; ++i)
      images_.push_back(testing::image_of(
          kImage_px, kImage_px,
          [&](const Vector2d& pixel) {
            const double light = i == 0 ? 1 : 0.85;
            return light * paint(shown(i, pixel).head<2>() / kPixel_m) + 10.0 * double(i);
          },
          noise_grey, seed * 100 + i));
    for (std::size_t i = 0; i < cameras; ++i) views_.push_back({&images_[i], &camera_, poses_[i]});
  }
  [[nodiscard]] Vector3d shown(std::size_t i, const Vector2d& pixel) const {
    const Vector3d centre = centre_of(poses_[i]);
    const Vector3d direction = poses_[i].rotation.conjugate() * ray_in_cam(camera_, pixel);
    return centre - direction * (normal_.dot(centre) / normal_.dot(direction));
  }
  [[nodiscard]] Vector3d along(const Vector2d& pixel) const {
    return poses_[0].rotation.conjugate() * ray_in_cam(camera_, pixel);
  }
  [[nodiscard]] std::vector<OrientedView>& views() { return views_; }
  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  Camera camera_;
  Vector3d normal_ = Vector3d(0.2, -0.1, 1).normalized();
  std::vector<Rigid3> poses_;
  std::vector<GreyImage> images_;
  std::vector<OrientedView> views_;
};

std::vector<Vector2d> grid_of_points() {
  std::vector<Vector2d> out;
  for (double y = 60; y < 185; y += 24.3)
    for (double x = 60; x < 185; x += 24.3) out.emplace_back(x, y);
  return out;
}

TEST(MultiImageMatching, FindsExactPointsFromAStartTwoPixelsAway) {
  PaintedPlane scene(4, testing::WaveTexture(3, 8, 24), 0, 1);
  for (const Vector2d& pixel : grid_of_points()) {
    const Vector3d truth = scene.shown(0, pixel);
    const auto found = match_in_images(scene.views(), 0, pixel, truth + 0.09 * scene.along(pixel), {});
    ASSERT_EQ(found.outcome, MultiImageOutcome::kFound);
    EXPECT_LT((found.point_in_world - truth).norm(), 0.01 * kPixel_m / 0.4);  // grey values are whole numbers
    for (std::size_t i = 1; i < 4; ++i) {
      ASSERT_TRUE(found.views[i].is_used);
      EXPECT_NEAR(found.views[i].gain, 0.85, 0.02);
      EXPECT_GT(found.views[i].correlation, 0.99);
    }
    EXPECT_EQ(found.redundancy, 5);
  }
}

// The derivatives of the residuals by the unknowns of a window against numeric ones.
TEST(MultiImageMatching, DerivativesAreThoseOfTheResiduals) {
  const testing::WaveTexture texture(5, 10, 30);
  const GreyImage image = testing::image_of(80, 80, texture);
  const auto reference = ReferenceTemplate::of(image, {40.3, 39.8}, 15);
  ASSERT_TRUE(reference);
  WindowState state{{40.6, 39.5}, Matrix2d::Identity(), 0.9, 120};
  state.map << 1.05, 0.06, -0.04, 0.97;
  const auto at = window_equations(*reference, image, state, {state.map, 0});
  ASSERT_TRUE(at);
  // d(-Z'W r)/dx with Z fixed is -Z'W A: by central differences of r, weighted with the columns at `state`.
  for (int k = 0; k < kWindowUnknowns; ++k) {
    WindowVector slope = WindowVector::Zero();
    constexpr double kStep = 1e-4;
    for (const int sign : {-1, 1}) {
      WindowState moved = state;
      double* const unknowns[] = {&moved.pixel.x(), &moved.pixel.y(), &moved.map(0, 0), &moved.map(0, 1),
                                  &moved.map(1, 0), &moved.map(1, 1), &moved.gain,      &moved.offset_grey};
      *unknowns[k] += sign * kStep;
      const auto there = window_equations(*reference, image, moved, {state.map, 0});
      ASSERT_TRUE(there);
      for (std::size_t p = 0; p < there->samples.size(); ++p)
        slope += sign * (there->samples[p].grey - moved.gain * reference->points[p].sample.grey - moved.offset_grey) /
                 (2 * kStep) * at->by_point[p];
    }
    for (int row = 0; row < kWindowUnknowns; ++row)
      EXPECT_NEAR(slope[row], at->matrix(row, k), 1e-4 * at->matrix.cwiseAbs().maxCoeff()) << row << ' ' << k;
  }
}

// (error along the ray / sigma)^2 is chi-squared with one degree of freedom; so is the test of the rays with 2 k - 1.
class Truthful : public ::testing::TestWithParam<std::size_t> {};
TEST_P(Truthful, CovarianceAndTestMatchTheRealErrors) {
  double sum = 0, statistics = 0, inside = 0;
  int count = 0, tried = 0, redundancy = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    PaintedPlane scene(GetParam(), testing::WaveTexture(seed, 7, 24), 4, seed);
    for (const Vector2d& pixel : grid_of_points()) {
      const Vector3d truth = scene.shown(0, pixel), direction = scene.along(pixel);
      const auto found = match_in_images(scene.views(), 0, pixel, truth + 0.03 * direction, {});
      ++tried;
      if (found.outcome == MultiImageOutcome::kNoTexture) continue;
      ASSERT_EQ(found.outcome, MultiImageOutcome::kFound);
      const double error = direction.dot(found.point_in_world - truth),
                   variance = direction.dot(found.covariance * direction);
      sum += error * error / variance;
      inside += error * error < 3.841 * variance;
      statistics += found.statistic;
      EXPECT_NEAR(found.noise_grey, 4, 1.2);
      redundancy = found.redundancy;
      ++count;
      EXPECT_LT((found.point_in_world - truth - error * direction).norm(), 1e-3 * kPixel_m);
    }
  }
  RecordProperty("ratio_within_test", std::to_string(std::sqrt(sum / count)) + " " + std::to_string(inside / count) +
                                          " " + std::to_string(statistics / count / redundancy));
  EXPECT_GT(count, 0.98 * tried);
  EXPECT_EQ(redundancy, 2 * int(GetParam() - 1) - 1);
  EXPECT_NEAR(std::sqrt(sum / count), 1, 0.1) << count;
  EXPECT_GT(inside / count, 0.93);
  EXPECT_LT(inside / count, 0.97);
  EXPECT_LT(statistics / count / redundancy, 1.1);
  EXPECT_GT(statistics / count / redundancy, 0.7);  // slow noise is never taken as less than white: below 1
}
INSTANTIATE_TEST_SUITE_P(MultiImageMatching, Truthful, ::testing::Values(2, 3, 5));

TEST(MultiImageMatching, MoreImagesAreBetter) {
  double variances[2] = {0, 0};
  for (const std::size_t cameras : {2u, 5u}) {
    PaintedPlane scene(cameras, testing::WaveTexture(7, 7, 24), 4, 3);
    for (const Vector2d& pixel : grid_of_points()) {
      const auto found = match_in_images(scene.views(), 0, pixel, scene.shown(0, pixel), {});
      ASSERT_EQ(found.outcome, MultiImageOutcome::kFound);
      variances[cameras > 2] += found.covariance.trace();
    }
  }
  EXPECT_LT(variances[1], variances[0] / 1.5);
}

TEST(MultiImageMatching, RaysThatMissByTheirSigmaAreNotForcedTogether) {
  PaintedPlane scene(3, testing::WaveTexture(9, 8, 24), 2, 4);
  const Vector2d pixel(118.7, 121.3);
  const Vector3d truth = scene.shown(0, pixel);
  // By half a pixel across the epipolar line of the first image.
  scene.views()[1].cam_from_world =
      Rigid3{rotation_by(Vector3d(0, 0.5 / 2000, 0)), {0, 0, 0}} * scene.views()[1].cam_from_world;
  const auto exact = match_in_images(scene.views(), 0, pixel, truth, {});
  ASSERT_EQ(exact.outcome, MultiImageOutcome::kFound);
  EXPECT_GT(exact.statistic, 30);  // the test notices
  MultiImageOptions loose;
  loose.ray_sigma_px = 0.5;
  const auto free = match_in_images(scene.views(), 0, pixel, truth, loose);
  ASSERT_EQ(free.outcome, MultiImageOutcome::kFound);
  EXPECT_LT(free.statistic, 11.3);  // 1 % of three degrees of freedom
  EXPECT_LT((free.point_in_world - truth).norm(), 3.5 * std::sqrt(free.covariance.trace()));
}

TEST(MultiImageMatching, DegenerateInputIsNamed) {
  PaintedPlane scene(3, testing::WaveTexture(9), 1, 4);
  const Vector2d pixel(120, 120);
  const Vector3d truth = scene.shown(0, pixel);
  EXPECT_EQ(match_in_images(scene.views(), 0, {5, 120}, truth, {}).outcome, MultiImageOutcome::kOutside);
  EXPECT_EQ(match_in_images(scene.views(), 0, {NAN, 120}, truth, {}).outcome, MultiImageOutcome::kOutside);
  EXPECT_EQ(match_in_images(std::span(scene.views()).first(1), 0, pixel, truth, {}).outcome,
            MultiImageOutcome::kFewViews);
  std::vector<OrientedView> same(2, scene.views()[0]);
  EXPECT_EQ(match_in_images(same, 0, pixel, truth, {}).outcome, MultiImageOutcome::kParallel);
  PaintedPlane blank(
      3, [](const Vector2d&) { return 100.0; }, 0, 4);
  EXPECT_EQ(match_in_images(blank.views(), 0, pixel, truth, {}).outcome, MultiImageOutcome::kNoTexture);
  // Another texture in one of the images: it is left out.
  PaintedPlane other(3, testing::WaveTexture(10), 1, 4);
  scene.views()[2].image = other.views()[2].image;
  const auto found = match_in_images(scene.views(), 0, pixel, truth, {});
  ASSERT_EQ(found.outcome, MultiImageOutcome::kFound);
  EXPECT_TRUE(found.views[1].is_used);
  EXPECT_FALSE(found.views[2].is_used);
}

// An edge along the epipolar line of one base fixes nothing; another base does.
TEST(MultiImageMatching, EdgesNeedABaseAcross) {
  const auto edge = [](const Vector2d& at) { return 120 + 60 * std::tanh((at.y() - 0.02 * at.x()) / 3); };
  PaintedPlane scene(3, edge, 1, 4);
  Vector2d pixel(120, 120);
  double best = 1e9;
  for (double y = 90; y < 150; y += 0.5)  // on the edge
    if (const Vector2d p = scene.shown(0, {120, y}).head<2>() / kPixel_m; std::abs(p.y() - 0.02 * p.x()) < best) {
      best = std::abs(p.y() - 0.02 * p.x());
      pixel = {120, y};
    }
  const Vector3d truth = scene.shown(0, pixel);
  const auto found = match_in_images(scene.views(), 0, pixel, truth, {});
  ASSERT_EQ(found.outcome, MultiImageOutcome::kFound);
  EXPECT_LT((found.point_in_world - truth).norm(), 4 * std::sqrt(found.covariance.trace()));
}

}  // namespace
}  // namespace collinea
